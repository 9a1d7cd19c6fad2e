"""The command ``photosite``, as the program of that name is."""

from __future__ import annotations

import signal
import sys

from ._photosite import cli

__all__ = ["main"]


def main() -> int:
    """Runs the command with the arguments of this process, and returns its exit status."""
    # Ctrl-C is the command's affair, which keeps a checkpoint. Where it is ignored, as in the background of a script,
    # it stays so.
    if signal.getsignal(signal.SIGINT) is not signal.SIG_IGN:
        signal.signal(signal.SIGINT, signal.SIG_DFL)
    return cli(["photosite", *sys.argv[1:]])
