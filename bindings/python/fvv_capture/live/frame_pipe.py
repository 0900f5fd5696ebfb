"""Writes frames to a pipe, as spec/frame-pipe.md has them."""

from __future__ import annotations

import json
import os
import struct
from collections.abc import Mapping
from typing import Any

from fvv.errors import Error

SIGNATURE = b"\x89FVP\r\n\x1a\n"
_RECORD = struct.Struct("<4s3I2qQ")


class PipeClosed(Error):
    """The reader is gone."""


class FramePipe:
    """The writing end of a pipe, by its descriptor."""

    def __init__(self, descriptor: int, description: Mapping[str, Any]) -> None:
        """description: a capture.json."""
        self._descriptor = descriptor
        text = json.dumps(description).encode()
        self._write(SIGNATURE + struct.pack("<2I", 1, len(text)) + text)

    def frame(self, number: int, filmed: int, positions: bytes, faces: bytes, pictures: memoryview) -> None:
        """positions: three float32 a vertex; faces: three uint32 a face; pictures: of all cameras, with their masks. filmed:
        microseconds since 1970; 0: not known."""
        size = len(positions) + len(faces) + pictures.nbytes
        head = _RECORD.pack(b"FRAM", len(positions) // 12, len(faces) // 12, 0, number, filmed, size)
        self._write(head + positions + faces)
        self._write(pictures)

    def lost(self, number: int, reason: str) -> None:
        text = reason.encode()[:4096].decode(errors="ignore").encode()
        self._write(_RECORD.pack(b"LOST", 0, 0, 0, number, 0, len(text)) + text)

    def end(self) -> None:
        self._write(_RECORD.pack(b"ENDS", 0, 0, 0, 0, 0, 0))

    def _write(self, data: bytes | memoryview) -> None:
        rest = memoryview(data)
        try:
            while rest:
                rest = rest[os.write(self._descriptor, rest) :]
        except BrokenPipeError:
            raise PipeClosed("the encoder takes no more frames") from None
