"""What tests share: small scenes, and the command to compare with."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path
from typing import Callable

import pytest

#: A wall above a floor.
ROOM_OBJ = "v -1 0 -1\nv 1 0 -1\nv 1 0 1\nv -1 0 1\nv -1 1 -1\nv 1 1 -1\nf 1 4 3 2\nf 1 2 6 5\n"
ROOM = """
[scene]
geometry = ["room.obj"]
environment = { illuminant = "D65", illuminance_lux = 500 }
[camera]
position_m = [0, 0.5, 3]
look_at_m = [0, 0.5, 0]
[sensor]
resolution_px = [64, 48]
[exposure]
time_s = 0.01
[render]
samples_per_pixel = 4
seed = 7
"""


@pytest.fixture
def room(tmp_path: Path) -> Path:
    """The capture file of a small room."""
    (tmp_path / "room.obj").write_text(ROOM_OBJ)
    (tmp_path / "capture.toml").write_text(ROOM)
    return tmp_path / "capture.toml"


@pytest.fixture
def command() -> "Callable[..., str]":
    """Runs the program that PHOTOSITE_BINARY names, else that of the package, and returns what it prints."""
    binary = os.environ.get("PHOTOSITE_BINARY")
    program = [binary] if binary else [sys.executable, "-m", "photosite"]

    def run(*arguments: "str | Path") -> str:
        done = subprocess.run([*program, *map(str, arguments)], capture_output=True, text=True, timeout=120, check=False)
        assert done.returncode == 0, done.stderr
        return done.stdout

    return run
