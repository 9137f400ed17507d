"""Files of 2-D keypoints: a reader a format, all to one kind of log, and `read`, which tells them apart."""
