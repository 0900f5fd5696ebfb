"""What notebooks show: pictures of frames, and the player with a clip inside the page or served."""

import base64
import functools
import gzip
import html
import http.server
import io
import json
import os
import re
import socket
import subprocess
import threading
import urllib.error
import urllib.request

import fvv
import numpy
import pytest
from conftest import ROOT
from fvv import pictures, player
from PIL import Image
from vectors import path_of as vector

DECODER = ROOT / "js/decoder/dist/worker.js"


@pytest.fixture(scope="module")
def script(tmp_path_factory):
    """The player's script, of this build where there is one."""
    if not DECODER.exists() or not (ROOT / "js/node_modules/esbuild").exists():
        return None
    path = tmp_path_factory.mktemp("script") / "player.js.gz"
    bundle = ["node", ROOT / "js/player/bundle.mjs", path]
    subprocess.run(bundle, check=True, timeout=60)
    return path


@pytest.fixture(scope="module")
def any_script(script, tmp_path_factory):
    if script is not None:
        return script
    path = tmp_path_factory.mktemp("script") / "player.js"
    path.write_text("throw new Error('there is no player here </script>');")
    return path


def plain(script):
    content = script.read_bytes()
    return gzip.decompress(content) if script.suffix == ".gz" else content


def decoded(png):
    return numpy.asarray(Image.open(io.BytesIO(png)))


# Frames.


def test_a_frame_shows_the_picture_of_its_first_camera(players):
    with fvv.open(players) as clip:
        assert (decoded(clip[3]._repr_png_()) == clip[3].pictures[0].whole()).all()
        unused = clip[5]
    assert unused._repr_png_() is None  # the clip is closed
    with fvv.open(vector("openexr_bars")) as clip:
        shown = decoded(clip[0]._repr_png_())
        light = clip[0].pictures[3].whole().astype(float).clip(0, 1)
        low = light <= 0.0031308
        expected = 255 * numpy.where(low, 12.92 * light, 1.055 * light ** (1 / 2.4) - 0.055)
        assert shown.shape == light.shape and numpy.abs(shown - expected).max() <= 0.5 + 1e-6
        assert shown.max() > 100
    with fvv.open(vector("tiles_crops")) as clip:  # its samples do not decode
        assert clip[0]._repr_png_() is None


@pytest.mark.parametrize("name", ["delta_field", "colours_sheet", "audio_two_sounds", "calibration_moving"])
def test_a_frame_without_pictures_shows_its_mesh(name):
    with fvv.open(vector(name)) as clip:
        shown = decoded(clip[0]._repr_png_())
    behind = (shown == (250, 250, 248)).all(axis=2)
    # It is in the middle of the picture and ends before its edges.
    assert shown.shape == (480, 640, 3) and 0.01 < (~behind).mean() < 0.9
    assert behind[[0, -1]].all() and behind[:, [0, -1]].all() and not behind[120:360, 160:480].all()


def test_png_is_read_by_others():
    random = numpy.random.default_rng(1)
    for height, width in ((1, 1), (1, 7), (5, 1), (40, 33)):
        pixels = random.integers(0, 256, (height, width, 3), numpy.uint8)
        assert (decoded(pictures.png(pixels)) == pixels).all()
        assert (decoded(pictures.png(pixels[::-1, ::-1])) == pixels[::-1, ::-1]).all()
    for wrong in (pixels[:, :, :2], pixels.astype(float), pixels[:0], pixels[0]):
        with pytest.raises(fvv.UsageError):
            pictures.png(wrong)


def test_pixels_for_screens():
    deep = numpy.array([[[0, 255, 256], [65535, 32768, 65280]]], numpy.uint16)
    assert pictures.on_screen(deep).tolist() == [[[0, 0, 1], [255, 128, 255]]]
    light = numpy.array([[[-1, 0, 0.5], [1, 7, numpy.nan]]], numpy.float16)
    assert pictures.on_screen(light).tolist() == [[[0, 0, 188], [255, 255, 0]]]
    for wrong in (deep.astype(numpy.int32), deep[0]):
        with pytest.raises(fvv.UsageError):
            pictures.on_screen(wrong)
    wide = numpy.arange(7 * 2000 * 3).reshape(7, 2000, 3).astype(numpy.uint8)
    small = pictures.shrunk(wide)
    assert small.shape == (2, 666, 3)
    assert numpy.abs(small[1, 5] - wide[3:6, 15:18].mean(axis=(0, 1))).max() <= 0.5
    assert pictures.shrunk(wide[:, :960]) is not None and pictures.shrunk(wide[:, :960]).shape == (7, 960, 3)


# A page with the clip in it.


def frame_of(shown):
    """The attributes of the <iframe>."""
    text = shown._repr_html_()
    assert text.startswith("<iframe ") and text.endswith("</iframe>")
    return {name: html.unescape(value) for name, value in re.findall(r'(\w+)="([^"]*)"', text)}


def test_a_page_holds_the_script_and_the_clip(players, any_script):
    with fvv.open(players) as clip:
        shown = clip.show(player=any_script, width=640)
    frame = frame_of(shown)
    assert "width: 640px" in frame["style"] and shown.url is None
    held = dict(re.findall(r'id="(\w+)">([^<]*)<', frame["srcdoc"]))
    assert base64.b64decode(held["clip"]) == players.read_bytes()
    assert gzip.decompress(base64.b64decode(held["script"])) == plain(any_script)


def test_what_show_refuses(players, any_script, monkeypatch):
    clip = fvv.open(players)
    for width in ("red", "1px; color: red", '1px" onload="', "-1%", ""):
        with pytest.raises(fvv.UsageError):
            clip.show(width=width, player=any_script)
    with pytest.raises(FileNotFoundError):
        clip.show(player=any_script.with_name("missing.js"))
    monkeypatch.setattr(player, "INLINE_LIMIT", 1000)
    with pytest.raises(fvv.UsageError, match="inline=False"):
        clip.show(inline=True, player=any_script)
    monkeypatch.setattr(player, "SCRIPT", str(any_script.with_name("missing.js")))
    with pytest.raises(fvv.UsageError, match="bundle.mjs"):
        clip.show()
    clip.close()
    with pytest.raises(fvv.UsageError, match="closed"):
        clip.show(player=any_script)


# Served.


def fetch(url, method="GET", **headers):
    """(status, headers, body), errors too."""
    request = urllib.request.Request(url, headers=headers, method=method)
    try:
        with urllib.request.urlopen(request, timeout=10) as reply:
            return reply.status, reply.headers, reply.read()
    except urllib.error.HTTPError as error:
        return error.code, error.headers, error.read()


def test_a_served_clip(players, any_script):
    content = players.read_bytes()
    clip = fvv.open(content)
    shown = clip.show(inline=False, player=any_script)
    assert frame_of(shown)["src"] == shown.url == clip.show(inline=False, player=any_script).url
    status, headers, page = fetch(shown.url)
    assert status == 200 and b'src="clip.fvv"' in page and headers["Content-Type"].startswith("text/html")
    status, headers, packed = fetch(shown.url + "player.js")
    assert gzip.decompress(packed) == plain(any_script) and headers["Content-Encoding"] == "gzip"
    status, headers, body = fetch(shown.url + "clip.fvv")
    assert (status, body, headers["Accept-Ranges"]) == (200, content, "bytes") and headers["ETag"]
    size = len(content)
    for text, first, last in (
        ("bytes=0-0", 0, 0),
        ("bytes=5-99", 5, 99),
        (f"bytes={size - 3}-", size - 3, size - 1),
        ("bytes=-8", size - 8, size - 1),
        (f"bytes=-{2 * size}", 0, size - 1),
        (f"bytes=7-{size + 5}", 7, size - 1),
    ):
        status, headers, body = fetch(shown.url + "clip.fvv", Range=text)
        assert (status, headers["Content-Range"]) == (206, f"bytes {first}-{last}/{size}")
        assert body == content[first : last + 1]
    for text in (f"bytes={size}-", "bytes=9-5", "bytes=-0", "bytes=-", "lines=1-2", "bytes=1-2,4-5"):
        status, headers, body = fetch(shown.url + "clip.fvv", Range=text)
        assert (status, headers["Content-Range"], body) == (416, f"bytes */{size}", b"")
    status, headers, body = fetch(shown.url + "clip.fvv", "HEAD")
    assert (status, headers["Content-Length"], body) == (200, str(size), b"")
    root = "/".join(shown.url.split("/")[:3])
    for other in (f"{root}/", f"{root}/wrong/clip.fvv", f"{shown.url}../clip.fvv", f"{shown.url}etc"):
        assert fetch(other)[0] == 404
    clip.close()
    with pytest.raises(OSError):
        fetch(shown.url)
    assert not [t for t in threading.enumerate() if t.daemon and "_serve" in t.name]


def test_a_clip_that_is_collected_is_served_no_more(players, any_script):
    import gc

    clip = fvv.open(players)
    url = clip.show(inline=False, player=any_script).url
    assert fetch(url)[0] == 200
    del clip
    gc.collect()
    with pytest.raises(OSError):
        fetch(url)


def test_ports(players):
    with fvv.open(players) as clip:
        with pytest.raises(fvv.UsageError):
            player.Server(clip._stream, "players", b"", port=70000)
        with socket.socket() as taken:
            taken.bind(("127.0.0.1", 0))
            taken.listen()
            with pytest.raises(OSError):
                player.Server(clip._stream, "players", b"", port=taken.getsockname()[1])


# In a browser.


class QuietFiles(http.server.SimpleHTTPRequestHandler):
    def log_message(self, *_):
        pass


@pytest.mark.parametrize("inline", [True, False], ids=["inline", "served"])
def test_chromium_plays_it(players, script, tmp_path, inline):
    if script is None:
        pytest.skip("no js/decoder/dist or no js/node_modules: the player is not built")
    handler = functools.partial(QuietFiles, directory=tmp_path)
    with fvv.open(players) as clip, http.server.ThreadingHTTPServer(("127.0.0.1", 0), handler) as notebook:
        thread = threading.Thread(target=notebook.serve_forever)
        thread.start()
        shown = clip.show(inline=inline, player=script)._repr_html_()
        page = f'<!doctype html><title>notebook</title><link rel="icon" href="data:,">{shown}'
        (tmp_path / "notebook.html").write_text(page)
        picture = (
            f"{os.environ.get('FVV_ARTEFACTS', tmp_path)}/notebook-{'inline' if inline else 'served'}.png"
        )
        url = f"http://127.0.0.1:{notebook.server_address[1]}/notebook.html"
        done = subprocess.run(
            ["node", ROOT / "bindings/python/tests/play.mjs", url, picture],
            capture_output=True,
            text=True,
            timeout=120,
        )
        notebook.shutdown()
        thread.join()
    assert done.returncode == 0, done.stderr
    seen = json.loads(done.stdout)
    if "missing" in seen:
        pytest.skip(seen["missing"])
    # One worker decodes: the script found itself.
    assert seen["shown"] >= 4 and seen["error"] is None and seen["troubles"] == [] and seen["workers"] == 1
