"""Triangle meshes as arrays: large scenes are made when they are needed.

Metres, +Y up, counter-clockwise faces. A mesh without normals is flat.
"""

from dataclasses import dataclass

import numpy as np


@dataclass(eq=False)
class Mesh:
    """Triangles of one material, `positions` n × 3, `triangles` m × 3, `normals` n × 3 or None, `uvs` n × 2 or None."""

    material: str
    positions: np.ndarray
    triangles: np.ndarray
    normals: np.ndarray | None = None
    # Centre and radius of what is a sphere but for its triangles.
    ball: tuple | None = None
    uvs: np.ndarray | None = None

    def moved(self, translation, scale=1.0):
        """The mesh of a body around the origin scaled evenly, then moved."""
        ball = self.ball and (translation, self.ball[1] * scale)
        return Mesh(self.material, self.positions * scale + np.array(translation), self.triangles, self.normals, ball, self.uvs)

    def turned_out(self):
        """The mesh with its front inside."""
        normals = None if self.normals is None else -self.normals
        return Mesh(self.material, self.positions, self.triangles[:, ::-1], normals, uvs=self.uvs)


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


def lathe(material, radii, heights, sectors):
    """A smooth body of revolution about +Y: radii and heights from the bottom up. u goes around it and v up, from the top of a
    texture down."""
    radii, heights = np.asarray(radii, dtype=np.float64), np.asarray(heights, dtype=np.float64)
    slope = np.stack([np.gradient(heights), -np.gradient(radii)], axis=-1)
    slope /= np.linalg.norm(slope, axis=-1, keepdims=True)
    angle = 2 * np.pi * np.arange(sectors + 1) / sectors
    around = np.stack([np.sin(angle), np.cos(angle)])

    def turned(radius, height):
        return np.stack([np.outer(radius, around[0]), np.repeat(height[:, None], sectors + 1, 1), np.outer(radius, around[1])], axis=-1)

    rings = len(radii)
    u, v = np.meshgrid(np.arange(sectors + 1) / sectors, 1 - np.arange(rings) / (rings - 1))
    ring, sector = np.meshgrid(np.arange(rings - 1), np.arange(sectors), indexing="ij")
    a = (ring * (sectors + 1) + sector).reshape(-1)
    b, c, d = a + 1, a + sectors + 1, a + sectors + 2
    triangles = np.concatenate([np.stack([a, b, d], -1), np.stack([a, d, c], -1)])
    flat = [turned(radii, heights), turned(slope[:, 0], slope[:, 1])]
    positions, normals = (values.reshape(-1, 3) for values in flat)
    return Mesh(material, positions, triangles, normals, uvs=np.stack([u, v], -1).reshape(-1, 2))
