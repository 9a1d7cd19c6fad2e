"""Packages that only some engines and stores need."""

from __future__ import annotations

import importlib
from typing import Any

from .._errors import InputError

__all__ = ["needed"]


def needed(module: str, package: str, argument: str, value: str) -> Any:
    """A module that must be installed for the value of an argument."""
    try:
        return importlib.import_module(module)
    except ImportError as missing:
        reason = f"{value!r} needs the package {package}, which cannot be imported: {missing}"
        help = f'install it on all machines: pip install "{package}"'
        raise InputError(f"{argument}: {reason}", file="<python>", key=argument, reason=reason, help=help) from None
