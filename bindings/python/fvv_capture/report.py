"""How good a capture is: silhouettes, components, flicker, pictures of cameras that were left out, time of each stage."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy
from fvv import open as open_clip
from fvv import recordings, render
from fvv.errors import UsageError
from fvv.interop.optional_import import optional_import

from .opencv import named
from .pipeline import FrameResult, Progress

cv2: Any = optional_import("cv2", "capture")

#: Below this intersection over union a camera's silhouette is named in a warning.
SILHOUETTE_WARNING = 0.75


def _mean(values: Sequence[float]) -> float | None:
    return float(numpy.mean(values)) if values else None


def describe_frames(
    results: Sequence[FrameResult], names: Sequence[str], keys: Sequence[dict[str, Any] | None]
) -> dict[str, Any]:
    """The report of all frames (spec/fvvcapture.schema.json). IoU: intersection over union of the mesh's silhouette and the mask.
    flicker: see `flicker`. keys: how each camera was keyed."""
    cameras = []
    for index, name in enumerate(names):
        iou = [v for r in results if (v := r.iou[index]) is not None]
        confidence = [v for r in results if (v := r.confidence[index]) is not None]
        cameras.append(
            {
                "name": name,
                "key": keys[index],
                "iou_mean": _mean(iou),
                "iou_min": min(iou, default=None),
                "confidence_mean": _mean(confidence),
                "confidence_min": min(confidence, default=None),
            }
        )
    stages: dict[str, float] = {}
    for result in results:
        for stage, seconds in result.seconds.items():
            stages[stage] = stages.get(stage, 0.0) + seconds
    every = [v for r in results for v in r.iou if v is not None]
    return {
        "fvvcapture": 1,
        "cameras": cameras,
        "iou_mean": _mean(every),
        "iou_min": min(every, default=None),
        "flicker": flicker([r.volume for r in results if not r.empty]),
        "seconds": {"of_frames": stages},
        "frames": [
            {
                "number": r.number,
                "iou": r.iou,
                "confidence": r.confidence,
                "vertices": r.vertices,
                "faces": r.faces,
                "components": r.components,
                "dropped": r.dropped,
                "volume": r.volume,
            }
            for r in results
        ],
    }


def flicker(volumes: Sequence[float]) -> float | None:
    """How much parts of the surface come and go: the median over frames of |v(t - 1) - 2 v(t) + v(t + 1)| / (2 v(t)), v the
    enclosed volume. Motion changes a volume smoothly, a limb that is lost in one frame does not. None: fewer than 3 frames."""
    if len(volumes) < 3:
        return None
    v = numpy.asarray(volumes)
    return float(numpy.median(numpy.abs(v[:-2] - 2 * v[1:-1] + v[2:]) / (2 * v[1:-1])))


def leave_one_out(
    clip_path: str, footage: recordings.Footage, numbers: Sequence[int], progress: Progress
) -> list[dict[str, Any]]:
    """Each camera at each of those frames, drawn from the pictures of the others, against its own: PSNR in dB over the pixels of
    its mask (the mesh is made with the camera's mask; its picture is not used), and the share of them that the mesh does not
    cover."""
    out = []
    with open_clip(clip_path) as clip:
        first, cameras = footage.frames[0], footage.cameras
        done = 0
        for number in numbers:
            frame = clip[number - first]
            for index, calibrated in enumerate(cameras):
                own = frame.cameras[calibrated.id]
                size = (own.width, own.height)
                drawn = render(
                    clip, number - first, own, exclude=[calibrated.id], environment=False, layers=True
                )
                with named(f"camera {calibrated.name or index}", number, is_file=False):
                    truth = cv2.resize(footage.picture(index, number), size, interpolation=cv2.INTER_AREA)
                    mask = cv2.resize(footage.mask(index, number), size, interpolation=cv2.INTER_AREA) >= 128
                done += 1
                progress("hold out cameras", done, len(numbers) * len(cameras))
                if not mask.any():
                    continue
                error = drawn.pixels[mask].astype(numpy.float64) - truth[mask]
                mse = float(numpy.mean(error * error))
                out.append(
                    {
                        "camera": calibrated.name,
                        "frame": number,
                        "psnr": 10 * math.log10(255 * 255 / mse) if mse else None,
                        "uncovered": float((drawn.coverage[mask] < 0.5).mean()),
                    }
                )
    return out


def need_matplotlib() -> Any:
    """Its module of figures. `UsageError`: it is not installed."""
    try:
        return optional_import("matplotlib.figure", "plot")
    except ImportError as error:
        raise UsageError(f"the chart of the report: {error}") from error


def chart(report: dict[str, Any]) -> bytes:
    """A PNG: silhouettes, confidence, vertices and time over the frames. Needs matplotlib."""
    import io

    frames = report["frames"]
    numbers = [f["number"] for f in frames]
    figure = need_matplotlib().Figure(figsize=(10, 8), layout="constrained")
    iou, confidence, size = figure.subplots(3, 1, sharex=True)
    for index, camera in enumerate(report["cameras"]):
        style = {"label": camera["name"], "linewidth": 1.2}
        iou.plot(numbers, [_or_nan(f["iou"][index]) for f in frames], **style)
        confidence.plot(numbers, [_or_nan(f["confidence"][index]) for f in frames], **style)
    iou.set_ylabel("IoU of mesh and mask")
    iou.legend(fontsize="small", ncols=6)
    confidence.set_ylabel("confidence of keys")
    confidence.set_ylim(0, 1)
    size.plot(numbers, [1000 * f["volume"] for f in frames], color="black")
    size.set_ylabel("volume, litres")
    size.set_xlabel("frame")
    for axes in (iou, confidence, size):
        axes.grid(alpha=0.3)
    data = io.BytesIO()
    figure.savefig(data, format="png", dpi=110)
    return data.getvalue()


def _or_nan(value: float | None) -> float:
    return math.nan if value is None else value


def text(report: dict[str, Any]) -> str:
    """The report on one screen."""

    def number(value: float | None, form: str) -> str:
        return "-" if value is None else format(value, form)

    lines = [f"{'camera':16} {'IoU':>6} {'least':>6} {'confidence':>10} {'least':>6} {'offset':>7}"]
    offsets = report["offsets"]
    for camera in report["cameras"]:
        offset = offsets.get(camera["name"], {}).get("pictures")
        lines.append(
            f"{camera['name']:16.16} {number(camera['iou_mean'], '6.3f'):>6} {number(camera['iou_min'], '6.3f'):>6} "
            f"{number(camera['confidence_mean'], '10.2f'):>10} {number(camera['confidence_min'], '6.2f'):>6} "
            f"{number(offset, '+7d'):>7}"
        )
    frames = report["frames"]
    count = len(frames)
    vertices = numpy.mean([f["vertices"] for f in frames])
    size = [high - low for low, high in zip(report["bounds"]["low"], report["bounds"]["high"])]
    lines.append(
        f"{count} frames, {vertices:.0f} vertices each, in {size[0]:.2f} x {size[1]:.2f} x {size[2]:.2f} m, {report['height']:.2f} m high; IoU "
        f"{number(report['iou_mean'], '.3f')}, least {number(report['iou_min'], '.3f')}; flicker "
        + ("-" if report["flicker"] is None else f"{100 * report['flicker']:.2f} % of the volume")
    )
    held_out = report.get("held_out")
    if held_out:
        psnr = [h["psnr"] for h in held_out if h["psnr"] is not None]
        lines.append(
            f"cameras predicted from the others: {numpy.mean(psnr):.2f} dB, least {min(psnr):.2f} dB"
        )
    stages = ", ".join(
        f"{stage} {seconds / count:.2f}" for stage, seconds in report["seconds"]["of_frames"].items()
    )
    lines.append(f"{report['seconds']['all']:.1f} s; seconds per frame: {stages}")
    return "\n".join(lines)
