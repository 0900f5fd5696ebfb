"""Faults of configuration blocks: clause 5, and what VCFG, TILE, CAMR and ACFG need of each other."""

import math

from .. import payloads
from ..case import faulty
from ..packing import patched
from ..recipes import block, group, opened
from ..writer import FILE_HEADER, Stream

INF, NAN = math.inf, math.nan
SCENE = FILE_HEADER  # the offset of the first SCEN
MESH, VIDEO, AUDIO = payloads.MESH, payloads.VIDEO, payloads.AUDIO
SOUND_BASE = {"time_base_numerator": 1, "time_base_denominator": 48000}


def scene(name, title, clauses, payload, issue):
    """The only block of a stream is wrong: nothing can be decoded."""

    def make():
        s = Stream()
        s.chunk("SCEN", payload, fault=issue)
        s.chunk("TRAK", payloads.track(MESH, "mesh"), track=1)
        group(s, 0)
        s.finish()
        return s

    faulty(f"scene_{name}", title, clauses, make)


def later_scene(name, title, issue, **fields):
    """The second block is wrong: the group after it cannot be decoded, but the one before and the one after a third can."""

    def make():
        s = opened()
        group(s, 0)
        s.chunk("SCEN", payloads.scene(**fields), fault=issue)
        s.chunk("TRAK", payloads.track(MESH, "mesh"), track=1)
        group(s, 2)
        block(s)
        group(s, 4)
        s.finish()
        return s

    faulty(f"scene_{name}", title, "5.1", make)


def scenes():
    good = payloads.scene()
    scene("short", "The SCEN payload has 55 bytes.", "5.1", good[:-1], 2001)
    scene("long", "The SCEN payload has 64 bytes.", "5.1", good + bytes(8), 2001)
    scene("empty", "The SCEN payload is empty.", "5.1", b"", 2001)
    scene("reserved", "The last reserved byte of SCEN is 1.", "5.1", good[:-1] + b"\1", 2001)
    scene("flags", "A reserved flag bit of SCEN is set.", "5.1", payloads.scene(flags=2), 2001)
    for field in ("time_base_numerator", "time_base_denominator", "frame_duration"):
        scene(f"{field}_zero", f"{field} is 0.", "5.1", payloads.scene(**{field: 0}), 2002)
    scene("frame_duration_negative", "frame_duration is -1.", "5.1", payloads.scene(frame_duration=-1), 2002)
    for name, fields in (
        ("origin_nan", {"lattice_origin": (0.0, NAN, 0.0)}),
        ("origin_infinite", {"lattice_origin": (0.0, 0.0, -INF)}),
        ("step_zero", {"lattice_step": 0.0}),
        ("step_negative", {"lattice_step": -0.001}),
        ("step_nan", {"lattice_step": NAN}),
        ("step_infinite", {"lattice_step": INF}),
        ("corner_infinite", {"lattice_step": 1e301}),
        ("sum_infinite", {"lattice_origin": (1.7e308, 0.0, 0.0), "lattice_step": 1e300}),
    ):
        scene(
            f"lattice_{name}",
            f"The lattice is not finite or its step not positive: {fields}.",
            "5.1",
            payloads.scene(**fields),
            2003,
        )
    scene("up_7", "The up axis is 7.", "5.1", payloads.scene(up_axis=7), 2004)
    scene("up_255", "The up axis is 255.", "5.1", payloads.scene(up_axis=255), 2004)
    later_scene(
        "changes_time_base", "The second block has the time base 1/50.", 2002, time_base_denominator=50
    )
    later_scene(
        "changes_time_base_form",
        "The second block has the time base 2/50 instead of 1/25.",
        2002,
        time_base_numerator=2,
        time_base_denominator=50,
    )
    later_scene(
        "changes_step",
        "The lattice's step differs in the last bit.",
        2003,
        lattice_step=0.0010000000000000002,
    )
    later_scene(
        "changes_origin_sign",
        "The lattice's origin is -0 instead of 0.",
        2003,
        lattice_origin=(-0.0, 0.0, 0.0),
    )


def track(name, title, clauses, payload, issue, identifier=2):
    """After a good TRAK."""

    def make():
        s = Stream()
        s.chunk("SCEN", payloads.scene())
        s.chunk("TRAK", payloads.track(MESH, "mesh"), track=1)
        s.chunk("TRAK", payload, track=identifier, fault=issue)
        group(s, 0)
        s.finish()
        return s

    faulty(f"track_{name}", title, clauses, make)


def tracks():
    good = payloads.track(MESH, "name")
    track("short", "A TRAK payload has 23 bytes.", "5.2", good[:23], 2101)
    track("name_short", "A name lacks its last byte.", "5.2", good[:-1], 2101)
    track("name_long", "A byte follows the name.", "5.2", good + b"s", 2101)
    track(
        "reserved",
        "A reserved flag bit of TRAK is set.",
        "5.2",
        patched(good, "TRAK payload", "flags", 3),
        2101,
    )
    track(
        "frames_missing",
        "A mesh track does not have the flag of frames.",
        "5.2",
        patched(good, "TRAK payload", "flags", 0),
        2107,
    )
    track(
        "frames_of_colours",
        "A track of colours has the flag of frames.",
        "5.2",
        payloads.track(payloads.COLOURS, flags=1),
        2107,
    )
    track("twice", "Two TRAK have one identifier.", "5.2", good, 2102, identifier=1)
    track(
        "twice_other_kind",
        "A mesh track and a colour track have one identifier.",
        "5.2",
        payloads.track(payloads.COLOURS),
        2102,
        1,
    )
    track("kind_0", "The kind of a track is 0.", "5.2", payloads.track(0), 2103)
    track(
        "kind_0_named",
        "The kind of a track with a name and a time base is 0.",
        "5.2",
        payloads.track(0, "x", **SOUND_BASE),
        2103,
    )
    for name, text in (
        ("byte", b"\xff"),
        ("cut", "é".encode()[:1]),
        ("overlong", b"\xc0\xaf"),
        ("overlong_nul", b"\xc0\x80"),
        ("surrogate", b"\xed\xa0\x80"),
        ("beyond", b"\xf4\x90\x80\x80"),
        ("continuation", b"a\x80"),
        ("nul", b"a\0b"),
    ):
        track(
            f"text_{name}", f"A name has the bytes {text.hex(' ')}.", "2.2", payloads.track(MESH, text), 2104
        )
    for kind in (1, 2, 3, 4, 5, 8):
        track(
            f"time_base_kind_{kind}",
            f"A track of kind {kind} has a time base.",
            "5.2",
            payloads.track(kind, **SOUND_BASE),
            2105,
        )
    track(
        "time_base_half",
        "A time base has the denominator 0.",
        "5.2",
        payloads.track(AUDIO, time_base_numerator=1),
        2105,
    )
    track(
        "time_base_no_numerator",
        "A time base has the numerator 0.",
        "5.2",
        payloads.track(payloads.DATA, time_base_denominator=1),
        2105,
    )
    track(
        "rank_alone",
        "A track without alternatives has the rank 1.",
        "5.2",
        payloads.track(MESH, rank=1),
        2106,
    )

    def alternates(name, title, first, second):
        def make():
            s = Stream()
            s.chunk("SCEN", payloads.scene())
            s.chunk("TRAK", first, track=1)
            s.chunk("TRAK", second, track=2)
            s.issue, s.offset = 2106, SCENE
            group(s, 0)
            s.finish()
            return s

        faulty(f"track_{name}", title, "5.2", make)

    one = payloads.track(MESH, alternate_group=1)
    alternates(
        "same_rank", "Two alternatives have the same rank.", one, payloads.track(MESH, alternate_group=1)
    )
    alternates(
        "no_rank_0",
        "No alternative has the rank 0.",
        payloads.track(MESH, alternate_group=1, rank=1),
        payloads.track(MESH, alternate_group=1, rank=2),
    )
    alternates(
        "other_kind",
        "Alternatives are of different kinds.",
        one,
        payloads.track(payloads.COLOURS, alternate_group=1, rank=1),
    )


def in_block(name, title, clauses, write, issue_at=None, tracks=(), **more):
    """write(s) adds chunks to the first block, and says which is wrong. The same block without them comes later."""

    def make():
        s = opened(*([(1, payloads.track(MESH, "mesh")), *tracks]))
        write(s)
        group(s, 0)
        block(s)
        group(s, 2)
        s.finish()
        return s

    faulty(name, title, clauses, make, **more)


VIDEO_TRACK = [(2, payloads.track(VIDEO, "video"))]


def cameras(s, *identifiers):
    for identifier in identifiers:
        s.chunk("CAMR", payloads.camera(identifier))


def relations():
    layout = payloads.tiles(payloads.tile(0))

    def undeclared(code, payload):
        return lambda s: (cameras(s, 0), s.chunk(code, payload, track=3, fault=2201))

    in_block(
        "video_undeclared",
        "VCFG names a track that is not declared.",
        "5",
        undeclared("VCFG", payloads.video()),
    )
    in_block("tiles_undeclared", "TILE names a track that is not declared.", "5", undeclared("TILE", layout))
    in_block(
        "video_of_mesh_track",
        "VCFG names a mesh track.",
        "5",
        lambda s: s.chunk("VCFG", payloads.video(), track=1, fault=2201),
    )
    in_block(
        "tiles_of_mesh_track",
        "TILE names a mesh track.",
        "5",
        lambda s: (cameras(s, 0), s.chunk("TILE", layout, track=1, fault=2201)),
    )

    def twice(s):
        cameras(s, 0)
        s.chunk("VCFG", payloads.video(), track=2)
        s.chunk("TILE", layout, track=2)

    in_block(
        "video_twice",
        "A video track has two VCFG.",
        "5",
        lambda s: (twice(s), s.chunk("VCFG", payloads.video(), track=2, fault=2201)),
        tracks=VIDEO_TRACK,
    )
    in_block(
        "tiles_twice",
        "A video track has two TILE.",
        "5",
        lambda s: (twice(s), s.chunk("TILE", layout, track=2, fault=2201)),
        tracks=VIDEO_TRACK,
    )

    def ends_at_group(name, title, clauses, write, issue, tracks=()):
        """What a block lacks is known where it ends, and reported at its SCEN."""

        def make():
            s = opened(*([(1, payloads.track(MESH, "mesh")), *tracks]))
            write(s)
            s.issue, s.offset = issue, SCENE
            group(s, 0, 1)
            block(s)
            group(s, 1)
            s.finish()
            return s

        faulty(name, title, clauses, make)

    ends_at_group("video_missing", "A video track has no VCFG.", "10.1", lambda s: None, 2202, VIDEO_TRACK)
    ends_at_group(
        "tiles_missing",
        "A video track that shows tiles has no TILE.",
        "10.1",
        lambda s: s.chunk("VCFG", payloads.video(), track=2),
        2202,
        VIDEO_TRACK,
    )
    ends_at_group(
        "tiles_of_atlas",
        "A video track that shows an atlas has a TILE.",
        "10.1",
        lambda s: (
            cameras(s, 0),
            s.chunk("VCFG", payloads.video(shows=1), track=2),
            s.chunk("TILE", layout, track=2),
        ),
        2202,
        VIDEO_TRACK,
    )
    in_block(
        "camera_twice",
        "Two CAMR have one identifier.",
        "9.2",
        lambda s: (cameras(s, 0, 5), s.chunk("CAMR", payloads.camera(5), fault=2203)),
    )
    in_block(
        "tiles_unknown_camera",
        "TILE names a camera that does not exist.",
        "9.2",
        lambda s: (
            cameras(s, 0),
            s.chunk("VCFG", payloads.video(), track=2),
            s.chunk("TILE", payloads.tiles(payloads.tile(1)), track=2, fault=2203),
        ),
        tracks=VIDEO_TRACK,
    )
    motion = [(3, payloads.track(payloads.CALIBRATION, "motion"))]
    ends_at_group(
        "calibration_missing",
        "A camera moves, and there is no calibration track.",
        "9.4",
        lambda s: s.chunk("CAMR", payloads.camera(0, flags=1)),
        2204,
    )
    ends_at_group(
        "calibration_without_camera",
        "There is a calibration track, and no camera moves.",
        "9.4",
        lambda s: cameras(s, 0),
        2204,
        motion,
    )
    ends_at_group(
        "calibration_twice",
        "There are two calibration tracks.",
        "9.4",
        lambda s: s.chunk("CAMR", payloads.camera(0, flags=1)),
        2204,
        [*motion, (4, payloads.track(payloads.CALIBRATION, "again"))],
    )
    sound = [(3, payloads.track(AUDIO, "sound", **SOUND_BASE))]
    ends_at_group("audio_missing", "An audio track has no ACFG.", "20.1", lambda s: None, 2205, sound)
    captions = [(3, payloads.track(payloads.DATA, "captions"))]
    ends_at_group("data_missing", "A data track has no DCFG.", "21.1", lambda s: None, 2206, captions)
    in_block(
        "audio_undeclared",
        "ACFG names a track that is not declared.",
        "20.1",
        lambda s: s.chunk("ACFG", payloads.audio(), track=9, fault=2205),
    )
    in_block(
        "audio_of_mesh_track",
        "ACFG names a mesh track.",
        "20.1",
        lambda s: s.chunk("ACFG", payloads.audio(), track=1, fault=2205),
    )
    in_block(
        "audio_twice",
        "An audio track has two ACFG.",
        "20.1",
        lambda s: (
            s.chunk("ACFG", payloads.audio(), track=3),
            s.chunk("ACFG", payloads.audio(), track=3, fault=2205),
        ),
        tracks=sound,
    )
    for name, text in ("bytes", b'{"a": "\xff"}'), ("nul", b'{"a": "\0"}'):
        in_block(
            f"meta_{name}",
            f"META has the bytes {text.hex(' ')}.",
            "2.2 5.3",
            lambda s, text=text: s.chunk("META", text, fault=2104),
            needs_check=True,
        )
    in_block(
        "texturing_nul",
        "TEXR has 39 bytes.",
        "17.5",
        lambda s: s.chunk("TEXR", payloads.texturing()[:-1], fault=6101),
    )
    in_block(
        "texturing_reserved",
        "A reserved byte of TEXR is 1.",
        "17.5",
        lambda s: s.chunk("TEXR", payloads.texturing(reserved=(0, 0, 1)), fault=6101),
    )
    in_block(
        "texturing_twice",
        "A block has two TEXR.",
        "17.5",
        lambda s: (s.chunk("TEXR", payloads.texturing()), s.chunk("TEXR", payloads.texturing(), fault=6101)),
    )
    for name, fields in (
        ("threshold_negative", {"threshold": -0.01}),
        ("threshold_above", {"threshold": 1.0000001}),
        ("threshold_nan", {"threshold": NAN}),
        ("bias_negative", {"depth_bias": -1.0}),
        ("bias_infinite", {"depth_bias": INF}),
        ("slope_nan", {"depth_slope": NAN}),
        ("slope_negative", {"depth_slope": -1e-300}),
        ("inset_negative", {"inset": -0.001}),
        ("inset_infinite", {"inset": INF}),
        ("best_zero", {"best": 0}),
        ("blend_2", {"blend": 2}),
    ):
        in_block(
            f"texturing_{name}",
            f"TEXR has {fields}.",
            "17.5",
            lambda s, fields=fields: s.chunk("TEXR", payloads.texturing(**fields), fault=6102),
        )


def camera(name, title, clauses, issue, payload=None, **fields):
    in_block(
        f"camera_{name}",
        title,
        clauses,
        lambda s: s.chunk("CAMR", payloads.camera(7, **fields) if payload is None else payload, fault=issue),
    )


def camera_faults():
    good = payloads.camera(7, "camera")
    camera("short", "A CAMR payload has 223 bytes.", "9.2", 5001, good[:223])
    camera("name_short", "The name of a camera lacks a byte.", "9.2", 5001, good[:-1])
    camera("name_long", "A byte follows the name of a camera.", "9.2", 5001, good + b"!")
    camera("flags", "A reserved flag bit of CAMR is set.", "9.2", 5001, flags=2)
    one = (0.0, 0.0, 0.0, 0.0, 0.01, 0.0, 0.0, 0.0)
    camera("coefficient_none", "A pinhole camera has a coefficient.", "9.2", 5001, distortion=one)
    camera(
        "coefficient_fisheye",
        "A fisheye camera has a fifth coefficient.",
        "9.2",
        5001,
        lens=2,
        r_max=1.0,
        distortion=one,
    )
    camera("text", "The name of a camera is no UTF-8.", "2.2", 2104, payloads.camera(7, b"\xc3("))
    for lens in (3, 255):
        camera(f"lens_{lens}", f"The lens model is {lens}.", "9.1", 5002, lens=lens)
    camera("identifier_65535", "The identifier is 65535.", "9.2", 5006, payloads.camera(65535))
    camera(
        "identifier_65535_moving",
        "A camera that moves has the identifier 65535.",
        "9.2",
        5006,
        payloads.camera(65535, flags=1),
    )
    for name, fields in (
        ("width_zero", {"width": 0}),
        ("height_zero", {"height": 0}),
        ("fx_zero", {"fx": 0.0}),
        ("fy_negative", {"fy": -16.0}),
        ("fx_infinite", {"fx": INF}),
        ("cx_nan", {"cx": NAN}),
        ("cy_infinite", {"cy": -INF}),
        ("skew_nan", {"skew": NAN}),
        (
            "coefficient_nan",
            {"lens": 1, "r_max": 1.0, "distortion": (0.0, NAN, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)},
        ),
    ):
        camera(name, f"A camera has {fields}.", "9.2", 5003, **fields)
    for name, rotation in (
        ("scaled", (1.001, 0.0, 0.0, 0.0, -1.0, 0.0, 0.0, 0.0, -1.0)),
        ("sheared", (1.0, 0.001, 0.0, 0.0, -1.0, 0.0, 0.0, 0.0, -1.0)),
        ("mirrored", (1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, -1.0)),
        ("zero", (0.0,) * 9),
        ("nan", (NAN, 0.0, 0.0, 0.0, -1.0, 0.0, 0.0, 0.0, -1.0)),
    ):
        camera(
            f"rotation_{name}",
            f"R is {rotation}.",
            "9.2",
            5004,
            rotation=rotation,
            translation=(0.0, 0.0, 1.0),
        )
    camera("translation_infinite", "t is not finite.", "9.2", 5004, translation=(0.0, INF, 0.0))
    camera("r_max_zero", "r_max is 0.", "9.3", 5005, r_max=0.0)
    camera("r_max_negative", "r_max is -1.", "9.3", 5005, r_max=-1.0)
    camera("r_max_nan", "r_max is not a number.", "9.3", 5005, r_max=NAN)
    camera("r_max_infinite_radtan", "r_max is infinite with a lens model.", "9.3", 5005, lens=1)
    camera(
        "r_max_fisheye_half_pi",
        "r_max of a fisheye camera is pi / 2.",
        "9.3",
        5005,
        lens=2,
        r_max=math.pi / 2,
    )
    # r (1 - r^2) rises up to 1 / sqrt(3).
    fold = (-1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    camera(
        "r_max_fold_radtan",
        "r_max is beyond the fold of k1 = -1.",
        "9.3 12",
        5005,
        lens=1,
        r_max=0.5774,
        distortion=fold,
    )
    camera(
        "r_max_fold_fisheye",
        "r_max is beyond the fold of k1 = -1.",
        "9.3",
        5005,
        lens=2,
        r_max=0.5774,
        distortion=fold,
    )
    camera(
        "r_max_pole",
        "r_max is beyond the pole of k4 = -1.",
        "9.3",
        5005,
        lens=1,
        r_max=1.5,
        distortion=(0.0, 0.0, 0.0, 0.0, 0.0, -1.0, 0.0, 0.0),
    )


def limits():
    in_block(
        "limit_camera_width",
        "A camera has pictures of 2^32 - 1 pixels in a row.",
        "13",
        lambda s: s.chunk("CAMR", payloads.camera(0, width=2**32 - 1), fault=7001),
    )
    faulty(
        "limit_tracks",
        "A block has 257 tracks, more than the reference library's limit.",
        "13",
        many_tracks,
        refused=True,
    )


def many_tracks():
    s = Stream()
    s.chunk("SCEN", payloads.scene())
    for identifier in range(1, 258):
        s.chunk("TRAK", payloads.track(MESH), track=identifier, fault=7001 if identifier == 257 else None)
    group(s, 0)
    s.finish()
    return s


scenes()
tracks()
relations()
camera_faults()
limits()
