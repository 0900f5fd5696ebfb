"""Clips of a web server: read by ranges, and what is said of servers that do not serve them."""

import contextlib
import http.server
import pickle
import re
import subprocess
import sys
import threading
import time

import fvv
import pytest
from fvv import remote


class Server(http.server.ThreadingHTTPServer):
    """Serves one stream. behaviour: what is wrong with it."""

    daemon_threads = True

    def __init__(self, content, behaviour=""):
        super().__init__(("127.0.0.1", 0), Handler)
        self.content, self.behaviour = content, behaviour
        self.date, self.ranges, self.requests, self.connections = "Sat, 28 Nov 2026 12:00:00 GMT", [], 0, 0
        self.url = f"http://127.0.0.1:{self.server_address[1]}/players.fvv"

    def handle_error(self, request, client_address):
        """A client that ends a connection is no error."""


class Handler(http.server.BaseHTTPRequestHandler):
    protocol_version = "HTTP/1.1"

    def setup(self):
        super().setup()
        self.server.connections += 1

    def do_GET(self):
        server, content = self.server, self.server.content
        server.requests += 1
        how = server.behaviour
        if how == "silent":
            time.sleep(5)
        if how == "busy" and server.requests % 2:
            return self.reply(503, b"")
        if how.isdigit():
            return self.reply(int(how), b"no")
        if how == "moved" and self.path == "/players.fvv":
            return self.reply(302, b"", Location="/elsewhere.fvv")
        if how == "whole":
            return self.reply(200, content)
        first, last = map(int, re.fullmatch(r"bytes=(\d+)-(\d+)", self.headers["Range"]).groups())
        server.ranges.append((first, last + 1))
        if first >= len(content):
            return self.reply(416, b"", Content_Range=f"bytes */{len(content)}")
        last = min(last, len(content) - 1)
        part = content[first : last + 1]
        said = f"bytes {first + (how == 'shifted')}-{last}/{len(content)}"
        fields = {"Last_Modified": server.date, "ETag": f'"{server.requests}"', "Content_Range": said}
        if how == "cut" and server.requests % 2 and len(part) > 100:
            return self.reply(206, part, sent=len(part) // 2, **fields)
        return self.reply(206, part, **fields)

    def reply(self, status, body, sent=None, **fields):
        self.send_response(status)
        for name, value in {"Content-Length": len(body), **fields}.items():
            self.send_header(name.replace("_", "-"), str(value))
        self.end_headers()
        with contextlib.suppress(OSError):
            self.wfile.write(body[:sent])
        if sent is not None:
            self.close_connection = True

    def log_message(self, format, *arguments):
        pass


@contextlib.contextmanager
def served(content, behaviour=""):
    with Server(content, behaviour) as server:
        thread = threading.Thread(target=server.serve_forever, args=(0.02,))
        thread.start()
        try:
            yield server
        finally:
            server.shutdown()
            thread.join()


def parts(clip):
    return [(f.ticks, f.mesh.positions.tobytes(), f.pictures[1].pixels.tobytes()) for f in clip]


@pytest.fixture(scope="module")
def content(players):
    return players.read_bytes()


@pytest.fixture(scope="module")
def expected(players):
    with fvv.open(players) as clip:
        return parts(clip)


@pytest.fixture(autouse=True)
def quick(monkeypatch):
    monkeypatch.setattr(remote, "CONNECT_SECONDS", 0.5)
    monkeypatch.setattr(remote, "READ_SECONDS", 0.5)
    monkeypatch.setattr(remote, "BLOCK", 1 << 12)  # the stream of this test has 140 kB
    monkeypatch.setattr(remote, "WAIT_SECONDS", 0.01)


@pytest.mark.parametrize("behaviour", ["", "busy", "moved", "cut"])
def test_a_url_is_read_as_a_file_is(content, expected, behaviour):
    with served(content, behaviour) as server, fvv.open(server.url) as clip:
        assert clip.name == server.url and parts(clip) == expected and not clip.problems


def test_only_ranges_that_are_needed_are_fetched(content, expected):
    with served(content) as server:
        with fvv.open(server.url) as clip:
            assert clip[0].mesh.vertex_count and clip[0].mesh.positions.tobytes() == expected[0][1]
            fetched = sum(min(end, len(content)) - first for first, end in server.ranges)
            assert fetched < len(content) / 2
            assert parts(clip) == expected
        # Blocks are kept, neighbours come in one request, and the connection stays.
        fetched = sum(min(end, len(content)) - first for first, end in server.ranges)
        assert fetched < 1.02 * len(content) and server.connections == 1
        assert server.requests < 0.6 * len(content) / remote.BLOCK


def test_a_file_of_many_blocks_is_kept_in_bounded_memory(content, monkeypatch):
    monkeypatch.setattr(remote, "BLOCK", 1024)
    monkeypatch.setattr(remote, "KEPT", 8)
    monkeypatch.setattr(remote, "MOST_BLOCKS", 4)
    with served(content) as server:
        file = remote.RemoteFile(server.url)
        for offset, size in (
            (0, 10),
            (500, 1000),
            (70_001, 30_000),
            (1023, 2),
            (len(content) - 1, 1),
            (0, len(content)),
        ):
            assert file.read_at(offset, size) == content[offset : offset + size]
            assert len(file._blocks) <= 8


@pytest.mark.parametrize(
    "behaviour, error, text",
    [
        ("whole", OSError, "does not serve parts of a file"),
        ("404", FileNotFoundError, "replies 404"),
        ("410", FileNotFoundError, "replies 410"),
        ("403", PermissionError, "replies 403"),
        ("418", OSError, "replies 418 .*expected 206"),
        ("503", OSError, "replies 503"),
        ("silent", TimeoutError, "does not reply"),
        ("shifted", OSError, "expected bytes 0-4095, the server replies with Content-Range 'bytes 1-"),
    ],
)
def test_what_is_wrong_with_a_server_is_said(content, behaviour, error, text):
    with served(content, behaviour) as server:
        begin = time.monotonic()
        with pytest.raises(error, match=text) as caught:
            fvv.open(server.url)
        assert server.url in str(caught.value) and time.monotonic() - begin < 10
        assert server.requests == {"silent": remote.ATTEMPTS, "503": remote.ATTEMPTS}.get(behaviour, 1)


def test_a_server_that_is_not_there():
    with served(b"") as server:
        url = server.url
    with pytest.raises(OSError, match="refused"):
        fvv.open(url)
    with pytest.raises(fvv.UsageError, match=r"fsspec.open\(url\)"):
        fvv.open("s3://bucket/players.fvv")


def test_what_is_no_stream(content):
    for body in (b"", b"no stream", bytes(100_000)):
        with served(body) as server, pytest.raises(fvv.DamagedError) as caught:
            fvv.open(server.url)
        assert caught.value.file == server.url


def test_a_file_that_is_replaced_is_an_error_and_not_damage(content):
    with served(content) as server, fvv.open(server.url) as clip:
        assert clip[0].mesh.vertex_count
        server.date = "Sat, 28 Nov 2026 13:00:00 GMT"
        with pytest.raises(OSError, match="was replaced while it was read"):
            parts(clip)
        assert not clip.problems


def test_a_server_that_ends_does_not_damage(content):
    with served(content) as server, fvv.open(server.url) as clip:
        server.behaviour = "404"
        with pytest.raises(FileNotFoundError):
            clip[11].mesh  # noqa: B018
        server.behaviour = ""
        assert clip[11].mesh.vertex_count and not clip.problems


def test_pickled_it_is_its_url(content, expected):
    with served(content) as server:
        with fvv.open(server.url) as clip:
            kept = pickle.dumps(clip)
        assert len(kept) < 500
        with pickle.loads(kept) as clip:
            assert parts(clip) == expected
        server.content = content + b"more"
        with pytest.raises(fvv.UsageError, match="bytes here, expected"):
            pickle.loads(kept)


def test_check_and_the_command_line(content):
    with served(content) as server:
        assert fvv.check(server.url).ok
        done = subprocess.run(
            [sys.executable, "-m", "fvv", "info", server.url], capture_output=True, text=True, timeout=60
        )
        assert done.returncode == 0 and "12 frames" in done.stdout, done.stderr


def test_without_urllib3_it_says_what_to_install(monkeypatch):
    monkeypatch.setitem(sys.modules, "urllib3", None)
    with pytest.raises(fvv.UsageError, match=r"pip install fvv\[http\]"):
        fvv.open("https://example.org/players.fvv")
