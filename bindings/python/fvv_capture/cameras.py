"""Cameras from the calibration files of other programs."""

from __future__ import annotations

import dataclasses
import json
import math
import os
import pathlib
import re
from collections.abc import Sequence
from typing import Any, Union

from fvv import Camera, recordings
from fvv.errors import Error, UsageError

#: Names of formats, as `fvvimport` has them, and "fvv" for a capture.json and for what `fvvcapture calibrate` writes.
FORMATS = (
    "fvv",
    "colmap",
    "easymocap",
    "kalibr",
    "krt",
    "metashape",
    "middlebury",
    "nerfstudio",
    "opencv",
    "panoptic",
    "qualisys",
    "realitycapture",
    "toml",
)
UNITS = {"metres": 1.0, "centimetres": 0.01, "millimetres": 0.001, "inches": 0.0254, "feet": 0.3048}
#: Of formats with a file for each camera, those that are taken from a folder.
_FILES = {"opencv": (".yml", ".yaml", ".xml", ".json"), "krt": (".txt", ".krt"), "realitycapture": (".xmp",)}
_LACKING_SIZE = "middlebury", "krt", "realitycapture"
_TAKING_SIZE = *_LACKING_SIZE, "easymocap"

PathLike = Union[str, "os.PathLike[str]"]


@dataclasses.dataclass(frozen=True)
class Calibration:
    """What `read_calibration` read."""

    cameras: list[
        Camera
    ]  #: In the order of the file. In metres; in units of the file when the unit is not known.
    unit_known: bool  #: Lengths are metres.
    format: str  #: One of `FORMATS`.
    #: The cameras as capture.json has them (spec/capture.md): in metres, pixel centres at .5, with `per_frame` of those that move.
    entries: list[dict[str, Any]]
    up: str = "unknown"  #: "+y", ...: the axis of the world that points up.


def recognise(path: PathLike) -> str:
    """The format of a calibration, by what is in it and not by its name alone: one of `FORMATS`.

    path: a file, or a folder (of colmap, of a capture, or of OpenCV's files). `Error` for what is none of them."""
    place = pathlib.Path(path)
    if place.is_dir():
        if (place / "capture.json").exists():
            return "fvv"
        if any(_is_colmap(model) for model in (place, place / "sparse", *sorted(place.glob("sparse/*")))):
            return "colmap"
        if (place / "transforms.json").exists():
            return "nerfstudio"
        if (place / "intri.yml").exists() and (place / "extri.yml").exists():
            return "easymocap"
        if any(file.suffix == ".xmp" for file in place.iterdir()):
            return "realitycapture"
        if any(file.suffix in _FILES["opencv"] for file in place.iterdir()):
            return "opencv"
        raise Error(
            f"{path}: expected a COLMAP model, capture.json, transforms.json or files .yml, .yaml or .xml in the "
            "folder, found none",
            file=str(path),
        )
    try:
        text = place.read_text("utf-8", errors="replace")
    except OSError as error:
        raise Error(f"{path}: {error.strerror}", file=str(path)) from None
    start = text.lstrip("\ufeff \t\r\n")
    if start.startswith("{"):
        document = _parsed(start, place)
        if "fvv_capture" in document or "fvv_calibration" in document:
            return "fvv"
        if "frames" in document:
            return "nerfstudio"
        cameras = document.get("cameras")
        if isinstance(cameras, list) and cameras and "resolution" in cameras[0]:
            return "panoptic"
        if "camera_matrix" in document or "opencv-matrix" in start:
            return "opencv"
    elif "T_cn_cnm1" in start or re.search(r"^cam0:", start, re.M):
        return "kalibr"
    elif place.suffix == ".xmp" or start.startswith("#name,x,y,alt,heading,pitch,roll,"):
        return "realitycapture"
    elif place.suffix == ".toml" or re.search(r"^\[cam[\w.]*\]", start, re.M):
        return "toml"
    elif start.startswith("<") and "<document" in start and "<chunk" in start:
        return "metashape"
    elif "<opencv_storage" in start[:4096] or start.startswith("%YAML"):
        return "opencv"
    elif start.startswith("<") and "<calibration" in start:
        return "qualisys"
    else:
        lines = start.splitlines()
        if len(lines) > 1 and len(lines[0].split()) == 1 and len(lines[1].split()) == 22:
            return "middlebury"
        rows = [line.split() for line in lines if line.strip() and not line.lstrip().startswith("#")]
        if len(rows) > 5 and (rows[0] == ["extrinsic"] or all(len(row) == 3 for row in rows[1:3])):
            return "krt"
    raise Error(
        f"{path}: expected a calibration of {', '.join(FORMATS)}, found none of them: pass format",
        file=str(path),
    )


def _is_colmap(folder: pathlib.Path) -> bool:
    return any(
        all((folder / f"{name}{end}").is_file() for name in ("cameras", "images")) for end in (".bin", ".txt")
    )


def _files(path: pathlib.Path, format: str) -> list[str]:
    """What the reader of a format takes."""
    if format in _FILES and path.is_dir():
        files = sorted(
            str(file)
            for file in path.iterdir()
            if file.suffix in _FILES[format] and file.name != "capture.json"
        )
        if not files:
            raise Error(
                f"{path}: expected files {' or '.join(_FILES[format])} in the folder, found none",
                file=str(path),
            )
        return files
    if format == "nerfstudio" and path.is_dir():
        return [str(path / "transforms.json")]
    return [str(path)]


def _metres(units: str | float) -> float | None:
    """Metres per unit; None: unknown."""
    if isinstance(units, str):
        if units == "unknown":
            return None
        if units in UNITS:
            return UNITS[units]
    elif units > 0 and math.isfinite(units):
        return float(units)
    raise UsageError(
        f"units: expected {', '.join(UNITS)}, unknown or metres per unit above 0, found {units!r}"
    )


def _scaled(camera: Camera, metres: float) -> Camera:
    return Camera(
        camera.id,
        camera.K,
        camera.R,
        camera.t * metres,
        (camera.width, camera.height),
        camera.distortion,
        camera.lens,
        camera.name,
        camera.r_max,
    )


def read_calibration(
    path: PathLike | Sequence[PathLike],
    format: str | None = None,
    units: str | float | None = None,
    size: tuple[int, int] | None = None,
) -> Calibration:
    """The cameras of a calibration, in fvv's conventions (world to camera; x right, y down, z forward; pixel centres at .5).

    path: a file or a folder, as `recognise` has it; of opencv and krt also a list of files, one for each camera. format: one of
    `FORMATS`, None: recognised. units: one of `UNITS`, "unknown", or metres per unit; None: the format's own, or unknown
    when it has none. size: width and height in pixels of the pictures of middlebury, krt and easymocap, whose files do not have it.

    `UsageError` for a wrong argument; `Error` that names file and line for a file that is not of the format, or has a lens
    that fvv cannot hold."""
    given: list[Any] = [path] if isinstance(path, (str, os.PathLike)) else list(path)
    paths = [pathlib.Path(one) for one in given]
    if not paths:
        raise UsageError("path: expected a file or a folder, found none")
    if format is None:
        format = recognise(paths[0])
    elif format not in FORMATS:
        raise UsageError(f"format: expected {', '.join(FORMATS)}, found {format!r}")
    if len(paths) > 1 and format not in _FILES:
        raise UsageError(f"path: expected one for {format}, found {len(paths)}")
    if format in _LACKING_SIZE and size is None:
        raise UsageError(f"size: expected width and height of the pictures, which {format} does not have")
    if format not in _TAKING_SIZE and size is not None:
        raise UsageError(
            f"size: expected for {', '.join(_TAKING_SIZE)} only, {format} has the size of pictures"
        )
    metres = _metres(units) if units is not None else None
    if format == "fvv":
        if units is not None:
            raise UsageError(f"units: expected for other formats only, {paths[0]} has its own")
        return _read_fvv(paths[0])
    files = [file for one in paths for file in _files(one, format)]
    cameras, own_metres = recordings.read_calibration(format, files, size or (0, 0))
    if units is None:
        metres = own_metres or None
    if metres is not None and metres != 1:
        cameras = [_scaled(camera, metres) for camera in cameras]
    return Calibration(cameras, metres is not None, format, [_entry(camera) for camera in cameras])


def _entry(camera: Camera) -> dict[str, Any]:
    """A camera as capture.json has it."""
    K = camera.K
    out: dict[str, Any] = {
        "id": camera.id,
        "name": camera.name or f"camera {camera.id}",
        "width": camera.width,
        "height": camera.height,
        "intrinsics": {"fx": K[0, 0], "fy": K[1, 1], "cx": K[0, 2], "cy": K[1, 2], "skew": K[0, 1]},
        "rotation": camera.R.tolist(),
        "translation": camera.t.tolist(),
    }
    if camera.lens != "none":
        count = {"radtan": 8, "fisheye": 4}[camera.lens]
        out["lens"] = {
            "model": camera.lens,
            "coefficients": camera.distortion[:count].tolist(),
            "r_max": camera.r_max,
        }
    return out


def _parsed(text: str, path: pathlib.Path) -> dict[str, Any]:
    """`Error` names the file, of JSON that is damaged, no object, or nested without end."""
    try:
        document = json.loads(text)
    except (ValueError, RecursionError) as error:
        raise Error(f"{path}: is no JSON: {error}", file=str(path)) from None
    if not isinstance(document, dict):
        raise Error(f"{path}: expected an object, found {type(document).__name__}", file=str(path))
    return document


def _read_fvv(path: pathlib.Path) -> Calibration:
    """The cameras of a capture.json, or of a file of `fvvcapture calibrate`, which has the same cameras and no capture."""
    file = path / "capture.json" if path.is_dir() else path
    document = _parsed(file.read_text("utf-8"), file)
    conventions = document.get("conventions", {})
    units = document.get("units", "metres")
    centre = conventions.get("pixel_centre", 0.5) if isinstance(conventions, dict) else 0.5
    metres = 1.0 if units == "unknown" else _metres(units)
    if metres is None or not isinstance(document.get("cameras"), list) or not document["cameras"]:
        raise Error(f"{file}: expected cameras, found none", file=str(file))
    entries = [_converted(entry, metres, 0.5 - centre) for entry in document["cameras"]]
    frames = sorted({m["frame"] for e in entries for m in e.get("per_frame", [])})
    # The strict reader of captures, for what is in them.
    text = {
        "fvv_capture": 1,
        "frame_rate": 1,
        "frames": {"first": frames[0] if frames else 0, "count": len(frames) or 1},
        "units": "metres",
        "cameras": [{**entry, "pictures": f"{i}-%d.png"} for i, entry in enumerate(entries)],
    }
    cameras = recordings.Footage(json.dumps(text), str(file)).cameras
    names = [entry.get("name") or f"camera {entry['id']}" for entry in entries]
    return Calibration(
        cameras,
        units != "unknown",
        "fvv",
        [{**entry, "name": name} for entry, name in zip(entries, names)],
        document.get("up", "unknown"),
    )


def _converted(entry: dict[str, Any], metres: float, shift: float) -> dict[str, Any]:
    """A camera without its pictures, in metres, its principal point counted from the corner of the picture."""
    out = {key: value for key, value in entry.items() if key not in ("pictures", "masks")}
    if "translation" in out and metres != 1:
        out["translation"] = [metres * value for value in out["translation"]]
    if "intrinsics" in out and shift:
        lens = out["intrinsics"]
        out["intrinsics"] = {**lens, **{axis: lens[axis] + shift for axis in ("cx", "cy") if axis in lens}}
    if "per_frame" in out:
        out["per_frame"] = [_converted(moment, metres, shift) for moment in out["per_frame"]]
    return out
