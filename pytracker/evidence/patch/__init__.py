"""An arm's colour patch in a video: found, followed, and whether it moves as the sensor does.

| file | what |
|---|---|
| `colour` | what in a picture is of its colour |
| `camshift` | followed frame by frame, knowing when it is lost |
| `standing` | what of its colour stands where it is |
| `beside` | what else of it goes about |
| `candidates` | coloured things that move: one of them is the patch |
| `landmarks` | shoulder and elbow, by further patches or keypoints |
| `lag`, `clocks`, `hanging` | whether it moves as the sensor does: later, slower, or not at all |
| `stepped` | whether it does so later from some time on |
"""
