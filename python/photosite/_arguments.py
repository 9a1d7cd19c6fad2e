"""What callers give: checked, and put into the words of the library."""

from __future__ import annotations

import json
import os
import re
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, Optional, Union, cast

import numpy as np
import numpy.typing as npt

from ._errors import InputError

if TYPE_CHECKING:
    from typing_extensions import TypeIs

#: A path of keys through tables, of which those of materials may have any name.
_KEY = re.compile(r"[^\s=#\[\]](?:[^\n\r=#\[\]]*[^\s=#\[\]])?")

#: Whatever names a file.
Path = Union[str, "os.PathLike[str]"]


def invalid(name: str, reason: str, help: Optional[str] = None) -> InputError:
    """The error of an argument."""
    message = f"{name}: {reason}"
    return InputError(message, file="<python>", key=name, reason=reason, help=help)


def path_of(name: str, value: object) -> str:
    """The path of a file or folder."""
    if not is_path(value):
        raise invalid(name, f"expected a path, got {type(value).__name__}", "give a str or a pathlib.Path")
    path: object = os.fspath(value)
    if not isinstance(path, str):
        raise invalid(name, "expected a path of text, got bytes", "give a str or a pathlib.Path")
    if not path:
        raise invalid(name, "the path is empty", 'give "." for the current folder')
    try:
        os.fsencode(path)
    except UnicodeEncodeError:
        raise invalid(name, f"{path!r} is not a name that a file can have") from None
    return path


def number(name: str, value: object) -> float:
    """A real number."""
    if isinstance(value, (bool, str, bytes)):
        raise invalid(name, f"expected a number, got {value!r}")
    try:
        return float(cast(float, value))
    except (TypeError, ValueError, OverflowError):
        raise invalid(name, f"expected a number, got {type(value).__name__}") from None


def names(name: str, value: object) -> "list[str]":
    """A list of texts."""
    if isinstance(value, (str, bytes)) or not isinstance(value, Sequence):
        raise invalid(name, f"expected a list of names, got {type(value).__name__}")
    items = cast("Sequence[object]", value)
    for item in items:
        if not isinstance(item, str):
            raise invalid(name, f"expected names, got {item!r}")
    return [str(item) for item in items]


def floats(name: str, value: Any, shape: str, axes: "tuple[int, ...]") -> "npt.NDArray[np.float32]":
    """Real numbers as an array of float32, C-contiguous, that has one of so many axes; `shape` says what is wanted."""
    array = as_array(name, value, axes, shape)
    if array.dtype.kind not in "uif" or array.dtype.itemsize > 8:
        raise invalid(name, f"expected real numbers, got an array of {array.dtype}", f"give an array {shape} of float32")
    return np.ascontiguousarray(array, np.float32)


def as_array(name: str, value: Any, axes: "tuple[int, ...]", shape: str) -> "npt.NDArray[Any]":
    """An array of so many axes that is not empty."""
    if isinstance(value, np.ma.MaskedArray) and np.ma.is_masked(value):
        raise invalid(name, "some of its numbers are masked", "fill them, or cut them away")
    try:
        array: npt.NDArray[Any] = np.asarray(value)
    except (TypeError, ValueError) as error:
        raise invalid(name, f"expected an array {shape}, got {type(value).__name__}: {error}") from None
    if array.dtype.kind in "OSUV":
        raise invalid(name, f"expected an array {shape} of numbers, got {type(value).__name__}")
    if array.ndim not in axes:
        raise invalid(name, f"expected an array {shape}, got one of shape {array.shape}")
    if array.size == 0:
        raise invalid(name, f"the array of shape {array.shape} is empty", f"give an array {shape}")
    return array


def is_path(value: object) -> "TypeIs[Path]":
    """Whether it names a file."""
    return isinstance(value, (str, os.PathLike))


def assignments(keys: Mapping[str, Any], prefix: str = "") -> "list[str]":
    """Keys and their values as the library reads them, `key=value`, with values in TOML."""
    if not isinstance(cast(object, keys), Mapping):
        raise invalid("set", f"expected a dictionary of values by their keys, got {type(keys).__name__}")
    for key in keys:
        if not isinstance(cast(object, key), str) or not _KEY.fullmatch(key):
            raise invalid("set", f"{key!r} is not a key", 'write keys as in {"exposure.time_s": 0.02}')
    return [f"{prefix}{key}={toml(f'{prefix}{key}', value)}" for key, value in keys.items()]


def toml(name: str, value: Any) -> str:
    """A value as TOML has it."""
    try:
        return _toml(name, value)
    except RecursionError:
        raise invalid(name, "holds itself, or is too deep for a capture") from None


def _toml(name: str, value: Any) -> str:
    if isinstance(value, np.floating):
        return repr(float(cast(Any, value)))
    if isinstance(value, (np.ndarray, np.generic)):
        return _toml(name, cast(Any, value).tolist())
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, (int, float)):
        return repr(value)
    if is_path(value):
        text: str = os.fspath(value)
        return json.dumps(text).replace("\x7f", "\\u007f")
    if isinstance(value, Mapping):
        pairs: Mapping[str, Any] = value  # pyright: ignore[reportUnknownVariableType]
        inside = (f"{json.dumps(str(key))} = {_toml(f'{name}.{key}', item)}" for key, item in pairs.items())
        return "{ " + ", ".join(inside) + " }"
    if isinstance(value, Sequence):
        items: Sequence[Any] = value  # pyright: ignore[reportUnknownVariableType]
        return "[" + ", ".join(_toml(f"{name}[{i}]", item) for i, item in enumerate(items)) + "]"
    help = "give a bool, a number, a string, a path, or a list or dictionary of these"
    raise invalid(name, f"a capture file cannot hold a value of type {type(value).__name__}", help)
