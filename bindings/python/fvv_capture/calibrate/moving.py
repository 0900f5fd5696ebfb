"""Cameras that move: their pose, and with a zoom their focal length, in each frame, by points of the scene that stand still."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from typing import Any

import numpy
from fvv.errors import Error, UsageError
from fvv.interop.optional_import import optional_import
from numpy.typing import NDArray

from ..opencv import cv2, named, quiet, sift
from .calibration import FEWEST_STILL, CalibratedCamera, Calibration, Moment, Progress
from .lenses import Lens
from .poses import Pose
from .recordings import Recording

optimize: Any = optional_import("scipy.optimize", "capture")
sparse: Any = optional_import("scipy.sparse", "capture")
csgraph: Any = optional_import("scipy.sparse.csgraph", "capture")
spatial: Any = optional_import("scipy.spatial", "capture")

Floats = NDArray[numpy.float64]
Ints = NDArray[numpy.int64]
Bytes = NDArray[numpy.uint8]

#: Features of a picture at most.
FEATURES = 3000
#: A feature matches if the second-best is this much farther (Lowe, 2004).
RATIO = 0.8
#: Pictures of which a still camera's plate is the median: what moves in front of it is in few of them.
PLATE_FRAMES = 9
#: A triangulated point must be this near, in pixels, to where both cameras see it; and its rays must meet at this angle at least.
NEAR, ANGLE = 2.0, numpy.radians(1.5)
#: Pixels up to which a match supports a pose.
SUPPORT = 5.0
#: Matches below which a frame has no calibration.
FEWEST_MATCHES = 15
#: Product of the descriptors of a feature and a point that lies where the feature is, from which they are taken for one.
ALIKE = 0.7
#: Rows of a table of products that are in memory at once.
CHUNK = 512
#: Looks that are kept of a point: the moving camera adds what it saw to those of the still ones.
MOST_LOOKS = 6
#: Metres at which features of a camera on a tripod are put: a camera that only turns shows no distances.
FAR = 10.0
#: Part of a picture's features that must be known, below which the others become known as well.
FAMILIAR = 0.5
#: Factors of the last frame's focal length that are tried with a zoom.
ZOOMS = (1.0, 0.96, 1.04, 0.88, 1.13, 0.75, 1.33, 0.55, 1.8)


@dataclasses.dataclass
class Landmarks:
    """Points of the scene, and how they look."""

    points: Floats  #: (points, 3) metres.
    looks: NDArray[numpy.float32]  #: (looks, 128) SIFT descriptors.
    owners: Ints  #: (looks,) the point of each.


def track(
    calibration: Calibration,
    recordings: Sequence[Recording],
    moving: Sequence[str],
    first: int = 0,
    step: int = 1,
    last: int | None = None,
    zoom: bool = False,
    tripod: Sequence[str] = (),
    progress: Progress | None = None,
) -> Calibration:
    """The calibration with `per_frame` of the cameras in `moving` and `tripod`.

    tripod: cameras that turn, and zoom, and stay where they are; in the first frame they have the pose of the calibration. They need no
    still cameras: the directions of the first picture's features are known, and each frame is matched to them. As they turn, features
    at the edge are added by the pose that was found, so that errors grow slowly with the angle.

    recordings: of the take, of the same cameras; a frame of the moving cameras gets a pose if FEWEST_MATCHES points support it.
    Features (SIFT; Lowe, 2004) that two still cameras see are triangulated; each frame of a camera in `moving` is matched to them, its
    pose found by RANSAC and refined on a robust sum of squares. zoom: both focal lengths are found as well, by one factor; the
    principal point and the lens are kept.

    `UsageError`: a camera that is not known, or fewer than three that stand still. `Error`: they have too few points in common, or
    a moving camera has no frame with a pose."""
    for name in (*moving, *tripod):
        calibration.camera(name)
        if name not in [one.name for one in recordings]:
            raise UsageError(f"moving: camera {name} has no recording")
    if not moving and not tripod or set(moving) & set(tripod):
        raise UsageError(
            "moving: expected cameras that move or that turn on a tripod, each in one of the two lists"
        )
    known = {one.name for one in calibration.cameras}
    still = [one for one in recordings if one.name in known - {*moving, *tripod}]
    if moving and len(still) < FEWEST_STILL:
        raise UsageError(
            f"moving: expected {FEWEST_STILL} cameras or more that stand still, found {len(still)}"
        )
    cameras = {one.name: one for one in calibration.cameras}
    with quiet():
        landmarks = _landmarks(calibration, still, first, last, progress) if moving else None
        for recording in recordings:
            if recording.name in moving or recording.name in tripod:
                tracker = _Tracker(
                    cameras[recording.name], landmarks if recording.name in moving else None, zoom
                )
                moments = _follow(tracker, recording, first, step, last, progress)
                cameras[recording.name] = dataclasses.replace(cameras[recording.name], per_frame=moments)
    return dataclasses.replace(calibration, cameras=tuple(cameras[one.name] for one in calibration.cameras))


def _follow(
    tracker: _Tracker,
    recording: Recording,
    first: int,
    step: int,
    last: int | None,
    progress: Progress | None,
) -> dict[int, Moment | None]:
    """The camera in each frame of its recording. `Error`: in none."""
    out: dict[int, Moment | None] = {}
    of = -(-recording.count() // step)
    for frame, grey in recording.frames(first, step, last):
        _check_size(tracker.camera, recording, frame, grey)
        with named(recording.path, frame):
            out[frame] = tracker.next(grey)
        if progress is not None:
            progress(f"camera {recording.name}", len(out), max(len(out), of))
    if not any(out.values()):
        raise Error(
            f"camera {recording.name}: no frame shows {FEWEST_MATCHES} of the points that are known",
            file=recording.path,
        )
    return out


def _check_size(camera: CalibratedCamera, recording: Recording, frame: int, grey: Bytes) -> None:
    if grey.shape != (camera.lens.height, camera.lens.width):
        raise Error(
            f"{recording.path}: frame {frame}: expected a picture of {camera.lens.width}x{camera.lens.height}, found "
            f"{grey.shape[1]}x{grey.shape[0]}",
            file=recording.path,
        )


def _features(grey: Bytes) -> tuple[Floats, NDArray[numpy.float32]]:
    """(features, 2) pixels, the centre of the first at 0.5, and their descriptors (features, 128).

    With the square roots of SIFT's numbers the Euclidean distance is Hellinger's (Arandjelovic and Zisserman, 2012: RootSIFT)."""
    detector, off = sift(FEATURES, 0.02)
    points, looks = detector.detectAndCompute(grey, None)
    if looks is None:
        return numpy.zeros((0, 2)), numpy.zeros((0, 128), numpy.float32)
    looks = numpy.sqrt(looks / numpy.maximum(looks.sum(axis=1, keepdims=True), 1e-9)).astype(numpy.float32)
    return numpy.array([one.pt for one in points]) - off + 0.5, looks


def _landmarks(
    calibration: Calibration,
    still: Sequence[Recording],
    first: int,
    last: int | None,
    progress: Progress | None,
) -> Landmarks:
    """Points that two still cameras see."""
    seen = []
    for i, recording in enumerate(still):
        if progress is not None:
            progress("still cameras", i, len(still))
        plate = _plate(calibration.camera(recording.name), recording, first, last)
        seen.append((calibration.camera(recording.name), *_features(plate)))
    # A graph of all features: those of one point of the scene are connected.
    starts = numpy.cumsum([0, *(len(pixels) for _, pixels, _ in seen)])
    edges, points = [numpy.zeros((0, 2), int)], [numpy.zeros((0, 3))]
    for i in range(len(seen)):
        for j in range(i + 1, len(seen)):
            (a, pixels_a, looks_a), (b, pixels_b, looks_b) = seen[i], seen[j]
            pairs = _mutual(looks_a, looks_b, numpy.arange(len(looks_b)))
            found, good = _triangulated(a, pixels_a[pairs[:, 0]], b, pixels_b[pairs[:, 1]])
            points.append(found[good])
            edges.append(pairs[good] + [starts[i], starts[j]])
    links, places = numpy.concatenate(edges), numpy.concatenate(points)
    size = int(starts[-1])
    graph = sparse.coo_matrix((numpy.ones(len(links)), (links[:, 0], links[:, 1])), shape=(size, size))
    labels = csgraph.connected_components(graph, directed=False)[1]
    names, owners = numpy.unique(labels[links[:, 0]], return_inverse=True)
    if len(names) < FEWEST_MATCHES:
        raise Error(
            f"still cameras: expected {FEWEST_MATCHES} points of the scene that two of them see, found {len(names)}; is there texture in it, "
            "and are two cameras within about 40 degrees of each other?"
        )
    counts = numpy.bincount(owners)
    mean = numpy.stack([numpy.bincount(owners, places[:, axis]) / counts for axis in range(3)], axis=1)
    used = numpy.flatnonzero(numpy.isin(labels, names))
    looks = numpy.concatenate([one for _, _, one in seen])[used]
    return Landmarks(mean, looks, numpy.searchsorted(names, labels[used]))


def _plate(camera: CalibratedCamera, recording: Recording, first: int, last: int | None) -> Bytes:
    """The median of pictures of the whole take."""
    end = recording.count() - recording.offset - 1 if last is None else last
    step = max(1, (end - first) // max(PLATE_FRAMES - 1, 1))
    pictures = []
    for frame, grey in recording.frames(first, step, last):
        _check_size(camera, recording, frame, grey)
        pictures.append(grey)
        if len(pictures) == PLATE_FRAMES:
            break
    if not pictures:
        raise Error(f"{recording.path}: has no picture in the frames that are used", file=recording.path)
    plate: Bytes = numpy.median(numpy.stack(pictures), axis=0).astype(numpy.uint8)
    return plate


def _mutual(a: NDArray[numpy.float32], b: NDArray[numpy.float32], owners: Ints) -> Ints:
    """(matches, 2): descriptors of a and b that are each other's nearest, and clearly nearer than the nearest of another point.
    owners: (b,) the point that each of b belongs to."""
    if len(a) < 2 or len(b) < 2:
        return numpy.zeros((0, 2), int)
    best = numpy.zeros(len(a), int)
    first, second = numpy.zeros(len(a)), numpy.zeros(len(a))
    back, back_value = numpy.zeros(len(b), int), numpy.full(len(b), -1.0)
    for start in range(0, len(a), CHUNK):
        table = a[start : start + CHUNK] @ b.T
        rows = numpy.arange(len(table))
        here = table.argmax(axis=0)
        value = table[here, numpy.arange(len(b))]
        back = numpy.where(value > back_value, here + start, back)
        back_value = numpy.maximum(back_value, value)
        chosen = table.argmax(axis=1)
        best[start + rows], first[start + rows] = chosen, table[rows, chosen]
        table[owners[None] == owners[chosen][:, None]] = -1
        second[start + rows] = table.max(axis=1)
    # Of descriptors of unit length: their squared distance is 2 - 2 times their product.
    clear = (1 - first) < RATIO**2 * (1 - second)
    mutual = back[best] == numpy.arange(len(a))
    kept = numpy.flatnonzero(clear & mutual)
    return numpy.stack([kept, best[kept]], axis=1)


def _triangulated(
    a: CalibratedCamera, pixels_a: Floats, b: CalibratedCamera, pixels_b: Floats
) -> tuple[Floats, NDArray[numpy.bool_]]:
    """Points (matches, 3), and which of them are where both cameras see them."""
    homogeneous = cv2.triangulatePoints(
        _matrix(a.pose), _matrix(b.pose), a.lens.rays(pixels_a).T.copy(), b.lens.rays(pixels_b).T.copy()
    )
    with numpy.errstate(divide="ignore", invalid="ignore"):
        points: Floats = (homogeneous[:3] / homogeneous[3]).T
    good = numpy.isfinite(points).all(axis=1)
    points = numpy.where(good[:, None], points, 0)
    towards = []
    for camera, pixels in ((a, pixels_a), (b, pixels_b)):
        own = camera.pose(points)
        front = own[:, 2] > 0.05
        own = numpy.where(front[:, None], own, [0.0, 0.0, 1.0])
        good &= front & (numpy.linalg.norm(camera.lens.project(own)[0] - pixels, axis=1) < NEAR)
        ray = points - camera.pose.centre
        towards.append(ray / numpy.maximum(numpy.linalg.norm(ray, axis=1, keepdims=True), 1e-9))
    good &= (towards[0] * towards[1]).sum(axis=1) < numpy.cos(ANGLE)
    return points, good


def _matrix(pose: Pose) -> Floats:
    return numpy.concatenate([pose.rotation, pose.translation[:, None]], axis=1)


class _Tracker:
    """One moving camera, frame by frame."""

    def __init__(self, camera: CalibratedCamera, landmarks: Landmarks | None, zoom: bool) -> None:
        """landmarks None: the camera is on a tripod."""
        self.camera = camera
        self._known = landmarks
        self._tripod = landmarks is None
        self._zoom = zoom
        self._factor = 1.0

    def next(self, grey: Bytes) -> Moment | None:
        """The camera in the next frame; None if too few points are found."""
        pixels, looks = _features(grey)
        if self._known is None:
            if len(pixels) < FEWEST_MATCHES:
                return None
            self._known = Landmarks(numpy.zeros((0, 3)), looks[:0], numpy.zeros(0, int))
            self._add(self.camera.pose, self.camera.lens, pixels, looks)
            return Moment(self.camera.lens, self.camera.pose, len(pixels), 0.0)
        known = self._known
        pairs = _mutual(looks, known.looks, known.owners)
        if len(pairs) < FEWEST_MATCHES // 2:
            return None
        start = self._start(known, pixels[pairs[:, 0]], known.owners[pairs[:, 1]])
        if start is None:
            return None
        features, owners = self._guided(known, *start, pixels, looks, 3 * SUPPORT)
        if len(features) < FEWEST_MATCHES:
            return None
        moment = self._refined(*start, pixels[features], known.points[owners])
        # Once more, by the better pose.
        features, owners = self._guided(known, moment.pose, moment.lens, pixels, looks, SUPPORT)
        if len(features) < FEWEST_MATCHES:
            return None
        moment = self._refined(moment.pose, moment.lens, pixels[features], known.points[owners])
        if moment.matches < FEWEST_MATCHES:
            return None
        start = (moment.pose, moment.lens)
        self._learn(looks[features], owners)
        if self._tripod and len(features) < FAMILIAR * len(pixels):
            others = numpy.setdiff1d(numpy.arange(len(pixels)), features)
            self._add(*start, pixels[others], looks[others])
        self._factor = float(start[1].parameters[0] / self.camera.lens.parameters[0])
        return moment

    def _placed(self, rotation: Floats, translation: Floats) -> Pose:
        """On a tripod the centre stays where it is, whatever the translation."""
        return Pose(rotation, -rotation @ self.camera.pose.centre if self._tripod else translation)

    def _add(self, pose: Pose, lens: Lens, pixels: Floats, looks: NDArray[numpy.float32]) -> None:
        """Features of a camera on a tripod become known by their directions."""
        assert self._known is not None
        rays = numpy.concatenate([lens.rays(pixels), numpy.ones((len(pixels), 1))], axis=1)
        rays *= FAR / numpy.linalg.norm(rays, axis=1, keepdims=True)
        known = self._known
        self._known = Landmarks(
            numpy.concatenate([known.points, pose.inverse()(rays)]),
            numpy.concatenate([known.looks, looks]),
            numpy.concatenate([known.owners, len(known.points) + numpy.arange(len(pixels))]),
        )

    def _start(self, known: Landmarks, pixels: Floats, owners: Ints) -> tuple[Pose, Lens] | None:
        """By RANSAC; with a zoom, for several focal lengths, of which the one with most support is taken."""
        best: tuple[int, Pose, Lens] | None = None
        for zoom in ZOOMS if self._zoom else (1.0,):
            lens = self.camera.lens.scaled(self._factor * zoom)
            found, rotation, translation, support = cv2.solvePnPRansac(
                known.points[owners],
                lens.rays(pixels),
                numpy.eye(3),
                None,
                iterationsCount=400,
                reprojectionError=SUPPORT / lens.parameters[0],
                confidence=0.999,
                flags=cv2.SOLVEPNP_SQPNP,
            )
            if not found or support is None:
                continue
            if best is None or len(support) > best[0]:
                best = (len(support), self._placed(cv2.Rodrigues(rotation)[0], translation.reshape(3)), lens)
            if zoom == 1.0 and len(support) > 0.8 * len(owners):
                break
        return None if best is None or best[0] < FEWEST_MATCHES // 2 else best[1:]

    def _guided(
        self,
        known: Landmarks,
        pose: Pose,
        lens: Lens,
        pixels: Floats,
        looks: NDArray[numpy.float32],
        near: float,
    ) -> tuple[Ints, Ints]:
        """Features and points that look alike, and whose distance is below `near` pixels with this pose: one feature for each
        point, one point for each feature."""
        own = pose(known.points)
        front = own[:, 2] > 0.05
        places = lens.project(numpy.where(front[:, None], own, [0.0, 0.0, 1.0]))[0]
        inside = front & (places > 0).all(axis=1) & (places < [lens.width, lens.height]).all(axis=1)
        shown = numpy.flatnonzero(inside[known.owners])
        near_ones = spatial.cKDTree(pixels).query_ball_point(places[known.owners[shown]], near)
        look = numpy.repeat(shown, [len(one) for one in near_ones])
        feature = numpy.concatenate([numpy.zeros(0, int), *(numpy.array(one, int) for one in near_ones)])
        alike = (known.looks[look] * looks[feature]).sum(axis=1)
        best: dict[int, int] = {}
        taken: set[int] = set()
        for i in numpy.argsort(-alike):
            if alike[i] < ALIKE:
                break
            point = int(known.owners[look[i]])
            if point not in best and int(feature[i]) not in taken:
                best[point] = int(feature[i])
                taken.add(int(feature[i]))
        return numpy.array(list(best.values()), int), numpy.array(list(best), int)

    def _refined(self, pose: Pose, lens: Lens, pixels: Floats, points: Floats) -> Moment:
        """The pose, and with a zoom the focal length, with the least robust sum of squares."""

        # A rotation vector; a translation, unless the camera is on a tripod; the logarithm of the zoom.
        free = 3 if self._tripod else 6

        def moved(x: Floats) -> tuple[Pose, Lens]:
            shift = numpy.zeros(3) if self._tripod else x[3:6]
            turned = self._placed(cv2.Rodrigues(x[:3])[0] @ pose.rotation, pose.translation + shift)
            return turned, lens.scaled(float(numpy.exp(x[free]))) if self._zoom else lens

        def residuals(x: Floats) -> Floats:
            turned, zoomed = moved(x)
            return (zoomed.project(turned(points))[0] - pixels).reshape(-1)

        found = optimize.least_squares(
            residuals,
            numpy.zeros(free + self._zoom),
            loss="soft_l1",
            f_scale=0.7,
            x_scale="jac",
            method="trf",
        )
        turned, zoomed = moved(found.x)
        apart = numpy.linalg.norm(residuals(found.x).reshape(-1, 2), axis=1)
        support = apart < SUPPORT
        rms = float(numpy.sqrt((apart[support] ** 2).mean())) if support.any() else float("inf")
        return Moment(zoomed, turned, int(support.sum()), rms)

    def _learn(self, looks: NDArray[numpy.float32], owners: Ints) -> None:
        """What the points look like from here."""
        assert self._known is not None
        known = self._known
        few = numpy.bincount(known.owners, minlength=len(known.points))[owners] < MOST_LOOKS
        known.looks = numpy.concatenate([known.looks, looks[few]])
        known.owners = numpy.concatenate([known.owners, owners[few]])
