#!/usr/bin/env python3
"""Writes room.gltf: a living room with one tall window. Needs Python only."""

import math
import random
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent))
from meshes import Model, ball, box, curve, joined, leaf, moved, polygon, sheet, tube, turned  # noqa: E402

WIDTH, HEIGHT, DEPTH = 5.0, 2.8, 6.0
LEFT, RIGHT, BACK, FRONT = -WIDTH / 2, WIDTH / 2, -DEPTH / 2, DEPTH / 2
# The window in the left wall.
SILL, LINTEL, NEAR, FAR = 0.45, 2.45, 0.5, -1.7
WALL = 0.3
BOOKS = ("book-red", "book-ochre", "book-green", "book-blue", "book-cream", "book-brown")

random.seed(1)
room = Model()


def walls():
    room.add("plaster", polygon(((LEFT, 0, BACK), (RIGHT, 0, BACK), (RIGHT, HEIGHT, BACK), (LEFT, HEIGHT, BACK))))
    room.add("plaster", polygon(((RIGHT, 0, BACK), (RIGHT, 0, FRONT), (RIGHT, HEIGHT, FRONT), (RIGHT, HEIGHT, BACK))))
    room.add("plaster", polygon(((RIGHT, 0, FRONT), (LEFT, 0, FRONT), (LEFT, HEIGHT, FRONT), (RIGHT, HEIGHT, FRONT))))
    room.add("ceiling", polygon(((LEFT, HEIGHT, BACK), (RIGHT, HEIGHT, BACK), (RIGHT, HEIGHT, FRONT), (LEFT, HEIGHT, FRONT))))
    outer = LEFT - WALL
    for low, high in (((outer, 0, NEAR), (LEFT, HEIGHT, FRONT)), ((outer, 0, BACK), (LEFT, HEIGHT, FAR)),
                      ((outer, 0, FAR), (LEFT, SILL, NEAR)), ((outer, LINTEL, FAR), (LEFT, HEIGHT, NEAR))):
        room.add("plaster", box(low, high))
    for low, high in (((LEFT, 0, BACK), (RIGHT, 0.12, BACK + 0.018)), ((RIGHT - 0.018, 0, BACK), (RIGHT, 0.12, FRONT))):
        room.add("white", box(low, high))


def floor():
    """Planks of random lengths."""
    x = LEFT
    while x < RIGHT:
        z = BACK - random.random()
        while z < FRONT:
            length = random.uniform(0.9, 1.8)
            tone = random.choice(("oak-1", "oak-2", "oak-3", "oak-4"))
            room.add(tone, box((x + 0.0015, -0.02, z + 0.0015), (x + 0.1385, 0, z + length - 0.0015)))
            z += length
        x += 0.14
    room.add("gap", box((LEFT, -0.03, BACK), (RIGHT, -0.004, FRONT)))


def window():
    frame = 0.06
    x0, x1 = LEFT - 0.12, LEFT - 0.06
    for z in (NEAR, (NEAR + FAR) / 2 + frame / 2, FAR + frame):
        room.add("white", box((x0, SILL, z - frame), (x1, LINTEL, z)))
    for y in (SILL, LINTEL - frame):
        room.add("white", box((x0, y, FAR), (x1, y + frame, NEAR)))
    for i in (1, 2):
        y = SILL + i * (LINTEL - SILL) / 3
        room.add("white", box((x0 + 0.015, y - 0.015, FAR), (x1 - 0.015, y + 0.015, NEAR)))
    room.add("white", box((LEFT - 0.02, SILL - 0.035, FAR - 0.08), (LEFT + 0.14, SILL, NEAR + 0.08)))

    def curtain(z0, z1):
        def at(u, v):
            z = z0 + (z1 - z0) * u
            return (LEFT + 0.16 + 0.035 * math.sin(40 * u) + 0.01 * math.sin(17 * u + 6 * v), 2.62 - 2.58 * v, z)
        return sheet(at, 70, 8)
    room.add("curtain", curtain(FAR - 0.45, FAR + 0.1))
    room.add("curtain", curtain(NEAR - 0.1, NEAR + 0.45))
    room.add("brass", tube([(LEFT + 0.16, 2.64, FAR - 0.6), (LEFT + 0.16, 2.64, NEAR + 0.6)], 0.014))


def shelf():
    """Against the back wall, filled with books."""
    x0, x1, z0, z1, top = 0.35, 2.2, BACK, BACK + 0.3, 2.2
    for x in (x0, (x0 + x1) / 2 - 0.015, x1 - 0.03):
        room.add("walnut", box((x, 0, z0), (x + 0.03, top, z1)))
    levels = 6
    for level in range(levels + 1):
        y = 0.06 + level * (top - 0.09) / levels
        room.add("walnut", box((x0, y, z0), (x1, y + 0.03, z1)))
        if level == levels:
            break
        for a, b in ((x0 + 0.03, (x0 + x1) / 2 - 0.015), ((x0 + x1) / 2 + 0.015, x1 - 0.03)):
            x, end = a, b - random.choice((0.02, 0.02, 0.25, 0.5))
            while x < end:
                wide = random.uniform(0.018, 0.05)
                if x + wide > b:
                    break
                tall = random.uniform(0.2, 0.29)
                deep = random.uniform(0.17, 0.24)
                room.add(random.choice(BOOKS), box((x, y + 0.03, z0), (x + wide - 0.002, y + 0.03 + tall, z0 + deep)))
                x += wide


def table():
    x, z = -0.55, -0.75
    top = [(0, 0.74), (0.54, 0.74), None, (0.54, 0.74), (0.555, 0.727), (0.54, 0.714), None, (0.54, 0.714), (0, 0.714)]
    room.add("walnut", moved(turned(top, 72), to=(x, 0, z)))
    for angle in (45, 135, 225, 315):
        c, s = math.cos(math.radians(angle)), math.sin(math.radians(angle))
        room.add("walnut", tube([(x + 0.26 * c, 0.72, z + 0.26 * s), (x + 0.42 * c, 0.0, z + 0.42 * s)], [0.026, 0.014]))
    vase = curve([(0.035, 1.03), (0.03, 1.01), (0.028, 0.98), (0.05, 0.93), (0.08, 0.88), (0.088, 0.84), (0.078, 0.79), (0.055, 0.755), (0.05, 0.741)])
    room.add("celadon", moved(turned(vase, 48), to=(x - 0.1, 0, z - 0.08)))
    for i in range(9):
        angle, lean = 40 * i + random.uniform(-15, 15), random.uniform(0.1, 0.3)
        c, s = math.cos(math.radians(angle)), math.sin(math.radians(angle))
        stem = [(x - 0.1 + lean * t * t * c, 1.0 + random.uniform(0.4, 0.5) * t, z - 0.08 + lean * t * t * s) for t in (0, 0.3, 0.6, 0.8, 1)]
        room.add("stem", tube(stem, 0.003, 6))
        for point in stem[2:]:
            for turn in (0, 130, 250):
                room.add("leaf", moved(leaf(0.13, 0.035), to=point, turned_deg=(0, angle + turn + random.uniform(-30, 30), random.uniform(10, 50))))
    for k, (wide, colour) in enumerate(((0.22, "book-blue"), (0.19, "book-cream"), (0.17, "book-red"))):
        y = 0.741 + 0.028 * k
        room.add(colour, moved(box((-wide / 2, 0, -wide * 0.7), (wide / 2, 0.026, wide * 0.7)), to=(x + 0.24, y, z + 0.12), turned_deg=(0, 12 * k - 20, 0)))
    cup = [(0.036, 0.84), (0.034, 0.8), (0.025, 0.755), (0.02, 0.742), (0, 0.742)]
    room.add("white", moved(turned(cup, 40), to=(x + 0.05, 0, z + 0.3)))


def cushion(low, high, bulge=0.045):
    """A box with soft sides."""
    (x0, y0, z0), (x1, y1, z1) = low, high
    middle = tuple((a + b) / 2 for a, b in zip(low, high))
    half = tuple((b - a) / 2 for a, b in zip(low, high))
    points, normals, triangles = ball((0, 0, 0), 1.0, 24)
    n = 8
    positions = []
    for point in points:
        norm = sum(abs(c) ** n for c in point) ** (1 / n)
        positions.append(tuple(m + h * c / norm for m, h, c in zip(middle, half, point)))
    normals = []
    for point in points:
        norm = sum(abs(c) ** n for c in point) ** (1 / n)
        gradient = tuple(math.copysign(abs(c / norm) ** (n - 1), c) / h for c, h in zip(point, half))
        length = math.sqrt(sum(g * g for g in gradient))
        normals.append(tuple(g / length for g in gradient))
    return positions, normals, triangles


def armchair():
    parts = [cushion((-0.36, 0.2, -0.36), (0.36, 0.46, 0.4)), cushion((-0.36, 0.3, -0.46), (0.36, 0.95, -0.24)),
             cushion((-0.5, 0.2, -0.42), (-0.33, 0.64, 0.4)), cushion((0.33, 0.2, -0.42), (0.5, 0.64, 0.4))]
    place = {"to": (1.25, 0, -0.9), "turned_deg": (0, -38, 0)}
    room.add("wool", moved(joined(parts), **place))
    room.add("mustard", moved(moved(cushion((-0.22, -0.2, -0.07), (0.22, 0.2, 0.07)), to=(0.02, 0.66, -0.14), turned_deg=(-18, 0, 8)), **place))
    for x in (-0.42, 0.42):
        for z in (-0.36, 0.33):
            room.add("walnut", moved(tube([(x, 0.22, z), (x * 1.05, 0, z * 1.05)], [0.024, 0.014]), **place))


def lamp():
    """A floor lamp, whose shade shines when the capture says so."""
    x, z = 0.05, -2.45
    room.add("brass", moved(turned([(0, 0.03), (0.13, 0.03), (0.15, 0.015), (0.15, 0)], 48), to=(x, 0, z)))
    room.add("brass", tube([(x, 0.02, z), (x, 1.5, z)], 0.011))
    room.add("shade", moved(turned([(0.13, 1.8), (0.23, 1.44)], 64), to=(x, 0, z)))


def rug():
    for k, (radius, tone) in enumerate(((1.25, "rug-dark"), (1.12, "rug-light"), (0.95, "rug-dark"), (0.9, "rug-light"))):
        room.add(tone, moved(turned([(0, 0.004 + 0.002 * k), (radius, 0.004 + 0.002 * k), None, (radius, 0.004 + 0.002 * k), (radius, 0)], 96), to=(-0.2, 0, -0.6)))


def picture():
    """An abstract print between window and shelf."""
    x, y, z = -1.25, 1.55, BACK
    room.add("walnut", box((x - 0.42, y - 0.55, z), (x + 0.42, y + 0.55, z + 0.03)))
    room.add("paper", box((x - 0.39, y - 0.52, z), (x + 0.39, y + 0.52, z + 0.032)))
    for k, (dx, dy, r, tone) in enumerate(((0.02, 0.12, 0.22, "book-red"), (-0.1, -0.12, 0.17, "book-blue"), (0.14, -0.18, 0.1, "mustard"))):
        disc = [(x + dx + r * math.cos(t), y + dy + r * math.sin(t), z + 0.033 + 0.0008 * k) for t in (2 * math.pi * i / 64 for i in range(64))]
        room.add(tone, polygon(disc))


for part in (walls, floor, window, shelf, table, armchair, lamp, rug, picture):
    part()
# What the window sees: a bright overcast sky, as an evenly bright sheet just outside.
room.add("sky", polygon(((LEFT - 0.34, SILL - 0.1, NEAR + 0.1), (LEFT - 0.34, SILL - 0.1, FAR - 0.1),
                         (LEFT - 0.34, LINTEL + 0.1, FAR - 0.1), (LEFT - 0.34, LINTEL + 0.1, NEAR + 0.1))))
room.write(HERE / "room.gltf")
