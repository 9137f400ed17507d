"""Text tables: lines, cells and numbers that know their place, so that an error can name it."""

from __future__ import annotations

import codecs
import csv
import math
import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from pytracker._core import InputError

__all__ = [
    "Table",
    "cells_of",
    "delimited",
    "first_line",
    "number",
    "parse_table",
    "points_for_commas",
    "read_lines",
    "without_cut_row",
]

Float = NDArray[np.float64]

EMPTY = {
    "", "-", "--", "nan", "-nan", "nan(ind)", "-nan(ind)", "1.#qnan", "-1.#ind", "null", "none", "na", "n/a", "#n/a",
}  # fmt: skip
"""Cells that say "no value", lower-case; of C's libraries on Windows too."""
ZIP = b"PK\x03\x04"
EMPTY_ROW = ' ,;"'
"""What rows of a spreadsheet hold below its last; among others they are samples without values."""
DECIMAL_COMMA = re.compile(r"(?<=\d),(?=\d)")
QUOTED_COMMA = re.compile(r'"\s*([+-]?\d+),(\d+)\s*"')
MOST_OF_START, WIDE = 4096, 0.9
"""Of so many bytes every other one is 0 in so large a share where a text has two bytes a letter."""
THOUSANDS = 3
"""Digits after a comma that may part thousands."""


def read_lines(path: Path) -> list[str]:
    """Lines of `path` without their ends (LF or CRLF), UTF-8, UTF-16 or Latin-1. Raises `InputError`."""
    if not path.is_file():
        raise InputError(f"{path}: no such file")
    raw = path.read_bytes()
    if raw.startswith(ZIP):
        raise InputError(f"{path}: is an Excel workbook, or else zipped, expected text: save it as CSV")
    utf16 = _utf16(raw)
    if b"\0" in raw.rstrip(b"\0\r\n")[:4096] and not utf16:
        raise InputError(f"{path}: is a binary file, expected text")
    try:
        text = raw.decode(utf16 or "utf-8-sig")
    except UnicodeDecodeError as error:
        if utf16:
            raise InputError(f"{path}: begins as UTF-16, and is none from byte {error.start} on") from None
        text = raw.decode("latin-1")
    if not text.strip("\0 \t\r\n"):
        raise InputError(f"{path}: the file is empty ({len(raw)} bytes)")
    # Loggers write whole blocks, the last filled up with zeros.
    return text.rstrip("\0\r\n").replace("\r\n", "\n").replace("\r", "\n").split("\n")


def _utf16(raw: bytes) -> str:
    """Which UTF-16 it is, what Windows' own tools call Unicode; empty where it is none.

    By its mark, else by every other byte being 0, the other half of a letter or a digit.
    """
    if raw.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        return "utf-16"
    start = raw[:MOST_OF_START]
    halves = {"utf-16-be": start[0::2], "utf-16-le": start[1::2]}
    zeros, other = sorted(halves, key=lambda name: -halves[name].count(0))
    is_such = len(start) > 2 and halves[zeros].count(0) > WIDE * len(halves[zeros]) and not halves[other].count(0)
    return zeros if is_such else ""


def first_line(lines: Sequence[str]) -> int:
    """Index of the first line that is neither blank nor a comment (`#`); 0 where all are."""
    return next((k for k, line in enumerate(lines) if line.strip() and not line.startswith("#")), 0)


def delimited(lines: list[str], first: int = 0) -> tuple[str, list[str]]:
    """Which of comma, semicolon and tab parts the cells of the header, the line `first`, and the lines.

    Where it is no comma, those of decimals below it are points, as tables are written in half of Europe.
    """
    delimiter = max(",;\t", key=lines[first].count)
    return delimiter, _unquoted(lines, first + 1) if delimiter == "," else points_for_commas(lines, first + 1)


def cells_of(line: str, delimiter: str = ",") -> list[str]:
    """The cells of a line, of which quoted ones may hold delimiters."""
    try:
        return next(csv.reader([line], delimiter=delimiter)) if '"' in line else line.split(delimiter)
    except csv.Error:  # such as a cell of more than 131 072 characters
        return line.split(delimiter)


def points_for_commas(lines: list[str], first: int) -> list[str]:
    """The same, with points for decimal commas from the line `first` on; no comma may part the cells."""
    return [*lines[:first], *(DECIMAL_COMMA.sub(".", line) for line in lines[first:])]


def _unquoted(lines: list[str], first: int) -> list[str]:
    """The same, with points for decimal commas in quoted cells from the line `first` on; they may part thousands."""
    quoted = [match for line in lines[first:] if '"' in line for match in QUOTED_COMMA.finditer(line)]
    if all(len(match[2]) == THOUSANDS and match[1].lstrip("+-") != "0" for match in quoted):
        return lines
    return [*lines[:first], *(QUOTED_COMMA.sub(r"\1.\2", line) for line in lines[first:])]


def number(cell: str, path: Path, line: int, column: str) -> float:
    """The number in a cell; NaN where it says that there is none. Raises `InputError` naming the place."""
    cell = cell.strip()
    if cell.lower() in EMPTY:
        return math.nan
    try:
        value = float(cell)
    except ValueError:
        asks = ", with a point for decimals" if re.fullmatch(r"[+-]?\d+,\d+", cell) else ""
        raise InputError(f"{path}:{line}: {column} is {cell[:80]!r}, expected a number{asks}") from None
    if "_" in cell or math.isinf(value):
        raise InputError(f"{path}:{line}: {column} is {cell[:80]!r}, expected a finite number")
    return value


@dataclass(frozen=True, eq=False)
class Table:
    """Columns of numbers by name.

    Attributes:
        path: the file.
        names: column names, in the file's order.
        values: `(M, K)`; NaN where a cell is empty.
        lines: line number of every row, from 1 `(M,)`.
        header: names of all columns of the file, also of those that were not read.
    """

    path: Path
    names: tuple[str, ...]
    values: Float
    lines: NDArray[np.int64]
    header: tuple[str, ...] = ()

    def columns(self, *names: str) -> Float | None:
        """The columns named, `(M, len(names))`; None where one of them is not there."""
        if any(name not in self.names for name in names):
            return None
        return np.ascontiguousarray(self.values[:, [self.names.index(name) for name in names]])

    def without(self, rows: NDArray[np.bool_]) -> Table:
        """The table without the rows marked."""
        return replace(self, values=self.values[~rows], lines=self.lines[~rows])


def without_cut_row(
    path: Path, lines: list[str], first: int, names: Sequence[str], delimiter: str
) -> tuple[list[str], tuple[str, ...]]:
    """The same without a last row of `lines[first:]` that lacks cells, and a word on it.

    As it is left by a logger that lost its power.
    """
    at = _rows_at(lines, first, names, delimiter)
    count = len(_split_cells(lines[at[-1]], delimiter, len(names))) if len(at) > 1 else len(names)
    if count >= len(names):
        return lines, ()
    words = f"its last row has {count} cells of {len(names)}: the file is cut short there, the row left out"
    return lines[: at[-1]], (f"{path}:{at[-1] + 1}: {words}",)


def _rows_at(lines: Sequence[str], first: int, names: Sequence[str], delimiter: str) -> list[int]:
    """Which lines hold rows: no blank ones, no comments (`#`), and below the last no rows of empty cells."""
    at = [k for k in range(first, len(lines)) if lines[k].strip(" ") and not _is_comment(lines[k], delimiter, names)]
    while at and not lines[at[-1]].strip(EMPTY_ROW):
        at.pop()
    return at


def parse_table(
    path: Path, lines: Sequence[str], first: int, names: Sequence[str], delimiter: str, wanted: set[str]
) -> Table:
    """Numbers of the `wanted` columns in `lines[first:]`.

    Blank lines and comments (`#`) are passed over, and rows of empty cells below the last. Raises `InputError` for a
    row with another number of cells than names, a cell that is no number, or no row.
    """
    kept = [(k, name) for k, name in enumerate(names) if name in wanted]
    at = _rows_at(lines, first, names, delimiter)
    rows: list[list[float]] = []
    header = lines[first - 1].strip() if first else ""
    for index in at:
        cells = _split_cells(lines[index], delimiter, len(names))
        if header and lines[index].strip() == header:
            raise InputError(
                f"{path}:{index + 1}: is the header of line {first} again, expected one recording a file: another "
                "follows there"
            )
        if len(cells) != len(names):
            raise InputError(f"{path}:{index + 1}: row has {len(cells)} cells, expected {len(names)} as the header has")
        rows.append([number(cells[k], path, index + 1, name) for k, name in kept])
    if not rows:
        raise InputError(f"{path}: has a header but no rows, expected at least one sample")
    values = np.array(rows, dtype=np.float64).reshape(len(rows), len(kept))
    numbers = np.array(at, dtype=np.int64) + 1
    return Table(path, tuple(name for _, name in kept), values, numbers, tuple(names))


def _is_comment(line: str, delimiter: str, names: Sequence[str]) -> bool:
    return line.startswith("#") and len(_split_cells(line, delimiter, len(names))) != len(names)


def _split_cells(line: str, delimiter: str, expected: int) -> list[str]:
    """Cells of a row; a trailing delimiter is forgiven.

    Where spaces delimit and empty cells have run together, the missing ones are taken to stand after the first.
    """
    cells = cells_of(line, delimiter)
    if len(cells) == expected + 1 and not cells[-1].strip():
        cells = cells[:-1]
    if delimiter == " " and len(cells) != expected:
        words = line.split()
        missing = [""] * max(0, expected - len(words))
        cells = [*words[:1], *missing, *words[1:]]
    return cells
