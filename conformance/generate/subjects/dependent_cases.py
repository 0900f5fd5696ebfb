"""What depends on a chunk that is invalid is not intact up to the next key of its track: FVV-9009, for every kind of track."""

from .. import meshes, payloads
from ..case import faulty
from ..motion import Motion
from ..recipes import frame, group, opened
from ..weights import Weights
from . import calibration_cases, sound_cases, visibility_cases
from .mesh_whole import moved
from .video import video_cases

SAMPLES = {"h264": 4202, "hevc": 4203, "vp9": 4204, "av1": 4205}


def case(name, title, clauses, make):
    faulty(f"dependent_{name}", title, clauses, make)


def video(name, issue):
    """A key sample, one without a byte, a good one that builds on it; in the same group another key and one after it."""
    setup = video_cases.of(name)
    (_, key), (_, delta) = setup.clip.samples[:2]

    def make():
        s = video_cases.opened_with(setup)
        end = setup.groups(s)
        s.begin(end, end + 6)
        for i, sample in enumerate((key, b"", delta, key, delta)):
            frame(s, end + i)
            bad = {"fault": issue} if sample == b"" else {}
            s.chunk("VPKT", sample, video_cases.TRACK, end + i, sample == key, **bad)
        s.end()
        s.finish()
        return s

    case(
        f"sample_{name}",
        f"A sample of {name} follows an invalid one; then comes a key.",
        "7.3 10.3",
        make,
    )


def tiles():
    setup = video_cases.of("jpeg")
    s = video_cases.opened_with(setup)
    end = setup.groups(s)
    s.begin(end, end + 2)
    s.chunk("TILE", payloads.tiles(), video_cases.TRACK, end, True, fault=4101)
    for time in end, end + 1:
        frame(s, time)
        s.chunk("VPKT", setup.clip.samples[0][1], video_cases.TRACK, time, True)
    s.end()
    end = setup.groups(s, end + 2)
    s.finish()
    return s


def cameras():
    s = calibration_cases.begun(0, 0)
    before = {}
    group(s, 0)
    s.begin(2, 8)
    for i in range(5):
        frame(s, 2 + i)
        entries = [(0, calibration_cases.values(i)), (2, calibration_cases.values(i + 1))]
        before = {} if i == 3 else before
        good = payloads.calibration(i % 3, entries, before)
        bad = {"fault": 5101} if i == 1 else {}
        payload = good[:-1] if bad else good
        s.chunk("CALB", payload, calibration_cases.TRACK, 2 + i, i % 3 == 0, **bad)
    s.end()
    s.finish()
    return s


def seen():
    shape = visibility_cases.GRID
    s = visibility_cases.begun((0, 1))
    weights = None
    group(s, 0)
    s.begin(2, 8)
    for i in range(5):
        s.chunk("MESH", meshes.raw(shape), 1, 2 + i, True)
        weights = Weights(shape) if i % 3 == 0 else weights
        good = weights.chunk(visibility_cases.centres(0, 1), visibility_cases.patches)
        bad = {"fault": 6004} if i == 1 else {}
        payload = good[:-1] if bad else good
        s.chunk("VISI", payload, visibility_cases.TRACK, 2 + i, i % 3 == 0, **bad)
    s.end()
    s.finish()
    return s


def seen_of_invalid_mesh():
    """The visibility of a mesh that is invalid cannot be decoded."""
    shape = visibility_cases.GRID
    s = visibility_cases.begun((0, 1))
    weights = Weights(shape)
    group(s, 0)
    s.begin(2, 6)
    for i in range(3):
        bad = {"fault": 3004} if i == 1 else {}
        s.chunk("MESH", meshes.raw(shape) + (b"\0" if bad else b""), 1, 2 + i, True, **bad)
        payload = weights.chunk(visibility_cases.centres(0, 1), visibility_cases.patches)
        s.chunk("VISI", payload, visibility_cases.TRACK, 2 + i, i == 0)
    s.end()
    s.finish()
    return s


def mesh():
    shape = meshes.grid(8, 6)
    s = opened()
    motion = Motion(shape)
    group(s, 0)
    s.begin(2, 8)
    for i in range(5):
        if i % 3 == 0:
            motion = Motion(shape)
            s.chunk("MESH", meshes.raw(shape), 1, 2 + i, True)
            continue
        good = motion.frame(moved(shape.positions, i))
        bad = {"fault": 3021} if i == 1 else {}
        s.chunk("MESH", good + (b"\0" if bad else b""), 1, 2 + i, **bad)
    s.end()
    s.finish()
    return s


def sound():
    """Of sound only the first chunk of a group is a key: all after an invalid one is lost."""
    s = sound_cases.begun()
    for start in 0, 4, 8:
        s.begin(start, start + 4)
        for time in range(start, start + 4):
            frame(s, time)
            good = payloads.sound(1920 * time, [sound_cases.SILENCE] * 2)
            bad = {"fault": 4305} if time == 5 else {}
            sound_cases.audio(s, time, good[:-1] if bad else good, time == start, **bad)
        s.end()
    s.finish()
    return s


for codec, number in SAMPLES.items():
    video(codec, number)
case("tiles", "Samples follow an invalid layout of their group.", "7.3 10.11", tiles)
case("calibration", "A CALB follows an invalid one; then comes a key.", "7.3 9.4", cameras)
case("visibility", "A VISI follows an invalid one; then comes a key.", "7.3 17.1", seen)
case("visibility_of_mesh", "A VISI describes a mesh that is invalid.", "7.3 17.1", seen_of_invalid_mesh)
case("mesh", "A delta mesh follows an invalid one; then comes a key.", "7.3 8.7", mesh)
case("sound", "Sound follows an invalid chunk; the next group is good.", "7.3 20.2", sound)
