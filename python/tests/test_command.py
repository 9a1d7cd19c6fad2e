"""The command of the package does what the program does: the same files, words and exit statuses."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import sysconfig
import time
from pathlib import Path
from typing import Any

import pytest

import photosite

COMMAND = os.path.join(sysconfig.get_path("scripts"), "photosite")


@pytest.fixture
def folder(room: Path) -> Path:
    """The folder of the room's capture."""
    return room.parent


def run(*arguments: str, program: str = COMMAND, **how: Any) -> "subprocess.CompletedProcess[str]":
    return subprocess.run([program, *arguments], capture_output=True, text=True, timeout=60, **how)


def until(is_there: Any, process: "subprocess.Popen[str]") -> None:
    while not is_there():
        assert process.poll() is None, "it ended too early"
        time.sleep(0.005)


def endless(folder: Path, *before: str) -> "subprocess.Popen[str]":
    """A render that takes longer than anybody waits for, once it has begun to trace."""
    command = [COMMAND, "render", "capture.toml", "--quiet", "-o", "out", "--set", "render.samples_per_pixel=4000000000"]
    command += ["--set", "output.preview_interval_s=0.01"]
    process = subprocess.Popen([*before, *command], cwd=folder, stderr=subprocess.PIPE, text=True)
    until((folder / "out" / "preview.png").exists, process)
    return process


def test_version_by_either_name() -> None:
    expected = f"photosite {photosite.__version__}\n"
    assert run("--version").stdout == expected
    assert run("-m", "photosite", "--version", program=sys.executable).stdout == expected


def test_help_names_the_command_however_it_is_called() -> None:
    for outcome in (run("render", "--help"), run("-m", "photosite", "render", "--help", program=sys.executable)):
        assert outcome.returncode == 0 and "Usage: photosite render " in outcome.stdout


def test_wrong_usage() -> None:
    outcome = run("render", "--colour")
    assert outcome.returncode == 2 and outcome.stdout == "" and "--colour" in outcome.stderr


def test_failure(folder: Path) -> None:
    outcome = run("render", "missing.toml", cwd=folder)
    assert outcome.returncode == 1 and outcome.stdout == "" and "missing.toml" in outcome.stderr
    outcome = run("render", "capture.toml", "--set", "lens.f_nummer=2", cwd=folder)
    assert outcome.returncode == 1 and "did you mean `f_number`?" in outcome.stderr


def test_pictures_that_differ(folder: Path) -> None:
    for seed in "12":
        assert run("render", "capture.toml", "--quiet", "-o", seed, "--set", f"render.seed={seed}", cwd=folder).returncode == 0
    outcome = run("compare", "1/electrons.exr", "2/electrons.exr", "--max-rmse", "1e-9", cwd=folder)
    assert outcome.returncode == 1 and outcome.stderr == ""
    assert run("compare", "1/electrons.exr", "1/electrons.exr", "--max-rmse", "1e-9", cwd=folder).returncode == 0


def test_names_that_are_no_text(folder: Path) -> None:
    name = os.fsdecode(b"out-\xff")
    assert run("render", "capture.toml", "--quiet", "-o", name, cwd=folder).returncode == 0
    assert (folder / name / "raw.dng").exists()


@pytest.mark.skipif("PHOTOSITE_BINARY" not in os.environ, reason="PHOTOSITE_BINARY does not name the program")
@pytest.mark.parametrize("threads", ["1", "2"])
def test_same_as_the_program(folder: Path, threads: str) -> None:
    both = {}
    for program in (os.environ["PHOTOSITE_BINARY"], COMMAND):
        arguments = ("--threads", threads, "render", "capture.toml", "--quiet", "--force", "-o", "out")
        outcome = run(*arguments, cwd=folder, program=program)
        assert (outcome.returncode, outcome.stdout, outcome.stderr) == (0, "", "")
        files = {path.name: path.read_bytes() for path in (folder / "out").iterdir()}
        report = json.loads(files.pop("capture.json"))
        del report["timings"], report["paths_per_s"]
        both[program] = (report, files)
        assert set(files) == {"raw.dng", "electrons.exr", "image.png"}
    by_program, by_package = both.values()
    assert by_program == by_package


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_signals_leave_a_checkpoint(folder: Path, number: signal.Signals) -> None:
    process = endless(folder)
    process.send_signal(number)
    words = process.communicate(timeout=30)[1]
    assert process.returncode == 128 + number and f"stopped by {number.name}" in words and "Traceback" not in words
    assert [path.name for path in (folder / "out").iterdir()] == ["checkpoint.film"]


def test_a_signal_that_is_ignored_stays_so(folder: Path) -> None:
    process = endless(folder, "sh", "-c", 'trap "" INT; exec "$0" "$@"')
    process.send_signal(signal.SIGINT)
    time.sleep(0.3)
    assert process.poll() is None
    process.terminate()
    process.communicate(timeout=30)
    assert process.returncode == 143


def test_a_reader_that_has_seen_enough() -> None:
    shell = f'"{COMMAND}" schema | head -1; "{COMMAND}" --help | head -1'
    outcome = run("-c", shell, program="sh")
    assert outcome.returncode == 0 and outcome.stderr == "" and outcome.stdout.startswith("{\n")
