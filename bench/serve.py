"""fvvserve under load: replies for a file, and a live stream to many viewers, some of which do not read.

The clients are one Python process on the server's machine, so the figures are lower bounds.
"""

import base64
import contextlib
import os
import re
import selectors
import shutil
import socket
import struct
import subprocess
import time

FILE_SIZE = 546_000  # of a frame of the paper's clip
VIEWERS, STALLED = 200, 20
SECONDS = 4
LATE = 0.040  # one frame at 25 Hz


@contextlib.contextmanager
def running(command, port=None):
    """A server process, and its port: given, or read from its first line."""
    process = subprocess.Popen([str(part) for part in command], stdout=subprocess.PIPE)
    try:
        if port is None:
            port = int(re.search(rb":(\d+)/", process.stdout.readline())[1])
        yield port, process.pid
    finally:
        process.terminate()
        process.wait()


def connect(port, receive_buffer=None):
    for _ in range(100):
        client = socket.socket()
        if receive_buffer:
            client.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, receive_buffer)
        with contextlib.suppress(ConnectionRefusedError):
            client.connect(("127.0.0.1", port))
            return client
        client.close()
        time.sleep(0.02)
    raise ConnectionRefusedError(f"no server on port {port}")


def replies_per_second(port, path, connections=4):
    request = f"GET {path} HTTP/1.1\r\nHost: localhost\r\n\r\n".encode()
    room, count, left = bytearray(1 << 20), 0, {}
    with selectors.DefaultSelector() as selector, contextlib.ExitStack() as stack:
        for _ in range(connections):
            client = stack.enter_context(connect(port))
            client.sendall(request)
            left[client] = None
            selector.register(client, selectors.EVENT_READ)
        begin = time.perf_counter()
        while (now := time.perf_counter()) < begin + SECONDS:
            for key, _ in selector.select(1):
                client = key.fileobj
                size = client.recv_into(room)
                if left[client] is None:
                    head = room.index(b"\r\n\r\n") + 4
                    assert room.startswith(b"HTTP/1.1 200")
                    left[client] = FILE_SIZE + head
                left[client] -= size
                if left[client] == 0:
                    count += 1
                    left[client] = None
                    client.sendall(request)
        return count / (now - begin)


class Viewer:
    """Notes when each frame arrived; reads only the headers of messages and chunks."""

    def __init__(self, port, receive_buffer=None):
        self.socket = connect(port, receive_buffer)
        key = base64.b64encode(os.urandom(16)).decode()
        self.socket.sendall(
            "GET /live/clip HTTP/1.1\r\nHost: localhost\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
            f"Sec-WebSocket-Key: {key}\r\nSec-WebSocket-Version: 13\r\n\r\n".encode()
        )
        self.seen, self.rest, self.skip, self.round = [], b"", 0, 0
        head = b""
        while not head.endswith(b"\r\n\r\n"):
            head += self.socket.recv(1)

    def read(self, room):
        size, now, at = self.socket.recv_into(room), time.perf_counter(), 0
        if self.rest:
            room[:size] = self.rest + room[:size]
            size, self.rest = size + len(self.rest), b""
        while True:
            step = min(self.skip, size - at)
            at, self.skip = at + step, self.skip - step
            if size - at < 26:  # the longest message header, and a chunk header up to its time
                self.rest = bytes(room[at:size])
                return
            kind, length, begin = room[at] & 15, room[at + 1], 2
            if length > 125:
                begin = 4 if length == 126 else 10
                length = int.from_bytes(room[at + 2 : at + begin], "big")
            self.skip = begin + length
            if kind == 1:
                self.round += 1  # a viewer that keeps up gets no other message
            elif room[at + begin : at + begin + 4] in (b"MESH", b"VPKT"):
                self.seen.append((self.round, struct.unpack_from("<q", room, at + begin + 8)[0], now))


def peak_memory(pid):
    with open(f"/proc/{pid}/status") as status:
        return int(re.search(r"VmHWM:\s+(\d+) kB", status.read())[1]) / 1024


def live(tool, stream):
    """Delays relative to the earliest chunk, by time stamps; the whole stream has one time line."""
    room = bytearray(1 << 20)
    with running([tool, "--port", "0", "--live", f"clip={stream}", "--loop"]) as (port, pid):
        viewers = [Viewer(port, 4096 if i < STALLED else None) for i in range(VIEWERS)]
        with selectors.DefaultSelector() as selector:
            for viewer in viewers[STALLED:]:
                selector.register(viewer.socket, selectors.EVENT_READ, viewer)
            end = time.perf_counter() + 2 * SECONDS
            while time.perf_counter() < end:
                for key, _ in selector.select(0.1):
                    key.data.read(room)
        memory = peak_memory(pid)
    frames = list(frames_in_one_count(viewers[STALLED:]))
    length = max(frame for _, frame, _ in frames) + 1
    offsets = sorted(now - (turn * length + frame) / 25 for turn, frame, now in frames)
    late = [offset - offsets[0] for offset in offsets]
    return {
        "serve.viewers": VIEWERS,
        "serve.on_time_percent": 100 * sum(value <= LATE for value in late) / len(late),
        "serve.lateness_p99_ms": 1000 * late[len(late) * 99 // 100],
        "serve.peak_rss_mib": memory,
    }


def frames_in_one_count(viewers):
    """Rounds are counted from a viewer's first message: a viewer that joined in the second round has one fewer."""
    last = max(viewer.round for viewer in viewers)
    for viewer in viewers:
        for turn, frame, now in viewer.seen:
            yield turn + last - viewer.round, frame, now


def static(tool, work):
    folder = work / "serve"
    folder.mkdir(exist_ok=True)
    (folder / "file.bin").write_bytes(os.urandom(FILE_SIZE))
    with running([tool, "--port", "0", "--root", folder]) as (port, _):
        figures = {"serve.replies_per_s": replies_per_second(port, "/file.bin")}
    nginx = shutil.which("nginx")
    if nginx:
        # A port that was free a moment ago.
        with socket.create_server(("127.0.0.1", 0)) as free:
            port = free.getsockname()[1]
        text = f"""daemon off; worker_processes 1; pid {folder}/pid; error_log stderr;
events {{}} http {{ access_log off; sendfile on; keepalive_requests 1000000;
server {{ listen 127.0.0.1:{port}; root {folder}; }} }}"""
        (folder / "nginx.conf").write_text(text)
        with running([nginx, "-c", folder / "nginx.conf", "-p", folder], port):
            figures["serve.nginx_replies_per_s"] = replies_per_second(port, "/file.bin")
    return figures


def measure(tool, work, stream):
    return static(tool, work) | live(tool, stream)
