"""What tests share: small scenes, the command to compare with, and what it has rendered."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path
from typing import Callable

import pytest

ROOT = Path(__file__).resolve().parents[2]
CORNELL_BOX = ROOT / "scenes/cornell-box/capture.toml"

Command = Callable[..., "subprocess.CompletedProcess[str]"]

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


@pytest.fixture(scope="session")
def command() -> Command:
    """Runs the program that the environment variable PHOTOSITE_BINARY names, else that of the package."""
    binary = os.environ.get("PHOTOSITE_BINARY")
    program = [binary] if binary else [sys.executable, "-m", "photosite"]

    def run(*arguments: object, status: int = 0) -> "subprocess.CompletedProcess[str]":
        done = subprocess.run([*program, *map(str, arguments)], capture_output=True, text=True, check=False)
        assert done.returncode == status, done.stderr
        return done

    return run


@pytest.fixture(scope="session")
def rendered(command: Command, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder that the command has rendered: small, few samples, all kinds of files."""
    folder = tmp_path_factory.mktemp("rendered") / "out"
    keys = {
        "sensor.resolution_px": "[64, 48]",
        "render.samples_per_pixel": "2",
        "output.raw": '["dng", "tiff", "pgm", "npy", "exr"]',
    }
    changes = [part for key, value in keys.items() for part in ("--set", f"{key}={value}")]
    command("render", CORNELL_BOX, "-o", folder, "-q", *changes)
    return folder


#: A rig of two cameras before a board.
BOARD = """
[[targets]]
type = "chessboard"
name = "board"
squares = [6, 5]
square_mm = 40
[scene]
environment = { illuminant = "D65", illuminance_lux = 1000 }
[camera]
position_m = [0, 0, 1]
look_at_m = [0, 0, 0]
[lens]
type = "pinhole"
focal_length_mm = 6
f_number = 4
focus_distance_m = "infinity"
[sensor]
preset = "generic-cmos-color"
resolution_px = [40, 30]
pixel_pitch_um = [100, 100]
[exposure]
auto = true
[render]
samples_per_pixel = 2
[output]
truth = ["depth", "normal", "instance"]
noise = ["prnu_e"]
electrons = true
"""
SET = """
capture = "board.toml"
frames = 5
seed = 1
[[cameras]]
name = "left"
[[cameras]]
name = "right"
position_m = [0.1, 0, 0]
look_at_m = [0.05, 0, -1]
[poses.random]
target = "board"
distance_m = [0.8, 1.2]
tilt_deg = [10, 30]
"""


@pytest.fixture
def file(tmp_path: Path) -> Path:
    """The file of a small data set."""
    (tmp_path / "board.toml").write_text(BOARD)
    (tmp_path / "set.toml").write_text(SET)
    return tmp_path / "set.toml"


def contents(folder: Path) -> "dict[str, bytes]":
    """All files of a data set but locks."""
    files = (path for path in folder.rglob("*") if path.is_file() and not path.name.startswith("."))
    return {str(path.relative_to(folder)): path.read_bytes() for path in files}
