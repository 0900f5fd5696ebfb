"""Folders and files where all workers reach them: local ones, and those of fsspec."""

from __future__ import annotations

import contextlib
import glob
import importlib
import os
import tempfile
import uuid
from collections.abc import Iterator, Sequence
from typing import Any, Callable

from .. import _core
from ..errors import Error, UsageError

#: Protocols whose first folder is a bucket: it belongs to an account and is never made here. Below it there are no folders, and a
#: file appears when it is whole.
BUCKETS = {"s3", "s3a", "gs", "gcs", "abfs", "abfss", "az", "adl", "oss", "oci", "cos", "tos", "obs"}


def filesystem(url: str) -> tuple[Any, str]:
    """The storage, and the path there. What it remembers of folders is forgotten: other processes write there."""
    try:
        fsspec = importlib.import_module("fsspec")
    except ImportError:
        raise ImportError("fvv.distributed needs fsspec: pip install fvv[dask]") from None
    files, path = fsspec.core.url_to_fs(url)
    files.invalidate_cache()
    return files, path


def protocols(files: Any) -> set[str]:
    return set(files.protocol) if isinstance(files.protocol, tuple) else {files.protocol}


def is_local(files: Any) -> bool:
    return "file" in protocols(files)


def absolute(path: str | os.PathLike[str]) -> str:
    """The same for workers with another current folder."""
    text = os.fspath(path)
    return text.rstrip("/") if "://" in text or "::" in text else os.path.abspath(text)


def inside(folder: str, name: str) -> str:
    return f"{folder}/{name}"


def write(path: str, content: bytes) -> None:
    with open(path, "wb") as file:
        file.write(content)


def require_bucket(url: str) -> None:
    """Raises `FileNotFoundError` for a bucket that is not there."""
    files, path = filesystem(url)
    bucket = path.partition("/")[0]
    if protocols(files) & BUCKETS and not files.exists(bucket):
        raise FileNotFoundError(f"{url}: there is no bucket {bucket}; make it first")


def make_folder(url: str) -> None:
    files, path = filesystem(url)
    if not protocols(files) & BUCKETS:
        files.makedirs(path, exist_ok=True)


def refuse_existing(url: str, force: bool) -> None:
    files, path = filesystem(url)
    if files.isdir(path):
        raise UsageError(f"{url}: is a folder, expected the name of a file", file=url)
    if not force and files.exists(path):
        raise UsageError(f"{url}: already exists; force=True replaces it", file=url)


def refuse_input(url: str, capture: str) -> None:
    (files, path), (of_capture, root) = filesystem(url), filesystem(capture)
    # A path of this machine may be another one on the workers.
    if not (is_local(files) and is_local(of_capture) and os.path.exists(path) and os.path.exists(root)):
        return
    with Capture(capture) as found:
        for name in _core.files_of(found.path):
            if os.path.exists(name) and os.path.samefile(name, path):
                raise UsageError(f"{url}: is read by this call, and cannot be replaced", file=url)


def remove(folder: str) -> None:
    files, path = filesystem(folder)
    with contextlib.suppress(FileNotFoundError):
        files.rm(path, recursive=True)


@contextlib.contextmanager
def written(url: str, call: str = "") -> Iterator[str]:
    """A local path to write. The file appears under url when it is whole, and replaces what is there. call: of which
    `remove_partials` removes what processes leave behind that are killed."""
    files, path = filesystem(url)
    folder, name = os.path.split(path)
    partial = inside(folder, f".{name}.{call}{uuid.uuid4().hex}.partial")
    if is_local(files):
        try:
            yield partial
            with open(partial, "rb") as file:
                os.fsync(file.fileno())
            os.replace(partial, path)
        finally:
            with contextlib.suppress(FileNotFoundError):
                os.unlink(partial)
        return
    with tempfile.TemporaryDirectory() as local:
        yield os.path.join(local, name)
        if protocols(files) & BUCKETS:
            files.put_file(os.path.join(local, name), path)
            return
        try:
            files.put_file(os.path.join(local, name), partial)
            files.mv(partial, path)
        except BaseException:
            with contextlib.suppress(Exception):
                files.rm(partial)
            raise


def remove_partials(url: str, call: str) -> None:
    files, path = filesystem(url)
    folder, name = os.path.split(path)
    if is_local(files):
        for left in glob.glob(inside(glob.escape(folder), f".{glob.escape(name)}.{call}*.partial")):
            with contextlib.suppress(FileNotFoundError):
                os.unlink(left)


class Capture:
    """A capture as local files: itself, or a folder with copies, which is removed at the end. Errors inside `with` name the
    files by their URL."""

    def __init__(self, url: str) -> None:
        self._url = url
        self._files, root = filesystem(url)
        folder = self._files.isdir(root)
        if folder:
            root = inside(root, "capture.json")
        self._root = os.path.dirname(root)
        self._folder = url if folder else url.rpartition("/")[0]
        self._copies: tempfile.TemporaryDirectory[str] | None = None
        #: Of capture.json.
        self.path = root
        if not is_local(self._files):
            self._copies = tempfile.TemporaryDirectory()
            self.path = os.path.join(self._copies.name, os.path.basename(root))
            try:
                self._files.get_file(root, self.path)
            except FileNotFoundError:
                self._copies.cleanup()
                raise FileNotFoundError(
                    f"{inside(url, 'capture.json') if folder else url}: there is no such file"
                ) from None
            except BaseException:
                self._copies.cleanup()
                raise

    @property
    def is_copied(self) -> bool:
        return self._copies is not None

    def description(self) -> bytes:
        """The bytes of capture.json."""
        with open(self.path, "rb") as file:
            return file.read()

    def fetch(
        self, names: Callable[[], Sequence[str]], progress: Callable[[float], object] | None = None
    ) -> None:
        """Copies files. names: the paths that are needed, beside `path`; those of files that copied files name are found in
        a second pass. What is missing is left to the one who reads it. progress: called with the part that is copied."""
        for _ in range(0 if self._copies is None else 2):
            wanted = names()
            for done, name in enumerate(wanted):
                if progress is not None:
                    progress(done / len(wanted))
                relative = os.path.relpath(name, os.path.dirname(self.path))
                if relative.startswith(os.pardir):
                    raise UsageError(
                        f"{self._url}: names {relative}: of a capture that is copied to the workers, all files are in the "
                        "folder of capture.json",
                        file=self._url,
                    )
                if os.path.exists(name):
                    continue
                os.makedirs(os.path.dirname(name), exist_ok=True)
                with contextlib.suppress(FileNotFoundError):
                    self._files.get_file(inside(self._root, relative), name)

    def __enter__(self) -> Capture:
        return self

    def __exit__(self, kind: object, error: BaseException | None, trace: object) -> None:
        if self._copies is None:
            return
        if error is not None:
            _rename(error, self._copies.name, self._folder)
        self._copies.cleanup()


def _rename(error: BaseException, folder: str, url: str) -> None:
    """Names files of a folder in an error's text by their URL."""
    error.args = tuple(one.replace(folder, url) if isinstance(one, str) else one for one in error.args)
    if isinstance(error, Error) and error.file is not None:
        error.file = error.file.replace(folder, url)
    if isinstance(error, OSError) and isinstance(error.filename, str):
        error.filename = error.filename.replace(folder, url)
