"""Where pictures go: a folder that all machines see, or a place in a store."""

from __future__ import annotations

import json
import os
import shutil
from pathlib import Path
from typing import Protocol

from .. import _photosite
from .task import Failure, Job, Task

__all__ = ["Folder", "Output", "failures_of", "fingerprint_in", "open_output", "part_folder", "told"]


#: The folder for folders of samples, which goes when pictures are made of them. It is not part of a data set's folder.
_PARTS = ".photosite-parts"


class Output(Protocol):
    """A place for pictures."""

    def claim(self, dataset: "_photosite.Dataset") -> str:
        """Takes it for the data set, and returns the fingerprint of what it is for."""
        ...

    def missing(self, dataset: "_photosite.Dataset", frames: "list[int]") -> "list[int]":
        """Which of these frames are not there."""
        ...

    def make(self, dataset: "_photosite.Dataset", job: Job, task: Task) -> "tuple[list[Failure], list[str]]":
        """Makes what is missing of a task."""
        ...

    def finish(self, dataset: "_photosite.Dataset") -> "list[str]":
        """Writes the summary of what is there, and tells what users should know of it."""
        ...


def open_output(output: str) -> Output:
    """The place of that name."""
    if "://" in output:
        from .store import Store

        return Store(output)
    return Folder(output)


class Folder:
    """A folder that all machines see."""

    def __init__(self, path: str) -> None:
        self.path = path

    def claim(self, dataset: "_photosite.Dataset") -> str:
        dataset.claim(self.path)
        return fingerprint_in(self.path)

    def missing(self, dataset: "_photosite.Dataset", frames: "list[int]") -> "list[int]":
        return dataset.missing(self.path, frames)

    def make(self, dataset: "_photosite.Dataset", job: Job, task: Task) -> "tuple[list[Failure], list[str]]":
        if task.samples is not None:
            first, end = task.samples
            folder = part_folder(self.path, first, end)
            told = dataset.make_part(folder, task.frames, (first, end), job.path, job.threads)
        elif task.parts:
            folders = [part_folder(self.path, first, end) for first, end in task.parts]
            told = dataset.merge(self.path, task.frames, folders, job.threads)
            if not told[0]:
                self._remove_parts(dataset, folders, task.frames)
        else:
            told = dataset.make(self.path, task.frames, job.threads)
        return failures_of(told[0]), told[1]

    def finish(self, dataset: "_photosite.Dataset") -> "list[str]":
        _, left_out, warnings = dataset.write_index(self.path)
        parts = Path(self.path, _PARTS)
        frames = {int(picture.name) for picture in parts.glob("*/*/[0-9]*")}
        if parts.exists() and not dataset.missing(self.path, sorted(frames)):
            # Nothing depends on them any more.
            shutil.rmtree(parts, ignore_errors=True)
        return told(left_out, warnings)

    def _remove_parts(self, dataset: "_photosite.Dataset", folders: "list[str]", frames: "list[int]") -> None:
        """Removes the parts of pictures that are whole now: they take much disk."""
        for folder in folders:
            for camera in dataset.cameras():
                for frame in frames:
                    shutil.rmtree(os.path.join(folder, camera, f"{frame:06}"), ignore_errors=True)

    def sample_ranges(self) -> "list[tuple[int, int]]":
        """The ranges of samples of which there are folders, in order."""
        names = [folder.name.split("-") for folder in Path(self.path, _PARTS).glob("[0-9]*-[0-9]*")]
        return sorted((int(first), int(end)) for first, end in names)

    def parts(self, dataset: "_photosite.Dataset", frames: "list[int]") -> "dict[int, list[tuple[int, int]]]":
        """The ranges of samples of each frame that are there, in order."""
        found: "dict[int, list[tuple[int, int]]]" = {frame: [] for frame in frames}
        for first, end in self.sample_ranges():
            missing = dataset.missing(part_folder(self.path, first, end), frames)
            for frame in set(frames).difference(missing):
                found[frame].append((first, end))
        return found


def part_folder(output: str, first: int, end: int) -> str:
    """The folder of a range of samples."""
    return os.path.join(output, _PARTS, f"{first:06}-{end:06}")


def failures_of(told: "list[tuple[int, str, bool]]") -> "list[Failure]":
    """Failures as the library tells them."""
    return [Failure(*failure) for failure in told]


def told(left_out: "list[str]", warnings: "list[str]") -> "list[str]":
    """What users should know of the whole: files that are left out, and what is said of its pictures."""
    return [f"calibration/ is without {why.replace('`', '')}" for why in left_out] + warnings


def fingerprint_in(folder: str) -> str:
    """What the folder of a data set is for."""
    with open(os.path.join(folder, "dataset.json"), encoding="utf-8") as file:
        fingerprint: str = json.load(file)["fingerprint"]
    return fingerprint
