"""Calibration targets, and where points appear in an image."""

from __future__ import annotations

import json
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt

from . import _photosite
from ._arguments import Path, as_array, assignments, invalid, path_of
from ._capture import CaptureLike, loaded

__all__ = ["Marker", "Targets", "project", "unproject"]


@dataclass(frozen=True, eq=False)
class Marker:
    """A marker of a target.

    Attributes:
        dictionary: OpenCV's name of the dictionary that its pattern is from.
        id: its number there.
        corners_m: (4, 3) float64, clockwise from the marker's own top-left corner, as OpenCV detects them, m.
    """

    dictionary: str
    id: int
    corners_m: "npt.NDArray[np.float64]"


class Targets:
    """A calibration target: a flat sheet with a pattern of exact edges, whose points are known.

    Coordinates are those of the sheet, as OpenCV has them: x to the right and y down along its front, z = 0, metres. The
    origin is where OpenCV puts that of the same pattern's object points, and points stand in OpenCV's order.

    Args:
        kind: ``"chessboard"``, ``"charuco"``, ``"marker-grid"``, ``"aprilgrid"``, ``"circle-grid"`` and more:
            :meth:`kinds` lists them.
        **keys: its sizes, as the table ``[[targets]]`` of capture files has them: ``squares=[10, 7], square_mm=25``.

    Raises:
        InputError: a kind or a key that does not exist, sizes that are impossible.
    """

    def __init__(self, kind: str, /, **keys: Any) -> None:
        compiled = _photosite.Target.draw(str(kind), assignments(keys))
        if compiled is None:
            raise invalid("kind", f"there is no target {kind!r}", f"write one of {', '.join(self.kinds())}")
        self._kind, self._given, self._compiled = str(kind), dict(keys), compiled

    @staticmethod
    def kinds() -> "dict[str, str]":
        """The kinds of targets by their names, and what they are."""
        return dict(_photosite.Target.kinds())

    @cached_property
    def _facts(self) -> "dict[str, Any]":
        facts: "dict[str, Any]" = json.loads(self._compiled.facts())
        return facts

    @property
    def kind(self) -> str:
        """What it is."""
        return self._kind

    @property
    def keys(self) -> "dict[str, Any]":
        """All its keys, with ``type``: with a position a table of ``[[targets]]``."""
        return dict(self._facts["target"])

    @property
    def size_m(self) -> "tuple[float, float]":
        """Width and height of the sheet, m."""
        width, height = self._compiled.size_m()
        return width, height

    @cached_property
    def points_m(self) -> "npt.NDArray[np.float64]":
        """The points that a calibration finds, (N, 3), m: what ``cv2.calibrateCamera`` takes as object points."""
        points = self._compiled.points_m()
        points.flags.writeable = False
        return points

    @property
    def ids(self) -> "tuple[str, ...]":
        """What the points are called: their numbers, or what they are the corners of."""
        return tuple(point["name"] for point in self._facts["points"])

    @cached_property
    def markers(self) -> "tuple[Marker, ...]":
        """The markers, by their place on the board."""
        corners = self._compiled.corners_m().reshape(-1, 4, 3)
        corners.flags.writeable = False
        return tuple(Marker(m["dictionary"], m["id"], corners[i]) for i, m in enumerate(self._facts["markers"]))

    def save(self, path: Path) -> None:
        """Writes a file, in the place of an older one, as ``photosite target`` does.

        Args:
            path: ``.svg`` and ``.pdf`` are pages in true size, ``.toml`` is a capture file that photographs the target,
                ``.obj`` (with ``.mtl``) its mesh, ``.json`` its points and markers.

        Raises:
            InputError: another extension.
            FileError: the file cannot be written.
        """
        self._compiled.save(path_of("path", path))

    def __reduce__(self) -> Any:
        return _unpickle, (self._kind, self._given)

    def __repr__(self) -> str:
        width, height = (1e3 * side for side in self.size_m)
        return f"<Targets {self._kind}: {width:g} × {height:g} mm, {len(self.points_m)} points, {len(self.markers)} markers>"


def _unpickle(kind: str, keys: "dict[str, Any]") -> Targets:
    return Targets(kind, **keys)


def project(capture: CaptureLike, points: "npt.ArrayLike", *, camera_space: bool = False) -> "npt.NDArray[np.float64]":
    """Where points appear in the image of a capture's camera, through the whole lens.

    Args:
        capture: a capture as :func:`load` makes it, or what that takes.
        points: (N, 3) or (3,), m, in the world.
        camera_space: the points are in the camera's coordinates of OpenCV instead: x right, y down, z forward.

    Returns:
        (N, 2) or (2,) float64, column and row, whole numbers at the centres of pixels, of the sensor before
        ``exposure.region_px`` and binning; NaN for what the lens does not show. A camera that moves sees each point in
        the middle of the exposure of its row.

    Raises:
        InputError: points that are not rows of three numbers, a camera without a lens.
    """
    numbers = _rows("points", points, 3)
    found = _photosite.project(loaded(capture)._compiled, numbers.reshape(-1, 3), bool(camera_space))
    return found.reshape(numbers.shape[:-1] + (2,))


def unproject(capture: CaptureLike, pixels: "npt.ArrayLike", *, camera_space: bool = False) -> "npt.NDArray[np.float64]":
    """What pixels of a capture's camera look at: the inverse of :func:`project`.

    Args:
        capture: a capture as :func:`load` makes it, or what that takes.
        pixels: (N, 2) or (2,), column and row, whole numbers at the centres of pixels.
        camera_space: directions in the camera's coordinates of OpenCV, x right, y down, z forward, instead of the world's.

    Returns:
        (N, 3) or (3,) float64, unit vectors; NaN for pixels that see nothing.

    Raises:
        InputError: pixels that are not rows of two numbers, a camera without a lens.
    """
    numbers = _rows("pixels", pixels, 2)
    found = _photosite.unproject(loaded(capture)._compiled, numbers.reshape(-1, 2), bool(camera_space))
    return found.reshape(numbers.shape[:-1] + (3,))


def _rows(name: str, value: Any, length: int) -> "npt.NDArray[np.float64]":
    """Rows of so many numbers each, or one of them."""
    shape = f"(N, {length})"
    if getattr(value, "shape", None) == (0, length):
        return np.empty((0, length), np.float64)
    array = as_array(name, value, (1, 2), shape)
    if array.shape[-1] != length:
        raise invalid(name, f"expected an array {shape}, got one of shape {array.shape}")
    if array.dtype.kind not in "uif":
        raise invalid(name, f"expected real numbers, got an array of {array.dtype}")
    return np.ascontiguousarray(array, np.float64)
