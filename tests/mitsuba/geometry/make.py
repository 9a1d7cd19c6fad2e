#!/usr/bin/env python3
"""Writes the geometry that scenes of the suite share, as OBJ files beside this script. Units are metres.

    stage.obj     a floor (material "floor"), a wall behind it ("wall"), a lamp above that faces down ("lamp")
    balls.obj     two balls of radius 0.5 side by side on the floor ("left", "right"), without normals
    uv-ball.obj   one ball of radius 0.5 with normals and UVs ("ball")
    block.obj     a block in the middle of the floor ("block")
"""

import math
from pathlib import Path

HERE = Path(__file__).resolve().parent


def icosphere(levels):
    """Vertices on the unit sphere and triangles, counter-clockwise from outside."""
    g = (1 + 5**0.5) / 2
    points = [(-1, g, 0), (1, g, 0), (-1, -g, 0), (1, -g, 0), (0, -1, g), (0, 1, g)]
    points += [(0, -1, -g), (0, 1, -g), (g, 0, -1), (g, 0, 1), (-g, 0, -1), (-g, 0, 1)]
    faces = [(0, 11, 5), (0, 5, 1), (0, 1, 7), (0, 7, 10), (0, 10, 11), (1, 5, 9), (5, 11, 4), (11, 10, 2)]
    faces += [(10, 7, 6), (7, 1, 8), (3, 9, 4), (3, 4, 2), (3, 2, 6), (3, 6, 8), (3, 8, 9), (4, 9, 5)]
    faces += [(2, 4, 11), (6, 2, 10), (8, 6, 7), (9, 8, 1)]

    def unit(p):
        length = math.hypot(*p)
        return tuple(c / length for c in p)

    points = [unit(p) for p in points]
    for _ in range(levels):
        middles, finer = {}, []

        def middle(a, b):
            key = (min(a, b), max(a, b))
            if key not in middles:
                middles[key] = len(points)
                points.append(unit(tuple((x + y) / 2 for x, y in zip(points[a], points[b]))))
            return middles[key]

        for a, b, c in faces:
            ab, bc, ca = middle(a, b), middle(b, c), middle(c, a)
            finer += [(a, ab, ca), (b, bc, ab), (c, ca, bc), (ab, bc, ca)]
        faces = finer
    return points, faces


class Obj:
    """Lines of an OBJ file."""

    def __init__(self):
        self.lines, self.vertices = [], 0

    def add(self, material, points, faces):
        self.lines.append(f"usemtl {material}")
        self.lines += ["v " + " ".join(f"{c:.6f}" for c in p) for p in points]
        self.lines += ["f " + " ".join(str(i + 1 + self.vertices) for i in f) for f in faces]
        self.vertices += len(points)

    def write(self, name):
        (HERE / name).write_text("# Written by make.py.\n" + "\n".join(self.lines) + "\n", encoding="utf-8")


def quad(*corners):
    return corners, [(0, 1, 2, 3)]


def main():
    stage = Obj()
    stage.add("floor", *quad((-2, 0, 2), (2, 0, 2), (2, 0, -2), (-2, 0, -2)))
    stage.add("wall", *quad((-2, 0, -2), (2, 0, -2), (2, 3, -2), (-2, 3, -2)))
    stage.add("lamp", *quad((-1.5, 2.5, -1.5), (1.5, 2.5, -1.5), (1.5, 2.5, 1.5), (-1.5, 2.5, 1.5)))
    stage.write("stage.obj")

    balls = Obj()
    points, faces = icosphere(3)
    for name, x in (("left", -0.6), ("right", 0.6)):
        balls.add(name, [(0.5 * a + x, 0.5 * b + 0.5, 0.5 * c) for a, b, c in points], faces)
    balls.write("balls.obj")

    rows, columns = 16, 32
    lines = ["# Written by make.py.", "usemtl ball"]
    for j in range(rows + 1):
        for i in range(columns + 1):
            t, p = math.pi * j / rows, 2 * math.pi * i / columns
            n = math.sin(t) * math.cos(p), math.cos(t), -math.sin(t) * math.sin(p)
            lines.append("v " + " ".join(f"{0.5 * c + o:.6f}" for c, o in zip(n, (0, 0.5, 0))))
            lines.append("vn " + " ".join(f"{c:.6f}" for c in n))
            lines.append(f"vt {i / columns:.6f} {1 - j / rows:.6f}")
    for j in range(rows):
        for i in range(columns):
            a, b = j * (columns + 1) + i + 1, (j + 1) * (columns + 1) + i + 1
            corners = ([a, b, b + 1] if j < rows - 1 else [], [a, b + 1, a + 1] if j > 0 else [])
            for triangle in corners if j < rows - 1 else ([a, b + 1, a + 1],):
                if triangle:
                    lines.append("f " + " ".join(f"{k}/{k}/{k}" for k in triangle))
    (HERE / "uv-ball.obj").write_text("\n".join(lines) + "\n", encoding="utf-8")

    block = Obj()
    (x0, x1), (y0, y1), (z0, z1) = (-0.3, 0.3), (0.0, 1.0), (-0.3, 0.3)
    block.add("block", *quad((x0, y0, z1), (x1, y0, z1), (x1, y1, z1), (x0, y1, z1)))
    block.add("block", *quad((x1, y0, z0), (x0, y0, z0), (x0, y1, z0), (x1, y1, z0)))
    block.add("block", *quad((x1, y0, z1), (x1, y0, z0), (x1, y1, z0), (x1, y1, z1)))
    block.add("block", *quad((x0, y0, z0), (x0, y0, z1), (x0, y1, z1), (x0, y1, z0)))
    block.add("block", *quad((x0, y1, z1), (x1, y1, z1), (x1, y1, z0), (x0, y1, z0)))
    block.write("block.obj")


if __name__ == "__main__":
    main()
