"""Render vectors: fvvrender draws what they hold, the renderers of the project conform, and a wrong one does not."""

import json
import pathlib
import shutil
import subprocess
import sys

import pytest

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
RENDER = ROOT / "conformance/render"
PYTHON = f"{sys.executable} {RENDER / 'bindings.py'}"
BLACK = """
import base64, json, sys
for line in sys.stdin:
    request = json.loads(line)
    if request["op"] == "hello":
        answer = {"protocol": 1, "name": "black", "parts": ["render"]}
    elif request["op"] == "render":
        width, height = request["view"]["width"], request["view"]["height"]
        answer = {"id": request["id"], "width": width, "height": height}
        answer["rgba"] = base64.b64encode(bytes(4 * width * height)).decode()
    else:
        break
    print(json.dumps(answer), flush=True)
"""


def rendered(*arguments):
    """Exit code and result of conformance/run render, and what it printed."""
    command = [sys.executable, ROOT / "conformance/run", "render", "--json", "-", *arguments]
    done = subprocess.run(command, capture_output=True, text=True)
    return done.returncode, json.loads(done.stdout or "{}"), done.stderr


def test_fvvrender_draws_the_vectors():
    done = subprocess.run([sys.executable, RENDER / "vectors.py", "--check"], capture_output=True, text=True)
    assert (done.returncode, done.stderr) == (0, "")


def test_python_draws_the_vectors():
    pytest.importorskip("fvv", reason="the Python package is not built: -DFVV_PYTHON_PACKAGE=ON")
    code, result, text = rendered("--renderer", PYTHON)
    assert code == 0, text
    vectors = result["renderers"][0]["vectors"]
    assert len(vectors) == 9
    # Averages over pixels are the renderer's own choice there; all others are the same bytes.
    assert all(line["psnr"] > 80 or line["vector"] == "far" for line in vectors)


@pytest.mark.parametrize("which", ["player", "three"])
def test_browsers_draw_the_vectors(which):
    if not shutil.which("chromium"):
        pytest.skip("no chromium installed")
    code, result, text = rendered("--renderer", f"node {RENDER / 'browser.mjs'} {which}")
    assert code == 0, text
    assert [line["unsupported"] for line in result["renderers"][0]["vectors"]] == [None] * 9


def test_a_wrong_renderer_fails(tmp_path):
    program = tmp_path / "black.py"
    program.write_text(BLACK)
    code, result, text = rendered("--renderer", f"{sys.executable} {program}")
    assert code == 1
    assert all("dB, expected at least" in line["problem"] for line in result["renderers"][0]["vectors"]), text


def test_what_is_drawn_beside_the_surface_counts(tmp_path):
    """The right picture on white."""
    program = tmp_path / "white.py"
    program.write_text(
        f"import sys; sys.path.insert(0, {str(RENDER)!r})\n"
        "import base64, bindings, numpy\n"
        "draw = bindings.render\n"
        "def white(request):\n"
        "    answer = draw(request)\n"
        "    pixels = numpy.frombuffer(base64.b64decode(answer['rgba']), numpy.uint8).reshape(-1, 4).copy()\n"
        "    pixels[(pixels[:, :3] == 0).all(axis=1)] = 255\n"
        "    return {**answer, 'rgba': base64.b64encode(pixels.tobytes()).decode()}\n"
        "bindings.render = white\n"
        "bindings.main()\n"
    )
    code, result, _ = rendered("--renderer", f"{sys.executable} {program}", "--only", "bits")
    assert code == 1
    assert "is drawn beside it" in result["renderers"][0]["vectors"][0]["problem"]
