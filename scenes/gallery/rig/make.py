#!/usr/bin/env python3
"""Writes rig.gltf: two cameras on a bar upon a tripod. Needs Python only."""

import math
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent))
from meshes import Model, box, disc, joined, moved, polygon, tube, turned  # noqa: E402

rig = Model()
BAR = 1.18


def bevelled(low, high, edge):
    """A box whose edges along z are cut off."""
    (x0, y0, z0), (x1, y1, z1) = low, high
    outline = [(x0 + edge, y0), (x1 - edge, y0), (x1, y0 + edge), (x1, y1 - edge), (x1 - edge, y1), (x0 + edge, y1), (x0, y1 - edge), (x0, y0 + edge)]
    faces = [polygon([(x, y, z1) for x, y in outline]), polygon([(x, y, z0) for x, y in outline[::-1]])]
    for (ax, ay), (bx, by) in zip(outline, outline[1:] + outline[:1]):
        faces.append(polygon([(ax, ay, z0), (bx, by, z0), (bx, by, z1), (ax, ay, z1)]))
    return joined(faces)


def camera(x, toe_deg):
    """An industrial camera that looks along -z, with its lens."""
    place = {"to": (x, BAR + 0.055, 0.0), "turned_deg": (0, toe_deg, 0)}
    rig.add("anodised", moved(bevelled((-0.036, -0.036, -0.03), (0.036, 0.036, 0.07), 0.006), **place))
    for i in range(6):
        z = -0.018 + 0.014 * i
        rig.add("black", moved(bevelled((-0.038, -0.038, z), (0.038, 0.038, z + 0.006), 0.007), **place))
    rig.add("black", moved(bevelled((-0.031, -0.031, 0.07), (0.031, 0.031, 0.0715), 0.004), **place))
    rig.add("steel", moved(moved(turned([(0, 0.003), (0.011, 0.003), None, (0.011, 0.003), (0.011, 0)], 32), turned_deg=(90, 0, 0)), to=place["to"], turned_deg=(0, toe_deg, 0)))
    profile = [(0.0, 0.094), (0.023, 0.098), None, (0.023, 0.098), (0.033, 0.103), None, (0.033, 0.103), (0.034, 0.1), (0.034, 0.083), None, (0.034, 0.083), (0.031, 0.08), (0.031, 0.062), None,
               (0.031, 0.062), (0.0335, 0.06), (0.0335, 0.045), None, (0.0335, 0.045), (0.0275, 0.042), (0.0275, 0.03), None, (0.0275, 0.03), (0, 0.03)]
    rig.add("black", moved(moved(turned(profile, 64), turned_deg=(-90, 0, 0)), **place))
    rig.add("red", moved(moved(turned([(0.0352, 0.0545), (0.0352, 0.0515)], 64), turned_deg=(-90, 0, 0)), **place))
    # Plug, cable, and lamp at the back.
    plug = [(0.012, 0.0), (0.012, 0.022), (0.009, 0.026), (0.005, 0.045)]
    rig.add("black", moved(moved(turned(plug[::-1], 32), to=(0, 0.012, 0.0715), turned_deg=(90, 0, 0)), to=place["to"], turned_deg=(0, toe_deg, 0)))
    rig.add("led", moved(moved(disc(0.0025, 16), to=(0.02, -0.02, 0.0721)), **place))
    down = [(x, BAR + 0.067, 0.11), (x, BAR + 0.065, 0.16), (x * 0.97, BAR + 0.03, 0.195), (x * 0.9, BAR - 0.05, 0.19), (x * 0.6, BAR - 0.17, 0.15), (x * 0.2, BAR - 0.27, 0.08), (0.03, BAR - 0.45, 0.05), (0.03, BAR - 0.75, 0.05)]
    rig.add("cable", tube(down, 0.0042, 12))
    rig.add("steel", box((x - 0.03, BAR + 0.006, -0.025), (x + 0.03, BAR + 0.019, 0.055)))


rig.add("aluminium", bevelled((-0.42, BAR - 0.034, -0.018), (0.42, BAR + 0.006, 0.042), 0.004))
for x in (-0.423, 0.42):
    rig.add("black", box((x, BAR - 0.034, -0.018), (x + 0.003, BAR + 0.006, 0.042)))
for i in range(-8, 9):
    rig.add("black", box((0.05 * i - 0.0008, BAR - 0.02, 0.0421), (0.05 * i + 0.0008, BAR + (0.0 if i % 2 else -0.008), 0.0424)))
camera(-0.29, -7)
camera(0.29, 7)
rig.add("black", moved(turned([(0.0, BAR - 0.034), (0.05, BAR - 0.034), (0.05, BAR - 0.05), (0.028, BAR - 0.07), (0.028, BAR - 0.13), (0.045, BAR - 0.14), (0.045, BAR - 0.21), (0.02, BAR - 0.22), (0.02, 0.55)], 48), to=(0, 0, 0.012)))
for angle in (90, 210, 330):
    c, s = math.cos(math.radians(angle)), math.sin(math.radians(angle))
    rig.add("aluminium", tube([(0.04 * c, BAR - 0.18, 0.012 + 0.04 * s), (0.42 * c, 0.02, 0.012 + 0.42 * s)], [0.016, 0.012], 16))
    rig.add("black", tube([(0.2 * c, 0.68, 0.012 + 0.2 * s), (0.245 * c, 0.56, 0.012 + 0.245 * s)], 0.021, 20))
    rig.add("black", tube([(0.41 * c, 0.035, 0.012 + 0.41 * s), (0.425 * c, 0.0, 0.012 + 0.425 * s)], [0.017, 0.02], 16))

# The board's frame and its easel, at z = -1.6.
rig.add("aluminium", box((-0.62, 0.72, -1.625), (0.62, 1.66, -1.605)))
for x in (-0.45, 0.45):
    rig.add("pine", tube([(x, 1.75, -1.648), (x * 1.15, 0.0, -1.648)], 0.02, 12))
rig.add("pine", tube([(0, 1.72, -1.68), (0, 0.0, -2.15)], 0.02, 12))
rig.add("pine", box((-0.66, 0.685, -1.64), (0.66, 0.718, -1.565)))
# A soft light on a stand, to the left.
panel = moved(polygon(((-0.4, -0.4, 0), (0.4, -0.4, 0), (0.4, 0.4, 0), (-0.4, 0.4, 0))), to=(-1.55, 1.75, -0.55), turned_deg=(12, 72, 0))
rig.add("panel", panel)
shell = moved(joined([polygon(((-0.43, -0.43, -0.01), (-0.43, 0.43, -0.01), (0.43, 0.43, -0.01), (0.43, -0.43, -0.01))), box((-0.43, -0.43, -0.03), (-0.4, 0.43, 0.01)), box((0.4, -0.43, -0.03), (0.43, 0.43, 0.01)),
                      box((-0.43, -0.43, -0.03), (0.43, -0.4, 0.01)), box((-0.43, 0.4, -0.03), (0.43, 0.43, 0.01))]), to=(-1.55, 1.75, -0.55), turned_deg=(12, 72, 0))
rig.add("black", shell)
rig.add("black", tube([(-1.62, 1.7, -0.57), (-1.62, 0.0, -0.57)], 0.016, 12))
for angle in (30, 150, 270):
    c, s = math.cos(math.radians(angle)), math.sin(math.radians(angle))
    rig.add("black", tube([(-1.62, 0.45, -0.57), (-1.62 + 0.35 * c, 0.0, -0.57 + 0.35 * s)], 0.01, 10))
rig.write(HERE / "rig.gltf")
