"""`recording.toml` while it is being made: read however little is in it, changed without losing what was written."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import tomlkit
from tomlkit.exceptions import TOMLKitError
from tomlkit.items import AbstractTable, Item

from pytracker._core import InputError
from pytracker.output import write_whole
from pytracker.recording.schema import FILES, ArmFile, BodyFile

__all__ = ["Draft"]

LISTS = ("camera", "imu")
"""Tables that may stand more than once: `imu` is the first, `imu[1]` the second."""
MISSING = re.compile(r"# (\w+) = .*# missing:")
FOUND = "found by pytracker check"
"""What stands behind a value that took a guess's place."""


class Draft:
    """The file of `folder`. Raises `InputError` where it is missing, or no TOML."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.path = folder / "recording.toml"
        if not self.path.is_file():
            raise InputError(f"{folder}: holds no recording.toml, expected one: pytracker init writes it")
        try:
            self._document = tomlkit.parse(self.path.read_text("utf-8-sig"))
        except (TOMLKitError, ValueError, RecursionError) as error:
            raise InputError(f"{self.path}: is not TOML: {error or type(error).__name__}") from None

    @property
    def kind(self) -> str:
        """`arm` or `body`; an arm where it does not say."""
        return str(self._document.get("kind", "arm"))

    @property
    def schema(self) -> type[ArmFile | BodyFile]:
        """What may stand in it; an arm's where the kind is none."""
        return FILES.get(self.kind, ArmFile)

    def get(self, place: str) -> Any:
        """What stands at `camera.matrix` or the like; None where nothing does."""
        name, key = place.split(".")
        table = self._table(name)
        value: Any = None if table is None else table.get(key)
        return value.unwrap() if hasattr(value, "unwrap") else value

    def table(self, name: str) -> dict[str, Any]:
        """All that stands in a table; empty where there is none."""
        table = self._table(name)
        return {} if table is None else dict(table.unwrap())

    def lacks(self, *places: str) -> list[str]:
        """Those of the places where nothing stands."""
        return [place for place in places if self.get(place) is None]

    def file(self, place: str) -> Path | None:
        """The file that is named there."""
        name = self.get(place)
        return None if not isinstance(name, str) else self.folder / name

    def set(self, place: str, value: object, note: str = "") -> None:
        """Put a value where one stood, or at the end of its table, and a note behind it; a guess is none any more."""
        name, key = place.split(".")
        table = self._table(name)
        if table is None:
            table = tomlkit.table()
            if name in LISTS:
                tables = tomlkit.aot()
                tables.append(table)
                self._document[name] = tables
                table = self._table(name)
            else:
                self._document[name] = table
        assert table is not None
        there = table.item(key) if key in table else None
        if not note and isinstance(there, Item) and there.trivia.comment.startswith("# guessed"):
            note = FOUND
        table[key] = tomlkit.item(value).comment(note) if note else value

    def save(self) -> None:
        """Write it, whole."""
        write_whole(self.path, _without_found(tomlkit.dumps(self._document)))

    def count(self, name: str) -> int:
        """How many tables of that name there are."""
        found = self._document.get(name)
        return len(found) if isinstance(found, list) else int(isinstance(found, AbstractTable))

    def _table(self, name: str) -> AbstractTable | None:
        name, _, number = name.rstrip("]").partition("[")
        found, at = self._document.get(name), int(number or 0)
        if isinstance(found, list):  # [[camera]], or camera = [{ ... }]
            found, at = (found[at] if at < len(found) else None), 0
        return found if isinstance(found, AbstractTable) and at == 0 else None


def _without_found(text: str) -> str:
    """The same without comments that say what is missing where it stands below in the same table."""
    tables = re.split(r"(?m)^(?=\[)", text)
    for k, table in enumerate(tables):
        there = set(re.findall(r"(?m)^(\w+) *=", table))
        lines = table.splitlines(keepends=True)
        tables[k] = "".join(line for line in lines if not ((missing := MISSING.match(line)) and missing[1] in there))
    return "".join(tables)
