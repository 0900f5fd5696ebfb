"""Pictures of flat things, through lenses: what tests and figures of the calibration are made from.

Rays come from fvv.Camera, so that the truth is independent of OpenCV, by which the calibration projects."""

import math

import cv2
import fvv
import numpy

#: Samples of a pixel along each side.
SAMPLES = 3
#: Gaussian blur of the pictures in pixels, and standard deviation of their noise in levels.
BLUR, NOISE = 0.6, 1.5


class Rectangle:
    """origin, along, down: (3,) metres in the world; the texture, (rows, columns) grey, spans origin to along and down."""

    def __init__(self, origin, along, down, texture):
        self.origin = numpy.asarray(origin, float)
        self.along = numpy.asarray(along, float)
        self.down = numpy.asarray(down, float)
        self.texture = texture

    def corners(self):
        return self.origin + numpy.array([numpy.zeros(3), self.along, self.along + self.down, self.down])


def look(centre, target, focal, size, distortion=(), lens="none", id=0, name="", roll=0.0, up=(0, 1, 0)):
    """A camera at a centre that looks at a target; roll in radians."""
    centre = numpy.asarray(centre, float)
    forward = numpy.asarray(target, float) - centre
    forward /= numpy.linalg.norm(forward)
    right = numpy.cross(forward, up)
    right /= numpy.linalg.norm(right)
    rotation = numpy.array([right, numpy.cross(forward, right), forward])
    turn = numpy.array(
        [[numpy.cos(roll), -numpy.sin(roll), 0], [numpy.sin(roll), numpy.cos(roll), 0], [0, 0, 1]]
    )
    rotation = turn @ rotation
    matrix = [[focal, 0, size[0] / 2 + 3.3], [0, 1.001 * focal, size[1] / 2 - 2.1], [0, 0, 1]]
    return fvv.Camera(id, matrix, rotation, -rotation @ centre, size, distortion, lens, name)


def render(camera, rectangles, generator, background=110, samples=SAMPLES):
    """(height, width) uint8: the nearest rectangle at each sample, blurred, with noise."""
    picture = numpy.full((camera.height, camera.width), float(background))
    x0, y0, x1, y1 = _box(camera, rectangles)
    if x1 > x0 and y1 > y0:
        # Rows in strips: the rays of a whole picture are large.
        strip = max(1, 2_000_000 // (samples**2 * (x1 - x0)))
        for top in range(y0, y1, strip):
            bottom = min(y1, top + strip)
            part = _sampled(camera, rectangles, (x0, top, x1, bottom), background, samples)
            picture[top:bottom, x0:x1] = cv2.resize(
                part, (x1 - x0, bottom - top), interpolation=cv2.INTER_AREA
            )
    picture = cv2.GaussianBlur(picture, (0, 0), BLUR)
    picture += generator.normal(0, NOISE, picture.shape)
    return numpy.clip(numpy.rint(picture), 0, 255).astype(numpy.uint8)


def _box(camera, rectangles):
    """The part of the picture in which rectangles may be: all of it if one reaches behind the camera."""
    corners = numpy.concatenate([one.corners() for one in rectangles])
    edges = camera.project(corners)
    if not numpy.isfinite(edges).all():
        return 0, 0, camera.width, camera.height
    margin = 8 + 0.02 * numpy.ptp(edges, axis=0).max()
    low = numpy.maximum(numpy.floor(edges.min(axis=0) - margin), 0).astype(int)
    high = numpy.minimum(numpy.ceil(edges.max(axis=0) + margin), [camera.width, camera.height]).astype(int)
    return low[0], low[1], high[0], high[1]


def _sampled(camera, rectangles, box, background, samples):
    x0, y0, x1, y1 = box
    x = x0 + (numpy.arange((x1 - x0) * samples) + 0.5) / samples
    y = y0 + (numpy.arange((y1 - y0) * samples) + 0.5) / samples
    rays = _rays(camera, x, y)
    out = numpy.full(rays[0].shape, float(background), numpy.float32)
    nearest = numpy.zeros(rays[0].shape, numpy.float32)
    for one in rectangles:
        # A point of the plane, origin + s along + t down, is depth * (x, y, 1) in the camera's axes.
        plane = camera.R @ numpy.stack([one.along, one.down, one.origin - camera.centre], axis=1)
        s, t, inverse = (row[0] * rays[0] + row[1] * rays[1] + row[2] for row in numpy.linalg.inv(plane))
        with numpy.errstate(divide="ignore", invalid="ignore"):
            s, t = s / inverse, t / inverse
        hit = (inverse > nearest) & (s >= 0) & (s < 1) & (t >= 0) & (t < 1)
        rows, columns = one.texture.shape
        seen = cv2.remap(
            one.texture,
            (numpy.where(hit, s, 0) * columns - 0.5).astype(numpy.float32),
            (numpy.where(hit, t, 0) * rows - 0.5).astype(numpy.float32),
            cv2.INTER_LINEAR,
            borderMode=cv2.BORDER_REPLICATE,
        )
        out[hit] = seen[hit]
        nearest[hit] = inverse[hit]
    return out


_GRID = 4
_grids = {}


def _rays(camera, x, y):
    """x / z and y / z, each (y, x): linear between every fourth pixel, which is exact to a thousandth of a pixel."""
    key = (camera.K.tobytes(), camera.distortion.tobytes(), camera.lens, camera.width, camera.height)
    if key not in _grids:
        columns = numpy.arange(-_GRID, camera.width + 2 * _GRID, _GRID)
        rows = numpy.arange(-_GRID, camera.height + 2 * _GRID, _GRID)
        found = camera.ray(numpy.stack(numpy.meshgrid(columns, rows), axis=-1))[1] @ camera.R.T
        _grids[key] = found[..., :2] / found[..., 2:]
    grid = _grids[key]
    column, row = x / _GRID + 1, y / _GRID + 1
    i, j = column.astype(int), row.astype(int)
    across = (column - i)[None, :, None]
    down = (row - j)[:, None, None]
    lines = grid[:, i] * (1 - across) + grid[:, i + 1] * across
    out = lines[j] * (1 - down) + lines[j + 1] * down
    return out[..., 0], out[..., 1]


def board_rectangle(board, pose, pixels_per_square=40, margin=0.5, paper=235):
    """The board with a margin of white paper. pose: (rotation, translation) from the board's axes to the world's."""
    rotation, translation = pose
    border = int(round(margin * pixels_per_square))
    print_ = board.picture(pixels_per_square)
    # Ink and paper of a print: neither black nor white.
    texture = numpy.pad(
        numpy.where(print_ > 127, paper, 20).astype(numpy.uint8), border, constant_values=paper
    ).astype(numpy.float32)
    edge = border / pixels_per_square * board.square
    along = board.columns * board.square + 2 * edge
    down = board.rows * board.square + 2 * edge
    return Rectangle(
        rotation @ numpy.array([-edge, -edge, 0]) + translation,
        along * rotation[:, 0],
        down * rotation[:, 1],
        texture,
    )


def walk(board, cameras, frames, generator, reach=(1.5, 0.8, 1.5), height=1.2):
    """Poses of a board that is carried through a volume around (0, height, 0), slanted, and turned to one camera after the other
    and between neighbours. Every fourth is nearer to the camera, anywhere in its picture: for the lens."""
    out = []
    middle = numpy.array([board.columns, board.rows, 0]) * board.square / 2
    for i in range(frames):
        camera, next_ = cameras[i % len(cameras)], cameras[(i + 1) % len(cameras)]
        place = numpy.array([0, height, 0]) + generator.uniform(-1, 1, 3) * reach
        towards = place - camera.centre
        if i % 4 == 3:
            pixel = generator.uniform(0.08, 0.92, 2) * [camera.width, camera.height]
            towards = camera.ray(pixel)[1] * generator.uniform(2.2, 3.5)
            place = camera.centre + towards
        elif i % 2:
            towards = place - (camera.centre + next_.centre) / 2
        forward = towards / numpy.linalg.norm(towards)
        right = numpy.cross(forward, [0, 1, 0])
        right /= numpy.linalg.norm(right)
        facing = numpy.stack([right, numpy.cross(forward, right), forward], axis=1)
        slant = cv2.Rodrigues(generator.uniform(-1, 1, 3) * [0.6, 0.4, 0.6])[0]
        rotation = facing @ slant
        out.append((rotation, place - rotation @ middle))
    return out


def aligned_centres(found, true):
    """Distances in metres between camera centres, (cameras, 3) each, after the best rotation and translation (Kabsch, 1976)."""
    found, true = numpy.asarray(found), numpy.asarray(true)
    a, b = found - found.mean(axis=0), true - true.mean(axis=0)
    u, _, v = numpy.linalg.svd(a.T @ b)
    turn = u @ numpy.diag([1, 1, numpy.sign(numpy.linalg.det(u @ v))]) @ v
    return numpy.linalg.norm(a @ turn - b, axis=1)


def camera_at(described, frame=None):
    """A camera of a calibration file as `fvv.Camera`. frame: of a camera that moves; None: the camera itself. Returns None if the
    camera has no calibration in this frame. `UsageError`: it moves, and the frame is not in its list."""
    values = dict(described)
    if frame is not None and "per_frame" in described:
        entries = [one for one in described["per_frame"] if one["frame"] == frame]
        if not entries:
            raise fvv.UsageError(
                f"camera {described['name']}: frame {frame}: is not among those of per_frame"
            )
        if entries[0].get("calibrated") is False:
            return None
        values.update(entries[0])
    inner = values["intrinsics"]
    matrix = [[inner["fx"], inner.get("skew", 0.0), inner["cx"]], [0, inner["fy"], inner["cy"]], [0, 0, 1]]
    lens = values["lens"]
    r_max = lens.get("r_max")
    return fvv.Camera(
        values["id"],
        matrix,
        values["rotation"],
        values["translation"],
        (values["width"], values["height"]),
        lens.get("coefficients", []),
        lens["model"],
        values["name"],
        None if r_max is None or r_max == "unbounded" else float(r_max) if math.isfinite(r_max) else None,
    )
