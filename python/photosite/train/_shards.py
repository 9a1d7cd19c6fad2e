"""Shards of a folder: which frames each holds, and how they are written."""

from __future__ import annotations

import importlib
import json
import math
import os
import tempfile
import warnings
from collections.abc import Callable, Sequence
from pathlib import Path as FilePath
from typing import Any, Optional, Protocol

from .. import __version__
from .._arguments import Path, invalid, path_of
from .._errors import Error, FileError, InputError, PhotositeWarning
from ._samples import Sample, SampleFrames

#: The file that says what the folder holds.
SETTINGS = "layout.json"
#: Most bytes of a shard where nothing else is asked for, MiB.
_DEFAULT_MB = 256


class Format(Protocol):
    """A kind of file."""

    @property
    def name(self) -> str:
        """What it is called."""
        ...

    @property
    def affixes(self) -> "tuple[str, str]":
        """What stands before and after the number of a shard."""
        ...

    def check(self, cameras: "Sequence[str]") -> None:
        """Refuses cameras that the format cannot tell apart, or that its packages are missing."""

    def write(self, path: FilePath, samples: "Sequence[Sample]") -> None:
        """Writes a file."""

    def finish(self, folder: FilePath, shards: "Sequence[FilePath]") -> None:
        """Writes what describes all shards."""


def write_shards(format: Format, dataset: Path, output: Path, shard_mb: Optional[int], shard_frames: Optional[int]) -> int:
    """Writes those shards of a data set that a folder lacks, and counts them."""
    if shard_mb is not None and shard_frames is not None:
        raise invalid("shard_frames", "a shard is either of so many frames or of so many MiB", "leave one of them out")
    for name, size in (("shard_mb", shard_mb), ("shard_frames", shard_frames)):
        if size is not None and size < 1:
            raise invalid(name, f"expected at least 1, got {size}")
    frames = SampleFrames(FilePath(path_of("dataset", dataset)))
    format.check(frames.cameras)
    folder = FilePath(path_of("output", output))
    try:
        settings = _settings(format, frames, folder, shard_mb, shard_frames)
        per_shard = settings["frames_per_shard"]
        paths = [shard_path(format, folder, number) for number in range(-(-len(frames) // per_shard))]
        written = 0
        for number, path in enumerate(paths):
            if path.exists():
                continue
            of_shard = range(number * per_shard, min((number + 1) * per_shard, len(frames)))
            samples = [sample for frame in of_shard for sample in frames[frame]]
            _write_whole(path, lambda partial: format.write(partial, samples))
            written += 1
        format.finish(folder, paths)
    except OSError as reason:
        path = FilePath(reason.filename or folder)
        raise FileError(f"{path}: cannot write: {reason}", file=path, reason=str(reason)) from reason
    return written


def shard_path(format: Format, folder: FilePath, number: int) -> FilePath:
    """The file of a shard."""
    before, after = format.affixes
    return folder / f"{before}{number:06}{after}"


def _settings(
    format: Format, frames: SampleFrames, folder: FilePath, shard_mb: Optional[int], shard_frames: Optional[int]
) -> "dict[str, Any]":
    """What the folder has recorded, or now records."""
    wanted: "dict[str, Any]" = {
        "photosite_version": __version__,
        "format": format.name,
        "fingerprint": frames.fingerprint,
        "frames": len(frames),
    }
    path = folder / SETTINGS
    if not path.exists():
        if folder.is_dir() and any(not name.startswith(".") for name in os.listdir(folder)):
            raise _elsewhere(folder, f"is not empty and has no {SETTINGS}")
        folder.mkdir(parents=True, exist_ok=True)
        limit = None if shard_frames else shard_mb or _DEFAULT_MB
        count = shard_frames or frames_within(limit or 0, _bytes_of_a_frame(format, frames, folder))
        wanted.update(frames_per_shard=max(1, min(count, len(frames))), limit_mb=limit)
        text = json.dumps(wanted, indent=2) + "\n"
        _write_whole(path, lambda partial: partial.write_text(text, encoding="utf-8"))
        return wanted
    try:
        found: "dict[str, Any]" = json.loads(path.read_text(encoding="utf-8"))
        if int(found["frames_per_shard"]) < 1:
            raise ValueError("a shard without frames")
        differing = [key for key, value in wanted.items() if found[key] != value]
    except (ValueError, KeyError, TypeError) as reason:
        message = f"is damaged: {reason}"
        help = "remove the folder, whose files can be made again from the data set"
        raise InputError(f"{path}: {message}", file=path, reason=message, help=help) from reason
    if differing:
        key = differing[0]
        raise _elsewhere(folder, f"has shards of another {key.replace('_', ' ')}: {found[key]!r}, and not {wanted[key]!r}")
    if shard_frames is not None and (found["frames_per_shard"], found["limit_mb"]) != (shard_frames, None):
        raise _elsewhere(folder, f"has shards of {found['frames_per_shard']} frames, and not of {shard_frames}")
    if shard_mb is not None and found["limit_mb"] != shard_mb:
        raise _elsewhere(folder, f"has shards of at most {found['limit_mb']} MiB, and not of {shard_mb}")
    return found


def frames_within(limit_mb: int, bytes_of_a_frame: int) -> int:
    """How many frames of this size a shard gets: with a tenth of it left for frames that are larger, and one digit that
    is not 0, so that the number seldom depends on which frame is the first."""
    most = (limit_mb << 20) // 10 * 9 // max(bytes_of_a_frame, 1)
    power: int = 10 ** int(math.log10(max(most, 1)))
    return max(most // power * power, 1)


def _bytes_of_a_frame(format: Format, frames: SampleFrames, folder: FilePath) -> int:
    with tempfile.TemporaryDirectory(prefix=".first.", dir=folder) as scratch:
        path = FilePath(scratch) / "first"
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", PhotositeWarning)
            format.write(path, frames[0])
        return path.stat().st_size


def _write_whole(path: FilePath, write: "Callable[[FilePath], object]") -> None:
    """A file that appears when it is complete; of several processes that write one, the last counts, with the same
    bytes."""
    handle, name = tempfile.mkstemp(prefix=f".{path.name}.", suffix=".partial", dir=path.parent)
    os.close(handle)
    try:
        write(FilePath(name))
        # Temporary files are private.
        os.chmod(name, 0o644)
        os.replace(name, path)
    except BaseException:
        os.remove(name)
        raise


def _elsewhere(folder: FilePath, reason: str) -> InputError:
    return InputError(f"{folder}: {reason}", file=folder, reason=reason, help="choose a new folder for the shards")


def left_out(what: str) -> None:
    """Warns of what a format has no place for."""
    warnings.warn(what, PhotositeWarning, stacklevel=2)


def package(name: str) -> Any:
    """A package that writes shards.

    Raises:
        Error: it is not installed.
    """
    try:
        return importlib.import_module(name)
    except ImportError as reason:
        message = f"shards for training need the package {name.split('.')[0]}, which is not installed"
        raise Error(message, help='pip install "photosite[train]"') from reason
