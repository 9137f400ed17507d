"""Study files and studies: what is read, and every fault with its place, value and expectation."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

import pytest
from study_cases import CIRCLE, METHODS, SCENE, TOML

import pytracker as pt
from pytracker.study import Study, StudyRecording


@pytest.mark.parametrize(
    ("line", "instead", "message"),
    [
        ("schema = 1", "schema = 2", "schema is 2, this version reads 1"),
        ("seeds = 10", "seeds = 0", "seeds is 0, expected a whole number from 1 to 100000, or a list of them"),
        ("seeds = 10", "seeds = 1000000000000", "seeds is 1000000000000, expected a whole number from 1 to 100000"),
        ("seeds = 10", "seeds = true", "seeds is True, expected a whole number"),
        ("seeds = 10", "seeds = [1, 1]", "the seed 1 twice, expected all to differ"),
        ("seeds = 10", "seeds = [-1]", "the seed is -1, expected a whole number from 0 to 2^63 - 1"),
        ("seeds = 10", "seed = 10", "seed is not a known key, did you mean 'seeds'?"),
        ('simulate = "arm"', 'simulate = "leg"', "recording[0].simulate is 'leg', expected: input should be 'arm'"),
        ('simulate = "arm"', "", "recording[0] has neither of folder and simulate, expected one of them"),
        ('simulate = "arm"', 'folder = "x"', "recording[0].scene goes with simulate, not with folder"),
        ("duration_s = 2.0", "duration = 2.0", "recording[0].scene.duration is not a known key, did you mean"),
        ("duration_s = 2.0", "duration_s = -2.0", "duration_s is -2.0, expected a positive number"),
        ("pixel_sd = 4.0", "pixel_sd = -4.0", "recording[0].pixel_sd is -4.0"),
        ('name = "layered"', 'name = "layred"', "method[0].name is 'layred', did you mean 'layered'?"),
        ("grid = { particles", "grid = { particle", "method[0]: particle: Layered has no such parameter, did you mean"),
        (
            "grid = { particles",
            'set = { particles = "few" }\ngrid = { pixel_sd',
            "Layered.particles is 'few', expected",
        ),
        ("grid = {", "set = { particles = 3 }\ngrid = {", "method[0] has particles in both set and grid"),
        ('name = "ekf"', 'name = "partitioned"', "method[1].name is 'partitioned', expected one of: inertial"),
        ("grid = { particles = [400, 2000, 8000] }", "grid = { particles = [4, 4] }", "twice, expected all to differ"),
    ],
)
def test_faults_of_a_study_file(tmp_path: Path, line: str, instead: str, message: str) -> None:
    file = tmp_path / "study.toml"
    assert line in TOML
    file.write_text(TOML.replace(line, instead, 1))
    with pytest.raises(pt.InputError) as caught:
        pt.read_study(file)
    assert str(file) in str(caught.value)
    assert message in str(caught.value)


def test_a_study_file_is_what_it_says(tmp_path: Path) -> None:
    file = tmp_path / "study.toml"
    file.write_text(TOML)
    study = pt.read_study(file)
    assert study.recordings == (CIRCLE,)
    assert study.seeds == tuple(range(1, 11))
    assert [getattr(method, "particles", 0) for method in study.methods] == [400, 2000, 8000, 0]


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: StudyRecording(name="a\rb", folder=Path()), "expected printable characters"),
        (lambda: StudyRecording(name="x", scene=SCENE, pixel_sd=float("inf")), "expected an arm's, 0 px or more"),
        (lambda: StudyRecording(name="x", scene=SCENE, seed=-5), "the seed is -5, expected a whole number"),
        (lambda: Study(recordings=(CIRCLE,), methods=METHODS, seeds=(1.5,)), "the seed is 1.5"),  # type: ignore[arg-type]
        (lambda: Study(recordings=(CIRCLE,), methods=METHODS, seeds=range(10**6)), "3000000 runs, expected at most"),
        (lambda: StudyRecording(name="x"), "has neither folder nor scene"),
        (lambda: StudyRecording(name="x", folder=Path(), seed=1), "seed and pixel_sd go with a scene"),
        (lambda: StudyRecording(name="x", scene=pt.BodyScene(), pixel_sd=1.0), "expected an arm's"),
        (lambda: Study(recordings=(), methods=METHODS, seeds=(1,)), "has no recording, expected at least one"),
        (lambda: Study(recordings=(CIRCLE,), methods=(pt.BodyPlain(),), seeds=(1,)), "the study has none"),
        (lambda: Study(recordings=(CIRCLE, CIRCLE), methods=METHODS, seeds=(1,)), "twice"),
    ],
)
def test_faults_of_a_study(make: Callable[[], object], message: str) -> None:
    with pytest.raises(pt.InputError, match=message):
        make()


def test_the_readmes_study_is_one(tmp_path: Path) -> None:
    text = (Path(__file__).parents[1] / "README.md").read_text("utf-8")
    (block,) = [b for b in re.findall(r"```toml\n(.*?)```", text, re.DOTALL) if "[[method]]" in b]
    (tmp_path / "study.toml").write_text(block, "utf-8")
    study = pt.read_study(tmp_path / "study.toml")
    assert [recording.name for recording in study.recordings] == ["trial03", "circle"]
    assert [getattr(method, "particles", 0) for method in study.methods] == [100, 500, 2000]
    assert len(study.seeds) == 10


def test_the_tables_studies_are_such() -> None:
    for name, count in (("arm-table", 10), ("arm-senses", 2), ("body-table", 4)):
        study = pt.read_study(Path(__file__).parents[1] / "docs" / f"{name}.toml")
        assert (len(study.methods), len(study.seeds)) == (count, 10)
