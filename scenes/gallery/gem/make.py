#!/usr/bin/env python3
"""Writes brilliant.gltf: a diamond in the round brilliant cut, 1 m across the girdle. And lamp.gltf, a round lamp of 1 m radius. Needs Python only."""

import math
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent))
from meshes import Model, disc, joined, polygon  # noqa: E402

TABLE = 0.56                        # width of the table over the diameter
CROWN_DEG, PAVILION_DEG = 34.5, 40.8
STAR_DEG, UPPER_DEG, LOWER_DEG = 21.5, 40.0, 42.2
GIRDLE = 0.03                       # its height


def facets():
    """Planes of all facets as (normal, distance from the origin); the middle of the girdle is at the origin."""
    planes = []

    def facet(azimuth_deg, angle_deg, radius, height):
        """A facet through a point of that radius and height, at its angle to the girdle's plane."""
        a, t = math.radians(azimuth_deg), math.radians(angle_deg)
        side = 1 if height > 0 else -1
        normal = (math.sin(t) * math.cos(a), side * math.cos(t), math.sin(t) * math.sin(a))
        planes.append((normal, normal[0] * radius * math.cos(a) + normal[1] * height + normal[2] * radius * math.sin(a)))

    top = GIRDLE / 2
    crown = (0.5 - TABLE / 2) * math.tan(math.radians(CROWN_DEG))
    planes.append(((0.0, 1.0, 0.0), top + crown))
    for i in range(8):
        facet(45 * i, CROWN_DEG, 0.5, top)
        facet(45 * i + 22.5, STAR_DEG, TABLE / 2 * math.cos(math.radians(22.5)), top + crown)
        facet(45 * i, PAVILION_DEG, 0.5, -top)
    for i in range(16):
        edge = 0.5 * math.cos(math.radians(11.25))
        facet(22.5 * i + 11.25, UPPER_DEG, edge, top)
        facet(22.5 * i + 11.25, LOWER_DEG, edge, -top)
    for i in range(64):
        a = 2 * math.pi * i / 64
        planes.append(((math.cos(a), 0.0, math.sin(a)), 0.4955))
    return planes


def dot(a, b):
    return sum(x * y for x, y in zip(a, b))


def cut(corners, normal, distance):
    """What of a polygon lies behind a plane."""
    kept = []
    for i, corner in enumerate(corners):
        before = corners[i - 1]
        here, there = dot(corner, normal) - distance, dot(before, normal) - distance
        if (here > 0) != (there > 0):
            t = there / (there - here)
            kept.append(tuple(b + t * (c - b) for b, c in zip(before, corner)))
        if here <= 0:
            kept.append(corner)
    return kept


def convex(planes):
    """The body behind all planes, facet by facet."""
    faces = []
    for i, (normal, distance) in enumerate(planes):
        across = (0.0, 1.0, 0.0) if abs(normal[1]) < 0.9 else (1.0, 0.0, 0.0)
        u = (across[1] * normal[2] - across[2] * normal[1], across[2] * normal[0] - across[0] * normal[2], across[0] * normal[1] - across[1] * normal[0])
        length = math.sqrt(dot(u, u))
        u = tuple(c / length for c in u)
        v = (normal[1] * u[2] - normal[2] * u[1], normal[2] * u[0] - normal[0] * u[2], normal[0] * u[1] - normal[1] * u[0])
        corners = [tuple(distance * n + 3 * (a * p + b * q) for n, p, q in zip(normal, u, v)) for a, b in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
        for j, plane in enumerate(planes):
            if j != i:
                corners = cut(corners, *plane)
        # Corners that are the same but for rounding make triangles without an area.
        corners = [c for k, c in enumerate(corners) if math.dist(c, corners[k - 1]) > 1e-9]
        if len(corners) > 2:
            faces.append(polygon(corners))
    return joined(faces)


model = Model()
model.add("diamond", convex(facets()))
model.write(HERE / "brilliant.gltf")

lamp = Model()
lamp.add("lamp", disc())
lamp.write(HERE / "lamp.gltf")
