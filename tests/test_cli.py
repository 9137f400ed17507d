"""The command line as a user types it: exit status, messages, files."""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
from dataclasses import fields
from pathlib import Path

import pytest

import pytracker as pt
from pytracker.cli import main


def run(*arguments: str | Path) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "pytracker", *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True, check=False)  # noqa: S603


def test_without_a_subcommand_it_helps() -> None:
    shown = run()
    assert "Usage: " in shown.stdout + shown.stderr
    for command in ("demo", "simulate", "frame", "track", "evaluate", "report"):
        assert command in shown.stdout + shown.stderr
    assert run("--version").stdout.startswith("pytracker 0.")


def test_help_lists_every_parameter_with_its_default_and_what_it_is() -> None:
    for command, classes in (
        (("track",), (pt.Ekf, pt.Joint, pt.BodyPlain, pt.Partitioned)),
        (("simulate", "arm"), (pt.ArmScene,)),
        (("simulate", "body"), (pt.BodyScene,)),
    ):
        shown = run(*command, "--help").stdout
        lines = [line.strip() for line in shown.splitlines()]
        for field in (field for cls in classes for field in fields(cls)):
            entries = [k for k, line in enumerate(lines) if line.startswith(f"{field.name}=")]
            assert entries, field.name
            assert any("=" not in lines[k + 1].split(" ")[0] and lines[k + 1] for k in entries), field.name
    assert "islands=8" in run("track", "--help").stdout


def test_track_evaluate_and_frame(simulated: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    done = run(
        "track", simulated, "--method", "layered", "--particles", "200", "--set", "bias=true", "--seed", "7",
        "--out", out, "--no-report",
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert "PF with constraint (layered), N = 200, bias" in done.stdout
    assert {path.name for path in out.glob("[!.]*")} == {"track.csv", "metadata.json", "scores.json"}
    metadata = json.loads((out / "metadata.json").read_text())
    assert metadata["tracks"][0]["seed"] == 7
    assert metadata["tracks"][0]["parameters"]["bias"] is True
    scored = json.loads(run("evaluate", simulated, out).stdout)
    expected = json.loads((out / "scores.json").read_text())
    ours, theirs = scored[str(out)]["joints"]["wrist"], next(iter(expected.values()))["joints"]["wrist"]
    assert ours["rms_m"] == pytest.approx(theirs["rms_m"], abs=1e-6)
    held = scored["first pose held"]["joints"]["wrist"]
    assert held["median_m"] == pytest.approx(expected["first pose held"]["joints"]["wrist"]["median_m"], abs=1e-6)
    assert held["coverage"] == [None, None, None]
    again = run("track", simulated, "--out", out)
    assert again.returncode == 2
    assert f"{out}: already exists, expected a new folder (or --force to replace it)" in again.stderr
    png = tmp_path / "frame.png"
    assert run("frame", simulated, "--out", png).returncode == 0
    assert "already exists" in run("frame", simulated, "--out", png).stderr
    assert "ends in .png" in run("frame", simulated, "--out", tmp_path / "recording.toml").stderr
    assert png.read_bytes().startswith(b"\x89PNG")
    assert "expected one numbered 900" in run("frame", simulated, "--frame", "900", "--force", "--out", png).stderr


@pytest.mark.parametrize(
    ("arguments", "expected"),
    [
        (["--method", "layred"], "--method is 'layred', expected one of: inertial, ekf, plain, layered"),
        (["--set", "biass=true"], "--set biass: Smooth has no such parameter, did you mean 'bias'?"),
        (["--set", "bias"], "--set 'bias', expected KEY=VALUE"),
        (["--set", "bias=yes"], "Smooth.bias is 'yes', expected true or false"),
        (["--method", "joint", "--set", "particles=1.5"], "Joint.particles is 1.5, expected a whole number, 0 or more"),
        (["--method", "joint", "--set", "layers=colour"], "Joint.layers is 'colour', expected layers such as"),
        (["--method", "joint", "--particles", "4000000000"], "particles is 4000000000, expected 1 to 100000000"),
        (["--method", "joint", "--particles", "9", "--set", "particles=8"], "both given, expected one of them"),
        (["--method", "ekf", "--particles", "9"], "--particles does not go with --method ekf"),
    ],
)
def test_bad_usage_exits_2(simulated: Path, tmp_path: Path, arguments: list[str], expected: str) -> None:
    done = run("track", simulated, "--out", tmp_path / "out", *arguments)
    assert done.returncode == 2
    assert expected in done.stderr
    assert "Traceback" not in done.stderr


def test_bad_input_exits_2_and_debug_shows_where(tmp_path: Path) -> None:
    done = run("track", tmp_path / "nowhere", "--out", tmp_path / "out")
    assert done.returncode == 2
    assert done.stderr.startswith("pytracker: ")
    assert "nowhere: is no folder, expected a folder with recording.toml" in done.stderr
    assert "Traceback" in run("--debug", "track", tmp_path / "nowhere", "--out", tmp_path / "out").stderr
    assert run("track").returncode == 2


def test_a_lost_track_exits_1_and_leaves_what_there_was(
    simulated: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    tracked = pt.track(pt.load(simulated), pt.Layered(particles=50))

    def lose(*_: object, **__: object) -> pt.Track:
        error = pt.TrackingError("frame 7: all 50 particle weights are zero at 0.28 s")
        error.track = tracked
        raise error

    monkeypatch.setattr(pt, "track", lose)
    out = tmp_path / "out"
    monkeypatch.setattr(sys, "argv", ["pytracker", "track", str(simulated), "--out", str(out), "--no-report"])
    with pytest.raises(SystemExit) as left:
        main()
    assert left.value.code == 1
    said = capsys.readouterr().err
    assert "frame 7: all 50 particle weights are zero" in said
    assert f"the frames before are in {out}" in said
    assert (out / "track.csv").is_file()


def test_force_replaces_only_what_was_made_here(simulated: Path, tmp_path: Path) -> None:
    home = tmp_path / "home"
    home.mkdir()
    (home / "thesis.txt").write_text("years of work")
    done = run("track", simulated, "--out", home, "--force")
    assert done.returncode == 2
    assert "was not written by pytracker, expected a folder that was; it is not replaced" in done.stderr
    mine = tmp_path / "mine"
    shutil.copytree(simulated, mine / "recording")
    (mine / ".made-by-pytracker").touch()
    assert "holds other folders" in run("track", simulated, "--out", mine, "--force").stderr
    recording = shutil.copytree(simulated, tmp_path / "own")
    (recording / ".made-by-pytracker").unlink()
    assert run("track", recording, "--out", recording, "--force").returncode == 2
    assert (home / "thesis.txt").is_file()
    assert (recording / "video.mp4").is_file()


@pytest.mark.parametrize(
    ("setting", "expected"),
    [
        ("duration_s=abc", "duration_s is 'abc', expected a finite number"),
        ("duration_s=1e9", "duration_s is 1000000000.0, expected 1 to 100000 frames"),
        ("centre_m=[1,2]", "centre_m is (1, 2), expected three finite numbers"),
        ("cameras=1.5", "cameras is 1.5, expected a whole number"),
        ("occlusions=[3,4]", "occlusions is (3, 4), expected pairs (from, to) in s"),
        ("acc_noise=-1", "acc_noise is -1, expected 0 or more"),
        ("distractor=yes", "distractor is 'yes', expected true or false"),
    ],
)
def test_simulate_names_bad_settings(tmp_path: Path, setting: str, expected: str) -> None:
    done = run("simulate", "arm", tmp_path / "out", "--set", setting)
    assert done.returncode == 2
    assert expected in done.stderr


def test_simulate_takes_every_setting(tmp_path: Path) -> None:
    out = tmp_path / "reach"
    done = run(
        "simulate", "arm", out, "--seed", "4", "--set", "pattern=reach", "--set", "duration_s=1.0",
        "--set", "occlusions=[[0.2, 0.4]]", "--set", "cameras=2",
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert {path.name for path in out.glob("[!.]*")} == {
        "recording.toml", "video.mp4", "video1.mp4", "imu.csv", "qualisys.tsv",
    }  # fmt: skip
    assert "expected one of: circle, rectangle, reach" in run("simulate", "arm", out, "--set", "pattern=x").stderr


def test_demo_compares_every_method(tmp_path: Path) -> None:
    done = run("demo", "--out", tmp_path / "report", "--duration", "2", "--body-duration", "1")
    assert done.returncode == 0, done.stderr
    for words in ("PF with constraint (joint)", "PF with constraint (layered)", "EKF with constraint", "Inertial only"):
        assert words in done.stdout
    for words in ("Partitioned PF", "Annealed PF", "PF of Li & Kulić"):
        assert words in done.stdout
    again = run("demo", "--out", tmp_path / "report", "--force", "--duration", "1", "--body-duration", "1", "--quiet")
    assert again.returncode == 0, again.stderr
    page = (tmp_path / "report" / "index.html").read_text("utf-8")
    for kind in ("arm", "body"):
        assert f'href="{kind}/index.html"' in page
        assert f'src="{kind}/overlay.webm"' in page
        assert {"arm": "first position held", "body": "first pose held"}[kind] in page
        assert (tmp_path / "report" / kind / "index.html").is_file()
        assert (tmp_path / "report" / kind / "overlay.webm").stat().st_size > 1000


def test_import_is_light() -> None:
    """Nothing that only a report or an orientation filter needs is imported with the package."""
    code = "import sys, pytracker; print([m for m in ('matplotlib', 'jinja2', 'vqf', 'typer') if m in sys.modules])"
    assert subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout == "[]\n"  # noqa: S603
