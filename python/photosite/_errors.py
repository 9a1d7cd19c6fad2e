"""Errors and warnings."""

from __future__ import annotations

import difflib
import os
import sys
import warnings
from collections.abc import Iterable
from typing import Any, Optional

__all__ = ["Error", "InputError", "FileError", "ResourceError", "PhotositeWarning"]


class Error(Exception):
    """Whatever photosite cannot do, for a reason outside of it.

    Attributes:
        file: the file at fault, or ``"<python>"`` where values were given in its place; None where there is none.
        line: the line in it, counted from 1.
        key: the key at fault, as in ``lens.f_number``, or the name of an argument; may be empty.
        reason: what is wrong, without file and key.
        help: what to write instead.
        is_temporary: whether another try may succeed: the disk is full, another process writes to the same place.
    """

    file: Optional[str]
    line: Optional[int]
    key: str
    reason: str
    help: Optional[str]
    is_temporary: bool

    def __init__(
        self,
        message: str,
        *,
        file: "os.PathLike[str] | str | None" = None,
        line: Optional[int] = None,
        key: str = "",
        reason: str = "",
        help: Optional[str] = None,
        is_temporary: bool = False,
    ) -> None:
        super().__init__(message)
        self.file = None if file is None else os.fspath(file)
        self.line, self.key, self.reason, self.help = line, key, reason or message, help
        self.is_temporary = is_temporary
        if help and sys.version_info >= (3, 11):
            self.add_note(f"help: {help}")  # below the message

    def __str__(self) -> str:
        return str(self.args[0])

    def __reduce__(self) -> Any:
        parts = {name: getattr(self, name) for name in ("file", "line", "key", "reason", "help", "is_temporary")}
        if isinstance(self, OSError):
            parts["errno"] = self.errno
        return _unpickle, (type(self).__name__, str(self), parts)


class InputError(Error, ValueError):
    """A file, a key or an argument says something that cannot be used."""


class FileError(Error, OSError):
    """The operating system refused to read or write. Where it has a class of its own for the reason, as
    FileNotFoundError, the error is one of that, too."""


class ResourceError(Error, MemoryError):
    """The machine does not give what the work takes: memory, threads."""


class _NotFound(FileError, FileNotFoundError):
    pass


class _Forbidden(FileError, PermissionError):
    pass


class _Exists(FileError, FileExistsError):
    pass


class _NoLayer(InputError, KeyError):
    pass


# What tracebacks show is what users can catch.
for _kind in (_NotFound, _Forbidden, _Exists):
    _kind.__name__ = _kind.__qualname__ = "FileError"
_NoLayer.__name__ = _NoLayer.__qualname__ = "InputError"


def no_layer(name: str, known: "Iterable[str]") -> InputError:
    """The error of a mapping of layers that has none of that name."""
    names = list(known)
    near = difflib.get_close_matches(name, names, 1)
    reason = "there is no such layer" + (f"; did you mean {near[0]}?" if near else "")
    help = f"the layers are {', '.join(names)}"
    return _NoLayer(f"{name}: {reason}", file="<python>", key=name, reason=reason, help=help)


class PhotositeWarning(UserWarning):
    """What one should know of a result that is otherwise as it was asked for."""


def make(kind: str, message: str, errno: Optional[int] = None, **parts: Any) -> Error:
    """The error of a kind; that of the operating system in the class of its number."""
    if kind != "FileError":
        known = {"Error": Error, "InputError": InputError, "ResourceError": ResourceError}
        return known[kind](message, **parts)
    plain = OSError(errno, "") if errno is not None else OSError()
    of_system: "dict[type[OSError], type[FileError]]"
    of_system = {FileNotFoundError: _NotFound, PermissionError: _Forbidden, FileExistsError: _Exists}
    error = of_system.get(type(plain), FileError)(message, **parts)
    error.errno = errno
    error.filename = error.file
    return error


def _unpickle(kind: str, message: str, parts: "dict[str, Any]") -> Error:
    return make(kind, message, **parts)


def warn_all(messages: "list[str]") -> None:
    """Gives each warning with the file and line of whoever called the package."""
    package = os.path.dirname(__file__) + os.sep
    level, frame = 1, sys._getframe()
    while frame.f_back is not None and frame.f_code.co_filename.startswith(package):
        frame, level = frame.f_back, level + 1
    for message in messages:
        warnings.warn(message, PhotositeWarning, stacklevel=level)
