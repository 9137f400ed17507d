"""`SilhouetteParameters`: every threshold from pictures to a body's foreground, edges and skin."""

from __future__ import annotations

from dataclasses import dataclass

__all__ = ["SilhouetteParameters"]


@dataclass(frozen=True, kw_only=True)
class SilhouetteParameters:
    """Every threshold. Areas are in square metres at the person, so that they hold for any camera.

    Attributes:
        gains: of blue, green and red, before anything else is done: of a camera that took another light for white, and
            where it is dim (`complexion`).
        colour: whether the background is subtracted in colour (largest channel) or in grey (paper Fig. 3).
        foreground_level: difference from the background, of 255, from which a pixel is foreground.
        region_chroma: difference of Cr or Cb, of 255, from which a pixel may belong to the region of skin: arms before
            a wall as bright as they are differ in colour alone, which has a fraction of brightness's noise. Edges,
            blobs and the foreground are the paper's.
        shadow_darkest: a shadow keeps at least this share of the background's brightness.
        shadow_chroma: and its Cr and Cb differ by less than this, of 255. 0: no shadow is taken off.
        open_px: foreground that is narrower is noise, px.
        least_area_m2: smaller pieces of foreground are noise, m².
        canny_low: lower threshold of Canny, of the gradient.
        canny_high: upper threshold, likewise.
        dilate_px: edges are widened to this many px.
        skin_cr: range of Cr of skin, of 255.
        skin_cb: range of Cb.
        skin_reddest: most redness of skin, (Cr - 128) / Y: unlike Cr itself it stays as it is in the shade, and tells
            red and orange clothes from skin of any tone.
        skin_darkest: least Y of skin, of 255.
        skin_area_m2: least and largest area of a blob, m².
        skin_growth_m: skin is taken so far beyond the foreground, m, and gaps so wide in it are closed.
        skin_elongation: longer side over shorter side, at most.
        bare_arm_m: a blob that is longer than this, m, and at least `bare_arm_elongation` times as long as wide, is a
            hand with a bare forearm: both its ends may be the hand.
        bare_arm_elongation: see there.
        hand_m: length of a hand, m.
    """

    gains: tuple[float, float, float] = (1.0, 1.0, 1.0)
    colour: bool = True
    foreground_level: int = 26
    region_chroma: int = 12
    shadow_darkest: float = 0.5
    shadow_chroma: int = 3
    open_px: int = 3
    least_area_m2: float = 0.003
    canny_low: int = 50
    canny_high: int = 120
    dilate_px: int = 3
    skin_cr: tuple[int, int] = (135, 166)
    skin_cb: tuple[int, int] = (95, 126)
    skin_reddest: float = 0.35
    skin_darkest: int = 50
    skin_area_m2: tuple[float, float] = (0.0012, 0.06)
    skin_growth_m: float = 0.05
    skin_elongation: float = 7.0
    bare_arm_m: float = 0.26
    bare_arm_elongation: float = 2.2
    hand_m: float = 0.18
