"""fvvserve over HTTP: what it serves, to whom, what it refuses, and ranges and conditions by the text of RFC 9110."""

import contextlib
import functools
import os
import resource
import signal
import socket
import subprocess
import time
from email.utils import formatdate

import pytest
from conftest import tool_path
from serve_client import CONTENT, SECRET, SIZE, Server, make_site, read_reply


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return make_site(tmp_path_factory.mktemp("serve"))


@pytest.fixture(scope="module")
def server(folder):
    with Server("--root", folder, "--allow-host", "Box.Example") as server:
        yield server


@pytest.mark.parametrize(
    "target, media_type",
    [
        ("/page.html", "text/html; charset=utf-8"),
        ("/sub/", "text/html; charset=utf-8"),
        ("/decoder.wasm", "application/wasm"),
        ("/with%20space.js", "text/javascript; charset=utf-8"),
        ("/inside.fvv?query=/../..", "model/vnd.fvv"),
    ],
)
def test_media_types(server, target, media_type):
    reply = server.request(target)
    assert (reply.status, reply["Content-Type"]) == (200, media_type)
    policy = reply["Content-Security-Policy"]
    if "html" in media_type:
        assert "script-src 'self' 'wasm-unsafe-eval'; worker-src 'self';" in policy
    else:
        assert policy is None


def test_folders(server):
    moved = server.request("/sub")
    assert (moved.status, moved["Location"]) == (301, "/sub/")
    assert server.request("/nothing/").status == server.request("/").status == 404, "no listing"


def spellings():
    """Paths to the secret beside the root and to hidden files, in every spelling that has fooled a server."""
    ups = [
        "..",
        "%2e%2e",
        "%2E.",
        ".%2e",
        "%252e%252e",
        "%c0%ae%c0%ae",
        "..;",
        "...",
        "..%00",
        "%u002e%u002e",
    ]
    slashes = ["/", "%2f", "%2F", "\\", "%5c", "//", "/./", "%252f", "%c0%af", "/%2e/"]
    for up in ups:
        for slash in slashes:
            yield f"/{up}{slash}secret.txt"
            yield f"/sub/{up}{slash}{up}{slash}secret.txt"
    for slash in slashes:
        yield f"/..{slash}rootless{slash}secret.txt"
        yield f"/sub{slash}..{slash}.hidden"
    yield from (
        "/out",
        "/outside/secret.txt",
        "/outside/rootless/secret.txt",
        "/veiled",
        "/.hidden",
        "/sub/.hidden",
    )
    yield from ("/%2ehidden", "/sub/%2Ehidden", "/clip.fvv/../../secret.txt", "/nothing/../../secret.txt")
    yield from ("/clip.fvv%00.html", "/%00", "/clip.fvv/", "/sub//index.html", "/sub/./index.html", "/fifo")
    yield from (
        "/etc/passwd",
        "//etc/passwd",
        "/%2fetc/passwd",
        "/%2",
        "/%zz",
        "/%",
        "/\x7f",
        "/proc/self/environ",
    )
    yield from (
        "//127.0.0.1/clip.fvv",
        "/clip.fvv\\..\\..\\secret.txt",
        "/file:///etc/passwd",
        "/~root",
        "/a/" * 500,
    )
    yield from ("/clip.fvv/..", "/sub/..", "/sub/../clip.fvv", "/outside/", "/out/", "/inside.fvv/../out")


def test_traversal(server):
    tried = list(spellings())
    assert len(tried) >= 250
    for target in tried:
        reply = server.request(target)
        assert reply.status in (400, 404) and SECRET not in reply.body, (target, reply.status)
    # Targets that are not a path.
    for target in ("..", "secret.txt", "../secret.txt", "*", "", "http://", "file:///etc/passwd"):
        assert server.request(target).status in (400, 404), target
    reply = server.request(f"http://{server.host}/clip.fvv")
    assert (reply.status, reply.body) == (
        200,
        CONTENT,
    ), "the absolute form is a valid target (RFC 9112 3.2.2)"


def test_a_slash_at_the_end_of_a_link_is_not_a_way_to_another_host(server):
    reply = server.request("//evil.example/..")
    assert reply.status == 404 and reply["Location"] is None


def test_hosts(server):
    port = server.port
    good = [
        f"localhost:{port}",
        f"127.0.0.1:{port}",
        "[::1]:80",
        "a.localhost",
        "LOCALHOST",
        "192.168.0.7",
        "box.example:1",
    ]
    bad = [
        "evil.example",
        f"evil.example:{port}",
        "localhost.evil.example",
        "127.0.0.1.evil.example",
        "[::1]evil",
    ]
    bad += [
        "localhost:80:80",
        "localhost:x",
        "box.example.evil",
        "[",
        "[]",
        "0x7f.1",
        "evil.example#localhost",
    ]
    assert [server.request("/clip.fvv", Host=host).status for host in good] == [200] * len(good)
    assert [server.request("/clip.fvv", Host=host).status for host in bad] == [421] * len(bad)
    assert server.request("http://evil.example/clip.fvv").status == 421
    assert server.request("/clip.fvv", Host=None).status == 400
    twice = b"GET / HTTP/1.1\r\nHost: localhost\r\nHost: evil.example\r\n\r\n"
    assert server.raw(twice).status == 400
    for target in b"/clip.fvv", b"http://localhost/clip.fvv", b"/live/clip":
        for version in b"1.0", b"1.1":
            assert server.raw(b"GET " + target + b" HTTP/" + version + b"\r\nHost: \r\n\r\n").status == 400


def test_two_origins_are_refused(server):
    request = f"GET /clip.fvv HTTP/1.1\r\nHost: {server.host}\r\n".encode()
    assert server.raw(request + b"Origin: https://a.example\r\n\r\n").status == 200
    for more in b"https://a.example", f"http://{server.host}".encode(), b"":
        both = b"Origin: https://a.example\r\nOrigin: " + more + b"\r\n\r\n"
        assert server.raw(request + both).status == 400
    assert server.raw(request + b"Origin:\r\n\r\n").status == 400


def test_methods_and_malformed_requests(server):
    for method in "POST", "PUT", "DELETE", "TRACE", "PATCH":
        reply = server.request("/clip.fvv", method)
        assert (reply.status, reply["Allow"]) == (405, "GET, HEAD, OPTIONS")
    for request in (
        b"nonsense\r\n\r\n",
        b"GET /clip.fvv HTTP/9.9\r\n\r\n",
        b"GET / HTTP/1.1\r\nHost : a\r\n\r\n",
    ):
        assert server.raw(request).status == 400
    assert server.raw(b"GET / HTTP/1.1\r\nHost: localhost\r\nContent-Length: 5\r\n\r\nhello").status == 400
    assert server.request("/clip.fvv", Padding="x" * 9000).status == 431


def test_connection_is_kept(server):
    with contextlib.closing(server.connect()) as connection, connection.makefile("rb") as stream:
        request = f"GET /clip.fvv HTTP/1.1\r\nHost: {server.host}\r\n".encode()
        connection.sendall((request + b"\r\n") * 3)  # in one go; the replies come in order
        assert [read_reply(stream).status for _ in range(3)] == [200] * 3
        connection.sendall(request + b"Connection: close\r\n\r\n")
        assert read_reply(stream)["Connection"] == "close"
        assert stream.read() == b""


def test_cors(folder, server):
    plain = server.request("/clip.fvv", Origin="https://player.example")
    assert plain["Access-Control-Allow-Origin"] is None
    assert plain["Cross-Origin-Resource-Policy"] == "same-origin"
    with Server(
        "--root", folder, "--allow-origin", "https://Player.example", "--allow-origin", "http://a:1"
    ) as other:
        reply = other.request("/clip.fvv", Origin="https://player.example", Range="bytes=0-1")
        assert reply["Access-Control-Allow-Origin"] == "https://player.example" and reply["Vary"] == "Origin"
        exposed = reply["Access-Control-Expose-Headers"].split(", ")
        assert {"Content-Range", "ETag", "Accept-Ranges"} <= set(exposed)
        for origin in (
            "https://player.example.evil",
            "http://player.example",
            "https://player.example:444",
            "null",
        ):
            assert other.request("/clip.fvv", Origin=origin)["Access-Control-Allow-Origin"] is None
        reply = other.request(
            "/clip.fvv", "OPTIONS", Origin="http://a:1", Access_Control_Request_Headers="range"
        )
        assert reply.status == 204 and "Range" in reply["Access-Control-Allow-Headers"].split(", ")
        assert "If-Range" in reply["Access-Control-Allow-Headers"].split(", ")
        assert (
            other.request("/x", Origin="http://a:1")["Access-Control-Allow-Origin"] == "http://a:1"
        ), "404 too"
    with Server("--root", folder, "--allow-origin", "*") as other:
        assert other.request("/clip.fvv", Origin="https://any.example")["Access-Control-Allow-Origin"] == "*"


def test_slow_requests_and_many_connections(folder):
    with Server("--root", folder, "--request-timeout", "0.5", "--max-connections", "20") as server:
        begin = time.monotonic()
        with contextlib.closing(server.connect()) as connection:
            connection.sendall(b"GET / HTTP/1.1\r\n")
            with contextlib.suppress(ConnectionError):
                while time.monotonic() - begin < 5:  # a byte now and then does not move the deadline
                    connection.sendall(b"X")
                    connection.settimeout(0.1)
                    with contextlib.suppress(socket.timeout):
                        assert connection.recv(1) == b""
                        break
        assert 0.4 < time.monotonic() - begin < 4
        waiting = [server.connect() for _ in range(20)]
        assert server.request("/clip.fvv").status == 503
        for connection in waiting:
            assert connection.recv(1) == b"", "silent connections are closed"
            connection.close()
        assert server.request("/clip.fvv").status == 200


def test_a_file_for_which_no_descriptor_is_free(folder):
    """It is there, which 404 would deny: 503, and a later request gets it."""
    few = functools.partial(resource.setrlimit, resource.RLIMIT_NOFILE, (40, 40))
    with Server("--root", folder, before=few) as server:
        get = f"GET /clip.fvv HTTP/1.1\r\nHost: {server.host}\r\n\r\n".encode()
        waiting = [server.connect() for _ in range(60)]  # more than there are descriptors
        status = None
        for connection in waiting[:20]:
            connection.sendall(get)
            reply = read_reply(connection.makefile("rb"))
            status = reply.status
            if status == 503:
                break
            time.sleep(0.1)  # some were not accepted yet
        assert status == 503 and reply["Retry-After"] == "5" and reply["Connection"] == "close"
        for connection in waiting:
            connection.close()
        end = time.monotonic() + 10
        while (reply := server.request("/clip.fvv")).status == 503 and time.monotonic() < end:
            time.sleep(0.1)
        assert reply.status == 200 and reply.body == CONTENT


def test_a_terminal_that_closes_does_not_end_a_server_with_nohup(folder):
    ignored = functools.partial(signal.signal, signal.SIGHUP, signal.SIG_IGN)
    with Server("--root", folder, before=ignored) as server:
        server.process.send_signal(signal.SIGHUP)
        time.sleep(0.2)
        assert server.request("/clip.fvv").status == 200
    with Server("--root", folder) as server:
        server.process.send_signal(signal.SIGHUP)
        assert server.process.wait(10) != 0
        server.process.returncode = 0  # as this test expects


def test_a_large_file_arrives_whole_at_a_slow_reader(folder, server):
    content = os.urandom(1 << 20) * 8
    (folder / "large.fvv").write_bytes(content)
    with contextlib.closing(server.connect(4096)) as connection:
        connection.sendall(f"GET /large.fvv HTTP/1.1\r\nHost: {server.host}\r\n\r\n".encode())
        time.sleep(0.3)
        assert server.request("/clip.fvv").status == 200, "others do not wait"
        assert read_reply(connection.makefile("rb")).body == content


# Ranges and conditions.


@pytest.fixture(scope="module")
def etag(server):
    return server.request("/clip.fvv")["ETag"]


def test_whole_file(server):
    reply = server.request("/clip.fvv")
    assert (reply.status, reply.body) == (200, CONTENT)
    assert reply["Accept-Ranges"] == "bytes" and reply["Content-Type"] == "model/vnd.fvv"
    assert reply["Last-Modified"] == formatdate(1_600_000_000, usegmt=True)
    assert reply["Content-Encoding"] is None and reply["Content-Range"] is None
    assert reply["Cache-Control"] == "no-cache" and reply["X-Content-Type-Options"] == "nosniff"
    assert reply["ETag"].startswith('"'), "a weak tag is of no use to If-Range"
    # RFC 9110 9.3.2: the same header fields, and no content.
    head = server.request("/clip.fvv", "HEAD")
    assert {**head.headers, "date": ""} == {**reply.headers, "date": ""}


# RFC 9110 14.1.2: value, first byte, bytes; or the status where nothing is sent in part.
RANGES = [
    ("bytes=0-0", 0, 1),
    ("bytes=0-499", 0, 500),
    ("bytes=500-999", 500, 500),
    ("bytes=999-999", 999, 1),
    ("bytes=-500", 500, 500),  # suffix
    ("bytes=9-", 9, 991),  # open end
    ("bytes=-1", 999, 1),
    ("bytes=-1000", 0, 1000),
    ("bytes=-2000", 0, 1000),  # longer than the file: all of it
    ("bytes=990-2000", 990, 10),  # an end after the end is cut
    ("bytes=990-99999999999999999999999", 990, 10),
    ("bytes=-99999999999999999999999", 0, 1000),
    ("BYTES=0-1", 0, 2),  # 14.1: units are case-insensitive
    ("bytes= 0-1", 0, 2),
    ("bytes=1000-", 416, 0),
    ("bytes=1000-1001", 416, 0),
    ("bytes=18446744073709551616-", 416, 0),
    ("bytes=-0", 416, 0),
    # 14.2: a field that is not valid, another unit, and several ranges may be ignored.
    ("bytes=2-1", 200, 0),
    ("bytes=-", 200, 0),
    ("bytes=", 200, 0),
    ("bytes", 200, 0),
    ("bytes=a-b", 200, 0),
    ("bytes=1", 200, 0),
    ("bytes=--1", 200, 0),
    ("bytes=+1-2", 200, 0),
    ("bytes=0x1-2", 200, 0),
    ("bytes=1-2-3", 200, 0),
    ("bytes=0-0,2-2", 200, 0),
    ("bytes=0-0,", 200, 0),
    ("lines=0-1", 200, 0),
    ("byte=0-1", 200, 0),
    ("bytes 0-1", 200, 0),
]


@pytest.mark.parametrize("value, first, count", RANGES)
def test_range(server, value, first, count):
    reply = server.request("/clip.fvv", Range=value)
    if not count:
        assert reply.status == first
        assert reply["Content-Range"] == (f"bytes */{SIZE}" if first == 416 else None)
        assert first == 416 or reply.body == CONTENT
        return
    assert (reply.status, reply.body) == (206, CONTENT[first : first + count])
    assert reply["Content-Range"] == f"bytes {first}-{first + count - 1}/{SIZE}"
    assert reply["Content-Length"] == str(count) and reply["ETag"] and reply["Last-Modified"]
    # 14.2: Range means nothing with HEAD.
    assert server.request("/clip.fvv", "HEAD", Range=value)["Content-Length"] == str(SIZE)


def test_range_of_an_empty_file(server):
    assert server.request("/empty.fvv", Range="bytes=0-").status == 416
    # Satisfiable by 14.1.2, but there is no Content-Range for it.
    assert server.request("/empty.fvv", Range="bytes=-5").status == 200
    assert server.request("/empty.fvv").body == b""


def test_conditions(server, etag):
    def status(**headers):
        return server.request("/clip.fvv", **headers).status

    modified = formatdate(1_600_000_000, usegmt=True)
    before, after = formatdate(1_500_000_000, usegmt=True), formatdate(1_700_000_000, usegmt=True)
    part = {"Range": "bytes=0-9"}
    # 13.1.2: weak comparison, lists, *; it wins over the date (13.1.3).
    assert [status(If_None_Match=v) for v in (etag, "W/" + etag, "*", f'"x", {etag}')] == [304] * 4
    assert [status(If_None_Match=v) for v in ('"x"', etag[:-1], etag.strip('"'), '"x"' + etag)] == [200] * 4
    assert status(If_None_Match='"x"', If_Modified_Since=after) == 200
    assert [status(If_Modified_Since=v) for v in (modified, after)] == [304, 304]
    assert [status(If_Modified_Since=v) for v in (before, "yesterday", "2020-09-13")] == [200] * 3
    # 13.1.1 and 13.1.4: strong comparison.
    assert [status(If_Match=v) for v in (etag, "*", "W/" + etag, '"x"')] == [200, 200, 412, 412]
    assert [status(If_Unmodified_Since=v) for v in (modified, after, before)] == [200, 200, 412]
    assert status(If_Match=etag, If_Unmodified_Since=before) == 200
    # 13.2.2: before the range.
    assert status(If_None_Match=etag, **part) == 304
    assert status(If_Match='"x"', **part) == 412
    # 13.1.5: strong tags and the exact date; otherwise the whole file.
    assert [status(If_Range=v, **part) for v in (etag, modified)] == [206, 206]
    others = ("W/" + etag, '"x"', before, after, "x", f"{etag}, {etag}")
    assert [status(If_Range=v, **part) for v in others] == [200] * len(others)
    assert status(If_Range=etag, Range="bytes=5000-") == 416
    assert status(If_Range='"x"', Range="bytes=5000-") == 200
    reply = server.request("/clip.fvv", If_None_Match=etag)
    assert (reply.body, reply["ETag"], reply["Content-Type"]) == (b"", etag, None)


def test_tag_of_a_file_that_changes(server, folder):
    path = folder / "changing.fvv"
    path.write_bytes(b"1")
    first = server.request("/changing.fvv")["ETag"]
    status = path.stat()
    time.sleep(0.02)
    # The same size and the same time: only the clock of the file system knows.
    path.write_bytes(b"2")
    os.utime(path, ns=(status.st_atime_ns, status.st_mtime_ns))
    assert server.request("/changing.fvv", If_None_Match=first).status == 200


# The command line.


@pytest.mark.parametrize(
    "arguments, code, text",
    [
        ([], 2, "--root, --open or --live is required"),
        (["--root", "/nowhere"], 1, "/nowhere: cannot open"),
        (["--root", "{root}/clip.fvv"], 1, "is not a folder"),
        (["--root", "{root}", "--bind", "localhost"], 2, "--bind: expected an address"),
        (["--root", "{root}", "--bind", "192.0.2.1"], 1, "cannot listen"),
        (["--root", "{root}", "--allow-origin", "example.org"], 2, "--allow-origin: expected http"),
        (["--root", "{root}", "--allow-origin", "https://example.org/x"], 2, "--allow-origin: expected http"),
        (["--live", "a/b=x"], 2, "--live: expected NAME=FILE"),
        (["--live", "a="], 2, "--live: expected NAME=FILE"),
        (["--live", "a={root}/clip.fvv", "--live", "a={root}/clip.fvv"], 2, "two streams have the name a"),
        (["--live", "a=-", "--live", "b=-"], 2, "two streams from standard input"),
        (["--live", "a={root}/missing"], 1, "missing: cannot open"),
        (["--live", "a={root}"], 1, "is a folder"),
    ],
)
def test_usage(folder, arguments, code, text):
    command = [tool_path("fvvserve"), "--port", "0", *(a.format(root=folder) for a in arguments)]
    done = subprocess.run(command, capture_output=True, timeout=20)
    assert done.returncode == code and text in done.stderr.decode()


def opened(folder, tmp_path, **environment):
    """What fvvserve --open does with a file outside of the root: the line that it prints, and replies."""
    clip = tmp_path / "my clip & more.fvv"
    clip.write_bytes(b"\x89FVV\r\n\x1a\n" + CONTENT)
    with pytest.MonkeyPatch.context() as patch:
        for name in "DISPLAY", "WAYLAND_DISPLAY":
            patch.delenv(name, raising=False)
        for name, value in environment.items():
            patch.setenv(name, value)
        with Server("--root", folder, "--open", clip) as server:
            targets = "/open/clip.fvv", "/open/my%20clip.fvv", "/open/", "/clip.fvv", "/secret.txt"
            replies = [server.request(target) for target in targets]
            ranged = server.request("/open/clip.fvv", Range="bytes=-4")
            if environment:
                deadline = time.monotonic() + 10
                while not (tmp_path / "shown").exists() and time.monotonic() < deadline:
                    time.sleep(0.05)
    return server, replies, ranged


def test_open_serves_a_file_outside_of_the_root(folder, tmp_path):
    server, replies, ranged = opened(folder, tmp_path)
    assert server.line == f"http://{server.host}/?open=my%20clip%20%26%20more.fvv\n"
    assert [reply.status for reply in replies] == [200, 404, 404, 200, 404]
    assert replies[0].body[8:] == CONTENT and replies[0]["Content-Type"] == "model/vnd.fvv"
    assert (ranged.status, ranged.body) == (206, CONTENT[-4:])


def test_open_shows_the_page_where_there_is_a_screen(folder, tmp_path):
    viewer = tmp_path / "bin/xdg-open"
    viewer.parent.mkdir()
    viewer.write_text(
        f'#!/bin/sh\nprintf %s "$1" >"{tmp_path}/new" && mv "{tmp_path}/new" "{tmp_path}/shown"\n'
    )
    viewer.chmod(0o755)
    server, _, _ = opened(folder, tmp_path, DISPLAY=":7", PATH=f"{viewer.parent}:{os.environ['PATH']}")
    assert (tmp_path / "shown").read_text() + "\n" == server.line


@pytest.mark.parametrize(
    "make, message",
    [
        (lambda path: None, "cannot open: No such file"),
        (lambda path: path.mkdir(), "expected a file"),
        (lambda path: path.write_bytes(b""), "expected an fvv stream"),
        (lambda path: path.write_text("<!doctype html>"), "expected an fvv stream"),
    ],
)
def test_open_refuses_what_is_no_stream(folder, tmp_path, make, message):
    path = tmp_path / "clip.fvv"
    make(path)
    command = [str(tool_path("fvvserve")), "--port", "0", "--root", str(folder), "--open", str(path)]
    found = subprocess.run(command, capture_output=True, text=True, timeout=10)
    assert (found.returncode, found.stdout) == (1, "")
    assert found.stderr.startswith(f"fvvserve: {path}: {message}")


def test_open_without_a_site_says_what_builds_it(tmp_path):
    clip = tmp_path / "clip.fvv"
    clip.write_bytes(b"\x89FVV\r\n\x1a\n")
    tool = tmp_path / "bin/fvvserve"
    tool.parent.mkdir()
    tool.write_bytes(tool_path("fvvserve").read_bytes())
    tool.chmod(0o755)
    command = [str(tool), "--port", "0", "--open", str(clip)]
    found = subprocess.run(command, capture_output=True, text=True, timeout=10)
    assert (
        found.returncode == 1
        and "./run demo builds it; or name the folder of a site with --root" in found.stderr
    )
    site = tmp_path / "share/fvv/site"
    site.mkdir(parents=True)
    (site / "index.html").write_text("")
    with subprocess.Popen(command, stdout=subprocess.PIPE) as process:
        assert process.stdout.readline().endswith(b"/?open=clip.fvv\n")
        process.terminate()
