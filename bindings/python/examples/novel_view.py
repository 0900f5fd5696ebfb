"""Draws a clip from where no camera is, and compares a view that a camera has with the camera's own picture.

usage: python novel_view.py CLIP.fvv OUT.png
"""

import sys

import fvv
import matplotlib
import numpy

matplotlib.use("agg")
from matplotlib import pyplot  # noqa: E402


def main(path, out):
    with fvv.open(path) as clip:
        frame = clip.at(clip.start + clip.duration / 2)
        target = frame.mesh.positions.mean(axis=0)
        centres = numpy.array([camera.centre for camera in frame.cameras.values()])

        # Half way between the first two cameras, as far from the scene as they are.
        between = centres[:2].mean(axis=0) - target
        between *= numpy.linalg.norm(centres[:2] - target, axis=1).mean() / numpy.linalg.norm(between)
        novel = fvv.render(
            clip, frame, (target + between, target), size=(480, 270), background=(230, 230, 230)
        )

        # A camera's view from the pictures of the others: what is not drawn from its own picture can be compared with it.
        camera = next(iter(frame.cameras))
        drawn = fvv.render(clip, frame, camera, exclude=[camera], layers=True)
        photographed = frame.pictures[camera].whole()

    scale = drawn.pixels.shape[0] // photographed.shape[0]
    same_size = drawn.pixels.reshape(len(photographed), scale, photographed.shape[1], scale, 3).mean(
        axis=(1, 3)
    )
    covered = drawn.coverage.reshape(len(photographed), scale, -1, scale).min(axis=(1, 3)) == 1
    difference = (same_size - photographed)[covered].astype(float)
    psnr = 20 * numpy.log10(255 / numpy.sqrt((difference**2).mean()))

    figure, panels = pyplot.subplots(1, 3, figsize=(12, 3), layout="constrained")
    titles = ("Between two cameras", f"Camera {camera}, from the others", f"Camera {camera}, its picture")
    for panel, title, picture in zip(panels, titles, (novel, drawn.pixels, photographed)):
        panel.imshow(picture)
        panel.set_title(title)
        panel.set_axis_off()
    figure.savefig(out, dpi=120)
    print(f"the view of camera {camera} from {len(drawn.sources)} others: {psnr:.1f} dB where the mesh is")


if __name__ == "__main__":
    main(*sys.argv[1:])
