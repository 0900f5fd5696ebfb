"""fvvserve: ranges and conditions, against the text of RFC 9110."""

import os
import time
from email.utils import formatdate

import pytest
from serve_client import CONTENT, SIZE, Server, make_site


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return make_site(tmp_path_factory.mktemp("serve"))


@pytest.fixture(scope="module")
def server(folder):
    with Server("--root", folder) as server:
        yield server


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
    ("bytes=990-2000", 990, 10),  # an end behind the end is cut
    ("bytes=990-99999999999999999999999", 990, 10),
    ("bytes=-99999999999999999999999", 0, 1000),
    ("BYTES=0-1", 0, 2),  # 14.1: units are case-insensitive
    ("bytes= 0-1", 0, 2),
    ("bytes=1000-", 416, 0),
    ("bytes=1000-1001", 416, 0),
    ("bytes=18446744073709551616-", 416, 0),
    ("bytes=-0", 416, 0),
    # 14.2: a field that is not valid, another unit, and several ranges may be passed over.
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
    before, behind = formatdate(1_500_000_000, usegmt=True), formatdate(1_700_000_000, usegmt=True)
    part = {"Range": "bytes=0-9"}
    # 13.1.2: weak comparison, lists, *; it wins over the date (13.1.3).
    assert [status(If_None_Match=v) for v in (etag, "W/" + etag, "*", f'"x", {etag}')] == [304] * 4
    assert [status(If_None_Match=v) for v in ('"x"', etag[:-1], etag.strip('"'), '"x"' + etag)] == [200] * 4
    assert status(If_None_Match='"x"', If_Modified_Since=behind) == 200
    assert [status(If_Modified_Since=v) for v in (modified, behind)] == [304, 304]
    assert [status(If_Modified_Since=v) for v in (before, "yesterday", "2020-09-13")] == [200] * 3
    # 13.1.1 and 13.1.4: strong comparison.
    assert [status(If_Match=v) for v in (etag, "*", "W/" + etag, '"x"')] == [200, 200, 412, 412]
    assert [status(If_Unmodified_Since=v) for v in (modified, behind, before)] == [200, 200, 412]
    assert status(If_Match=etag, If_Unmodified_Since=before) == 200
    # 13.2.2: before the range.
    assert status(If_None_Match=etag, **part) == 304
    assert status(If_Match='"x"', **part) == 412
    # 13.1.5: strong tags and the very date; else the whole.
    assert [status(If_Range=v, **part) for v in (etag, modified)] == [206, 206]
    others = ("W/" + etag, '"x"', before, behind, "x", f"{etag}, {etag}")
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
