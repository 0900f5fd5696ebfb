"""fvvrecover: what is whole in damaged and unfinished files is kept, and nothing else; the original is the oracle."""

import concurrent.futures
import json
import math
import os
import random
import re
import signal
import subprocess
import time

import pytest
from conftest import Tool, read_json, run, tool_path
from recover_oracle import groups_of, judge, offsets
from reference.container import Stream, crc32c
from reference.mesh import raw_parts
from reference.tiny import TETRAHEDRON
from vectors import name_of, names, path_of

# Damaged versions of each file; FVV_RECOVER_CASES multiplies them. Slow programs, of sanitizers, get a third of the files.
MANY = float(os.environ.get("FVV_RECOVER_CASES", 1))
FILES = [path_of(name) for name in names()][:: 1 if MANY >= 1 else 3]
CASES = {"cut": 4, "bit": 4, "burst": 2, "insert": 1, "delete": 2, "repeat": 1, "swap": 1}


@pytest.fixture(scope="module")
def fvvrecover():
    return Tool("fvvrecover")


@pytest.fixture(scope="module")
def fvvinfo():
    return Tool("fvvinfo")


def mesh_stream(groups=4, frames=3, repeat=True):
    """A raw mesh in every frame, the configuration before every group or once."""
    stream, shake = Stream(), random.Random(5)
    for group in range(groups):
        if repeat or not group:
            stream.scene()
            stream.track(1, 1, "mesh")
        start = group * frames
        stream.begin_group(start, start + frames)
        for at in range(start, start + frames):
            moved = [tuple(x + shake.randrange(-9, 9) for x in p) for p in TETRAHEDRON.positions]
            payload = raw_parts(TETRAHEDRON._replace(positions=moved))
            stream.chunk("MESH", payload, track=1, time=at, key=True)
        stream.end_group()
    return stream.finish()


def flipped(content, offset, bit=0):
    out = bytearray(content)
    out[offset] ^= 1 << bit
    return bytes(out)


def recovered(fvvrecover, folder, content, *options):
    """The report of fvvrecover on these bytes, and what it wrote (None: nothing)."""
    source, out = folder / "in.fvv", folder / "out.fvv"
    source.write_bytes(content)
    out.unlink(missing_ok=True)
    done = fvvrecover(source, "-o", out, "--json", *options)
    assert done.returncode in (0, 1, 3), done.stderr
    report = read_json(done, "fvvrecover")
    assert source.read_bytes() == content
    assert out.exists() == (done.returncode != 1)
    assert sorted(p.name for p in folder.iterdir()) == ["in.fvv", "out.fvv"][: 1 + out.exists()]
    if not out.exists():
        return report, None
    written = out.read_bytes()
    assert len(written) == report["bytes_written"]
    return report, written


@pytest.mark.parametrize("path", FILES, ids=name_of)
def test_a_whole_file_gives_the_same_bytes(fvvrecover, tmp_path, path):
    content = path.read_bytes()
    report, written = recovered(fvvrecover, tmp_path, content)
    assert written == content
    assert (report["state"], report["losses"], report["problem_count"]) == ("whole", [], 0)
    assert report["frames"]["lost"] == 0 and report["frames"]["exact"]
    assert report["frames"]["kept"] == sum(len(group.frames()) for group in groups_of(content))


def damages(content, shake):
    """Names and bytes of damaged versions."""
    size = len(content)
    for kind, count in CASES.items():
        for i in range(math.ceil(count * MANY)):
            at = shake.randrange(size)
            length = min(size - at, 1 << shake.randrange(1, 13))
            if kind == "cut":
                made = content[:at]
            elif kind == "bit":
                made = flipped(content, at, shake.randrange(8))
            elif kind == "burst":
                made = content[:at] + shake.randbytes(length) + content[at + length :]
            elif kind == "insert":
                made = content[:at] + shake.randbytes(length) + content[at:]
            elif kind == "delete":
                made = content[:at] + content[at + length :]
            elif kind == "repeat":
                made = content[: at + length] + content[at:]
            else:
                middle = (at + size) // 2
                made = content[:at] + content[middle : middle + length] + content[at + length : middle]
                made += content[at : at + length] + content[middle + length :]
            yield f"{kind}-{i}", made
    # Whole chunks that are missing, repeated or damaged in their header or payload.
    parts = list(offsets(content))
    for i in sorted(shake.sample(range(len(parts)), min(math.ceil(2 * MANY), len(parts)))):
        at, _, length = parts[i]
        yield f"no-chunk-{i}", content[:at] + content[at + length :]
        yield f"twice-chunk-{i}", content[: at + length] + content[at:]
        yield f"header-{i}", flipped(content, at + 9, 3)
        if length > 32:
            yield f"payload-{i}", flipped(content, at + 32)


def check_case(fvvrecover, fvvinfo, folder, content, name, made):
    """Nothing of what is kept is wrong, and everything is kept that fvvinfo calls whole."""
    folder = folder / name
    folder.mkdir()
    if made == content:
        return 0
    report, written = recovered(fvvrecover, folder, made)
    paths = sorted(folder.iterdir())
    files = json.loads(fvvinfo("--check", "--json", *paths).stdout)["files"]
    before = files[0]
    seen = before["whole_frames"]
    if written is None:
        assert report["frames"]["kept"] == 0 and seen == 0, name
        return 1
    assert (files[1]["integrity"], files[1]["problems"]) == ("complete", []), name
    times = judge(content, written)
    assert len(times) == report["frames"]["kept"], name
    # fvvinfo counts frames that are there twice.
    assert len(times) >= seen or name.startswith(("repeat", "twice", "swap")), name
    if written != content:
        assert report["state"] != "whole"
    for run_of in before["whole"]:
        assert int(run_of["first_time"]) in times and int(run_of["last_time"]) in times, name
    return 1


def sweep(fvvrecover, fvvinfo, folder, content, name):
    cases = damages(content, random.Random(name))
    with concurrent.futures.ThreadPoolExecutor(2) as pool:
        done = [
            pool.submit(check_case, fvvrecover, fvvinfo, folder, content, name, made) for name, made in cases
        ]
        return sum(future.result() for future in done)


@pytest.mark.parametrize("path", FILES, ids=name_of)
def test_damage(fvvrecover, fvvinfo, tmp_path, path):
    assert sweep(fvvrecover, fvvinfo, tmp_path, path.read_bytes(), name_of(path)) > 10 * MANY


@pytest.fixture(scope="module")
def capture(tmp_path_factory):
    folder = tmp_path_factory.mktemp("capture") / "players"
    size = ["--frames", 16, "--cameras", 2, "--size", "96x64"]
    run("fvvsynth", "-o", folder, "--rig", "small", *size, "--sound", "--environment", "--threads", 2)
    return folder


CODED = ["--group", 4, "--visibility", "weight", "--quality", "30dB", "--triangles", 400]


@pytest.fixture(scope="module")
def coded(capture, tmp_path_factory):
    """H.264 with crops of its own in each group, visibility, colours, sound and an environment; all meshes are keys."""
    path = tmp_path_factory.mktemp("coded") / "coded.fvv"
    run(
        "fvvmux", capture, "-o", path, "--repeat-configuration", "--no-delta", *CODED, code=(0, 3), warns=True
    )
    content = path.read_bytes()
    assert {kind for _, kind, _ in offsets(content)} >= {b"VISI", b"COLR", b"TILE", b"AUDI", b"BACK"}
    return content


def test_damage_of_a_coded_clip(fvvrecover, fvvinfo, tmp_path, coded):
    """Frames that are predicted from a lost one are lost, too: no decoder would notice."""
    assert sweep(fvvrecover, fvvinfo, tmp_path, coded, "coded") > 10 * MANY


def places(stream, kind):
    return [at for at, found, _ in offsets(stream) if found == kind]


@pytest.mark.parametrize(
    "kind, offset, frames, reduced",
    [
        (b"MESH", 40, 11, 1),  # a payload: one frame of 12
        (b"MESH", 9, 11, 1),  # a header: the table in GEND names the frame
        (b"GRUP", 9, 12, 0),  # proven by the chain in GEND
        (b"GRUP", 36, 12, 0),
        (b"GEND", 40, 12, 0),  # the counter shows that no chunk is missing before it
        (b"GEND", 9, 11, 1),  # the last frame may have had more chunks
        (b"SCEN", 40, 12, 0),  # a repetition serves
        (b"INDX", 40, 12, 0),
        (b"FOOT", 9, 12, 0),
    ],
)
def test_what_one_damaged_chunk_costs(fvvrecover, tmp_path, kind, offset, frames, reduced):
    content = mesh_stream()
    made = flipped(
        content, places(content, kind)[-1 if kind == b"SCEN" else len(places(content, kind)) // 2] + offset
    )
    report, written = recovered(fvvrecover, tmp_path, made)
    assert report["frames"] == {"kept": frames, "lost": 12 - frames, "exact": True}
    groups = report["groups"]
    assert (groups["copied"], groups["reduced"], groups["lost"]) == (4 - reduced, reduced, 0)
    assert len(judge(content, written)) == frames
    assert (written == content) == (frames == 12)


@pytest.mark.parametrize("offset", [0, 5, 9, 21])
def test_a_damaged_file_header_is_replaced(fvvrecover, tmp_path, offset):
    content = mesh_stream()
    report, written = recovered(fvvrecover, tmp_path, flipped(content, offset))
    assert report["state"] == "damaged" and written == content


def test_the_beginning_of_a_file_may_be_missing(fvvrecover, tmp_path):
    content = mesh_stream()
    begin = places(content, b"MESH")[4]
    report, written = recovered(fvvrecover, tmp_path, content[begin:])
    # The first whole group has the number 2; without its GRUP and a mesh, nothing proves what group 1 was.
    assert [group.start for group in groups_of(written)] == [6, 9]
    assert len(judge(content, written)) == 6
    assert report["groups"] == {"copied": 0, "renumbered": 2, "reduced": 0, "lost": 2}
    assert report["losses"][0]["groups_lost"] == 2


def test_groups_after_a_missing_one_are_renumbered(fvvrecover, tmp_path):
    content = mesh_stream()
    grup, gend = places(content, b"GRUP"), places(content, b"GEND")
    size = dict((at, length) for at, _, length in offsets(content))
    made = content[: grup[1]] + content[gend[1] + size[gend[1]] :]
    report, written = recovered(fvvrecover, tmp_path, made)
    assert report["groups"] == {"copied": 1, "renumbered": 2, "reduced": 0, "lost": 1}
    assert report["frames"] == {"kept": 9, "lost": 3, "exact": True}
    assert report["losses"][0]["sequence"] == 1
    old, new = groups_of(content), groups_of(written)
    assert new[0] == old[0]
    assert [group.chunks for group in new] == [old[i].chunks for i in (0, 2, 3)]


def test_the_only_configuration_block_is_needed(fvvrecover, tmp_path):
    content = mesh_stream(repeat=False)
    assert recovered(fvvrecover, tmp_path, flipped(content, 24 + 40))[1] is None
    done = fvvrecover(tmp_path / "in.fvv", "-o", tmp_path / "out.fvv")
    assert done.returncode == 1
    assert b"nothing can be kept" in done.stderr


def test_a_damaged_payload_gets_no_new_crc(fvvrecover, tmp_path):
    content = mesh_stream()
    for at in places(content, b"MESH"):
        made = flipped(content, at + 60)
        damaged = made[at + 32 : at + 32 + 112]
        _, written = recovered(fvvrecover, tmp_path, made)
        assert damaged not in written
        assert content[at + 32 : at + 32 + 112] not in written


def test_a_layout_moves_to_the_first_sample_that_is_left(fvvrecover, fvvinfo, tmp_path):
    content = (path_of("tiles_crops")).read_bytes()
    source = groups_of(content)
    group = next(i for i, g in enumerate(source) if g.layouts() and len(g.frames()) > 1)
    first = [at for at in places(content, b"VPKT") if at > places(content, b"GRUP")[group]][0]
    report, written = recovered(fvvrecover, tmp_path, flipped(content, first + 40))
    assert report["groups"]["reduced"] == 1
    assert len(judge(content, written)) == sum(len(g.frames()) for g in source) - 1
    assert groups_of(written)[group].layouts() == source[group].layouts()


def test_lost_sound_costs_no_frame(fvvrecover, tmp_path, coded):
    at = places(coded, b"AUDI")[1]
    report, written = recovered(fvvrecover, tmp_path, flipped(coded, at + 40))
    assert report["frames"] == {"kept": 16, "lost": 0, "exact": True}
    assert report["groups"]["reduced"] == 1
    assert len(judge(coded, written)) == 16


def test_frames_predicted_from_a_lost_one_are_lost(fvvrecover, tmp_path, coded):
    sizes = [len(group.frames()) for group in groups_of(coded)]
    assert sizes == [4, 4, 4, 4]
    samples = places(coded, b"VPKT")
    for lost, kept in (samples[4], 12), (samples[6], 14), (samples[7], 15):
        report, written = recovered(fvvrecover, tmp_path, flipped(coded, lost + 40))
        assert report["frames"] == {"kept": kept, "lost": 16 - kept, "exact": True}
        assert len(judge(coded, written)) == kept


def wait_for(what, seconds=30):
    end = time.monotonic() + seconds
    while not what():
        assert time.monotonic() < end
        time.sleep(0.002)


# Few threads and a slow quality search: there is time to kill it.
SLOW = [*CODED[:-1], 2000, "--threads", 1, "--repeat-configuration"]


@pytest.fixture(scope="module")
def slow(capture, tmp_path_factory):
    path = tmp_path_factory.mktemp("slow") / "slow.fvv"
    run("fvvmux", capture, "-o", path, *SLOW, code=(0, 3), warns=True)
    return path.read_bytes()


def test_a_killed_fvvmux_leaves_a_file_that_can_be_recovered(fvvrecover, fvvinfo, tmp_path, capture, slow):
    out = tmp_path / "killed.fvv"
    command = [str(tool_path("fvvmux")), str(capture), "-o", str(out), *map(str, SLOW)]
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    try:
        # The first group is on disk, the others are not.
        written = len(slow) / 4
        wait_for(lambda: sum(p.stat().st_size for p in tmp_path.glob(".killed.fvv.*")) > written)
    finally:
        process.send_signal(signal.SIGKILL)
        process.wait()
    assert not out.exists()
    (left,) = tmp_path.glob(".killed.fvv.*.partial")
    done = fvvrecover(left, "-o", out, "--json")
    assert done.returncode == 3, done.stderr
    report = read_json(done, "fvvrecover")
    assert report["state"] == "unfinished"
    assert fvvinfo("--check", out).returncode == 0
    times = judge(slow, out.read_bytes())
    assert 4 <= len(times) == report["frames"]["kept"] < 16


def test_a_live_stream_that_breaks_off_can_be_recovered(fvvrecover, fvvinfo, tmp_path, capture, slow):
    """fvvmux to a pipe, killed; what came through it is the file."""
    command = [str(tool_path("fvvmux")), str(capture), "-o", "-", "--live", *map(str, SLOW)]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL)
    received = b""
    while len(received) < len(slow) * 0.4:
        received += process.stdout.read(1000)
    process.send_signal(signal.SIGKILL)
    received += process.stdout.read(10)
    process.stdout.close()
    process.wait()
    report, written = recovered(fvvrecover, tmp_path, received)
    assert report["state"] == "unfinished"
    assert fvvinfo("--check", tmp_path / "out.fvv").returncode == 0
    assert 4 <= len(judge(slow, written)) < 16


def test_a_live_stream_that_is_whole_gets_an_index(fvvrecover, tmp_path):
    content = mesh_stream()
    report, written = recovered(fvvrecover, tmp_path, content[: places(content, b"INDX")[0]])
    assert report["state"] == "unfinished"
    assert report["groups"]["copied"] == 4
    assert written == content


def test_a_stream_for_a_newer_reader_is_refused(fvvrecover, tmp_path):
    content = bytearray(mesh_stream())
    content[10] = content[14] = 99
    content[20:24] = with_crc(content[:20])
    report, written = recovered(fvvrecover, tmp_path, bytes(content))
    assert written is None
    assert [problem["issue"] for problem in report["problems"]] == ["FVV-1004"]


def with_crc(content):
    return crc32c(content).to_bytes(4, "little")


def test_other_files_hold_nothing(fvvrecover, tmp_path):
    for content in b"", b"x", b"# A page of text\n" * 99, bytes(5000):
        assert recovered(fvvrecover, tmp_path, content)[1] is None


def test_dry_run_writes_nothing(fvvrecover, tmp_path):
    content = mesh_stream()
    source = tmp_path / "in.fvv"
    source.write_bytes(content[:-200])
    done = fvvrecover(source, "--dry-run", "--json")
    assert done.returncode == 3
    dry = read_json(done, "fvvrecover")
    assert list(tmp_path.iterdir()) == [source]
    report, written = recovered(fvvrecover, tmp_path, content[:-200])
    assert dry == report | {"output": None} and dry["bytes_written"] == len(written)


def test_the_input_is_never_replaced(fvvrecover, tmp_path):
    source, other = tmp_path / "in.fvv", tmp_path / "other.fvv"
    source.write_bytes(mesh_stream()[:-200])
    other.hardlink_to(source)
    before = source.read_bytes()
    for name in source, other:
        done = fvvrecover(source, "-o", name, "--force")
        assert done.returncode == 1 and b"this run reads" in done.stderr
    out = tmp_path / "out.fvv"
    out.write_bytes(b"old")
    assert fvvrecover(source, "-o", out).returncode == 1
    assert (source.read_bytes(), out.read_bytes()) == (before, b"old")
    assert fvvrecover(source, "-o", out, "--force").returncode == 3
    assert out.read_bytes() != b"old"


def test_text(fvvrecover, tmp_path):
    content = mesh_stream()
    at = places(content, b"MESH")[4]
    (tmp_path / "in.fvv").write_bytes(flipped(content, at + 40))
    done = fvvrecover("in.fvv", "-o", "out.fvv", cwd=tmp_path)
    assert done.returncode == 3
    assert done.stderr.decode() == (
        f"in.fvv: {at:#x}: MESH: group 1: 2 frames kept, 1 lost: CRC of the payload does not match [FVV-1103]\n"
    )
    assert done.stdout.decode().splitlines()[1:] == [
        "              kept      lost",
        "  groups         4         0",
        "  frames        11         1",
        "  1 group rebuilt from what is whole in them",
    ]


@pytest.mark.parametrize(
    "arguments",
    [[], ["in.fvv"], ["in.fvv", "-o", "x", "--dry-run"], ["in.fvv", "-o", "-", "--json"], ["--no-such"]],
)
def test_usage(fvvrecover, tmp_path, arguments):
    done = fvvrecover(*arguments, cwd=tmp_path)
    assert (done.returncode, done.stdout) == (2, b"")
    assert done.stderr and list(tmp_path.iterdir()) == []


def test_help_and_version(fvvrecover):
    done = fvvrecover("--help")
    assert (done.returncode, done.stderr) == (0, b"")
    for word in "--output", "--dry-run", "--json", "--force", "--version", "Exit code":
        assert word in done.stdout.decode()
    assert re.fullmatch(r"fvvrecover \d+\.\d+\.\d+\n", fvvrecover("--version").stdout.decode())
