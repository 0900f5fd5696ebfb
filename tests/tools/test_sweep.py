"""Every cut and every single flipped bit of a stream is found: all of them are tried, on files of a few kB."""

import json
import os
import pathlib
import random
import sys
import tempfile

from conftest import TINY, run, tool_path
from PIL import Image
from reference.container import Stream
from reference.mesh import raw_parts
from reference.tiny import TETRAHEDRON
from sweep import memory_folder, sweep

GROUPS, FRAMES = 2, 3  # frames a group
# Cases of each file that are run once more in a process of their own.
ALONE = int(os.environ.get("FVV_SWEEP_ALONE", 250))


def two_tracks():
    """Two groups, two mesh tracks, the configuration repeated before the second group."""
    stream = Stream()
    shake = random.Random(2)

    def configuration():
        stream.scene(step=0.002, origin=(-1.5, 2.25, 0.0))
        stream.track(1, 1, "left")
        stream.track(2, 1, "right")

    for group in range(GROUPS):
        configuration()
        start = group * FRAMES
        stream.begin_group(start, start + FRAMES)
        for time in range(start, start + FRAMES):
            for track in 1, 2:
                moved = [tuple(x + shake.randrange(-9, 9) for x in p) for p in TETRAHEDRON.positions]
                payload = raw_parts(TETRAHEDRON._replace(positions=moved))
                stream.chunk("MESH", payload, track=track, time=time, key=True)
        stream.end_group()
    stream.finish()
    return stream.data()


def write_capture(folder):
    """Two frames of one tetrahedron, seen by one camera."""
    folder.mkdir()
    for frame in range(2):
        corners = "".join(f"v {x} {y} {z + 5 * frame}\n" for x, y, z in TETRAHEDRON.positions)
        faces = "".join(f"f {a + 1} {b + 1} {c + 1}\n" for a, b, c in TETRAHEDRON.faces)
        (folder / f"{frame}.obj").write_text(corners + faces)
        Image.new("RGB", (32, 16), (40 + 90 * frame, 90, 60)).save(folder / f"{frame}.png")
    description = {
        "fvv_capture": 1,
        "frame_rate": 25,
        "frames": {"first": 0, "count": 2},
        "units": "millimetres",
        "meshes": {"pattern": "%d.obj"},
        "cameras": [
            {
                "id": 0,
                "width": 32,
                "height": 16,
                "intrinsics": {"fx": 30, "fy": 30, "cx": 16, "cy": 8},
                "rotation": [[1, 0, 0], [0, 1, 0], [0, 0, 1]],
                "translation": [0, 0, 1000],
                "pictures": "%d.png",
            }
        ],
    }
    (folder / "capture.json").write_text(json.dumps(description))


def muxed(folder):
    capture, out = folder / "capture", folder / "muxed.fvv"
    write_capture(capture)
    options = ["--codec", "jpeg", "--quality", "10", "--step", "1mm", "--keep-geometry"]
    run("fvvmux", capture, "-o", out, *options)
    return out.read_bytes()


def test_no_case_is_silently_wrong(capsys):
    files = {"tetrahedron": (TINY / "tetrahedron.fvv").read_bytes(), "two_tracks": two_tracks()}
    with tempfile.TemporaryDirectory(dir=memory_folder()) as folder:
        files["muxed"] = muxed(pathlib.Path(folder))
        result = sweep(tool_path("fvvinfo"), folder, files, ALONE)
    line = f"sweep.cases {result.cases} sweep.silent_wrong {result.silent_wrong}"
    with capsys.disabled():
        print(f"\n{line}")
    if os.environ.get("FVV_SWEEP_OUT"):
        pathlib.Path(os.environ["FVV_SWEEP_OUT"]).write_text(line + "\n")
    assert result.silent_wrong == 0
    assert result.unexpected == []
    assert result.cases == 9 * sum(len(content) for content in files.values())


def test_sweep_sees_what_a_tool_does_not_find(tmp_path):
    """A tool that calls everything complete is wrong in every case."""
    blind = tmp_path / "blind"
    blind.write_text(
        f"#!{sys.executable}\n"
        "import json, sys\n"
        "names = [a for a in sys.argv[1:] if not a.startswith('--')]\n"
        "print(json.dumps({'files': [{'name': n, 'integrity': 'complete'} for n in names]}))\n"
    )
    blind.chmod(0o755)
    result = sweep(blind, tmp_path, {"short": bytes(30)}, alone=3)
    assert (result.cases, result.silent_wrong) == (270, 270)
    assert result.unexpected
