"""Images of a data set that its manifest vouches for: they can be opened, and nothing is to be planned."""

from __future__ import annotations

import json
import os
import re
from typing import Any, Optional

__all__ = ["Manifest"]

#: How a line of an image begins, so that only those that are asked for are read whole.
_HEAD = re.compile(rb'\{"frame":(\d+),"frames":\d+,"camera":("(?:[^"\\]|\\.)*")')


class Manifest:
    """``manifest.jsonl`` of a folder, read again where it or ``dataset.json`` has changed."""

    def __init__(self, folder: str) -> None:
        self._paths = [os.path.join(folder, name) for name in ("dataset.json", "manifest.jsonl")]
        self._folder = folder
        self._stamps: "list[Any]" = []
        self._fingerprint: "Optional[str]" = None
        # Where the line of an image begins in the file.
        self._lines: "dict[tuple[int, str], int]" = {}

    def lists(self, frame: int, cameras: "tuple[str, ...]", fingerprint: str) -> bool:
        """Whether all images of a frame of the data set with that fingerprint are listed, and there in the listed
        sizes."""
        try:
            self._refresh()
            return self._fingerprint == fingerprint and all(self._is_whole(frame, camera) for camera in cameras)
        except (OSError, ValueError, KeyError, TypeError):
            # Whatever is wrong with it, the program says when it looks.
            self._stamps = []
            return False

    def _refresh(self) -> None:
        found = [os.stat(path) for path in self._paths]
        stamps = [(stat.st_mtime_ns, stat.st_size, stat.st_ino) for stat in found]
        if stamps == self._stamps:
            return
        identity, manifest = self._paths
        with open(identity, encoding="utf-8") as file:
            self._fingerprint = json.load(file)["fingerprint"]
        lines: "dict[tuple[int, str], int]" = {}
        begin = 0
        with open(manifest, "rb") as file:
            for line in file:
                head = _HEAD.match(line)
                frame, camera = (int(head[1]), json.loads(head[2])) if head else _of_line(line)
                lines[frame, camera] = begin
                begin += len(line)
        self._lines, self._stamps = lines, stamps

    def _is_whole(self, frame: int, camera: str) -> bool:
        begin = self._lines.get((frame, camera))
        if begin is None:
            return False
        with open(self._paths[1], "rb") as file:
            file.seek(begin)
            line = json.loads(file.readline())
        if (line["frame"], line["camera"]) != (frame, camera):
            return False
        sums = line["sums"]
        folder = os.path.join(self._folder, camera, f"{frame:06}")
        is_there = (os.stat(os.path.join(folder, name)).st_size == sums[name]["bytes"] for name in sums)
        return "capture.json" in sums and set(line["files"]) <= set(sums) and all(is_there)


def _of_line(line: bytes) -> "tuple[int, str]":
    picture = json.loads(line)
    return picture["frame"], picture["camera"]
