"""What a calibration is worth: figures as JSON, and a picture for each camera of where its errors and its corners are."""

from __future__ import annotations

from typing import Any

import numpy
from fvv.interop.optional_import import optional_import
from fvv.outputs import FolderOutput, discarded_unless_written
from numpy.typing import NDArray

from .calibration import CELLS, CalibratedCamera, Calibration

cv2: Any = optional_import("cv2", "capture")

Bytes = NDArray[numpy.uint8]

#: Width of a report picture, and heights of the lines of text above and of the scale below.
WIDTH, HEAD, FOOT = 1280, 64, 56
#: Residuals are drawn this many times longer.
LONGER = 200
#: Finer than CELLS by this factor: the heat map.
FINER = 2
PAPER, INK, FAINT = (248, 251, 251), (34, 34, 34), (150, 150, 150)
#: The scale of the heat map ends at this many pixels at least: errors of a good calibration shall look small.
LEAST_SCALE = 0.5


def report(calibration: Calibration, output: str | None) -> dict[str, Any]:
    """The figures, as spec/fvvcapture-calibrate.schema.json defines them. output: where the calibration was written, or None."""
    return {
        "fvvcapture_calibrate": 1,
        "output": output,
        "rms_px": calibration.rms,
        "boards": len(calibration.boards),
        "corners": sum(len(one.pixels) for one in calibration.cameras),
        "rejected": calibration.rejected,
        "up": calibration.up,
        "cameras": [_figures(one) for one in calibration.cameras],
        "warnings": list(calibration.warnings),
    }


def _figures(camera: CalibratedCamera) -> dict[str, Any]:
    return {
        "id": camera.id,
        "name": camera.name,
        "lens": camera.lens.model,
        "centre": camera.pose.centre.tolist(),
        "r_max": camera.r_max,
        "fit": _fit(camera),
        "moves": _motion(camera),
    }


def _fit(camera: CalibratedCamera) -> dict[str, Any] | None:
    if not len(camera.pixels):
        return None
    lengths = numpy.linalg.norm(camera.residuals, axis=1)
    return {
        "views": camera.views,
        "corners": len(lengths),
        "rms_px": camera.rms,
        "p95_px": float(numpy.percentile(lengths, 95)),
        "max_px": float(lengths.max()),
        "covered": camera.covered,
        "held_out_px": dict(camera.held_out),
    }


def _motion(camera: CalibratedCamera) -> dict[str, Any] | None:
    if camera.per_frame is None:
        return None
    found = [moment for moment in camera.per_frame.values() if moment is not None]
    return {
        "frames": len(camera.per_frame),
        "found": len(found),
        "fewest_matches": min(moment.matches for moment in found),
        "worst_rms_px": max(moment.rms for moment in found),
    }


def pictures_output(folder: str, calibration: Calibration) -> FolderOutput:
    """NAME.png of each camera, in a folder that is new or empty, before it has its name. `UsageError`: it is not; OSError."""
    output = FolderOutput(folder)
    with discarded_unless_written(output):
        for camera in calibration.cameras:
            good, content = cv2.imencode(".png", picture(camera)[:, :, ::-1])
            assert good
            output.write_file(f"{camera.name}.png", content.tobytes())
    return output


def picture(camera: CalibratedCamera) -> Bytes:
    """(height, WIDTH, 3): the camera's picture with the root mean square of the residuals in cells as colours, each corner, and
    the residual from there, LONGER times as long. Cells without a corner are grey; the circle is r_max."""
    scale = WIDTH / camera.lens.width
    height = round(camera.lens.height * scale)
    out = numpy.full((HEAD + height + FOOT, WIDTH, 3), PAPER, numpy.uint8)
    lengths = numpy.linalg.norm(camera.residuals, axis=1)
    top = max(LEAST_SCALE, float(numpy.percentile(lengths, 99)))
    stage = out[HEAD : HEAD + height]
    stage[:] = _heat(camera, height, top)
    _circle(camera, stage, scale)
    for (x, y), (u, v) in zip(camera.pixels * scale, camera.residuals * scale * LONGER):
        at = (round(16 * x), round(16 * y))
        end = (round(16 * (x + u)), round(16 * (y + v)))
        cv2.line(stage, at, end, (60, 60, 60), 1, cv2.LINE_AA, 4)
        cv2.circle(stage, at, 20, INK, -1, cv2.LINE_AA, 4)
    _text(
        out,
        f"{camera.name}: rms {camera.rms:.3f} px, 95 % below {numpy.percentile(lengths, 95):.3f} px",
        12,
        26,
        0.7,
    )
    _text(
        out,
        f"{len(lengths)} corners in {camera.views} views, {camera.covered:.0%} of the picture covered; {camera.lens.model}, "
        f"r_max {camera.r_max:.3f}; lines: residuals x {LONGER}",
        12,
        52,
        0.5,
    )
    _scale(out[HEAD + height :], top)
    return out


def _heat(camera: CalibratedCamera, height: int, top: float) -> Bytes:
    columns, rows = CELLS[0] * FINER, CELLS[1] * FINER
    x = numpy.clip(camera.pixels[:, 0] * columns / camera.lens.width, 0, columns - 1).astype(int)
    y = numpy.clip(camera.pixels[:, 1] * rows / camera.lens.height, 0, rows - 1).astype(int)
    squares = (camera.residuals**2).sum(axis=1)
    counts = numpy.bincount(y * columns + x, minlength=rows * columns)
    sums = numpy.bincount(y * columns + x, weights=squares, minlength=rows * columns)
    rms = numpy.sqrt(sums / numpy.maximum(counts, 1)).reshape(rows, columns)
    colours = _colours(rms / top)
    colours[counts.reshape(rows, columns) == 0] = (225, 225, 225)
    large: Bytes = cv2.resize(colours, (WIDTH, height), interpolation=cv2.INTER_NEAREST)
    return large


def _colours(values: NDArray[numpy.float64]) -> Bytes:
    """(rows, columns) from 0 to 1 to (rows, columns, 3): viridis, half way to white, so that lines on it can be seen."""
    levels = numpy.clip(numpy.rint(255 * values), 0, 255).astype(numpy.uint8)
    mapped: Bytes = cv2.applyColorMap(levels, cv2.COLORMAP_VIRIDIS)[:, :, ::-1]
    return (mapped // 2 + 127).astype(numpy.uint8)


def _circle(camera: CalibratedCamera, stage: Bytes, scale: float) -> None:
    """Where r_max is in the picture."""
    angles = numpy.linspace(0, 2 * numpy.pi, 181)
    radius = numpy.tan(camera.r_max) if camera.lens.model == "fisheye" else camera.r_max
    points = numpy.stack(
        [radius * numpy.cos(angles), radius * numpy.sin(angles), numpy.ones_like(angles)], axis=1
    )
    pixels = camera.lens.project(points)[0] * scale
    if numpy.isfinite(pixels).all() and numpy.abs(pixels).max() < 20 * WIDTH:
        cv2.polylines(
            stage, [numpy.rint(16 * pixels).astype(numpy.int32)], True, (190, 60, 0), 2, cv2.LINE_AA, 4
        )


def _scale(out: Bytes, top: float) -> None:
    """The colours' scale."""
    left, right = 60, WIDTH // 2
    out[10:26, left:right] = _colours(numpy.linspace(0, 1, right - left)[None])
    for part in (0, 0.5, 1):
        _text(out, f"{part * top:.2f} px", round(left + part * (right - left)) - 24, 46, 0.45)
    cv2.rectangle(out, (right + 60, 10), (right + 84, 26), (225, 225, 225), -1)
    cv2.rectangle(out, (right + 60, 10), (right + 84, 26), FAINT, 1)
    _text(out, "no corner", right + 92, 24, 0.45)
    cv2.line(out, (right + 200, 18), (right + 224, 18), (190, 60, 0), 2, cv2.LINE_AA)
    _text(out, "r_max", right + 232, 24, 0.45)


def _text(out: Bytes, text: str, x: int, y: int, size: float) -> None:
    # OpenCV's own letters are those of ASCII.
    shown = text.encode("ascii", "replace").decode()
    cv2.putText(out, shown, (x, y), cv2.FONT_HERSHEY_SIMPLEX, size, INK, 1, cv2.LINE_AA)
