"""Meshes for the scenes of the gallery, beside those of gltf_file.py: boxes, tubes, sheets and leaves, moved and put together.

A mesh is (positions, normals, triangles), as `lathe` makes it. Metres, +Y up, counter-clockwise faces. Needs Python only.
"""

import math
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from gltf_file import GltfFile, cross, lathe, minus, sphere, unit  # noqa: E402


class Model:
    """Meshes by their material, written as one glTF file. What the materials are, the capture file says."""

    def __init__(self):
        self.meshes = {}

    def add(self, material, mesh):
        positions, normals, triangles = self.meshes.setdefault(material, ([], [], []))
        first = len(positions)
        positions += mesh[0]
        normals += mesh[1]
        triangles += [tuple(first + index for index in triangle) for triangle in mesh[2]]

    def write(self, path):
        file = GltfFile()
        for material, mesh in self.meshes.items():
            file.material(material)
            file.shape(material, *mesh)
            file.place(material, material, material)
        file.write(path)


def rotation(degrees):
    """Rows of the matrix that turns about x, then y, then z."""
    (cx, sx), (cy, sy), (cz, sz) = ((math.cos(math.radians(a)), math.sin(math.radians(a))) for a in degrees)
    return (
        (cy * cz, sx * sy * cz - cx * sz, cx * sy * cz + sx * sz),
        (cy * sz, sx * sy * sz + cx * cz, cx * sy * sz - sx * cz),
        (-sy, sx * cy, cx * cy),
    )


def moved(mesh, to=(0, 0, 0), turned_deg=(0, 0, 0), scale=1.0):
    """A mesh made larger, turned and moved, in this order."""
    rows = rotation(turned_deg)

    def turn(vector):
        return tuple(sum(a * b for a, b in zip(row, vector)) for row in rows)

    positions = [tuple(scale * a + b for a, b in zip(turn(point), to)) for point in mesh[0]]
    return positions, [turn(normal) for normal in mesh[1]], mesh[2]


def polygon(corners):
    """A flat convex polygon, its corners counter-clockwise as seen from the front."""
    normal = unit(cross(minus(corners[1], corners[0]), minus(corners[2], corners[0])))
    return list(corners), [normal] * len(corners), [(0, i, i + 1) for i in range(1, len(corners) - 1)]


def disc(radius=1.0, corners=48):
    """A disc about the origin that faces +Z."""
    return polygon([(radius * math.cos(a), radius * math.sin(a), 0.0) for a in (2 * math.pi * i / corners for i in range(corners))])


def joined(meshes):
    """Several meshes as one."""
    positions, normals, triangles = [], [], []
    for mesh in meshes:
        first = len(positions)
        positions += mesh[0]
        normals += mesh[1]
        triangles += [tuple(first + index for index in triangle) for triangle in mesh[2]]
    return positions, normals, triangles


def box(low, high):
    """A box between two corners."""
    (x0, y0, z0), (x1, y1, z1) = low, high
    return joined(polygon(face) for face in (
        ((x0, y0, z1), (x1, y0, z1), (x1, y1, z1), (x0, y1, z1)),
        ((x1, y0, z0), (x0, y0, z0), (x0, y1, z0), (x1, y1, z0)),
        ((x1, y0, z1), (x1, y0, z0), (x1, y1, z0), (x1, y1, z1)),
        ((x0, y0, z0), (x0, y0, z1), (x0, y1, z1), (x0, y1, z0)),
        ((x0, y1, z1), (x1, y1, z1), (x1, y1, z0), (x0, y1, z0)),
        ((x0, y0, z0), (x1, y0, z0), (x1, y0, z1), (x0, y0, z1)),
    ))


def ball(centre, radius, frequency=16, stretch=(1, 1, 1)):
    """A sphere, or an ellipsoid."""
    points, triangles = sphere(frequency)
    positions = [tuple(c + radius * s * x for c, s, x in zip(centre, stretch, point)) for point in points]
    normals = [unit(tuple(x / s for s, x in zip(stretch, point))) for point in points]
    return positions, normals, triangles


def curve(points, steps=6):
    """A smooth line through points in a plane, as pottery has it: a Catmull–Rom spline."""
    line = []
    for i in range(len(points) - 1):
        a, b, c, d = (points[min(max(k, 0), len(points) - 1)] for k in (i - 1, i, i + 1, i + 2))
        for j in range(steps):
            t = j / steps
            line.append(tuple(0.5 * (2 * q + (r - p) * t + (2 * p - 5 * q + 4 * r - s) * t**2 + (3 * q - p - 3 * r + s) * t**3) for p, q, r, s in zip(a, b, c, d)))
    line.append(points[-1])
    # No radius below 0 where a line begins or ends on the axis.
    return [(max(radius, 0.0), height) for radius, height in line]


def turned(points, segments=48):
    """A solid of revolution about +Y. `points` are (radius, height) from the top down along a smooth line, None breaks it."""
    runs, run = [], []
    for point in [*points, None]:
        if point is None:
            if len(run) > 1:
                runs.append(run)
            run = []
        else:
            run.append(point)
    return lathe([[(r, y, *_outwards(run, i)) for i, (r, y) in enumerate(run)] for run in runs], segments)


def _outwards(run, i):
    before, after = run[max(i - 1, 0)], run[min(i + 1, len(run) - 1)]
    if run[i][0] == 0:
        # On the axis, the normal is the axis: up at the top of a run, down at its end.
        return (0.0, 1.0 if i == 0 else -1.0)
    return (before[1] - after[1], after[0] - before[0])


def tube(points, radii, segments=12):
    """A tube along a line; `radii` is one, or one for each point."""
    if not isinstance(radii, (list, tuple)):
        radii = [radii] * len(points)
    positions, normals, triangles = [], [], []
    side = None
    for i, (point, radius) in enumerate(zip(points, radii)):
        along = unit(minus(points[min(i + 1, len(points) - 1)], points[max(i - 1, 0)]))
        if side is None:
            side = unit(cross(along, (0, 0, 1) if abs(along[2]) < 0.9 else (1, 0, 0)))
        # The side of the ring before, made perpendicular: no twist along the way.
        side = unit(minus(side, tuple(sum(a * b for a, b in zip(side, along)) * c for c in along)))
        other = cross(along, side)
        for s in range(segments):
            angle = 2 * math.pi * s / segments
            normal = tuple(math.cos(angle) * a + math.sin(angle) * b for a, b in zip(side, other))
            positions.append(tuple(p + radius * n for p, n in zip(point, normal)))
            normals.append(normal)
    for i in range(len(points) - 1):
        for s in range(segments):
            a, b = i * segments + s, i * segments + (s + 1) % segments
            triangles += [(a, b, b + segments), (a, b + segments, a + segments)]
    return positions, normals, triangles


def sheet(function, across, down):
    """A surface given by function(u, v), 0 to 1 each, with normals from its neighbours."""
    step = 1e-4
    positions, normals, triangles = [], [], []
    for j in range(down + 1):
        for i in range(across + 1):
            u, v = i / across, j / down
            along_u = minus(function(u + step, v), function(u - step, v))
            along_v = minus(function(u, v + step), function(u, v - step))
            positions.append(tuple(function(u, v)))
            normals.append(unit(cross(along_u, along_v)))
    for j in range(down):
        for i in range(across):
            a = j * (across + 1) + i
            b, c, d = a + 1, a + across + 2, a + across + 1
            triangles += [(a, b, c), (a, c, d)]
    return positions, normals, triangles


def leaf(length, width, bend=0.25):
    """A leaf from the origin along +X, a little folded along its middle and bent down towards its tip."""
    def at(u, v):
        u, v = min(max(u, 0.0), 1.0), v - 0.5
        half = width * math.sin(math.pi * u**0.8) ** 0.9 if 0 < u < 1 else 0.0
        return (length * u, -bend * length * u * u + 0.25 * half * abs(2 * v), -half * v)

    positions, triangles = [], []
    for i in range(7):
        positions += [at(i / 6, v) for v in (0, 0.5, 1)]
    for i in range(6):
        a = 3 * i
        triangles += [(a, a + 1, a + 4), (a, a + 4, a + 3), (a + 1, a + 2, a + 5), (a + 1, a + 5, a + 4)]
    normals = []
    for i in range(7):
        slope = unit((1.0, -2 * bend * i / 6, 0.0))
        up = (-slope[1], slope[0], 0.0)
        normals += [unit((up[0], up[1], -0.2)), up, unit((up[0], up[1], 0.2))]
    # No triangles without an area at the ends.
    return positions, normals, [t for t in triangles if len({tuple(round(c, 9) for c in positions[i]) for i in t}) == 3]
