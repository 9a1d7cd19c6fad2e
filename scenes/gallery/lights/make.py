#!/usr/bin/env python3
"""Writes lights.gltf: strings of small lamps behind figures of a game of chess. Needs Python only."""

import math
import random
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent))
from meshes import Model, ball, box, moved, polygon, tube, turned  # noqa: E402

random.seed(5)
scene = Model()
COLOURS = ("warm", "warm", "warm", "white", "red", "green", "blue", "amber")
scene.add("wood", box((-1, -0.02, -0.6), (1, 0, 0.4)))


def figures():
    """A king and two pawns of a game of chess, turned from brass, dark wood and box."""
    king = [(0, 0.098), (0.004, 0.097), (0.0035, 0.09), (0.0075, 0.0885), (0.0085, 0.0865), (0.0135, 0.082), (0.0085, 0.066), (0.0088, 0.064), (0.013, 0.0625), (0.0125, 0.0605), (0.0085, 0.059),
            (0.0082, 0.05), (0.0095, 0.035), (0.0135, 0.02), (0.0165, 0.0165), (0.0155, 0.0145), (0.0185, 0.012), (0.021, 0.008), (0.021, 0.004), (0.0205, 0.0), (0, 0)]
    pawn = [(0, 0.052)] + [(0.0095 * math.sin(t), 0.0425 + 0.0095 * math.cos(t)) for t in (math.radians(a) for a in range(12, 150, 12))] + [
        (0.0055, 0.0335), (0.0105, 0.0325), (0.01, 0.031), (0.0058, 0.03), (0.0062, 0.024), (0.0085, 0.015), (0.012, 0.011), (0.0135, 0.008), (0.0165, 0.006), (0.0165, 0.002), (0.016, 0.0), (0, 0)]
    scene.add("king", moved(turned(king, 96), to=(0.0, 0, 0.0)))
    scene.add("box", moved(turned(pawn, 96), to=(-0.062, 0, 0.004)))
    scene.add("rosewood", moved(turned(pawn, 96), to=(0.058, 0, -0.02)))
    scene.add("rosewood", moved(moved(turned(pawn, 96), turned_deg=(0, 0, 90)), to=(0.062, 0.0165, 0.035), turned_deg=(0, 35, 0)))


def strings():
    """Lamps along wires that sag, row behind row."""
    for row, (z, size) in enumerate(((-0.55, 0.005), (-0.8, 0.0065), (-1.1, 0.0085), (-1.5, 0.011))):
        for k in range(3):
            wide = 0.62 * (1 - z) * 0.62
            y0, sag = random.uniform(0.09, 0.3) * (1 - 0.6 * z), random.uniform(0.04, 0.1) * (1 - z)
            shift = random.uniform(-0.2, 0.2)
            for i in range(9):
                u = (i + 0.5 + random.uniform(-0.3, 0.3)) / 9
                x = wide * (u - 0.5) * 1.3 + shift
                y = y0 - sag * 4 * u * (1 - u) + random.uniform(-0.015, 0.015)
                scene.add(random.choice(COLOURS), ball((x, y, z + random.uniform(-0.1, 0.1)), size, 4))


figures()
strings()
# A soft light from the upper left for the figures.
scene.add("soft", moved(polygon(((-0.12, -0.12, 0), (0.12, -0.12, 0), (0.12, 0.12, 0), (-0.12, 0.12, 0))), to=(-0.28, 0.3, 0.22), turned_deg=(42, 128, 0)))
scene.write(HERE / "lights.gltf")
