"""Streams of other writers as cases: those of libfvv, most of which `test_stream '[make]'` writes in their places, and those of the
reference's own writers. conformance/reference/listings has what the readers of the reference find in most of them."""

from reference import audio, openexr, tiny

from ..case import CASES, valid

LIBRARY = {
    "environment_stage": ("18", "Two parts, two pictures and a light of each type, once after the second frame of a group."),
    "calibration_moving": ("9.4 9.5", "Three lenses that rotate by 180 degrees, zoom tenfold, travel and lose their calibration."),
    "colours_sheet": ("19", "Colours of vertices with other steps and cells in each group, and a key mesh without."),
    "delta_field": ("8.7 8.8 8.9", "Six delta frames of 830 vertices in five levels, with twins, a seam and five loose triangles."),
    "delta_stencils": ("8.7 8.8 8.9", "One of the first four nodes of a vertex has weight 0 and a later one has not."),
    "fast_shapes": ("8.11", "A torus, a textured cube, and random faces with every code of the index and vertex streams."),
    "normals_cube": ("8.12 8.13", "Normals that rotate with their faces, mirrored and without area, then computed normals."),
    "texturing_default": ("17.5", "Two groups without TEXR, so that the defaults apply."),
    "texturing_explicit": ("17.5", "A TEXR in which no value is the default."),
    "tiles_crops": ("10.11", "Five groups, of which three have a layout of their own; one of them lacks a camera."),
    "visibility_moving": ("17.1 17.2 17.3", "Weights by moving cameras, of which one has no calibration in one frame."),
    "visibility_sheet": ("17.1 17.2 17.3", "Two visibility tracks of a wavy sheet with thresholds of 64 and 10, three cameras each."),
    "visibility_weights": ("17.1 17.2 17.3", "A key and four chunks that use the former one as context, three cameras."),
}  # fmt: skip
TINY = {
    "cameras": "A key and a delta frame, two cameras of which one moves, their layout, calibration and visibility.",
    "empty": "A scene and an index without entries.",
    "tetrahedron": "One mesh track, one group, one frame: a raw mesh of 4 vertices and 4 faces.",
}


def add(name, title, clauses, make, writer):
    valid(f"vector_{name}", title, clauses, make, source=f"written by {writer}")


for name, (clauses, title) in LIBRARY.items():
    add(name, title, clauses, (CASES / f"valid/vector_{name}/input.fvv").read_bytes, "libfvv")
for name, title in TINY.items():
    add(
        f"tiny_{name}",
        title,
        "3 4 5 6 7 8.3",
        lambda name=name: tiny.files()[f"{name}.fvv"],
        "conformance/reference",
    )
add(
    "audio_two_sounds",
    "A mesh in two ranks of one alternate group, and two sounds of which one moves.",
    "5.2 20",
    audio.audio_stream,
    "conformance/reference",
)
add(
    "openexr_bars",
    "Samples without compression, in ZIPS and in ZIP, with the extremes of half floats.",
    "10.12",
    openexr.bars_stream,
    "conformance/reference",
)
