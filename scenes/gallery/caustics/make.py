#!/usr/bin/env python3
"""Writes rings.gltf: rings of gold, copper and silver. And lamp.gltf, a round lamp of 1 m radius. Needs Python only."""

import math
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent))
from meshes import Model, disc, moved, turned  # noqa: E402


def ring(inner, outer, height, edge=0.0008):
    """A flat band with rounded edges."""
    turns = [math.radians(a) for a in range(0, 91, 15)]
    outside = [(outer - edge + edge * math.sin(t), height - edge + edge * math.cos(t)) for t in turns] + [(outer, 0)]
    inside = [(inner, 0)] + [(inner + edge - edge * math.cos(t), height - edge + edge * math.sin(t)) for t in turns]
    return turned([*outside, None, *inside, (outer - edge, height)], 360)


model = Model()
model.add("gold", moved(ring(0.034, 0.036, 0.012), to=(-0.012, 0, -0.012)))
model.add("copper", moved(ring(0.019, 0.0202, 0.009), to=(0.05, 0, 0.016)))
model.add("silver", moved(ring(0.014, 0.0150, 0.006), to=(-0.045, 0, 0.046)))
model.write(HERE / "rings.gltf")

lamp = Model()
lamp.add("lamp", disc())
lamp.write(HERE / "lamp.gltf")
