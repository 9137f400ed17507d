"""Something of the patch's colour that stands on its way: a mug on the table."""

from __future__ import annotations

import numpy as np
import pytest

from pytracker.evidence import PatchTracker
from pytracker.evidence.patch.beside import Beside
from pytracker.evidence.patch.camshift import TOGETHER
from pytracker.evidence.patch.colour import Piece
from pytracker.evidence.patch.standing import Standing
from pytracker.formats.video import Image

BLUE = (190, 60, 30)
MUG = (150, 100)
HALF = 10


def picture(patch: tuple[float, float], things: list[tuple[int, int]], half: int = HALF, frame: int = 0) -> Image:
    """A wall, things and before them a patch about its pixel (u, v), with the noise of a camera."""
    noise = np.random.default_rng(round(1000 * patch[0] + patch[1]) + frame).normal(0, 4, (200, 320, 3))
    image = np.full((200, 320, 3), (150, 160, 165), dtype=np.float64)
    for u, v in [*things, (round(patch[0]), round(patch[1]))]:
        image[max(0, v - half) : v + half + 1, max(0, u - half) : u + half + 1] = BLUE
    return np.asarray(np.clip(image + noise, 0, 255), dtype=np.uint8)


def way(count: int) -> np.ndarray:
    """To and fro over the mug, stopping half beside it."""
    k = np.arange(count)
    u = 150 + 90 * np.sin(0.05 * k)
    return np.column_stack([np.where((k > 120) & (k < 150), 162.0, u), np.full(count, 104.0)])


@pytest.mark.parametrize("half", [10, 22])
def test_a_patch_that_passes_a_mug_of_its_colour_is_followed(half: int) -> None:
    path = way(400)
    path[:, 1] = MUG[1] + 0.4 * half
    first = picture((240.0, path[0, 1]), [MUG], half)
    tracker = PatchTracker(first, (240 - half, round(path[0, 1]) - half, 2 * half + 1, 2 * half + 1))
    off, seen, why = [], 0, set()
    for u, v in np.concatenate([np.linspace((240, path[0, 1]), path[31], 31), path[31:]]):
        found = tracker.update(picture((u, v), [MUG], half))
        if found.valid:
            seen += 1
            off.append(np.hypot(found.pixel[0] - round(u), found.pixel[1] - round(v)))
        else:
            why.add(found.reason)
    assert max(off) < 3.0
    assert seen > 0.5 * len(path)
    assert TOGETHER in why


def test_a_mug_that_is_put_there_is_learned_and_one_that_leaves_forgotten() -> None:
    box = (20, 20, 20, 20)
    empty, there = np.zeros((100, 100), np.uint8), np.zeros((100, 100), np.uint8)
    there[60:70, 60:80] = 255
    standing = Standing(empty, box, 1)
    back = there.copy()
    assert standing.without(back) is back
    for _ in range(30):
        standing.learn(there, box)
    assert not standing.without(back).any()
    assert standing.is_at(np.array([70.0, 65.0]))
    assert not standing.is_at(np.array([65.0, 80.0]))
    assert standing.is_covered((55, 60, 20, 10))
    assert not standing.is_covered(box)
    # A part of a picture that begins elsewhere.
    assert not standing.without(back[50:75, 50:85], (50, 50)).any()
    # An arm may lie before it for seconds.
    for _ in range(150):
        standing.learn(empty, box)
    assert not standing.without(back).any()
    for _ in range(250):
        standing.learn(empty, box)
    assert standing.without(back) is back


def test_a_patch_that_rests_is_no_mug() -> None:
    path = [(100.0 + 2 * k, 60.0) for k in range(30)] + [(158.0, 60.0)] * 150 + [(158.0 + k, 60.0) for k in range(40)]
    tracker = PatchTracker(picture(path[0], []), (90, 50, 21, 21))
    for frame, place in enumerate(path[1:]):
        found = tracker.update(picture(place, [], frame=frame))
        assert found.valid, found.reason
        assert np.hypot(found.pixel[0] - round(place[0]), found.pixel[1] - place[1]) < 1.5


def test_a_mug_close_by_in_the_first_frame_is_no_part_of_the_patch() -> None:
    """Camshift began on both, 16 px beside the patch, and stayed so: 14 cm off, valid."""
    at, mug = np.array([120.0, 100.0]), (143, 108)
    path = [at + np.array([0.0, -0.5 * k]) for k in range(60)] + [at + np.array([-k, -30.0]) for k in range(60)]
    tracker = PatchTracker(picture((at[0], at[1]), [mug]), (110, 90, 21, 21))
    for frame, (u, v) in enumerate(path):
        found = tracker.update(picture((u, v), [mug], frame=frame))
        assert found.valid, found.reason
        assert np.hypot(found.pixel[0] - round(u), found.pixel[1] - round(v)) < 2.0


def test_a_patch_whose_box_holds_two_pieces_of_it_is_all_of_them() -> None:
    """A strap across it parts it."""
    image = picture((120.0, 100.0), [])
    image[98:103] = (150, 160, 165)
    found = PatchTracker(image, (108, 88, 25, 25)).update(image + np.uint8(1))
    assert found.valid
    assert np.hypot(found.pixel[0] - 120.0, found.pixel[1] - 100.0) < 1.5


def test_a_thing_that_is_seen_where_it_stood_is_not_followed_to_what_is_beside_it() -> None:
    """Half hidden, it drew the patch among what is no patch, which was never found again: 20 % of frames were valid."""
    standing = Standing(255 * (picture((245.0, 100.0), [MUG])[..., 0] > 170).astype(np.uint8), (235, 90, 21, 21), 1)
    things = Beside(standing, 31.0)
    mug, moved, beside = (
        Piece(np.array(at, dtype=float), 400.0, 1.0, (0, 0, 21, 21)) for at in (MUG, (150, 105), (172, 100))
    )
    things.learn([mug])
    things.follow([moved, beside])
    assert things.near(mug.centre)[0].centre is mug.centre
    # Where it is gone from its place, what is near may be it.
    things.follow([beside])
    assert things.near(beside.centre)[0].centre is beside.centre


@pytest.mark.parametrize("speed", [-5, -2, 3])
@pytest.mark.parametrize("half", [7, 14])
def test_a_thing_that_passes_the_patch_is_not_taken_for_it_nor_the_patch_for_it(half: int, speed: int) -> None:
    """Once both had been one piece, the patch was another's for good, or what passed was followed."""
    noise = np.random.default_rng(half)

    def shown(u: float, passing: float) -> Image:
        image = picture((u, 100.0), [], frame=round(passing))
        low, high = max(0, round(passing) - half), max(0, round(passing) + half)
        image[95 - half : 95 + half, low:high] = BLUE
        return np.asarray(np.clip(image + noise.normal(0, 3, image.shape), 0, 255), dtype=np.uint8)

    far = 160.0 - 60.0 * np.sign(speed) * abs(speed)
    tracker = PatchTracker(shown(160.0, -50.0), (150, 90, 21, 21))
    found = []
    for k in range(120):
        u = 160.0 + 10.0 * np.sin(0.1 * k)
        found.append((u, tracker.update(shown(u, far + speed * k))))
    off = [abs(one.pixel[0] - round(u)) for u, one in found if one.valid]
    assert max(off) < 15.0
    assert len(off) > 60
    assert all(one.valid for _, one in found[-10:])


def test_a_thing_that_comes_in_while_the_patch_is_away_is_not_taken_for_it() -> None:
    """Small at the picture's rim it grew, was thought to be two, left there, and taken for the patch."""
    wrong = []
    for seed in range(4):
        tracker = PatchTracker(picture((160.0, 100.0), [(300, 60)]), (150, 90, 21, 21))
        pick = np.random.default_rng(seed)
        for k in range(200):
            v = 100.0 + 4.0 * max(0, k - 20) if k < 100 else max(100.0, 260.0 - 4.0 * (k - 100))
            # The other goes out to the right before the patch goes, and comes back while it is away.
            other = round(300 + 3 * min(k, 12) - 3 * max(0, min(k - 40, 60)) + pick.normal(0.0, 0.5))
            found = tracker.update(picture((160.0, v), [(other, 60)], frame=k))
            wrong.append(found.valid and abs(found.pixel[1] - v) > 25.0)
    assert np.mean(wrong) < 0.02
