"""--max-memory: a file that takes more to be decoded is refused before that, and named, whatever its kind (docs/encoding/memory.md)."""

import json
import re
import resource
import shutil
import struct
import subprocess
import wave
import zlib

import pytest
from conftest import run, tool_path

SIDE = 12000  # of a picture: 144 million pixels, 20 kB as PNG
ALLOWED = "64M"
MUX = ["fvvmux", ".", "-o", "o.fvv", "--force", "--threads", 1]
SHEET = ["fvvimport", "capture", ".", "--sheet", "o.png", "--force", "--threads", 1]
COMPARE = ["fvvcompare", ".", ".", "--samples", 1, "--threads", 1]
STREAM = ["fvvcompare", "s.fvv", "s.fvv", "--samples", 1, "--threads", 1]


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    folder = tmp_path_factory.mktemp("made")
    run("fvvsynth", "--rig", "small", "--cameras", 2, "--size", "64x48", "--frames", 2, "-o", folder / "cap")
    run("fvvmux", folder / "cap", "-o", folder / "cap/s.fvv")
    return folder / "cap"


@pytest.fixture
def cap(made, tmp_path):
    shutil.copytree(made, tmp_path / "cap")
    return tmp_path / "cap"


def change(cap, **values):
    capture = json.loads((cap / "capture.json").read_text())
    (cap / "capture.json").write_text(json.dumps(capture | values))


def png(side):
    """Black, of one bit."""

    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    head = struct.pack(">IIBBBBB", side, side, 1, 0, 0, 0, 0)
    packer = zlib.compressobj(9)
    row = bytes(1 + (side + 7) // 8)
    data = b"".join(packer.compress(row) for _ in range(side)) + packer.flush()
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", data) + chunk(b"IEND", b"")


def huge_picture(cap):
    (cap / "cam0/0001.png").write_bytes(png(SIDE))
    return "cam0/0001.png"


def huge_mask(cap):
    (cap / "cam1/mask_0000.png").write_bytes(png(SIDE))
    return "cam1/mask_0000.png"


def huge_sound(cap):
    """Little of it, but for a clip of an hour."""
    with wave.open(str(cap / "long.wav"), "wb") as file:
        file.setparams((8, 1, 8000, 0, "NONE", None))
        file.writeframes(bytes(8 * 100))
    change(cap, audio=[{"file": "long.wav"}], frame_rate="1/1800")
    return "long.wav"


def huge_mesh(cap):
    """No count can be forged: it is compared with the file. So the file is large."""
    name = json.loads((cap / "capture.json").read_text())["meshes"]
    name = (name if isinstance(name, str) else name["pattern"]).replace("%04d", "0001")
    path = cap / name
    path.write_bytes(path.read_bytes() + bytes(70 << 20))
    return name


def forged_ply(cap):
    head = "ply\nformat binary_little_endian 1.0\nelement vertex 4000000000\n"
    head += "".join(f"property double {axis}\n" for axis in "xyz")
    head += "element face 4\nproperty list uchar int vertex_indices\nend_header\n"
    (cap / "m.ply").write_text(head)
    change(cap, meshes="m.ply")
    return "m.ply"


def call(command, folder):
    words = [str(tool_path(command[0])), *map(str, command[1:])]
    return subprocess.run(words, cwd=folder, capture_output=True, text=True, timeout=120)


def refuses(command, cap, name, *more):
    """One line that names the file, what it takes and the option; nothing is left, and little memory was taken."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss
    done = call([*command, *more], cap)
    most = resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss
    # A frame that cannot be compared is a loss.
    assert done.returncode == (3 if command is COMPARE and more else 1), done.stderr
    lines = [line for line in done.stderr.splitlines() if "warning" not in line]
    assert name in done.stderr and len(lines) <= 2, done.stderr
    assert not list(cap.glob("o.*")) and not list(cap.glob("*.partial"))
    assert most < max(before, 600 << 10), "kilobytes of the largest process so far"
    return done.stderr


@pytest.mark.parametrize("command", [MUX, SHEET], ids=["fvvmux", "fvvimport"])
@pytest.mark.parametrize("bomb", [huge_picture, huge_mask], ids=lambda bomb: bomb.__name__)
def test_pictures(bomb, command, cap):
    name = bomb(cap)
    frame = ["--frames", int(re.search(r"(\d+)\.png", name)[1])] if command is SHEET else []
    said = refuses(command, cap, name, "--max-memory", ALLOWED, *frame)
    assert f"{SIDE} x {SIDE} pixels takes up to 1648 MiB, --max-memory allows 64 MiB" in said


@pytest.mark.parametrize("command", [MUX, SHEET, COMPARE], ids=["fvvmux", "fvvimport", "fvvcompare"])
def test_meshes(command, cap):
    name = huge_mesh(cap)
    frame = ["--frames", 1] if command is SHEET else []
    said = refuses(command, cap, name, "--max-memory", ALLOWED, *frame)
    assert "reading a mesh file of" in said and "--max-memory allows 64 MiB" in said


def test_forged_counts(cap):
    name = forged_ply(cap)
    refuses(COMPARE, cap, name)


def test_sound(cap):
    name = huge_sound(cap)
    said = refuses(MUX, cap, name, "--max-memory", ALLOWED)
    assert "of sound in 8 channels takes up to" in said and "--max-memory allows 64 MiB" in said


def test_streams(cap):
    done = call([*STREAM, "--max-memory", "1K"], cap)
    assert done.returncode == 1 and "s.fvv: frame 0: " in done.stderr, done.stderr
    assert "--max-memory allows 1024 bytes" in done.stderr


def test_videos(cap):
    run(
        "fvvrender",
        cap / "s.fvv",
        "--camera",
        0,
        "--size",
        "1280x720",
        "--frames",
        "0-1",
        "-o",
        cap / "f.mp4",
    )
    capture = json.loads((cap / "capture.json").read_text())
    for camera in capture["cameras"]:
        camera.pop("masks", None)
    capture["cameras"][0]["pictures"] = {"video": "f.mp4"}
    (cap / "capture.json").write_text(json.dumps(capture))
    said = refuses(MUX, cap, "f.mp4", "--max-memory", "20M")
    assert (
        "decoding a video of 1280 x 720 pixels takes up to" in said and "--max-memory allows 20 MiB" in said
    )


def test_an_embedded_picture(cap):
    """In the atlas of a mesh file."""
    (cap / "a.png").write_bytes(png(SIDE))
    corners = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nvt 0 0\nvt 1 0\nvt 0 1\n"
    faces = "f 1/1 3/3 2/2\nf 1/1 2/2 4/3\nf 2/1 3/2 4/3\nf 3/1 1/2 4/3\n"
    (cap / "t.obj").write_text(f"mtllib t.mtl\nusemtl m\n{corners}{faces}")
    (cap / "t.mtl").write_text("newmtl m\nmap_Kd a.png\n")
    words = ["fvvmux", "--meshes", "t.obj", "--fps", 25, "-o", "o.fvv"]
    said = refuses(words, cap, "a.png", "--max-memory", ALLOWED)
    assert "--max-memory allows 64 MiB" in said


@pytest.mark.parametrize(
    "command", [MUX, SHEET, COMPARE, STREAM], ids=["fvvmux", "fvvimport", "fvvcompare", "of a stream"]
)
@pytest.mark.parametrize("limit", [[], ["--max-memory", ALLOWED], ["--max-memory", "67108864"]])
def test_usual_files_pass(limit, command, cap):
    done = call([*command, *limit], cap)
    assert done.returncode in (0, 3), done.stderr


def test_a_plan_keeps_it(cap):
    assert call(["fvvmux", ".", "--group", 1, "--plan", "P", "--max-memory", ALLOWED], cap).returncode == 0
    huge_picture(cap)
    done = call(["fvvmux", "--part", 1, "P"], cap)
    assert done.returncode == 1 and "--max-memory allows 64 MiB" in done.stderr, done.stderr


@pytest.mark.parametrize("value", ["", "-1", "x", "5x", "M", "1.5G", "99999999999G"])
@pytest.mark.parametrize("command", [MUX, SHEET, COMPARE], ids=["fvvmux", "fvvimport", "fvvcompare"])
def test_values_that_are_none(command, value, cap):
    done = call([*command, "--max-memory", value], cap)
    assert done.returncode == 2 and "max-memory" in done.stderr, done.stderr
