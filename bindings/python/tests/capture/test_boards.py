"""Boards and their corners in pictures that are generated, whose truth is known."""

import pathlib
import sys

import numpy
import pytest

cv2 = pytest.importorskip("cv2")

sys.path.insert(0, str(pathlib.Path(__file__).parent))

import room  # noqa: E402
from fvv.errors import UsageError  # noqa: E402
from fvv_capture.calibrate import Board  # noqa: E402
from fvv_capture.calibrate.boards import parse_board, refine  # noqa: E402


@pytest.mark.parametrize("rows, legacy", [(5, False), (6, False), (5, True), (6, True)])
def test_board_is_found_where_it_is_drawn(rows, legacy):
    board = Board(9, rows, 0.12, 0.09, "4X4_100", legacy)
    drawn = board.picture(40)
    if tuple(int(one) for one in cv2.__version__.split(".")[:2]) >= (4, 10):
        words = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_4X4_100)
        theirs = cv2.aruco.CharucoBoard((9, rows), 0.12, 0.09, words)
        theirs.setLegacyPattern(legacy)
        assert (drawn == theirs.generateImage((360, 40 * rows), marginSize=0, borderBits=1)).all()
    found = board.detect(numpy.pad(drawn, 60, constant_values=255))
    assert len(found.ids) == 8 * (rows - 1)
    # Edges without a grey between black and white are no more certain than that.
    assert found.pixels - 60 == pytest.approx(board.points[found.ids][:, :2] / 0.12 * 40, abs=0.2)


def test_a_marker_that_is_seen_twice_is_not_believed():
    board = Board(9, 6, 0.12, 0.09, "4X4_100")
    page = numpy.pad(board.picture(40), 60, constant_values=255)
    before = board.detect(page)
    page[8:48, 300:340] = page[60:100, 100:140]  # the first marker
    assert set(before.ids) - set(board.detect(page).ids) == {0, 1}  # the corners beside it


def test_chessboard_is_not_turned_round():
    board = Board(8, 5, 0.1)
    assert not board.ambiguous and Board(8, 6, 0.1).ambiguous
    generator = numpy.random.default_rng(4)
    camera = room.look((0, 0, 2), (0, 0, 0), 640, (640, 480))
    for angle in (0.1, 1.4, 3.0, 4.4):
        facing = camera.R.T @ cv2.Rodrigues(numpy.array([0, 0, angle]))[0]
        pose = (facing, -facing @ [0.4, 0.25, 0])
        found = board.detect(room.render(camera, [room.board_rectangle(board, pose, margin=1)], generator))
        true = camera.project(board.points @ facing.T + pose[1])
        assert found is not None
        assert numpy.linalg.norm(found.pixels - true[found.ids], axis=1).max() < 0.3


@pytest.mark.parametrize(
    "size, square, marker, dictionary, message",
    [
        ("8", 0.1, None, None, "expected COLUMNSxROWS"),
        ("2x6", 0.1, None, None, "expected 3x3 squares or more, found 2x6"),
        ("8x6", 0.0, None, None, "square: expected metres"),
        ("8x6", 0.1, 0.2, "4x4_50", "marker: expected metres between 0"),
        ("8x6", 0.1, 0.05, None, "a chessboard has none"),
        ("8x6", 0.1, None, "9x9_1", "dictionary: expected one of"),
        ("20x20", 0.1, None, "4x4_50", "has 50 markers, expected 200"),
    ],
)
def test_boards_that_are_none(size, square, marker, dictionary, message):
    with pytest.raises(UsageError, match=message):
        parse_board(size, square, marker, dictionary)


def test_corners_outside_the_straightened_picture_are_kept():
    """Most corners agree on a plane; one that was taken for another is far outside of what is straightened by it."""
    board = Board(9, 6, 0.12)
    grey = numpy.pad(board.picture(40), 40, constant_values=255)
    points = board.points / board.square
    corners = 40 * points[:, :2] + 39.5
    wrong = corners.copy()
    wrong[0] += [4000, 3000]
    found = refine(grey, points, wrong)
    assert found[0] == pytest.approx(wrong[0], abs=0.01)
    assert numpy.abs(found[1:] - corners[1:]).max() < 0.2
