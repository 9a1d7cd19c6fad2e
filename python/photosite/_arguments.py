"""What callers give: checked, and put into the words of the library."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, Optional, Union, cast

import numpy as np
import numpy.typing as npt

from ._errors import InputError

if TYPE_CHECKING:
    from typing_extensions import TypeIs

#: Whatever names a file.
Path = Union[str, "os.PathLike[str]"]


def invalid(name: str, reason: str, help: Optional[str] = None) -> InputError:
    """The error of an argument."""
    message = f"{name}: {reason}"
    return InputError(message, file="<python>", key=name, reason=reason, help=help)


def floats(name: str, value: Any, shape: str, axes: "tuple[int, ...]") -> "npt.NDArray[np.float32]":
    """Real numbers as an array of float32, C-contiguous, that has one of so many axes; `shape` says what is wanted."""
    array = as_array(name, value, axes, shape)
    if array.dtype.kind not in "uif" or array.dtype.itemsize > 8:
        raise invalid(name, f"expected real numbers, got an array of {array.dtype}", f"give an array {shape} of float32")
    return np.ascontiguousarray(array, np.float32)


def as_array(name: str, value: Any, axes: "tuple[int, ...]", shape: str) -> "npt.NDArray[Any]":
    """An array of so many axes that is not empty."""
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
    return [f"{prefix}{key}={toml(f'{prefix}{key}', value)}" for key, value in keys.items()]


def toml(name: str, value: Any) -> str:
    """A value as TOML has it."""
    if isinstance(value, (np.ndarray, np.generic)):
        plain = cast(Any, value).tolist()
        return toml(name, plain)
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, (int, float)):
        return repr(value)
    if is_path(value):
        text: str = os.fspath(value)
        return json.dumps(text).replace("\x7f", "\\u007f")
    if isinstance(value, Mapping):
        pairs: Mapping[str, Any] = value  # pyright: ignore[reportUnknownVariableType]
        inside = (f"{json.dumps(str(key))} = {toml(f'{name}.{key}', item)}" for key, item in pairs.items())
        return "{ " + ", ".join(inside) + " }"
    if isinstance(value, Sequence):
        items: Sequence[Any] = value  # pyright: ignore[reportUnknownVariableType]
        return "[" + ", ".join(toml(f"{name}[{i}]", item) for i, item in enumerate(items)) + "]"
    help = "give a bool, a number, a string, a path, or a list or dictionary of these"
    raise invalid(name, f"a value of type {type(value).__name__} is none that a capture file can hold", help)
