"""Whole and faulty video: clause 10, with samples of every codec."""

import struct
from typing import NamedTuple

from reference import openexr

from ... import media, payloads
from ...case import faulty, valid
from ...recipes import frame, group, opened

VIDEO = payloads.VIDEO
TRACK = 2
CODED = (
    "h264",
    "h264_baseline",
    "h264_main",
    "h264_slices",
    "hevc",
    "hevc_10",
    "vp9",
    "vp9_10",
    "av1",
    "av1_10",
)
PICTURES = ("jpeg", "jpeg_grey", "jpeg_444", "jpeg_progressive")


class Setup(NamedTuple):
    """The video track of a block: VCFG, and layouts of 32 x 32 pixels for the cameras of TILE, or an atlas."""

    clip: media.Clip
    cameras: int = 2
    shows: int = 0
    fields: dict = {}

    def config(self, record=None, string=None, **fields):
        clip = self.clip
        ten = clip.bit_depth == 10
        values = {
            "width": clip.width,
            "height": clip.height,
            "bit_depth": clip.bit_depth,
            "shows": self.shows,
        }
        if clip.codec == "oexr":
            values |= {"transfer_characteristics": 8, "matrix_coefficients": 0, "full_range": 1}
        elif clip.codec != "jpeg":
            values |= {"matrix_coefficients": 1, "full_range": 0}
        values |= {"transfer_characteristics": 14} if ten else {}
        record = clip.record if record is None else record
        string = clip.string if string is None else string
        return payloads.video(
            fields.pop("codec", clip.codec), record, string, **values | self.fields | fields
        )

    def layout(self):
        return payloads.tiles(
            *[payloads.tile(i, (0, 0, 32, 32), (32 * i, 0, 32, 32)) for i in range(self.cameras)]
        )

    def block(self, s, config=None, layout=None):
        s.chunk("SCEN", payloads.scene())
        s.chunk("TRAK", payloads.track(payloads.MESH, "mesh"), track=1)
        s.chunk("TRAK", payloads.track(VIDEO, "video"), track=TRACK)
        for i in range(self.cameras):
            s.chunk(
                "CAMR", payloads.camera(i, f"camera {i}", width=32, height=32, centre=(0.1 * i, 0.0, 1.0))
            )
        s.chunk("VCFG", self.config() if config is None else config, track=TRACK)
        if self.shows == 0:
            s.chunk("TILE", self.layout() if layout is None else layout, track=TRACK)

    def groups(self, s, start=0, samples=None):
        """A group for each key sample."""
        samples = self.clip.samples if samples is None else samples
        runs = []
        for key, data in samples:
            if key and not (runs and self.clip.codec in ("jpeg", "oexr")):
                runs.append([])
            runs[-1].append((key, data))
        for run in runs:
            s.begin(start, start + len(run))
            for key, data in run:
                frame(s, start)
                s.chunk("VPKT", data, TRACK, start, key)
                start += 1
            s.end()
        return start

    def stream(self):
        s = opened_with(self)
        self.groups(s)
        s.finish()
        return s


def opened_with(setup, **changed):
    from ...writer import Stream

    s = Stream()
    setup.block(s, **changed)
    return s


def of(name, **more):
    return Setup(media.clip(name), **more)


def filled_jpeg():
    """T.81 allows any number of bytes FF before a marker."""
    setup = of("jpeg")
    samples = []
    for key, data in setup.clip.samples:
        at = data.index(b"\xff\xc0")
        samples.append((key, data[:2] + b"\xff" + data[2:at] + b"\xff\xff" + data[at:]))
    s = opened_with(setup)
    setup.groups(s, samples=samples)
    s.finish()
    return s


def exr(width=64, height=32, compression=openexr.ZIPS, frames=2, **changed):
    samples = [
        (True, openexr.write(width, height, openexr.bars(width, height, i), compression, **changed))
        for i in range(frames)
    ]
    return Setup(media.Clip("oexr", width, height, 16, "", b"", samples))


def whole():
    for name in (*CODED, *PICTURES):
        clip = media.clip(name)
        valid(
            f"video_{name}",
            f"Video of {clip.codec} with {clip.bit_depth} bits: {name.replace('_', ' ')}.",
            "10",
            lambda name=name: of(name).stream(),
        )
    for name, compression in ("none", openexr.NONE), ("zips", openexr.ZIPS), ("zip", openexr.ZIP):
        valid(
            f"video_oexr_{name}",
            f"OpenEXR video, compression {name}.",
            "10.12",
            lambda compression=compression: exr(compression=compression).stream(),
        )
    valid("video_jpeg_fill", "JPEG samples with fill bytes before their markers.", "10.4", filled_jpeg)
    valid("video_oexr_narrow", "OpenEXR video of 1 x 40 pixels.", "10.12", lambda: narrow_exr(1, 40))
    valid(
        "video_oexr_attributes",
        "OpenEXR samples with attributes that are ignored.",
        "10.12",
        lambda: exr(
            chromaticities=("chromaticities", bytes(32)),
            owner=("string", b"fvv"),
            type=("string", b"scanlineimage"),
            chunkCount=("int", struct.pack("<i", 32)),
        ).stream(),
    )
    valid(
        "video_atlas",
        "A video track shows an atlas, addressed by texture coordinates.",
        "8.6 10.1",
        lambda: of("jpeg", shows=1, cameras=0).stream(),
    )
    for name, fields in (
        ("hlg", {"colour_primaries": 9, "transfer_characteristics": 18, "matrix_coefficients": 9}),
        ("pq", {"colour_primaries": 9, "transfer_characteristics": 16, "matrix_coefficients": 9}),
        ("unspecified", {"colour_primaries": 2, "transfer_characteristics": 2, "matrix_coefficients": 2}),
        ("unknown", {"colour_primaries": 77, "transfer_characteristics": 200, "matrix_coefficients": 255}),
    ):
        valid(
            f"video_colour_{name}",
            f"Colour by H.273: {fields}.",
            "10.6",
            lambda fields=fields: of("hevc_10", fields=fields).stream(),
            uncommon=name == "unknown",
            requirements=(9015,) if name == "unknown" else (),
        )
    valid(
        "video_full_range",
        "VP9 in full range, as VCFG says.",
        "10.6",
        lambda: of("vp9", fields={"full_range": 1}).stream(),
    )
    valid("video_codec_changes", "The second block has another codec for the same track.", "5 10.1", changes)
    valid("video_missing_samples", "Some frames have no sample, one has no mesh.", "11", missing)
    valid("video_unused_track", "A declared video track has no sample.", "10.1", unused)
    valid(
        "video_two_tracks",
        "Two video tracks show different cameras.",
        "10.2",
        two_tracks,
        requirements=(9021,),
    )
    valid(
        "video_same_camera_twice",
        "Two video tracks show the same camera.",
        "10.2",
        lambda: two_tracks(same=True),
        requirements=(9021,),
        uncommon=True,
    )
    valid(
        "video_ladder",
        "Three ranks of one video track and two of one mesh track.",
        "5.2",
        ladder,
        requirements=(9023,),
    )


def narrow_exr(width, height):
    setup = exr(width, height, openexr.ZIP)._replace(cameras=1)
    whole_frame = (0, 0, width, height)
    s = opened_with(setup, layout=payloads.tiles(payloads.tile(0, (0, 0, 1, 32), whole_frame)))
    setup.groups(s)
    s.finish()
    return s


def changes():
    first, second = of("jpeg"), of("h264")
    s = opened_with(first)
    end = first.groups(s)
    second.block(s)
    second.groups(s, end)
    s.finish()
    return s


def missing():
    setup = of("jpeg")
    s = opened_with(setup)
    samples = [data for _, data in setup.clip.samples]
    s.begin(0, 6)
    frame(s, 0)
    s.chunk("VPKT", samples[0], TRACK, 1, True)
    frame(s, 2)
    frame(s, 4)
    s.chunk("VPKT", samples[1], TRACK, 4, True)
    s.chunk("VPKT", samples[2], TRACK, 5, True)
    s.end()
    s.finish()
    return s


def unused():
    s = opened_with(of("av1"))
    group(s, 0)
    s.finish()
    return s


def two_tracks(same=False):
    from ...writer import Stream

    one, two = of("jpeg"), of("jpeg_grey")
    s = Stream()
    s.chunk("SCEN", payloads.scene())
    for identifier in 1, 2:
        s.chunk("TRAK", payloads.track(VIDEO, f"video {identifier}"), track=identifier)
    for i in range(3):
        s.chunk("CAMR", payloads.camera(i, width=32, height=32))
    for identifier, setup, shown in (1, one, (0, 1)), (2, two, (1, 2) if same else (2,)):
        s.chunk("VCFG", setup.config(), track=identifier)
        tiles = [payloads.tile(c, (0, 0, 32, 32), (32 * i, 0, 32, 32)) for i, c in enumerate(shown)]
        s.chunk("TILE", payloads.tiles(*tiles), track=identifier)
    s.begin(0, 3)
    for time in range(3):
        for identifier, setup in (1, one), (2, two):
            s.chunk("VPKT", setup.clip.samples[time][1], identifier, time, True)
    s.end()
    s.finish()
    return s


def ladder():
    from ... import meshes
    from ...writer import Stream

    s = Stream()
    s.chunk("SCEN", payloads.scene())
    shapes = [meshes.OCTAHEDRON, meshes.TETRAHEDRON]
    clips = [of("jpeg_444"), of("jpeg"), of("jpeg_grey")]
    for rank, shape in enumerate(shapes):
        alternate = {
            "alternate_group": 1,
            "rank": rank,
            "bit_rate": 4000 >> rank,
            "nominal_size": len(shape.faces),
        }
        s.chunk("TRAK", payloads.track(payloads.MESH, f"mesh {rank}", **alternate), track=1 + rank)
    for rank in range(3):
        alternate = {"alternate_group": 2, "rank": rank, "bit_rate": 300000 >> rank, "nominal_size": 2048}
        s.chunk("TRAK", payloads.track(VIDEO, f"video {rank}", **alternate), track=10 + rank)
    for i in range(2):
        s.chunk("CAMR", payloads.camera(i, width=32, height=32))
    for rank, setup in enumerate(clips):
        s.chunk("VCFG", setup.config(), track=10 + rank)
        s.chunk("TILE", setup.layout(), track=10 + rank)
    for start in 0, 1:
        s.begin(start, start + 1)
        for rank in (1, 0):
            s.chunk("MESH", meshes.raw(shapes[rank]), 1 + rank, start, True)
        for rank in (2, 1, 0):
            s.chunk("VPKT", clips[rank].clip.samples[start][1], 10 + rank, start, True)
        s.end()
    s.finish()
    return s


def tiles_whole():
    def layout(name, title, *tiles, **more):
        setup = of("jpeg", cameras=max(tile[0] for tile in tiles) + 1)

        def make():
            s = opened_with(setup, layout=payloads.tiles(*[payloads.tile(*tile) for tile in tiles]))
            setup.groups(s)
            s.finish()
            return s

        valid(f"tiles_{name}", title, "10.2", make, **more)

    layout("one", "One camera fills the frame.", (0, (0, 0, 32, 32), (0, 0, 64, 32)))
    layout(
        "crop",
        "Parts of the pictures.",
        (0, (3, 5, 17, 9), (0, 0, 17, 9)),
        (1, (31, 31, 1, 1), (32, 16, 1, 1)),
    )
    layout(
        "scaled",
        "A tile is enlarged, another one made smaller.",
        (0, (0, 0, 8, 4), (0, 0, 32, 32)),
        (1, (0, 0, 32, 32), (32, 0, 16, 8)),
    )
    layout(
        "touching",
        "Destinations touch, at multiples of 16.",
        (0, (0, 0, 16, 16), (0, 0, 16, 16)),
        (1, (0, 0, 16, 16), (16, 0, 16, 16)),
        (2, (0, 0, 16, 16), (0, 16, 16, 16)),
        (3, (0, 0, 16, 16), (16, 16, 48, 16)),
    )
    layout(
        "unordered",
        "Tiles in descending order of their cameras, and cameras without a tile.",
        (4, (0, 0, 16, 16), (0, 0, 16, 16)),
        (1, (0, 0, 16, 16), (16, 0, 16, 16)),
    )
    valid("tiles_64_cameras", "64 cameras, each with a tile.", "10.2 13", lambda: many_cameras(64))
    valid(
        "cameras_200",
        "200 cameras without pictures.",
        "9.2",
        lambda: cameras_only(200),
        uncommon=True,
        limits=True,
    )
    valid("tiles_group", "Groups with layouts of their own, and groups without.", "10.11", group_layouts)
    valid(
        "tiles_group_drops_camera",
        "The layout of a group leaves a camera out.",
        "10.11",
        lambda: group_layouts(drop=True),
    )
    valid("tiles_group_alone", "A group has a layout and no sample.", "10.11", layout_alone, uncommon=True)


def many_cameras(count):
    from ...writer import Stream

    setup = of("jpeg")
    s = Stream()
    s.chunk("SCEN", payloads.scene())
    s.chunk("TRAK", payloads.track(VIDEO, "video"), track=TRACK)
    for i in range(count):
        s.chunk("CAMR", payloads.camera(3 * i, f"camera {i}", centre=(0.01 * i, 0.0, 1.0)))
    s.chunk("VCFG", setup.config(width=128, height=128), track=TRACK)
    tiles = [
        payloads.tile(3 * i, (0, 0, 16, 16), (16 * (i % 8), 16 * (i // 8), 16, 16)) for i in range(count)
    ]
    s.chunk("TILE", payloads.tiles(*tiles), track=TRACK)
    s.finish()
    return s


def cameras_only(count):
    s = opened()
    for i in range(count):
        s.chunk("CAMR", payloads.camera(65534 - i, centre=(0.0, 0.001 * i, 2.0)))
    group(s, 0)
    s.finish()
    return s


def group_layouts(drop=False):
    setup = of("jpeg")
    s = opened_with(setup)
    for number in range(4):
        s.begin(number, number + 1)
        frame(s, number)
        if number in (1, 3):
            tiles = [
                payloads.tile(i, (number, 0, 16, 16), (32 * (1 - i), 16, 16, 16)) for i in range(2 - drop)
            ]
            s.chunk("TILE", payloads.tiles(*tiles), TRACK, number, True)
        s.chunk("VPKT", setup.clip.samples[number % 3][1], TRACK, number, True)
        s.end()
    s.finish()
    return s


def layout_alone():
    setup = of("jpeg")
    s = opened_with(setup)
    s.begin(0, 1)
    frame(s, 0)
    s.chunk("TILE", setup.layout(), TRACK, 0, True)
    s.end()
    s.finish()
    return s


def config_fault(name, title, clauses, issue, setup, *, in_stream=True, **changed):
    """The VCFG of the first block is wrong; a good block follows."""

    def make():
        from ...writer import Stream

        s = Stream()
        s.chunk("SCEN", payloads.scene())
        s.chunk("TRAK", payloads.track(payloads.MESH, "mesh"), track=1)
        s.chunk("TRAK", payloads.track(VIDEO, "video"), track=TRACK)
        for i in range(setup.cameras):
            s.chunk("CAMR", payloads.camera(i, width=32, height=32))
        payload = changed["payload"] if "payload" in changed else setup.config(**changed)
        s.chunk("VCFG", payload, track=TRACK, fault=issue)
        s.chunk("TILE", setup.layout(), track=TRACK)
        end = setup.groups(s)
        setup.block(s)
        setup.groups(s, end)
        s.finish()
        return s

    faulty(f"video_{name}", title, clauses, make)


def config_faults():
    jpeg = of("jpeg")
    good = jpeg.config()
    config_fault("config_short", "A VCFG payload has 23 bytes.", "10.1", 4001, jpeg, payload=good[:-1])
    config_fault("config_long", "A byte follows the VCFG payload.", "10.1", 4001, jpeg, payload=good + b"\0")
    config_fault(
        "config_record_size",
        "The record of VCFG is larger than the payload.",
        "10.1",
        4001,
        jpeg,
        record_size=100,
    )
    config_fault(
        "config_string_size",
        "The codec string is larger than the payload.",
        "10.1",
        4001,
        of("h264"),
        codec_string_size=65535,
    )
    config_fault(
        "config_text", "The codec string is no UTF-8.", "2.2 10.1", 2104, of("h264"), string=b"avc1.\xff4000a"
    )
    config_fault("codec_unknown", "The codec is unknown.", "10.1", 4002, jpeg, codec=b"vvc1")
    config_fault("shows_2", "The track shows something unknown.", "10.1 16", 4002, jpeg, shows=2)
    config_fault(
        "shows_255_string",
        "The same, with a codec string and a width of 0.",
        "10.1 16",
        4002,
        jpeg,
        shows=255,
        width=0,
        string="x",
    )
    config_fault("codec_case", "The codec is JPEG instead of jpeg.", "10.1", 4002, jpeg, codec=b"JPEG")
    for name, fields in (
        ("width_zero", {"width": 0}),
        ("height_zero", {"height": 0}),
        ("depth_7", {"bit_depth": 7}),
        ("depth_17", {"bit_depth": 17}),
        ("jpeg_depth_10", {"bit_depth": 10}),
        ("range_2", {"full_range": 2}),
    ):
        config_fault(name, f"VCFG has {fields}.", "10.1", 4003, jpeg, **fields)
    for name, fields in (
        ("oexr_depth", {"bit_depth": 10}),
        ("oexr_transfer", {"transfer_characteristics": 1}),
        ("oexr_matrix", {"matrix_coefficients": 1}),
        ("oexr_range", {"full_range": 0}),
    ):
        config_fault(name, f"VCFG of OpenEXR has {fields}.", "10.12", 4003, exr(), **fields)
    config_fault("jpeg_record", "VCFG of JPEG has a record.", "10.1 12", 4004, jpeg, record=b"\0")
    config_fault("jpeg_string", "VCFG of JPEG has a codec string.", "10.1 12", 4004, jpeg, string="jpeg")
    config_fault("oexr_record", "VCFG of OpenEXR has a record.", "10.1", 4004, exr(), record=b"\0")
    for name, clause, changes in (
        ("h264", "10.5", RECORDS_AVC),
        ("hevc", "10.7", RECORDS_HEVC),
        ("vp9", "10.8", RECORDS_VP9),
        ("av1", "10.9", RECORDS_AV1),
    ):
        setup = of(name)
        for case, (title, change) in changes.items():
            config_fault(
                f"{name}_record_{case}", title, clause, 4004, setup, record=change(setup.clip.record)
            )
        config_fault(
            f"{name}_string_missing", f"The codec string of {name} is empty.", clause, 4004, setup, string=""
        )
        string = setup.clip.string
        config_fault(
            f"{name}_string_other",
            "The codec string is of another profile.",
            clause,
            4004,
            setup,
            string=string[:5] + ("2" if string[5] != "2" else "3") + string[6:],
        )
        config_fault(
            f"{name}_depth", "VCFG has another bit depth than the record.", clause, 4004, setup, bit_depth=12
        )


def byte(at, value):
    return lambda record: record[:at] + bytes([value]) + record[at + 1 :]


RECORDS_AVC = {
    "empty": ("The record is empty.", lambda r: b""),
    "version": ("The record has version 2.", byte(0, 2)),
    "lengths": ("lengthSizeMinusOne is 1.", byte(4, 0xFD)),
    "no_sequence": ("The record has no sequence parameter set.", byte(5, 0xE0)),
    "cut": ("The record lacks its last byte.", lambda r: r[:-1]),
    "extra": ("A byte follows the record.", lambda r: r + b"\0"),
}
RECORDS_HEVC = {
    "version": ("The record has version 0.", byte(0, 0)),
    "space": ("general_profile_space is 1.", lambda r: r[:1] + bytes([r[1] | 0x40]) + r[2:]),
    "lengths": ("lengthSizeMinusOne is 0.", lambda r: r[:21] + bytes([r[21] & 0xFC]) + r[22:]),
    "arrays": ("The record counts two arrays.", byte(22, 2)),
    "incomplete": (
        "array_completeness of the first array is 0.",
        lambda r: r[:23] + bytes([r[23] & 0x7F]) + r[24:],
    ),
    "cut": ("The record lacks its last byte.", lambda r: r[:-1]),
    "extra": ("A byte follows the record.", lambda r: r + b"\0"),
}
RECORDS_VP9 = {
    "version": ("The record has version 0.", byte(0, 0)),
    "flags": ("The record has flags.", byte(3, 1)),
    "profile": ("The record has profile 2 with 8 bits.", byte(4, 2)),
    "chroma": ("The record has 4:4:4 in profile 0.", lambda r: r[:6] + bytes([r[6] & 0xF1 | 6]) + r[7:]),
    "data": ("codecInitializationDataSize is 1.", lambda r: r[:10] + b"\0\1" + b"\0"),
    "cut": ("The record has 11 bytes.", lambda r: r[:-1]),
}
RECORDS_AV1 = {
    "version": ("The record has version 2.", byte(0, 0x82)),
    "marker": ("The marker bit is 0.", lambda r: bytes([r[0] & 0x7F]) + r[1:]),
    "reserved": ("A reserved bit is 1.", lambda r: r[:3] + bytes([r[3] | 0x80]) + r[4:]),
    "no_header": ("The record has no sequence header.", lambda r: r[:4]),
    "profile": (
        "seq_profile differs from that of the sequence header.",
        lambda r: r[:1] + bytes([r[1] | 0x20]) + r[2:],
    ),
    "cut": ("The record lacks its last byte.", lambda r: r[:-1]),
    "twice": ("The record has two sequence headers.", lambda r: r + r[4:]),
}


def tile_fault(name, title, issue, *tiles, payload=None, clauses="10.2"):
    """The TILE of the first block is wrong; a good block follows."""
    setup = of("jpeg")

    def make():
        from ...writer import Stream

        s = Stream()
        s.chunk("SCEN", payloads.scene())
        s.chunk("TRAK", payloads.track(payloads.MESH, "mesh"), track=1)
        s.chunk("TRAK", payloads.track(VIDEO, "video"), track=TRACK)
        for i in range(2):
            s.chunk("CAMR", payloads.camera(i, width=32, height=32))
        s.chunk("VCFG", setup.config(), track=TRACK)
        layout = payloads.tiles(*[payloads.tile(*t) if isinstance(t, tuple) else t for t in tiles])
        s.chunk("TILE", layout if payload is None else payload, track=TRACK, fault=issue)
        end = setup.groups(s)
        setup.block(s)
        setup.groups(s, end)
        s.finish()
        return s

    faulty(f"tiles_{name}", title, clauses, make)


def tile_faults():
    whole_tile = (0, (0, 0, 32, 32), (0, 0, 32, 32))
    good = payloads.tiles(payloads.tile(*whole_tile))
    tile_fault("count_zero", "TILE has no entry.", 4101, payload=payloads.tiles())
    tile_fault(
        "count_more",
        "TILE counts an entry more than it has.",
        4101,
        payload=payloads.tiles(payloads.tile(*whole_tile), count=2),
    )
    tile_fault(
        "count_greatest",
        "TILE counts 2^32 - 1 entries.",
        4101,
        payload=payloads.tiles(payloads.tile(*whole_tile), count=2**32 - 1),
    )
    tile_fault("short", "TILE has 7 bytes.", 4101, payload=good[:7])
    tile_fault("long", "A byte follows the last entry of TILE.", 4101, payload=good + b"\0")
    tile_fault(
        "reserved",
        "The reserved field of TILE is 1.",
        4101,
        payload=payloads.tiles(payloads.tile(*whole_tile), reserved=1),
    )
    tile_fault(
        "entry_reserved",
        "The reserved field of an entry is 1.",
        4101,
        payload=payloads.tiles(payloads.tile(*whole_tile, reserved=1)),
    )
    tile_fault(
        "entry_flags",
        "An entry has a flag.",
        4101,
        payload=payloads.tiles(payloads.tile(*whole_tile, flags=0x8000)),
    )
    for name, source, destination in (
        ("source_empty", (0, 0, 0, 32), (0, 0, 32, 32)),
        ("source_right", (1, 0, 32, 32), (0, 0, 32, 32)),
        ("source_below", (0, 32, 32, 1), (0, 0, 32, 32)),
        ("source_overflow", (65535, 0, 65535, 32), (0, 0, 32, 32)),
        ("destination_empty", (0, 0, 32, 32), (0, 0, 32, 0)),
        ("destination_right", (0, 0, 32, 32), (48, 0, 17, 16)),
        ("destination_below", (0, 0, 32, 32), (0, 16, 32, 17)),
        ("destination_unaligned_x", (0, 0, 32, 32), (8, 0, 32, 32)),
        ("destination_unaligned_y", (0, 0, 32, 32), (0, 1, 32, 16)),
    ):
        tile_fault(
            name,
            f"A tile has the source {source} and the destination {destination}.",
            4102,
            (0, source, destination),
        )
    tile_fault(
        "overlap",
        "Two destinations overlap by one pixel.",
        4103,
        (0, (0, 0, 32, 32), (0, 0, 17, 16)),
        (1, (0, 0, 32, 32), (16, 0, 16, 16)),
    )
    tile_fault("same_place", "Two cameras have the same destination.", 4103, whole_tile, (1, *whole_tile[1:]))
    tile_fault(
        "camera_twice", "A camera has two tiles.", 4103, whole_tile, (0, (0, 0, 32, 32), (32, 0, 32, 32))
    )

    def in_group(name, title, issue, write, setup=None):
        setup = setup or of("jpeg")

        def make():
            s = opened_with(setup)
            s.begin(0, 4)
            write(s, setup)
            s.end()
            setup.groups(s, 4)
            s.finish()
            return s

        faulty(f"tiles_group_{name}", title, "10.11", make)

    def sample(s, setup, time):
        s.chunk("VPKT", setup.clip.samples[time % 3][1], TRACK, time, True)

    layout = of("jpeg").layout()

    def tile(s, time, payload=layout, issue=None):
        s.chunk("TILE", payload, TRACK, time, True, fault=issue)

    in_group(
        "twice",
        "A group has two TILE of a track, at different times.",
        4104,
        lambda s, v: (tile(s, 0), tile(s, 1, issue=4104), sample(s, v, 1)),
    )
    in_group(
        "after_sample",
        "TILE comes after the first sample.",
        4104,
        lambda s, v: (sample(s, v, 0), tile(s, 1, issue=4104), sample(s, v, 1)),
    )
    in_group(
        "other_time",
        "TILE has another time than the first sample after it.",
        4104,
        lambda s, v: (tile(s, 0), s.chunk("VPKT", v.clip.samples[1][1], TRACK, 1, True, fault=4104)),
    )
    other = payloads.tiles(payloads.tile(5, (0, 0, 32, 32), (0, 0, 32, 32)))
    in_group(
        "other_camera",
        "The layout of a group has a camera that the configuration does not show.",
        4105,
        lambda s, v: (tile(s, 0, other, 4105), sample(s, v, 0)),
        of("jpeg", cameras=2),
    )
    in_group(
        "of_atlas",
        "A group has a TILE of a track that shows an atlas.",
        4105,
        lambda s, v: (tile(s, 0, layout, 4105), sample(s, v, 0)),
        of("jpeg", shows=1),
    )
    in_group(
        "bad_layout",
        "The layout of a group is empty.",
        4101,
        lambda s, v: (tile(s, 0, payloads.tiles(), 4101), sample(s, v, 0)),
    )
    in_group(
        "bad_overlap",
        "Tiles of the layout of a group overlap.",
        4103,
        lambda s, v: (
            tile(
                s,
                0,
                payloads.tiles(
                    payloads.tile(0, (0, 0, 32, 32), (0, 0, 32, 32)),
                    payloads.tile(1, (0, 0, 32, 32), (16, 0, 32, 32)),
                ),
                4103,
            ),
            sample(s, v, 0),
        ),
    )


whole()
tiles_whole()
config_faults()
tile_faults()
