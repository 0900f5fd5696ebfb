"""Outputs of the package: nothing that was there is lost, whatever fails, and names may be as long as the file system takes."""

import errno
import os

import fvv
import pytest
from fvv import outputs
from fvv.outputs import FileOutput, FolderOutput


def folder_of(path, content):
    output = FolderOutput(str(path), "tool", force=True)
    output.write_file("a/part.bin", content)
    return output


@pytest.fixture
def whole(tmp_path):
    """A folder that a run of the tool wrote."""
    folder_of(tmp_path / "out", b"first").commit()
    return tmp_path / "out"


def failing(monkeypatch, *calls):
    """These calls of os.rename fail, counted from 0."""
    count, rename = iter(range(100)), os.rename

    def sometimes(source, target):
        if next(count) in calls:
            raise OSError(28, "No space left on device", source)
        rename(source, target)

    monkeypatch.setattr(os, "rename", sometimes)


def test_a_folder_is_replaced(whole):
    folder_of(whole, b"second").commit()
    assert (whole / "a/part.bin").read_bytes() == b"second" and os.listdir(whole.parent) == ["out"]


@pytest.mark.parametrize("call", [0, 1])
def test_a_folder_is_as_it_was_after_a_rename_that_fails(whole, monkeypatch, call):
    output = folder_of(whole, b"second")
    failing(monkeypatch, call)
    with pytest.raises(OSError, match="No space"):
        output.commit()
    output.discard()
    assert (whole / "a/part.bin").read_bytes() == b"first" and os.listdir(whole.parent) == ["out"]


def test_a_folder_that_cannot_be_taken_back_is_named(whole, monkeypatch):
    output = folder_of(whole, b"second")
    failing(monkeypatch, 1, 2)
    with pytest.raises(OSError, match="was before is now ") as caught:
        output.commit()
    output.discard()
    [left] = os.listdir(whole.parent)
    assert left in str(caught.value)
    assert (whole.parent / left / "a/part.bin").read_bytes() == b"first"


@pytest.mark.parametrize(
    "name", ["n" * 255, "\N{LATIN SMALL LETTER E WITH ACUTE}" * 127], ids=["ascii", "utf8"]
)
def test_names_as_long_as_the_file_system_takes(tmp_path, name):
    file = FileOutput(str(tmp_path / name), force=False)
    file.write(b"1")
    file.commit()
    folder = folder_of(tmp_path / "inner" / name, b"2")
    folder.commit()
    assert (tmp_path / name).read_bytes() == b"1" and (
        tmp_path / "inner" / name / "a/part.bin"
    ).read_bytes() == b"2"


@pytest.mark.skipif(os.geteuid() != 0, reason="only root gives files to others")
def test_a_replaced_file_keeps_owner_and_rights(tmp_path):
    path = tmp_path / "out.fvv"
    path.write_bytes(b"1")
    os.chown(path, 1234, 2345)
    path.chmod(0o640)
    file = FileOutput(str(path), force=True)
    file.write(b"2")
    file.commit()
    found = path.stat()
    assert (found.st_uid, found.st_gid, found.st_mode & 0o777) == (
        1234,
        2345,
        0o640,
    ) and path.read_bytes() == b"2"


# Several outputs of one call.


def state(folder):
    return {p.relative_to(folder): p.read_bytes() for p in folder.rglob("*") if p.is_file()}


def muxed(players, folder):
    capture = players.parent / "capture"
    return fvv.mux(
        None,
        folder / "out.fvv",
        meshes=capture / "meshes/####.ply",
        fps=25,
        segments=folder / "segments",
        write_capture=folder / "capture.json",
        force=True,
        threads=1,
    )


class Failing:
    """os with a call that fails the n-th time; later: every time from then on."""

    def __init__(self, monkeypatch, name, number, later):
        self.count = 0
        real = getattr(os, name)

        def call(*values, **more):
            self.count += 1
            if self.count == number or (later and self.count > number):
                raise OSError(errno.EIO, os.strerror(errno.EIO), values[0])
            return real(*values, **more)

        monkeypatch.setattr(outputs.os, name, call)


@pytest.mark.parametrize("later", [False, True], ids=["once", "from then on"])
@pytest.mark.parametrize("name", ["rename", "replace", "link", "fsync"])
def test_all_outputs_of_a_call_or_none(name, later, tmp_path, players, monkeypatch):
    failures = 0
    for number in range(1, 5):
        folder = tmp_path / f"{number}"
        folder.mkdir()
        for old in ("out.fvv", "capture.json"):
            (folder / old).write_bytes(b"old")
        before = state(folder)
        with monkeypatch.context() as patch:
            failing = Failing(patch, name, number, later)
            try:
                muxed(players, folder)
                is_done = True
            except OSError as error:
                is_done = False
                said = str(error)
        after = state(folder)
        if is_done:
            assert {"out.fvv", "capture.json", "segments"} == {p.name for p in folder.iterdir()}
            assert b"old" not in after.values()
            continue
        failures += 1
        assert failing.count >= number
        if after != before:  # putting back failed as well: it is said where the old file is
            assert later and sorted(after.values()) >= [b"old", b"old"]
            for path in after.keys() - before.keys():
                assert path.name in said, said
    assert failures >= (0 if name == "link" else 1)
