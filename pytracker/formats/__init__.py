"""One file a format: readers that name file, line, value and expectation, and writers."""

from __future__ import annotations

from pytracker.formats.amc import Motion, read_amc, write_amc
from pytracker.formats.asf import read_asf
from pytracker.formats.asf_write import write_asf

__all__ = ["Motion", "read_amc", "read_asf", "write_amc", "write_asf"]
