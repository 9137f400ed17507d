"""What was measured besides: joints of an arm or a body, checked, in the recording's world.

| file | what |
|---|---|
| `points` | any file of markers, each joint one of them or the middle of several |
| `names` | points that are called like joints |
| `arm`, `body` | checked against an arm's lengths, or a skeleton's and the first pose |
| `filled`, `strays` | rows that nobody measured |
"""
