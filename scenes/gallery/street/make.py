#!/usr/bin/env python3
"""Writes street.gltf: a street of small houses at night. Needs Python only."""

import math
import random
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent))
from meshes import Model, ball, box, disc, joined, moved, polygon, sheet, tube, turned  # noqa: E402

random.seed(8)
street = Model()
# The street runs along -z, 6 m wide, with a pavement on both sides.
street.add("asphalt", polygon(((-3, 0, 6), (3, 0, 6), (3, 0, -70), (-3, 0, -70))))
for side in (-1, 1):
    street.add("pavement", box((min(3 * side, 5 * side), -0.02, -70), (max(3 * side, 5 * side), 0.13, 6)))
for i in range(14):
    street.add("paint", polygon([(x, 0.004, z - 2.2 * dz) for (x, dz), z in zip(((-0.07, 0), (0.07, 0), (0.07, 1), (-0.07, 1)), [-4.0 * i] * 4)]))


def house(side, z, wide, storeys, wall):
    """A house whose front faces the street, with windows of which some are lit."""
    x, tall = 5 * side, 3.2 * storeys + 0.6
    near, far = z, z - wide
    street.add(wall, box((min(x, x + 8 * side), 0, far), (max(x, x + 8 * side), tall, near)))
    roof = [(x - 0.35 * side, tall - 0.1), (x + 4 * side, tall + 2.6), (x + 8.3 * side, tall - 0.1)]
    for (ax, ay), (bx, by) in zip(roof, roof[1:]):
        corners = [(ax, ay, near), (ax, ay, far), (bx, by, far), (bx, by, near)]
        street.add("roof", polygon(corners if side < 0 else corners[::-1]))
    street.add(wall, polygon([(rx, ry, near) for rx, ry in (roof if side > 0 else roof[::-1])]))
    columns = max(2, int(wide / 1.9))
    for storey in range(storeys):
        for i in range(columns):
            middle = near - wide * (i + 0.5) / columns
            low = 0.13 + 3.2 * storey + (0.75 if storey else 0.9)
            is_door = storey == 0 and i == columns // 2
            high = low + (1.55 if not is_door else 1.3)
            low = 0.13 if is_door else low
            face = x - 0.012 * side
            corners = [(face, low, middle + 0.5), (face, low, middle - 0.5), (face, high, middle - 0.5), (face, high, middle + 0.5)]
            what = "door" if is_door else random.choices(("dark", "lit-warm", "lit-cool", "lit-dim"), (5, 3, 1, 2))[0]
            street.add(what, polygon(corners if side > 0 else corners[::-1]))
            bars = [((low, middle + 0.5), (high, middle + 0.56)), ((low, middle - 0.56), (high, middle - 0.5)), ((high, middle - 0.56), (high + 0.08, middle + 0.56)), ((low - 0.08, middle - 0.6), (low, middle + 0.6))]
            if not is_door:
                bars += [((low, middle - 0.02), (high, middle + 0.02)), ((low + 1.0, middle - 0.5), (low + 1.04, middle + 0.5))]
            for (y0, z0), (y1, z1) in bars:
                street.add("frame", box((min(x, x - 0.06 * side), y0, z0), (max(x, x - 0.06 * side), y1, z1)))


for side in (-1, 1):
    z = 4.0
    while z > -62:
        wide = random.uniform(5.0, 8.5)
        house(side, z, wide, random.choice((2, 2, 3, 3)), random.choice(("brick", "cream", "grey", "rose")))
        z -= wide
# At the end of the street stands a church.
street.add("stone", box((-2.2, 0, -76), (2.2, 15, -72)))
for side in range(4):
    a, b = (((-2.4, -71.8), (2.4, -71.8)), ((2.4, -71.8), (2.4, -76.2)), ((2.4, -76.2), (-2.4, -76.2)), ((-2.4, -76.2), (-2.4, -71.8)))[side]
    street.add("roof", polygon(((a[0], 15, a[1]), (b[0], 15, b[1]), (0, 24, -74))))
street.add("clock", moved(disc(1.0), to=(0, 11.5, -71.98)))

# Lanterns: posts on both sides, a globe on each.
for i, z in enumerate((-5, -17, -29, -41, -53)):
    for side in (-1, 1):
        x, shift = side * 3.4, z - (6 if side > 0 else 0)
        street.add("iron", moved(turned([(0.035, 3.7), (0.045, 1.0), (0.08, 0.9), (0.09, 0.13), None, (0.0, 3.72), (0.09, 3.7), (0.035, 3.62)], 20), to=(x, 0, shift)))
        street.add("globe", ball((x, 3.93, shift), 0.2, 8))
        street.add("iron", moved(turned([(0, 0.1), (0.12, 0.02), (0.13, 0)], 20), to=(x, 4.1, shift)))


def bicycle(x, z, turn):
    """Against a post: two wheels and a frame."""
    parts = []
    for dx in (-0.52, 0.52):
        ring = [(dx + 0.33 * math.cos(t), 0.33 + 0.33 * math.sin(t), 0) for t in (2 * math.pi * i / 40 for i in range(41))]
        parts.append(tube(ring, 0.017, 8))
        for k in range(10):
            t = 2 * math.pi * k / 10
            parts.append(tube([(dx, 0.33, 0), (dx + 0.32 * math.cos(t), 0.33 + 0.32 * math.sin(t), 0)], 0.0025, 5))
    bars = ((-0.52, 0.33, 0), (-0.15, 0.28, 0), (-0.28, 0.8, 0), (0.3, 0.82, 0), (0.52, 0.33, 0))
    for a, b in ((0, 1), (0, 2), (1, 2), (2, 3), (1, 3), (3, 4)):
        parts.append(tube([bars[a], bars[b]], 0.016, 10))
    parts += [tube([(-0.28, 0.8, 0), (-0.31, 0.92, 0)], 0.014, 8), tube([(-0.43, 0.93, 0), (-0.2, 0.95, 0)], [0.06, 0.03], 12)]
    parts += [tube([(0.3, 0.82, 0), (0.27, 1.0, 0)], 0.014, 8), tube([(0.27, 1.0, -0.28), (0.3, 1.0, 0), (0.27, 1.0, 0.28)], 0.013, 8)]
    street.add("iron", moved(joined(parts), to=(x, 0.13, z), turned_deg=(0, turn, 7)))


bicycle(3.55, -4.4, 82)
street.write(HERE / "street.gltf")
