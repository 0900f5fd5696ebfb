"""The objects that a stream names: the key `objects` of META (spec/registry.md)."""

from __future__ import annotations

import dataclasses
import json
import math
from collections.abc import Callable, Sequence
from typing import Any

import numpy
from numpy.typing import ArrayLike, NDArray

Vector = NDArray[numpy.float64]


@dataclasses.dataclass(frozen=True)
class _Object:
    id: int
    name: str
    of: int
    radius: float
    places: dict[int, Vector]


def metadata_of(metadata: Sequence[str], key: str, is_right: Callable[[Any], bool]) -> Any:
    """The value of a key in the first text of META that has it as is_right wants it; None: there is none."""
    for text in metadata:
        try:
            value = json.loads(text)
        except ValueError:
            continue
        if isinstance(value, dict) and is_right(value.get(key)):
            return value[key]
    return None


def _is_count(value: object) -> bool:
    return isinstance(value, int) and not isinstance(value, bool) and value >= 0


def is_number(value: object) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool) and math.isfinite(value)


def _is_path(path: object) -> bool:
    return isinstance(path, list) and all(
        isinstance(run, list)
        and len(run) >= 4
        and len(run) % 3 == 1
        and all(isinstance(x, int) and not isinstance(x, bool) for x in run)
        for run in path
    )


def _is_described(value: Any) -> bool:
    """As spec/registry.md describes the key `objects`."""
    if not isinstance(value, dict) or not _is_count(value.get("step")) or value["step"] == 0:
        return False
    origin: Any = value.get("origin")
    unit: Any = value.get("unit")
    if not isinstance(origin, list) or len(origin) != 3 or not all(map(is_number, origin)):
        return False
    listed: Any = value.get("list")
    touching: Any = value.get("touching")
    splits: Any = value.get("splits")
    lists = (listed, touching, splits)
    if not is_number(unit) or unit <= 0 or not all(isinstance(one, list) for one in lists):
        return False
    if not all(isinstance(one, dict) for rows in lists for one in rows):
        return False
    for one in listed:
        if not _is_count(one.get("id")) or not is_number(one.get("radius")) or one["radius"] <= 0:
            return False
        if not _is_path(one.get("path")) or not isinstance(one.get("name", ""), str):
            return False
    known = {one["id"] for one in listed}
    whole = {one["id"] for one in listed if "of" not in one}
    if len(known) != len(listed) or not all(one.get("of") in whole for one in listed if "of" in one):
        return False
    for one in touching:
        ids = one.get("objects")
        if not isinstance(ids, list) or len(ids) < 2 or not all(i in known for i in ids):
            return False
        if not _is_count(one.get("from")) or not _is_count(one.get("to")):
            return False
    return all(
        one.get("from") in known and one.get("object") in known and _is_count(one.get("time"))
        for one in splits
    )


class ObjectPaths:
    """The objects that a stream names, and their paths (`fvvmux --objects`; spec/registry.md, keys of META)."""

    def __init__(self, value: dict[str, Any]) -> None:
        """value: that of the key `objects`, as the registry describes it."""
        self._step: int = value["step"]
        self.rounding: float = (
            value["unit"] / 2
        )  #: Metres by which the coordinates of places are rounded at most.
        self._objects: dict[int, _Object] = {}
        for one in value["list"]:
            places: dict[int, Vector] = {}
            for first, *numbers in one["path"]:
                steps = numpy.cumsum(numpy.reshape(numbers, (-1, 3)), axis=0)
                for i, place in enumerate(numpy.asarray(value["origin"], float) + value["unit"] * steps):
                    places[first + i] = place
            found = _Object(one["id"], one.get("name", ""), one.get("of", one["id"]), one["radius"], places)
            self._objects[found.id] = found
        self._touching = [(tuple(one["objects"]), one["from"], one["to"]) for one in value["touching"]]

    @classmethod
    def of(cls, metadata: Sequence[str]) -> ObjectPaths | None:
        """Of the texts of META, such as `Description.metadata`. None: they name none, or not as the registry says."""
        value = metadata_of(metadata, "objects", _is_described)
        return cls(value) if value else None

    @property
    def names(self) -> dict[int, str]:
        """Identifiers and names; "" for those without. Parts of objects are left out."""
        return {one.id: one.name for one in self._objects.values() if one.of == one.id}

    def find(self, name: str) -> int | None:
        """The identifier of an object; None: there is none of that name."""
        return next((one.id for one in self._objects.values() if one.name == name), None)

    def centre(self, identifier: int, ticks: float) -> Vector | None:
        """(3,) metres: where an object is, by its path; None: nowhere. KeyError: there is no such object."""
        places = self._objects[identifier].places
        at = ticks / self._step
        before, after = places.get(math.floor(at)), places.get(math.ceil(at))
        if before is None or after is None:
            return None
        return before + (at - math.floor(at)) * (after - before)

    def path(self, identifier: int) -> dict[int, Vector]:
        """Ticks, and (3,) metres: the places that the stream gives of an object. KeyError: there is no such object."""
        return {i * self._step: place for i, place in self._objects[identifier].places.items()}

    def together(self, identifier: int, ticks: float) -> tuple[int, ...]:
        """The objects that are one piece with an object at a time, with itself."""
        found = (ids for ids, first, last in self._touching if identifier in ids and first <= ticks <= last)
        return tuple(dict.fromkeys(self._objects[i].of for i in next(found, (identifier,))))

    def at(self, centre: ArrayLike, ticks: float) -> tuple[int, ...]:
        """The objects that a piece with a centre is: that whose centre is nearest, within its radius, and those that touch it."""
        nearest: tuple[float, int] | None = None
        for one in self._objects.values():
            place = self.centre(one.id, ticks)
            if place is None:
                continue
            away = float(numpy.linalg.norm(numpy.asarray(centre) - place))
            if away <= one.radius and (nearest is None or away < nearest[0]):
                nearest = (away, one.id)
        return self.together(nearest[1], ticks) if nearest else ()
