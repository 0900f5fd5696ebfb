"""Arrays for torch, JAX and CuPy, without copies."""

from __future__ import annotations

import ctypes
from typing import Any

import numpy
from numpy.typing import NDArray


class Shared:
    """An array of this package for `torch.from_dlpack` and the like: they share its memory, which stays alive as long as the
    tensor.

    numpy before 2.1 exports no read-only array, and torch has no read-only tensors. The tensor can be written to, and must
    not be: it is the memory of the mesh or the picture.
    """

    def __init__(self, array: NDArray[Any]) -> None:
        # Rows may be at any distance, also backwards.
        ways = (
            [(sides - 1) * stride for sides, stride in zip(array.shape, array.strides)] if array.size else []
        )
        low = array.ctypes.data + sum(min(way, 0) for way in ways)
        high = array.ctypes.data + sum(max(way, 0) for way in ways) + array.itemsize
        memory: Any = (ctypes.c_char * (high - low)).from_address(low)
        memory.owner = array  # what keeps the memory alive, as long as an array of it
        self._writable: NDArray[Any] = numpy.ndarray(
            array.shape, array.dtype, memory, array.ctypes.data - low, array.strides
        )

    def __dlpack__(self, **options: Any) -> Any:
        return self._writable.__dlpack__(**options)

    def __dlpack_device__(self) -> tuple[int, int]:
        kind, number = self._writable.__dlpack_device__()
        return int(kind), int(number)


def shared(array: NDArray[Any]) -> Shared:
    """`torch.from_dlpack(fvv.interop.shared(mesh.positions))`: a tensor that shares the memory. See `Shared`."""
    return Shared(array)
