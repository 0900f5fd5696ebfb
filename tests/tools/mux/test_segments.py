"""fvvmux --segments: a folder whose files are together the stream, and a manifest that lists them."""

import json

import pytest
from conftest import figures, read_json, run, validate
from reference import tiny
from reference.container import DATA, Part, Stream, crc32c, joined
from reference.mesh import raw_parts
from reference.tiny import TETRAHEDRON


def make(groups=3, blocks=(0,), name=lambda group: "mesh"):
    """A stream with a configuration block before each group in blocks; index and footer are left out."""
    stream = Stream()
    for group in range(groups):
        if group in blocks:
            stream.scene()
            stream.track(1, 1, name(group))
        stream.begin_group(2 * group, 2 * group + 2)
        for time in 2 * group, 2 * group + 1:
            mesh = raw_parts(TETRAHEDRON)
            stream.chunk("MESH", mesh, track=1, time=time, key=True)
        stream.end_group()
    return stream


def put(folder, content, name="clip.fvv"):
    path = folder / name
    path.write_bytes(content)
    return path


def read(folder):
    """Checks each file against its entry and returns the manifest and the bytes of the stream."""
    manifest = json.loads((folder / "manifest.json").read_text())
    validate(manifest, "segments")
    entries, content = [manifest["configuration"], *manifest["groups"]], b""
    environments = manifest.get("environments", [])
    for entry in entries + environments:
        data = (folder / entry["file"]).read_bytes()
        assert entry["bytes"] == len(data) and entry["crc32c"] == f"{crc32c(data):08x}"
        content += data if entry not in environments else b""
    entries += environments
    names = [entry["file"] for entry in entries]
    assert {p.name for p in folder.iterdir()} == {".fvv-output", "manifest.json", *names}
    return manifest, content


def test_a_file_is_cut_up_as_it_is(fvvmux, fvvinfo, tmp_path):
    stream = make()
    live = stream.data()
    path = put(tmp_path, stream.finish())
    done = fvvmux(path, "--segments", tmp_path / "out", "--json")
    assert (done.returncode, done.stderr) == (0, b"")
    reported = {"folder": str(tmp_path / "out"), "groups": 3, "bytes": len(live)}
    assert read_json(done, "fvvmux") == {"fvvmux": 1, "segments": reported}
    manifest, content = read(tmp_path / "out")
    assert content == live, "the stream without index and footer"
    assert manifest["format"] == f"{DATA['format']['major']}.{DATA['format']['minor']}"
    assert manifest["time_base"] == [1, 25] and manifest["frame_duration"] == "1"
    spans = [(g["sequence"], g["start"], g["end"], g["frames"]) for g in manifest["groups"]]
    assert spans == [(0, "0", "2", 2), (1, "2", "4", 2), (2, "4", "6", 2)]
    for group in manifest["groups"]:
        assert (tmp_path / "out" / group["file"]).read_bytes().startswith(b"GRUP")
    whole = fvvinfo("--check", put(tmp_path, content, "whole.fvv"))
    assert whole.returncode == 3 and len(whole.stderr.splitlines()) == 1, "no footer, and nothing else"


def test_streams_without_footer_and_with_repeated_configuration(fvvmux, tmp_path):
    plain = make().data()
    done = fvvmux(put(tmp_path, make(blocks=(0, 1, 2)).data()), "--segments", tmp_path / "out")
    assert (done.returncode, done.stderr) == (0, b"")
    assert read(tmp_path / "out")[1] == plain, "one block is enough for all groups"


def test_environments_are_files_of_their_own_too(fvvmux, tmp_path):
    stream = Stream()
    stream.scene()
    stream.track(1, 1, "mesh")
    for track in 5, 7:
        stream.track(track, 5, "floor")
    mesh = raw_parts(TETRAHEDRON)
    payloads = {5: b"not looked into", 7: b"8 bytes!"}
    for group, tracks in enumerate([[], [5], [5, 7]]):
        stream.begin_group(group, group + 1)
        stream.chunk("MESH", mesh, track=1, time=group, key=True)
        for track in tracks:
            stream.chunk("BACK", [Part(payloads[track], "", "")], track=track, time=group, key=True)
        stream.end_group()
    done = fvvmux(put(tmp_path, stream.finish()), "--segments", tmp_path / "out")
    assert (done.returncode, done.stderr) == (0, b"")
    manifest, content = read(tmp_path / "out")
    assert content == stream.data()[: len(content)]
    found = {
        entry["track"]: (tmp_path / "out" / entry["file"]).read_bytes() for entry in manifest["environments"]
    }
    assert sorted(found) == [5, 7]
    for track, data in found.items():
        assert data in content and data[:4] == b"BACK" and len(data) % 8 == 0
        assert data[32 : 32 + len(payloads[track])] == payloads[track]


def test_refusals(fvvmux, tmp_path):
    good = make().data()
    damaged = bytearray(good)
    damaged[300] ^= 1
    out = tmp_path / "out"
    empty = tiny.empty().data()
    changing = make(blocks=(0, 2), name=lambda group: f"mesh {group}").data()
    for content, problem in [
        (bytes(damaged), "MESH: CRC of the payload does not match [FVV-1103]"),
        (good[:-8], "the stream ends inside a chunk"),
        (good[: good.rindex(b"GEND")], "the stream ends inside group 2 [FVV-1203]"),
        (empty, "there are no groups to make segments of"),
        (changing, "the configuration changes "),
        (b"no stream", "[FVV-1005]"),
    ]:
        done = fvvmux(put(tmp_path, content), "--segments", out)
        assert done.returncode == 1 and problem in done.stderr.decode()
        assert len(done.stderr.splitlines()) == 1 and done.stdout == b""
        assert [p.name for p in tmp_path.iterdir()] == ["clip.fvv"], "no file is left over"
    path = put(tmp_path, good)
    out.mkdir()
    put(out, b"mine", "mine.txt")
    done = fvvmux(path, "--segments", out)
    assert done.returncode == 1 and b"already exists; --force replaces it" in done.stderr
    done = fvvmux(path, "--segments", out, "--force")
    assert done.returncode == 1 and b"--force replaces only what this tool wrote" in done.stderr
    assert [p.name for p in out.iterdir()] == ["mine.txt"]
    (out / "mine.txt").unlink()
    assert fvvmux(path, "--segments", out).returncode == 0
    assert fvvmux(path, "--segments", out, "--force").returncode == 0
    assert read(out)[1] == good
    assert fvvmux(path, "--segments", out, "-o", tmp_path / "again.fvv").returncode == 2
    assert fvvmux("capture.json", "--segments", out).returncode == 2, "a capture needs -o too"
    assert fvvmux("capture.json", "--segments", tmp_path / "o", "-o", "-").returncode == 2


def test_of_a_capture(fvvmux, tmp_path):
    (tmp_path / "meshes").mkdir()
    for frame in range(3):
        corners = "".join(
            f"v {x / 1000} {y / 1000} {(z + frame) / 1000}\n" for x, y, z in TETRAHEDRON.positions
        )
        faces = "".join(f"f {a + 1} {b + 1} {c + 1}\n" for a, b, c in TETRAHEDRON.faces)
        (tmp_path / "meshes" / f"{frame:04}.obj").write_text(corners + faces)
    capture = {
        "fvv_capture": 1,
        "name": "three",
        "frame_rate": 25,
        "frames": {"first": 0, "count": 3},
        "units": "metres",
        "meshes": {"pattern": "meshes/%04d.obj"},
    }
    (tmp_path / "capture.json").write_text(json.dumps(capture))
    out, segments = tmp_path / "three.fvv", tmp_path / "segments"
    options = ["--step", "1mm", "--group", "2"]
    done = fvvmux(tmp_path / "capture.json", "-o", out, "--segments", segments, *options)
    assert done.returncode == 0, done.stderr
    assert done.stdout.decode().splitlines()[-1].endswith(" bytes in 2 groups and a configuration")
    manifest, content = read(segments)
    assert out.read_bytes().startswith(content) and len(manifest["groups"]) == 2


def ladder(groups=3, ranks=(0, 1, 3), tracks=None):
    """A stream with a mesh at several ranks, and an environment for all; with tracks, what is left of those, as a stream."""
    stream = Stream()
    stream.scene()

    def has(track):
        return tracks is None or track in tracks

    for place, rank in enumerate(ranks):
        if has(place + 1):
            values = {"bit_rate": 1000 - rank, "nominal_size": 4}
            # What is alone has no alternatives (clause 5.2).
            if tracks is None:
                values |= {"alternate_group": 7, "rank": rank}
            stream.track(place + 1, 1, f"mesh {rank}", **values)
    stream.track(9, 5, "floor")
    mesh = raw_parts(TETRAHEDRON)
    for group in range(groups):
        stream.begin_group(2 * group, 2 * group + 2)
        for time in 2 * group, 2 * group + 1:
            for track in range(len(ranks), 0, -1):
                if has(track):
                    stream.chunk("MESH", mesh, track=track, time=time, key=True)
        if group == 1:
            stream.chunk("BACK", [Part(b"floor", "", "")], track=9, time=time, key=True)
        stream.end_group()
    return stream


def test_each_rung_has_a_folder(fvvmux, fvvinfo, tmp_path):
    path = put(tmp_path, ladder().finish())
    done = fvvmux(path, "--segments", tmp_path / "out", "--json")
    assert (done.returncode, done.stderr) == (0, b"")
    manifest = json.loads((tmp_path / "out/manifest.json").read_text())
    validate(manifest, "segments")
    assert [rung["tracks"] for rung in manifest["rungs"]] == [[1, 9], [2, 9], [3, 9]]
    assert [rung["bit_rate"] for rung in manifest["rungs"]] == [1000, 999, 997]
    written = 0
    for number, rung in enumerate(manifest["rungs"]):
        content = b""
        for entry in [rung["configuration"], *rung["groups"]]:
            data = (tmp_path / "out" / entry["file"]).read_bytes()
            assert entry["file"].startswith(f"rung-{number}/")
            assert entry["bytes"] == len(data) and entry["crc32c"] == f"{crc32c(data):08x}"
            content += data
        assert content == ladder(tracks=[number + 1]).data(), "what a writer of this rung alone writes"
        written += len(content)
        checked = fvvinfo("--check", put(tmp_path, content, f"rung-{number}.fvv"))
        assert "FVV-" not in checked.stderr.decode().replace("FVV-8", "")
    assert read_json(done, "fvvmux")["segments"] == {
        "folder": str(tmp_path / "out"),
        "groups": 3,
        "bytes": written,
        "rungs": 3,
    }
    best = manifest["rungs"][0]
    assert manifest["configuration"] == best["configuration"]
    for group, entry in zip(manifest["groups"], best["groups"]):
        assert entry.items() <= group.items() and group["frames"] == 2
    assert [entry["file"] for entry in manifest["environments"]] == ["environment-9.fvv"]


def test_fvvinfo_lists_rungs(fvvinfo, tmp_path):
    document = read_json(fvvinfo("--json", put(tmp_path, ladder().finish())), "fvvinfo")["files"][0]
    mesh = len(joined(raw_parts(TETRAHEDRON)))
    assert [rung["tracks"] for rung in document["rungs"]] == [[1, 9], [2, 9], [3, 9]]
    assert [rung["bytes"] for rung in document["rungs"]] == [6 * mesh + 5] * 3
    assert [rung["triangles"] for rung in document["rungs"]] == [4] * 3
    assert document["rungs"][0]["measured_rate"] == pytest.approx(8 * (6 * mesh + 5) / (6 / 25))
    assert document["tracks"][2]["alternate"] == {"group": 7, "rank": 3, "bit_rate": 997, "size": 4}
    assert "alternate" not in document["tracks"][3]
    lines = fvvinfo(put(tmp_path, ladder().finish())).stdout.decode().splitlines()
    assert sum("rung " in line and "meshes of 4 triangles" in line for line in lines) == 3
    assert "rungs" not in read_json(fvvinfo("--json", put(tmp_path, make().finish())), "fvvinfo")["files"][0]


def test_numbers_of_rungs(tmp_path):
    path = put(tmp_path, ladder().finish())
    for number in "-1", "65536", "1.5", "x", "":
        run("fvvdemux", path, "-o", tmp_path / "out", "--rung", number, code=2)
        run("fvvrender", path, "-o", tmp_path / "out.png", "--pose", "1,1,1,0,0,0", "--rung", number, code=2)
    done = figures("fvvdemux", path, "-o", tmp_path / "out", "--rung", "65535", "--no-environment")
    assert done["meshes"] == 6 and not done["warnings"], "any other number names a rung"
