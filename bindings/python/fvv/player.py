"""The player for browsers: in a notebook, with a clip inside the page, or served to this computer."""

from __future__ import annotations

import base64
import gzip
import html
import http.server
import os
import re
import secrets
import threading
from typing import Any, cast
from urllib.parse import urlsplit

from ._core import Stream
from .errors import Error, UsageError

#: Bytes of clips that are put into a page. They are a third more there, and a notebook keeps them.
INLINE_LIMIT = 64 << 20
#: Written by js/player/bundle.mjs.
SCRIPT = os.path.join(os.path.dirname(__file__), "player.js.gz")
BLOCK = 1 << 20
LOOK = "html, body { margin: 0; environment: #fff; } fvv-player { width: 100%; }"

SERVED = """<!doctype html>
<meta charset="utf-8" />
<meta name="viewport" content="width=device-width, initial-scale=1" />
<title>{title}</title>
<link rel="icon" href="data:," />
<style>{look}</style>
<script type="module" src="player.js"></script>
<fvv-player src="clip.fvv" worker="player.js" controls autoplay loop></fvv-player>
"""

# The script is compressed; nothing in Base64 ends an element or an attribute.
INLINE = """<!doctype html>
<meta charset="utf-8" />
<title>{title}</title>
<style>{look}</style>
<script type="text/plain" id="script">{script}</script>
<script type="text/plain" id="clip">{clip}</script>
<script type="module">
  const bytes = (id) => Uint8Array.from(atob(document.getElementById(id).textContent), (c) => c.charCodeAt(0));
  const unpacked = new Blob([bytes("script")]).stream().pipeThrough(new DecompressionStream("gzip"));
  const script = new Blob([await new Response(unpacked).blob()], {{ type: "text/javascript" }});
  const url = URL.createObjectURL(script);
  await import(url);
  const player = document.createElement("fvv-player");
  for (const [name, value] of Object.entries({{ worker: url, controls: "", autoplay: "", loop: "" }}))
    player.setAttribute(name, value);
  player.srcObject = new Blob([bytes("clip")]);
  document.body.append(player);
</script>
"""


def script_of(path: str | None) -> bytes:
    """The player and its decoder, one script, compressed by gzip. path: None for the package's own; it need not be compressed.
    `UsageError`: the package was built without. OSError."""
    if path is None and not os.path.exists(SCRIPT):
        raise UsageError(
            "this package was built without the player: write one with js/player/bundle.mjs and pass player=PATH"
        )
    with open(path or SCRIPT, "rb") as file:
        content = file.read()
    return content if content.startswith(b"\x1f\x8b") else gzip.compress(content, 9, mtime=0)


def page(stream: Stream, title: str, script: bytes) -> str:
    """A whole page with the player and the stream in it. `UsageError`: the stream is larger than INLINE_LIMIT."""
    if stream.byte_count > INLINE_LIMIT:
        raise UsageError(
            f"{title}: {stream.byte_count} bytes do not fit into a page, which holds {INLINE_LIMIT}: pass inline=False"
        )
    return INLINE.format(
        title=html.escape(title),
        look=LOOK,
        script=base64.b64encode(script).decode(),
        clip=base64.b64encode(stream.read_at(0, stream.byte_count)).decode(),
    )


class Player:
    """What a notebook shows of a clip. A clip that is served plays as long as it is open; one inside the page always."""

    def __init__(self, source: str, width: str, url: str | None) -> None:
        self._source, self._width = source, width
        #: Where the page is served; None: it is in the notebook.
        self.url = url

    def _repr_html_(self) -> str:
        return (
            f'<iframe {self._source} style="width: {self._width}; aspect-ratio: 16 / 9; border: 0" '
            'allow="autoplay; fullscreen; xr-spatial-tracking"></iframe>'
        )

    def __repr__(self) -> str:
        return f"<fvv.Player {self.url or 'with the clip in the page'}>"


def inline_player(stream: Stream, title: str, width: str, script: bytes) -> Player:
    """A player with the stream in the page."""
    return Player(f'srcdoc="{html.escape(page(stream, title, script))}"', width, None)


class _Handler(http.server.BaseHTTPRequestHandler):
    protocol_version = "HTTP/1.1"

    @property
    def _listener(self) -> _Listener:
        return cast(_Listener, self.server)

    def do_GET(self) -> None:
        self._reply(with_body=True)

    def do_HEAD(self) -> None:
        self._reply(with_body=False)

    def _reply(self, with_body: bool) -> None:
        folder, _, name = urlsplit(self.path).path[1:].partition("/")
        if not secrets.compare_digest(folder.encode(), self._listener.token.encode()):
            self.send_error(404)
        elif name == "clip.fvv":
            self._reply_with_clip(with_body)
        elif name in self._listener.pages:
            kind, content, coding = self._listener.pages[name]
            self._begin(200, kind, len(content), **coding)
            if with_body:
                self.wfile.write(content)
        else:
            self.send_error(404)

    def _begin(self, status: int, kind: str, length: int, **more: str) -> None:
        self.send_response(status)
        headers = {"Content-Type": kind, "Content-Length": str(length), "Cache-Control": "no-store"}
        for name, value in {
            **headers,
            **{name.replace("_", "-"): value for name, value in more.items()},
        }.items():
            self.send_header(name, value)
        self.end_headers()

    def _reply_with_clip(self, with_body: bool) -> None:
        stream = self._listener.stream
        size, kind = stream.byte_count, "application/octet-stream"
        tag = {"ETag": f'"{self._listener.token}"', "Accept_Ranges": "bytes"}
        wanted = self.headers.get("Range")
        first, last, status = 0, size - 1, 200
        if wanted is not None:
            found = range_of(wanted, size)
            if found is None:
                self._begin(416, kind, 0, Content_Range=f"bytes */{size}")
                return
            (first, last), status = found, 206
            tag["Content_Range"] = f"bytes {first}-{last}/{size}"
        self._begin(status, kind, last - first + 1, **tag)
        try:
            while with_body and first <= last:
                part = stream.read_at(first, min(BLOCK, last + 1 - first))
                self.wfile.write(part)
                first += len(part)
        except (Error, OSError):
            # The clip was closed, or the browser has enough: the reply is shorter than announced.
            self.close_connection = True

    def log_message(self, format: str, *args: Any) -> None:
        """Requests are not reported."""


def range_of(text: str, size: int) -> tuple[int, int] | None:
    """First and last byte of a Range header (RFC 9110, 14.1.2) of one range; None: it cannot be served."""
    found = re.fullmatch(r"bytes=(\d*)-(\d*)", text.strip())
    if not found or found[1] == found[2] == "":
        return None
    first, last = (int(part) if part else None for part in found.groups())
    if first is None:
        first, last = max(0, size - (last or 0)), size - 1
    last = size - 1 if last is None else min(last, size - 1)
    return (first, last) if first <= last else None


class _Listener(http.server.ThreadingHTTPServer):
    daemon_threads = True

    def __init__(self, stream: Stream, title: str, port: int, script: bytes) -> None:
        self.stream = stream
        # Part of the address: pages of others that guess the port get nothing.
        self.token = secrets.token_urlsafe(12)
        start = SERVED.format(title=html.escape(title), look=LOOK).encode()
        self.pages: dict[str, tuple[str, bytes, dict[str, str]]] = {
            "": ("text/html; charset=utf-8", start, {}),
            # Every browser that plays it takes gzip.
            "player.js": ("text/javascript", script, {"Content_Encoding": "gzip"}),
        }
        super().__init__(("127.0.0.1", port), _Handler)

    def handle_error(self, request: Any, client_address: Any) -> None:
        """A browser that ends a connection is no error."""


class Server:
    """Serves a player and a stream on this computer, to this computer, until it is closed. The stream is borrowed; after its
    close requests fail. OSError: the port is not free."""

    def __init__(self, stream: Stream, title: str, script: bytes, port: int = 0) -> None:
        if not 0 <= port < 65536:
            raise UsageError(f"port {port}: expected 0 to 65535")
        self._listener = _Listener(stream, title, port, script)
        #: The page.
        self.url = f"http://127.0.0.1:{self._listener.server_address[1]}/{self._listener.token}/"
        self._ended = threading.Event()
        self._process = os.getpid()
        self._thread = threading.Thread(target=self._serve, daemon=True)
        self._thread.start()

    def _serve(self) -> None:
        self._listener.timeout = 0.1
        with self._listener:
            while not self._ended.is_set():
                self._listener.handle_request()

    def wait(self) -> None:
        """Until another thread closes the server."""
        self._thread.join()

    def close(self) -> None:
        """Ends the server. May be called again. A process that was forked has none."""
        if self._process != os.getpid():
            return
        self._ended.set()
        # The garbage collector may come here in the thread itself.
        if threading.current_thread() is not self._thread:
            self._thread.join()

    def __enter__(self) -> Server:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()
