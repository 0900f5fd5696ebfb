"""Boards of known size, and the corners that a picture shows of them."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy
from fvv.errors import UsageError
from fvv.interop.optional_import import optional_import
from numpy.typing import NDArray

Floats = NDArray[numpy.float64]
Bytes = NDArray[numpy.uint8]

cv2: Any = optional_import("cv2", "capture")

#: Corners of a view below which a pose from a plane is not reliable.
FEWEST_CORNERS = 6

#: Least and largest side of a square, in pixels, in a picture that is straightened for its corners; and the part of a square from a
#: corner to its window's edge is 1 / WINDOW.
SIDES = (12.0, 64.0)
WINDOW = 4.5


@dataclasses.dataclass(frozen=True)
class Corners:
    """The corners of a board that one picture shows."""

    ids: NDArray[numpy.int64]  #: (corners,) indices into `Board.points`.
    pixels: Floats  #: (corners, 2); the centre of the top left pixel is (0.5, 0.5).


@dataclasses.dataclass(frozen=True)
class Board:
    """A ChArUco board, or a plain chessboard if `dictionary` is None."""

    columns: int  #: Squares in a row.
    rows: int
    square: float  #: Metres.
    marker: float = 0.0  #: Metres; not of a chessboard.
    dictionary: str | None = None  #: As OpenCV names them, without DICT_: "4X4_100".
    legacy: bool = (
        False  #: The pattern of OpenCV before 4.6: with an even number of rows it begins with a marker.
    )

    def __post_init__(self) -> None:
        if self.columns < 3 or self.rows < 3:
            raise UsageError(f"board: expected 3x3 squares or more, found {self.columns}x{self.rows}")
        if not 0 < self.square < 100:
            raise UsageError(f"square: expected metres between 0 and 100, found {self.square}")
        if self.dictionary is None:
            return
        if not 0 < self.marker < self.square:
            raise UsageError(
                f"marker: expected metres between 0 and the square's {self.square}, found {self.marker}"
            )
        markers = (self.columns * self.rows) // 2
        found = len(self._words().bytesList)
        if found < markers:
            raise UsageError(
                f"dictionary {self.dictionary}: has {found} markers, expected {markers} for {self.columns}x{self.rows} squares"
            )

    @property
    def points(self) -> Floats:
        """(corners, 3) metres in the board's axes: x along a row, y along a column, z away from who looks at it, 0 on
        the board. Only inner corners, row by row."""
        x, y = numpy.meshgrid(numpy.arange(1, self.columns), numpy.arange(1, self.rows))
        places = numpy.stack([x, y, numpy.zeros_like(x)], axis=-1).reshape(-1, 3)
        out: Floats = self.square * places.astype(numpy.float64)
        return out

    def picture(self, pixels_per_square: int) -> Bytes:
        """(rows, columns) times pixels_per_square, grey: the board as it is printed, without a margin."""
        y, x = (
            numpy.indices((self.rows * pixels_per_square, self.columns * pixels_per_square))
            // pixels_per_square
        )
        drawn = numpy.where((x + y) % 2 == self._first_black, 0, 255).astype(numpy.uint8)
        if self.dictionary is None:
            return drawn
        # In the middle to the pixel: how far a corner is from the markers beside it moves what cameras see of it.
        margin = round((1 - self.marker / self.square) / 2 * pixels_per_square)
        side = pixels_per_square - 2 * margin
        for word, (x, y) in enumerate(self._white_squares() * pixels_per_square + margin):
            drawn[y : y + side, x : x + side] = cv2.aruco.generateImageMarker(self._words(), word, side)
        return drawn

    def detect(self, grey: Bytes) -> Corners | None:
        """The corners of the board in a picture; None if there are fewer than FEWEST_CORNERS. grey: (height, width).

        ChArUco: a corner is where the homography of the two markers beside it has it, then refined to a part of a pixel.
        cv2.aruco.CharucoDetector does the same, but crashes with parameters in OpenCV 4.7. Chessboard: the sector-based
        detector of Duda and Frese (2018), which refines them as well; all corners must be seen."""
        if self.dictionary is None:
            return self._detect_chessboard(grey)
        places, outlines = self._detect_markers(grey)
        points = self.points / self.square
        ids, corners = [], []
        for corner, point in enumerate(points[:, :2]):
            beside = (numpy.abs(places.mean(axis=1) - point) < 1).all(axis=1)
            if beside.sum() < 2:
                continue
            to_picture, _ = cv2.findHomography(places[beside].reshape(-1, 2), outlines[beside].reshape(-1, 2))
            if to_picture is None:
                continue
            ids.append(corner)
            corners.append(cv2.perspectiveTransform(point.reshape(1, 1, 2), to_picture).reshape(2))
        if len(ids) < FEWEST_CORNERS:
            return None
        pixels = refine(grey, points[ids], numpy.array(corners))
        found = Corners(numpy.array(ids), pixels + 0.5)
        return found if _spans_plane(self.points[found.ids]) else None

    def _detect_markers(self, grey: Bytes) -> tuple[Floats, Floats]:
        """(markers, 4, 2) in squares on the board, and pixels in the picture, the centre of the top left pixel at 0."""
        detector = cv2.aruco.ArucoDetector(self._words(), _detection(grey.shape))
        outlines, found, _ = detector.detectMarkers(grey)
        ids = numpy.zeros(0, int) if found is None else found.reshape(-1)
        white = self._white_squares() + 0.5
        half = self.marker / self.square / 2
        around = half * numpy.array([[-1, -1], [1, -1], [1, 1], [-1, 1]])
        places, pixels = [], []
        for word in sorted(set(ids[ids < len(white)])):
            # One for each threshold, or a reflection too.
            seen = numpy.array([outlines[i] for i in numpy.flatnonzero(ids == word)], numpy.float64)
            seen = seen.reshape(-1, 4, 2)
            outline = numpy.median(seen, axis=0)
            side = numpy.linalg.norm(outline[1] - outline[0])
            if numpy.abs(seen - outline).max() < 0.25 * side:
                places.append(white[word] + around)
                pixels.append(outline)
        shape = (-1, 4, 2)
        return numpy.array(places).reshape(shape), numpy.array(pixels).reshape(shape)

    def _detect_chessboard(self, grey: Bytes) -> Corners | None:
        found, corners = cv2.findChessboardCornersSB(
            grey, (self.columns - 1, self.rows - 1), flags=cv2.CALIB_CB_NORMALIZE_IMAGE
        )
        if not found:
            return None
        pixels = corners.reshape(-1, 2).astype(float)
        # The detector may begin at either end. The square right of and below the first corner is black if it began at ours.
        across = self.columns - 1
        square = pixels[[0, 1, across, across + 1]]
        middle = numpy.rint(square.mean(axis=0)).astype(int)
        others = [numpy.rint(square.mean(axis=0) + one - square[0]).astype(int) for one in square[1:3]]
        height, width = grey.shape
        light = [
            float(grey[min(max(y, 0), height - 1), min(max(x, 0), width - 1)]) for x, y in [middle, *others]
        ]
        if light[0] > sum(light[1:]) / 2:
            pixels = pixels[::-1]
        return Corners(numpy.arange(len(pixels)), pixels + 0.5)

    @property
    def ambiguous(self) -> bool:
        """Half a turn of the board gives the same picture: cameras on different sides may disagree on its first corner."""
        return self.dictionary is None and (self.columns + self.rows) % 2 == 0

    def _words(self) -> Any:
        name = f"DICT_{self.dictionary}"
        if not hasattr(cv2.aruco, name):
            known = ", ".join(
                sorted(one[5:].lower() for one in dir(cv2.aruco) if one.startswith("DICT_") and "X" in one)
            )
            raise UsageError(f"dictionary: expected one of {known}, found {self.dictionary}")
        return cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, name))

    @property
    def _first_black(self) -> int:
        """Of the first row: 1 in the legacy pattern of an even number of rows, which begins with a marker."""
        return int(self.legacy and self.rows % 2 == 0)

    def _white_squares(self) -> NDArray[numpy.int64]:
        """(squares, 2) columns and rows, in the order of their markers."""
        y, x = numpy.indices((self.rows, self.columns))
        white: NDArray[numpy.int64] = numpy.stack([x, y], axis=-1)[(x + y) % 2 != self._first_black]
        return white


def parse_board(
    size: str, square: float, marker: float | None, dictionary: str | None, legacy: bool = False
) -> Board:
    """size: COLUMNSxROWS, in squares. dictionary: such as 4x4_100; None: a chessboard. marker None: three quarters of the
    square. `UsageError` for what is no board."""
    parts = size.lower().split("x")
    if len(parts) != 2 or not all(part.isdigit() for part in parts):
        raise UsageError(f"board: expected COLUMNSxROWS in squares, such as 8x6, found {size}")
    columns, rows = map(int, parts)
    if dictionary is None:
        if marker is not None:
            raise UsageError("marker: a chessboard has none; a ChArUco board needs --dictionary")
        return Board(columns, rows, square)
    return Board(
        columns,
        rows,
        square,
        0.75 * square if marker is None else marker,
        dictionary.upper().replace("DICT_", ""),
        legacy,
    )


def refine(grey: Bytes, points: Floats, corners: NDArray[Any]) -> Floats:
    """Corners to a part of a pixel. points: (corners, 3) on the board, in squares; corners: (corners, 2), the centre of the top
    left pixel at 0; so is the result.

    The gradients near a corner of a chessboard are orthogonal to the way from there (cv2.cornerSubPix, after Foerstner). The
    window is a square on the board, not in the picture: of a slanted board, a square window that has no other corner in it is
    too small for an exact answer. So the picture is straightened by the homography from the board, and its corners are taken back."""
    corners = corners.astype(numpy.float64)
    plane = numpy.ascontiguousarray(points[:, :2])
    to_board, _ = cv2.findHomography(corners, plane, cv2.RANSAC, 0.2)
    if to_board is None:
        return corners
    apart = numpy.linalg.norm(corners[:, None] - corners[None], axis=-1)
    squares = numpy.linalg.norm(plane[:, None] - plane[None], axis=-1)
    # Pixels of a square along its longer side: nothing is made smaller.
    side = float(numpy.clip((apart[squares > 0.5] / squares[squares > 0.5]).max(), *SIDES))
    low, high = plane.min(axis=0) - 1, plane.max(axis=0) + 1
    size = tuple(int(one) for one in numpy.ceil(side * (high - low)))
    straight = numpy.array([[side, 0, -side * low[0]], [0, side, -side * low[1]], [0, 0, 1]]) @ to_board
    picture = cv2.warpPerspective(
        grey, straight, size, flags=cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE
    )
    window = max(2, round(side / WINDOW))
    before = cv2.perspectiveTransform(corners.reshape(-1, 1, 2), straight).astype(numpy.float32)
    end = (cv2.TERM_CRITERIA_EPS + cv2.TERM_CRITERIA_MAX_ITER, 60, 1e-4)
    # A corner that the homography does not explain may be outside the straightened picture, where OpenCV refuses to look.
    inside = ((before >= 0) & (before < numpy.array(size))).all(axis=(1, 2))
    after = before.copy()
    if inside.any():
        after[inside] = cv2.cornerSubPix(picture, before[inside], (window, window), (-1, -1), end)
    back = cv2.perspectiveTransform(after.astype(numpy.float64), numpy.linalg.inv(straight)).reshape(-1, 2)
    # A corner that runs away has found another edge.
    kept = numpy.linalg.norm(after - before, axis=-1).reshape(-1, 1) <= window
    return numpy.where(kept, back, corners)


def _detection(shape: tuple[int, ...]) -> Any:
    """Markers of a board far away are a few pixels wide: a small share of the picture's longer side."""
    parameters = cv2.aruco.DetectorParameters()
    parameters.minMarkerPerimeterRate = min(0.03, 40 / max(shape))
    parameters.cornerRefinementMethod = cv2.aruco.CORNER_REFINE_NONE
    # Before OpenCV 4.9 markers that are close to another outline are dropped by more than this.
    parameters.minMarkerDistanceRate = 0.005
    return parameters


def _spans_plane(points: Floats) -> bool:
    """Points in one line have no pose."""
    spread = numpy.linalg.svd(points[:, :2] - points[:, :2].mean(axis=0), compute_uv=False)
    return bool(spread[1] > 0.2 * spread[0])
