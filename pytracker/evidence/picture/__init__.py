"""A body in a picture: what is the person, where skin is, and where edges are.

| file | what |
|---|---|
| `silhouette`, `skin`, `thresholds` | foreground, edges and skin of a frame |
| `smaller` | pictures that are larger than need be |
| `background`, `left_behind` | the scene without the person; what stays where a hand was |
| `complexion` | what the light does to skin |
| `frozen` | pictures that hung |
| `largest` | who is largest in a frame, before anything is known of where they are |
"""
