"""Images of a finished data set, as shards take them."""

from __future__ import annotations

import json
import struct
import zlib
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, Optional

import numpy as np
import numpy.typing as npt

from .. import _photosite
from .._dataset import FramePicture
from .._errors import InputError
from .._raw import Raw

#: Layers of ground truth that count things.
_COUNTS = ("instance", "material")


@dataclass(frozen=True)
class Sample:
    """An image with its raw image, its ground truth and its camera.

    Attributes:
        facts: camera, frame, ``time_s``, ``stamp_ns``, pose, camera matrix and lens, as the program reads them from
            ``capture.json``: of the middle of the exposure, on the pixels of the image.
        image: its folder.
    """

    facts: "dict[str, Any]"
    picture: FramePicture

    @property
    def camera(self) -> str:
        """The name of the camera."""
        return str(self.facts["camera"])

    @property
    def frame(self) -> int:
        """The number of the frame."""
        return int(self.facts["frame"])

    @cached_property
    def report(self) -> bytes:
        """``capture.json``."""
        return (self.picture.folder / "capture.json").read_bytes()

    @cached_property
    def image(self) -> Optional[bytes]:
        """``image.png``, where there is one."""
        path = self.picture.folder / "image.png"
        if path not in self.picture.files:
            return None
        png = path.read_bytes()
        # The header of a PNG file states columns and rows at byte 16.
        self._check(path, struct.unpack(">II", png[16:24])[::-1])
        return png

    @cached_property
    def raw(self) -> Optional[Raw]:
        """The raw image, where there is one."""
        if not any(file.name.startswith("raw") for file in self.picture.files):
            return None
        raw = self.picture.raw
        self._check(self.picture.folder, raw.active.shape[:2])
        return raw

    @cached_property
    def truth(self) -> "dict[str, npt.NDArray[Any]]":
        """Layers of ground truth by their names: float32, uint32 of those that count things."""
        layers = {name: np.asarray(layer) for name, layer in sorted(self.picture.truth.items())}
        for layer in layers.values():
            self._check(self.picture.folder, layer.shape[:2])
        return {name: layer.astype(np.uint32) if name in _COUNTS else layer for name, layer in layers.items()}

    def _check(self, path: Path, shape: "Sequence[int]") -> None:
        columns, rows = self.facts["resolution_px"]
        if tuple(shape) != (rows, columns):
            reason = f"has {shape[1]} x {shape[0]} pixels, and its camera {columns} x {rows}"
            raise InputError(f"{path}: {reason}", file=path, reason=reason, help="make the frame again")


class SampleFrames:
    """The frames of a finished data set.

    Args:
        folder: the folder that ``photosite dataset`` has filled to the end.

    Attributes:
        fingerprint: that of the data set.
        cameras: names of the cameras.

    Raises:
        InputError: a data set that is not whole, or whose images show things in other places than ground truth.
    """

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        shots: "list[dict[str, Any]]" = json.loads(_photosite.shots(str(folder)))
        lines = [json.loads(line) for line in (folder / "manifest.jsonl").read_text(encoding="utf-8").splitlines()]
        self._times = {(line["camera"], line["frame"]): line["time_s"] for line in lines}
        self.fingerprint: str = json.loads((folder / "dataset.json").read_text(encoding="utf-8"))["fingerprint"]
        self.cameras = tuple(dict.fromkeys(str(shot["camera"]) for shot in shots))
        self._frames: "dict[int, list[dict[str, Any]]]" = {}
        for shot in shots:
            self._frames.setdefault(shot["frame"], []).append(shot)

    def __len__(self) -> int:
        return len(self._frames)

    def __getitem__(self, frame: int) -> "list[Sample]":
        return [self._sample(shot) for shot in self._frames[frame]]

    def _sample(self, shot: "dict[str, Any]") -> Sample:
        folder = self._folder / shot["folder"]
        picture = FramePicture(folder, shot["camera"], shot["frame"])
        facts = {key: value for key, value in shot.items() if key != "folder"}
        facts.update(time_s=self._times[shot["camera"], shot["frame"]], seed=picture.report["seed"])
        sample = Sample(facts, picture)
        if sample.image is None and sample.raw is None:
            reason = "has neither image.png nor a raw file"
            help = 'make the data set with output.image = true or output.raw = ["dng"]'
            raise InputError(f"{folder}: {reason}", file=folder, reason=reason, help=help)
        return sample


def grey_png(values: "npt.NDArray[np.uint16]") -> bytes:
    """A grey PNG file of 16 bits, which readers of images give back as it is."""

    def chunk(name: bytes, data: bytes) -> bytes:
        return struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))

    rows, columns = values.shape
    # Each row begins with its filter, of which 0 is none.
    lines = np.zeros((rows, 1 + 2 * columns), np.uint8)
    lines[:, 1:] = values.astype(">u2").view(np.uint8).reshape(rows, 2 * columns)
    header = struct.pack(">IIBBBBB", columns, rows, 16, 0, 0, 0, 0)
    parts = ((b"IHDR", header), (b"IDAT", zlib.compress(lines.tobytes(), 6)), (b"IEND", b""))
    return b"\x89PNG\r\n\x1a\n" + b"".join(chunk(*part) for part in parts)
