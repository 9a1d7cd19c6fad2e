#!/usr/bin/env python3
"""Writes depth-of-field.gltf and .bin: pawns at growing distances on a cutting mat, small lamps far behind.

The camera stands above the origin, at (0, 0.045, 0), and looks towards -z. The mat has lines every 25 mm from there. Needs Python only.
"""

import math
import random
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent))
from gltf_file import GltfFile, lathe, sphere  # noqa: E402

# Distance in millimetres, where across the image (-1 left edge, 1 right edge), colour in linear sRGB.
PAWNS = (
    (205, -0.66, (0.55, 0.04, 0.03)),
    (245, -0.36, (0.80, 0.22, 0.03)),
    (300, -0.04, (0.80, 0.60, 0.05)),
    (375, 0.26, (0.10, 0.42, 0.08)),
    (480, 0.50, (0.05, 0.25, 0.50)),
    (640, 0.72, (0.25, 0.08, 0.40)),
)
HALF_WIDTH = 2.4 / 13.04            # of the image, at distance 1
LAMPS = 34
LAMP_RADIUS = 4.5
LAMP_COLOURS = (
    ("lamp-warm", (1.0, 0.62, 0.28)),
    ("lamp-white", (1.0, 0.90, 0.75)),
    ("lamp-red", (1.0, 0.12, 0.06)),
    ("lamp-green", (0.15, 1.0, 0.30)),
    ("lamp-blue", (0.12, 0.30, 1.0)),
)
MM = 0.001


def pawn(segments):
    """A pawn of a game of chess, 30 mm high."""
    arc = [math.radians(angle) for angle in range(0, 151, 10)]
    head = [(5.5 * math.sin(t), 24.5 + 5.5 * math.cos(t)) for t in arc]
    turn = [math.radians(angle) for angle in range(90, -91, -20)]
    collar = [(2.6, 19.4)] + [(4.9 + 0.8 * math.cos(t), 18.6 + 0.8 * math.sin(t)) for t in turn] + [(2.6, 17.8)]
    waist = [i / 12 for i in range(13)]
    body = [(3.2 + 3.3 * t**2.6, 17.9 - 12.9 * t) for t in waist]
    foot = [(6.5, 5.0)] + [(7.4 + 1.4 * math.cos(t), 3.6 + 1.4 * math.sin(t)) for t in turn[:5]] + [(8.8, 0.0)]
    runs = []
    for points in (head, collar, body, foot):
        run = []
        for i, (radius, height) in enumerate(points):
            before, after = points[max(i - 1, 0)], points[min(i + 1, len(points) - 1)]
            normal = (before[1] - after[1], after[0] - before[0])
            # The top of the head lies on the axis, where the normal is the axis.
            if radius == 0:
                normal = (0.0, 1.0)
            run.append((radius * MM, height * MM, *normal))
        runs.append(run)
    return lathe(runs, segments)


def grid():
    """The lines printed on the cutting mat, 25 mm apart, as quads side by side without overlaps."""
    positions, triangles = [], []
    half, height = 0.4, 0.05

    def quad(x0, x1, near, far):
        first = len(positions)
        positions.extend((x * MM, height * MM, -z * MM) for x, z in ((x0, near), (x1, near), (x1, far), (x0, far)))
        triangles.extend([(first, first + 1, first + 2), (first, first + 2, first + 3)])

    for z in range(150, 851, 25):
        quad(-400, 400, z - half, z + half)
        for x in range(-400, 401, 25):
            quad(x - half, x + half, z + half, z + 25 - half)
    return positions, triangles


def quad_shape(corners):
    """Two triangles, counter-clockwise."""
    return corners, None, [(0, 1, 2), (0, 2, 3)]


def main():
    file = GltfFile()
    file.material("mat", (0.014, 0.036, 0.036), roughness=0.7)
    file.material("grid", (0.32, 0.36, 0.30), roughness=0.7)
    file.material("backdrop", (0.012, 0.014, 0.022))
    file.material("softbox", (0.8, 0.8, 0.8), emission=(1.0, 0.93, 0.84), luminance_nit=3000.0)
    for name, colour in LAMP_COLOURS:
        file.material(name, (0.1, 0.1, 0.1), emission=colour, luminance_nit=2200.0)
    for number, (_, _, colour) in enumerate(PAWNS, 1):
        file.material(f"pawn-{number}", colour, roughness=0.38)

    file.shape("mat", *quad_shape([(-0.6, 0, 0.2), (0.6, 0, 0.2), (0.6, 0, -0.9), (-0.6, 0, -0.9)]))
    file.place("mat", "mat", "mat")
    file.shape("backdrop", *quad_shape([(-1.5, -0.5, -2.2), (1.5, -0.5, -2.2), (1.5, 1, -2.2), (-1.5, 1, -2.2)]))
    file.place("backdrop", "backdrop", "backdrop")
    positions, triangles = grid()
    file.shape("grid", positions, None, triangles)
    file.place("grid", "grid", "grid")
    # Above the mat on the left, facing its middle.
    file.shape("softbox", *quad_shape([(-0.42, 0.50, -0.10), (-0.42, 0.50, -0.55), (-0.18, 0.62, -0.55), (-0.18, 0.62, -0.10)]))
    file.place("softbox", "softbox", "softbox")

    file.shape("pawn", *pawn(64))
    for number, (distance, across, _) in enumerate(PAWNS, 1):
        place = (across * HALF_WIDTH * distance * MM, 0.0, -distance * MM)
        file.place(f"pawn at {distance} mm", "pawn", f"pawn-{number}", place)

    positions, triangles = sphere(1)
    file.shape("lamp", positions, positions, triangles)
    generator = random.Random(7)
    placed = []
    while len(placed) < LAMPS:
        distance = generator.uniform(1000, 1700)
        across, angle = generator.uniform(-1.05, 1.05), math.radians(generator.uniform(-2.2, 3.6))
        if all(math.hypot(across - x, (angle - y) / HALF_WIDTH) > 0.1 for x, y in placed):
            placed.append((across, angle))
            place = (across * HALF_WIDTH * distance * MM, 0.045 + math.tan(angle) * distance * MM, -distance * MM)
            colour, _ = generator.choice(LAMP_COLOURS)
            file.place(f"lamp {len(placed)}", "lamp", colour, place, LAMP_RADIUS * MM)
    file.write(HERE / "depth-of-field.gltf")


if __name__ == "__main__":
    main()
