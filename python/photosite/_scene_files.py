"""Arrays in the place of files: what a capture names as a file may be an array, which becomes a file of its own."""

from __future__ import annotations

import json
import os
import shutil
import struct
import tempfile
import weakref
from collections.abc import Mapping, Sequence
from difflib import get_close_matches
from typing import Any, Optional, cast

import numpy as np
import numpy.typing as npt

from . import _photosite
from ._arguments import as_array, floats, invalid

#: Keys whose text is the path of a file, by what kind of array may stand there.
_TABLES, _ENVIRONMENTS, _TEXTURES = ("file",), ("image",), ("texture",)


class SceneFiles:
    """A folder for the arrays of a capture, which is gone when nothing uses it any more."""

    def __init__(self) -> None:
        self._folder: Optional[str] = None
        self._count = 0

    def _new(self, extension: str) -> str:
        if self._folder is None:
            self._folder = tempfile.mkdtemp(prefix="photosite-")
            # A forked child that ends must leave it to its parent.
            weakref.finalize(self, _remove, self._folder, os.getpid())
        self._count += 1
        return os.path.join(self._folder, f"array-{self._count:04d}{extension}")

    def plain(self, value: Any, path: str = "", key: str = "") -> Any:
        """Values as JSON has them. Arrays and meshes where files are named become files; other arrays become lists."""
        if key == "geometry" and isinstance(value, Sequence) and not isinstance(value, str):
            items = cast("Sequence[Any]", value)
            return [self._geometry(item, f"{path}[{i}]") for i, item in enumerate(items)]
        if isinstance(value, np.ndarray):
            return self._array(cast("npt.NDArray[Any]", value), path, key)
        if isinstance(value, np.generic):
            value = value.item()
        if isinstance(value, os.PathLike):
            value = os.fspath(cast("os.PathLike[str]", value))
        if isinstance(value, Mapping):
            entries = cast("Mapping[Any, Any]", value)
            for name in entries:
                if not isinstance(name, str):
                    raise invalid(path or "capture", f"a key is {name!r}, which is not text")
            join = f"{path}." if path else ""
            return {name: self.plain(item, f"{join}{name}", name) for name, item in entries.items()}
        if isinstance(value, (list, tuple)):
            elements = cast("Sequence[Any]", value)
            return [self.plain(item, f"{path}[{i}]") for i, item in enumerate(elements)]
        if isinstance(value, float) and not np.isfinite(value):
            raise invalid(path, f"must be finite, got {value}")
        if isinstance(value, (bool, int, float, str)):
            return value
        if value is None:
            raise invalid(path, "a capture cannot hold None", "leave the key out")
        help = "give a bool, a number, a string, a path, an array, or a list or dictionary of these"
        raise invalid(path, f"a capture cannot hold a value of type {type(value).__name__}", help)

    def _array(self, value: "npt.NDArray[Any]", path: str, key: str) -> Any:
        if key in _TABLES:
            return self._table(value, path)
        if key in _ENVIRONMENTS:
            return self._environment(value, path)
        if key in _TEXTURES:
            return self._texture(value, path)
        return self.plain(value.tolist(), path)

    def _table(self, value: "npt.NDArray[Any]", path: str) -> str:
        """Numbers as the lines of a table: a spectrum has (N, 2), wavelengths in nm and values."""
        table = as_array(path, value, (2,), "(N, columns)").astype(np.float64)
        file = self._new(".csv")
        with open(file, "w", encoding="utf-8") as to:
            to.writelines(",".join(repr(float(x)) for x in row) + "\n" for row in table)
        return file

    def _environment(self, value: "npt.NDArray[Any]", path: str) -> str:
        """Linear RGB all around."""
        file = self._new(".exr")
        rgb = floats(path, value, "(H, W, 3)", (3,))
        if rgb.shape[2] != 3:
            raise invalid(path, f"expected an array (H, W, 3), got one of shape {rgb.shape}")
        _photosite.write_rgb(file, rgb)
        return file

    def _texture(self, value: "npt.NDArray[Any]", path: str) -> str:
        """Codes of a texture, grey or RGB, as a PGM or PPM file."""
        shape = "(H, W) or (H, W, 3)"
        codes = as_array(path, value, (2, 3), shape)
        if codes.ndim == 3 and codes.shape[2] != 3:
            raise invalid(path, f"expected an array {shape}, got one of shape {codes.shape}")
        if codes.dtype not in (np.dtype(np.uint8), np.dtype(np.uint16)):
            raise invalid(path, f"expected codes of uint8 or uint16, got {codes.dtype}")
        largest = int(np.iinfo(codes.dtype).max)
        kind, extension = (b"P5", ".pgm") if codes.ndim == 2 else (b"P6", ".ppm")
        file = self._new(extension)
        with open(file, "wb") as to:
            to.write(kind + f" {codes.shape[1]} {codes.shape[0]} {largest}\n".encode("ascii"))
            to.write(codes.astype(codes.dtype.newbyteorder(">")).tobytes())
        return file

    def _geometry(self, value: Any, path: str) -> Any:
        """A mesh as a glTF file; a path stays one."""
        if not isinstance(value, Mapping):
            return self.plain(value, path)
        mesh = cast("Mapping[str, Any]", value)
        known = {"positions", "triangles", "normals", "uvs", "material", "name"}
        unknown = sorted(set(mesh) - known)
        if unknown:
            # What other libraries call the same, and what is nearly the same word
            others = {"faces": "triangles", "indices": "triangles", "vertices": "positions", "points": "positions"}
            others |= {"vertex_normals": "normals", "uv": "uvs", "texcoords": "uvs", "texture_coordinates": "uvs"}
            near = [others[name] for name in unknown if name in others] or get_close_matches(unknown[0], known, 1)
            hint = f"; did you mean {near[0]!r}?" if near else ""
            parts = f"its parts are {', '.join(sorted(known))}"
            raise invalid(f"{path}.{unknown[0]}", f"is not part of a mesh{hint}", parts)
        for part in ("positions", "triangles"):
            if part not in mesh:
                raise invalid(f"{path}.{part}", "is missing: a mesh is made of positions (N, 3) and triangles (M, 3)")
        positions = _vertices(f"{path}.positions", mesh["positions"], 3, None)
        arrays = {"POSITION": positions}
        for part, attribute, columns in (("normals", "NORMAL", 3), ("uvs", "TEXCOORD_0", 2)):
            if mesh.get(part) is not None:
                arrays[attribute] = _vertices(f"{path}.{part}", mesh[part], columns, len(positions))
        triangles = _triangles(f"{path}.triangles", mesh["triangles"], len(positions))
        file = self._new(".glb")
        with open(file, "wb") as to:
            to.write(_glb(arrays, triangles, str(mesh.get("material", "material")), str(mesh.get("name", "mesh"))))
        return file


def _remove(folder: str, process: int) -> None:
    if os.getpid() == process:
        shutil.rmtree(folder, ignore_errors=True)


def _vertices(name: str, value: Any, columns: int, count: Optional[int]) -> "npt.NDArray[np.float32]":
    array = floats(name, value, f"(N, {columns})", (2,))
    if array.shape[1] != columns or count not in (None, len(array)):
        rows = "N" if count is None else str(count)
        raise invalid(name, f"expected an array ({rows}, {columns}), got one of shape {array.shape}")
    if not np.isfinite(array).all():
        raise invalid(name, "holds numbers that are not finite")
    return array


def _triangles(name: str, value: Any, vertices: int) -> "npt.NDArray[np.uint32]":
    array = as_array(name, value, (2,), "(M, 3)")
    if array.shape[1] != 3:
        raise invalid(name, f"expected an array (M, 3), got one of shape {array.shape}")
    if array.dtype.kind not in "ui":
        raise invalid(name, f"expected whole numbers, got an array of {array.dtype}")
    if array.min() < 0 or array.max() >= vertices:
        raise invalid(name, f"expected numbers of vertices from 0 to {vertices - 1}, got {array.min()} to {array.max()}")
    return np.ascontiguousarray(array, np.uint32)


def _glb(
    arrays: "Mapping[str, npt.NDArray[np.float32]]", triangles: "npt.NDArray[np.uint32]", material: str, name: str
) -> bytes:
    """A binary glTF file (glTF 2.0, section 4) of one mesh."""
    views: "list[dict[str, Any]]" = []
    accessors: "list[dict[str, Any]]" = []
    data = b""
    kinds = {2: "VEC2", 3: "VEC3"}
    attributes: "dict[str, int]" = {}
    for attribute, array in arrays.items():
        attributes[attribute] = len(accessors)
        views.append({"buffer": 0, "byteOffset": len(data), "byteLength": array.nbytes})
        accessor: "dict[str, Any]" = {
            "bufferView": len(accessors), "componentType": 5126, "count": len(array), "type": kinds[array.shape[1]]
        }
        if attribute == "POSITION":
            accessor.update(min=array.min(0).tolist(), max=array.max(0).tolist())
        accessors.append(accessor)
        data += array.astype("<f4").tobytes()
    views.append({"buffer": 0, "byteOffset": len(data), "byteLength": triangles.nbytes})
    accessors.append(
        {"bufferView": len(accessors), "componentType": 5125, "count": triangles.size, "type": "SCALAR"}
    )
    data += triangles.astype("<u4").tobytes()
    primitive = {"attributes": attributes, "indices": len(accessors) - 1, "material": 0}
    document = {
        "asset": {"version": "2.0"},
        "scenes": [{"nodes": [0]}],
        "scene": 0,
        "nodes": [{"mesh": 0, "name": name}],
        "meshes": [{"name": name, "primitives": [primitive]}],
        "materials": [{"name": material, "doubleSided": True}],
        "accessors": accessors,
        "bufferViews": views,
        "buffers": [{"byteLength": len(data)}],
    }
    text = json.dumps(document).encode("utf-8")
    text += b" " * (-len(text) % 4)
    length = 12 + 8 + len(text) + 8 + len(data)
    head = struct.pack("<4sII", b"glTF", 2, length)
    return head + struct.pack("<I4s", len(text), b"JSON") + text + struct.pack("<I4s", len(data), b"BIN\0") + data
