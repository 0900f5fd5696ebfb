"""Files that are written whole or not at all."""

from __future__ import annotations

import contextlib
import os
import tempfile

from .errors import UsageError


def require_writable(path: str, sources: list[str], overwrite: bool) -> str:
    """The file that path means, once links are followed. `UsageError` if it may not be written: it is one of the sources, it
    exists and overwrite is False, or it is no ordinary file."""
    target = os.path.realpath(path)
    if os.path.exists(target):
        if not os.path.isfile(target):
            raise UsageError(f"{path}: expected the name of a file, found a folder or a device", file=path)
        if any(os.path.exists(source) and os.path.samefile(source, target) for source in sources):
            raise UsageError(f"{path}: is read by this run and would be replaced", file=path)
        if not overwrite:
            raise UsageError(f"{path}: exists already; overwrite it by force", file=path)
    return target


def write_whole(path: str, content: bytes, *, sources: list[str], overwrite: bool = False) -> None:
    """Writes a file under a temporary name beside its own and renames it. sources: files that are never replaced. Raises
    `UsageError` as `require_writable` does, and OSError."""
    target = require_writable(path, sources, overwrite)
    folder, name = os.path.split(target)
    former = os.stat(target).st_mode & 0o7777 if os.path.exists(target) else None
    descriptor, temporary = tempfile.mkstemp(prefix=f".{name}.", suffix=".partial", dir=folder)
    try:
        with os.fdopen(descriptor, "wb") as file:
            file.write(content)
        if former is None:
            mask = os.umask(0)
            os.umask(mask)
            former = 0o666 & ~mask
        os.chmod(temporary, former)
        os.replace(temporary, target)
    except BaseException:
        with contextlib.suppress(FileNotFoundError):
            os.unlink(temporary)
        raise
