"""Both papers' pages: made small, looked at in a browser, and their numbers against the table they come from."""

from __future__ import annotations

import csv
import shutil
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pytest
from browser import SIZES, contrast, opened
from conftest import made_once
from test_cli import run

import pytracker as pt
from pytracker.reproduce import PAPERS, printed
from pytracker.reproduce.endings import endings, tracked
from pytracker.reproduce.words import cm, comparison, plain_number, share, than, times
from pytracker.scores import mean_interval, paired_ratio
from pytracker.simulate import ArmSimulation
from pytracker.study import Study, StudyRecording

if TYPE_CHECKING:
    from playwright.sync_api import Browser

DURATIONS_S = {"tao-hu": 3.2, "li-kulic": 1.0}


@pytest.fixture(scope="module")
def pages(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    made = {}
    for paper in PAPERS:
        small = partial(pt.reproduce, paper, seeds=2, duration_s=DURATIONS_S[paper])
        made[paper] = made_once(tmp_path_factory, paper, small) / "index.html"
    return made


@pytest.mark.parametrize(("width", "scheme"), SIZES)
@pytest.mark.parametrize(("paper", "figures", "sections"), [("tao-hu", 8, 11), ("li-kulic", 8, 11)])
def test_pages_in_a_browser(
    browser: Browser, pages: dict[str, Path], paper: str, figures: int, sections: int, width: int, scheme: str
) -> None:
    page = opened(browser, pages[paper], width, scheme)
    assert page.locator("img").count() == figures
    assert page.locator("section h2").count() == sections
    assert page.locator("figcaption").count() == figures
    for selector in ("p.words", ".soft", "td", "caption"):
        assert contrast(page, selector) >= 4.5
    page.close()


@pytest.mark.parametrize("paper", PAPERS)
def test_pages_print_on_a4(browser: Browser, pages: dict[str, Path], paper: str) -> None:
    page = opened(browser, pages[paper], 1280, "light")
    page.emulate_media(media="print")
    # 210 mm less margins of 14 mm, at 96 px per inch.
    page.set_viewport_size({"width": 688, "height": 970})
    wide = page.evaluate("[...document.querySelectorAll('table, img')].filter(e => e.scrollWidth > 688).length")
    assert wide == 0
    assert page.pdf(format="A4").startswith(b"%PDF")
    page.close()


@pytest.mark.parametrize("paper", PAPERS)
def test_a_second_run_uses_the_first(pages: dict[str, Path], paper: str, tmp_path: Path) -> None:
    known: list[tuple[int, int]] = []
    folder = shutil.copytree(pages[paper].parent, tmp_path / paper)
    before = (folder / "study" / "table.csv").read_bytes()
    pt.reproduce(
        paper, folder, seeds=2, duration_s=DURATIONS_S[paper], progress=lambda done, total: known.append((done, total))
    )
    assert len(known) == 1
    assert known[0][0] == known[0][1]
    assert (folder / "study" / "table.csv").read_bytes() == before


def test_the_page_says_what_the_table_says(browser: Browser, pages: dict[str, Path]) -> None:
    with (pages["tao-hu"].parent / "study" / "table.csv").open(encoding="utf-8") as file:
        rows = [r for r in csv.DictReader(file) if r["recording"] == "circle" and r["joint"] == "wrist"]
    assert {row["status"] for row in rows} == {"ok"}
    mean = 100 * np.mean([float(row["mean_x_m"]) for row in rows if row["method"] == "layered"])
    page = opened(browser, pages["tao-hu"], 1280, "light")
    cells = page.locator("#table-i tbody tr", has_text="PF with constraint").first.locator("th, td").all_inner_texts()
    assert cells[:2] == ["PF with constraint", "-0.68 / 2"]
    assert cells[2].startswith(f"{mean:.1f} ± ")
    page.close()
    page = opened(browser, pages["li-kulic"], 1280, "light")
    cells = page.locator("#particles tbody tr").nth(3).locator("th, td").all_inner_texts()
    assert cells[:2] == ["300", "7"]
    assert cells[2].split(" ± ")[0] in page.locator(".summary").inner_text()
    page.close()


def test_printed_numbers_are_those_of_the_papers() -> None:
    assert list(printed.TABLE_I_CM["PF with constraint"]) == [(-0.68, 2.0), (1.14, 5.47), (1.77, 3.27)]
    assert printed.TABLE_I_CM["Inertial only"][0] == (21.31, 37.70)
    assert all(low < value < high for value, low, high in printed.TABLE_II.values())


def test_what_is_refused(tmp_path: Path) -> None:
    with pytest.raises(pt.InputError, match="the paper is 'hu-tao', expected one of: tao-hu, li-kulic"):
        pt.reproduce("hu-tao", tmp_path / "x")
    with pytest.raises(pt.InputError, match="there are 1 seeds, expected at least 2"):
        pt.reproduce("tao-hu", tmp_path / "x", seeds=1)
    (tmp_path / "letters").mkdir()
    (tmp_path / "letters" / "index.html").touch()
    with pytest.raises(pt.InputError, match="already exists and is no reproduction"):
        pt.reproduce("tao-hu", tmp_path / "letters")
    (tmp_path / "letters" / "study").mkdir()
    with pytest.raises(pt.InputError, match="already exists and is no reproduction"):
        pt.reproduce("tao-hu", tmp_path / "letters")
    (tmp_path / "other").mkdir()
    (tmp_path / "other" / ".made-by-pytracker").write_text("li-kulic")
    with pytest.raises(pt.InputError, match="holds something else than tao-hu"):
        pt.reproduce("tao-hu", tmp_path / "other")
    with pytest.raises(pt.InputError, match=r"duration_s is 1.0, expected 3.2 to 600 s"):
        pt.reproduce("tao-hu", tmp_path / "x", duration_s=1.0)
    assert not (tmp_path / "x").exists()
    failed = run("reproduce", "hu-tao", "--out", tmp_path / "x")
    assert failed.returncode == 2
    assert "expected one of: tao-hu, li-kulic" in failed.stderr


def test_pages_tell_of_runs_that_did_not_end_well(tmp_path: Path) -> None:
    # A bias that drives the particles through the camera.
    scene = pt.ArmScene(duration_s=2.0, acc_bias=30.0)
    recording = StudyRecording(name="circle", scene=scene, pixel_sd=4.0)
    method = pt.Plain(particles=10)
    table = pt.run_study(Study(recordings=(recording,), methods=(method,), seeds=(1, 3, 4)), tmp_path / "out")
    said = endings(table, {"PF": method}, {"circle": ["circle"]})
    assert said.tables[0].rows == [["PF", "2 lost"]]
    assert "favours the method that was lost" in said.words[0]
    kept = endings(table, {"EKF": pt.Ekf()}, {"circle": ["circle"]})
    assert kept.words == ("Every run kept its track to the end.",)
    simulation = ArmSimulation(scene, 3)
    sightings = pt.Sightings.of(simulation.frame_time_s, simulation.sightings(4.0))
    found, words = tracked(simulation.recording(), method, 3, sightings)
    assert found is not None
    assert words.startswith("frame 10: all 10 particle weights are zero")


def test_words_of_numbers() -> None:
    nan = float("nan")
    interval = mean_interval([0.03, 0.04, 0.05])
    assert cm(interval) == "4.0 ± 2.5"
    assert share(interval) == "4 ± 2 %"
    assert share(interval, mean_interval([0.5])) == "4 ± 2 · 50 %"
    assert cm(mean_interval([0.0077, 0.0079])) == "0.8 ± 0.1"
    assert cm(mean_interval([0.00771, 0.00772, 0.00773])) == "0.77 ± 0.00"
    assert cm(mean_interval([1.234])) == "123"
    assert times(paired_ratio([2.0, 2.0], [1.0, 1.0])) == "2.0 (2.0 to 2.0)"
    assert [plain_number(x) for x in (123.4, 12.34, 0.1234, -2.34)] == ["123", "12.3", "0.12", "-2.3"]
    ratio, difference, count, verdict = comparison([0.01, 0.012, 0.011], [0.02, 0.022, 0.023])
    assert ratio.startswith("0.51 (")
    assert difference.startswith("-1.1 ± ")
    assert (count, verdict) == ("3 of 3", "smaller")
    assert comparison([0.01, 0.03], [0.02, 0.02])[3] == "not told apart"
    # A run that failed on one side is left out of both.
    assert comparison([0.01, nan, 0.011, 0.5], [0.02, 0.022, 0.023, nan])[2] == "2 of 2"
    assert comparison([nan], [0.1]) == ("–", "–", "0 of 1", "not told apart")
    assert (than("smaller"), than("not told apart")) == ("smaller than", "not told apart from")
