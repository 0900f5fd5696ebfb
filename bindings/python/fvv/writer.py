"""Streams from arrays, from captures on disk, and from frames that come on a pipe."""

from __future__ import annotations

import os
import threading
import warnings
from collections.abc import Iterable, Mapping, Sequence
from fractions import Fraction
from typing import TYPE_CHECKING, Any, Callable, Union

import numpy

from . import _core
from ._core import Camera, Mesh, Picture, Sound
from .audio import AudioInput, sound_arguments
from .errors import LossWarning, UsageError
from .frames import Key
from .meshes import MeshArrays, MeshLike, mesh_arrays
from .options import OF_CAPTURES, camera_names, option_texts
from .outputs import (
    FileOutput,
    FolderOutput,
    ObjectOutput,
    Target,
    commit_all,
    discarded_unless_written,
    output_of,
)

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from ._options import MuxOptions, WriterOptions

#: By identifier or name of a camera, or in the order of `Writer.cameras`, None where there is nothing.
Pictures = Union[Mapping[Key, Any], Sequence[Any]]


#: Kind ("lost", "dropped", "lowered", "raised", "ended"), number of the frame, its age in seconds, and a sentence.
OnEvent = Callable[[str, int, float, str], object]


class _Losses:
    """Warnings of a run, which are raised as `LossWarning` when it is back in Python."""

    def __init__(self) -> None:
        self.texts: list[str] = []
        self._shown = 0

    def __call__(self, text: str) -> None:
        self.texts.append(text)

    def show(self, stacklevel: int) -> None:
        new, self._shown = self.texts[self._shown :], len(self.texts)
        for text in new:
            warnings.warn(text, LossWarning, stacklevel=stacklevel)


class _Calls:
    """What the core calls while it encodes. It has no reference to the writer, which is collected like any object."""

    def __init__(self, progress: Callable[[int], object] | None) -> None:
        self.output: FileOutput | ObjectOutput
        self.losses = _Losses()
        self._progress = progress
        self._done = 0

    def write(self, data: memoryview) -> None:
        self.output.write(data)

    def step(self, frames: int) -> None:
        self._done += frames
        if self._progress is not None:
            self._progress(self._done)


class Writer:
    """Writes a stream, frame by frame.

    target: a path, which exists when the stream is whole; a binary file object, which is not closed; or a function that
    takes bytes, for live streams. cameras: in the order of pictures without names. rate: frames per second.
    audio: `AudioInput`, or `Sound` of a clip, whose packets stay as they are (one that moves is heard everywhere then).
    options: those of `fvvmux`, with its words and defaults: `fvvmux --bit-depth 10` is `bit_depth=10`, `--max-error 1mm` is
    `max_error="1mm"`, `--no-delta` is `no_delta=True`. force: replaces an existing file.
    name: of the scene. up: "+y", ...: the axis that points up. scale_unknown: lengths are in an unknown unit.
    progress: called with the number of frames that are encoded.

    A group of frames (`group`, one second) is encoded when its last frame is added; decisions for all of the stream are made
    by the first group with a mesh. `UsageError` for what cannot be written; a frame that was refused may be
    given again. Any other exception ends the writer, and leaves no file. What cannot be kept is a `LossWarning`.

    One thread at a time. `with` finishes; an exception inside of it leaves no file.
    """

    def __init__(
        self,
        target: Target,
        *,
        rate: float | Fraction,
        cameras: Iterable[Camera] = (),
        audio: Iterable[AudioInput | Sound] = (),
        force: bool = False,
        name: str = "",
        up: str | None = None,
        scale_unknown: bool = False,
        progress: Callable[[int], object] | None = None,
        **options: Unpack[WriterOptions],
    ) -> None:
        #: Of all frames.
        self.cameras = tuple(cameras)
        #: What `finish` returned; None before.
        self.summary: dict[str, Any] | None = None
        self.rate = _rate_of(rate)
        if up not in (None, "+x", "+y", "+z", "-x", "-y", "-z"):
            raise UsageError(f'up: expected "+x", "+y", "+z", "-x", "-y", "-z" or None, found {up!r}')
        for option in sorted((OF_CAPTURES - {"cameras", "up"}) & options.keys()):
            raise UsageError(f"{option}: is an option of fvv.mux, a writer has none")
        for camera in self.cameras:
            if not isinstance(camera, Camera):
                raise UsageError(f"cameras: expected fvv.Camera, found {type(camera).__name__}")
        identifiers = [camera.id for camera in self.cameras]
        for identifier in identifiers:
            if identifiers.count(identifier) > 1:
                raise UsageError(f"cameras: two of them have the identifier {identifier}")
        self._scene = (name, up or "", scale_unknown)
        self._sounds = [sound_arguments(one, i) for i, one in enumerate(audio)]
        self._given: tuple[tuple[bool, ...], ...] = ()
        self._start = Fraction(0)
        self._ended: str | None = None
        self._lost_uvs = False
        self._lock = threading.Lock()
        self._process = os.getpid()
        calls = _Calls(progress)
        self._losses = calls.losses
        # Wrong options are refused before anything is created.
        self._core = _core.FrameWriter(
            option_texts(options),
            calls.write,
            calls.losses,
            None if progress is None else calls.step,
        )
        self._output = calls.output = output_of(target, force)

    @property
    def frames(self) -> int:
        """How many were added."""
        return self._core.frames

    @property
    def closed(self) -> bool:
        """Whether it is finished, was closed, or ended by an exception."""
        return self._ended is not None

    def add(
        self,
        mesh: MeshLike | None = None,
        pictures: Pictures | None = None,
        masks: Pictures | None = None,
        *,
        time: float | Fraction | None = None,
        calibration: Pictures | None = None,
        visibility: Pictures | None = None,
    ) -> None:
        """The next frame. Arrays are copied.

        mesh: an `fvv.Mesh`, (positions, indices[, normals[, uvs]]), or an object with vertices and faces; None: the stage is
        empty. pictures, masks, calibration, visibility: by camera. The first frame says which cameras have them; all
        frames have the same.
        pictures: (height, width, 3) of the camera's size: uint8 sRGB, uint16 for video of more than 8 bits, floats for OpenEXR
        (linear light, 1 for white). masks: (height, width) uint8, above 127 where the scene is, or bool.
        calibration: the `Camera` of this frame. visibility: uint8 (vertices,), 0 nothing to 255 everything.
        time: seconds; has to be that of the frame at the writer's rate, counted from the first frame's.
        """
        with self._using():
            self._check_time(time)
            where = f"frame {self.frames}"
            arrays = None if mesh is None else mesh_arrays(mesh, f"{where}: mesh")
            found = (
                self._by_camera(pictures, "pictures", where),
                self._by_camera(masks, "masks", where),
                self._by_camera(calibration, "calibration", where),
                self._by_camera(visibility, "visibility", where),
            )
            pixels = None if found[0] is None else [_pixels(one) for one in found[0]]
            masks_ = None if found[1] is None else [_pixels(one) for one in found[1]]
            self._check_calibration(found[2], where)
            weights = (
                None
                if found[3] is None
                else [None if w is None else numpy.ascontiguousarray(w) for w in found[3]]
            )
            self._check_given(found, where, mesh is None)
            if not self._lost_uvs and _has_uvs(arrays):
                self._lost_uvs = True
                self._losses(
                    "texture coordinates are left out: the pictures of a writer are those of cameras"
                )
            self._run(lambda: self._core.add(arrays, pixels, masks_, found[2], weights))

    def extend(self, frames: Iterable[Mapping[str, Any] | Sequence[Any]]) -> None:
        """Adds frames, such as those of a generator: dicts of the arguments of `add`, or tuples (mesh, pictures, masks)."""
        for frame in frames:
            if isinstance(frame, Mapping):
                self.add(**frame)
            else:
                self.add(*frame)

    def finish(self) -> dict[str, Any]:
        """Writes what is left, index and footer; the file has its name then. Returns what `fvvmux --json` prints
        (spec/fvvmux.schema.json) and "warnings", a list."""
        with self._using():
            if not self.frames:
                self._abandon("nothing was added")
                raise UsageError("expected at least one frame before finish")
            try:
                summary: dict[str, Any] = self._run(lambda: self._core.finish(self._output.name))
                self._output.commit()
            except BaseException as error:
                if self._ended is None:
                    self._abandon(f"failed: {error}")
                raise
            self._ended = "is finished"
            summary["warnings"] = list(self._losses.texts)
            self.summary = summary
            return summary

    def close(self) -> None:
        """Gives the stream up, unless it is finished: leaves no file. May be called again. A process that was forked leaves it
        alone."""
        if self._process != os.getpid():
            return
        with self._using(closed=True):
            if self._ended is None:
                self._abandon("was closed")

    def __enter__(self) -> Writer:
        with self._using():
            return self

    def __exit__(self, kind: type[BaseException] | None, *_: object) -> None:
        if kind is not None:
            self.close()
        elif not self.closed:
            self.finish()

    def __del__(self) -> None:
        if hasattr(self, "_output") and self._ended is None and self._process == os.getpid():
            self._abandon("was collected")

    def __repr__(self) -> str:
        return f"<fvv.Writer {self._output.name}: {self.frames} frames{', ' + self._ended if self._ended else ''}>"

    def _using(self, closed: bool = False) -> _Turn:
        return _Turn(self, closed)

    def _abandon(self, why: str) -> None:
        self._ended = why
        self._core.close()
        self._output.discard()

    def _run(self, call: Callable[[], Any]) -> Any:
        try:
            result = call()
        except BaseException as error:
            if self._core.failed:
                self._abandon(f"failed: {error}")
            raise
        finally:
            self._losses.show(stacklevel=4)
        return result

    def _check_time(self, time: float | Fraction | None) -> None:
        if time is None:
            return
        number = self.frames
        try:
            given = Fraction(time)
        except (ValueError, OverflowError, TypeError):
            raise UsageError(f"frame {number}: time: expected seconds, found {time!r}") from None
        if not number:
            self._start = given
        expected = self._start + number / self.rate
        if abs(given - expected) * self.rate > Fraction(1, 4):
            raise UsageError(
                f"frame {number}: time: expected {float(expected):.6g} s at {float(self.rate):.6g} frames per second, found "
                f"{float(given):.6g} s; a moment without a mesh is add(None, ...)"
            )

    def _by_camera(self, given: Pictures | None, name: str, where: str) -> list[Any] | None:
        """In the order of the cameras, None where there is nothing."""
        if given is None:
            return None
        if isinstance(given, Mapping):
            found = []
            taken = 0
            for camera in self.cameras:
                keys = [key for key in (camera.id, camera.name) if key != "" and key in given]
                if len(keys) > 1:
                    keys = [camera.id]
                taken += len(keys)
                found.append(given[keys[0]] if keys else None)
            if taken != len(given):
                raise UsageError(
                    f"{where}: {name}: expected identifiers or names of the writer's cameras, found "
                    f"{', '.join(repr(key) for key in given)}"
                )
            return found
        found = list(given)
        if len(found) != len(self.cameras):
            raise UsageError(
                f"{where}: {name}: expected one for each of {len(self.cameras)} cameras, found {len(found)}"
            )
        return found

    def _check_calibration(self, calibration: list[Any] | None, where: str) -> None:
        for camera, one in zip(self.cameras, calibration or ()):
            if one is None:
                continue
            if not isinstance(one, Camera):
                raise UsageError(f"{where}: calibration: expected fvv.Camera, found {type(one).__name__}")
            expected = (camera.id, camera.width, camera.height, camera.lens)
            found = (one.id, one.width, one.height, one.lens)
            if found != expected:
                raise UsageError(
                    f"{where}: calibration: expected identifier, size and lens {expected}, found {found}"
                )

    def _check_given(self, found: tuple[list[Any] | None, ...], where: str, is_empty: bool) -> None:
        """Configures the encoder by the first frame, and compares the others with it."""
        given = tuple(
            tuple(one is not None for one in part) if part is not None else (False,) * len(self.cameras)
            for part in found
        )
        for camera, has_image, has_mask in zip(self.cameras, given[0], given[1]):
            if has_mask and not has_image:
                raise UsageError(
                    f"{where}: masks: expected with a picture of camera {camera.id}, found alone"
                )
        if not self.frames:  # a first frame that was refused decides nothing
            numerator, denominator = (1 / self.rate).as_integer_ratio()
            flags = list(zip(*given))
            name, up, scale_unknown = self._scene
            self._core.configure(
                name, numerator, denominator, list(self.cameras), flags, self._sounds, up, scale_unknown
            )
            self._given = given
        for i, name in enumerate(("pictures", "masks", "calibration", "visibility")):
            if given[i] != self._given[i] and not (name == "visibility" and is_empty):
                expected, here = (
                    [camera.id for camera, one in zip(self.cameras, flags) if one]
                    for flags in (self._given[i], given[i])
                )
                raise UsageError(
                    f"{where}: {name}: expected of cameras {expected}, as in the first frame, found of {here}"
                )


class _Turn:
    """The use of a writer by one call: another one meanwhile, from a sink or a thread, is refused."""

    def __init__(self, writer: Writer, closed: bool) -> None:
        self._writer = writer
        self._closed = closed

    def __enter__(self) -> None:
        if self._writer._process != os.getpid():
            raise UsageError(
                "the writer belongs to the process that made it, and not to one that was forked from it"
            )
        if not self._writer._lock.acquire(blocking=False):
            raise UsageError("the writer is in use by another call")
        if self._writer._ended is not None and not self._closed:
            self._writer._lock.release()
            raise UsageError(f"the writer cannot be used any more: it {self._writer._ended}")

    def __exit__(self, *_: object) -> None:
        self._writer._lock.release()


def _has_uvs(arrays: Mesh | MeshArrays | None) -> bool:
    if arrays is None:
        return False
    return (arrays.uvs if isinstance(arrays, Mesh) else arrays[3]) is not None


def _rate_of(rate: float | Fraction) -> Fraction:
    try:
        found = Fraction(rate).limit_denominator(100000)
    except (ValueError, OverflowError, TypeError):
        raise UsageError(f"rate: expected frames per second above 0, found {rate!r}") from None
    if not (found > 0 and found.numerator < 1 << 32):
        raise UsageError(f"rate: expected frames per second above 0 and below 2^32, found {rate!r}")
    return found


def _pixels(image: Any) -> Any:
    """An array that the core reads: rows of pixels without gaps inside, in types that it has."""
    if image is None:
        return None
    if isinstance(image, Picture):
        image = image.whole()
    array = numpy.asarray(image)
    if array.dtype.kind == "f" and array.dtype != numpy.float32:
        array = array.astype(numpy.float32)
    array = array.astype(array.dtype.newbyteorder("="), copy=False)
    dense = array.ndim >= 2 and array.strides[1:] == tuple(
        array.itemsize * n for n in ((array.shape[2], 1) if array.ndim == 3 else (1,))
    )
    return array if dense else numpy.ascontiguousarray(array)


def mux(
    capture: str | os.PathLike[str] | None,
    target: Target,
    *,
    cameras: str | Iterable[int | str] | None = None,
    force: bool = False,
    segments: str | os.PathLike[str] | None = None,
    write_capture: str | os.PathLike[str] | None = None,
    progress: Callable[[int, int], object] | None = None,
    **options: Unpack[MuxOptions],
) -> dict[str, Any]:
    """Packs a capture on disk into a stream, as `fvvmux` does, with the same bytes.

    capture: capture.json or its folder (spec/capture.md), or the folder of a COLMAP model or of nerfstudio's transforms.json;
    None: meshes names them all. meshes ("f/%04d.obj"), atlas, pictures, masks, fps, units, up, bake_repeats: in place of a
    capture.json (docs/tools/fvvmux-inputs.md); write_capture: a file for the capture.json that they amount to. target, force, options: as `Writer` has them.
    cameras: identifiers, ranges ("2-5") or names of those to take. verify=True: reads the file back and compares everything
    with the capture. segments: a folder that does not exist or is empty, for the stream in files (docs/tools/fvvserve.md). progress: called with frames done and frames in all.

    Returns what `fvvmux --json` prints, and "warnings". Raises `UsageError`, `DamagedError` for files of the capture that
    cannot be used, and `OSError`; nothing is left of the stream then.
    """
    path = "" if capture is None else os.fspath(capture)
    chosen = camera_names(cameras)
    texts = option_texts(options)
    if not path and "meshes" not in texts:
        raise UsageError("capture: expected a path, or None and meshes, found None")
    verifies = texts.get("verify") == "on"
    calls = _Calls(None if progress is None else lambda done: progress(done, muxer.frame_count))
    folder = described = None
    output = calls.output = output_of(target, force, _core.files_of(path, texts) if force else ())
    try:
        if output.temporary is None and (verifies or segments is not None):
            raise UsageError(f"{'verify' if verifies else 'segments'}: {output.name} cannot be read back")
        if segments is not None:
            folder = FolderOutput(os.fspath(segments))
        if write_capture is not None:
            described = FileOutput(
                os.fspath(write_capture), force, _core.files_of(path, texts) if force else ()
            )
            described.write(_core.describe_inputs(path, texts, described.name).encode())
        muxer = _core.CaptureMuxer(
            path, chosen, texts, calls.write, calls.losses, None if progress is None else calls.step
        )
        muxer.run()
        output.flush()
        if verifies and output.temporary is not None:
            muxer.verify(output.temporary)
        summary: dict[str, Any] = muxer.result(output.name)
        if folder is not None and output.temporary is not None:
            groups, size, rungs = _core.write_segments(output.temporary, folder.write_file)
            summary["segments"] = {"folder": folder.name, "groups": groups, "bytes": size}
            if rungs > 1:
                summary["segments"]["rungs"] = rungs
        commit_all([one for one in (output, folder, described) if one is not None])
    finally:
        output.discard()
        if described is not None:
            described.discard()
        if folder is not None:
            folder.discard()
        calls.losses.show(stacklevel=3)
    summary["warnings"] = calls.losses.texts
    return summary


def pack_pipe(
    pipe: int,
    target: Target,
    *,
    max_delay: float = 2.0,
    idle: float = 10.0,
    force: bool = False,
    on_event: OnEvent | None = None,
    **options: Unpack[WriterOptions],
) -> dict[str, Any]:
    """Packs the frames that another thread or process writes to a pipe (spec/frame-pipe.md), until it ends.

    pipe: a descriptor, which is read and stays open. target: as `fvv.Writer` has it. max_delay: seconds from a frame to the last
    byte of its group; older frames are dropped. idle: seconds without a frame after which the stream ends. on_event: called on this
    thread. options: those of `fvv.Writer`; the preset is "live" unless it is given. Returns what `fvvmux --json` prints, with
    "warnings", and "warned": whether frames were lost or dropped, or the pipe ended early. Errors are those of `fvv.mux`.
    """
    if not (max_delay > 0 and idle > 0):
        raise UsageError(f"expected max_delay and idle above 0, found {max_delay:g} and {idle:g}")
    for option in sorted((OF_CAPTURES - {"cameras", "up"}) & options.keys()):
        raise UsageError(f"{option}: is an option of fvv.mux, a pipe has none")
    texts = {"preset": "live", **option_texts(options)}
    losses: list[str] = []
    output = output_of(target, force)
    with discarded_unless_written(output):
        summary = _core.pack_pipe(
            pipe,
            texts,
            max_delay,
            idle,
            output.name,
            output.write,
            losses.append,
            on_event or (lambda kind, frame, age, text: None),
        )
        output.commit()
    for loss in losses:
        warnings.warn(loss, LossWarning, stacklevel=2)
    summary["warnings"] = losses
    return summary
