"""What users choose from by name, in functions and on the command line."""

from __future__ import annotations

#: Axes of the world that may point up.
UPS = ("+x", "-x", "+y", "-y", "+z", "-z")
#: Models of lenses; "auto" compares radtan5 and radtan8.
LENSES = ("auto", "radtan5", "radtan8", "fisheye")
#: Of the calibration files that `write_calibration` writes.
CALIBRATION_FORMATS = ("fvv", "opencv")
#: Ways to find when recordings began.
SYNCHRONISE = ("sound", "flash", "motion", "timecode")
#: Ways to find the surface of a frame.
SURFACES = ("hull", "refined")
