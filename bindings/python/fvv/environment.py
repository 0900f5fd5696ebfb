"""The static environment around the action: meshes with pictures, and lights."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy
from numpy.typing import NDArray

from ._core import Mesh

LIGHT_TYPES = {0: "directional", 1: "point", 2: "spot"}
Triple = tuple[float, float, float]


@dataclasses.dataclass(frozen=True)
class EnvironmentPart:
    """One mesh of an environment, in one colour or with one picture."""

    mesh: Mesh  #: On the lattice of the environment; its `uvs` run from 0 to 1 over a rectangle: use the part's.
    picture: int | None  #: Index in `Environment.pictures`.
    colour: Triple  #: Red, green, blue, linear light, 0 to 1; a factor of the picture's.
    unlit: bool  #: The colours are shown as they are, without lights.
    double_sided: bool  #: Both sides of its faces are seen.
    clamped: bool  #: Beyond its edge the picture goes on with its last pixel; otherwise it repeats.
    _origin: tuple[float, float]
    _size: tuple[float, float]

    @property
    def uvs(self) -> NDArray[numpy.float64] | None:
        """(vertices, 2) places in the picture: (0, 0) is its top left corner, (1, 1) its bottom right one. None: not sent."""
        if self.mesh.uvs is None:
            return None
        places: NDArray[numpy.float64] = self._origin + numpy.multiply(
            self._size, self.mesh.uvs, dtype=numpy.float64
        )
        return places


@dataclasses.dataclass(frozen=True)
class Light:
    """A light as in KHR_lights_punctual of glTF. What a type does not use is 0."""

    kind: str  #: "directional", "point" or "spot".
    casts_shadows: bool  #: In players that draw shadows.
    position: Triple  #: Metres, axes of the world.
    direction: Triple  #: Of unit length, in which the light travels.
    colour: Triple  #: Red, green, blue, linear light, 0 to 1.
    intensity: float  #: Lux of directional lights, candela of others.
    range: float  #: Metres; 0: no end.
    inner_cone: float  #: Radians from `direction`.
    outer_cone: float  #: Radians.


@dataclasses.dataclass(frozen=True)
class Environment:
    """The environment at a time of a clip. It stays valid after the clip is closed."""

    parts: tuple[EnvironmentPart, ...]  #: They are drawn together.
    pictures: tuple[bytes, ...]  #: Files, JPEG or PNG, sRGB.
    lights: tuple[Light, ...]  #: For players that light or draw shadows.

    @classmethod
    def _of(cls, raw: tuple[Any, Any, Any]) -> Environment:
        parts, pictures, lights = raw
        return cls(
            tuple(EnvironmentPart(*part) for part in parts),
            tuple(pictures),
            tuple(Light(LIGHT_TYPES.get(kind, str(kind)), *rest) for kind, *rest in lights),
        )
