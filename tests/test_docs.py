"""What the documents promise: links that lead somewhere, examples that run, and the site of all of it."""

from __future__ import annotations

import re
import runpy
import subprocess
import sys
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote

import pytest

from pytracker.recording.schema import (
    ArmEntry,
    BodyCameraEntry,
    CameraEntry,
    ImuEntry,
    InitialEntry,
    SkeletonEntry,
    TruthEntry,
    read_recording_file,
)

ROOT = Path(__file__).parents[1]
PAGES = [ROOT / name for name in ("README.md", "CHANGELOG.md", "CONTRIBUTING.md")] + sorted(
    (ROOT / "docs").glob("*.md")
)
EXAMPLES = sorted((ROOT / "docs" / "examples").glob("*.py"))
"""Those in Rust are run and tested by Cargo."""


def anchors(page: Path) -> set[str]:
    """Of its headings, as GitHub makes them."""
    text = re.sub(r"```.*?```", "", page.read_text("utf-8"), flags=re.DOTALL)
    headings = re.findall(r"^#+ (.*)$", text, re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-") for heading in headings}


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_links_lead_somewhere(page: Path) -> None:
    for target in re.findall(r"\]\(([^)\s]+)\)", page.read_text("utf-8")):
        if re.match(r"[a-z]+:", target):
            continue  # elsewhere
        name, _, anchor = target.partition("#")
        file = page.parent / name if name else page
        assert file.exists(), target
        assert not anchor or anchor in anchors(file), target


@pytest.mark.parametrize("example", EXAMPLES, ids=lambda example: example.stem)
def test_an_example_runs(
    example: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """And prints what it is for; its first lines say how it is called."""
    monkeypatch.setattr(sys, "argv", [str(example), str(tmp_path / "out")])
    runpy.run_path(str(example), run_name="__main__")
    assert " cm" in capsys.readouterr().out
    assert f"python docs/examples/{example.name}" in example.read_text("utf-8").split('"""')[1]


def recordings(page: str) -> list[str]:
    """Every `recording.toml` that a page shows."""
    blocks = re.findall(r"```toml\n(.*?)```", (ROOT / page).read_text("utf-8"), re.DOTALL)
    return [block for block in blocks if "kind =" in block]


@pytest.mark.parametrize("page", ["README.md", "docs/recording.md"])
def test_recordings_that_are_shown_are_such(page: str, tmp_path: Path) -> None:
    shown = recordings(page)
    assert len(shown) == 2
    for text in shown:
        (tmp_path / "recording.toml").write_text(text, "utf-8")
        assert f'kind = "{read_recording_file(tmp_path / "recording.toml").kind}"' in text


def test_every_key_is_in_the_page_of_recordings() -> None:
    page = (ROOT / "docs" / "recording.md").read_text("utf-8")
    entries = (ArmEntry, BodyCameraEntry, CameraEntry, ImuEntry, InitialEntry, SkeletonEntry, TruthEntry)
    keys = {key for entry in entries for key in entry.model_fields}
    assert not [key for key in sorted(keys) if not re.search(rf"\b{key}\b", page)]


def test_every_example_is_in_the_guide() -> None:
    guide = (ROOT / "docs" / "guide.md").read_text("utf-8")
    for example in (ROOT / "docs" / "examples").glob("*.*"):
        assert f"examples/{example.name}" in guide, example.name


class Links(HTMLParser):
    """What a page links to, and what can be linked to on it."""

    def __init__(self) -> None:
        super().__init__()
        self.to: list[str] = []
        self.names: set[str] = set()

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        for name, value in attrs:
            if name in {"href", "src"} and value and not re.match(r"[a-z]+:|//", value):
                self.to.append(value)
            if name in {"id", "name"} and value:
                self.names.add(value)


def test_the_site_has_no_dead_links(tmp_path: Path) -> None:
    """README, guide, examples and the Python side in one; the Rust side where it was made."""
    build = [sys.executable, "-m", "mkdocs", "build", "--quiet", "--site-dir", str(tmp_path)]
    done = subprocess.run(build, cwd=ROOT, capture_output=True, text=True, check=True)  # noqa: S603
    told = [line for line in done.stderr.splitlines() if "rust/" not in line]
    assert not told
    pages = {page: Links() for page in [*tmp_path.glob("*.html"), *tmp_path.glob("examples/*.html")]}
    for page, links in pages.items():
        links.feed(page.read_text("utf-8"))
    assert {"index.html", "guide.html", "recording.html", "accuracy.html", "faults.html"} <= {
        page.name for page in pages
    }
    assert "PatchTracker" in (tmp_path / "api" / "pytracker" / "evidence.html").read_text("utf-8")
    for page, links in pages.items():
        # The page of what is not found is for a site at the root of its host.
        for target in () if page.name == "404.html" else links.to:
            path, _, anchor = target.partition("#")
            file = (page.parent / unquote(path.partition("?")[0])).resolve() if path else page
            if "rust" in file.relative_to(tmp_path).parts:
                continue
            assert file.exists(), (page.name, target)
            assert not anchor or file not in pages or anchor in pages[file].names, (page.name, target)
