"""Whether frames bear out a pose that is tracked, and what of it they cannot tell.

| file | what |
|---|---|
| `borne_out`, `points_borne_out` | hands and forearms where skin is, or where keypoints are |
| `ambiguity` | how far off wrists may be for all that skin says |
| `cut_off` | hands that something hides |
| `trunk`, `stature`, `facing` | whether who is seen is as large, as tall, and turned as is tracked |
| `pieces` | the person, and what else stands there |
| `stands_apart` | whether a thing of skin's colour that came may draw an arm |
| `stands_out` | whether the person differs from the background |
| `lately` | what was so over the last moments |
"""
