"""The page of all commands, made of what the program prints for `--help`."""

from __future__ import annotations

import os
import re
import shutil
import subprocess

BEGINNING = """\
# Commands

What `photosite COMMAND --help` prints. Files that commands take have pages of their own: [captures](capture.md),
[data sets](data-set.md), [sensors](sensor.md).
"""


def binary() -> str:
    found = os.environ.get("PHOTOSITE_BINARY") or shutil.which("photosite")
    if not found:
        raise SystemExit("The reference of commands needs the program: put photosite on the PATH, or its path into PHOTOSITE_BINARY.")
    return found


def help_of(command: "list[str]") -> str:
    environment = {**os.environ, "COLUMNS": "100"}
    told = subprocess.run([binary(), *command, "--help"], capture_output=True, text=True, check=True, env=environment)
    return told.stdout.rstrip()


def subcommands(text: str) -> "list[str]":
    # Those of the program itself come in groups with other headings.
    listed = text.split("\nOptions:\n")[0].split("Usage: ")[-1]
    names = re.findall(r"^  ([a-z][\w-]*)(?:  |$)", listed, re.MULTILINE)
    return [name for name in names if name != "help"]


def section(command: "list[str]") -> "list[str]":
    text = help_of(command)
    title = " ".join(["photosite", *command])
    lines = [f"{'##' if len(command) < 2 else '###'} `{title}` {{ #{'-'.join(command) or 'photosite'} }}", ""]
    lines += ["```text", text, "```", ""]
    for name in subcommands(text):
        lines += section([*command, name])
    return lines


def page() -> str:
    return BEGINNING + "\n" + "\n".join(section([])) + "\n"
