"""Several recordings at once: each has its own folder, one that fails stops no other, and a page leads to all."""

from __future__ import annotations

import csv
import shutil
from pathlib import Path

from typer.testing import CliRunner

import pytracker as pt
from pytracker.cli.entry import app


def test_one_that_fails_stops_no_other(tmp_path: Path) -> None:
    first = pt.simulate_arm(tmp_path / "trial", pt.ArmScene(duration_s=3.0), 1)
    alike = tmp_path / "other" / "trial"
    shutil.copytree(first, alike)
    broken = tmp_path / "=broken"
    shutil.copytree(first, broken)
    (broken / "imu.csv").write_text("time_s,acc_x\n")
    out = tmp_path / "out"
    files = [str(folder) for folder in (first, broken, alike)]
    done = CliRunner().invoke(app, ["track", *files, "--out", str(out), "--no-report", "--jobs", "2"])
    assert done.exit_code == 1, done.output
    rows = list(csv.DictReader((out / "index.csv").read_text().splitlines()))
    assert [(row["recording"], row["result"], row["failed"]) for row in rows] == [
        ("trial", "trial", "False"),
        ("'=broken", "", "True"),
        ("trial", "trial-2", "False"),
    ]
    assert "acc_y" in rows[1]["said"]
    assert (out / "trial" / "track.csv").read_bytes() == (out / "trial-2" / "track.csv").read_bytes()
    page = (out / "index.html").read_text()
    assert 'href="trial-2/index.html"' in page
    assert "2 of 3" in page
    alone = CliRunner().invoke(app, ["track", str(first), "--out", str(tmp_path / "alone"), "--no-report", "--quiet"])
    assert alone.exit_code == 0, alone.output
    assert (tmp_path / "alone" / "track.csv").read_bytes() == (out / "trial" / "track.csv").read_bytes()
    again = CliRunner().invoke(app, ["track", *files, "--out", str(out), "--no-report", "--quiet"])
    assert again.exit_code == 1
    assert "already exists" in (out / "index.csv").read_text()
