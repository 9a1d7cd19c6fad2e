"""What tests share: the command, and what it has rendered."""

from __future__ import annotations

import os
import subprocess
from pathlib import Path
from typing import Callable

import pytest

ROOT = Path(__file__).resolve().parents[2]
CORNELL_BOX = ROOT / "scenes/cornell-box/capture.toml"

Command = Callable[..., "subprocess.CompletedProcess[str]"]


@pytest.fixture(scope="session")
def command() -> Command:
    """Runs the command ``photosite``, which the environment variable PHOTOSITE_BINARY names."""
    binary = os.environ.get("PHOTOSITE_BINARY")
    if not binary:
        pytest.skip("PHOTOSITE_BINARY does not name the command photosite")

    def run(*arguments: object, status: int = 0) -> "subprocess.CompletedProcess[str]":
        done = subprocess.run([binary, *map(str, arguments)], capture_output=True, text=True)
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
