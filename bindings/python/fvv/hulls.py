"""Visual hulls of silhouettes, as plain calls: `fvv_capture.hull` has them with named options and results.

Masks are (height, width) uint8, 255 inside, one for each camera, None where a camera has none. `hull_bounds` returns two corners
in metres, `hull_carve` the mesh and its grid, `coverage` what a camera sees of a mesh as a mask, `silhouette_iou` the overlap, 0 to
1, of a mesh's outlines and the masks.
"""

from ._core import coverage, hull_bounds, hull_carve, silhouette_iou

__all__ = ["coverage", "hull_bounds", "hull_carve", "silhouette_iou"]
