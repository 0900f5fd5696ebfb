"""Calibrations as files: JSON with the cameras of capture.json, and OpenCV's YAML."""

from __future__ import annotations

import json
from typing import Any

import numpy
from fvv.errors import Error, UsageError
from fvv.interop.optional_import import optional_import
from fvv.outputs import FileOutput, FolderOutput, discarded_unless_written

from ..choices import CALIBRATION_FORMATS
from .calibration import CalibratedCamera, Calibration, Moment
from .lenses import Lens
from .poses import Pose

cv2: Any = optional_import("cv2", "capture")


def description(calibration: Calibration) -> dict[str, Any]:
    """The calibration as spec/fvvcapture-calibration.schema.json defines it: its cameras are those of capture.json."""
    return {
        "fvv_calibration": 1,
        "units": "metres",
        "up": calibration.up,
        "conventions": {"pixel_centre": 0.5},
        "cameras": [_described(camera) for camera in calibration.cameras],
    }


def _described(camera: CalibratedCamera) -> dict[str, Any]:
    out: dict[str, Any] = {
        "id": camera.id,
        "name": camera.name,
        "width": camera.lens.width,
        "height": camera.lens.height,
        "intrinsics": _intrinsics(camera.lens),
        "lens": {
            "model": camera.lens.name,
            "coefficients": camera.lens.coefficients.tolist(),
            "r_max": camera.r_max,
        },
        **_pose(camera.pose),
    }
    if camera.per_frame is not None:
        out["per_frame"] = [_moment(camera, *one) for one in sorted(camera.per_frame.items())]
    return out


def _moment(camera: CalibratedCamera, frame: int, moment: Moment | None) -> dict[str, Any]:
    if moment is None:
        return {"frame": frame, "calibrated": False}
    zoomed = not numpy.array_equal(moment.lens.parameters, camera.lens.parameters)
    return {
        "frame": frame,
        **({"intrinsics": _intrinsics(moment.lens)} if zoomed else {}),
        **_pose(moment.pose),
    }


def _intrinsics(lens: Lens) -> dict[str, float]:
    return dict(zip(("fx", "fy", "cx", "cy"), lens.parameters[:4].tolist()))


def _pose(pose: Pose) -> dict[str, Any]:
    return {"rotation": pose.rotation.tolist(), "translation": pose.translation.tolist()}


def write_calibration(path: str, calibration: Calibration, format: str = "fvv", force: bool = False) -> None:
    """format "fvv": a JSON file. "opencv": a folder with NAME.yml of each camera, which `fvvimport opencv` and OpenCV read; cameras
    that move do not fit there. `UsageError`: the output exists and is not to be replaced (a folder never is); OSError."""
    output = calibration_output(path, calibration, format, force)
    try:
        output.commit()
    finally:
        output.discard()


def calibration_output(
    path: str, calibration: Calibration, format: str, force: bool
) -> FileOutput | FolderOutput:
    """What `write_calibration` writes, before it has its name."""
    if format == "fvv":
        file = FileOutput(path, force)
        with discarded_unless_written(file):
            file.write((json.dumps(description(calibration), indent=1) + "\n").encode())
        return file
    if format != "opencv":
        raise UsageError(f"format: expected one of {', '.join(CALIBRATION_FORMATS)}, found {format}")
    for camera in calibration.cameras:
        if camera.per_frame is not None:
            raise UsageError(
                f"camera {camera.name}: moves, which OpenCV's files cannot hold; expected --format fvv"
            )
    folder = FolderOutput(path)
    with discarded_unless_written(folder):
        for camera in calibration.cameras:
            folder.write_file(f"{camera.name}.yml", opencv_yaml(camera))
    return folder


def opencv_yaml(camera: CalibratedCamera) -> bytes:
    """cv::FileStorage with the keys that `fvvimport opencv` reads. The centre of the top left pixel is at 0 there."""
    storage = cv2.FileStorage("camera.yml", cv2.FILE_STORAGE_WRITE | cv2.FILE_STORAGE_MEMORY)
    matrix = camera.lens.matrix
    matrix[:2, 2] -= 0.5
    storage.write("image_width", camera.lens.width)
    storage.write("image_height", camera.lens.height)
    storage.write("camera_matrix", matrix)
    storage.write("distortion_coefficients", camera.lens.coefficients.reshape(1, -1))
    storage.write("fisheye_model", int(camera.lens.model == "fisheye"))
    storage.write("R", camera.pose.rotation)
    storage.write("T", camera.pose.translation.reshape(3, 1))
    text: str = storage.releaseAndGetString()
    return text.encode()


def read_calibration(path: str) -> tuple[list[dict[str, Any]], str]:
    """The cameras of a calibration file, as capture.json has them, in metres with pixel centres at 0.5; and its `up`. `Error` names the file and
    the key of what is missing or has another form; OSError."""
    with open(path, encoding="utf-8") as file:
        try:
            found = json.load(file)
        except (ValueError, RecursionError) as error:  # the latter of nested brackets
            raise Error(f"{path}: is no JSON: {error}", file=path) from error
    if not isinstance(found, dict) or found.get("fvv_calibration") != 1:
        raise Error(f"{path}: /fvv_calibration: expected 1", file=path)
    if found.get("units") != "metres" or found.get("conventions") != {"pixel_centre": 0.5}:
        raise Error(f"{path}: expected units metres and pixel_centre 0.5", file=path)
    cameras = found.get("cameras")
    if not isinstance(cameras, list) or not cameras:
        raise Error(f"{path}: /cameras: expected an array with a camera or more", file=path)
    for i, camera in enumerate(cameras):
        for key in ("id", "name", "width", "height", "intrinsics", "lens", "rotation", "translation"):
            if not isinstance(camera, dict) or key not in camera:
                raise Error(f"{path}: /cameras/{i}: expected {key}", file=path)
    return cameras, found.get("up", "unknown")


def from_description(cameras: list[dict[str, Any]], up: str) -> Calibration:
    """The calibration that a file describes, without what the report needs: for `track`."""
    out = []
    empty = numpy.zeros((0, 2))
    for one in cameras:
        inner = one["intrinsics"]
        coefficients = one["lens"]["coefficients"]
        model = "fisheye" if one["lens"]["model"] == "fisheye" else f"radtan{len(coefficients)}"
        lens = Lens(
            model,
            one["width"],
            one["height"],
            numpy.array([*(inner[key] for key in ("fx", "fy", "cx", "cy")), *coefficients], float),
        )
        pose = Pose(numpy.array(one["rotation"], float), numpy.array(one["translation"], float))
        out.append(
            CalibratedCamera(one["id"], one["name"], lens, pose, one["lens"]["r_max"], 0, empty, empty, {})
        )
    return Calibration(tuple(out), up, {}, 0, ())
