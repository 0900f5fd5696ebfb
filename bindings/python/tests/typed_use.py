"""Use of the package that mypy checks."""

import fvv
import numpy
from numpy.typing import NDArray


def largest(path: str) -> float:
    with fvv.open(path, limits=fvv.Limits(max_faces=1000)) as clip:
        heights: list[float] = []
        for frame in clip[::5]:
            mesh = frame.mesh
            if mesh is None:
                continue
            positions: NDArray[numpy.float32] = mesh.positions
            camera: fvv.Camera = frame.cameras["cam0"]
            pixels: NDArray[numpy.float64] = camera.project(positions)
            heights.append(float(positions.max() + pixels.max()))
        return max(heights)


def follow(reader: fvv.Reader, data: bytes) -> int:
    frames = 0
    for event in reader.feed(data):
        if isinstance(event, fvv.FrameEvent):
            frames += event.frame.number
        elif isinstance(event, fvv.Damage):
            print(event.problem.offset)
    return frames
