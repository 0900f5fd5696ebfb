"""fvvinfo from outside: exit codes, standard output and error, and JSON by its schema."""

import re

import pytest
from conftest import read_json
from reference import tiny
from reference.container import Stream
from reference.mesh import raw_parts
from reference.tiny import TETRAHEDRON


@pytest.fixture
def tetrahedron(tiny_files):
    return tiny_files["tetrahedron.fvv"].read_bytes()


def put(folder, content, name="file.fvv"):
    path = folder / name
    path.write_bytes(content)
    return path


def flipped(content, offset, bit=0):
    out = bytearray(content)
    out[offset] ^= 1 << bit
    return bytes(out)


def files_of(done):
    return read_json(done, "fvvinfo")["files"]


def test_complete_files_are_silent_on_stderr(fvvinfo, tiny_files):
    for path in tiny_files.values():
        for options in [], ["--check"], ["--json"], ["--chunks"], ["--check", "--json", "--chunks"]:
            done = fvvinfo(*options, path)
            assert (done.returncode, done.stderr) == (0, b""), (path, options)
            assert done.stdout


def test_text(fvvinfo, tiny_files):
    path = tiny_files["tetrahedron.fvv"]
    lines = fvvinfo("--check", path).stdout.decode().splitlines()
    assert lines[0].startswith(f"{path}: 616 B")
    assert lines[1:] == [
        "  Duration    0.040 s, 1 frames at 25 Hz in 1 groups, ticks of 1/25 s",
        "  World       metres, +z is up, lattice step 1 mm from (0, 0, 0)",
        '  Mesh        track 1 "mesh": 4 vertices, 4 triangles; 1 chunk (1 key), 112 B, 112 B each: 1 raw of 112 B',
        "  Bytes       mesh 18.2 %, container 81.82 %; 616 B a frame",
        "  Index       present, 1 groups",
        "  Integrity   complete; CRCs, structure, meshes and video samples checked",
    ]


@pytest.mark.parametrize(
    "size, duration, end",
    [(256, "unknown (cut)", "0"), (376, "0.040 s", "1"), (446, "0.040 s", "1"), (516, "0.040 s", "1")],
)
def test_duration_of_a_cut_file_is_that_of_its_frames(fvvinfo, tetrahedron, tmp_path, size, duration, end):
    cut = put(tmp_path, tetrahedron[:size])
    line = fvvinfo(cut).stdout.decode().splitlines()[1]
    assert line.startswith(f"  Duration    {duration}, {int(end)} frames at 25 Hz in 1 groups")
    file = files_of(fvvinfo("--json", cut))[0]
    assert (file["start"], file["end"]) == ("0", end)


# Texture indices of the four corners, within one bit.
CORNERS = [(0, 0), (1, 0), (2, 2), (0, 1)]


def textured(bits_of_groups):
    """A stream of one group for each list of bits, one frame for each number."""
    stream, time = Stream(), 0
    stream.scene()
    stream.track(1, 1, "mesh")
    for frames in bits_of_groups:
        stream.begin_group(time, time + len(frames))
        for bits in frames:
            mesh = TETRAHEDRON._replace(texture=CORNERS if bits else (), texture_bits=bits)
            stream.chunk("MESH", raw_parts(mesh), track=1, time=time, key=True)
            time += 1
        stream.end_group()
    return stream.finish()


@pytest.mark.parametrize(
    "bits_of_groups, text, texture",
    [
        ([[0, 0]], "", None),
        ([[12, 12]], ", texture coordinates of 12 bits", {"chunks": 2, "bits": [12, 12]}),
        ([[1], [16]], ", texture coordinates of 1 to 16 bits", {"chunks": 2, "bits": [1, 16]}),
        ([[0], [9, 9]], ", texture coordinates of 9 bits in 2 chunks", {"chunks": 2, "bits": [9, 9]}),
    ],
)
def test_texture_coordinates(fvvinfo, tmp_path, bits_of_groups, text, texture):
    path = put(tmp_path, textured(bits_of_groups))
    done = fvvinfo("--check", path)
    assert (done.returncode, done.stderr) == (0, b"")
    assert f"4 vertices, 4 triangles{text}; " in done.stdout.decode()
    for options in [], ["--check"]:
        assert files_of(fvvinfo("--json", *options, path))[0]["tracks"][0]["mesh"].get("texture") == texture


def test_texture_coordinates_in_one_mesh_of_a_group(fvvinfo, tmp_path):
    path = put(tmp_path, textured([[12, 12, 0]]))
    done = fvvinfo(path.name, cwd=tmp_path)
    assert done.returncode == 1
    offset = 0xE8 + 2 * (32 + 112 + 32) + 32 + 2  # after two MESH chunks with 8 bytes more a vertex
    assert done.stderr.decode() == (
        f"file.fvv: {offset:#x}: MESH: 0 texture bits, the first mesh of the track in this group has 12 [FVV-3016]\n"
    )


def test_text_names_the_version_of_the_format(fvvinfo, tiny_files):
    first = fvvinfo(tiny_files["empty.fvv"]).stdout.decode().splitlines()[0]
    assert first.endswith(": 208 B, format 0.2")


def test_chunk_list(fvvinfo, tiny_files):
    lines = fvvinfo("--chunks", tiny_files["tetrahedron.fvv"]).stdout.decode().splitlines()
    rows = [line.split() for line in lines[-7:]]
    assert [(int(row[0]), row[1]) for row in rows] == [
        (section.offset, section.title[:4]) for section in tiny.tetrahedron().sections[1:]
    ]


def test_json_of_complete_files(fvvinfo, tiny_files):
    names = [str(tiny_files[name]) for name in ("empty.fvv", "tetrahedron.fvv")]
    empty, one = files_of(fvvinfo("--json", "--check", "--chunks", *names))
    assert [empty["name"], one["name"]] == names
    assert [empty["integrity"], one["integrity"]] == ["complete", "complete"]
    assert [empty["tracks"], empty["frames"], empty["problems"]] == [[], 0, []]
    assert one["decoded"] and one["index"]
    assert one["scene"]["time_base"] == [1, 25] and one["scene"]["lattice_step"] == 0.001
    assert one["whole"] == [{"first": 0, "count": 1, "first_time": "0", "last_time": "0"}]
    assert one["tracks"][0]["name"] == "mesh"
    assert one["tracks"][0]["mesh"]["vertices"] == [4, 4]
    assert [chunk["type"] for chunk in one["chunks"]] == "SCEN TRAK GRUP MESH GEND INDX FOOT".split()


def test_json_names_the_version_of_the_format(fvvinfo, tiny_files):
    assert files_of(fvvinfo("--json", tiny_files["empty.fvv"]))[0]["written_version"] == [0, 2]


def test_json_of_cut_and_damaged_files_fits_the_schema(fvvinfo, tetrahedron, tmp_path):
    contents = [tetrahedron[:size] for size in range(0, len(tetrahedron), 7)]
    contents += [flipped(tetrahedron, offset, offset % 8) for offset in range(0, len(tetrahedron), 5)]
    contents += [tetrahedron * 2, tetrahedron[24:], b"", b"no stream at all"]
    paths = [put(tmp_path, content, f"{i}.fvv") for i, content in enumerate(contents)]
    files = files_of(fvvinfo("--json", "--check", "--chunks", *paths))
    assert len(files) == len(paths)
    assert {file["integrity"] for file in files} == {"truncated", "damaged", "unreadable"}
    for file in files:
        # Only an end between two chunks outside a group breaks no rule: the stream may be live.
        assert file["problems"] or file["integrity"] == "truncated"


# size of what is left, exit code, the line after the name
CUTS = [
    (0, 1, "0x0: the stream is empty [FVV-1005]"),
    (23, 1, "0x17: the stream ends inside its file header [FVV-1005]"),
    (24, 3, "0x18: no footer: the stream is live or truncated"),
    (40, 3, "0x18: the stream ends inside a chunk header [FVV-1107]"),
    (100, 3, "0x18: SCEN: the stream ends inside a chunk: 76 of 88 bytes [FVV-1107]"),
    (112, 3, "0x70: no footer: the stream is live or truncated"),
    (173, 3, "0x70: TRAK: the stream ends inside a chunk: 61 of 64 bytes [FVV-1107]"),  # within padding
    (176, 3, "0xb0: no footer: the stream is live or truncated"),
    (216, 3, "0xb0: GRUP: the stream ends inside a chunk: 40 of 56 bytes [FVV-1107]"),
    (232, 3, "0xe8: the stream ends inside group 0 [FVV-1203]"),
    (316, 3, "0xe8: MESH: the stream ends inside a chunk: 84 of 144 bytes [FVV-1107]"),
    (376, 3, "0x178: the stream ends inside group 0 [FVV-1203]"),
    (446, 3, "0x178: GEND: the stream ends inside a chunk: 70 of 72 bytes [FVV-1107]"),
    (448, 3, "0x1c0: no footer: the stream is live or truncated"),
    (516, 3, "0x1c0: INDX: the stream ends inside a chunk: 68 of 112 bytes [FVV-1107]"),
    (560, 3, "0x230: no footer: the stream is live or truncated"),
    (615, 3, "0x230: FOOT: the stream ends inside a chunk: 55 of 56 bytes [FVV-1107]"),
]


@pytest.mark.parametrize("size, code, line", CUTS)
def test_cut(fvvinfo, tetrahedron, tmp_path, size, code, line):
    done = fvvinfo(put(tmp_path, tetrahedron[:size], "cut.fvv").name, cwd=tmp_path)
    assert done.stderr.decode().splitlines() == [f"cut.fvv: {line}"]
    assert done.returncode == code


@pytest.mark.parametrize(
    "offset, line",
    [
        (0, "0x0: not a fvv stream: the signature is missing [FVV-1001]"),
        (32, "0x18: no chunk header where one is expected [FVV-1101]"),
        (266, "0xe8: MESH: CRC of the payload does not match [FVV-1103]"),
    ],
)
def test_damage(fvvinfo, tetrahedron, tmp_path, offset, line):
    done = fvvinfo(put(tmp_path, flipped(tetrahedron, offset)).name, cwd=tmp_path)
    assert done.stderr.decode().splitlines()[0] == f"file.fvv: {line}"
    assert done.returncode == 1


def test_worst_exit_code_of_several_files(fvvinfo, tetrahedron, tmp_path):
    good = put(tmp_path, tetrahedron, "good.fvv")
    cut = put(tmp_path, tetrahedron[:316], "cut.fvv")
    bad = put(tmp_path, flipped(tetrahedron, 266), "bad.fvv")
    for paths, code in [
        ([good, good], 0),
        ([good, cut, good], 3),
        ([cut, bad], 1),
        ([bad, cut, good], 1),
        ([tmp_path / "missing.fvv", good], 1),
    ]:
        assert fvvinfo(*paths).returncode == code, paths
    # All are shown, also after one that is missing.
    done = fvvinfo(tmp_path / "missing.fvv", cut, good)
    assert f"{good}: 616 B" in done.stdout.decode() and f"{cut}: 316 B" in done.stdout.decode()
    assert len(done.stderr.splitlines()) == 2


def test_standard_input(fvvinfo, tetrahedron):
    done = fvvinfo("--check", "-", stdin=tetrahedron)
    assert (done.returncode, done.stderr) == (0, b"")
    assert done.stdout.startswith(b"standard input: 616 B")
    assert files_of(fvvinfo("--json", "-", stdin=tetrahedron))[0]["name"] == "standard input"
    done = fvvinfo("-", stdin=tetrahedron[:316])
    assert done.returncode == 3
    assert done.stderr.startswith(b"standard input: 0xe8: MESH: ")


def repeated_blocks():
    """Two groups of one frame, each after the same configuration block; and where the first block's track is."""
    stream = Stream()
    for time in 0, 1:
        stream.scene()
        stream.track(1, 1, "mesh")
        stream.begin_group(time, time + 1)
        stream.chunk("MESH", raw_parts(TETRAHEDRON), track=1, time=time, key=True)
        stream.end_group()
    return stream.finish(), stream.sections[2].offset


def test_a_later_repetition_of_a_lost_configuration_block_serves(fvvinfo, tmp_path):
    content, track = repeated_blocks()
    good = files_of(fvvinfo("--check", "--json", put(tmp_path, content)))[0]
    assert (good["integrity"], good["whole_frames"]) == ("complete", 2)
    damaged = put(tmp_path, flipped(content, track + 40))
    done = fvvinfo("--check", "--json", "--chunks", damaged)
    assert done.returncode == 1
    file = files_of(done)[0]
    assert [problem["issue"] for problem in file["problems"]] == ["FVV-1103"]
    assert (file["frames"], file["whole_frames"], file["bytes"]) == (2, 2, len(content))
    assert len(file["chunks"]) == file["chunk_count"] + 1
    # A pipe is kept until the first whole frame, which here comes after the group that needs the repetition.
    file = files_of(fvvinfo("--json", "-", stdin=damaged.read_bytes()))[0]
    assert (file["frames"], file["whole_frames"], file["bytes"]) == (2, 2, len(content))
    file = files_of(fvvinfo("--json", "-", stdin=content))[0]
    assert (file["integrity"], file["whole_frames"]) == ("complete", 2)


def test_input_that_is_not_a_stream(fvvinfo, tmp_path):
    text = put(tmp_path, b"# A page of text\n" * 9, "page.md")
    done = fvvinfo(text)
    assert done.returncode == 1
    assert done.stderr.decode() == f"{text}: 0x0: not a fvv stream: the signature is missing [FVV-1001]\n"
    for path, reason in [
        (tmp_path, "is a folder, expected a file"),
        (tmp_path / "missing.fvv", "No such file or directory"),
    ]:
        done = fvvinfo(path)
        assert (done.returncode, done.stdout) == (1, b"")
        assert re.fullmatch(f"fvvinfo: {path}: (cannot be opened: )?{reason}\n", done.stderr.decode())
        assert files_of(fvvinfo("--json", path)) == []


@pytest.mark.parametrize(
    "arguments", [[], ["--json"], ["--no-such-option", "x.fvv"], ["--check=perhaps", "x.fvv"]]
)
def test_usage_errors(fvvinfo, tmp_path, arguments):
    done = fvvinfo(*arguments, cwd=tmp_path)
    assert done.returncode == 2
    assert done.stdout == b"" and done.stderr
    assert list(tmp_path.iterdir()) == []


def test_help_and_version(fvvinfo):
    done = fvvinfo("--help")
    assert (done.returncode, done.stderr) == (0, b"")
    for word in "--json", "--check", "--chunks", "--version", "Exit code":
        assert word in done.stdout.decode()
    done = fvvinfo("--version")
    assert (done.returncode, done.stderr) == (0, b"")
    assert re.fullmatch(r"fvvinfo \d+\.\d+\.\d+\n", done.stdout.decode())


def test_control_characters_of_a_name_are_not_printed(fvvinfo, tmp_path):
    name = "red \x1b[31m bell \x07 line\nreturn\rdelete\x7f"
    path = put(tmp_path, tiny.tetrahedron(name).data())
    done = fvvinfo("--check", path)
    assert (done.returncode, done.stderr) == (0, b"")
    assert b'"red ?[31m bell ? line?return?delete?"' in done.stdout
    assert not set(done.stdout) & (set(range(32)) - {10} | {127})
    done = fvvinfo("--json", path)
    assert not set(done.stdout) & (set(range(32)) - {10})
    assert files_of(done)[0]["tracks"][0]["name"] == name
