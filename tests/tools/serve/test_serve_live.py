"""fvvserve: live streams. What a client receives is compared with the chunks that went in, byte for byte."""

import contextlib
import functools
import json
import os
import pathlib
import signal
import subprocess
import time

import pytest
from reference import container
from reference.container import Part, Stream, joined
from reference.mesh import raw_parts
from reference.tiny import TETRAHEDRON
from serve_client import BINARY, CLOSE, PING, PONG, TEXT, Server

FRAMES = 3  # of a group
MESH = joined(raw_parts(TETRAHEDRON))


@pytest.fixture(scope="module", autouse=True)
def quick_crc():
    """Computes the CRC of equal payloads once: in Python it takes a second per MiB."""
    plain, container.crc32c = container.crc32c, functools.lru_cache(maxsize=None)(container.crc32c)
    yield
    container.crc32c = plain


def make(groups, payload=MESH, name="mesh", repeat=False, change_at=None, start=0):
    """A stream as its pieces: [file header, block of group 0, group 0, block or nothing, group 1, ...], index left out."""
    stream = Stream()
    pieces, seen = [stream.data()], stream.size

    def cut():
        nonlocal seen
        # The data from where the last piece ended, without joining everything again.
        sections = [s for s in stream.sections if s.offset >= seen]
        piece, seen = b"".join(joined(s.parts) for s in sections), stream.size
        return piece

    for group in range(groups):
        if group == 0 or repeat or group == change_at:
            stream.scene()
            stream.track(1, 1, "another name" if change_at is not None and group >= change_at else name)
        pieces.append(cut())
        first = start + group * FRAMES
        stream.begin_group(first, first + FRAMES)
        for frame in range(FRAMES):
            part = [Part(payload, "payload", "")]
            stream.chunk("MESH", part, track=1, time=first + frame, key=True)
        stream.end_group()
        pieces.append(cut())
    return pieces


def make_ladder(groups, tracks=(1, 2, 3), payload=MESH):
    """The same of a stream with a mesh at three ranks, or of that with some of its tracks."""
    stream = Stream()
    stream.scene()
    for track in tracks:
        values = {"bit_rate": 1000 * track, "nominal_size": 4}
        # What is alone has no alternatives (clause 5.2).
        if len(tracks) > 1:
            values |= {"alternate_group": 1, "rank": track - 1}
        stream.track(track, 1, f"rung {track - 1}", **values)
    pieces, parts = [], [joined(s.parts) for s in stream.sections]
    pieces += [parts[0], b"".join(parts[1:])]
    for group in range(groups):
        seen = len(stream.sections)
        stream.begin_group(group * FRAMES, (group + 1) * FRAMES)
        for frame in range(FRAMES):
            for track in tracks:
                part = [Part(payload, "payload", "")]
                stream.chunk("MESH", part, track=track, time=group * FRAMES + frame, key=True)
        stream.end_group()
        pieces += [b"".join(joined(s.parts) for s in stream.sections[seen:]), b""]
    return pieces[:-1]


RUNGS = [{"rung": k, "bit_rate": 1000 * (k + 1), "size": 0, "tracks": [k + 1]} for k in range(3)]


def receive_rungs(client):
    kind, payload = client.receive()
    assert kind == TEXT
    assert json.loads(payload) == {"type": "rungs", "time_base": [1, 25], "rungs": RUNGS}


def settle(client):
    """Returns when the server has read all that the client has sent."""
    client.send(PING, b"")
    assert client.receive() == (PONG, b"")


def groups_of(pieces):
    return pieces[2::2]


class Pipe:
    """A server that reads its stream from the test."""

    def __init__(self, *arguments):
        self.server = Server("--live", "now=-", *arguments, stdin=subprocess.PIPE)
        self.port, self.live, self.memory = self.server.port, self.server.live, self.server.memory

    def __enter__(self):
        return self

    def __exit__(self, *error):
        self.close()
        self.server.__exit__(*error)

    def close(self):
        if self.server.process.stdin:
            with contextlib.suppress(BrokenPipeError):
                self.server.process.stdin.close()
        self.server.process.stdin = None  # or communicate() would flush it

    def write(self, *pieces):
        for piece in pieces:
            self.server.process.stdin.write(piece)
        self.server.process.stdin.flush()


def receive_runs(client):
    """[(bytes of a run, what ended it), ...] up to the end of the connection, and the code with which it was closed."""
    runs, run = [], b""
    while (message := client.receive()) is not None:
        kind, payload = message
        if kind == BINARY:
            run += payload
        elif kind == TEXT:
            runs.append((run, json.loads(payload)))
            run = b""
        elif kind == CLOSE:
            return runs, int.from_bytes(payload[:2], "big")
    return runs, None


def receive_bytes(client, size):
    data = b""
    while len(data) < size:
        kind, payload = client.receive()
        assert kind == BINARY, payload
        data += payload
    assert len(data) == size
    return data


def test_join_in_mid_stream(fvvinfo, tmp_path):
    pieces = make(5)
    header, block, *_ = pieces
    groups = groups_of(pieces)
    with Pipe() as pipe, pipe.live("now") as early:
        pipe.write(header, block, groups[0])
        assert receive_bytes(early, len(header + block + groups[0])) == header + block + groups[0]
        half = len(groups[1]) // 2
        pipe.write(groups[1][:half])
        begun = receive_bytes(early, groups[1].index(b"MESH"))  # the server has read up to here
        with pipe.live("now") as late:
            pipe.write(groups[1][half:], groups[2], groups[3])
            late_run = header + block + groups[2] + groups[3]
            assert (
                receive_bytes(late, len(late_run)) == late_run
            ), "from the next group on, configuration first"
            rest = b"".join(groups[1:4])[len(begun) :]
            assert receive_bytes(early, len(rest)) == rest
            # A chunk is sent when it is whole, before its group is.
            cut = len(groups[4]) - 8
            pipe.write(groups[4][:cut])
            before_end = receive_bytes(late, groups[4].index(b"GEND"))
            assert groups[4].startswith(before_end)
            pipe.write(groups[4][cut:])
            pipe.close()
            runs, code = receive_runs(late)
            assert code == 1000 and [end for _, end in runs] == [{"type": "end"}]
            path = tmp_path / "late.fvv"
            path.write_bytes(late_run + before_end + runs[0][0])
            # A reader that joined late accepts any first number (clause 6.1).
            problems = fvvinfo("--check", path).stderr.decode().splitlines()
            assert [line[-10:] for line in problems] == ["[FVV-1205]"], problems
        assert receive_runs(early)[1] == 1000
        assert pipe.live("now").reply.status == 410, "the stream has ended for good"


def test_a_slow_client_skips_whole_groups_and_is_informed():
    pieces = make(110, bytes(100_000))
    start = b"".join(pieces[:2])
    groups = groups_of(pieces)
    with Pipe("--queue", "2") as pipe, pipe.live("now") as good, pipe.live("now", 4096) as slow:
        pipe.write(start)
        for number, group in enumerate(groups[:100]):
            pipe.write(group)
            receive_bytes(good, len(group) + (len(start) if number == 0 else 0))
            if number == 20:
                before = pipe.memory()
        grown = pipe.memory() - before
        assert grown < 12 << 20, f"{grown} bytes more while 24 MB went by"
        # It reads again: what the kernel still holds, the message, and a run that is a stream.
        slow.socket.settimeout(0.3)
        data, skip = b"", None
        for group in groups[100:]:
            with contextlib.suppress(TimeoutError):
                while skip is None:
                    kind, message = slow.receive()
                    if kind == TEXT:
                        skip = json.loads(message)
                    else:
                        data += message
            if skip:
                break
            pipe.write(group)
            receive_bytes(good, len(group))
        assert skip and skip["type"] == "skip"
        assert b"".join(pieces).startswith(data), "nothing is torn before the skip"
        to = int(skip["to"])
        assert to % FRAMES == 0 and int(skip["from"]) < to and skip["chunks"] > 100
        # The bytes received and the bytes reported as missed add up.
        assert len(data) + skip["bytes"] == len(start) + len(b"".join(groups[: to // FRAMES]))
        slow.socket.settimeout(10)
        run = start + groups[to // FRAMES]
        assert receive_bytes(slow, len(run)) == run


def test_file_is_played_in_time_and_again(tmp_path):
    path = tmp_path / "clip.fvv"
    pieces = make(4)  # 12 frames of 40 ms
    path.write_bytes(b"".join(pieces))
    with Server("--live", f"clip={path}") as server:
        time.sleep(0.3)  # without a listener nothing is missed
        for _ in range(2):
            begin = time.monotonic()
            with server.live("clip") as client:
                runs, code = receive_runs(client)
            assert code == 1000 and runs == [(b"".join(pieces), {"type": "end"})]
            assert 0.46 < time.monotonic() - begin < 2.5
    with Server("--live", f"clip={path}", "--loop") as server, server.live("clip") as client:
        assert receive_bytes(client, len(b"".join(pieces))) == b"".join(pieces)
        kind, payload = client.receive()
        assert (kind, json.loads(payload)) == (TEXT, {"type": "restart"})
        assert receive_bytes(client, len(b"".join(pieces))) == b"".join(pieces)


def test_configuration_that_changes_or_is_repeated():
    for pieces in make(4, repeat=True), make(4, change_at=2):
        with Pipe() as pipe, pipe.live("now") as early:
            pipe.write(*pieces[:5])
            receive_bytes(early, len(b"".join(pieces[:5])))
            with pipe.live("now") as late:
                pipe.write(*pieces[5:])
                pipe.close()
                block = pieces[5] or pieces[1]
                assert receive_runs(late)[0][0][0] == pieces[0] + block + b"".join(pieces[6:])
            assert receive_runs(early)[0][0][0] == b"".join(pieces[5:])


def test_damage_is_reported_and_the_next_group_opens_a_run():
    pieces = make(5)
    header, block, *_ = pieces
    groups = groups_of(pieces)
    spoilt = bytearray(groups[1])
    spoilt[spoilt.index(MESH)] ^= 1
    with Pipe() as pipe, pipe.live("now") as client:
        pipe.write(header, block, groups[0], bytes(spoilt), groups[2], b"garbage", *groups[3:])
        pipe.close()
        runs, code = receive_runs(client)
    assert code == 1000
    assert [end["type"] for _, end in runs] == ["damage", "damage", "end"]
    assert "CRC of the payload does not match [FVV-1103]" in runs[0][1]["message"]
    first = header + block + groups[0]
    assert runs[0][0].startswith(first) and (first + groups[1]).startswith(runs[0][0])
    assert runs[1][0] == header + block + groups[2]
    assert runs[2][0] == header + block + groups[3] + groups[4]
    assert "fvvserve: warning: /live/now: -: 0x" in pipe.server.stderr


def test_a_client_takes_a_rung_and_changes_it():
    whole, alone = make_ladder(4), [make_ladder(4, tracks=[track]) for track in (1, 2, 3)]
    groups = [groups_of(pieces) for pieces in alone]
    with Pipe() as pipe, pipe.live("now") as all_of_it, pipe.live("now?x=1&rung=1") as client:
        with pipe.live("now?rung=65535") as lowest:
            pipe.write(*whole[:3])
            receive_rungs(client)
            first = b"".join(alone[1][:3])
            assert receive_bytes(client, len(first)) == first, "as if the stream had no other track"
            receive_rungs(lowest)
            assert receive_bytes(lowest, len(b"".join(alone[2][:3]))) == b"".join(alone[2][:3])
        assert receive_bytes(all_of_it, len(b"".join(whole[:3]))) == b"".join(whole[:3])
        client.send(TEXT, b'{"type":"rung","rung":0}')
        settle(client)
        half = whole[4].index(b"MESH") + 8  # the wish comes in the middle of a group, and waits for the next
        pipe.write(whole[4][:half])
        kind, payload = client.receive()
        assert (kind, payload) == (BINARY, alone[0][1]), "the block, in the same run"
        begun = receive_bytes(client, groups[0][1].index(b"MESH"))
        client.send(TEXT, b'{"type":"rung","rung":2,"more":[]}')
        all_of_it.send(TEXT, b'{"type":"rung","rung":1}')
        settle(client)
        receive_bytes(all_of_it, len(begun))
        settle(all_of_it)
        pipe.write(whole[4][half:], *whole[5:])
        rest = groups[0][1][len(begun) :] + alone[2][1] + groups[2][2] + groups[2][3]
        assert receive_bytes(client, len(rest)) == rest
        assert receive_bytes(all_of_it, len(whole[4]) - len(begun)) == whole[4][len(begun) :]
        receive_rungs(all_of_it)
        run = b"".join(alone[1][:2]) + groups[1][2] + groups[1][3]
        assert receive_bytes(all_of_it, len(run)) == run
        pipe.close()
        for one in client, all_of_it:
            assert receive_runs(one) == ([(b"", {"type": "end"})], 1000)


def test_a_client_that_asks_gets_a_pong_in_the_middle_of_a_run():
    pieces = make(2)
    with Pipe() as pipe, pipe.live("now") as client:
        client.send(TEXT, b'{"type":"ping"}')
        assert client.receive() == (TEXT, b'{"type":"pong"}'), "also before there is anything to send"
        pipe.write(*pieces[:3])
        assert receive_bytes(client, len(b"".join(pieces[:3]))) == b"".join(pieces[:3])
        client.send(TEXT, b'{"type":"ping","n":[1]}')
        assert client.receive() == (TEXT, b'{"type":"pong"}')
        pipe.write(pieces[3])
        assert receive_bytes(client, len(pieces[3])) == pieces[3], "the run goes on"


def test_wishes_that_are_none():
    whole, alone = make_ladder(2), make_ladder(2, tracks=[2])
    wrong = [
        b"",
        b"x",
        b"null",
        b"[]",
        b'"rung"',
        b'{"type":"rung"}',
        b'{"rung":0}',
        b"[" * 4000,
        b'{"a":' * 600,
    ]
    wrong += [
        b'{"type":"rung","rung":%s}' % n for n in (b"-1", b"65536", b"0.5", b'"0"', b"null", b"1e99", b"[0]")
    ]
    with Pipe() as pipe, pipe.live("now?rung=1") as client:
        for number in "", "-1", "65536", "1x", "0x1", "+1", "%31", "9" * 30, "1&rung=x":
            assert pipe.live(f"now?rung={number}").reply.status == 400
        pipe.write(*whole[:3])
        receive_rungs(client)
        receive_bytes(client, len(b"".join(alone[:3])))
        for text in wrong:
            client.send(TEXT, text)
        client.send(BINARY, b'{"type":"rung","rung":0}')
        settle(client)
        pipe.write(whole[4])
        assert receive_bytes(client, len(alone[4])) == alone[4]


def test_damage_in_a_rung_and_a_ladder_that_changes():
    whole, alone = make_ladder(4), make_ladder(4, tracks=[3])
    spoilt = bytearray(whole[4])
    spoilt[spoilt.index(MESH)] ^= 1
    other = make(1, start=4 * FRAMES)
    with Pipe() as pipe, pipe.live("now?rung=2") as client:
        pipe.write(*whole[:4], bytes(spoilt), *whole[6:])
        pipe.close()
        runs, code = receive_runs(client)
    assert code == 1000 and [end["type"] for _, end in runs] == ["rungs", "damage", "end"]
    first = b"".join(alone[:3])
    assert runs[1][0].startswith(first) and (first + alone[4]).startswith(runs[1][0])
    assert runs[2][0] == b"".join(alone[:2]) + alone[6] + alone[8]
    # Of a stream without a ladder each rung is the stream.
    with Pipe() as pipe, pipe.live("now?rung=2") as client:
        pipe.write(*other)
        pipe.close()
        runs, _ = receive_runs(client)
    assert runs[0][1]["rungs"] == [{"rung": 0, "bit_rate": 0, "size": 0, "tracks": [1]}]
    assert runs[1] == (b"".join(other), {"type": "end"})


def test_a_slow_client_of_a_rung():
    whole, alone = (make_ladder(60, tracks, bytes(100_000)) for tracks in [(1, 2, 3), (2,)])
    start = b"".join(alone[:2])
    with Pipe("--queue", "1") as pipe, pipe.live("now?rung=1") as good, pipe.live("now?rung=1", 4096) as slow:
        for number, piece in enumerate(whole):
            pipe.write(piece)
            if number == 2:
                receive_rungs(good)
                receive_bytes(good, len(start))
            if number % 2 == 0 and number:
                receive_bytes(good, len(alone[number]))
        pipe.close()
        runs, code = receive_runs(slow)
    ends = [end["type"] for _, end in runs]
    assert code == 1000 and ends[0] == "rungs" and "skip" in ends
    groups = groups_of(alone)
    for (data, _), (_, before) in zip(runs[1:], runs):
        if before["type"] == "skip" and data:
            first = int(before["to"]) // FRAMES
            assert (start + b"".join(groups[first:])).startswith(data)


def test_input_that_is_not_a_stream():
    with Pipe() as pipe, pipe.live("now") as client:
        pipe.write(b"this is no stream, and long enough to be sure of it")
        runs, code = receive_runs(client)
        assert code == 1000 and runs[0][1]["type"] == "error" and "FVV-1001" in runs[0][1]["message"]
    with Server("--live", f"x={os.devnull}", stdin=None) as server:
        assert server.request("/live/x").status in (410, 426)


def test_growing_file(tmp_path):
    path = tmp_path / "growing.fvv"
    pieces = make(4)
    with open(path, "wb", buffering=0) as file:
        file.write(b"".join(pieces[:3]))
        with Server("--live", f"now={path}", "--follow") as server, server.live("now") as client:
            time.sleep(0.2)
            file.write(b"".join(pieces[3:5]))
            run = b"".join(pieces[:2]) + pieces[4]
            assert receive_bytes(client, len(run)) == run, "what was there before is not sent"
            file.write(b"".join(pieces[5:7]))
            assert receive_bytes(client, len(pieces[6])) == pieces[6]


def test_fifo_has_one_writer_after_another(tmp_path):
    path = tmp_path / "fifo"
    os.mkfifo(path)
    with Server("--live", f"now={path}") as server, server.live("now") as client:
        for number in range(2):
            pieces = make(2, name=f"writer {number}")
            path.write_bytes(b"".join(pieces))
            kind, _ = client.receive()
            assert kind == BINARY
            while client.receive()[0] == BINARY:
                pass
            if number == 0:
                assert client.receive()[0] == CLOSE
                client = server.live("now")


@pytest.mark.parametrize(
    "bad",
    [b"", b"this is no stream, and long enough to be sure of it" * 5000, "cut"],
    ids=["nothing", "noise", "cut"],
)
def test_a_bad_writer_does_not_end_the_channel(bad, tmp_path):
    """It dies before its first byte, sends something else, or is cut within its header: the next one is served."""
    path = tmp_path / "fifo"
    os.mkfifo(path)
    pieces = make(2)
    with Server("--live", f"now={path}") as server, server.live("now") as client:
        path.write_bytes(pieces[0][:10] if bad == "cut" else bad)
        if bad:
            kind, message = client.receive()
            assert kind == TEXT and json.loads(message)["type"] == "error"
            assert client.receive()[0] == CLOSE
            client = server.live("now")
            assert client.reply.status == 101
        time.sleep(1)  # writers that follow at once are one writer for the reader of a FIFO
        path.write_bytes(b"".join(pieces))
        run = b"".join(pieces)
        assert receive_bytes(client, len(run)) == run
    warnings = [line for line in server.stderr.splitlines() if "warning" in line]
    assert len(warnings) == 1 and "fifo" in warnings[0], server.stderr


def test_a_damaged_file_that_is_played_again_and_again(tmp_path):
    """Without a pause, it took a processor and wrote 11 MB of warnings a second."""
    path = tmp_path / "cut.fvv"
    path.write_bytes(b"".join(make(2))[:300])
    seconds = 3
    with Server("--live", f"now={path}", "--loop") as server, server.live("now"):
        time.sleep(seconds)
        stat = pathlib.Path(f"/proc/{server.process.pid}/stat").read_text()
        ticks = sum(map(int, stat.rpartition(")")[2].split()[11:13]))
        assert ticks / os.sysconf("SC_CLK_TCK") < 0.5
    warnings = [line for line in server.stderr.splitlines() if "warning" in line]
    assert 1 <= len(warnings) <= seconds + 2, server.stderr[:1000]


def test_many_warnings_are_few_lines():
    """A pipe with a damaged chunk in each of 2000 groups: what is not shown is counted."""
    pieces = make(2000)
    for i in range(2, len(pieces), 2):
        pieces[i] = pieces[i][:100] + bytes([pieces[i][100] ^ 1]) + pieces[i][101:]
    with Pipe() as pipe, pipe.live("now") as client:
        pipe.write(*pieces)
        pipe.close()
        receive_runs(client)
    warnings = [line for line in pipe.server.stderr.splitlines() if "warning" in line]
    assert 10 <= len(warnings) < 100, len(warnings)


def test_origins(tmp_path):
    path = tmp_path / "clip.fvv"
    path.write_bytes(b"".join(make(1)))
    with Server("--live", f"clip={path}", "--allow-origin", "https://player.example") as server:

        def status(**headers):
            client = server.live("clip", **headers)
            client.close()
            return client.reply.status

        same = f"http://{server.host}"
        assert [status(Origin=o) for o in (same, "https://player.example", "HTTPS://PLAYER.EXAMPLE")] == [
            101
        ] * 3
        assert status() == 101, "programs that are no browsers send none"
        bad = ["https://evil.example", "null", f"https://{server.host}", f"http://localhost:{server.port}"]
        bad += [
            same + ".evil.example",
            "https://player.example.evil",
            "http://player.example",
            f"{same}/",
            "x",
        ]
        assert [status(Origin=origin) for origin in bad] == [403] * len(bad)
        assert status(Host="evil.example", Origin="http://evil.example") == 421, "DNS rebinding"
        assert server.request("/live/clip").status == 426
        assert [server.live(name).reply.status for name in ("other", "", "../clip", "clip/")] == [404] * 4


def test_inbound_messages(tmp_path):
    path = tmp_path / "clip.fvv"
    path.write_bytes(b"".join(make(1)))
    with Server("--live", f"clip={path}", "--loop") as server:
        with server.live("clip") as client:
            client.send(BINARY, bytes(4096))
            client.send(TEXT, b"anything")
            client.send(BINARY, bytes(4097))
            codes = [int.from_bytes(m[1][:2], "big") for m in iter(client.receive, None) if m[0] == CLOSE]
            assert codes == [1009]
        with server.live("clip") as client:
            client.socket.sendall(b"\x82\xff" + (1 << 60).to_bytes(8, "big") + bytes(4))
            codes = [int.from_bytes(m[1][:2], "big") for m in iter(client.receive, None) if m[0] == CLOSE]
            assert codes == [1009], "a length that no memory has"
        with server.live("clip") as client:
            client.socket.sendall(b"\x82\x05hello")  # without a mask: RFC 6455 5.1
            assert client.receive()[0] in (BINARY, CLOSE, TEXT)
        assert server.request("/live/clip").status == 426, "still there"


def test_a_silent_client_is_disconnected():
    with Pipe("--idle-timeout", "0.6") as pipe, pipe.live("now") as lively, pipe.live("now") as silent:
        begin = time.monotonic()
        lively.socket.settimeout(0.2)
        while time.monotonic() - begin < 1.5:
            with contextlib.suppress(TimeoutError):
                assert lively.receive() is not None, "answers its pings"
        data = b"".join(iter(lambda: silent.socket.recv(4096), b""))
        assert data[:1] == b"\x89", "a ping, and then the end"


def test_200_clients():
    pieces = make(2, bytes(20_000))
    whole = b"".join(pieces)
    with Pipe() as pipe, contextlib.ExitStack() as stack:
        clients = [stack.enter_context(pipe.live("now")) for _ in range(200)]
        pipe.write(whole)
        for client in clients:
            assert receive_bytes(client, len(whole)) == whole
        pipe.close()
        assert [receive_runs(client) for client in clients] == [([(b"", {"type": "end"})], 1000)] * 200


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT])
def test_a_signal_tells_clients_to_come_back(tmp_path, number):
    path = tmp_path / "clip.fvv"
    path.write_bytes(b"".join(make(1)))
    with Server("--live", f"clip={path}", "--loop") as server, server.live("clip") as client:
        client.receive()
        server.process.send_signal(number)
        runs, code = receive_runs(client)
        assert code == 1012 and runs[-1][1] == {"type": "restarting"}
