"""The exceptions of this package."""

from __future__ import annotations


class Error(Exception):
    """What every exception of this package derives from. str() is the whole line: file, place, what is wrong and rule."""

    def __init__(
        self,
        message: str,
        *,
        file: str | None = None,
        chunk: str | None = None,
        offset: int | None = None,
        issue: int | None = None,
    ) -> None:
        super().__init__(message)
        #: The file's name, as it was given.
        self.file = file
        #: The four characters of the chunk's type, such as "MESH".
        self.chunk = chunk
        #: Bytes from the start of the stream.
        self.offset = offset
        #: The number n of FVV-n in spec/issues.md.
        self.issue = issue

    def __reduce__(self) -> tuple[object, ...]:
        return (_rebuild, (type(self), str(self), self.file, self.chunk, self.offset, self.issue))


def _rebuild(
    kind: type[Error],
    message: str,
    file: str | None,
    chunk: str | None,
    offset: int | None,
    issue: int | None,
) -> Error:
    return kind(message, file=file, chunk=chunk, offset=offset, issue=issue)


class DamagedError(Error):
    """The stream is damaged, cut, or breaks a rule of the specification."""


class LimitError(Error):
    """The stream is valid, and beyond the limits that were given."""


class UnsupportedError(Error):
    """The stream needs a later version, or a codec that is not known."""


class UsageError(Error, ValueError):
    """A call that cannot be served: a wrong argument, or a clip that is closed."""


class LossWarning(UserWarning):
    """The stream is written, but lacks something of its sources, or does not meet an option exactly."""
