"""fvvdemux without an index: what a damaged chunk costs is what needs it, as with an index."""

import pytest
from conftest import figures, read_json, run

FRAMES, GROUP = 20, 10


def chunks_of(stream):
    """Offset, type, track and payload size of each chunk."""
    at = 24
    while at + 32 <= len(stream):
        size = int.from_bytes(stream[at + 16 : at + 24], "little")
        yield at, stream[at : at + 4].decode(), int.from_bytes(stream[at + 6 : at + 8], "little"), size
        at += 32 + (size + 7) // 8 * 8


@pytest.fixture(scope="module")
def ladder(tmp_path_factory):
    """A stream of two rungs without INDX and FOOT, and what fvvdemux writes of it."""
    root = tmp_path_factory.mktemp("damage")
    run(
        "fvvsynth", "--rig", "small", "--cameras", 2, "--size", "64x48", "--frames", FRAMES, "-o", root / "in"
    )
    run(
        "fvvmux",
        root / "in",
        "-o",
        root / "whole.fvv",
        "--ladder",
        "1,0.5",
        "--mesh-ladder",
        "on",
        "--group",
        GROUP,
    )
    stream = (root / "whole.fvv").read_bytes()
    end = next(at for at, kind, _, _ in chunks_of(stream) if kind == "INDX")
    (root / "cut.fvv").write_bytes(stream[:end])
    return root, stream[:end], unpacked(root / "cut.fvv", root / "good")[1]


def unpacked(stream, folder):
    """Frames that were written, and the files, without the list of them."""
    words = ["fvvdemux", stream, "-o", folder, "--pictures", "jpg", "--force", "--json"]
    done = read_json(run(*words, code=(0, 3), warns=True), "fvvdemux")
    files = {
        p.relative_to(folder): p.read_bytes() for p in folder.rglob("*") if p.is_file() and p.name[0] != "."
    }
    return done["frames"]["written"], files


def tracks_of_rungs(root):
    rungs = figures("fvvinfo", root / "whole.fvv")["files"][0]["rungs"]
    return [set(rung["tracks"]) for rung in rungs]


def test_a_damaged_chunk_of_another_rung_costs_nothing(ladder, tmp_path):
    root, stream, good = ladder
    best, other = tracks_of_rungs(root)
    # Before the first picture of a group the layout of the pictures might be lost: every chunk there, and of the others
    # some.
    tried, early, before, in_groups = 0, 0, False, False
    for at, kind, track, size in chunks_of(stream):
        before = kind == "GRUP" or (before and not (kind == "VPKT" and track in best))
        in_groups = in_groups or kind == "GRUP"
        if not in_groups or track not in other - best or not (before or at // 8 % 3 == 0):
            continue
        early += before
        damaged = bytearray(stream)
        damaged[at + 32 + size // 2] ^= 1
        (tmp_path / "d.fvv").write_bytes(damaged)
        frames, files = unpacked(tmp_path / "d.fvv", tmp_path / "d")
        assert (frames, files) == (FRAMES, good), (kind, track, at)
        tried += 1
    assert tried > 5 and early >= 2


def test_a_damaged_chunk_of_the_rung_costs_its_frames_and_no_more(ladder, tmp_path):
    """From the damaged picture or mesh to the end of its group at most; what is written is that of the whole stream."""
    root, stream, good = ladder
    best, _ = tracks_of_rungs(root)
    tried = 0
    for at, kind, track, size in list(chunks_of(stream))[::7]:
        if track not in best or kind not in ("MESH", "VPKT"):
            continue
        damaged = bytearray(stream)
        damaged[at + 32 + size // 2] ^= 1
        (tmp_path / "d.fvv").write_bytes(damaged)
        frames, files = unpacked(tmp_path / "d.fvv", tmp_path / "d")
        assert FRAMES - GROUP <= frames < FRAMES, (kind, track, at)
        assert all(good[name] == content for name, content in files.items() if name.suffix != ".json")
        tried += 1
    assert tried > 5
