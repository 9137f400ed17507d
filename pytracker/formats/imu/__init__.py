"""IMU files: a reader a format, all to one kind of log (`pytracker.inertial`), and `read`, which tells them apart."""
