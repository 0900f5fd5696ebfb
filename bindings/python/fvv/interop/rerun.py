"""A clip in Rerun: in a recording, or opened by its viewer, which runs `rerun-importer-fvv` (before 0.32 `rerun-loader-fvv`)."""

from __future__ import annotations

import argparse
import os
import sys
from typing import Any

import numpy
from numpy.typing import NDArray

from .._core import Camera, Mesh, Picture
from ..clip import EVERY, Clip, ClipFrame
from ..errors import Error
from ..frames import ByCamera
from ..pictures import on_screen
from .conventions import straightened
from .optional_import import optional_import
from .samples import h264_samples

#: The first bytes of a stream.
SIGNATURE = b"\x89FVV\r\n\x1a\n"
#: The exit code with which a loader says that a file is none of its own.
INCOMPATIBLE = 66
#: What pictures are compressed with; Rerun keeps all of a recording in memory.
JPEG_QUALITY = 90
GREY = 128
#: Colours of surface that no camera sees, that half of them see, and that all see.
RAMP = ((68, 1, 84), (33, 145, 140), (253, 231, 37))
RAMP_AT = (0.0, 0.5, 1.0)


def log(
    clip: Clip,
    recording: Any = None,
    *,
    prefix: str = "",
    frames: slice = EVERY,
    pictures: bool = True,
    visibility: bool = False,
) -> None:
    """Logs a clip to a `rerun.RecordingStream`; None: the current one. Returns when all frames are logged.

    prefix: entity paths begin with it. Under it are "mesh/TRACK", a `Mesh3D` with the colours, normals or atlas that were sent;
    "cameras/NAME", a `Transform3D`, with "picture" below, a `Pinhole` without lens and skew and the picture as such a camera
    sees it; and "damage", a `TextLog` of what was lost. The time lines are "frame", its number, and "seconds".
    pictures: log those of cameras, and under "video/NAME" as a `VideoStream` the film of all cameras, or of the atlas, as it was
    sent, where it is H.264 and all frames are logged.
    visibility: log under "visibility/TRACK" the first mesh again, where the stream has weights: yellow where all cameras see it,
    dark blue where none does. It is in the same place: hide one of the two.
    Streams that are far from 0 are logged relative to the origin of their lattice: Rerun's numbers are float32.
    """
    _Log(clip, recording, prefix, pictures, visibility).run(frames)


class _Log:
    def __init__(self, clip: Clip, recording: Any, prefix: str, pictures: bool, visibility: bool) -> None:
        self._rerun = optional_import("rerun", "rerun")
        self._clip, self._recording, self._root = clip, recording, prefix.strip("/")
        self._pictures, self._visibility = pictures, visibility
        #: Where Rerun's 0 is.
        self._origin: NDArray[numpy.float64] = numpy.zeros(3)
        self._shown: set[int] = set()
        self._placed: dict[str, tuple[bytes, ...]] = {}
        self._maps: dict[tuple[object, ...], tuple[NDArray[numpy.intp], NDArray[numpy.bool_]]] = {}

    def run(self, frames: slice) -> None:
        self._send("", self._view_coordinates(), static=True)
        first = True
        for frame in self._clip[frames]:
            try:
                if first:
                    self._choose_origin(frame)
                self._set_time(frame)
                self._log_frame(frame)
                first = False
            except Error as error:
                self._log_damage(frame.number, str(error))
        if self._pictures and len(self._clip[frames]) == len(self._clip):
            self._log_films()
        for problem in self._clip.problems:
            self._send("damage", self._rerun.TextLog(str(problem), level="ERROR"))

    def _send(self, path: str, what: Any, static: bool = False) -> None:
        whole = "/".join(part for part in (self._root, path) if part) or "/"
        self._rerun.log(whole, what, static=static, recording=self._recording)

    def _view_coordinates(self) -> Any:
        up = self._clip.up or "+y"
        side = "UP" if up[0] == "+" else "DOWN"
        return getattr(self._rerun.ViewCoordinates, f"RIGHT_HAND_{up[1].upper()}_{side}")

    def _choose_origin(self, frame: ClipFrame) -> None:
        for mesh in frame.meshes.values():
            if mesh.positions.dtype == numpy.float64:
                self._origin = numpy.array(mesh.origin)

    def _set_time(self, frame: ClipFrame) -> None:
        self._set_time_of(frame.number, frame.time)

    def _set_time_of(self, number: int, seconds: float) -> None:
        self._rerun.set_time("frame", sequence=number, recording=self._recording)
        self._rerun.set_time("seconds", duration=seconds, recording=self._recording)

    def _log_damage(self, number: int, text: str) -> None:
        self._rerun.set_time("frame", sequence=number, recording=self._recording)
        self._send("damage", self._rerun.TextLog(text, level="ERROR"))
        self._clear(set())

    def _clear(self, there: set[int]) -> None:
        """What is shown no more: a mesh without a value at this time would stay as it was."""
        for track in sorted(self._shown - there):
            self._send(f"mesh/{track}", self._rerun.Clear(recursive=False))
        self._shown = set(there)

    def _log_frame(self, frame: ClipFrame) -> None:
        meshes, atlas = frame.meshes, frame.atlas
        for track, mesh in meshes.items():
            self._send(f"mesh/{track}", self._mesh(mesh, atlas))
        self._clear(set(meshes))
        if self._visibility:
            self._log_visibility(frame)
        shown: ByCamera[Picture] | dict[int, Picture] = frame.pictures if self._pictures else {}
        for camera in frame.cameras.values():
            path = "cameras/" + self._rerun.escape_entity_path_part(camera.name or str(camera.id))
            self._place(path, camera)
            if camera.id in shown:
                self._log_picture(f"{path}/picture", shown[camera.id])

    def _log_films(self) -> None:
        if not hasattr(self._rerun, "VideoStream"):  # before 0.24
            return
        numbers = {frame.ticks: frame.number for frame in self._clip if frame.intact}
        names = {track.id: track.name or str(track.id) for track in self._clip.tracks}
        for track, samples in h264_samples(self._clip).items():
            path = "video/" + self._rerun.escape_entity_path_part(names[track])
            self._send(path, self._rerun.VideoStream(codec=self._rerun.VideoCodec.H264), static=True)
            for sample in samples:
                if sample.ticks not in numbers:
                    continue
                self._set_time_of(numbers[sample.ticks], float(sample.ticks * self._clip.time_base))
                self._send(path, self._rerun.VideoStream.from_fields(sample=sample.data))

    def _log_visibility(self, frame: ClipFrame) -> None:
        mesh = frame.mesh
        weights = [frame.visibility(identifier) for identifier in frame.cameras]
        there = [one for one in weights if one is not None]
        path = f"visibility/{0 if mesh is None else mesh.track}"
        if mesh is None or not there:
            return
        seen = numpy.mean([one > 127 for one in there], axis=0)
        colours = numpy.stack([numpy.interp(seen, RAMP_AT, one) for one in zip(*RAMP)], axis=-1)
        self._send(
            path,
            self._rerun.Mesh3D(
                vertex_positions=(mesh.positions - self._origin).astype(numpy.float32),
                triangle_indices=mesh.indices,
                vertex_colors=numpy.rint(colours).astype(numpy.uint8),
            ),
        )

    def _mesh(self, mesh: Mesh, atlas: Picture | None) -> Any:
        textured = mesh.uvs is not None and atlas is not None
        return self._rerun.Mesh3D(
            vertex_positions=(mesh.positions - self._origin).astype(numpy.float32),
            triangle_indices=mesh.indices,
            vertex_normals=mesh.normals,
            vertex_colors=None if textured else mesh.colours,
            vertex_texcoords=mesh.uvs if textured else None,
            albedo_texture=on_screen(atlas.pixels) if textured and atlas is not None else None,
        )

    def _place(self, path: str, camera: Camera) -> None:
        where = (camera.R.tobytes(), camera.t.tobytes())
        if self._placed.get(path) == where:
            return
        self._placed[path] = where
        self._send(path, self._rerun.Transform3D(translation=camera.centre - self._origin, mat3x3=camera.R.T))

    def _log_picture(self, path: str, picture: Picture) -> None:
        camera = picture.camera
        if camera is None:
            return
        intrinsics = (camera.K.tobytes(), str((camera.width, camera.height)).encode())
        straight = numpy.array(camera.K)
        straight[0, 1] = 0
        if self._placed.get(path) != intrinsics:
            self._placed[path] = intrinsics
            size = [camera.width, camera.height]
            self._send(path, self._rerun.Pinhole(image_from_camera=straight, resolution=size))
        pixels = self._without_lens(camera, straight, on_screen(picture.pixels))
        self._send(path, self._rerun.Image(pixels).compress(jpeg_quality=JPEG_QUALITY))

    def _without_lens(
        self, camera: Camera, straight: NDArray[numpy.float64], pixels: NDArray[numpy.uint8]
    ) -> NDArray[numpy.uint8]:
        """The picture as a camera without lens and skew sees it: the nearest pixels, grey where the picture has none."""
        if camera.lens == "none" and camera.K[0, 1] == 0:
            return pixels
        key = (camera.id, camera.lens, camera.K.tobytes(), camera.distortion.tobytes(), pixels.shape)
        if key not in self._maps:
            ideal = Camera(camera.id, straight, camera.R, camera.t, (camera.width, camera.height))
            self._maps[key] = straightened(camera, ideal)[1:]
        places, inside = self._maps[key]
        out = pixels.reshape(-1, 3)[places]
        out[~inside] = GREY
        return out


def _parser() -> argparse.ArgumentParser:
    """The arguments that the viewer passes; later versions may have more, which are of no use here."""
    out = argparse.ArgumentParser(
        description="Writes a .fvv stream as a recording of Rerun to standard output. `rerun players.fvv` runs it.",
        allow_abbrev=False,
    )
    out.add_argument("file", metavar="FILE", help="a .fvv stream")
    out.add_argument("--application-id", default="fvv", metavar="ID")
    out.add_argument("--recording-id", metavar="ID")
    out.add_argument("--entity-path-prefix", default="", metavar="PATH")
    out.add_argument("--no-pictures", action="store_true", help="leave out what the cameras filmed")
    out.add_argument("--visibility", action="store_true", help="colours for how many cameras see the surface")
    return out


def main(arguments: list[str] | None = None) -> int:
    """rerun-importer-fvv. 66: the file is no .fvv stream."""
    given, _ = _parser().parse_known_args(arguments)
    try:
        with open(given.file, "rb") as file:
            own = file.read(len(SIGNATURE)) == SIGNATURE
    except OSError:
        own = False
    if not own:
        return INCOMPATIBLE
    try:
        rerun = optional_import("rerun", "rerun")
        recording = rerun.RecordingStream(given.application_id, recording_id=given.recording_id)
        with Clip(given.file) as clip:
            rerun.stdout(recording=recording)
            stem = os.path.splitext(os.path.basename(given.file))[0]
            prefix = given.entity_path_prefix or rerun.escape_entity_path_part(stem)
            log(clip, recording, prefix=prefix, pictures=not given.no_pictures, visibility=given.visibility)
    except (Error, ImportError, OSError) as error:
        print(f"rerun-importer-fvv: {error}", file=sys.stderr)
        return 1
    return 0


def main_before_0_32(arguments: list[str] | None = None) -> int:
    """rerun-loader-fvv, the name that older viewers look for. Later ones run it, too: there it leaves the file to
    rerun-importer-fvv."""
    given, _ = _parser().parse_known_args(arguments)
    if given.recording_id is not None:
        rerun = optional_import("rerun", "rerun")
        if hasattr(rerun, "EXTERNAL_IMPORTER_INCOMPATIBLE_EXIT_CODE"):
            return INCOMPATIBLE
    return main(arguments)
