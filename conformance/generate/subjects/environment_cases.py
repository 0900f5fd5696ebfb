"""Whole and faulty environments and lights: clause 18."""

import math

from .. import media, meshes, payloads
from ..case import faulty, valid
from ..packing import patched
from ..recipes import block, frame, opened
from .mesh_whole import draco_payload

TRACK = 5
TRACKS = [(1, payloads.track(payloads.MESH, "mesh")), (TRACK, payloads.track(payloads.ENVIRONMENT, "stage"))]
PLAIN = meshes.raw(meshes.TETRAHEDRON)
TEXTURED = meshes.raw(meshes.textured(meshes.grid(5, 4), 10))
LIGHTS = [payloads.light(kind) for kind in range(3)]
PNG, JPEG = 1, 0


def file(name):
    codec = JPEG if name.startswith("jpeg") else PNG
    return payloads.picture(codec, *media.picture(name))


def stream(*chunks, groups=2):
    """Groups of two frames; BACK comes after the second frame of the first group."""
    s = opened(*TRACKS)
    for number in range(groups):
        start = 2 * number
        s.begin(start, start + 2)
        frame(s, start)
        frame(s, start + 1)
        if number < len(chunks):
            s.chunk("BACK", chunks[number], TRACK, start + 1, True)
        s.end()
    s.finish()
    return s


def one(name, title, *parts, pictures=(), lights=(), **fields):
    payload = payloads.environment(parts, pictures, lights, **fields)
    valid(f"environment_{name}", title, "18", lambda: stream(payload))


def whole():
    part = payloads.part
    one("part", "One part without a picture.", part(PLAIN))
    one("lights", "A light of each type, and no part.", lights=LIGHTS)
    one(
        "all",
        "Two parts, two pictures and three lights.",
        part(TEXTURED, 1),
        part(PLAIN),
        pictures=[file("png"), file("jpeg")],
        lights=LIGHTS,
    )
    for flags in range(1, 8):
        one(
            f"flags_{flags}",
            f"A part with the flags {flags}.",
            part(TEXTURED, 0, flags=flags),
            pictures=[file("png")],
        )
    one(
        "profiles",
        "Parts of the profiles raw, Draco and fast.",
        part(PLAIN),
        part(draco_payload("ball_speed_5")),
        part(meshes.fast(meshes.grid(6, 5))),
        part(draco_payload("grid_textured", 12), 0),
        pictures=[file("jpeg")],
    )
    for name in ("png", "png_grey", "png_alpha", "png_palette", "jpeg", "jpeg_grey", "jpeg_progressive"):
        one(
            f"picture_{name}",
            f"A picture: {name.replace('_', ' ')}.",
            part(TEXTURED, 0),
            pictures=[file(name)],
        )
    one(
        "shared_picture",
        "Two parts share a picture; another picture is not used.",
        part(TEXTURED, 0),
        part(TEXTURED, 0, colour=(0, 65535, 65535)),
        pictures=[file("png"), file("jpeg_grey")],
    )
    one(
        "texture_place",
        "The texture lies beyond the edges of the picture.",
        part(TEXTURED, 0, texture_origin=(-2.5, 1e6), texture_size=(3.25, 1e-3)),
        pictures=[file("png")],
    )
    one("textured_without_picture", "A mesh with texture coordinates and no picture.", part(TEXTURED))
    one("normals", "A mesh with sent normals.", part(meshes.raw(meshes.with_normals(meshes.OCTAHEDRON))))
    one(
        "lattice",
        "A coarse lattice far away.",
        part(PLAIN),
        lattice_origin=(1e5, -1e5, 0.5),
        lattice_step=0.25,
    )
    light = payloads.light
    one(
        "light_limits",
        "Lights at the ends of their ranges.",
        lights=[
            light(0, colour=(0.0, 0.0, 0.0), intensity=0.0),
            light(1, range=0.0, intensity=1e300, colour=(1.0, 1.0, 1.0)),
            light(2, inner_cone=0.0, outer_cone=math.pi / 2, flags=1),
            light(0, direction=(0.00009, 0.0, 1.00005)),
        ],
    )
    one(
        "parts_64",
        "64 parts, the number that every reader supports.",
        *[part(meshes.raw(meshes.TRIANGLE))] * 64,
    )
    same = payloads.environment([part(PLAIN)], (), LIGHTS[:1])
    other = payloads.environment([part(TEXTURED)])
    valid(
        "environment_repeated",
        "Every group repeats the environment.",
        "18.5",
        lambda: stream(same, same, same, groups=3),
    )
    valid(
        "environment_later", "The environment comes in the third group.", "18.5", later, requirements=(9019,)
    )
    valid(
        "environment_changes",
        "A new configuration has no environment, the next one another.",
        "18.5",
        lambda: changes(same, other),
    )
    valid("environment_two_tracks", "Two environment tracks.", "18", two_tracks)


def later():
    s = opened(*TRACKS)
    for number in range(3):
        s.begin(number, number + 1)
        frame(s, number)
        if number == 2:
            s.chunk("BACK", payloads.environment([payloads.part(PLAIN)]), TRACK, number, True)
        s.end()
    s.finish()
    return s


def changes(first, second):
    s = opened(*TRACKS)
    for number, payload in enumerate((first, None, second)):
        if number:
            block(s, *TRACKS, scene=payloads.scene(up_axis=number))
        s.begin(number, number + 1)
        frame(s, number)
        if payload:
            s.chunk("BACK", payload, TRACK, number, True)
        s.end()
    s.finish()
    return s


def two_tracks():
    s = opened(*TRACKS, (6, payloads.track(payloads.ENVIRONMENT, "crowd")))
    s.begin(0, 1)
    frame(s, 0)
    s.chunk("BACK", payloads.environment([payloads.part(PLAIN)]), TRACK, 0, True)
    s.chunk("BACK", payloads.environment([payloads.part(TEXTURED, 0)], [file("jpeg")]), 6, 0, True)
    s.end()
    s.finish()
    return s


def fault(name, title, issue, payload, clauses):
    """The environment of the first group is wrong; a new configuration has a good one."""

    def make():
        s = opened(*TRACKS)
        s.begin(0, 2)
        frame(s, 0)
        frame(s, 1)
        s.chunk("BACK", payload, TRACK, 1, True, fault=issue)
        s.end()
        block(s, *TRACKS, scene=payloads.scene(up_axis=0))
        s.begin(2, 3)
        frame(s, 2)
        s.chunk("BACK", GOOD, TRACK, 2, True)
        s.end()
        s.finish()
        return s

    faulty(f"environment_{name}", title, clauses, make)


GOOD = payloads.environment([payloads.part(PLAIN)], (), LIGHTS)


def no_key():
    s = opened(*TRACKS)
    s.begin(0, 2)
    frame(s, 0)
    s.chunk("BACK", GOOD, TRACK, 0, True)
    frame(s, 1)
    s.chunk("BACK", GOOD, TRACK, 1, False, fault=8003)
    s.end()
    s.finish()
    return s


def not_same(repeated_block):
    s = opened(*TRACKS)
    for number in range(2):
        if number and repeated_block:
            block(s, *TRACKS)
        s.begin(number, number + 1)
        frame(s, number)
        payload = payloads.environment([payloads.part(PLAIN, colour=(number, 0, 0))])
        s.chunk("BACK", payload, TRACK, number, True, fault=8004 if number else None)
        s.end()
    s.finish()
    return s


def faults():
    part, environment, light = payloads.part, payloads.environment, payloads.light

    def payload(name, title, data):
        fault(name, title, 8001, data, "18.1")

    payload("header", "A BACK payload of 47 bytes.", GOOD[:47])
    payload("reserved", "The reserved field of BACK is 1.", environment([part(PLAIN)], reserved=1))
    payload("empty", "BACK has neither part nor light.", environment())
    payload("tables_cut", "The tables of BACK are cut.", GOOD[: 48 + 48 + 112])
    payload("cut", "The last mesh lacks a byte.", GOOD[:-1])
    payload("mesh_empty", "A mesh of 0 bytes.", environment([part(b""), part(PLAIN)]))
    payload("mesh_size", "The size of a mesh is 2^32 - 1.", environment([part(PLAIN, mesh_size=2**32 - 1)]))
    payload(
        "picture_empty",
        "A picture of 0 bytes.",
        environment([part(PLAIN)], [payloads.picture(PNG, 4, 4, b"")]),
    )
    payload("part_flags", "A part has a reserved flag.", environment([part(PLAIN, flags=8)]))
    payload("part_reserved", "The reserved byte of a part is 1.", environment([part(PLAIN, reserved=1)]))
    payload(
        "picture_reserved",
        "A reserved byte of a picture is 1.",
        environment([part(TEXTURED, 0)], [payloads.picture(PNG, *media.picture("png"), reserved=(0, 1, 0))]),
    )
    payload("light_flags", "A light has a reserved flag.", environment(lights=[light(0, flags=2)]))
    payload(
        "light_reserved",
        "A reserved byte of a light is 1.",
        environment(lights=[light(0, reserved=(0, 0, 0, 0, 0, 1))]),
    )
    fault(
        "pictures_many",
        "BACK has 1,025 pictures, more than the reference library's limit.",
        7001,
        environment([part(PLAIN)], [payloads.picture(PNG, 1, 1, b"x")] * 1025),
        "13 18.1",
    )
    for name, fields in (
        ("step_zero", {"lattice_step": 0.0}),
        ("step_negative", {"lattice_step": -1.0}),
        ("step_nan", {"lattice_step": math.nan}),
        ("origin_infinite", {"lattice_origin": (0.0, math.inf, 0.0)}),
        ("corner", {"lattice_step": 1e301}),
    ):
        fault(
            f"lattice_{name}",
            f"The lattice of BACK has {fields}.",
            8002,
            environment([part(PLAIN)], **fields),
            "18.1",
        )
    faulty("environment_no_key", "A BACK chunk does not have the key flag.", "18.1", no_key, needs_check=True)
    faulty(
        "environment_not_same",
        "The second group has another environment under the same block.",
        "18.5",
        lambda: not_same(False),
        needs_check=True,
    )
    faulty(
        "environment_not_same_repetition",
        "The group after a repeated block has another environment.",
        "18.5",
        lambda: not_same(True),
        needs_check=True,
    )

    def part_fault(name, title, *args, pictures=("png",), **fields):
        fault(
            f"part_{name}",
            title,
            8005,
            environment([part(*args, **fields)], [file(p) for p in pictures]),
            "18.2",
        )

    part_fault("picture_missing", "A part names picture 1 of 1.", TEXTURED, 1)
    part_fault("picture_none_there", "A part names a picture, and there is none.", TEXTURED, 0, pictures=())
    part_fault("no_coordinates", "A part has a picture and no texture coordinates.", PLAIN, 0)
    part_fault("texture_size_zero", "The size of a texture is 0.", TEXTURED, 0, texture_size=(0.0, 1.0))
    part_fault(
        "texture_size_negative", "The size of a texture is negative.", TEXTURED, 0, texture_size=(1.0, -1.0)
    )
    part_fault(
        "texture_size_infinite",
        "The size of a texture is not finite.",
        TEXTURED,
        0,
        texture_size=(math.inf, 1.0),
    )
    part_fault(
        "texture_origin_nan",
        "The origin of a texture is not a number.",
        TEXTURED,
        0,
        texture_origin=(0.0, math.nan),
    )
    part_fault(
        "delta",
        "The mesh of a part is a delta frame.",
        patched(PLAIN, "MESH payload", "profile", 2),
        pictures=(),
    )
    bad = meshes.raw(meshes.TETRAHEDRON._replace(faces=[*meshes.TETRAHEDRON.faces[:3], (0, 1, 9)]))
    fault(
        "mesh_index",
        "A face of a part uses a vertex that does not exist.",
        3005,
        environment([part(bad)]),
        "8.3 18.2",
    )
    fault(
        "mesh_profile",
        "The mesh of a part has an unknown profile.",
        3002,
        environment([part(patched(PLAIN, "MESH payload", "profile", 9))]),
        "8.3 18.2",
    )
    fault(
        "mesh_lattice",
        "A position of a part is beyond the lattice.",
        3006,
        environment([part(meshes.raw(meshes.BEYOND))]),
        "8.1 18.2",
    )

    def picture_fault(name, title, codec, width, height, data, issue=8006):
        fault(
            f"picture_{name}",
            title,
            issue,
            environment([part(TEXTURED, 0)], [payloads.picture(codec, width, height, data)]),
            "18.3",
        )

    png, jpeg = media.picture("png"), media.picture("jpeg")
    picture_fault("png_width", "A PNG file has another width than its entry.", PNG, png[0] + 1, *png[1:])
    picture_fault(
        "jpeg_height", "A JPEG file has another height than its entry.", JPEG, jpeg[0], jpeg[1] - 1, jpeg[2]
    )
    picture_fault("zero", "The entry of a picture has the width 0.", PNG, 0, *png[1:])
    picture_fault(
        "png_signature", "A PNG file does not begin with its signature.", PNG, *png[:2], b"\0" + png[2][1:]
    )
    picture_fault("png_cut", "A PNG file does not end with IEND.", PNG, *png[:2], png[2][:-12])
    picture_fault("jpeg_cut", "A JPEG file does not end with EOI.", JPEG, *jpeg[:2], jpeg[2][:-2])
    picture_fault("other_codec", "The entry of a PNG file says JPEG.", JPEG, *png)
    for codec in 2, 255:
        picture_fault(f"codec_{codec}", f"The codec of a picture is {codec}.", codec, *png, issue=8007)
    half = math.sqrt(0.5)
    for name, kind, fields in (
        ("type", 0, {"type": 3}),
        ("position_nan", 1, {"position": (math.nan, 0.0, 0.0)}),
        ("directional_position", 0, {"position": (0.0, 0.0, 1.0)}),
        ("directional_range", 0, {"range": 1.0}),
        ("point_direction", 1, {"direction": (0.0, 0.0, 1.0)}),
        ("point_cone", 1, {"outer_cone": 0.5}),
        ("direction_short", 0, {"direction": (0.0, 0.0, 0.999)}),
        ("direction_zero", 2, {"direction": (0.0, 0.0, 0.0)}),
        ("direction_nan", 0, {"direction": (half, half, math.nan)}),
        ("colour_above", 0, {"colour": (0.0, 1.5, 0.0)}),
        ("colour_negative", 0, {"colour": (0.0, 0.0, -0.1)}),
        ("intensity_negative", 1, {"intensity": -1.0}),
        ("intensity_infinite", 1, {"intensity": math.inf}),
        ("range_negative", 1, {"range": -1.0}),
        ("cone_equal", 2, {"inner_cone": 0.5, "outer_cone": 0.5}),
        ("cone_negative", 2, {"inner_cone": -0.1}),
        ("cone_wide", 2, {"outer_cone": 1.6}),
    ):
        fault(
            f"light_{name}",
            f"A light of type {kind} has {fields}.",
            8008,
            environment(lights=[light(kind, **fields)]),
            "18.4",
        )


whole()
faults()
