"""What cameras filmed, read as `fvvmux` reads it: pictures, masks and sound of footage, and calibrations of other programs.

`Footage(text, path)` is a capture.json, given as text, whose files are relative to `path`. `picture_size` returns the width and
height of a picture in pixels, `video_facts` size, rate and frames of a film, `sound` its rate in Hz, start in seconds and samples
(n, channels) float32. `read_calibration(format, paths, size)` returns cameras and the metres of the file's unit; `format` is one
of `fvvimport`'s, `size` (pixels) is used where the format has none. OSError, `fvv.Error` and `fvv.UsageError` name the file.
"""

from ._core import Footage, has_sound, picture_size, read_calibration, sound, video_facts

__all__ = ["Footage", "has_sound", "picture_size", "read_calibration", "sound", "video_facts"]
