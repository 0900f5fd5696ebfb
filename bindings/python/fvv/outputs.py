"""Where a stream is written: a file that appears when it is whole, a file object, or a function."""

from __future__ import annotations

import contextlib
import os
import shutil
import stat
from collections.abc import Iterable
from typing import Any, BinaryIO, Callable, Protocol, Union

from .errors import UsageError


class Writable(Protocol):
    """A binary file object."""

    def write(self, data: bytes) -> Any:
        """Returns how many bytes were taken, or None: all."""


#: A path, a binary file object, or a function that takes bytes.
Target = Union[str, "os.PathLike[str]", Writable, Callable[[bytes], Any]]


def _beside(path: str) -> str:
    """A free name in the folder of path."""
    folder, name = os.path.split(path)
    for i in range(10000):
        found = os.path.join(folder, f".{name}.{os.getpid()}-{i}.partial")
        if not os.path.lexists(found):
            return found
    raise FileExistsError(f"{folder}: no free name for a temporary file")


class FileOutput:
    """A file under a temporary name beside its own, until `commit`. Pipes and devices are written to directly."""

    def __init__(self, path: str, force: bool, inputs: Iterable[str] = ()) -> None:
        self.name = path
        self._path = os.path.realpath(path)
        self._force = force
        self._file: BinaryIO | None = None
        #: Where the bytes are before `commit`; None: it is a pipe or a device.
        self.temporary: str | None = None
        found: os.stat_result | None = None
        with contextlib.suppress(FileNotFoundError):
            found = os.stat(self._path)
        if found is not None:
            if stat.S_ISFIFO(found.st_mode) or stat.S_ISCHR(found.st_mode):
                self._file = open(self._path, "wb")  # noqa: SIM115
                return
            if not stat.S_ISREG(found.st_mode):
                raise UsageError(f"{path}: expected a file to write, found something else", file=path)
            if not force:
                raise self._exists()
            for source in inputs:
                if os.path.exists(source) and os.path.samestat(found, os.stat(source)):
                    raise UsageError(f"{path}: is read by this call, and cannot be replaced", file=path)
        self.temporary = _beside(self._path)
        self._file = open(self.temporary, "xb")  # noqa: SIM115
        if found is not None:
            os.chmod(self.temporary, stat.S_IMODE(found.st_mode))

    def write(self, data: bytes | memoryview) -> None:
        assert self._file is not None
        self._file.write(data)

    def flush(self) -> None:
        if self._file is not None:
            self._file.flush()

    def commit(self) -> None:
        """Closes the file and gives it its name."""
        assert self._file is not None
        self._file.flush()
        if self.temporary is None:
            self._file.close()
            return
        os.fsync(self._file.fileno())  # a full disk is found before anything is replaced
        self._file.close()
        if not self._force:
            try:
                os.link(self.temporary, self._path)  # fails where something has the name meanwhile
            except FileExistsError:
                raise self._exists() from None
            except OSError:  # a file system without links
                if os.path.lexists(self._path):
                    raise self._exists() from None
            else:
                os.unlink(self.temporary)
                self.temporary = None
                return
        os.replace(self.temporary, self._path)
        self.temporary = None

    def _exists(self) -> UsageError:
        return UsageError(f"{self.name}: already exists; force=True replaces it", file=self.name)

    def discard(self) -> None:
        """Closes the file and removes what was written. May be called again, and after `commit`."""
        if self._file is not None:
            self._file.close()
        if self.temporary is not None:
            os.unlink(self.temporary)
            self.temporary = None


class FolderOutput:
    """A folder under a temporary name beside its own, until `commit`."""

    def __init__(self, path: str) -> None:
        self.name = path
        self._path = os.path.realpath(path)
        if os.path.lexists(self._path) and not (os.path.isdir(self._path) and not os.listdir(self._path)):
            raise UsageError(f"{path}: expected a name that is free, or an empty folder", file=path)
        self.temporary: str | None = _beside(self._path)
        os.mkdir(self.temporary)

    def write_file(self, name: str, content: bytes) -> None:
        """name: with / between folders, which are made."""
        assert self.temporary is not None
        path = os.path.join(self.temporary, *name.split("/"))
        os.makedirs(os.path.dirname(path), exist_ok=True)
        with open(path, "xb") as file:
            file.write(content)

    def commit(self) -> None:
        """Gives the folder its name. Fails where something has it meanwhile."""
        assert self.temporary is not None
        os.rename(self.temporary, self._path)
        self.temporary = None

    def discard(self) -> None:
        """Removes what was written. May be called again, and after `commit`."""
        if self.temporary is not None:
            shutil.rmtree(self.temporary)
            self.temporary = None


class ObjectOutput:
    """A file object or a function of the caller, which is neither flushed nor closed."""

    temporary: str | None = None

    def __init__(self, target: Any) -> None:
        self._write = target.write if hasattr(target, "write") else target
        name = getattr(target, "name", None)
        self.name = name if isinstance(name, str) else type(target).__name__

    def write(self, data: memoryview) -> None:
        # A copy: the memory is valid during this call, and the caller may keep what it receives.
        rest = bytes(data)
        while rest:
            taken = self._write(rest)
            if not isinstance(taken, int) or isinstance(taken, bool) or not 0 <= taken < len(rest):
                return
            if not taken:
                raise BlockingIOError(f"{self.name}: takes no bytes")
            rest = rest[taken:]

    def flush(self) -> None: ...
    def commit(self) -> None: ...
    def discard(self) -> None: ...


def output_of(target: Target, force: bool, inputs: Iterable[str] = ()) -> FileOutput | ObjectOutput:
    if isinstance(target, (str, os.PathLike)):
        return FileOutput(os.fspath(target), force, inputs)
    if hasattr(target, "write") or callable(target):
        return ObjectOutput(target)
    raise TypeError(f"expected a path, a binary file object or a function, not {type(target).__name__}")
