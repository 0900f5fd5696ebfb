"""The table of options: the command line, the types, the reference, keywords and messages are made from it."""

import ast
import importlib.util
import io
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys

import fvv
import numpy
import pytest
from conftest import tool
from fvv.options import OF_CAPTURES, TABLE, option_texts

ROOT = pathlib.Path(__file__).resolve().parents[3]
# Of the command alone, and no options of a stream.
OF_COMMAND = {
    "capture", "force", "help", "help-all", "idle", "in-place", "json", "max-delay", "merge", "output", "part", "plan", "realtime",
    "report", "segments", "version", "write-capture",
}  # fmt: skip


def described():
    """Options of fvvmux by name, as --help-json has them."""
    groups = json.loads(tool("fvvmux", "--help-json"))["groups"]
    found = [option for group in groups for option in group["options"]]
    return {name[2:]: option for option in found for name in option["names"] if name.startswith("--")}


def test_the_command_line_has_the_options_of_the_table():
    options = described()
    assert set(options) - OF_COMMAND == {row["name"] for row in TABLE.values()}
    for row in TABLE.values():
        option = options[row["name"]]
        assert (option["value"] is None) == (row["type"] == "bool")
        assert option.get("default", "") == row["default"]
        assert re.sub(r"--([a-z-]+)", lambda m: m[1].replace("-", "_"), option["text"]) == row["help"]


def test_the_types_are_those_of_the_table():
    path = ROOT / "bindings/python/stub_options.py"
    specification = importlib.util.spec_from_file_location("stub_options", path)
    module = importlib.util.module_from_spec(specification)
    specification.loader.exec_module(module)
    assert module.PATH.read_text() == module.stub(), f"run {path.name}"
    classes = {one.name: one for one in ast.parse(module.stub()).body if isinstance(one, ast.ClassDef)}
    fields = {
        name: {line.target.id for line in found.body if isinstance(line, ast.AnnAssign)}
        for name, found in classes.items()
    }
    assert fields["EncodeOptions"] | fields["WriterOptions"] == set(TABLE) - OF_CAPTURES
    assert fields["PlanOptions"] | fields["MuxOptions"] == OF_CAPTURES - {"cameras"}
    assert "threads" in fields["WriterOptions"] and "frames" in fields["PlanOptions"]


@pytest.mark.skipif(not shutil.which("node"), reason="the reference is written by Node")
def test_the_reference_has_every_option():
    script = f"""
        import {{ toolReference }} from {json.dumps(str(ROOT / "js/docs/references/cli.mjs"))};
        process.stdout.write(toolReference("fvvmux", {json.dumps(os.environ["FVV_TOOLS_DIR"])}));
    """
    done = subprocess.run(
        ["node", "--input-type=module", "-e", script], capture_output=True, text=True, check=True
    )
    named = set(re.findall(r"`--([a-z-]+)`", done.stdout))
    assert {row["name"] for row in TABLE.values()} <= named


@pytest.mark.parametrize("name", TABLE)
def test_every_option_is_a_keyword(name):
    row = TABLE[name]
    value = True if row["type"] == "bool" else row["example"]
    assert option_texts({name: value}) == {row["name"]: row["example"]}
    assert option_texts({name: None}) == {}
    if name not in OF_CAPTURES or name == "up":  # a writer has one of its own
        return
    with pytest.raises(fvv.UsageError):
        fvv.Writer(io.BytesIO(), rate=25, **{name: value})


def test_values_become_texts():
    assert option_texts({"tile": (480, 270), "ladder": [1, 0.5], "no_delta": numpy.bool_(True)}) == {
        "tile": "480x270", "ladder": "1,0.5", "no-delta": "on",
    }  # fmt: skip
    assert option_texts({"colours": False, "max_error": 0.5}) == {"colours": "off", "max-error": "0.5"}


def test_former_names_warn():
    with pytest.warns(DeprecationWarning, match="budget is called max_error now"):
        assert option_texts({"budget": "1mm"}) == {"max-error": "1mm"}
    with pytest.warns(DeprecationWarning), pytest.raises(fvv.UsageError, match="max_error: expected once"):
        option_texts({"max_error": "1mm", "budget": "1mm"})
    mesh = (numpy.eye(3), [[0, 1, 2]])
    with pytest.warns(DeprecationWarning, match="budget is called max_error now"):
        fvv.decimate(mesh, budget="1mm")


def test_messages_name_arguments():
    with pytest.raises(fvv.UsageError, match=r"^scale: expected a number above 0") as caught:
        fvv.Writer(io.BytesIO(), rate=25, scale=2)
    assert "--" not in str(caught.value) and not re.search(r"[\x00-\x1f]", str(caught.value))
    with pytest.raises(fvv.UsageError, match=r"^sound_bitrate: expected without no_sound, found both$"):
        fvv.Writer(io.BytesIO(), rate=25, sound_bitrate="96k", no_sound=True)


def test_an_encoder_that_ffmpeg_lacks_is_named(tmp_path):
    """As in a wheel whose FFmpeg has no parts under the GPL: x264 and x265 are hidden."""
    source = tmp_path / "hide.c"
    source.write_text(
        """#include <dlfcn.h>
#include <stdlib.h>
#include <string.h>
void *avcodec_find_encoder_by_name(const char *name) {
  if (!strncmp(name, "libx26", 6)) return 0;
  void *library = dlopen(getenv("LIBAVCODEC"), RTLD_LAZY | RTLD_NOLOAD);
  return ((void *(*)(const char *))dlsym(library, "avcodec_find_encoder_by_name"))(name);
}
"""
    )
    subprocess.run(["cc", "-shared", "-fPIC", "-o", tmp_path / "hide.so", source], check=True)
    loaded = subprocess.run(["ldd", fvv._core.__file__], capture_output=True, text=True, check=True).stdout
    library = re.search(r"libavcodec\.so\.\d+", loaded)[0]
    program = """
import sys
import fvv, numpy
camera = fvv.Camera(0, [[100, 0, 80], [0, 100, 48], [0, 0, 1]], numpy.eye(3), [0, 0, 3], (160, 96))
mesh = numpy.eye(4, 3, -1), [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]
for codec in ("h264", "hevc", "vp9"):
    try:
        with fvv.Writer(sys.argv[1], rate=25, cameras=[camera], codec=codec, force=True) as writer:
            writer.add(mesh, [numpy.full((96, 160, 3), 100, numpy.uint8)])
        print(codec)
    except fvv.Error as error:
        print(error)
"""
    done = subprocess.run(
        [sys.executable, "-c", program, tmp_path / "out.fvv"],
        capture_output=True,
        text=True,
        env=os.environ | {"LD_PRELOAD": str(tmp_path / "hide.so"), "LIBAVCODEC": library},
    )
    assert done.returncode == 0, done.stderr
    first, second, third = done.stdout.splitlines()
    for line, library, name in ((first, "libx264", "H.264"), (second, "libx265", "HEVC")):
        assert f"this build of FFmpeg has no {library}, which encodes {name}" in line
        assert "one of its codecs: vp9, av1, jpeg" in line
    assert third == "vp9", done.stderr
