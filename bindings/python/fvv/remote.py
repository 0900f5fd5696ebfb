"""A stream on a web server, read by ranges."""

from __future__ import annotations

import collections
import re
import time
from typing import Any
from urllib.parse import urlsplit
from urllib.request import getproxies, proxy_bypass

from .errors import UsageError

#: Seconds: for a connection to come about, and for each part of a response to arrive.
CONNECT_SECONDS, READ_SECONDS = 10.0, 30.0
#: A request is tried that many times. Seconds before the second attempt; before each further one twice as many.
ATTEMPTS, WAIT_SECONDS = 4, 0.5
#: What may be better a moment later.
BUSY = frozenset({429, 500, 502, 503, 504})
BLOCK = 1 << 18
#: Of one request, while reads follow each other: twice the last one, up to this many.
MOST_BLOCKS = 16
#: Blocks that are kept: more than those of one request.
KEPT = 128


def is_url(text: str) -> bool:
    """Whether a text is an address and no path."""
    return re.match(r"[A-Za-z][A-Za-z0-9+.-]+://", text) is not None


class RemoteFile:
    """A file of a web server as `fvv.ReadAt`. OSError where it cannot be read: TimeoutError, FileNotFoundError, PermissionError."""

    def __init__(self, url: str) -> None:
        if urlsplit(url).scheme.lower() not in ("http", "https"):
            raise UsageError(
                f"{url}: addresses of http and https are read; of others pass a file object, such as fsspec.open(url).open()",
                file=url,
            )
        try:
            import urllib3
        except ImportError:
            raise UsageError(f"{url}: reading it needs urllib3: pip install fvv[http]", file=url) from None
        self.url = url
        self._pool = _pool_of(urllib3, url)
        self._blocks: collections.OrderedDict[int, bytes] = collections.OrderedDict()
        self._next, self._ahead = 0, 1
        #: What must stay the same: bytes in all, and when or as what they were stored.
        self.identity: tuple[int, str | None, str | None] | None = None
        self.size = 0
        self._fetch(0, 1)
        if self.identity:
            self.size = self.identity[0]

    def read_at(self, offset: int, size: int) -> bytes:
        """Exactly size bytes, from blocks that were fetched or are fetched now."""
        parts: list[bytes] = []
        end = offset + size
        for number in range(offset // BLOCK, (end + BLOCK - 1) // BLOCK):
            if number not in self._blocks:
                self._ahead = min(2 * self._ahead, MOST_BLOCKS) if number == self._next else 1
                wanted = (end - 1) // BLOCK - number + 1
                self._fetch(number, max(min(wanted, MOST_BLOCKS), self._ahead))
            self._blocks.move_to_end(number)
            begin = number * BLOCK
            parts.append(self._blocks[number][max(0, offset - begin) : end - begin])
        return parts[0] if len(parts) == 1 else b"".join(parts)

    def _fetch(self, number: int, count: int) -> None:
        """Blocks from a number on, up to the first that is there."""
        last = (self.size - 1) // BLOCK if self.identity else number
        end = number + 1
        while end < number + count and end <= last and end not in self._blocks:
            end += 1
        content = self._range(
            number * BLOCK, end * BLOCK if not self.identity else min(end * BLOCK, self.size)
        )
        for i in range(number, end):
            self._blocks[i] = content[(i - number) * BLOCK : (i - number + 1) * BLOCK]
        self._next = end
        while len(self._blocks) > KEPT:
            self._blocks.popitem(last=False)

    def _range(self, first: int, end: int) -> bytes:
        """The bytes from first to before end, of the first request fewer where the file ends."""
        import urllib3

        content = b""
        why: Exception | None = None
        for attempt in range(ATTEMPTS):
            if attempt:
                time.sleep(WAIT_SECONDS * 2 ** (attempt - 1))
            response = None
            try:
                response = self._pool.request(
                    "GET",
                    self.url,
                    headers={
                        "Range": f"bytes={first + len(content)}-{end - 1}",
                        "Accept-Encoding": "identity",
                    },
                    preload_content=False,
                    retries=urllib3.Retry(total=5, connect=0, read=0, status=0, redirect=5, other=0),
                )
                if response.status in BUSY:
                    why = OSError(f"{self.url}: the server replies {response.status} {response.reason}")
                    continue
                end = self._check(response, first + len(content), end)
                while first + len(content) < end:
                    part = response.read(end - first - len(content))
                    if not part:
                        break
                    content += part
                if first + len(content) == end:
                    return content
                why = OSError(f"{self.url}: the response ends before its bytes {first}-{end - 1}")
            except urllib3.exceptions.MaxRetryError as error:
                why = self._error(urllib3, error.reason or error)
            except urllib3.exceptions.HTTPError as error:
                why = self._error(urllib3, error)
            finally:
                if response is not None:
                    # What was not read of it is of no use.
                    if first + len(content) == end:
                        response.release_conn()
                    else:
                        response.close()
        assert why is not None
        raise why

    def _check(self, response: Any, first: int, end: int) -> int:
        """The end of the range that the response has; OSError where that is another one."""
        status, said = response.status, f"{response.status} {response.reason}"
        found = re.fullmatch(r"bytes (?:(\d+)-(\d+)|\*)/(\d+)", response.headers.get("Content-Range", ""))
        if status == 416 and found and found[3] == "0":
            return first  # an empty file
        if status == 200:
            raise OSError(
                f"{self.url}: the server does not serve parts of a file (Range, RFC 9110): it replies 200 with all of it. Download "
                "it, and open the file"
            )
        if status in (404, 410):
            raise FileNotFoundError(f"{self.url}: the server replies {said}")
        if status in (401, 403, 407):
            raise PermissionError(f"{self.url}: the server replies {said}")
        if status != 206:
            raise OSError(f"{self.url}: the server replies {said}, expected 206 Partial Content")
        if not found or found[1] is None or int(found[1]) != first or int(found[2]) > end - 1:
            raise OSError(
                f"{self.url}: expected bytes {first}-{end - 1}, the server replies with Content-Range "
                f"{response.headers.get('Content-Range')!r}"
            )
        size = int(found[3])
        identity = (size, response.headers.get("Last-Modified"), response.headers.get("ETag"))
        if self.identity is None:
            self.identity = identity
        elif not _same(self.identity, identity):
            raise OSError(f"{self.url}: the file on the server was replaced while it was read: open it again")
        if int(found[2]) != min(end, size) - 1:
            raise OSError(
                f"{self.url}: expected bytes {first}-{min(end, size) - 1}, the server replies with {found[0]}"
            )
        return int(found[2]) + 1

    def _error(self, urllib3: Any, error: Exception) -> OSError:
        if isinstance(error, urllib3.exceptions.TimeoutError):
            return TimeoutError(f"{self.url}: the server does not reply: {error}")
        return OSError(f"{self.url}: {error}")


def _pool_of(urllib3: Any, url: str) -> Any:
    """Connections, kept open, through the proxy that the environment names."""
    parts = urlsplit(url)
    timeout = urllib3.Timeout(connect=CONNECT_SECONDS, read=READ_SECONDS)
    proxy = None if proxy_bypass(parts.hostname or "") else getproxies().get(parts.scheme.lower())
    if proxy:
        return urllib3.ProxyManager(proxy, timeout=timeout)
    return urllib3.PoolManager(timeout=timeout)


def _same(known: tuple[int, str | None, str | None], found: tuple[int, str | None, str | None]) -> bool:
    """By size and date; nodes of a network that has no date for a file may have ETags of their own."""
    if known[0] != found[0]:
        return False
    if known[1] and found[1]:
        return known[1] == found[1]
    return not (known[2] and found[2]) or known[2] == found[2]
