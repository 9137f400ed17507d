"""Calibration boards: drawn, and found in a picture.

A ChArUco board may be seen in part, a chess board only whole.
"""

from __future__ import annotations

import difflib
from dataclasses import dataclass
from typing import Literal

import cv2
import numpy as np

from pytracker._core import InputError
from pytracker.formats.video import Image
from pytracker.rotation import Array

__all__ = ["Board", "BoardKind", "find_corners"]

BoardKind = Literal["charuco", "chess"]
MARKER_SHARE = 0.75
DICTIONARIES = sorted(name.removeprefix("DICT_") for name in dir(cv2.aruco) if name.startswith("DICT_"))
"""Of markers, as OpenCV names them."""
LEAST_CORNERS = 6
PX_PER_SQUARE = 120
MOST_SQUARES = 20


@dataclass(frozen=True)
class Board:
    """A flat board of squares.

    Attributes:
        kind: `charuco` or `chess`.
        squares: columns, rows.
        square_m: side of a square, m.
        dictionary: of a ChArUco board's markers, one of `DICTIONARIES`.
        is_inverted: whether it is white on black.
    """

    kind: BoardKind
    squares: tuple[int, int]
    square_m: float
    dictionary: str = "5X5_250"
    is_inverted: bool = False

    def __post_init__(self) -> None:
        if not all(3 <= count <= MOST_SQUARES for count in self.squares) or not 0.002 <= self.square_m <= 0.5:
            raise InputError(
                f"the board has {self.squares[0]} x {self.squares[1]} squares of {1000 * self.square_m:g} mm, expected "
                f"3 to {MOST_SQUARES} each way, of 2 to 500 mm"
            )

        if self.dictionary not in DICTIONARIES:
            near = difflib.get_close_matches(self.dictionary, DICTIONARIES, n=1, cutoff=0.3)
            known = f"did you mean {near[0]!r}?" if near else f"expected one of: {', '.join(DICTIONARIES)}"
            raise InputError(f"the board's dictionary is {self.dictionary!r}, {known}")

    @property
    def charuco(self) -> cv2.aruco.CharucoBoard:
        """As OpenCV knows it."""
        dictionary = cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, f"DICT_{self.dictionary}"))
        return cv2.aruco.CharucoBoard(self.squares, self.square_m, MARKER_SHARE * self.square_m, dictionary)

    def drawn(self) -> Image:
        """In grey, `PX_PER_SQUARE` a square."""
        columns, rows = self.squares
        if self.kind == "charuco":
            return np.asarray(self.charuco.generateImage((columns * PX_PER_SQUARE, rows * PX_PER_SQUARE)), np.uint8)
        dark = (np.add.outer(np.arange(rows), np.arange(columns)) % 2 == 0).astype(np.uint8)
        return np.asarray(np.kron(255 * (1 - dark), np.ones((PX_PER_SQUARE, PX_PER_SQUARE))), np.uint8)


def find_corners(board: Board, image: Image) -> tuple[Array, Array] | None:
    """Inner corners on the board `(N, 3)`, m, and in the picture `(N, 2)`, px; None where too few are seen."""
    grey = cv2.cvtColor(image, cv2.COLOR_BGR2GRAY) if image.ndim == 3 else image
    grey = cv2.bitwise_not(grey) if board.is_inverted else grey
    if board.kind == "charuco":
        corners, ids, *_ = cv2.aruco.CharucoDetector(board.charuco).detectBoard(grey)
        if ids is None or len(ids) < LEAST_CORNERS:
            return None
        on_board = np.asarray(board.charuco.getChessboardCorners(), dtype=np.float64)[np.asarray(ids).ravel()]
        return on_board, np.asarray(corners, dtype=np.float64).reshape(-1, 2)
    inner = (board.squares[0] - 1, board.squares[1] - 1)
    found, corners = cv2.findChessboardCornersSB(grey, inner)
    if not found:
        return None
    rows, columns = np.mgrid[1 : inner[1] + 1, 1 : inner[0] + 1]
    on_board = board.square_m * np.stack([columns, rows, np.zeros_like(rows)], axis=-1).reshape(-1, 3)
    return on_board.astype(np.float64), np.asarray(corners, dtype=np.float64).reshape(-1, 2)
