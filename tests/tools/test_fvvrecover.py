"""fvvrecover: what is whole in damaged and unfinished files is kept, and nothing else; the original is the oracle."""

import concurrent.futures
import json
import os
import pathlib
import random
import re
import signal
import subprocess
import time

import pytest
from conftest import CONFORMANCE, Tool, read_json, run, tool_path
from recover_oracle import groups_of, judge, offsets
from reference.container import Part, Stream, structure
from reference.mesh import raw_parts
from reference.tiny import TETRAHEDRON

FILES = sorted(CONFORMANCE.glob("*/*.fvv"))
CASES = {"cut": 12, "bit": 16, "burst": 6, "insert": 4, "delete": 6, "repeat": 4, "swap": 4}


@pytest.fixture(scope="module")
def fvvrecover():
    return Tool("fvvrecover")


@pytest.fixture(scope="module")
def fvvinfo():
    return Tool("fvvinfo")


def mesh_stream(groups=4, frames=3, repeat=True, sound=False):
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


def whole_times(fvvinfo, path):
    """The times of the frames that fvvinfo calls whole, if they follow one another; and its report."""
    report = json.loads(fvvinfo("--check", "--json", path).stdout)["files"][0]
    return report


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
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
        for i in range(count):
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
    for i in sorted(shake.sample(range(len(parts)), min(8, len(parts)))):
        at, _, length = parts[i]
        yield f"no-chunk-{i}", content[:at] + content[at + length :]
        yield f"twice-chunk-{i}", content[: at + length] + content[at:]
        yield f"header-{i}", flipped(content, at + 9, 3)
        if length > 32:
            yield f"payload-{i}", flipped(content, at + 32)


def frames_in(report):
    return report["whole_frames"]


def check_case(fvvrecover, fvvinfo, folder, content, name, made):
    """Nothing of what is kept is wrong, and everything is kept that fvvinfo calls whole."""
    folder = folder / name
    folder.mkdir()
    if made == content:
        return 0
    report, written = recovered(fvvrecover, folder, made)
    before = json.loads(fvvinfo("--check", "--json", folder / "in.fvv").stdout)["files"]
    seen = before[0]["whole_frames"] if before else 0
    if written is None:
        assert report["frames"]["kept"] == 0 and seen == 0, name
        return 1
    done = fvvinfo("--check", folder / "out.fvv")
    assert (done.returncode, done.stderr) == (0, b""), name
    times = judge(content, written)
    assert len(times) == report["frames"]["kept"] >= seen, name
    if written != content:
        assert report["state"] != "whole"
    for run_of in before[0]["whole"]:
        assert int(run_of["first_time"]) in times and int(run_of["last_time"]) in times, name
    return 1


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_damage(fvvrecover, fvvinfo, tmp_path, path):
    content = path.read_bytes()
    cases = damages(content, random.Random(path.stem))
    with concurrent.futures.ThreadPoolExecutor(2) as pool:
        done = [
            pool.submit(check_case, fvvrecover, fvvinfo, tmp_path, content, name, made)
            for name, made in cases
        ]
        assert sum(future.result() for future in done) > 30
