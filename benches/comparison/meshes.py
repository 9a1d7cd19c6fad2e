"""Triangle meshes as arrays, and a writer of binary glTF for them: large scenes are made when they are needed.

Metres, +Y up, counter-clockwise faces. A mesh without normals is flat.
"""

import json
import struct
from dataclasses import dataclass

import numpy as np

FLOAT, UNSIGNED_INT = 5126, 5125


@dataclass
class Mesh:
    """Triangles of one material, `positions` n × 3, `triangles` m × 3, `normals` n × 3 or None."""

    material: str
    positions: np.ndarray
    triangles: np.ndarray
    normals: np.ndarray | None = None
    # Centre and radius of what is a sphere but for its triangles.
    ball: tuple | None = None

    def moved(self, translation, scale=1.0):
        """The mesh of a body around the origin scaled evenly, then moved."""
        ball = self.ball and (translation, self.ball[1] * scale)
        return Mesh(self.material, self.positions * scale + np.array(translation), self.triangles, self.normals, ball)


def quads(material, *corners):
    """Parallelograms, each given by a corner and the two edges that leave it, counter-clockwise seen from the front."""
    positions, triangles = [], []
    for i, (corner, u, v) in enumerate(corners):
        corner, u, v = (np.array(x, dtype=np.float64) for x in (corner, u, v))
        positions += [corner, corner + u, corner + u + v, corner + v]
        triangles += [[4 * i, 4 * i + 1, 4 * i + 2], [4 * i, 4 * i + 2, 4 * i + 3]]
    return Mesh(material, np.array(positions), np.array(triangles))


def box(material, centre, half_x, half_y, half_z):
    """A box by its centre and three half edges, right-handed."""
    c, x, y, z = (np.array(v, dtype=np.float64) for v in (centre, half_x, half_y, half_z))
    sides = [(a, b, n) for n, a, b in ((x, y, z), (y, z, x), (z, x, y))]
    faces = [(c + n - a - b, 2 * a, 2 * b) for a, b, n in sides] + [(c - n - a - b, 2 * b, 2 * a) for a, b, n in sides]
    return quads(material, *faces)


def sphere(material, bands, sectors, radius=lambda direction: 1.0, smooth=False):
    """A sphere around the origin, 2 · sectors · (bands − 1) triangles: flat, its radius a function of the direction, or smooth,
    its radius 1."""
    theta, phi = np.meshgrid(np.pi * np.arange(1, bands) / bands, 2 * np.pi * np.arange(sectors) / sectors, indexing="ij")
    ring = np.stack([np.sin(theta) * np.cos(phi), np.cos(theta), np.sin(theta) * np.sin(phi)], axis=-1).reshape(-1, 3)
    directions = np.concatenate([[[0.0, 1.0, 0.0]], ring, [[0.0, -1.0, 0.0]]])
    last = len(directions) - 1
    band, sector = np.meshgrid(np.arange(bands), np.arange(sectors), indexing="ij")

    def corner(band, sector):
        inside = (band - 1) * sectors + sector % sectors + 1
        return np.where(band == 0, 0, np.where(band == bands, last, inside))

    a, b = corner(band, sector), corner(band, sector + 1)
    c, d = corner(band + 1, sector), corner(band + 1, sector + 1)
    triangles = np.stack([np.stack([a, b, c], -1), np.stack([b, d, c], -1)], axis=2).reshape(-1, 3)
    p, q, r = triangles.T
    triangles = triangles[(p != q) & (q != r) & (r != p)]
    positions = directions * np.reshape(radius(directions), (-1, 1))
    return Mesh(material, positions, triangles, directions if smooth else None, ((0, 0, 0), 1.0) if smooth else None)


def write_glb(path, meshes):
    """Writes meshes as binary glTF. Materials have names alone: the capture file says what they are."""
    chunks, views, accessors = [], [], []

    def accessor(array, component, kind, **bounds):
        data = array.tobytes()
        views.append({"buffer": 0, "byteOffset": sum(map(len, chunks)), "byteLength": len(data)})
        chunks.append(data)
        accessors.append({"bufferView": len(views) - 1, "componentType": component, "count": len(array), "type": kind, **bounds})
        return len(accessors) - 1

    names = list(dict.fromkeys(mesh.material for mesh in meshes))
    entries = []
    for mesh in meshes:
        positions = mesh.positions.astype("<f4")
        bounds = {"min": positions.min(axis=0).tolist(), "max": positions.max(axis=0).tolist()}
        attributes = {"POSITION": accessor(positions, FLOAT, "VEC3", **bounds)}
        if mesh.normals is not None:
            attributes["NORMAL"] = accessor(mesh.normals.astype("<f4"), FLOAT, "VEC3")
        indices = accessor(mesh.triangles.astype("<u4").reshape(-1), UNSIGNED_INT, "SCALAR")
        entries.append({"primitives": [{"attributes": attributes, "indices": indices, "material": names.index(mesh.material)}]})
    document = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": list(range(len(entries)))}],
        "nodes": [{"mesh": i} for i in range(len(entries))],
        "meshes": entries,
        "materials": [{"name": name} for name in names],
        "accessors": accessors,
        "bufferViews": views,
        "buffers": [{"byteLength": sum(map(len, chunks))}],
    }
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    size = sum(map(len, chunks))
    with path.open("wb") as file:
        file.write(struct.pack("<4sII", b"glTF", 2, 12 + 8 + len(text) + 8 + size))
        file.write(struct.pack("<I4s", len(text), b"JSON") + text + struct.pack("<I4s", size, b"BIN\0"))
        file.writelines(chunks)
