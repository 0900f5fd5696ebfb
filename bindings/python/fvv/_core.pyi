from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy
from numpy.typing import ArrayLike, DTypeLike, NDArray

library_version: str

class Mesh:
    """A triangle mesh. Arrays are read-only views of the mesh's memory and keep it alive."""

    @property
    def track(self) -> int:
        """Identifier of the mesh track."""
    @property
    def vertex_count(self) -> int:
        """Rows of `positions`."""
    @property
    def face_count(self) -> int:
        """Rows of `indices`."""
    @property
    def positions(self) -> NDArray[numpy.float32] | NDArray[numpy.float64]:
        """(vertices, 3) metres on the axes of the world: origin + step * lattice, rounded once. float32; float64 in streams that
        are far from 0, as in map coordinates, where float32 has decimetres."""
    @property
    def lattice(self) -> NDArray[numpy.int32]:
        """(vertices, 3) lattice indices, as they were sent."""
    @property
    def origin(self) -> NDArray[numpy.float64]:
        """(3,) metres: the lattice point 0 0 0."""
    @property
    def step(self) -> float:
        """Metres between neighbouring lattice points."""
    @property
    def indices(self) -> NDArray[numpy.uint32]:
        """(faces, 3) vertices of each triangle, counter-clockwise seen from outside."""
    @property
    def normals(self) -> NDArray[numpy.float32]:
        """(vertices, 3) unit vectors: as sent, otherwise computed from the faces."""
    @property
    def has_normals(self) -> bool:
        """Normals were sent."""
    @property
    def uvs(self) -> NDArray[numpy.float32] | None:
        """(vertices, 2) places in the atlas: (0, 0) is its top left corner, (1, 1) its bottom right one. None: not sent."""
    @property
    def colours(self) -> NDArray[numpy.uint8] | None:
        """(vertices, 3) red, green, blue of low resolution, sRGB. None: not sent."""
    # Of fvv.interop.
    def to_trimesh(self, atlas: Picture | NDArray[Any] | None = None) -> Any:
        """A trimesh.Trimesh. atlas: the picture of the texture."""
    def to_open3d(self) -> Any:
        """An open3d.geometry.TriangleMesh."""
    def to_pyvista(self) -> Any:
        """A pyvista.PolyData."""

class Camera:
    """A calibrated camera: x_camera = R x_world + t, x right, y down, z forward, pixel centres at .5."""

    def __init__(
        self,
        id: int,
        K: ArrayLike,
        R: ArrayLike,
        t: ArrayLike,
        size: tuple[int, int],
        distortion: ArrayLike = ...,
        lens: str = "none",
        name: str = "",
        r_max: float | None = None,
    ) -> None:
        """id: 0 to 65534. K, R, t, lens, distortion (up to 8 numbers, the others are 0), r_max: as the attributes have them;
        r_max None: as far as the lens can be inverted and the picture needs. size: width and height in pixels.
        `UsageError` for what is no camera, such as an R that is no rotation."""
    @property
    def id(self) -> int:
        """Its identifier in the stream."""
    @property
    def name(self) -> str:
        """Its name; may be empty."""
    @property
    def width(self) -> int:
        """Pixels of the picture that K belongs to."""
    @property
    def height(self) -> int:
        """Pixels of the picture that K belongs to."""
    @property
    def K(self) -> NDArray[numpy.float64]:
        """(3, 3): fx skew cx, 0 fy cy, 0 0 1, in pixels."""
    @property
    def R(self) -> NDArray[numpy.float64]:
        """(3, 3) world to camera."""
    @property
    def t(self) -> NDArray[numpy.float64]:
        """(3,) metres."""
    @property
    def centre(self) -> NDArray[numpy.float64]:
        """(3,) metres: where the camera is in the world."""
    @property
    def lens(self) -> str:
        """ "none", "radtan" (OpenCV's rational model) or "fisheye" (OpenCV's)."""
    @property
    def distortion(self) -> NDArray[numpy.float64]:
        """(8,): k1 k2 p1 p2 k3 k4 k5 k6 of radtan; k1 k2 k3 k4 0 0 0 0 of fisheye."""
    @property
    def r_max(self) -> float:
        """Radius up to which the lens model is valid, at z = 1; an angle in radians for fisheye."""
    @property
    def moves(self) -> bool:
        """Its calibration changes from frame to frame."""
    def project(self, points: ArrayLike) -> NDArray[numpy.float64]:
        """(..., 3) metres in the world to (..., 2) pixels. NaN behind the camera and beyond r_max; a pixel may lie outside
        the picture."""
    def depth(self, points: ArrayLike) -> NDArray[numpy.float64]:
        """(..., 3) metres in the world to (...) metres along the camera's z axis."""
    def unproject(self, pixels: ArrayLike, depth: ArrayLike) -> NDArray[numpy.float64]:
        """(..., 2) pixels at a depth along the camera's z axis (a number, or one for each pixel) to (..., 3) metres in the
        world. NaN beyond r_max."""
    def ray(self, pixels: ArrayLike) -> tuple[NDArray[numpy.float64], NDArray[numpy.float64]]:
        """The camera's centre, (3,), and the directions from there through (..., 2) pixels, (..., 3) of unit length, both in
        the world. NaN beyond r_max."""

class Picture:
    """What the video shows of a camera's picture: a rectangle of it, scaled."""

    @property
    def pixels(self) -> NDArray[Any]:
        """(height, width, 3) red, green, blue: uint8 sRGB; uint16 sRGB of video with more than 8 bits, 65535 for white;
        float16 linear light of OpenEXR, 1 for white. A view of the video frame, or of its one copy as float16."""
    @property
    def source(self) -> tuple[int, int, int, int]:
        """x, y, width, height of the rectangle in pixels of the camera's picture that `pixels` show."""
    @property
    def camera(self) -> Camera | None:
        """The camera whose whole picture `pixels` are: points projected by it are in their pixels. None for an atlas."""
    def whole(self) -> NDArray[Any]:
        """The camera's whole picture at the scale of `pixels`, grey outside of the rectangle: a new array."""
    def __array__(self, dtype: DTypeLike = None, copy: bool | None = None) -> NDArray[Any]: ...

class Sound:
    """Packets of an audio track that follow each other without a gap."""

    @property
    def track(self) -> int:
        """Identifier of the audio track."""
    @property
    def title(self) -> str:
        """The name of the track; may be empty."""
    @property
    def language(self) -> str:
        """BCP 47; may be empty."""
    @property
    def codec(self) -> str:
        """ "opus" or "aac"."""
    @property
    def rate(self) -> int:
        """Samples per second."""
    @property
    def channels(self) -> int:
        """1 to 8."""
    @property
    def start(self) -> float:
        """Time of the first of `samples()`, in seconds of the clip."""
    @property
    def duration(self) -> float:
        """Seconds of `samples()`."""
    @property
    def packet_duration(self) -> int:
        """Samples of each packet."""
    @property
    def packets_start(self) -> int:
        """Time of the first sample that the first packet decodes to, in samples."""
    @property
    def packets(self) -> tuple[bytes, ...]:
        """As they were sent; `packet_duration` samples each."""
    @property
    def record(self) -> bytes:
        """Opus: the header of RFC 7845 clause 5.1. AAC: AudioSpecificConfig."""
    @property
    def position(self) -> NDArray[numpy.float64] | None:
        """(3,) metres: where it is heard from. None: everywhere, or from a place that moves."""
    @property
    def moves(self) -> bool:
        """It is heard from a place that moves: `position_at`."""
    def position_at(self, seconds: float) -> NDArray[numpy.float64] | None:
        """(3,) metres: where it is heard from at a time of the clip, in seconds; of sound that moves, in a straight line between the
        places that were sent, and the first or last one beyond. None: everywhere."""
    def samples(self) -> NDArray[numpy.float32]:
        """(samples, channels), full scale 1: decodes the packets into a new array."""

class Stream:
    def __init__(self, source: Any, name: str, rung: int, limits: dict[str, int]) -> None: ...
    def close(self) -> None: ...
    @property
    def closed(self) -> bool: ...
    def __len__(self) -> int: ...
    def frame(self, frame: int) -> tuple[int, int, int]: ...
    def number(self, frame: int) -> int: ...
    def at(self, ticks: int) -> int: ...
    def span(self) -> tuple[int, int]: ...
    def configuration(self, group: int | None = None) -> dict[str, Any]: ...
    def configuration_offset(self, group: int) -> int: ...
    def mesh(self, frame: int, track: int) -> Mesh | None: ...
    def camera(self, frame: int, camera: int) -> Camera | None: ...
    def visibility(self, frame: int, mesh_track: int, camera: int) -> NDArray[numpy.uint8] | None: ...
    def picture_cameras(self, frame: int) -> list[int]: ...
    def picture(self, frame: int, camera: int) -> Picture | None: ...
    def environment(self, frame: int) -> tuple[list[Any], list[bytes], list[Any]] | None: ...
    def sounds(self) -> list[Sound]: ...
    def problems(self) -> list[tuple[str, int | None, str | None, int | None, int | None, str]]: ...
    def chunks(self, group: int | None = None) -> NDArray[numpy.void]: ...
    @property
    def byte_count(self) -> int: ...
    def read_at(self, offset: int, size: int) -> bytes: ...

class LiveFrame:
    @property
    def ticks(self) -> int: ...
    @property
    def number(self) -> int: ...
    @property
    def meshes(self) -> dict[int, Mesh]: ...
    @property
    def cameras(self) -> dict[int, Camera | None]: ...
    @property
    def pictures(self) -> dict[int, Picture]: ...
    def visibility(self, mesh_track: int, camera: int) -> NDArray[numpy.uint8] | None: ...

class LiveReader:
    def __init__(
        self,
        name: str,
        rung: int,
        pictures: bool,
        visibility: bool,
        sound: bool,
        join: bool,
        limits: dict[str, int],
    ) -> None: ...
    def feed(self, bytes: Any) -> list[tuple[Any, ...]]: ...
    def finish(self) -> list[tuple[Any, ...]]: ...

class FrameWriter:
    def __init__(
        self,
        options: dict[str, str],
        sink: Callable[[memoryview], None],
        on_warning: Callable[[str], None],
        on_progress: Callable[[int], None] | None,
    ) -> None: ...
    @property
    def failed(self) -> bool: ...
    @property
    def frames(self) -> int: ...
    def configure(
        self,
        name: str,
        numerator: int,
        denominator: int,
        cameras: list[Camera],
        flags: list[tuple[bool, ...]],
        sounds: list[dict[str, Any]],
        up: str,
        scale_unknown: bool,
    ) -> None: ...
    def add(
        self,
        mesh: Any,
        pictures: list[Any] | None,
        masks: list[Any] | None,
        calibrations: list[Any] | None,
        visibility: list[Any] | None,
    ) -> None: ...
    def finish(self, output: str) -> dict[str, Any]: ...
    def close(self) -> None: ...

class CaptureMuxer:
    def __init__(
        self,
        capture: str,
        cameras: list[str],
        options: dict[str, str],
        sink: Callable[[memoryview], None],
        on_warning: Callable[[str], None],
        on_progress: Callable[[int], None] | None,
    ) -> None: ...
    @property
    def frame_count(self) -> int: ...
    def run(self) -> None: ...
    def verify(self, path: str) -> None: ...
    def result(self, output: str) -> dict[str, Any]: ...

class PartPlan:
    """fvv_mux/parts.h. Paths are local. Every method but the attributes releases the GIL."""

    @staticmethod
    def make(capture: str, cameras: list[str], options: dict[str, str], first: str) -> PartPlan: ...
    @staticmethod
    def load(data: bytes, name: str, capture: str) -> PartPlan: ...
    @property
    def data(self) -> bytes: ...
    @property
    def first_report(self) -> str: ...
    @property
    def group_count(self) -> int: ...
    @property
    def frame_count(self) -> int: ...
    def frames_of(self, group: int) -> int: ...
    def files_of(self, group: int) -> list[str]: ...
    def encode(self, group: int, threads: int, path: str) -> str: ...
    def check_complete(self, name: str, there: list[bool]) -> None: ...
    def merge(self, open_part: Callable[[int], tuple[str, str]], path: str) -> tuple[int, list[str]]: ...

class Footage:
    def __init__(self, text: str, path: str) -> None: ...
    @property
    def frames(self) -> list[int]: ...
    @property
    def frame_duration(self) -> tuple[int, int]: ...
    @property
    def cameras(self) -> list[Camera]: ...
    def camera(self, index: int, frame: int) -> Camera | None: ...
    def picture(self, index: int, frame: int) -> NDArray[numpy.uint8]: ...
    def mask(self, index: int, frame: int) -> NDArray[numpy.uint8]: ...
    def check(self) -> tuple[list[str], list[str]]: ...

def video_facts(path: str) -> dict[str, Any]: ...
def picture_size(path: str) -> tuple[int, int]: ...
def has_sound(path: str) -> bool: ...
def sound(path: str) -> tuple[int, float, NDArray[numpy.float32]]: ...
def option_table() -> list[dict[str, Any]]: ...
def files_of(capture: str, options: dict[str, str] = ...) -> list[str]: ...
def describe_inputs(capture: str, options: dict[str, str], path: str) -> str: ...
def pack_pipe(
    descriptor: int,
    options: dict[str, str],
    most_delay: float,
    idle: float,
    output: str,
    sink: Callable[[memoryview], None],
    on_warning: Callable[[str], None],
    on_event: Callable[[str, int, float, str], object],
) -> dict[str, Any]: ...
def write_segments(stream: str, write_file: Callable[[str, bytes], None]) -> tuple[int, int, int]: ...
def decimate(
    mesh: Any,
    max_error: str | None,
    triangles: int | None,
    cameras: list[Camera],
    scale: float,
    step: float | None,
    min_piece: int,
) -> dict[str, Any]: ...
def hull_bounds(
    cameras: list[Camera], masks: list[NDArray[Any] | None], options: dict[str, Any]
) -> tuple[list[float], list[float]]: ...
def hull_carve(
    cameras: list[Camera],
    masks: list[NDArray[Any] | None],
    bounds: tuple[list[float], list[float]] | None,
    cell: float | None,
    max_error: float | None,
    options: dict[str, Any],
) -> dict[str, Any]: ...
def coverage(mesh: tuple[Any, Any, Any, Any], camera: Camera) -> NDArray[numpy.uint8]: ...
def silhouette_iou(
    mesh: tuple[Any, Any, Any, Any], cameras: list[Camera], masks: list[NDArray[Any] | None]
) -> list[float | None]: ...
def read_calibration(format: str, paths: list[str], size: tuple[int, int]) -> tuple[list[Camera], float]: ...
def inspect(source: Any, name: str, decode: bool, chunks: bool) -> str: ...
def check(source: Any, name: str, decode: bool, limits: dict[str, int]) -> dict[str, Any]: ...
def render(clip: Stream, frame: int, target: Any, options: dict[str, Any]) -> dict[str, Any]: ...
def compare(
    a: Any,
    b: Any,
    frames: tuple[int, int] | None,
    start: int | None,
    samples: int,
    points_of_samples: bool,
    peak: float | None,
    threads: int,
    progress: Any,
) -> dict[str, Any]: ...
