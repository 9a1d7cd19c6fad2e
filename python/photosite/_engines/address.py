"""Addresses of clusters."""

from __future__ import annotations

import re
import socket

from .._errors import Error

__all__ = ["check_reachable", "unreachable"]

#: For a machine to answer.
_ANSWER_S = 5.0


def unreachable(address: str, why: str) -> Error:
    """The error of a cluster that does not answer."""
    reason = f"no cluster answers at {address!r}: {why}"
    help = "give the address that the cluster printed when it started, and check that this machine can reach it"
    return Error(f"address: {reason}", file="<python>", key="address", reason=reason, help=help, is_temporary=True)


def check_reachable(address: str) -> None:
    """Looks whether anything listens at HOST:PORT, for which some engines wait very long. Other forms are theirs."""
    found = re.fullmatch(r"(?:\w+://)?\[?([^/\]]+?)\]?:(\d+)/?", address)
    if found is None:
        return
    try:
        socket.create_connection((found[1], int(found[2])), timeout=_ANSWER_S).close()
    except (OSError, OverflowError) as refused:
        raise unreachable(address, str(refused)) from None
