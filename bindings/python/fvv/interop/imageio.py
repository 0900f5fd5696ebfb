"""A plugin of imageio that reads the pictures of one camera, each exactly by its number.

fvv.interop.imageio.register()
picture = imageio.v3.imread("players.fvv", index=30, camera="cam2")
"""

from __future__ import annotations

import pathlib
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import numpy
from numpy.typing import NDArray

from ..clip import Clip, ClipFrame
from ..errors import Error, UsageError
from ..frames import Key
from .optional_import import optional_import

if TYPE_CHECKING:
    from types import EllipsisType

    from .._core import Picture


def register() -> None:
    """Makes imageio read files that end in .fvv with `FvvPlugin`. May be called again."""
    config = optional_import("imageio.config", "imageio")
    config.known_plugins["fvv"] = config.PluginConfig(
        name="fvv", class_name="FvvPlugin", module_name="fvv.interop.imageio"
    )
    if ".fvv" not in config.known_extensions:
        extension = config.FileExtension(name="Free-viewpoint video", extension=".fvv", priority=["fvv"])
        config.known_extensions[".fvv"] = [extension]
        config.extension_list.append(extension)


class FvvPlugin:
    """imageio's interface PluginV3. `camera` chooses the pictures, by identifier or name; None: the first that has some.

    Pictures are whole, as `fvvdemux` writes them: (height, width, 3), uint8, uint16 or float16.
    """

    def __init__(self, request: Any) -> None:
        core = optional_import("imageio.core.request", "imageio")
        if request.mode.io_mode == core.IOMode.write:
            raise core.InitializationError("fvv: streams are read only")
        self._request = request
        name = request.get_local_filename()
        # imageio asks every plugin about a file without a known extension.
        with pathlib.Path(name).open("rb") as file:
            if file.read(4) != b"\x89FVV":
                raise core.InitializationError(f"{name}: no fvv stream")
        try:
            self._clip = Clip(name)
        except Error as error:
            raise core.InitializationError(str(error)) from error

    def read(self, *, index: int | EllipsisType = 0, camera: Key | None = None) -> NDArray[Any]:
        """The picture of a frame, from either end. Ellipsis: those of all frames, (frames, height, width, 3)."""
        if not isinstance(index, int):
            return numpy.stack(list(self.iter(camera=camera)))
        return self._picture(self._clip[index], camera).whole()

    def iter(self, *, camera: Key | None = None) -> Iterator[NDArray[Any]]:
        """The pictures of all frames in order."""
        for frame in self._clip:
            yield self._picture(frame, camera).whole()

    def write(self, ndimage: Any) -> None:
        raise UsageError("fvv: streams are read only")

    def properties(self, index: int | EllipsisType = 0, *, camera: Key | None = None) -> Any:
        """imageio's ImageProperties."""
        api = optional_import("imageio.core.v3_plugin_api", "imageio")
        every = not isinstance(index, int)
        picture = self.read(index=index if isinstance(index, int) else 0, camera=camera)
        shape = (len(self._clip), *picture.shape) if every else picture.shape
        return api.ImageProperties(
            shape=shape, dtype=picture.dtype, n_images=len(self._clip) if every else None, is_batch=every
        )

    def metadata(
        self, index: int | EllipsisType = 0, exclude_applied: bool = True, *, camera: Key | None = None
    ) -> dict[str, Any]:
        """Of the stream for an index that is Ellipsis: fps, duration (s), frames, cameras. Of a frame: time (s), number, and the
        camera's name and calibration of the whole picture."""
        if not isinstance(index, int):
            clip = self._clip
            return {
                "fps": float(clip.rate),
                "duration": clip.duration,
                "frames": len(clip),
                "cameras": [found.name or found.id for found in clip[0].cameras.values()],
            }
        frame = self._clip[index]
        found = frame.cameras[self._key(frame, camera)]
        names = ("id", "name", "width", "height", "K", "R", "t", "lens", "distortion")
        return {"time": frame.time, "number": frame.number, **{name: getattr(found, name) for name in names}}

    def close(self) -> None:
        self._clip.close()
        self._request.finish()

    @property
    def request(self) -> Any:
        return self._request

    def __enter__(self) -> FvvPlugin:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _key(self, frame: ClipFrame, camera: Key | None) -> Key:
        for key in frame.pictures if camera is None else [camera]:
            return key
        raise UsageError(f"frame {frame.number} has no picture", file=self._clip.name)

    def _picture(self, frame: ClipFrame, camera: Key | None) -> Picture:
        key = self._key(frame, camera)
        if key not in frame.pictures:
            raise UsageError(f"frame {frame.number} has no picture of camera {key}", file=self._clip.name)
        return frame.pictures[key]
