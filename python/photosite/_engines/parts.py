"""Folders of parts, each some samples of every pixel, which go when images are made of them."""

from __future__ import annotations

import os
import shutil
from pathlib import Path

from .. import _photosite

__all__ = ["part_folder", "parts_present", "remove_needless", "remove_parts", "sample_ranges"]

#: The folder of such folders. It is not part of a data set's folder.
_PARTS = ".photosite-parts"


def part_folder(output: str, first: int, end: int) -> str:
    """The folder of a range of samples."""
    return os.path.join(output, _PARTS, f"{first:06}-{end:06}")


def sample_ranges(output: str) -> "list[tuple[int, int]]":
    """The ranges of samples of which there are folders, in order."""
    names = [folder.name.split("-") for folder in Path(output, _PARTS).glob("[0-9]*-[0-9]*")]
    return sorted((int(first), int(end)) for first, end in names)


def parts_present(
    dataset: "_photosite.Dataset", output: str, frames: "list[int]"
) -> "dict[int, list[tuple[int, int]]]":
    """The ranges of samples of each frame that are there, in order."""
    found: "dict[int, list[tuple[int, int]]]" = {frame: [] for frame in frames}
    for first, end in sample_ranges(output):
        missing = dataset.missing(part_folder(output, first, end), frames)
        for frame in set(frames).difference(missing):
            found[frame].append((first, end))
    return found


def remove_parts(dataset: "_photosite.Dataset", folders: "list[str]", frames: "list[int]") -> None:
    """Removes the parts of images that are whole now: they take much disk."""
    for folder in folders:
        for camera in dataset.cameras():
            for frame in frames:
                shutil.rmtree(os.path.join(folder, camera, f"{frame:06}"), ignore_errors=True)


def remove_needless(dataset: "_photosite.Dataset", output: str) -> None:
    """Removes all folders of parts if no image that is missing has any."""
    parts = Path(output, _PARTS)
    frames = {int(image.name) for image in parts.glob("*/*/[0-9]*")}
    if parts.exists() and not dataset.missing(output, sorted(frames)):
        shutil.rmtree(parts, ignore_errors=True)
