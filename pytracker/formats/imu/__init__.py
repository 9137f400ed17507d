"""IMU files: a reader a format, all to one kind of log (`pytracker.inertial`), and `read`, which tells them apart.

| file | what |
|---|---|
| `read` | any of them, told apart by content; what every log must pass |
| `table` | a CSV whose columns are named, or mapped |
| `names`, `clock`, `dates` | what columns are called, their units; the unit of times that do not say it; dates |
| `counter` | a column that counts samples, and what it shows to be lost |
| `stream` | one sensor of several that tick on their own |
| `phone`, `core_motion` | Sensor Logger's and phyphox's folders; Apple's motion in one file |
| `ximu3` | x-io's folders |
| `apdm` | APDM's HDF5 |
| `mvnx`, `mt9_log`, `mt_manager` | Xsens: MVN's XML, the MT9's log, MT Manager's and DOT's text |
"""
