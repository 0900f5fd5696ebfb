"""fvv: free-viewpoint video in numpy arrays.

    with fvv.open("players.fvv") as clip:
        for frame in clip:
            print(frame.time, frame.mesh.positions.shape)

    with fvv.Writer("copy.fvv", rate=clip.rate, max_error="1mm") as writer:
        for frame in clip:
            writer.add(frame.mesh)

Lengths are metres, times seconds, pixels have their centres at .5; cameras look along +z with x to the right and y down.
"""

from __future__ import annotations

from . import analysis, interop
from ._core import Camera, Mesh, Picture, Sound, library_version
from .audio import AudioInput
from .clip import Clip, ClipFrame, check
from .comparison import Comparison, compare
from .environment import Environment, EnvironmentPart, Light
from .errors import DamagedError, Error, LimitError, LossWarning, UnsupportedError, UsageError
from .frames import ByCamera, Frame, ReceivedFrame
from .meshes import Decimated, decimate
from .player import Player
from .reader import Configuration, Damage, End, Event, FrameEvent, Reader, SoundEvent
from .records import Check, Description, Limits, Problem, Rung, Texturing, Track
from .sources import Readable, ReadAt
from .view import Rendering, render
from .writer import Writer, mux

__version__ = library_version

__all__ = [
    "AudioInput",
    "ByCamera",
    "Camera",
    "Check",
    "Clip",
    "ClipFrame",
    "Comparison",
    "Configuration",
    "Damage",
    "DamagedError",
    "Decimated",
    "Description",
    "End",
    "Environment",
    "EnvironmentPart",
    "Error",
    "Event",
    "Frame",
    "FrameEvent",
    "Light",
    "LimitError",
    "Limits",
    "LossWarning",
    "Mesh",
    "Picture",
    "Player",
    "Problem",
    "ReadAt",
    "Readable",
    "Reader",
    "ReceivedFrame",
    "Rendering",
    "Rung",
    "Sound",
    "SoundEvent",
    "Texturing",
    "Track",
    "UnsupportedError",
    "UsageError",
    "Writer",
    "analysis",
    "check",
    "compare",
    "decimate",
    "interop",
    "mux",
    "open",
    "render",
]


def open(source: Readable, *, rung: int = 0, limits: Limits | None = None) -> Clip:  # noqa: A001
    """Opens a stream for reading.

    source: a path; a URL of http or https, of which the ranges that are needed are fetched; bytes or another object with the buffer protocol, such as an mmap, which is not copied; a binary file
    object that can seek; or an object with `size` and `read_at(offset, size)`, which is called for the bytes that are needed
    and no others.
    rung: which quality to read, 0 the best; a number beyond the last names the last.
    limits: what to accept of streams that are not trusted.

    Raises OSError where the source cannot be read, and `DamagedError`, `LimitError` or `UnsupportedError`.
    """
    return Clip(source, rung=rung, limits=limits)
