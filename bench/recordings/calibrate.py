"""Calibration of six cameras by a board that is carried through a volume of 3 m, on generated pictures whose truth is known."""

import pathlib
import sys
import tempfile

import numpy

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
# The package of the build, and the pictures of its tests.
sys.path[:0] = [
    str(ROOT / part) for part in ("build/default/bindings/python", "bindings/python/tests/capture")
]

CAMERAS, FRAMES, SIZE = 6, 120, (1280, 720)


def calibrate() -> dict:
    """rms_px: of all corners that are used. centre_mm: the largest error of a camera's place, 5 m from the middle, after the best
    rotation and translation; the scale is that of the board."""
    import cv2
    import room
    from fvv_capture import calibrate as calibration
    from fvv_capture.calibrate.recordings import recordings_of

    generator = numpy.random.default_rng(1)
    board = calibration.Board(9, 6, 0.12, 0.09, "4X4_100")
    cameras = []
    for i in range(CAMERAS):
        angle = 2 * numpy.pi * i / CAMERAS
        centre = (5 * numpy.sin(angle), 1.0 + 0.3 * i, 5 * numpy.cos(angle))
        lens = (-0.16 - 0.02 * i, 0.05 + 0.01 * i, 0.0004, -0.0003, -0.01)
        focal = 1300 + 15 * i
        cameras.append(
            room.look(centre, (0.1 * i, 1.1, 0), focal, SIZE, lens, "radtan", i, f"cam{i}", 0.02 * i)
        )
    poses = room.walk(board, cameras, FRAMES, generator)
    with tempfile.TemporaryDirectory() as folder:
        for camera in cameras:
            own = pathlib.Path(folder) / camera.name
            own.mkdir()
            for frame, pose in enumerate(poses):
                picture = room.render(camera, [room.board_rectangle(board, pose)], generator)
                cv2.imwrite(str(own / f"{frame:04d}.png"), picture)
        found = calibration.calibrate(recordings_of(folder), board)
    apart = room.aligned_centres([one.pose.centre for one in found.cameras], [one.centre for one in cameras])
    return {"calibrate.rms_px": found.rms, "calibrate.centre_mm": 1000 * float(apart.max())}


if __name__ == "__main__":
    for name, value in calibrate().items():
        print(f"{name} {value:.4f}")
