"""Use of the package that mypy checks."""

from concurrent.futures import ProcessPoolExecutor
from typing import Union

import fvv
import fvv.distributed
import numpy
from numpy.typing import NDArray


def largest(path: str) -> float:
    with fvv.open(path, limits=fvv.Limits(max_faces=1000)) as clip:
        heights: list[float] = []
        for frame in clip[::5]:
            mesh = frame.mesh
            if mesh is None:
                continue
            positions: Union[NDArray[numpy.float32], NDArray[numpy.float64]] = mesh.positions
            camera: fvv.Camera = frame.cameras["cam0"]
            pixels: NDArray[numpy.float64] = camera.project(positions)
            heights.append(float(positions.max() + pixels.max()))
        return max(heights)


def draw(path: str) -> float:
    with fvv.open(path) as clip:
        picture: NDArray[numpy.uint8] = fvv.render(clip, clip[0], ((2, 1, 3), (0, 1, 0)), size=(64, 48))
        layers: fvv.Rendering = fvv.render(clip, 0, "cam0", layers=True)
        apart: fvv.Comparison = fvv.compare(clip, [frame.mesh for frame in clip if frame.mesh is not None])
        clip.to_usd("out.usdc", slice(0, 5), force=True)
        return float(picture.mean() + layers.depth.min()) + apart.d1.symmetric.psnr


def follow(reader: fvv.Reader, data: bytes) -> int:
    frames = 0
    for event in reader.feed(data):
        if isinstance(event, fvv.FrameEvent):
            frames += event.frame.number
        elif isinstance(event, fvv.Damage):
            print(event.problem.offset)
    return frames


def write(path: str, source: str) -> int:
    with fvv.open(source) as clip, fvv.Writer(path, rate=clip.rate, max_error="1mm", codec="jpeg") as writer:
        for frame in clip:
            writer.add(frame.mesh, time=frame.time)
    summary = writer.summary or fvv.mux("capture", path, force=True, threads=1)
    camera = fvv.Camera(0, numpy.eye(3), numpy.eye(3), [0, 0, 0], (64, 48))
    coarse: fvv.Decimated = fvv.decimate((numpy.zeros((3, 3)), [[0, 1, 2]]), 0.5, cameras=[camera])
    return int(summary["bytes"]) + len(coarse.indices)


def spread(path: str) -> float:
    with ProcessPoolExecutor(2) as pool:
        found = fvv.distributed.mux(
            "s3://bucket/capture", path, pool, work="s3://bucket/work", max_error="1mm", group=25
        )
    seconds: float = found["seconds"]["plan"]
    return seconds
