"""2-D keypoints of a body's video: of which frames they are, how good, and which nobody saw.

| file | what |
|---|---|
| `load` | `[[camera]] keypoints` in the pixels and frames of that camera |
| `frames` | of which frames they are: by number, by time, else one by one |
| `spreads` | how far they are spread, which the data show; which are guesses |
| `filled`, `stuck` | which were held, filled in or stuck |
"""
