"""One frame of a video with a pixel grid, to choose a patch box without a window."""

from __future__ import annotations

from pathlib import Path

from pytracker._core import InputError
from pytracker.evidence.grid import draw_grid, png_of
from pytracker.formats.toml_file import parse_toml
from pytracker.formats.video import frames, probe
from pytracker.output import whole_file

__all__ = ["write_frame"]


def write_frame(source: Path | str, out: Path, camera: int = 0, number: int = 0, *, force: bool = False) -> None:
    """Write frame `number` of a video, or of camera `camera` of a recording's folder, as PNG, with grid and patch box.

    Of recording.toml nothing but the video needs to be there. Raises `InputError`.
    """
    file, box = _video(Path(source), camera)
    probe(file)
    last = -1
    for frame in frames(file):
        last = frame.index
        if last == number:
            with whole_file(out, force=force) as partial:
                partial.write_bytes(png_of(draw_grid(frame.image, box)))
            return
    raise InputError(f"{file}: has frames 0 to {last}, expected one numbered {number}")


def _video(source: Path, camera: int) -> tuple[Path, tuple[int, int, int, int] | None]:
    if source.is_file():
        return source, None
    path = source / "recording.toml"
    if not path.is_file():
        raise InputError(f"{source}: holds no recording.toml, expected a recording's folder or a video")
    entries = parse_toml(path).get("camera")
    if not isinstance(entries, list) or not entries:
        raise InputError(f"{path}: has no [[camera]], expected one with a video")
    if not 0 <= camera < len(entries):
        raise InputError(f"camera is {camera}, expected 0 to {len(entries) - 1}")
    entry = entries[camera] if isinstance(entries[camera], dict) else {}
    video, box = entry.get("video"), entry.get("patch_box")
    if not isinstance(video, str):
        raise InputError(f"{path}: camera[{camera}].video is missing, expected a file's name")
    is_box = isinstance(box, list) and len(box) == 4 and all(type(value) is int and abs(value) < 2**20 for value in box)
    return source / video, (box[0], box[1], box[2], box[3]) if is_box and isinstance(box, list) else None
