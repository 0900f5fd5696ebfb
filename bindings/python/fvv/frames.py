"""A frame: meshes, cameras, pictures and visibility at one time."""

from __future__ import annotations

import abc
from collections.abc import Iterator, Mapping
from typing import Any, Callable, Generic, TypeVar, Union

import numpy
import numpy.typing

from ._core import Camera, LiveFrame, Mesh, Picture
from .errors import Error, UsageError
from .pictures import on_screen, png, shrunk
from .records import Description

Value = TypeVar("Value")
Key = Union[int, str]
#: In place of a camera's identifier: the picture is an atlas (`FVV_NO_CAMERA`).
ATLAS = 65535
#: Visibility weights, (vertices,).
Weights = numpy.typing.NDArray[numpy.uint8]


class ByCamera(Mapping[Key, Value], Generic[Value]):
    """Values by camera: by identifier or by name. Iteration gives identifiers."""

    def __init__(
        self, description: Description, identifiers: list[int], load: Callable[[int], Value | None]
    ) -> None:
        self._description = description
        self._identifiers = identifiers
        self._load = load
        self._known: dict[int, Value | None] = {}

    def __getitem__(self, key: Key) -> Value:
        identifier = self._description.camera(key)
        if identifier is None or identifier not in self._identifiers:
            raise KeyError(key)
        if identifier not in self._known:
            self._known[identifier] = self._load(identifier)
        value = self._known[identifier]
        if value is None:
            raise KeyError(key)
        return value

    def __contains__(self, key: object) -> bool:
        return self._description.camera(key) in self._identifiers

    def __iter__(self) -> Iterator[Key]:
        return iter(self._identifiers)

    def __len__(self) -> int:
        return len(self._identifiers)

    def __repr__(self) -> str:
        names = ", ".join(str(name or i) for i, name in self._description.cameras if i in self._identifiers)
        return f"<by camera: {names}>"


class Frame(abc.ABC):
    """One time of a stream. Nothing is decoded before it is used; what was used is kept with the frame."""

    def __init__(self) -> None:
        self._meshes: dict[int, Mesh | None] = {}
        self._cameras: ByCamera[Camera] | None = None
        self._pictures: ByCamera[Picture] | None = None

    @property
    @abc.abstractmethod
    def ticks(self) -> int:
        """The time in ticks of the stream's time base."""

    @property
    @abc.abstractmethod
    def number(self) -> int:
        """The frame's number; frames that are lost keep theirs."""

    @property
    @abc.abstractmethod
    def _description(self) -> Description:
        """The configuration that holds for the frame."""

    @abc.abstractmethod
    def _load_mesh(self, track: int) -> Mesh | None: ...

    @abc.abstractmethod
    def _load_cameras(self) -> ByCamera[Camera]: ...

    @abc.abstractmethod
    def _load_pictures(self) -> ByCamera[Picture]: ...

    @abc.abstractmethod
    def _load_atlas(self) -> Picture | None: ...

    @abc.abstractmethod
    def _load_visibility(self, mesh_track: int, camera: int) -> Weights | None: ...

    @property
    def time(self) -> float:
        """The time in seconds."""
        return float(self.ticks * self._description.time_base)

    @property
    def meshes(self) -> dict[int, Mesh]:
        """The meshes by track, of the rung that is read. Tracks without a mesh at this time are left out."""
        for track in self._description.meshes:
            if track not in self._meshes:
                self._meshes[track] = self._load_mesh(track)
        return {track: mesh for track, mesh in self._meshes.items() if mesh is not None}

    @property
    def mesh(self) -> Mesh | None:
        """The mesh of the first mesh track; None: there is none at this time."""
        for track in self._description.meshes[:1]:
            if track not in self._meshes:
                self._meshes[track] = self._load_mesh(track)
            return self._meshes[track]
        return None

    @property
    def cameras(self) -> ByCamera[Camera]:
        """The cameras at this time. A camera that moves and is not calibrated now is left out."""
        if self._cameras is None:
            self._cameras = self._load_cameras()
        return self._cameras

    @property
    def pictures(self) -> ByCamera[Picture]:
        """The pictures of the cameras that the video shows at this time."""
        if self._pictures is None:
            self._pictures = self._load_pictures()
        return self._pictures

    @property
    def atlas(self) -> Picture | None:
        """The picture that the mesh's texture coordinates address; None: the stream has none."""
        return self._load_atlas()

    def visibility(self, camera: Key) -> Weights | None:
        """How much a camera sees around each vertex of `mesh`: uint8 of shape (vertices,), 0 nothing to 255 everything, and
        127 where the surface is turned away from the camera. None: the stream has no weights of this camera. KeyError: the
        stream has no such camera."""
        identifier = self._description.camera(camera)
        if identifier is None:
            raise KeyError(camera)
        for track in self._description.meshes[:1]:
            return self._load_visibility(track, identifier)
        return None

    def _repr_png_(self) -> bytes | None:
        """What notebooks show: the picture of the first camera, else the mesh. None: there is neither, or it is damaged."""
        try:
            for picture in self.pictures.values():
                return png(shrunk(on_screen(picture.whole())))
            drawn = self._draw_mesh()
        except Error:
            return None
        return None if drawn is None else png(drawn)

    def _draw_mesh(self) -> numpy.typing.NDArray[numpy.uint8] | None:
        """The mesh as seen from outside of the scene; None where it cannot be drawn."""
        return None

    def to_trimesh(self) -> Any:
        """A `trimesh.Scene` of the meshes and cameras (`fvv.interop.frame_to_trimesh`)."""
        from .interop import frame_to_trimesh

        return frame_to_trimesh(self)


class ReceivedFrame(Frame):
    """A frame from `fvv.Reader`."""

    def __init__(self, description: Description, received: LiveFrame, has_visibility: bool) -> None:
        super().__init__()
        self._known = description
        self._received = received
        self._has_visibility = has_visibility

    @property
    def _description(self) -> Description:
        return self._known

    @property
    def ticks(self) -> int:
        return self._received.ticks

    @property
    def number(self) -> int:
        return self._received.number

    def _load_mesh(self, track: int) -> Mesh | None:
        return self._received.meshes.get(track)

    def _load_cameras(self) -> ByCamera[Camera]:
        found = self._received.cameras
        known = [i for i, _ in self._description.cameras if found.get(i) is not None]
        return ByCamera(self._description, known, found.get)

    def _load_pictures(self) -> ByCamera[Picture]:
        found = self._received.pictures
        return ByCamera(self._description, [i for i in found if i != ATLAS], found.get)

    def _load_atlas(self) -> Picture | None:
        return self._received.pictures.get(ATLAS)

    def _load_visibility(self, mesh_track: int, camera: int) -> Weights | None:
        if not self._has_visibility:
            raise UsageError("the reader decodes no visibility: pass visibility=True")
        return self._received.visibility(mesh_track, camera)

    def __repr__(self) -> str:
        return f"<fvv frame {self.number} at {self.time:.3f} s>"
