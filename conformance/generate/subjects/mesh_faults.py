"""Faults of meshes in the raw, Draco and fast profiles: clauses 8.1 to 8.6, 8.11 and 8.13."""

import struct

from .. import draco_writer, media, meshes
from ..case import faulty
from ..packing import pack, patched
from ..recipes import between, in_group
from .mesh_whole import by_hand, draco_payload

GRID = meshes.grid(5, 4)
RAW = meshes.raw(meshes.TETRAHEDRON)
MOST = meshes.MOST


def mesh(name, title, clauses, payload, issue, *, key=True):
    """The payload comes after a good mesh, and before a good group."""
    faulty(
        f"mesh_{name}",
        title,
        clauses,
        lambda: in_group(
            lambda s: s.chunk("MESH", payload() if callable(payload) else payload, 1, 3, key, fault=issue)
        ),
    )


def header():
    for size in (0, 1, 15):
        mesh(f"header_{size}_bytes", f"A MESH payload of {size} bytes.", "8.3", RAW[:size], 3001)
    mesh(
        "header_reserved",
        "The reserved field is 1.",
        "8.3",
        patched(RAW, "MESH payload", "reserved", 1),
        3001,
    )
    for profile in (3, 6, 127, 128, 255):
        mesh(
            f"profile_{profile}",
            f"A mesh of profile {profile}.",
            "8.3",
            patched(RAW, "MESH payload", "profile", profile),
            3002,
        )
    for attributes in (4, 0x80):
        mesh(
            f"attribute_{attributes}",
            f"Attribute bits {attributes:#x}.",
            "8.3",
            patched(RAW, "MESH payload", "attributes", attributes),
            3002,
        )
    two = meshes.TRIANGLE.positions[:2]
    mesh(
        "no_vertices", "A mesh without vertices and faces.", "8.3 12", meshes.raw(meshes.Shape([], [])), 3003
    )
    mesh("two_vertices", "A mesh of two vertices.", "8.3", meshes.raw(meshes.Shape(two, [(0, 1, 0)])), 3003)
    mesh(
        "no_faces",
        "A mesh of three vertices without a face.",
        "8.3",
        meshes.raw(meshes.TRIANGLE._replace(faces=[])),
        3003,
    )
    mesh(
        "many_vertices",
        "The header declares 2^32 - 1 vertices.",
        "13",
        patched(RAW, "MESH payload", "vertex_count", 2**32 - 1),
        7001,
    )
    mesh(
        "many_faces",
        "The header declares 2^31 faces.",
        "13",
        patched(RAW, "MESH payload", "face_count", 2**31),
        7001,
    )
    mesh(
        "key_without_flag", "A raw mesh without the key flag, after a key mesh.", "8.3", RAW, 3017, key=False
    )
    mesh("fast_without_flag", "A fast mesh without the key flag.", "8.3", meshes.fast(GRID), 3017, key=False)


def raw():
    mesh("raw_short", "A raw payload lacks its last byte.", "8.3", RAW[:-1], 3004)
    mesh("raw_long", "A raw payload has a face too many.", "8.3", RAW + RAW[-12:], 3004)
    mesh(
        "raw_textured_short",
        "A raw payload says that it has texture coordinates and has none.",
        "8.3 8.6",
        meshes.raw(meshes.TETRAHEDRON, attributes=1, texture_bits=8),
        3004,
    )
    mesh(
        "raw_normals_short",
        "A raw payload lacks the normals that it declares.",
        "8.3 8.13",
        meshes.raw(meshes.TETRAHEDRON, attributes=2, normal_bits=8),
        3004,
    )

    def shape(name, title, issue, clauses="8.3", base=meshes.TETRAHEDRON, **change):
        mesh(name, title, clauses, meshes.raw(base._replace(**change)), issue)

    faces = meshes.TETRAHEDRON.faces
    shape("index_at_count", "A face uses vertex 4 of 4.", 3005, faces=[*faces[:3], (1, 3, 4)])
    shape("index_greatest", "A face uses vertex 2^32 - 1.", 3005, faces=[(0, 1, 2**32 - 1), *faces[1:]])
    for corners in ((0, 0, 1), (0, 1, 0), (1, 0, 0), (2, 2, 2)):
        text = "".join(map(str, corners))
        shape(f"index_repeated_{text}", f"A face has the vertices {corners}.", 3005, faces=[*faces, corners])
    shape("unreferenced_first", "No face uses the first vertex.", 3011, faces=[(1, 2, 3), (1, 3, 2)])
    shape("unreferenced_last", "No face uses the last vertex.", 3011, faces=[(0, 1, 2)])
    for axis in range(3):
        for sign, name in (1, "above"), (-1, "below"):
            position = [0, 0, 0]
            position[axis] = sign * (MOST + 1)
            shape(
                f"lattice_{name}_{'xyz'[axis]}",
                f"A position is beyond the lattice: {tuple(position)}.",
                3006,
                "8.1",
                positions=[tuple(position), *meshes.TETRAHEDRON.positions[1:]],
            )
    shape(
        "lattice_extreme",
        "A position is -2^31.",
        3006,
        "8.1",
        positions=[*meshes.TETRAHEDRON.positions[:3], (0, 0, -(2**31))],
    )


def attributes():
    textured, normals = meshes.textured(GRID, 8), meshes.with_normals(GRID, 6)

    def payload(name, title, issue, clauses, base, **fields):
        mesh(name, title, clauses, meshes.raw(base, **fields), issue)

    payload("texture_bits_0", "Texture coordinates with 0 bits.", 3014, "8.6", textured, texture_bits=0)
    payload("texture_bits_17", "Texture coordinates with 17 bits.", 3014, "8.6", textured, texture_bits=17)
    payload(
        "texture_bits_without",
        "8 texture bits without texture coordinates.",
        3014,
        "8.6",
        GRID,
        texture_bits=8,
    )
    payload("normal_bits_1", "Normals with 1 bit.", 3030, "8.13", normals, normal_bits=1)
    payload("normal_bits_13", "Normals with 13 bits.", 3030, "8.13", normals, normal_bits=13)
    payload("normal_bits_0", "Normals with 0 bits.", 3030, "8.13", normals, normal_bits=0)
    payload("normal_bits_without", "6 normal bits without normals.", 3030, "8.13", GRID, normal_bits=6)

    def ranged(name, title, issue, base, **change):
        clauses = "8.6" if issue == 3015 else "8.13"
        faulty(
            f"mesh_{name}",
            title,
            clauses,
            lambda: between(lambda s: _alone(s, base._replace(**change), issue)),
        )

    ranged(
        "texture_range_u",
        "A texture index u is 257 of 256.",
        3015,
        textured,
        texture=[(257, 0), *textured.texture[1:]],
    )
    ranged(
        "texture_range_v",
        "A texture index v is 2^32 - 1.",
        3015,
        textured,
        texture=[*textured.texture[:-1], (0, 2**32 - 1)],
    )
    ranged(
        "normal_range_first",
        "A normal index is 63 of 62.",
        3031,
        normals,
        normals=[(63, 0), *normals.normals[1:]],
    )
    ranged(
        "normal_range_second",
        "A normal index is 2^31.",
        3031,
        normals,
        normals=[*normals.normals[:-1], (0, 2**31)],
    )
    for name, second, issue in (
        ("texture_in_group", meshes.textured(GRID, 9), 3016),
        ("texture_appears", GRID, 3016),
        ("normals_in_group", meshes.with_normals(textured, 6), 3032),
    ):
        first = meshes.textured(GRID, 8)
        clause = "8.6" if issue == 3016 else "8.13"
        faulty(
            f"mesh_{name}",
            "A mesh has other attribute bits than the first mesh of its track in the group.",
            clause,
            lambda first=first, second=second, issue=issue: between(lambda s: _two(s, first, second, issue)),
        )
    with_normals = meshes.with_normals(GRID, 7)
    faulty(
        "mesh_normals_bits_in_group",
        "Normal bits change from 6 to 7 within a group.",
        "8.13",
        lambda: between(lambda s: _two(s, normals, with_normals, 3032)),
    )


def _alone(s, shape, issue):
    s.begin(2, 3)
    s.chunk("MESH", meshes.raw(shape), 1, 2, True, fault=issue)
    s.end()


def _two(s, first, second, issue):
    s.begin(2, 4)
    s.chunk("MESH", meshes.raw(first), 1, 2, True)
    s.chunk("MESH", meshes.raw(second), 1, 3, True, fault=issue)
    s.end()


def draco():
    name = "ball_speed_5"
    vertices, faces, good = media.draco(name)

    def changed(case, title, issue, data=None, **fields):
        mesh(f"draco_{case}", title, "8.4", draco_payload(name, data=data, **fields), issue)

    def byte(at, value):
        return good[:at] + bytes([value]) + good[at + 1 :]

    changed("magic", "The bitstream begins with DRACX.", 3007, byte(4, ord("X")))
    changed("empty", "The payload ends after the MESH header.", 3012, b"")
    changed("version_major", "The bitstream has version 1.2.", 3007, byte(5, 1))
    changed("version_minor", "The bitstream has version 2.3.", 3007, byte(6, 3))
    changed("point_cloud", "The bitstream is a point cloud.", 3007, byte(7, 0))
    changed("method", "The bitstream has the method 2.", 3007, byte(8, 2))
    changed("metadata", "The bitstream has the flag of metadata.", 3007, byte(10, 0x80))
    changed("vertex_count", "The MESH header declares a vertex more.", 3008, vertex_count=vertices + 1)
    changed("face_count", "The MESH header declares a face less.", 3008, face_count=faces - 1)
    changed("cut", "The bitstream lacks its last byte.", 3009, good[:-1])
    changed("half", "The bitstream is cut in the middle.", 3009, good[: len(good) // 2])
    changed("extra", "A byte follows the bitstream.", 3009, good + b"\0")
    tiny = struct.pack("<5sBBBBH", b"DRACO", 2, 2, 1, 1, 0)
    mesh(
        "draco_density",
        "A bitstream of 40 bytes declares 1,000 vertices.",
        "8.4",
        pack("MESH payload", profile=1, vertex_count=1000, face_count=500) + tiny + bytes(29),
        3012,
    )
    mesh(
        "draco_density_faces",
        "A bitstream of 40 bytes declares 641 faces.",
        "8.4",
        pack("MESH payload", profile=1, vertex_count=400, face_count=641) + tiny + bytes(29),
        3012,
    )
    for case, title, source, fields in (
        (
            "texture_missing",
            "The header declares texture coordinates that the bitstream lacks.",
            name,
            {"texture_bits": 12},
        ),
        (
            "texture_extra",
            "The bitstream has texture coordinates that the header does not declare.",
            "grid_textured",
            {},
        ),
        (
            "normals_extra",
            "The bitstream has normals that the header does not declare.",
            "grid_both",
            {"texture_bits": 12},
        ),
        ("generic", "The bitstream has an attribute of floats after the position.", "bad_float", {}),
    ):
        faulty(
            f"mesh_draco_{case}",
            title,
            "8.4",
            lambda source=source, fields=fields: between(
                lambda s: _alone_payload(s, draco_payload(source, **fields), 3010)
            ),
        )
    mesh(
        "draco_steps",
        "Joining and renumbering vertices takes more than 16 steps per face.",
        "8.4",
        draco_payload("bad_steps"),
        3013,
    )
    mesh(
        "draco_lattice",
        "A position of a Draco mesh is beyond the lattice.",
        "8.1 8.4",
        draco_payload("bad_beyond"),
        3006,
    )
    faulty(
        "mesh_draco_texture_range",
        "A texture index of a Draco mesh is beyond its bits.",
        "8.4 8.6",
        lambda: between(lambda s: _alone_payload(s, draco_payload("grid_textured", 11), 3015)),
    )
    faulty(
        "mesh_draco_normal_range",
        "A normal index of a Draco mesh is beyond its bits.",
        "8.4 8.13",
        lambda: between(lambda s: _alone_payload(s, draco_payload("grid_normals", 0, 9), 3031)),
    )


def draco_by_hand():
    """Bitstreams that a decoder of all of Draco reads, and some that it does not."""
    grid = meshes.grid(9, 7)

    def broken(case, title, issue=3009, **options):
        mesh(f"draco_sequential_{case}", title, "8.4", by_hand(grid, **options), issue)

    broken(
        "differences", "The corners are coded as differences (way 0).", way=draco_writer.DIFFERENCES, width=9
    )
    broken("way_2", "The corners are coded in the way 2.", way=2, width=9)
    broken("no_prediction", "The positions have no prediction (-2).", prediction=-2, size=2)
    broken(
        "parallelogram", "The sequential method has the prediction parallelogram (1).", prediction=1, width=9
    )
    broken("transform", "The transform is 0.", transform=0, width=9)
    broken("range", "The largest value is below the least.", size=2, least=5, most=4)
    broken("coding", "The positions are coded in way 0, not as integers.", 3010, coding=0, width=9)
    good = draco_writer.values(grid.positions, width=9)
    at = good.index(b"\1\1\x09")  # coded, raw, width

    def changed(case, title, bytes_, offset=at):
        broken(case, title, positions=good[:offset] + bytes_ + good[offset + len(bytes_) :])

    changed("coded_2", "The numbers are coded in way 2.", b"\2")
    changed("scheme", "The symbols have the scheme 2.", b"\2", at + 1)
    for width, wrong, name in ((8, 0, "no bits"), (18, 19, "19 bits")):
        coded = draco_writer.values(grid.positions, width=width)
        coded = coded.replace(bytes([1, 1, width]), bytes([1, 1, wrong]), 1)
        broken(
            f"alphabet_{wrong}", f"The alphabet has {name}, and the precision of {width}.", positions=coded
        )
    changed(
        "precision",
        "The probabilities add up to less than the precision of the declared bits.",
        b"\x0a",
        at + 2,
    )
    for size in (0, 5):
        plain = draco_writer.values(grid.positions, size=4)
        broken(
            f"size_{size}",
            f"The numbers have {size} bytes each.",
            positions=plain[:3] + bytes([size]) + plain[4:],
        )
    points, faces = len(grid.positions), len(grid.faces)
    long_form = bytes([faces | 128, 0, points])
    broken("long_number", "The number of faces is not in its shortest form.", counts=long_form, width=9)
    whole = draco_writer.uleb128(1 << 32) + bytes([points])
    broken("number_2_32", "The number of faces is 2^32.", counts=whole, width=9)
    broken("counts", "The bitstream declares a face more.", 3008, counts=bytes([faces + 1, points]), width=9)
    wide = {"least": -(1 << 30), "most": (1 << 30) - 1}
    broken("range_2_31", "The range of values is 2^31.", width=9, **wide)
    broken("tags_34", "An alphabet of tags has 34 symbols.", least_symbols=34)
    many = by_hand(meshes.grid(20, 15), width=18, least_symbols=(1 << 18) + 1)
    mesh("draco_sequential_alphabet_long", "A raw alphabet has 2^18 + 1 symbols.", "8.4", many, 3009)
    wrong = grid._replace(faces=[(0, 1, points), *grid.faces[1:]])
    mesh("draco_sequential_corner", "A corner is no vertex.", "8.3 8.4", by_hand(wrong, width=9), 3005)


def draco_connectivity():
    """Bytes of a ring of 54 vertices and 108 faces: 107 symbols, 6 splits, 2 events."""
    good = media.draco("torus")[2]
    headers = good.index(b"\1\xff\0\0\1\0\5\3\0")

    def changed(case, title, at, value, issue=3009):
        data = good[:at] + bytes([value]) + good[at + 1 :]
        mesh(f"draco_ring_{case}", title, "8.4", draco_payload("torus", data=data), issue)

    for size, issue in ((10, 3007), (11, 3009)):
        data = draco_payload("torus", data=good[:size])
        mesh(f"draco_ring_{size}_bytes", f"{size} bytes of bitstream.", "8.4", data, issue)
    assert good[11:24] == bytes([0, 54, 108, 0, 107, 6, 2, 97, 11, 5, 61, 3, 28])
    changed("traversal", "The traversal is 1.", 11, 1)
    changed("seams", "An attribute has seams.", 14, 1, 3010)
    changed("symbols_more", "More symbols than faces.", 15, 109)
    fewer = good[:13] + b"\x6b" + good[14:]
    mesh(
        "draco_ring_start_face",
        "A start face after as many faces as are declared.",
        "8.4",
        draco_payload("torus", data=fewer, face_count=107),
        3009,
    )
    changed("symbols_few", "Fewer symbols than 108 faces need at least.", 15, 80)
    changed("splits_more", "A split more is declared than there is.", 16, 7)
    changed("splits_fewer", "A split fewer is declared than there are.", 16, 5)
    changed("events_symbols", "More events than symbols.", 17, 108)
    changed("event_back", "The first event goes back beyond the first symbol.", 19, 98)
    changed("event_source", "The second event has a source after the last symbol.", 20, 10)
    changed("bits_more", "The symbols do not fill their bytes.", 23, 29)
    changed("bits_fewer", "The symbols take more than their bytes.", 23, 27)
    for offset, name, value, issue, title in (
        (0, "decoders", 2, 3010, "Two attributes decoders."),
        (1, "connectivity", 0, 3010, "The attributes have a connectivity of their own."),
        (2, "per_corner", 1, 3010, "The attributes are coded for each corner."),
        (3, "order", 2, 3009, "The values have the order 2."),
        (4, "count", 2, 3010, "Two attributes."),
        (5, "type", 4, 3010, "The positions have the type of generic values."),
        (6, "data_type", 6, 3010, "The positions are UINT32."),
        (7, "components", 2, 3010, "The positions have two components."),
        (8, "normalised", 1, 3010, "The positions are normalised."),
    ):
        changed(name, title, headers + offset, value, issue)


def _alone_payload(s, payload, issue):
    s.begin(2, 3)
    s.chunk("MESH", payload, 1, 2, True, fault=issue)
    s.end()


def fast():
    grid = meshes.grid(6, 5)
    count = len(grid.faces)

    def case(name, title, issue, base=grid, **change):
        mesh(f"fast_{name}", title, "8.11", meshes.fast(base, **change), issue)

    head = grid.header(meshes.FAST)
    mesh(
        "fast_no_size", "The payload ends inside the size of the vertex stream.", "8.11", head + b"\1\0", 3023
    )
    case("size_beyond", "The vertex stream is larger than the payload.", 3023, size=100000)
    case("size_greatest", "The vertex stream has 2^32 - 1 bytes.", 3023, size=2**32 - 1)
    case(
        "density_vertices",
        "The vertex stream is too short for the vertex count.",
        3024,
        vertices=lambda v: v[: 33 + 12 - 1],
    )
    case(
        "density_faces",
        "The index stream is too short for the face count.",
        3024,
        indices=lambda i: i[: 16 + count],
    )
    case("density_count", "The header declares 100,000 vertices.", 3024, vertex_count=100000)
    case("vertices_version", "The vertex stream has version 1.", 3025, vertices=lambda v: b"\xa1" + v[1:])
    case(
        "vertices_padding",
        "A byte of padding before the baseline is 1.",
        3025,
        vertices=lambda v: v[:-32] + b"\1" + v[-31:],
    )
    case(
        "vertices_extra",
        "A byte lies between the last block and the tail.",
        3025,
        vertices=lambda v: v[:-32] + b"\0" + v[-32:],
    )
    case(
        "vertices_short",
        "The blocks end one byte late: into the tail.",
        3025,
        vertices=lambda v: v[:-33] + v[-32:],
    )
    case("faces_version", "The index stream has version 0.", 3026, indices=lambda i: b"\xe0" + i[1:])
    case("faces_table_end", "The last byte of the table is 1.", 3026, indices=lambda i: i[:-1] + b"\1")
    case(
        "faces_table_15",
        "A half-byte of the table is 15.",
        3026,
        indices=lambda i: i[:-15] + b"\x7f" + i[-14:],
    )
    case(
        "faces_extra",
        "A byte lies between the data and the table.",
        3026,
        indices=lambda i: i[:-16] + b"\0" + i[-16:],
    )
    far = grid._replace(faces=[(29, 3, 17), *grid.faces])
    case(
        "faces_overlong",
        "A number of the index stream is not in its shortest form.",
        3026,
        far,
        indices=overlong,
    )
    case(
        "faces_data_short",
        "The data of the index stream ends too early.",
        3026,
        far,
        indices=lambda i: i[:-17] + i[-16:],
    )
    case(
        "index",
        "A face of a fast mesh uses a vertex that does not exist.",
        3005,
        indices=lambda i: meshes.index_stream([*grid.faces[:-1], (28, 29, 30)])[0],
    )
    case(
        "empty_fifo",
        "A face of a fast mesh uses an entry of the FIFO that is empty.",
        3005,
        base=meshes.TRIANGLE,
        indices=lambda i: b"\xe1\xe0" + i[2:],
    )
    case(
        "unreferenced",
        "No face of a fast mesh uses its last vertex.",
        3011,
        base=grid._replace(faces=[f for f in grid.faces if 29 not in f]),
    )
    case(
        "lattice",
        "A position of a fast mesh is beyond the lattice.",
        3006,
        base=grid._replace(positions=[(MOST + 1, 0, 0), *grid.positions[1:]]),
    )


def overlong(stream):
    """The first number of the data, which follows the pair of corners of the first face, gets a byte more."""
    at = 1 + len(meshes.grid(6, 5).faces) + 1 + 1
    end = at
    while stream[end] & 128:
        end += 1
    return stream[:end] + bytes([stream[end] | 128, 0]) + stream[end + 1 :]


header()
raw()
attributes()
draco()
draco_by_hand()
draco_connectivity()
fast()
