#!/usr/bin/env python3
"""Writes tree.gltf, grass.gltf and house.gltf, for a meadow. Needs Python only."""

import math
import random
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent))
from meshes import Model, box, joined, moved, polygon, sheet, tube  # noqa: E402

random.seed(11)


def along(azimuth, elevation):
    return (math.cos(elevation) * math.cos(azimuth), math.sin(elevation), math.cos(elevation) * math.sin(azimuth))


def blade(length, width):
    """A small leaf: two triangles, folded a little."""
    positions = [(0, 0, 0), (0.45 * length, 0.02 * length, -width / 2), (length, -0.08 * length, 0), (0.45 * length, 0.02 * length, width / 2)]
    return positions, [(0.0, 1.0, 0.0)] * 4, [(0, 3, 2), (0, 2, 1)]


def tree():
    model = Model()
    crown = []

    def branch(start, direction, length, radius, level):
        points = [start]
        azimuth, elevation = direction
        for _ in range(5):
            azimuth += random.uniform(-0.22, 0.22)
            elevation += random.uniform(-0.12, 0.14)
            step = along(azimuth, min(elevation, 1.5))
            points.append(tuple(p + length / 5 * d for p, d in zip(points[-1], step)))
        radii = [radius * (1 - 0.11 * i) for i in range(6)]
        model.add("bark", tube(points, radii, 14 if level == 0 else 7))
        if level >= 3:
            for point in points[1:]:
                for _ in range(6):
                    crown.append(tuple(p + random.gauss(0, 0.16) for p in point))
        if level == 5:
            return
        count = 6 if level == 0 else 3
        for i in range(count):
            at = points[random.choice((3, 4, 5)) if i else 5]
            branch(at, (azimuth + 2 * math.pi * i / count + random.uniform(-0.5, 0.5), random.uniform(0.1, 0.95) if level else random.uniform(0.3, 1.1)),
                   length * random.uniform(0.62, 0.82), radius * 0.52, level + 1)

    branch((0, 0, 0), (0.0, 1.5), 2.2, 0.26, 0)
    for point in crown:
        model.add("leaf", moved(blade(random.uniform(0.13, 0.19), 0.09), to=point, turned_deg=(random.uniform(-50, 50), random.uniform(0, 360), random.uniform(-60, 30))))
    model.write(HERE / "tree.gltf")


def grass():
    """A square metre."""
    model = Model()
    for _ in range(1400):
        x, z = random.random(), random.random()
        tall, wide = random.uniform(0.06, 0.2), random.uniform(0.004, 0.007)
        azimuth, bend = random.uniform(0, 2 * math.pi), random.uniform(0.1, 0.7)
        c, s = math.cos(azimuth), math.sin(azimuth)
        left, right, upper = [], [], []
        for i, t in enumerate((0, 0.4, 0.75, 1)):
            w = wide * (1 - t**1.5) / 2
            along_x = bend * tall * t * t
            left.append((x + c * along_x - s * w, tall * t * (1 - 0.3 * bend * t), z + s * along_x + c * w))
            right.append((x + c * along_x + s * w, tall * t * (1 - 0.3 * bend * t), z + s * along_x - c * w))
        normal = (-c * 0.6, 0.8, -s * 0.6)
        model.add("grass", (left[:3] + right[:3] + left[3:], [normal] * 7, [(0, 3, 4), (0, 4, 1), (1, 4, 5), (1, 5, 2), (2, 5, 6)]))
    model.write(HERE / "grass.gltf")


def house():
    model = Model()
    model.add("plaster", box((-3, 0, -2), (3, 2.6, 2)))
    for z in (-2, 2):
        gable = ((-3, 2.6, z), (3, 2.6, z), (0, 4.6, z))
        model.add("plaster", polygon(gable if z > 0 else gable[::-1]))
    for side in (-1, 1):
        corners = [(side * 3.35, 2.36, -2.3), (side * 3.35, 2.36, 2.3), (0, 4.72, 2.3), (0, 4.72, -2.3)]
        model.add("roof", polygon(corners if side < 0 else corners[::-1]))
    for x in (-1.7, 1.7):
        model.add("pane", box((x - 0.45, 0.95, 1.95), (x + 0.45, 2.0, 2.01)))
    model.add("door", box((-0.5, 0, 1.95), (0.5, 2.05, 2.03)))
    model.add("roof", box((1.0, 3.4, -0.9), (1.6, 5.2, -0.3)))
    model.write(HERE / "house.gltf")


def hills():
    """Ground that rises and falls, and hills behind."""
    model = Model()

    def height(x, z):
        near = 0.25 * math.sin(0.21 * x + 0.5) * math.sin(0.17 * z)
        return near * min(1, max(0.0, -z - 3) / 6) + max(0.0, -z - 35) * 0.10 * (1.2 + math.sin(0.045 * x + 1.0) + 0.4 * math.sin(0.13 * x))
    model.add("meadow", sheet(lambda u, v: (-90 + 180 * u, height(-90 + 180 * u, 8 - 110 * v), 8 - 110 * v), 90, 110))
    for i in range(26):
        x = -6.5 + 0.62 * i
        z = -9.5 + 0.07 * x
        model.add("fence", box((x - 0.035, height(x, z) - 0.1, z - 0.035), (x + 0.035, height(x, z) + 0.95, z + 0.035)))
    for y in (0.4, 0.78):
        model.add("fence", tube([(-6.6 + 0.31 * i, height(-6.6 + 0.31 * i, -9.5 + 0.07 * (-6.6 + 0.31 * i)) + y, -9.5 + 0.07 * (-6.6 + 0.31 * i) + 0.04) for i in range(52)], 0.03, 6))
    model.write(HERE / "hills.gltf")


for part in (tree, grass, house, hills):
    part()
