"""Dates and times of day in a table's clock, as seconds since the first."""

from __future__ import annotations

import re
from collections.abc import Iterable
from datetime import datetime, timedelta
from pathlib import Path

from pytracker._core import InputError

__all__ = ["as_seconds"]

DATE_OR_TIME = re.compile(r"\d{4}[-/]\d\d?[-/]\d\d?[ T]|\d{8}T\d|\d\d?[./-]\d\d?[./-]\d{4}[ T]|\d\d?:\d\d[:.,]\d")
YEAR_FIRST = r"(?P<year>\d{4})(?P<by>[-/]?)(?P<month>\d\d?)(?P=by)(?P<day>\d\d?)"
YEAR_LAST = r"(?P<first>\d\d?)(?P<by>[-/.])(?P<second>\d\d?)(?P=by)(?P<year>\d{4})"
FRACTION = r"(?:(?:[.,]|:(?=\d{3}(?!\d)))(?P<fraction>\d+))?"
"""Of a second; behind a colon there are thousandths, and of two digits frames."""
TIME = (
    rf"(?P<hour>\d\d?):?(?P<minute>[0-5]\d):?(?P<whole>[0-5]\d){FRACTION}\s*(?P<half>[AaPp][Mm])?"
    r"\s*(?P<zone>Z|[+-]\d\d(?::?\d\d)?)?"
)
# Spreadsheets leave the hours out.
MINUTES = r"(?P<minute>[0-5]?\d):(?P<whole>[0-5]\d)[.,](?P<fraction>\d+)"
CLOCKS = [
    *(re.compile(date + TIME) for date in (f"{YEAR_FIRST}(?:T|\\s+)", f"{YEAR_LAST}(?:T|\\s+)", "")),
    re.compile(MINUTES),
]
HOUR, DAY = timedelta(hours=1), timedelta(days=1)
MICROSECOND = timedelta(microseconds=1)
SLASHED = re.compile(r"(\d\d?)/(\d\d?)/(\d{4})")


def as_seconds(path: Path, lines: list[str], first: int, delimiter: str, clock: int) -> list[str] | None:
    """The lines, from `first` on with seconds since the first date or time of day in column `clock`.

    None where it has none. Times of day may pass midnight, those without hours the hour. Raises `InputError` for a date
    or a time that is none.
    """
    begin = last = None
    counted, is_day_first = list(lines), False
    for k in range(first, len(lines)):
        cells, cell = _cells(lines[k], delimiter, clock)
        if begin is None and SLASHED.match(cell):
            is_day_first = _is_day_first(_cells(line, delimiter, clock)[1] for line in lines[k:])
        if not DATE_OR_TIME.match(cell):
            if begin is None and cell:
                return None
            continue
        at = _when(cell, last, is_day_first=is_day_first)
        if at is None:
            raise InputError(
                f"{path}:{k + 1}: time is {cell[:40]!r}, expected a date and time, a time of day, or seconds"
            )
        begin, last = at if begin is None else begin, at
        cells[clock] = repr((at - begin) / MICROSECOND / 1e6)
        counted[k] = delimiter.join(cells)
    return None if begin is None else counted


def _cells(line: str, delimiter: str, clock: int) -> tuple[list[str], str]:
    """Of a line, and that of the clock."""
    cells = line.split(delimiter)
    return cells, cells[clock].strip(' "') if clock < len(cells) else ""


def _is_day_first(cells: Iterable[str]) -> bool:
    """Whether days come before months where slashes part them: if only so all are dates, or they are of fewer days.

    Where neither tells months are first, as in the USA.
    """
    dates = {match.groups() for cell in cells if (match := SLASHED.match(cell))}
    spans = {}
    for is_day_first in (False, True):
        try:
            days = [_slashed(int(a), int(b), int(year), is_day_first=is_day_first) for a, b, year in dates]
        except ValueError:
            continue
        spans[is_day_first] = max(days) - min(days)
    return bool(spans) and min(spans, key=lambda order: spans[order])


def _slashed(first: int, second: int, year: int, *, is_day_first: bool) -> datetime:
    """Raises `ValueError` where that is no date."""
    return datetime(year, second, first) if is_day_first else datetime(year, first, second)


def _when(cell: str, last: datetime | None, *, is_day_first: bool) -> datetime | None:
    """In universal time where the zone is said; of a time of day, after `last`; None where it is neither."""
    said = next((match.groupdict() for pattern in CLOCKS if (match := pattern.fullmatch(cell))), None)
    if said is None:
        return None
    try:
        day = _date(said, is_day_first=is_day_first)
        hour = int(said.get("hour") or 0)
        if half := said.get("half"):
            hour = hour % 12 + 12 * (half.lower() == "pm")
        at = day.replace(
            hour=hour, minute=int(said["minute"]), second=int(said["whole"]),
            microsecond=int((said["fraction"] or "0")[:6].ljust(6, "0")),
        )  # fmt: skip
    except ValueError:
        return None
    if "year" not in said and last is not None:
        # More than half a day back is past midnight; what is less is left to whoever looks at the order.
        turn = DAY if "hour" in said else HOUR
        at += turn * max(0, round((last - at) / turn))
    return at - _zone(said.get("zone"))


def _date(said: dict[str, str | None], *, is_day_first: bool) -> datetime:
    """Midnight of it; points and hyphens part days from months, slashes whichever comes first."""
    if "year" not in said:
        return datetime(1970, 1, 1)
    year = int(said["year"] or 0)
    if "month" in said:
        return datetime(year, int(said["month"] or 0), int(said["day"] or 0))
    first, second = int(said["first"] or 0), int(said["second"] or 0)
    return _slashed(first, second, year, is_day_first=is_day_first or said["by"] != "/")


def _zone(said: str | None) -> timedelta:
    """How far it is ahead of universal time."""
    if said is None or said == "Z":
        return timedelta()
    digits = said[1:].replace(":", "").ljust(4, "0")
    ahead = timedelta(hours=int(digits[:2]), minutes=int(digits[2:]))
    return ahead if said[0] == "+" else -ahead
