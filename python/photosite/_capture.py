"""Captures: a scene, the camera that looks at it, and what to make of it."""

from __future__ import annotations

import copy
import json
import os
from collections.abc import Mapping
from typing import Any, Optional, Union, cast

from . import _photosite
from ._arguments import Path, assignments, invalid, is_path, path_of
from ._scene_files import SceneFiles

__all__ = ["Capture", "load"]

#: What stands for a capture: one that is loaded, the path of a file, or the tables of one.
CaptureLike = Union["Capture", Path, "Mapping[str, Any]"]


class Capture:
    """A capture that is loaded and checked. It never changes: :meth:`set` gives another one.

    Made by :func:`load`. Captures can be pickled: one of a file by its path, one of a dictionary by what it holds.
    """

    def __init__(
        self, compiled: "_photosite.Capture", source: "Union[str, Mapping[str, Any]]", changes: "list[str]", files: Any
    ) -> None:
        self._compiled = compiled
        self._source = source
        self._changes = changes
        # Held on to: the files of its arrays are there as long as it is.
        self._files = files
        self._folder = os.getcwd()

    @property
    def resolution_px(self) -> "tuple[int, int]":
        """Columns and rows of the sensor."""
        columns, rows = self._compiled.resolution()
        return columns, rows

    @property
    def values(self) -> "dict[str, Any]":
        """All keys that were given, by the tables of the capture file, with changes and the sensor's preset laid over
        each other; paths are relative to the current folder."""
        values: "dict[str, Any]" = json.loads(self._compiled.values(os.getcwd()))
        return values

    def set(self, changes: "Mapping[str, Any]") -> "Capture":
        """The same capture with other values of some keys.

        Args:
            changes: values by their keys, as in ``{"lens.f_number": 8}``.

        Raises:
            InputError: an unknown key, or a value that it cannot have.
        """
        more = assignments(changes)
        if not more:
            return self
        if os.getcwd() != self._folder:
            # Relative paths, as they were typed, would lead elsewhere.
            return _again(self._source, self._changes + more)
        return Capture(self._compiled.changed(more), self._source, self._changes + more, self._files)

    def __reduce__(self) -> Any:
        return _again, (self._source, self._changes)

    def __repr__(self) -> str:
        name = f"{self._source!r}" if isinstance(self._source, str) else "of a dictionary"
        changes = f", {', '.join(self._changes)}" if self._changes else ""
        columns, rows = self.resolution_px
        return f"<photosite.Capture {name}{changes}, {columns} × {rows} px>"


def load(source: "Union[Path, Mapping[str, Any]]", *, set: "Optional[Mapping[str, Any]]" = None) -> Capture:
    """Loads a capture, and checks all of it.

    Args:
        source: a capture file (.toml), a report of one that was rendered (capture.json), a scene (.gltf, .glb, .obj, .ply,
            .stl), which then gets a camera, daylight, a lens and a sensor automatically; or a dictionary of what a capture file
            holds, with paths relative to the current folder. In a dictionary arrays may stand where files are named:

            - ``scene.geometry``: a dictionary of ``positions`` (N, 3) in m and ``triangles`` (M, 3), and if there are
              any ``normals`` (N, 3), ``uvs`` (N, 2) from the top-left corner of textures, ``material``, a name for
              ``[materials]``, and ``name``;
            - ``image`` of an environment: (H, W, 3) linear RGB;
            - ``texture``: (H, W) or (H, W, 3) codes, uint8 or uint16;
            - ``file`` of a spectrum: (N, 2), wavelengths in nm and values.
        set: values for some keys in place of the file's, as in ``{"exposure.time_s": 0.02}``.

    Raises:
        InputError: whatever is wrong with the file or one that it names, with key and line.
        FileError: a file that cannot be read.
    """
    changes = assignments({} if set is None else set)
    if isinstance(source, Mapping):
        # A capture never changes, whatever becomes of the dictionary.
        return _again(copy.deepcopy(dict(source)), changes)
    if not is_path(source):
        raise invalid("source", f"expected a path or a dictionary, got {type(cast(object, source)).__name__}")
    typed = path_of("source", source)
    return _again(os.path.abspath(typed), changes, typed)


def loaded(capture: CaptureLike) -> Capture:
    """A capture, loaded unless it is one."""
    return capture if isinstance(capture, Capture) else load(capture)


def _again(
    source: "Union[str, Mapping[str, Any]]", changes: "list[str]", typed: Optional[str] = None
) -> Capture:
    """Loads a capture; messages name its file as it was typed."""
    if isinstance(source, str):
        return Capture(_photosite.Capture.load(typed or source, changes), source, changes, None)
    files = SceneFiles()
    try:
        values = json.dumps(files.plain(source))
    except RecursionError:
        raise invalid("capture", "holds itself, or is too deep") from None
    return Capture(_photosite.Capture.of_values(values, "<python>", changes), source, changes, files)
