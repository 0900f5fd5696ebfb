"""fvvsynth --scene game: the files of the capture, sound without flashes, and the bytes of the practice."""

import hashlib
import json

import pytest
from conftest import run

SMALL = ["--frames", 2, "--rig", "small", "--cameras", 1, "--size", "64x36"]
GAME = ["--scene", "game", "--sound", "--environment", "--pictures", "jpeg", *SMALL]


def contents(folder):
    return {str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


@pytest.fixture(scope="module")
def game(tmp_path_factory):
    folder = tmp_path_factory.mktemp("game") / "capture"
    run("fvvsynth", "-o", folder, *GAME, "--threads", 1)
    return folder


def test_capture(game):
    capture = json.loads((game / "capture.json").read_text())
    assert capture["name"] == "game"
    assert [track["title"] for track in capture["audio"]] == ["shoes", "ball"]
    assert capture["cameras"][0]["pictures"] == "cam0/%04d.jpg"
    assert (game / "cam0" / "0001.jpg").read_bytes()[:3] == b"\xff\xd8\xff"
    assert not (game / "claps.wav").exists()


def test_ceiling_in_the_environment(game):
    glb = (game / "environment.glb").read_bytes()
    length = int.from_bytes(glb[12:16], "little")
    document = json.loads(glb[20 : 20 + length])
    # Floor, walls and ceiling; beams, purlins, and lamps in two colours.
    assert sum(len(mesh["primitives"]) for mesh in document["meshes"]) == 7


@pytest.mark.long
def test_threads_make_no_difference(game, tmp_path):
    run("fvvsynth", "-o", tmp_path / "again", *GAME, "--threads", 3)
    assert contents(tmp_path / "again") == contents(game)


def test_practice_keeps_its_bytes(tmp_path):
    """Benchmarks, charts and conformance cases were made from these."""
    run("fvvsynth", "-o", tmp_path / "practice", *SMALL)
    files = contents(tmp_path / "practice")
    names = ["cam0/0001.png", "cam0/mask_0001.png", "meshes/0001.ply"]
    digest = hashlib.sha256(b"".join(files[name] for name in names)).hexdigest()
    assert digest == "ca02711b6c8a51b66cf8bf6334d2ef5a7243882d9a2cada7cf6e503e10b87f2f"


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--meshes", "hull"], "--scene game: expected with --meshes tracked"),
        (["--atlas"], "--scene game: expected with --meshes tracked and without --atlas"),
        (["--footage"], "--scene excludes --footage"),
    ],
)
def test_what_a_game_is_not_for(tmp_path, options, message):
    done = run("fvvsynth", "-o", tmp_path / "none", "--scene", "game", *options, code=2)
    assert message in done.stderr
    assert not (tmp_path / "none").exists()
