"""From footage and calibration to a capture: keying, visual hulls, files. Frames are independent tasks, in this process, in
processes of this machine or on a Dask cluster; the files are the same."""

from __future__ import annotations

import concurrent.futures
import dataclasses
import functools
import itertools
import json
import multiprocessing
import os
import pickle
import time
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, Callable

import numpy
from fvv import Camera, recordings
from fvv.errors import DamagedError, Error, UsageError
from fvv.interop.optional_import import optional_import
from numpy.typing import NDArray

from . import agreement, hull, refine_surface
from .clean_plate import median_plate, plate_of
from .keying import Key, Keyer, KeyOptions, volume_matte
from .opencv import named

cv2: Any = optional_import("cv2", "capture")

#: A frame that is this part of a frame's duration away from its picture has no other silhouette than the picture's.
_SIMULTANEOUS = 0.05
#: Consecutive frames of a task: a video is read in order within it.
BATCH = 4
#: Pictures that a background, and the colours of the action, are learnt from.
PLATE_PICTURES = 34
LEARN_PICTURES = 12
#: Frames whose masks give the bounds of the action.
BOUNDS_FRAMES = 7

Progress = Callable[[str, int, int], object]


class NothingInCommon(Error):
    """The silhouettes have no volume in common."""


@dataclasses.dataclass(frozen=True)
class Options:
    """How frames are made."""

    key: KeyOptions = dataclasses.field(default_factory=KeyOptions)
    hull: hull.HullOptions = dataclasses.field(default_factory=hull.HullOptions)
    bounds: tuple[tuple[float, float, float], tuple[float, float, float]] | None = (
        None  #: Metres; None: found.
    )
    agree: bool = True  #: Keys are completed by what the other cameras see.
    keep_grids: bool = False  #: Write grids/NNNN.npz beside the meshes.
    refined: bool = False  #: Hollows that no silhouette shows are carved by colour.


@dataclasses.dataclass(frozen=True)
class Work:
    """What every task needs; it is sent to other processes."""

    description: str  #: capture.json without meshes; names are absolute.
    folder: str  #: Where meshes and masks are written; absolute.
    keyers: tuple[str | None, ...]  #: A file of `learn_keyer` for each camera; None: its masks are given.
    options: Options
    bounds: tuple[tuple[float, float, float], tuple[float, float, float]] | None = None
    #: For each camera how much later than its picture a frame is, in frames, -0.5 to 0.5; empty: not at all.
    late: tuple[float, ...] = ()


@dataclasses.dataclass(frozen=True)
class FrameResult:
    """Of one frame."""

    number: int
    iou: list[float | None]  #: Of each camera: silhouette of the mesh against the mask.
    confidence: list[float | None]  #: Of each camera's key; None: the mask was given.
    vertices: int
    faces: int
    components: int
    dropped: int  #: Components that were too small.
    seconds: dict[str, float]  #: Of "read", "key", "carve", "write".
    volume: float  #: Cubic metres that the mesh encloses.
    empty: bool  #: No mesh: nothing is inside the silhouettes.
    size: tuple[float, float, float]  #: Of the mesh along x, y and z, metres.


def open_footage(description: str) -> recordings.Footage:
    """The reader of a capture.json whose names of files are absolute, so that its own place does not count."""
    return recordings.Footage(description, os.path.join(os.sep, "capture.json"))


@functools.lru_cache(maxsize=2)
def _footage(description: str) -> recordings.Footage:
    """One of a process: it keeps videos open."""
    return open_footage(description)


@functools.lru_cache(maxsize=2)
def _second_footage(description: str) -> recordings.Footage:
    """Another one, for pictures whose keys were made before: a video that goes back decodes again from its last key picture."""
    return open_footage(description)


@functools.lru_cache(maxsize=64)
def _key(
    description: str,
    index: int,
    frame: int,
    keyer: str,
    bounds: tuple[tuple[float, float, float], tuple[float, float, float]] | None,
) -> Key:
    """Frames that follow share those of moments between their pictures."""
    footage = _footage(description)
    camera = footage.camera(index, frame)
    matte = None if bounds is None or camera is None else volume_pixels(camera, bounds)
    return _keyer(keyer).key(_picture(footage, index, frame), matte)


def _picture(footage: recordings.Footage, index: int, frame: int) -> NDArray[numpy.uint8]:
    try:
        return footage.picture(index, frame)
    except DamagedError as error:
        name = footage.cameras[index].name or index
        raise DamagedError(
            f"{error}; --exclude {name} goes on without the camera, --frames without frame {frame}",
            file=error.file,
        ) from error


@functools.lru_cache(maxsize=256)
def _keyer(path: str) -> Keyer:
    with open(path, "rb") as file:
        keyer: Keyer = pickle.load(file)  # written by learn_keyer of the same run
    return keyer


def learn_keyer(
    description: str, index: int, path: str, options: KeyOptions, empty: str | None
) -> dict[str, Any]:
    """A task: what the key of a camera has to know of its clip, as a file. description: of the whole clip; empty: of the
    camera's pictures of the empty stage, None: the background is found in the clip. Returns how it keys, for the report."""
    cv2.setNumThreads(1)
    clip = open_footage(description)
    learn = [clip.picture(index, n) for n in spread(clip.frames, PLATE_PICTURES)]
    with named(f"the background of camera {clip.cameras[index].name or index}", is_file=False):
        if empty is not None:
            stage = open_footage(empty)
            plate = plate_of(stage.picture(0, n) for n in stage.frames)
        elif options.mode == "chroma" or len(learn) < 3:
            plate = None
        else:
            plate = median_plate(learn)
        keyer = Keyer(plate, options, learn=[learn[i] for i in spread(range(len(learn)), LEARN_PICTURES)])
    with open(path, "wb") as file:
        pickle.dump(keyer, file)
    return {"mode": keyer.mode, "notes": list(keyer.notes)}


def spread(numbers: Sequence[int], most: int) -> list[int]:
    """At most that many of numbers, evenly, with the first and the last; of one the middle."""
    if len(numbers) <= most:
        return list(numbers)
    if most == 1:
        return [numbers[len(numbers) // 2]]
    return [numbers[round(i * (len(numbers) - 1) / (most - 1))] for i in range(most)]


def keys_of(
    work: Work, frame: int, clock: dict[str, float] | None = None
) -> tuple[list[Camera | None], list[Key | None], list[NDArray[numpy.uint8] | None]]:
    """Cameras at a frame, their keys (None: the mask is given), and their masks (None: not calibrated at that frame)."""
    footage = _footage(work.description)
    clock = {} if clock is None else clock
    cameras: list[Camera | None] = []
    keys: list[Key | None] = []
    masks: list[NDArray[numpy.uint8] | None] = []
    for index, file in enumerate(work.keyers):
        camera = footage.camera(index, frame)
        cameras.append(camera)
        if camera is None:
            keys.append(None)
            masks.append(None)
            continue
        if file is None:
            with _timed(clock, "read"):
                mask = mask_of(work, index, frame)
            keys.append(None)
            masks.append(mask)
            continue
        with _timed(clock, "key"), named(f"camera {camera.name or index}", frame, is_file=False):
            key = _key(work.description, index, frame, file, work.bounds)
        keys.append(key)
        masks.append(key.mask)
    return cameras, keys, masks


def silhouettes(
    work: Work, frame: int, cameras: Sequence[Camera | None], masks: Sequence[NDArray[numpy.uint8] | None]
) -> list[NDArray[numpy.uint8] | None]:
    """The masks at the time of the frame, between those of the picture that is nearest and of the next nearest one: where signed
    distances from their outlines, weighted by time, are above 0 (shape-based interpolation: Raya and Udupa 1990)."""
    frames = _footage(work.description).frames
    out = list(masks)
    for index, (camera, mask) in enumerate(zip(cameras, masks)):
        part = work.late[index] if work.late else 0.0
        other = frame + (1 if part > 0 else -1)
        if (
            mask is None
            or camera is None
            or abs(part) < _SIMULTANEOUS
            or not frames[0] <= other <= frames[-1]
        ):
            continue
        if _footage(work.description).camera(index, other) is None:
            continue
        next_mask = mask_of(work, index, other)
        if mask.any() and next_mask.any():
            between = (1 - abs(part)) * _depth(mask) + abs(part) * _depth(next_mask)
            out[index] = numpy.where(between > 0, 255, 0).astype(numpy.uint8)
    return out


def _depth(mask: NDArray[numpy.uint8]) -> NDArray[numpy.float32]:
    """Pixels from the outline, above 0 inside."""
    inside = (mask > 0).astype(numpy.uint8)
    size = cv2.DIST_MASK_5
    depth: NDArray[numpy.float32] = cv2.distanceTransform(inside, cv2.DIST_L2, size)
    outside: NDArray[numpy.float32] = cv2.distanceTransform(1 - inside, cv2.DIST_L2, size)
    return depth - outside


def mask_of(work: Work, index: int, frame: int) -> NDArray[numpy.uint8]:
    """One camera's mask at a frame, keyed or given."""
    file = work.keyers[index]
    if file is None:
        return numpy.where(_footage(work.description).mask(index, frame) >= 128, 255, 0).astype(numpy.uint8)
    return _key(work.description, index, frame, file, work.bounds).mask


def volume_pixels(
    camera: Camera, bounds: tuple[tuple[float, float, float], tuple[float, float, float]]
) -> NDArray[numpy.uint8]:
    """The pixels that show the bounds; none for a camera that looks elsewhere."""
    try:
        return volume_matte(camera, *bounds)
    except UsageError:
        return numpy.zeros((camera.height, camera.width), numpy.uint8)


class _timed:
    """Adds the seconds of a block to a stage."""

    def __init__(self, clock: dict[str, float], stage: str) -> None:
        self._clock, self._stage = clock, stage

    def __enter__(self) -> None:
        self._start = time.perf_counter()

    def __exit__(self, *_: object) -> None:
        self._clock[self._stage] = self._clock.get(self._stage, 0.0) + time.perf_counter() - self._start


def find_bounds(work: Work, frame: int) -> tuple[list[float], list[float]] | None:
    """A task: the box around what the silhouettes of a frame have in common; None: nothing."""
    cv2.setNumThreads(1)
    cameras, _, masks = keys_of(work, frame)
    return common_box(cameras, masks, work.options.hull, work.options.hull.missed)


def common_box(
    cameras: Sequence[Camera | None],
    masks: Sequence[NDArray[numpy.uint8] | None],
    options: hull.HullOptions,
    missed: int,
) -> tuple[list[float], list[float]] | None:
    """The box around what all silhouettes but `missed` have in common; None: nothing."""
    there = [(c, m) for c, m in zip(cameras, masks) if c is not None]
    try:
        low, high = hull.bounds([c for c, _ in there], [m for _, m in there], missed, options.least_views)
    except Error:
        return None
    return [float(v) for v in low], [float(v) for v in high]


def mask_name(camera: str) -> str:
    """The folder of a camera's masks."""
    return f"masks/{camera.replace('/', '_')}"


def make_frames(work: Work, frames: Sequence[int], names: Sequence[str]) -> list[FrameResult]:
    """A task: masks and mesh of consecutive frames, as files."""
    cv2.setNumThreads(1)  # tasks are what runs at once
    return [_make_frame(work, frame, names) for frame in frames]


def _make_frame(work: Work, frame: int, names: Sequence[str]) -> FrameResult:
    clock: dict[str, float] = {}
    cameras, keys, masks = keys_of(work, frame, clock)
    there = [i for i, camera in enumerate(cameras) if camera is not None]
    seeing = [camera for camera in cameras if camera is not None]
    with _timed(clock, "key"):
        outlines = silhouettes(work, frame, cameras, masks)
        if work.options.agree and work.bounds is not None:
            changed = [None if key is None else key.changed for key in keys]
            options = work.options.hull
            more = agreement.dropped(cameras, outlines, changed, work.bounds, options)
            outlines, masks = agreement.added(outlines, more), agreement.added(masks, more)
    own = [outlines[i] for i in there]
    with _timed(clock, "carve"):
        made = hull.carve(seeing, own, work.bounds, work.options.hull)
        empty = len(made.indices) == 0
        if work.options.refined:
            footage = _second_footage(work.description)
            pictures = [_picture(footage, i, frame) for i in there]
            made = dataclasses.replace(made, positions=refine_surface.refine(made, seeing, pictures, own))
        match = (
            [None] * len(seeing) if empty else hull.silhouette_iou(made.positions, made.indices, seeing, own)
        )
    with _timed(clock, "write"):
        for index, keyer in enumerate(work.keyers):
            if keyer is None:
                continue
            # A frame without a calibration has a file too.
            mask = masks[index]
            mask = _empty(work, index) if mask is None else mask
            _write_png(os.path.join(work.folder, mask_name(names[index]), f"{frame:04d}.png"), mask)
        if not empty:
            write_ply(os.path.join(work.folder, "meshes", f"{frame:04d}.ply"), made.positions, made.indices)
            if work.options.keep_grids:
                made.grid.save(os.path.join(work.folder, "grids", f"{frame:04d}.npz"))
    iou: list[float | None] = [None] * len(cameras)
    for i, value in zip(there, match):
        iou[i] = value
    x, y, z = (0.0, 0.0, 0.0) if empty else numpy.ptp(made.positions, axis=0).tolist()
    return FrameResult(
        frame,
        iou,
        [None if key is None else float(key.confidence) for key in keys],
        len(made.positions),
        len(made.indices),
        made.components,
        made.dropped,
        clock,
        enclosed_volume(made.positions, made.indices),
        empty,
        (x, y, z),
    )


def _empty(work: Work, index: int) -> NDArray[numpy.uint8]:
    camera = _footage(work.description).cameras[index]
    return numpy.zeros((camera.height, camera.width), numpy.uint8)


def enclosed_volume(positions: NDArray[numpy.float64], indices: NDArray[numpy.uint32]) -> float:
    """Of a closed mesh, by the divergence theorem."""
    if not len(indices):
        return 0.0
    a, b, c = (positions[indices[:, k]] - positions[0] for k in range(3))
    return float(numpy.einsum("ij,ij->", a, numpy.cross(b, c)) / 6)


def _write_png(path: str, mask: NDArray[numpy.uint8]) -> None:
    done, data = cv2.imencode(".png", mask, [cv2.IMWRITE_PNG_COMPRESSION, 1, cv2.IMWRITE_PNG_BILEVEL, 1])
    if not done:
        raise Error(f"{path}: OpenCV cannot encode the mask", file=path)
    with open(path, "wb") as file:
        file.write(data.tobytes())


def write_ply(path: str, positions: NDArray[numpy.float64], indices: NDArray[numpy.uint32]) -> None:
    """A mesh as binary PLY: float32 positions, uint32 triangles."""
    faces = numpy.empty(len(indices), numpy.dtype([("count", "u1"), ("indices", "<u4", 3)]))
    faces["count"] = 3
    faces["indices"] = indices
    head = (
        "ply\nformat binary_little_endian 1.0\n"
        f"element vertex {len(positions)}\nproperty float x\nproperty float y\nproperty float z\n"
        f"element face {len(indices)}\nproperty list uchar uint vertex_indices\nend_header\n"
    )
    with open(path, "wb") as file:
        file.write(head.encode())
        file.write(numpy.ascontiguousarray(positions, "<f4").tobytes())
        file.write(faces.tobytes())


class Executors:
    """Where tasks run: this process (jobs 1), processes of this machine, or the workers of a Dask cluster, which must reach
    the same paths."""

    def __init__(self, jobs: int = 1, client: Any = None) -> None:
        self._owned: concurrent.futures.Executor | None = None
        self._executor: Any = None
        if client is not None:
            self._executor = client.get_executor(pure=False) if hasattr(client, "get_executor") else client
        elif jobs > 1:
            # A fork would copy the threads' locks of OpenCV and of the reader in the state that they are in.
            self._owned = concurrent.futures.ProcessPoolExecutor(
                jobs, mp_context=multiprocessing.get_context("spawn")
            )
            self._executor = self._owned

    def __enter__(self) -> Executors:
        return self

    def __exit__(self, kind: object, *_: object) -> None:
        if self._owned is not None:
            self._owned.shutdown(wait=True, cancel_futures=kind is not None)

    def map(self, task: Callable[..., Any], calls: Sequence[tuple[Any, ...]]) -> Iterator[Any]:
        """Results in the order of calls, as they come."""
        if self._executor is None:
            yield from itertools.starmap(task, calls)
            return
        pending = [self._executor.submit(task, *call) for call in calls]
        try:
            for future in pending:
                yield future.result()
        except BaseException:
            for future in pending:
                future.cancel()
            raise


def _no_progress(stage: str, done: int, count: int) -> None:
    """Used where none is wanted."""


def prepare(work: Work, numbers: Sequence[int], run: Executors, progress: Progress) -> Work:
    """The same work with bounds. Raises `NothingInCommon` when nothing is in all silhouettes at any of the frames looked at."""
    if work.options.bounds is not None:
        return dataclasses.replace(work, bounds=work.options.bounds)
    sample = spread(numbers, BOUNDS_FRAMES)
    found = []
    for done, box in enumerate(run.map(find_bounds, [(work, n) for n in sample])):
        progress("find bounds", done + 1, len(sample))
        if box is not None:
            found.append(box)
    if not found:
        raise NothingInCommon(
            f"the silhouettes of {len(sample)} frames have no volume in common: look at the preview (--sheet), and at the calibration"
        )
    low = numpy.min([low for low, _ in found], axis=0)
    high = numpy.max([high for _, high in found], axis=0)
    # Frames between those looked at may reach farther.
    margin = 0.1 * (high - low) if len(numbers) > len(sample) else 0 * low
    low, high = ([float(v) for v in p] for p in (low - margin, high + margin))
    return dataclasses.replace(work, bounds=((low[0], low[1], low[2]), (high[0], high[1], high[2])))


def make(
    work: Work,
    numbers: Sequence[int],
    names: Sequence[str],
    run: Executors,
    progress: Progress = _no_progress,
) -> list[FrameResult]:
    """Masks and meshes of all frames, in work.folder."""
    for folder in ["meshes", *(["grids"] if work.options.keep_grids else [])]:
        os.makedirs(os.path.join(work.folder, folder), exist_ok=True)
    for index, file in enumerate(work.keyers):
        if file is not None:
            os.makedirs(os.path.join(work.folder, mask_name(names[index])), exist_ok=True)
    batches = [list(numbers[i : i + BATCH]) for i in range(0, len(numbers), BATCH)]
    out: list[FrameResult] = []
    for results in run.map(make_frames, [(work, batch, list(names)) for batch in batches]):
        out += results
        progress("key and carve", len(out), len(numbers))
    if all(result.empty for result in out):
        raise Error("no frame has anything inside of its silhouettes: look at the preview (--sheet)")
    return out


def without_meshes(entries: Sequence[Mapping[str, Any]], head: Mapping[str, Any]) -> str:
    """The text of a capture.json that pictures and masks are read by."""
    if not entries:
        raise UsageError("expected a camera or more")
    return json.dumps({**head, "cameras": list(entries)})
