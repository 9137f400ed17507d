"""A detector's 2-D keypoints of people: whose they are, which side, and of which frame.

| file | what |
|---|---|
| `keypoints` | those of a frame, where there is no picture |
| `detector` | a detector of our own |
| `subject` | which of several people is followed |
| `followed` | left and right as that person has them |
| `late` | whether they are of the frames that they are given for |
"""
