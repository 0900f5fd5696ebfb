"""Calibration of cameras by a board that is carried through the volume: lenses, poses, the world's axes, cameras that move."""

from .boards import Board, Corners
from .calibration import Calibration, Options, calibrate
from .files import read_calibration, write_calibration
from .lenses import Lens
from .moving import track

__all__ = [
    "Board",
    "Calibration",
    "Corners",
    "Lens",
    "Options",
    "calibrate",
    "read_calibration",
    "track",
    "write_calibration",
]
