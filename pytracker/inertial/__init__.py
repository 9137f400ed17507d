"""What every IMU log must pass, whatever file it came from, and what it tells of itself.

| file | what |
|---|---|
| `log` | one kind of log for every file |
| `check` | all that it must pass |
| `conventions` | units, order and direction of the quaternion, earth frame: turned into ours |
| `gravity`, `agreement` | whether acceleration, turn rate and orientation agree |
| `noise` | a sensor that hangs, or is disturbed |
| `bursts`, `whole_seconds` | times at which samples arrived, or that are cut off: put back |
| `outliers`, `filled`, `interleaved`, `saturation` | samples that no sensor gave, or several, or one at its end |
| `bias`, `orientation` | a gyroscope's bias; an orientation where there is none |
"""
