"""Evidence of a body: foreground without its shadow, edges, blobs of skin; and the projection's fit."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

import cv2
import numpy as np
import pytest

import pytracker as pt
from pytracker.evidence import Silhouette, SilhouetteParameters, median_background, senses_of
from pytracker.evidence.picture.silhouette import _region, check_order
from pytracker.evidence.picture.smaller import smaller, times_smaller
from pytracker.formats.video import Frame, frames
from pytracker.recording import fit_weak_perspective

PX_PER_M = 100.0


def wall() -> np.ndarray:
    rng = np.random.default_rng(1)
    image = np.full((120, 160, 3), (130, 134, 128), np.float64) + 2.0 * rng.standard_normal((120, 160, 3))
    return np.clip(image, 0, 255).astype(np.uint8)


def person(image: np.ndarray) -> np.ndarray:
    """A blue body with a face and two hands."""
    out = image.copy()
    cv2.rectangle(out, (60, 40), (100, 110), (150, 80, 40), cv2.FILLED)
    for centre in ((80, 30), (40, 70), (120, 70)):
        cv2.circle(out, centre, 7, (125, 158, 214), cv2.FILLED)
    return out


def test_a_person_is_foreground_and_a_shadow_is_not() -> None:
    background = wall()
    shaded = background.copy()
    shaded[60:110, 10:30] = (0.7 * shaded[60:110, 10:30]).astype(np.uint8)
    found = Silhouette(background, PX_PER_M)(person(shaded))
    assert (found.foreground[45:105, 65:95] > 0).all()
    assert (found.foreground[60:110, 10:30] > 0).mean() < 0.02
    without = Silhouette(background, PX_PER_M, SilhouetteParameters(shadow_chroma=0))(person(shaded))
    assert (without.foreground[65:105, 14:26] > 0).all()


def test_an_arm_before_a_wall_as_bright_as_it_is_is_skin() -> None:
    """Seen on people: a bare arm before a pillar of its brightness was lost from the elbow on."""
    background = wall()
    image = background.copy()
    image[50:90, 40:52] = np.clip(image[50:90, 40:52] + np.array([-14.0, -9.0, 20.0]), 0, 255).astype(np.uint8)
    found = Silhouette(background, PX_PER_M)(image)
    assert found.skin_region is not None
    assert found.skin_region[0][55:85, 44:48].max() < 1.0
    assert not found.foreground.any()
    assert Silhouette(background, PX_PER_M, SilhouetteParameters(region_chroma=255))(image).skin_region is None


@pytest.mark.parametrize("by", [(0, 0), (-50, -28), (75, 45), (-150, 0), (300, 0)], ids=str)
def test_what_is_far_from_the_person_has_no_say(by: tuple[int, int], monkeypatch: pytest.MonkeyPatch) -> None:
    """Most is done about the person alone: wherever they stand, cut by the rim or gone, the whole picture says that.

    The background holds a part of the face, which is skin beyond the foreground.
    """
    move = np.array([[1.0, 0.0, by[0]], [0.0, 1.0, by[1]]])
    held = wall()
    cv2.circle(held, (80 + by[0], 18 + by[1]), 12, (125, 158, 214), cv2.FILLED)
    there = cv2.warpAffine(np.full((120, 160), 255, np.uint8), move, (160, 120)) > 0
    whoever = cv2.rectangle(person(wall()), (74, 30), (86, 42), (125, 158, 214), cv2.FILLED)
    image = np.where(there[..., None], cv2.warpAffine(whoever, move, (160, 120)), held)
    image = np.where(np.all(held == (125, 158, 214), axis=2, keepdims=True), held, image)
    near = Silhouette(held, 4 * PX_PER_M)(image)
    monkeypatch.setattr(Silhouette, "_near", lambda self, mask: (slice(0, 120), slice(0, 160)))
    whole = Silhouette(held, 4 * PX_PER_M)(image)
    for name in ("foreground", "edges", "skin", "blobs"):
        assert np.array_equal(getattr(near, name), getattr(whole, name)), name
    regions = [(near.skin_region, whole.skin_region), (near.foreground_region, whole.foreground_region)]
    for some, every in regions:
        assert (some is None) == (every is None)
        if some is not None and every is not None:
            assert np.array_equal(some[0], every[0])
            assert np.array_equal(some[1], every[1])


def test_what_is_gone_at_half_the_size_is_far_and_not_nowhere() -> None:
    """Its distance would be infinite there, and no number between its pixels."""
    mask = np.zeros((40, 60), np.uint8)
    for u, v in ((31, 21), (32, 21), (31, 22)):
        mask[v, u] = 255
    found = _region(mask, (slice(0, 40), slice(0, 60)))
    assert found is not None
    assert np.isfinite(found[0]).all()
    assert len(found[1]) == 3


def test_skin_is_found_where_it_is() -> None:
    found = Silhouette(wall(), PX_PER_M)(person(wall()))
    expected = np.array([(80, 30), (40, 70), (120, 70)])
    assert len(found.blobs) == 3
    apart = np.linalg.norm(found.blobs[:, None] - expected, axis=2)
    assert apart.min(axis=0).max() < 1.5


def test_red_clothes_are_no_skin_in_any_light() -> None:
    """Their shaded parts have the Cr of skin."""
    image = person(wall())
    for k, light in enumerate(np.linspace(1.0, 0.3, 9)):
        cv2.rectangle(image, (60, 40 + 8 * k), (100, 48 + 8 * k), (60 * light, 60 * light, 150 * light), cv2.FILLED)
    found = Silhouette(wall(), PX_PER_M)(image)
    assert len(found.blobs) == 3
    naive = Silhouette(wall(), PX_PER_M, SilhouetteParameters(skin_reddest=9.0))(image)
    assert (naive.skin[45:105, 65:95] > 0).any()
    assert not (found.skin[45:105, 65:95] > 0).any()


@pytest.mark.parametrize("tone", [(175, 195, 232), (125, 158, 214), (90, 120, 175), (60, 80, 120)])
def test_skin_of_any_tone_is_skin(tone: tuple[int, int, int]) -> None:
    """From light to dark, BGR."""
    image = wall()
    cv2.circle(image, (80, 60), 9, tone, cv2.FILLED)
    assert len(Silhouette(wall(), PX_PER_M)(image).blobs) == 1


def test_a_bare_arm_offers_both_its_ends() -> None:
    image = wall()
    cv2.line(image, (50, 90), (80, 60), (125, 158, 214), 7)  # 42 cm long
    found = Silhouette(wall(), PX_PER_M)(image)
    assert len(found.blobs) == 2
    ends = np.array([(50, 90), (80, 60)])
    apart = np.linalg.norm(found.blobs[:, None] - ends, axis=2).min(axis=0)
    assert (apart > 2).all()
    assert (apart < 12).all()
    whole = SilhouetteParameters(bare_arm_m=9.0)
    assert len(Silhouette(wall(), PX_PER_M, whole)(image).blobs) == 1


def test_edges_run_along_the_outline() -> None:
    edges = Silhouette(wall(), PX_PER_M)(person(wall())).edges
    assert (edges[50:100, 57:64].max(axis=1) > 0).all()
    assert (edges[50:100, 70:90] > 0).mean() < 0.05
    assert not edges[:, :30].any()


def test_an_empty_scene_is_no_error() -> None:
    found = Silhouette(wall(), PX_PER_M)(wall())
    assert not found.edges.any()
    assert found.blobs.shape == (0, 2)


def test_what_cannot_be_used_is_refused() -> None:
    extract = Silhouette(wall(), PX_PER_M)
    with pytest.raises(pt.InputError, match=r"frame is \(60, 160, 3\), expected \(120, 160, 3\)"):
        extract(wall()[:60])
    with pytest.raises(pt.InputError, match=r"background is uint8 \(120, 160\)"):
        Silhouette(wall()[..., 0], PX_PER_M)
    with pytest.raises(pt.InputError, match="px_per_m is 0"):
        Silhouette(wall(), 0.0)
    with pytest.raises(pt.InputError, match="no frame"):
        median_background(iter(()))


def test_a_frame_whose_channels_are_in_another_order_is_refused(body: pt.BodyRecording) -> None:
    """RGB of a live source: an arm was 39 cm off, 83 % of its frames valid."""
    assert body.view.video is not None
    first = next(frames(body.view.video))
    senses = senses_of(body)
    with pytest.raises(pt.InputError, match="expected blue, green, red in this order"):
        senses(Frame(first.index, first.time_s, np.ascontiguousarray(first.image[..., ::-1])))
    assert (senses(first).foreground > 0).any()


def test_another_light_is_no_other_order() -> None:
    background = wall()
    background[90:] = (60, 100, 150)  # a wooden floor
    frame = person(background)
    check_order(np.clip(frame * np.array([0.7, 0.9, 1.2]), 0, 255).astype(np.uint8), background)
    check_order(np.clip(frame * np.array([1.3, 1.0, 0.8]), 0, 255).astype(np.uint8), background)
    with pytest.raises(pt.InputError, match="expected blue, green, red in this order"):
        check_order(np.ascontiguousarray(frame[..., ::-1]), background)


def test_a_frame_of_another_type_is_refused() -> None:
    with pytest.raises(pt.InputError, match="frame is of float64, expected uint8"):
        Silhouette(wall(), PX_PER_M)(person(wall()) / 255.0)  # type: ignore[arg-type]


def test_the_median_of_a_long_clip_is_the_background() -> None:
    background = wall()

    def clip() -> Iterator[Frame]:
        for k in range(500):
            image = background.copy()
            image[:, (3 * k) % 120 : (3 * k) % 120 + 40] = (150, 80, 40)
            yield Frame(k, k / 30, image)

    assert np.abs(median_background(clip()).astype(int) - background).max() == 0


@pytest.mark.parametrize("clothes", range(6))
def test_blobs_of_a_simulated_person_are_its_hands_and_head(tmp_path: Path, clothes: int) -> None:
    """In all clothes, red ones too. Where they are apart: a hand before the face is no blob of its own."""
    body = pt.load(pt.simulate_body(tmp_path / "body", pt.BodyScene(duration_s=2.0, clothes=clothes), seed=11))
    assert isinstance(body, pt.BodyRecording)
    extract = senses_of(body).silhouette
    assert extract is not None
    assert body.view.video is not None
    near = []
    for frame in frames(body.view.video):
        k = int(np.argmin(np.abs(body.truth.time_s - frame.time_s))) if body.truth is not None else 0
        assert body.poses is not None
        starts, ends, _ = body.skeleton.core.pose(body.poses[k : k + 1])
        hands = [0.5 * (starts[0, body.skeleton.bone(b)] + ends[0, body.skeleton.bone(b)]) for b in ("lhand", "rhand")]
        head = 0.5 * (starts[0, body.skeleton.bone("upperneck")] + ends[0, body.skeleton.bone("head")])
        pixels = body.view.camera.project(np.array([head, *hands]))
        if min(np.linalg.norm(pixels[a] - pixels[b]) for a, b in ((0, 1), (0, 2), (1, 2))) < 35:
            continue
        blobs = extract(frame.image).blobs
        near += [len(blobs) > 0 and np.linalg.norm(blobs - p, axis=1).min() < 10 for p in pixels]
    assert len(near) > 60
    assert np.mean(near) > 0.9


def test_every_real_clip_gives_evidence(shared: Callable[[str], Path]) -> None:
    """Fifteen clips of three people, made smaller as for tracking; the background is the median over all of them."""
    px_per_m = 480.0
    clips = {path.name: list(frames(path)) for path in sorted(shared("data/video/asl").glob("*.mkv"))}
    assert len(clips) == 15
    pool = [clip[k].image for clip in clips.values() for k in np.linspace(0, len(clip) - 1, 8).astype(int)]
    background = np.asarray(np.median(pool, axis=0), np.uint8)
    times = times_smaller(px_per_m, background)
    assert times > 1
    extract = Silhouette(smaller(background, times), px_per_m / times)
    for name, clip in clips.items():
        found = [extract(smaller(frame.image, times)) for frame in clip]
        assert np.mean([f.foreground.any() and f.edges.any() for f in found]) == 1.0, name
        # Who signs "help" holds both hands before the face: one region in a quarter of the frames.
        assert np.mean([len(f.blobs) >= 2 for f in found]) > (0.7 if name == "help.mkv" else 0.9), name
    extract = Silhouette(background, px_per_m)
    whole = [extract(frame.image) for frame in clips["help.mkv"]]
    assert np.mean([len(f.blobs) >= 2 for f in whole]) > 0.8


def test_fit_of_the_projection_is_least_squares_with_its_bounds() -> None:
    rng = np.random.default_rng(3)
    points = rng.uniform(-1, 1, (42, 3))
    true = np.array([[138.0, 2.0, 0.0, 160.0], [-5.0, -156.0, 0.0, 336.0]])
    inside = []
    for _ in range(200):
        pixels = points @ true[:, :3].T + true[:, 3] + 3.0 * rng.standard_normal((42, 2))
        fit = fit_weak_perspective(points, pixels)
        inside.append((fit.low <= true) & (true <= fit.high))
    assert 0.92 < np.mean(inside, axis=0)[:, [0, 1, 3]].mean() < 0.98
    residual = pixels - (points @ fit.matrix[:, :3].T + fit.matrix[:, 3])
    assert fit.sse == pytest.approx((residual**2).sum(axis=0))
    assert fit.rmse == pytest.approx(np.sqrt(fit.sse / 39))
    assert (fit.adjusted_r2 < fit.r2).all()
