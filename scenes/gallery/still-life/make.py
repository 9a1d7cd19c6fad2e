#!/usr/bin/env python3
"""Writes still-life.gltf: fruit and pottery on a table. Needs Python only."""

import math
import random
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent))
from meshes import Model, box, curve, leaf, moved, polygon, sheet, tube, turned  # noqa: E402

random.seed(3)
scene = Model()
# A table of boards, and a wall behind it.
for i in range(5):
    z = -0.42 + 0.17 * i
    scene.add(("board-1", "board-2", "board-3")[i * 2 % 3], box((-1.2, -0.03, z + 0.001), (1.2, 0, z + 0.169)))
scene.add("wall", polygon(((-2, -0.5, -0.75), (2, -0.5, -0.75), (2, 1.6, -0.75), (-2, 1.6, -0.75))))


def cloth(u, v):
    """A cloth that hangs over the front of the table."""
    x, way = -0.42 + 0.5 * u, 0.62 * v
    ripple = 0.004 * math.sin(7 * u + 3 * v) * math.sin(5 * v + 1)
    if way < 0.38:
        return (x + 0.1 * v, 0.008 + ripple, 0.05 + way)
    return (x + 0.1 * v, 0.008 + ripple - (way - 0.38), 0.43 + 0.012 + 2 * ripple)


scene.add("linen", sheet(cloth, 70, 70))
jug = curve([(0.052, 0.33), (0.047, 0.31), (0.045, 0.28), (0.06, 0.24), (0.092, 0.18), (0.105, 0.12), (0.098, 0.06), (0.075, 0.015), (0.07, 0.0)])
scene.add("blue-glaze", moved(turned(jug, 96), to=(-0.24, 0, -0.12)))
scene.add("blue-glaze", moved(turned([(0, 0.2), (0.04, 0.3), (0.048, 0.332), (0.052, 0.33)], 96), to=(-0.24, 0, -0.12)))
handle = [(-0.24 - 0.05 - 0.07 * math.sin(t), 0.225 + 0.075 * math.cos(t), -0.12) for t in (math.pi * i / 16 for i in range(17))]
scene.add("blue-glaze", tube(handle, [0.011] * 17, 16))
bowl = [(0.0, 0.022), (0.06, 0.026), (0.11, 0.05), (0.143, 0.09), (0.148, 0.092), (0.15, 0.088), (0.118, 0.042), (0.07, 0.012), (0.055, 0.0), (0, 0.0)]
scene.add("white-glaze", moved(turned(bowl, 96), to=(0.12, 0, -0.08)))


def fruit(material, x, y, z, radius, squash=0.94, turn=(0, 0, 0)):
    """With a dimple at its stalk."""
    run = []
    for i in range(33):
        t = math.pi * i / 32
        r = 1 - 0.16 * math.exp(-(t / 0.32) ** 2) - 0.1 * math.exp(-((math.pi - t) / 0.3) ** 2)
        run.append((radius * r * math.sin(t) if 0 < i < 32 else 0.0, radius * squash * r * math.cos(t)))
    scene.add(material, moved(turned(run, 64), to=(x, y, z), turned_deg=turn))


fruit("orange", 0.06, 0.085, -0.06, 0.046, 0.96)
fruit("orange", 0.155, 0.083, -0.03, 0.043, 0.96, (30, 0, 0))
fruit("red-apple", 0.16, 0.092, -0.12, 0.042, 0.9, (-15, 0, -20))
fruit("green-apple", 0.085, 0.135, -0.115, 0.043, 0.9, (20, 0, 15))
fruit("red-apple", -0.02, 0.036, 0.12, 0.04, 0.9, (-25, 20, 25))
scene.add("stalk", tube([(-0.035, 0.064, 0.13), (-0.042, 0.078, 0.137), (-0.046, 0.088, 0.138)], [0.0017, 0.0014, 0.002], 8))


def lemon(x, y, z, turn):
    run = []
    for i in range(41):
        t = math.pi * i / 40
        tip = 0.25 * math.exp(-(t / 0.2) ** 2) + 0.2 * math.exp(-((math.pi - t) / 0.2) ** 2)
        run.append((0.031 * math.sin(t) if 0 < i < 40 else 0.0, 0.037 * (1 + tip) * math.cos(t)))
    scene.add("lemon", moved(turned(run, 64), to=(x, y, z), turned_deg=turn))


lemon(0.255, 0.031, 0.09, (0, 25, 90))
lemon(0.325, 0.031, 0.05, (0, -40, 90))
pear = curve([(0.0, 0.115), (0.008, 0.113), (0.014, 0.105), (0.018, 0.09), (0.026, 0.07), (0.038, 0.045), (0.04, 0.028), (0.034, 0.011), (0.02, 0.001), (0, 0.002)])
scene.add("pear", moved(turned(pear, 64), to=(-0.115, 0, 0.06), turned_deg=(4, 0, -5)))
scene.add("stalk", tube([(-0.105, 0.112, 0.064), (-0.102, 0.125, 0.066), (-0.096, 0.134, 0.067)], [0.002, 0.0016, 0.0022], 8))
pot = curve([(0.078, 0.15), (0.076, 0.14), (0.088, 0.1), (0.093, 0.06), (0.085, 0.02), (0.065, 0.0)])
scene.add("copper", moved(turned(pot, 96), to=(0.38, 0, -0.16)))
scene.add("copper", moved(turned([(0, 0.03), (0.06, 0.04), (0.078, 0.15)], 96), to=(0.38, 0, -0.16)))
# A branch in the jug.
for i in range(7):
    angle = random.uniform(0, 360)
    c, s = math.cos(math.radians(angle)), math.sin(math.radians(angle))
    reach, up = random.uniform(0.06, 0.17), random.uniform(0.2, 0.33)
    stem = [(-0.24 + reach * t**1.6 * c, 0.27 + up * t, -0.12 + reach * t**1.6 * s) for t in (0, 0.25, 0.5, 0.75, 1)]
    scene.add("stalk", tube(stem, 0.0022, 8))
    for k, point in enumerate(stem[1:] + stem[2:]):
        scene.add("leaf", moved(leaf(random.uniform(0.05, 0.085), 0.019), to=point, turned_deg=(random.uniform(-30, 30), random.uniform(0, 360), random.uniform(0, 50))))
# A soft light from the left, as of a window.
scene.add("window", polygon(((-1.35, 0.25, -0.45), (-1.35, 1.25, -0.45), (-1.05, 1.35, 0.75), (-1.05, 0.25, 0.75))))
scene.write(HERE / "still-life.gltf")
