"""What the site has besides `docs/`: the root's pages, examples as pages, and the API of both sides.

Hooks of MkDocs, by `mkdocs.yml`. The Rust side is there where `cargo doc` made it.
"""

from __future__ import annotations

import pkgutil
import re
import tempfile
from pathlib import Path

import pdoc
from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import File, Files
from mkdocs.structure.pages import Page

import pytracker

ROOT = Path(__file__).parents[1]
PAGES = {"README.md": "index.md", "CONTRIBUTING.md": "CONTRIBUTING.md", "CHANGELOG.md": "CHANGELOG.md"}
"""Pages of the root, and what they are called in the site."""
LANGUAGES = {".py": "python", ".rs": "rust"}


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """Add what is made or lies elsewhere."""
    for name, called in PAGES.items():
        files.append(File.generated(config, called, content=(ROOT / name).read_text("utf-8")))
    files.append(File.generated(config, "CITATION.cff", content=(ROOT / "CITATION.cff").read_text("utf-8")))
    for example in sorted((ROOT / "docs" / "examples").glob("*.*")):
        language = LANGUAGES[example.suffix]
        text = f"# {example.name}\n\n```{language}\n{example.read_text('utf-8')}```\n"
        files.append(File.generated(config, f"examples/{example.stem}.md", content=text))
    with tempfile.TemporaryDirectory() as made:
        pdoc.pdoc("pytracker", *packages(), output_directory=Path(made))
        add(files, config, Path(made), "api")
    add(files, config, ROOT / "target" / "doc", "rust")
    return files


def packages() -> list[str]:
    """Rooms of the package, whose names are not among the public ones."""
    rooms = (room.name for room in pkgutil.iter_modules(pytracker.__path__) if room.ispkg)
    return [f"pytracker.{name}" for name in rooms if name not in pytracker.__all__]


def add(files: Files, config: MkDocsConfig, folder: Path, called: str) -> None:
    """Every file of a folder."""
    for path in sorted(folder.rglob("*")):
        if path.is_file() and path.name != ".lock":
            where = f"{called}/{path.relative_to(folder).as_posix()}"
            files.append(File.generated(config, where, content=path.read_bytes()))


def on_page_markdown(markdown: str, page: Page, config: MkDocsConfig, files: Files) -> str:
    """Links between root and `docs/`, which lie beside each other here."""
    markdown = re.sub(r"\]\((?:docs|\.\.)/", "](", markdown)
    return re.sub(r"\]\((examples/\w+)\.(?:py|rs)\)", r"](\1.md)", markdown)
