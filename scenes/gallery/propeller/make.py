#!/usr/bin/env python3
"""Writes plane.gltf and propeller.gltf: a small aeroplane, and what turns at its nose. Needs Python only."""

import math
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent))
from meshes import Model, ball, box, moved, sheet, tube, turned  # noqa: E402

# The nose is at z = 0, the tail behind it; the propeller turns about +z.
plane = Model()


def along(points, segments=64):
    """A solid of revolution about z: (radius, z) from the nose to the tail."""
    return moved(turned([point and (point[0], point[1]) for point in points], segments), turned_deg=(90, 0, 0))


def wing(span, chord, thick, to, sweep=0.0, rise=0.0):
    """A wing with round tips, its profile thickest at a third of its chord."""
    def at(u, v):
        s = 2 * u - 1
        c = chord * max(1e-4, 1 - abs(s) ** 6) ** 0.5 * (1 - 0.35 * abs(s))
        a = 2 * math.pi * v
        x = 0.5 * (1 + math.cos(a))
        y = thick * c / chord * math.sin(a) * (0.35 + 0.65 * (1 - x)) * (1.25 if math.sin(a) > 0 else 0.75)
        return (to[0] + s * span / 2, to[1] + y + rise * abs(s), to[2] - c * (x - 0.35) - sweep * abs(s))
    return sheet(at, 80, 40)


fuselage = [(0.30, -0.06), (0.40, -0.10), (0.46, -0.22), (0.50, -0.5), (0.53, -1.0), (0.54, -1.6), (0.50, -2.4), (0.38, -3.6), (0.22, -4.9), (0.1, -5.6), (0.02, -5.8)]
plane.add("red", along([(r, z) for r, z in fuselage[:4]]))
plane.add("cream", along(fuselage[3:]))
plane.add("black", along([(0.0, -0.055), (0.30, -0.055)]))
for x in (-0.2, 0.2):
    plane.add("black", ball((x, 0.02, -0.1), 0.095, 12, stretch=(1.15, 0.75, 0.4)))
plane.add("red", wing(8.6, 1.35, 0.12, (0, -0.3, -1.45), rise=0.42))
plane.add("red", wing(3.0, 0.75, 0.05, (0, 0.12, -5.15)))
plane.add("red", moved(wing(1.9, 0.85, 0.05, (0, 0, 0), sweep=0.2), to=(0, 0.55, -5.2), turned_deg=(0, 0, 90)))
plane.add("canopy", ball((0, 0.42, -1.7), 0.4, 24, stretch=(0.85, 0.95, 1.9)))
for side in (-1, 1):
    plane.add("cream", tube([(side * 0.35, -0.38, -1.1), (side * 1.0, -1.05, -0.95)], [0.055, 0.04]))
    wheel = [(0, 0.07), (0.12, 0.075), None, (0.12, 0.075), (0.19, 0.06), (0.215, 0.0), (0.19, -0.06), (0.12, -0.075), None, (0.12, -0.075), (0, -0.07)]
    plane.add("rubber", moved(turned(wheel, 48), to=(side * 1.06, -1.12, -0.95), turned_deg=(0, 0, 90)))
    plane.add("cream", ball((side * 1.06, -1.02, -0.98), 0.22, 16, stretch=(0.55, 0.95, 1.5)))
plane.add("cream", tube([(0, -0.2, -5.4), (0, -0.5, -5.6)], 0.03))
plane.add("rubber", moved(turned([(0, 0.03), (0.08, 0.03), (0.1, 0), (0.08, -0.03), (0, -0.03)], 32), to=(0, -0.55, -5.6), turned_deg=(0, 0, 90)))
plane.write(HERE / "plane.gltf")

propeller = Model()
propeller.add("red", along([(0.0, 0.30), (0.06, 0.285), (0.115, 0.235), (0.15, 0.16), (0.17, 0.06), (0.175, -0.03)]))
for k in range(3):
    def blade(r0, r1):
        def at(u, v):
            r = r0 + (r1 - r0) * u
            t = r / 0.98
            chord = 0.17 * (math.sin(math.pi * min(1, 0.18 + 0.75 * t)) ** 0.8) * max(1e-3, 1 - t**14) ** 0.5
            twist = math.radians(62 - 46 * t)
            a = 2 * math.pi * v
            x, y = 0.5 * chord * math.cos(a), 0.09 * chord * math.sin(a)
            return (x * math.cos(twist) - y * math.sin(twist), r, x * math.sin(twist) + y * math.cos(twist) + 0.06)
        return sheet(at, 24, 24)
    for material, r0, r1 in (("steel", 0.1, 0.84), ("yellow", 0.84, 0.979)):
        propeller.add(material, moved(blade(r0, r1), turned_deg=(0, 0, 120 * k)))
propeller.write(HERE / "propeller.gltf")
