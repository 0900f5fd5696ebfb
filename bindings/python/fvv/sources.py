"""Where the bytes of a clip come from, and how another process reads the same ones."""

from __future__ import annotations

import io
import os
import pickle
from typing import Any, BinaryIO, Protocol

from .errors import UsageError
from .remote import RemoteFile, is_url


class ReadAt(Protocol):
    """Something that gives bytes from any place, such as a client of a storage service."""

    @property
    def size(self) -> int:
        """Bytes in all."""
        ...

    def read_at(self, offset: int, size: int) -> Any:
        """Exactly size bytes from offset, as bytes or another object with the buffer protocol."""


#: A path or a URL of http or https, bytes or anything with the buffer protocol (mmap too), a binary file object, or a `ReadAt`.
Readable = Any


class _FileObject:
    """A seekable file object as `ReadAt`. Its position is moved; it is not closed."""

    def __init__(self, file: BinaryIO) -> None:
        self._file = file
        self.size = file.seek(0, os.SEEK_END)

    def read_at(self, offset: int, size: int) -> bytes:
        self._file.seek(offset)
        parts: list[bytes] = []
        while size:
            part = self._file.read(size)
            if not part:
                break
            parts.append(part)
            size -= len(part)
        return parts[0] if len(parts) == 1 else b"".join(parts)


class Source:
    """What `fvv.open` was given. core: what the core reads; name: what messages call it."""

    def __init__(self, given: Readable) -> None:
        self._given = given
        #: Which file a path or URL leads to: a process that opens it again may find another.
        self._file: tuple[object, ...] | None = None
        if isinstance(given, str) and is_url(given) and not os.path.exists(given):
            self.core: Any = RemoteFile(given)
            self.name, self._file = given, self.core.identity
            return
        if isinstance(given, (str, os.PathLike)):
            path: str = os.fspath(given)
            if os.path.exists(path) and not os.path.isfile(path):
                raise UsageError(f"{path}: expected a file", file=path)
            with open(path, "rb") as file:  # for the usual exceptions
                self._file = _identity(os.fstat(file.fileno()))
            self._given = os.path.abspath(path)
            self.core, self.name = path, path
            return
        self.core, self.name = given, "bytes"
        try:
            memoryview(given)
            return
        except TypeError:
            pass
        name = getattr(given, "name", None)
        self.name = name if isinstance(name, str) else type(given).__name__
        if hasattr(given, "read_at"):
            return
        if hasattr(given, "read") and hasattr(given, "seek"):
            self.core = _FileObject(given)
            return
        raise TypeError(
            f"expected a path, bytes, a binary file object, or an object with read_at and size, not {type(given).__name__}"
        )

    def after_fork(self) -> Source:
        """The same source in a process that was forked from the one that opened it. Only what has no position and no
        connection is shared."""
        if isinstance(self._given, str):
            found = Source(self._given)
            if self._file != found._file:
                raise UsageError(
                    f"{self.name}: was replaced after it was opened: open it in this process", file=self.name
                )
            return found
        if self.name == "bytes":
            return Source(self._given)
        return Source(pickle.loads(self._pickled("is shared by processes after a fork")))

    def portable(self) -> Readable:
        """What another process opens in place of it, with `opened_elsewhere`."""
        if isinstance(self._given, (str, bytes)):
            return self._given
        return _Pickled(self._pickled("cannot be pickled"))

    def _pickled(self, what: str) -> bytes:
        try:
            return pickle.dumps(_own_path(self._given) or self._given)
        except Exception as error:
            raise UsageError(
                f"{self.name}: a clip of this {type(self._given).__name__} {what}: {error}. Open it by its path or URL, or "
                "open a clip in each process",
                file=self.name,
            ) from error


class _Pickled:
    """A source that was pickled already, as its errors are to name the clip."""

    def __init__(self, data: bytes) -> None:
        self.data = data


def opened_elsewhere(portable: Readable) -> Readable:
    """What `Source.portable` returned, in the process that received it."""
    return pickle.loads(portable.data) if isinstance(portable, _Pickled) else portable


def _identity(status: os.stat_result) -> tuple[object, ...]:
    return status.st_dev, status.st_ino, status.st_size, status.st_mtime_ns


def _own_path(file: Any) -> str | None:
    """The path of a file of the operating system, if it still leads to this file. None for what reads through one, such as a
    decompressor."""
    raw = file.raw if isinstance(file, (io.BufferedReader, io.BufferedRandom)) else file
    if not isinstance(raw, io.FileIO) or not isinstance(raw.name, str):
        return None
    try:
        same = os.path.samestat(os.fstat(raw.fileno()), os.stat(raw.name))
    except OSError:
        return None
    return os.path.abspath(raw.name) if same else None
