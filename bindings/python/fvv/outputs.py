"""Where a stream is written: a file that appears when it is whole, a file object, or a function."""

from __future__ import annotations

import contextlib
import os
import shutil
import stat
from collections.abc import Iterable, Iterator, Sequence
from typing import Any, BinaryIO, Callable, Protocol, Union

from .errors import UsageError


class Writable(Protocol):
    """A binary file object."""

    def write(self, data: bytes) -> Any:
        """Returns how many bytes were taken, or None: all."""


#: A path, a binary file object, or a function that takes bytes.
Target = Union[str, "os.PathLike[str]", Writable, Callable[[bytes], Any]]


# What most file systems take, in bytes.
_LONGEST_NAME = 255


def _beside(path: str) -> str:
    """A free name in the folder of path."""
    folder, name = os.path.split(path)
    for i in range(10000):
        end = f".{os.getpid()}-{i}.partial"
        # A name as long as the file system takes leaves no room for more.
        begin = os.fsencode(name)[: _LONGEST_NAME - 1 - len(end)].decode(errors="ignore")
        found = os.path.join(folder, f".{begin}{end}")
        if not os.path.lexists(found):
            return found
    raise FileExistsError(f"{folder}: no free name for a temporary file")


def _flush_folder(path: str) -> None:
    """Names in the folder of path are on the disk when this returns, where the file system can say so."""
    with contextlib.suppress(OSError):
        folder = os.open(os.path.dirname(path), os.O_RDONLY)
        try:
            os.fsync(folder)
        finally:
            os.close(folder)


@contextlib.contextmanager
def _naming(former: str | None, name: str) -> Iterator[None]:
    """Errors say where that is which had a name before."""
    try:
        yield
    except OSError as error:
        if former is None:
            raise
        raise OSError(
            error.errno, f"{error.strerror}: what {name} was before is now {former}", name
        ) from error


class Output(Protocol):
    """What has its name only when it is whole."""

    name: str

    def prepare(self) -> None:
        """All bytes are on the disk. May be called again."""

    def place(self) -> None:
        """It has its name."""

    def take_back(self) -> None:
        """The name is as it was before `place`, which may have failed."""

    def keep(self) -> None:
        """What had the name before is removed."""

    def discard(self) -> None:
        """Removes what was written and has no name."""


def commit_all(outputs: Sequence[Output]) -> None:
    """Gives all outputs their names, or none."""
    for output in outputs:
        output.prepare()
    placed: list[Output] = []
    try:
        for output in outputs:
            placed.append(output)
            output.place()
    except BaseException as error:
        lost: list[str] = []
        for output in reversed(placed):
            try:
                output.take_back()
            except OSError as other:
                lost.append(f"{output.name}: {other.strerror}")
        if lost and isinstance(error, OSError):
            raise OSError(error.errno, "; ".join([str(error.strerror), *lost]), error.filename) from error
        raise
    with contextlib.ExitStack() as kept:  # all of them, whichever fails
        for output in outputs:
            kept.callback(output.keep)


@contextlib.contextmanager
def discarded_unless_written(output: Output) -> Iterator[None]:
    """What is written here is whole, or discarded."""
    try:
        yield
    except BaseException:
        output.discard()
        raise


class FileOutput:
    """A file under a temporary name beside its own, until `commit`. Pipes and devices are written to directly."""

    def __init__(self, path: str, force: bool, inputs: Iterable[str] = ()) -> None:
        self.name = path
        self._path = os.path.realpath(path)
        self._force = force
        self._file: BinaryIO | None = None
        #: Where the bytes are before `commit`; None: it is a pipe or a device.
        self.temporary: str | None = None
        self._former: str | None = None  # where what had the name is, until all outputs have theirs
        self._is_placed = False
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
            with contextlib.suppress(OSError):  # root alone may keep the owner of others
                os.chown(self.temporary, found.st_uid, found.st_gid)
            os.chmod(self.temporary, stat.S_IMODE(found.st_mode))

    def write(self, data: bytes | memoryview) -> None:
        assert self._file is not None
        self._file.write(data)

    def flush(self) -> None:
        if self._file is not None:
            self._file.flush()

    def prepare(self) -> None:
        assert self._file is not None
        if self._file.closed:
            return
        self._file.flush()
        if self.temporary is not None:
            os.fsync(self._file.fileno())  # a full disk is found before anything is replaced
        self._file.close()

    def place(self) -> None:
        if self.temporary is None:
            return
        if self._force:
            self._keep_former()
        else:
            try:
                os.link(self.temporary, self._path)  # fails where something has the name meanwhile
            except FileExistsError:
                raise self._exists() from None
            except OSError:  # a file system without links
                if os.path.lexists(self._path):
                    raise self._exists() from None
            else:
                self._is_placed = True
                os.unlink(self.temporary)
                self.temporary = None
                return
        os.replace(self.temporary, self._path)
        self._is_placed = True
        self.temporary = None

    def _keep_former(self) -> None:
        """What has the name gets a second one; without links it has that alone for a moment."""
        if not os.path.isfile(self._path):
            return  # a folder that came meanwhile is not replaced
        former = _beside(self._path)
        try:
            os.link(self._path, former)
        except OSError:
            os.rename(self._path, former)
        self._former = former

    def take_back(self) -> None:
        with _naming(self._former, self.name):
            if self._former is not None:
                if os.path.lexists(self._path) and os.path.samefile(self._former, self._path):
                    os.unlink(self._former)  # what was there still has its name
                else:
                    os.replace(self._former, self._path)
            elif self._is_placed:
                os.unlink(self._path)
        self._former, self._is_placed = None, False

    def keep(self) -> None:
        if self._is_placed:
            _flush_folder(self._path)
        if self._former is not None:
            os.unlink(self._former)
            self._former = None

    def commit(self) -> None:
        """Closes the file and gives it its name."""
        commit_all([self])

    def _exists(self) -> UsageError:
        return UsageError(f"{self.name}: already exists; force=True replaces it", file=self.name)

    def discard(self) -> None:
        """Closes the file and removes what was written. May be called again, and after `commit`."""
        if self._file is not None:
            self._file.close()
        if self.temporary is not None:
            os.unlink(self.temporary)
            self.temporary = None


_LIST, _HEAD = ".fvv-output", "fvv output folder 1"


class FolderOutput:
    """A folder under a temporary name beside its own, until `commit`. With a tool's name it gets the list of its files by which a
    later run may replace it (docs/tools/outputs.md)."""

    def __init__(self, path: str, tool: str | None = None, force: bool = False) -> None:
        self.name = path
        self._path = os.path.realpath(path)
        self._tool = tool
        self._replace = False
        self._former: str | None = None
        self._written: str | None = None  # where it was before it had its name
        if os.path.lexists(self._path) and not (os.path.isdir(self._path) and not os.listdir(self._path)):
            if not force or tool is None:
                hint = "; --force replaces it" if tool else ""
                raise UsageError(f"{path}: expected a name that is free, or an empty folder{hint}", file=path)
            self._check_own()
            self._replace = True
        os.makedirs(os.path.dirname(self._path), exist_ok=True)
        self.temporary: str | None = _beside(self._path)
        os.mkdir(self.temporary)

    def _check_own(self) -> None:
        """Raises `UsageError` unless a run of this tool wrote the folder and every file in it."""
        refusal = f"{self.name}: --force replaces only what this tool wrote: "
        try:
            with open(os.path.join(self._path, _LIST)) as file:
                head, writer, *lines = file.read().splitlines()
        except (OSError, ValueError):
            raise UsageError(f"{refusal}the folder has no list of its files; remove it first") from None
        if head != _HEAD or writer != f"tool {self._tool}":
            raise UsageError(f"{refusal}the folder is from {writer.partition(' ')[2] or 'another tool'}")
        own = {_LIST, *(line[5:] for line in lines if line.startswith("file "))}
        for part in _files(self._path):
            if part not in own:
                raise UsageError(f"{refusal}it did not write {part}")
        here = os.path.join(os.path.realpath(os.curdir), "")
        if here.startswith(os.path.join(self._path, "")):
            raise UsageError(f"{self.name}: is the current folder, or around it")

    def write_file(self, name: str, content: bytes) -> None:
        """name: with / between folders, which are made."""
        assert self.temporary is not None
        path = os.path.join(self.temporary, *name.split("/"))
        os.makedirs(os.path.dirname(path), exist_ok=True)
        with open(path, "xb") as file:
            file.write(content)

    def prepare(self) -> None:
        assert self.temporary is not None
        if self._tool is not None and not os.path.exists(os.path.join(self.temporary, _LIST)):
            files = "".join(f"file {part}\n" for part in sorted(_files(self.temporary)))
            self.write_file(_LIST, f"{_HEAD}\ntool {self._tool}\n{files}".encode())

    def place(self) -> None:
        assert self.temporary is not None
        if self._replace:
            self._check_own()  # files may have been added while the run went on
            former = _beside(self._path)
            os.rename(self._path, former)
            self._former = former
        os.rename(self.temporary, self._path)
        self._written, self.temporary = self.temporary, None

    def take_back(self) -> None:
        with _naming(self._former, self.name):
            if self._written is not None:
                os.rename(self._path, self._written)
                self._written, self.temporary = None, self._written
            if self._former is not None:
                os.rename(self._former, self._path)
        self._former = None

    def keep(self) -> None:
        _flush_folder(self._path)
        if self._former is not None:
            shutil.rmtree(self._former)
            self._former = None

    def commit(self) -> None:
        """Gives the folder its name. Fails where something has it meanwhile."""
        commit_all([self])

    def discard(self) -> None:
        """Removes what was written. May be called again, and after `commit`."""
        if self.temporary is not None:
            shutil.rmtree(self.temporary)
            self.temporary = None


def _files(folder: str) -> list[str]:
    """Paths of all files below a folder, relative to it, with / between folders."""
    return [
        os.path.relpath(os.path.join(place, name), folder).replace(os.sep, "/")
        for place, _, names in os.walk(folder)
        for name in names
    ]


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
    def prepare(self) -> None: ...
    def place(self) -> None: ...
    def take_back(self) -> None: ...
    def keep(self) -> None: ...
    def commit(self) -> None: ...
    def discard(self) -> None: ...


def output_of(target: Target, force: bool, inputs: Iterable[str] = ()) -> FileOutput | ObjectOutput:
    if isinstance(target, (str, os.PathLike)):
        return FileOutput(os.fspath(target), force, inputs)
    if hasattr(target, "write") or callable(target):
        return ObjectOutput(target)
    raise TypeError(f"expected a path, a binary file object or a function, not {type(target).__name__}")
