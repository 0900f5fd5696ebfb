"""A running fvvserve, and as much HTTP and WebSocket as its tests need, written out so that a test controls every byte."""

import base64
import contextlib
import hashlib
import io
import os
import re
import signal
import socket
import struct
import subprocess

from conftest import tool_path

TEXT, BINARY, CLOSE, PING, PONG = 1, 2, 8, 9, 10
SIZE = 1000
CONTENT = bytes(i * 7 % 251 for i in range(SIZE))
SECRET = b"not for readers"


def make_site(base):
    """A folder to serve, with public and secret files in it and beside it."""
    root = base / "root"
    (root / "sub").mkdir(parents=True)
    (base / "rootless").mkdir()
    for path in base / "secret.txt", base / "rootless/secret.txt", root / ".hidden", root / "sub/.hidden":
        path.write_bytes(SECRET)
    (root / "clip.fvv").write_bytes(CONTENT)
    (root / "empty.fvv").write_bytes(b"")
    (root / "page.html").write_text("<p>page")
    (root / "sub/index.html").write_text("<p>index")
    (root / "decoder.wasm").write_bytes(b"\0asm")
    (root / "with space.js").write_text("0")
    (root / "inside.fvv").symlink_to("clip.fvv")
    (root / "out").symlink_to("../secret.txt")
    (root / "outside").symlink_to("..")
    (root / "veiled").symlink_to(".hidden")
    (root / "nothing").mkdir()
    os.mkfifo(root / "fifo")
    os.utime(root / "clip.fvv", (1_600_000_000, 1_600_000_000))
    return root


class Reply:
    def __init__(self, status, headers, body):
        self.status, self.headers, self.body = status, headers, body

    def __getitem__(self, name):
        return self.headers.get(name.lower())


class Server:
    """fvvserve on a port that the system chose. Ends with the block, and has to end cleanly."""

    def __init__(self, *arguments, stdin=subprocess.DEVNULL, before=None):
        command = [str(tool_path("fvvserve")), "--port", "0", "--verbose", *map(str, arguments)]
        pipe = subprocess.PIPE
        # Freed memory that AddressSanitizer keeps would hide the server's own.
        environment = {"ASAN_OPTIONS": "quarantine_size_mb=1"} | os.environ
        self.process = subprocess.Popen(
            command, stdin=stdin, stdout=pipe, stderr=pipe, env=environment, preexec_fn=before
        )
        self.line = self.process.stdout.readline().decode()
        found = re.search(r":(\d+)/", self.line)
        assert found, self.line + self.process.stderr.read().decode()
        self.port = int(found[1])
        self.host = f"127.0.0.1:{self.port}"
        self.stderr = ""

    def __enter__(self):
        return self

    def __exit__(self, *error):
        if self.process.poll() is None:
            self.process.send_signal(signal.SIGTERM)
        try:
            self.stderr = self.process.communicate(timeout=10)[1].decode()
        finally:
            self.process.kill()
        # A sanitizer that finds a fault gives another code.
        assert self.process.returncode == 0, self.stderr

    def memory(self):
        """Resident bytes."""
        with open(f"/proc/{self.process.pid}/status") as status:
            return int(re.search(r"VmRSS:\s+(\d+) kB", status.read())[1]) * 1024

    def connect(self, receive_buffer=None):
        connection = socket.socket()
        if receive_buffer:
            connection.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, receive_buffer)
        connection.settimeout(10)
        connection.connect(("127.0.0.1", self.port))
        return connection

    def raw(self, request, head=False):
        """Sends bytes and returns the reply."""
        with contextlib.closing(self.connect()) as connection:
            connection.sendall(request)
            return read_reply(connection.makefile("rb"), head)

    def request(self, target, method="GET", **headers):
        """Keywords are header fields, with _ for -; None leaves one out."""
        fields = {"Host": self.host} | {name.replace("_", "-"): value for name, value in headers.items()}
        lines = [f"{method} {target} HTTP/1.1"]
        lines += [f"{name}: {value}" for name, value in fields.items() if value is not None]
        return self.raw("\r\n".join([*lines, "", ""]).encode("latin-1"), method == "HEAD")

    def live(self, name, receive_buffer=None, **headers):
        return Live(self.connect(receive_buffer), name, {"Host": self.host} | headers)


def read_reply(stream, head=False):
    status = stream.readline().decode("latin-1")
    assert re.fullmatch(r"HTTP/1\.1 \d{3} [^\r]*\r\n", status), status
    headers = {}
    while (line := stream.readline().decode("latin-1")) != "\r\n":
        name, value = line.rstrip("\r\n").split(": ", 1)
        assert name.lower() not in headers, "a header field came twice"
        headers[name.lower()] = value
    body = b"" if head else stream.read(int(headers.get("content-length", 0)))
    return Reply(int(status.split()[1]), headers, body)


class Live:
    """The client of a WebSocket (RFC 6455)."""

    def __init__(self, connection, name, headers):
        self.socket, self.buffer = connection, b""
        key = base64.b64encode(os.urandom(16)).decode()
        lines = [f"GET /live/{name} HTTP/1.1", "Upgrade: websocket", "Connection: Upgrade"]
        lines += [f"Sec-WebSocket-Key: {key}", "Sec-WebSocket-Version: 13"]
        lines += [f"{name}: {value}" for name, value in headers.items()]
        connection.sendall("\r\n".join([*lines, "", ""]).encode())
        # Byte by byte, so that no byte after the header is read.
        while not self.buffer.endswith(b"\r\n\r\n"):
            self.buffer += connection.recv(1)
        self.reply = read_reply(io.BytesIO(self.buffer), head=True)
        self.buffer = b""
        if self.reply.status == 101:
            wanted = hashlib.sha1((key + "258EAFA5-E914-47DA-95CA-C5AB0DC85B11").encode()).digest()
            assert self.reply["Sec-WebSocket-Accept"] == base64.b64encode(wanted).decode()

    def __enter__(self):
        assert self.reply.status == 101
        return self

    def __exit__(self, *error):
        self.close()

    def close(self):
        self.socket.close()

    def send(self, kind, payload):
        size = bytes([0x80 | len(payload)]) if len(payload) < 126 else struct.pack(">BH", 0xFE, len(payload))
        self.socket.sendall(bytes([0x80 | kind]) + size + bytes(4) + payload)  # a mask of zeros

    def fill(self, size):
        """Fills the buffer to a size and returns whether that worked. A timeout leaves what is there."""
        while len(self.buffer) < size:
            try:
                data = self.socket.recv(1 << 20)
            except ConnectionResetError:
                return False
            if not data:
                return False
            self.buffer += data
        return True

    def receive(self):
        """Returns (kind, payload) of a whole message and answers pings. None: the connection is gone."""
        while self.fill(2):
            kind, size, begin = self.buffer[0] & 15, self.buffer[1], 2
            assert self.buffer[0] & 0xF0 == 0x80 and size < 128, "one whole unmasked frame"
            if size > 125:
                begin += 2 if size == 126 else 8
                if not self.fill(begin):
                    return None
                size = int.from_bytes(self.buffer[2:begin], "big")
            if not self.fill(begin + size):
                return None
            payload = self.buffer[begin : begin + size]
            self.buffer = self.buffer[begin + size :]
            if kind != PING:
                return kind, payload
            self.send(PONG, payload)
        return None
