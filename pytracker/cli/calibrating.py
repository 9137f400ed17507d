"""Commands about cameras: `board`, `calibrate camera`, `calibrate pose`, `calibrate level`, `calibrate export`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import numpy as np
import typer

import pytracker as pt
from pytracker._core import check_camera
from pytracker.cli.options import Force, Quiet, check_new, say
from pytracker.cli.terminal import frames_bar
from pytracker.evidence.boards import Board, BoardKind
from pytracker.formats.calibration import read_calibration, size_of
from pytracker.formats.calibration_write import calibration_text, with_pose
from pytracker.formats.points import read_points
from pytracker.formats.toml_file import parse_toml
from pytracker.output import write_whole
from pytracker.setup.calibrate import Intrinsics, calibrate_camera, find_pose, pose_by_level

__all__ = ["commands"]

calibrate = typer.Typer(help="Find a camera's intrinsics, and where it stands.", no_args_is_help=True)
commands = typer.Typer()
commands.add_typer(calibrate, name="calibrate")

Kind = Annotated[BoardKind, typer.Option("--board", help="charuco (may be seen in part) or chess (only whole).")]
Squares = Annotated[str, typer.Option(help="Columns x rows of squares.", metavar="7x5")]
Dictionary = Annotated[str, typer.Option(help="Of a ChArUco board's markers, as OpenCV names them.")]
Inverted = Annotated[bool, typer.Option("--inverted", help="A board that is white on black.")]
SquareMm = Annotated[float, typer.Option("--square-mm", help="Side of a square as measured, mm.")]
FEW_PX = 3.0
BY_LEVEL = {"rotation_sd_deg": 2.0, "distance_sd_m": 0.05, "shoulder_sd_m": 0.05}
"""How well a telephone's level and a tape tell where a camera stands, and a picture where a shoulder's joint is."""
POSE_KEYS = ("rotation", "translation_m")
CAMERA_KEYS = ("matrix", "distortion", *POSE_KEYS)


def _size(words: str, option: str, most: int, example: str) -> tuple[int, int]:
    parts = words.lower().split("x")
    is_number = [part.isascii() and part.isdigit() and len(part) < 6 and 1 <= int(part) <= most for part in parts]
    if is_number != [True, True]:
        raise pt.InputError(f"{option} is {words!r}, expected {example}")
    return int(parts[0]), int(parts[1])


def _board(
    kind: BoardKind, squares: str, square_mm: float, dictionary: str = "5X5_250", *, inverted: bool = False
) -> Board:
    size = _size(squares, "--squares", 999, "columns and rows such as 7x5")
    return Board(kind, size, square_mm / 1000, dictionary.upper().removeprefix("DICT_"), inverted)


@commands.command()
def board(
    out: Annotated[Path, typer.Argument(help="PDF to write.")] = Path("board.pdf"),
    kind: Kind = "charuco",
    squares: Squares = "7x5",
    square_mm: SquareMm = 35.0,
    force: Force = False,
) -> None:
    """Write a calibration board as a PDF in true size."""
    check_new(out, ".pdf", force=force)
    from pytracker.report.board import write_board  # noqa: PLC0415 - Matplotlib is slow

    write_board(_board(kind, squares, square_mm), out, force=force)
    print(f"wrote {out}: print in true size on stiff paper, and measure a square")


@calibrate.command("camera")
def camera(
    video: Annotated[Path, typer.Argument(help="A video in which the board is moved about.")],
    kind: Kind = "charuco",
    squares: Squares = "7x5",
    square_mm: SquareMm = 35.0,
    dictionary: Dictionary = "5X5_250",
    inverted: Inverted = False,
    out: Annotated[Path, typer.Option(help="TOML to write, for `pytracker init --known`.")] = Path("camera.toml"),
    force: Force = False,
    quiet: Quiet = False,
) -> None:
    """Intrinsics from a video of a board: matrix, distortion, and how well they are known."""
    check_new(out, ".toml", force=force)
    with frames_bar(quiet) as progress:
        board = _board(kind, squares, square_mm, dictionary, inverted=inverted)
        found = calibrate_camera(video, board, progress)
    write_whole(out, "\n".join(_lines(found)) + "\n", force=force)
    focal, centre = found.matrix[0, 0], found.matrix[:2, 2]
    say(
        f"focal length {focal:.1f} px ± {100 * found.focal_sd:.2f} %, centre ({centre[0]:.1f}, {centre[1]:.1f}) ± "
        f"{found.centre_sd_px:.1f} px; corners fit to {np.median(found.rms_px):.2f} px in {len(found.frames)} views, "
        f"the worst, frame {found.frames[int(np.argmax(found.rms_px))]}, to {found.rms_px.max():.2f} px",
        quiet,
    )
    print(f"wrote {out}")


def _lines(found: Intrinsics) -> list[str]:
    return [
        f"# {len(found.frames)} views, corners fit to {np.median(found.rms_px):.2f} px",
        f"size_px = {list(found.size)}",
        f"matrix = {np.round(found.matrix, 3).tolist()}",
        f"distortion = {np.round(found.distortion, 6).tolist()}",
        f"focal_sd = {found.focal_sd:.5f}",
    ]


@calibrate.command("pose")
def pose(
    points: Annotated[Path, typer.Argument(help="CSV with columns x_m, y_m, z_m, u, v: places in the world, pixels.")],
    known: Annotated[
        Path, typer.Argument(help="TOML with matrix and distortion; rotation and translation_m are added.")
    ],
    quiet: Quiet = False,
) -> None:
    """Where the camera stands, from four or more points of the world that it sees; into the TOML file."""
    given = _intrinsics(known)
    world, pixels = read_points(points)
    found = find_pose(np.array(given.matrix), np.array(given.distortion), world, pixels)
    at = -found.rotation.T @ found.translation_m
    say(f"the camera is at ({at[0]:.3f}, {at[1]:.3f}, {at[2]:.3f}) m; points fit to {found.rms_px:.2f} px", quiet)
    if found.rms_px > FEW_PX:
        raise pt.InputError(
            f"{points}: the points fit to {found.rms_px:.1f} px only, expected {FEW_PX:g}: is one of them mistaken?"
        )
    write_whole(known, with_pose(known, found.rotation, found.translation_m))
    print(f"wrote rotation and translation_m into {known}")


@calibrate.command("level")
def level(
    known: Annotated[Path, typer.Argument(help="TOML with matrix and distortion; the pose is added.")],
    shoulder: Annotated[str, typer.Option(help="The shoulder's joint in the first frame, px.", metavar="U,V")],
    distance_m: Annotated[float, typer.Option("--distance-m", help="From the lens to that shoulder, m.", min=0.2)],
    down_deg: Annotated[
        float, typer.Option("--down-deg", help="By how much the camera looks down, °.", min=-80, max=80)
    ],
    roll_deg: Annotated[
        float, typer.Option("--roll-deg", help="By how much it is turned clockwise, °.", min=-180, max=180)
    ] = 0.0,
    quiet: Quiet = False,
) -> None:
    """Where the camera stands, by tape and level, from the shoulder: no place of the room need be measured."""
    given = _intrinsics(known)
    found = pose_by_level(given, _pixel(shoulder), distance_m, down_deg, roll_deg)
    at = -found.rotation.T @ found.translation_m
    say(
        f"the camera is at ({at[0]:.3f}, {at[1]:.3f}, {at[2]:.3f}) m from the shoulder: x to its right, y the way it "
        "looks, z up",
        quiet,
    )
    text = with_pose(known, found.rotation, found.translation_m, shoulder_m=[0.0, 0.0, 0.0], **BY_LEVEL)
    write_whole(known, text)
    print(f"wrote rotation, translation_m, shoulder_m and how well they are known into {known}")


def _intrinsics(known: Path) -> pt.Camera:
    """A camera whose pose is not known yet."""
    data = parse_toml(known)
    if "matrix" not in data:
        raise pt.InputError(f"{known}: has no matrix, expected one: pytracker calibrate camera")
    camera = pt.Camera(**{key: data[key] for key in ("matrix", "distortion") if key in data})
    try:
        check_camera(camera)
    except (pt.InputError, TypeError, ValueError) as error:
        raise pt.InputError(f"{known}: {error}") from None
    return camera


def _pixel(words: str) -> np.ndarray:
    try:
        pixel = np.array([float(word) for word in words.split(",")])
    except ValueError:
        pixel = np.empty(0)
    if pixel.shape != (2,) or not np.isfinite(pixel).all():
        raise pt.InputError(f"--shoulder is {words!r}, expected a pixel such as 312,180: pytracker frame")
    return pixel


@calibrate.command("export")
def export(
    known: Annotated[Path, typer.Argument(help="TOML with matrix and what else is known of the camera.")],
    out: Annotated[Path, typer.Argument(help=".toml for Pose2Sim and AniPose, .yml for OpenCV.")],
    size: Annotated[
        str | None, typer.Option(help="Width x height of its pictures, px, where it does not say.", metavar="1920x1080")
    ] = None,
    name: Annotated[str, typer.Option(help="What the camera is called there.")] = "cam_01",
    camera: Annotated[str | None, typer.Option(help="Which of several cameras of the file.")] = None,
    force: Force = False,
) -> None:
    """Write a camera as others read it: Pose2Sim's and AniPose's TOML, or OpenCV's YAML."""
    check_new(out, out.suffix.lower(), force=force)
    given = read_calibration(known, camera)
    size_px = size_of(known, given)
    if size is not None:
        asked = _size(size, "--size", 99999, "width and height such as 1920x1080")
        if size_px not in (None, asked):
            raise pt.InputError(f"{known}: is of pictures of {size_px[0]} x {size_px[1]} px, and --size is {size}")
        size_px = asked
    if size_px is None:
        raise pt.InputError(f"{known}: does not say how large its pictures are, expected size_px, or --size 1920x1080")
    text = calibration_text(out, given, size_px, name)
    try:
        check_camera(pt.Camera(**{key: given[key] for key in CAMERA_KEYS if key in given}))
    except pt.InputError as error:
        raise pt.InputError(f"{known}: {error}") from None
    write_whole(out, text, force=force)
    print(f"wrote {out}")
