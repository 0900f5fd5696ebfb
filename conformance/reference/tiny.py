"""The tiny files of conformance/tiny, and Appendix A of spec/fvv.md, which takes them apart byte by byte."""

from .container import Part, Stream, structure, uleb128, zigzag
from .mesh import Mesh, raw_parts
from .mesh_delta import Sequence
from .range_coder import RangeEncoder
from .visibility import Surface, centre, decode_stream

# Four corners of a cube of 200 mm; counter-clockwise seen from outside.
TETRAHEDRON = Mesh(
    positions=[(100, 100, 100), (100, -100, -100), (-100, 100, -100), (-100, -100, 100)],
    faces=[(0, 1, 2), (0, 3, 1), (0, 2, 3), (1, 3, 2)],
)


def empty():
    stream = Stream()
    stream.scene()
    stream.finish()
    return stream


def tetrahedron(name="mesh"):
    stream = Stream()
    stream.scene()
    stream.track(1, 1, name)
    stream.begin_group(0, 1)
    stream.chunk("MESH", raw_parts(TETRAHEDRON), track=1, time=0, key=True)
    stream.end_group()
    stream.finish()
    return stream


# Columns of R are the camera's axes: it looks down, along -z, with its right along +x.
DOWN = (1.0, 0.0, 0.0, 0.0, -1.0, 0.0, 0.0, 0.0, -1.0)
CAMERAS = {0: (0.0, 0.0, 1.0), 1: (0.5, 0.0, 1.0)}  # centres in metres
# Of the track of moving cameras: 2^-8 for the quaternion, half metres, whole pixels.
CALIBRATION_BITS = {"rotation_bits": 8, "position_bits": 1}
QUATERNION = (0, 256, 0, 0)


def camera_payload(identifier, name, moves):
    x, y, z = CAMERAS[identifier]
    values = {
        "id": identifier,
        "flags": int(moves),
        "name_size": len(name),
        "width": 16,
        "height": 16,
        "fx": 16.0,
        "fy": 16.0,
        "cx": 8.0,
        "cy": 8.0,
        "r_max": float("inf"),
        "rotation": DOWN,
        "translation": (0.0 - x, y, z),
    }
    meanings = {
        "r_max": "infinite: no lens model",
        "rotation": "x to the right, y and z turned round",
        "translation": f"-R times the centre ({x:g}, {y:g}, {z:g})",
    }
    if moves:
        meanings["flags"] = "1: moves"
    return [*structure("CAMR payload", values, meanings), Part(name.encode(), "name", f'"{name}"')]


def video_payload():
    values = {"codec": b"jpeg", "width": 32, "height": 16, "bit_depth": 8, "full_range": 1}
    values |= {"colour_primaries": 1, "transfer_characteristics": 1, "matrix_coefficients": 6}
    meanings = {"codec": '"jpeg"', "shows": "0: tiles"}
    return structure("VCFG payload", values, meanings)


def tiles_payload():
    parts = structure("TILE payload", {"count": len(CAMERAS)})
    for camera in CAMERAS:
        values = {"camera": camera, "source": (0, 0, 16, 16), "destination": (16 * camera, 0, 16, 16)}
        parts += structure("TILE entry", values)
    return parts


def calibration_payload(number, centre_of, before):
    """Of camera 1 alone. Returns the parts and the values; before: those of the chunk before."""
    values = [*QUATERNION, *(round(2 * x) for x in centre_of), 16, 16, 8, 8, 0, 0]
    names = ["q0", "q1", "q2", "q3", "X", "Y", "Z", "fx", "fy", "cx", "cy", "skew", "r_max"]
    parts = structure("CALB payload", {"number": number, "count": 1, **CALIBRATION_BITS})
    parts.append(Part(uleb128(1), "camera", "1"))
    for name, value, former in zip(names, values, before or [0] * len(values)):
        change = value - former
        meaning = f"zigzag of {change:+}: {value}" if change else f"0: {value}"
        parts.append(Part(uleb128(zigzag(change)), name, meaning))
    return parts, values


def delta_payload(sequence):
    """A delta frame that moves all vertices by one lattice step along x: only the first has a residual."""
    vertices = len(TETRAHEDRON.positions)
    encoder = RangeEncoder([1, 0, 0] + [0] * (3 * vertices - 1))
    sequence.move([(4, encoder)])
    values = {"profile": 2, "vertex_count": vertices, "face_count": len(TETRAHEDRON.faces)}
    data = encoder.data()
    return [
        *structure("MESH payload", values, {"profile": "2: delta"}),
        Part(uleb128(1), "number", "1: the first after the key mesh"),
        Part(uleb128(1), "level count", "1: all four vertices are survivors"),
        Part(uleb128(4), "step", "4 quarters: one lattice step"),
        Part(uleb128(len(data)), "size", f"{len(data)} of data"),
        Part(data, "level", "vertex 0: 1, 0, 0 on x, 0 on y and z; vertices 1 to 3: nine times 0"),
    ]


def visibility_payload(centres):
    """Each camera sees all vertices that face it but the last in coding order; all levels are the first."""
    lattice = (0.0, 0.0, 0.0, 0.001)
    surface = Surface(len(TETRAHEDRON.positions), TETRAHEDRON.faces)
    streams = []
    for place in centres:
        t = [-sum(DOWN[3 * i + j] * place[j] for j in range(3)) for i in range(3)]
        facing = surface.facing(TETRAHEDRON.positions, centre(DOWN, t, lattice), 0)
        vertices = [vertex for vertex in surface.order if facing[vertex]]
        sides = [1] * (len(vertices) - 1) + [0]
        # All corners of a tetrahedron are neighbours: each vertex has one of the other side.
        encoder = RangeEncoder(sides + [1] * len(vertices))
        decode_stream(encoder, surface, facing, [0] * surface.count)
        streams.append((encoder.data(), vertices, sides))
    values = {"mesh_track": 1, "vertex_count": surface.count, "camera_count": len(centres)}
    parts = structure("VISI payload", values, {"number": "0: key"})
    for camera, (data, _, _) in enumerate(streams):
        parts.append(
            Part(uleb128(min(camera, 1)), "camera", f"{camera}" if not camera else f"1 more: {camera}")
        )
        parts.append(Part(uleb128(len(data)), "size", f"{len(data)} of data"))
    for camera, (data, vertices, sides) in enumerate(streams):
        seen = ", ".join(f"{vertex}: {bit}" for vertex, bit in zip(vertices, sides))
        parts.append(
            Part(
                data,
                f"stream of camera {camera}",
                f"sides of the vertices that face it, in coding order: {seen}; then a 1 for the level of each",
            )
        )
    return parts


def cameras():
    stream = Stream()
    stream.scene()
    for identifier, kind, name in (1, 1, "mesh"), (2, 2, "video"), (3, 3, "motion"), (4, 4, "seen"):
        stream.track(identifier, kind, name)
    stream.chunk("CAMR", camera_payload(0, "above", moves=False))
    stream.chunk("CAMR", camera_payload(1, "crane", moves=True))
    stream.chunk("VCFG", video_payload(), track=2)
    stream.chunk("TILE", tiles_payload(), track=2)
    stream.begin_group(0, 2)
    stream.chunk("MESH", raw_parts(TETRAHEDRON), track=1, time=0, key=True)
    first, values = calibration_payload(0, CAMERAS[1], None)
    stream.chunk("CALB", first, track=3, time=0, key=True)
    stream.chunk("VISI", visibility_payload(CAMERAS.values()), track=4, time=0, key=True)
    stream.chunk("MESH", delta_payload(Sequence(TETRAHEDRON)), track=1, time=1)
    moved, _ = calibration_payload(1, (1.0, 0.0, 1.0), values)
    stream.chunk("CALB", moved, track=3, time=1)
    stream.end_group()
    stream.finish()
    return stream


FILES = {
    "empty.fvv": (empty, "A stream without groups: file header, one configuration block, index, footer."),
    "tetrahedron.fvv": (tetrahedron, "One mesh track, one group, one frame: a raw mesh of four vertices."),
    "cameras.fvv": (
        cameras,
        "Two frames of a mesh, a key and a delta frame, and two cameras, one of which moves: with their layout in a video "
        "frame, calibration at both times and visibility at the first. There are no pictures. Chunks and fields that are "
        "as in tetrahedron.fvv are left out.",
    ),
}


# Of the last file: the last camera and the last mesh, and all chunks of the other types.
SHOWN = {"CAMR": 1, "VCFG": 1, "TILE": 1, "CALB": 2, "VISI": 1, "MESH": 1}


def shown(sections):
    """The sections of the last file that the appendix takes apart."""
    of_type = [section.title[:4] for section in sections]
    return [
        section
        for i, section in enumerate(sections)
        if section.title[:4] in SHOWN and of_type[i:].count(section.title[:4]) <= SHOWN[section.title[:4]]
    ]


def files():
    """The bytes of each file, by name."""
    return {name: make().data() for name, (make, _) in FILES.items()}


def appendix():
    """Appendix A: every byte of the files, but for chunks of the last one that are like others."""
    out = [
        "The numbers in the first column are offsets in the file. The files are in",
        "[conformance/tiny](../conformance/tiny/README.md).",
    ]
    for name, (make, text) in FILES.items():
        stream = make()
        out += ["", f"### {name}", "", f"{text} {stream.size} bytes."]
        for section in shown(stream.sections) if name == "cameras.fvv" else stream.sections:
            out += [
                "",
                f"**{section.title}**",
                "",
                "| offset | bytes | field | meaning |",
                "|---|---|---|---|",
            ]
            offset = section.offset
            for part in section.parts:
                out.append(f"| {offset} | `{part.data.hex(' ').upper()}` | {part.name} | {part.meaning} |")
                offset += len(part.data)
    return "\n".join(out)
