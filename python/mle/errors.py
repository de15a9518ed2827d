"""Exceptions of the package: one class for each kind of failure.

Every exception has the text of the library's status, which says what was found,
where, and what would be right; its ``code`` ("INVALID_ARGUMENT", ...); and
``options``, the names of the options that the text is about.
"""

from __future__ import annotations

from typing import Tuple


class Error(Exception):
    """What the library refuses, or cannot do."""

    code: str = "UNKNOWN"
    options: Tuple[str, ...] = ()


class InvalidInputError(Error, ValueError):
    """A model, record, file or option that is wrong."""


class NotUsableError(Error, RuntimeError):
    """The computation ran, but its result cannot be used."""


class MissingFileError(Error, FileNotFoundError):
    """A file that is not there."""


class FileAccessError(Error, OSError):
    """A file that cannot be read or written, a database that cannot be reached."""


class CancelledError(Error):
    """The progress callback asked to stop."""


_KINDS = {
    "INVALID_ARGUMENT": InvalidInputError,
    "OUT_OF_RANGE": InvalidInputError,
    "NOT_FOUND": MissingFileError,
    "PERMISSION_DENIED": FileAccessError,
    "UNAVAILABLE": FileAccessError,
    "CANCELLED": CancelledError,
}


def _error(code: str, message: str, options: str) -> Error:
    """The exception of a status; the compiled module calls this."""
    error = _KINDS.get(code, NotUsableError)(message)
    error.code = code
    error.options = tuple(name for name in options.split(",") if name)
    return error
