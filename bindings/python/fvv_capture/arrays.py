"""Names for what arrays are. OpenCV's types tell integers from floats and no more, so these do not say dtypes to checkers."""

from __future__ import annotations

from typing import Any

from numpy.typing import NDArray

Picture = NDArray[Any]  #: (height, width, 3) uint8 RGB.
Mask = NDArray[Any]  #: (height, width) uint8, 255 inside.
Flags = NDArray[Any]  #: (height, width) bool.
Floats = NDArray[Any]  #: float32.
