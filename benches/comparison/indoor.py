"""Scenes of the comparison in rooms, whose light is hard to find: f to j.

Rooms are 4 m wide (x), 2.6 m high (y) and 5 m long (z), around x = 0 and z = 0 on the floor y = 0.
"""

import math

import numpy as np

from .capture import Scene
from .materials import Light, diffuse, glass, glossy
from .meshes import box, lathe, quads, sphere

WHITE, WOOD, RED, BLUE = (0.75, 0.73, 0.7), (0.45, 0.3, 0.18), (0.6, 0.08, 0.06), (0.1, 0.2, 0.5)
MATT = [diffuse("white", WHITE), diffuse("wood", WOOD), diffuse("red", RED), diffuse("blue", BLUE)]
WARM, DAYLIGHT = (1.0, 0.78, 0.5), (0.75, 0.87, 1.0)


def block(material, low, high):
    """A box along the axes by its corners."""
    low, high = np.array(low, dtype=np.float64), np.array(high, dtype=np.float64)
    x, y, z = np.diag((high - low) / 2)
    return box(material, (low + high) / 2, x, y, z)


def shell(back=-2.5, sides="left right back"):
    """Floor, ceiling, the wall behind the camera, and those of the other walls that are named."""
    depth = 2.5 - back
    walls = {
        "left": quads("white", ((-2, 0, 2.5), (0, 0, -depth), (0, 2.6, 0))),
        "right": quads("white", ((2, 0, back), (0, 0, depth), (0, 2.6, 0))),
        "back": quads("white", ((-2, 0, back), (4, 0, 0), (0, 2.6, 0))),
    }
    return [
        quads("wood", ((-2, 0, 2.5), (4, 0, 0), (0, 0, -depth))),
        quads("white", ((-2, 2.6, back), (4, 0, 0), (0, 0, depth)), ((2, 0, 2.5), (-4, 0, 0), (0, 2.6, 0))),
        *(walls[side] for side in sides.split()),
    ]


def furniture():
    """A table, a ball on it and a chest."""
    legs = [block("wood", (x, 0, z), (x + 0.06, 0.7, z + 0.06)) for x in (-1.5, -0.36) for z in (-1.7, -0.96)]
    table = block("wood", (-1.5, 0.7, -1.7), (-0.3, 0.75, -0.9))
    return [table, *legs, sphere("red", 32, 64, smooth=True).moved((-0.7, 0.95, -1.3), 0.2), block("blue", (0.3, 0, -2.4), (1.3, 0.8, -1.9))]


def window():
    """Scene f."""
    wall = [
        block("white", (2, 0, -2.5), (2.25, 0.9, 2.5)),
        block("white", (2, 2.1, -2.5), (2.25, 2.6, 2.5)),
        block("white", (2, 0.9, -2.5), (2.25, 2.1, -0.6)),
        block("white", (2, 0.9, 0.6), (2.25, 2.1, 2.5)),
    ]
    camera = {"eye": [-0.5, 1.5, 2.4], "target": [-0.6, 0.95, -2.5], "focal_length_mm": 2.2}
    return Scene(shell(sides="left back") + wall + furniture(), MATT, **camera, environment=Light(DAYLIGHT, 5_000), exposure_s=0.0008)


def door_ajar():
    """Scene g: the next room is bright; its door opens into it by twelve degrees."""
    partition = [
        block("white", (-2, 0, -2.6), (-0.5, 2.6, -2.5)),
        block("white", (0.5, 0, -2.6), (2, 2.6, -2.5)),
        block("white", (-0.5, 2.1, -2.6), (0.5, 2.6, -2.5)),
    ]
    turn = math.radians(12)
    along, through = np.array([math.cos(turn), 0, -math.sin(turn)]), np.array([math.sin(turn), 0, math.cos(turn)])
    hinge = np.array([-0.5, 0, -2.56])
    door = box("wood", hinge + 0.5 * along + np.array([0, 1.05, 0]), 0.5 * along, (0, 1.05, 0), 0.02 * through)
    lamp = quads("lamp", ((-0.5, 2.59, -4.6), (1, 0, 0), (0, 0, 1)))
    camera = {"eye": [0.9, 1.45, 2.3], "target": [-0.2, 1.0, -2.5], "focal_length_mm": 2.4}
    things = furniture()[-1:] + [sphere("red", 32, 64, smooth=True).moved((-1.1, 0.3, -1.5), 0.3)]
    materials = [*MATT, diffuse("lamp", WHITE, Light(WARM, 20_000))]
    return Scene(shell(-5.5) + partition + [door, lamp] + things, materials, **camera, exposure_s=0.02)


def screen():
    """Scene h."""
    board = block("blue", (-1.62, 0.5, -1.7), (-1.6, 1.7, -0.5))
    lamp = quads("lamp", ((-1.63, 0.9, -1.3), (0, 0, 0.4), (0, 0.4, 0)))
    foot = block("wood", (-1.63, 0, -1.15), (-1.59, 0.5, -1.05))
    camera = {"eye": [1.3, 1.5, 2.3], "target": [-0.7, 1.0, -1.8], "focal_length_mm": 2.2}
    chair = block("red", (-0.4, 0, -1.5), (0.2, 0.5, -0.9))
    ball = sphere("white", 32, 64, smooth=True).moved((0.5, 0.35, -2.0), 0.35)
    return Scene(shell() + [board, lamp, foot, chair, ball], [*MATT, diffuse("lamp", WHITE, Light(WARM, 50_000))], **camera, exposure_s=0.0007)


def glass_lamp():
    """Scene i: a bulb of 18 cm in a globe of glass, 30 cm wide and 1 cm thick."""
    centre = np.array([-0.9, 0.91, -1.3])
    lamp = [
        sphere("lamp", 16, 32).moved(centre, 0.09),
        sphere("glass", 64, 128, smooth=True).moved(centre, 0.14).turned_out(),
        sphere("glass", 64, 128, smooth=True).moved(centre, 0.15),
    ]
    table, *legs, ball, chest = furniture()
    ball = sphere("red", 32, 64, smooth=True).moved((-0.5, 0.85, -1.05), 0.1)
    camera = {"eye": [0.3, 1.45, 1.2], "target": [-0.6, 0.85, -1.8], "focal_length_mm": 2.2}
    materials = [*MATT, glass("glass"), diffuse("lamp", WHITE, Light(WARM, 20_000))]
    return Scene(shell() + [table, *legs, ball, chest, *lamp], materials, **camera, exposure_s=0.001)


def kitchen():
    """Scene j."""
    pot = lathe("steel", (0.0, 0.12, 0.125, 0.125, 0.13, 0.115, 0.115, 0.0), (0.0, 0.0, 0.01, 0.17, 0.18, 0.18, 0.02, 0.015), 64)
    things = [
        block("lacquer", (-2, 0, -2.5), (2, 0.88, -1.9)),
        block("stone", (-2, 0.88, -2.5), (2, 0.92, -1.85)),
        block("lacquer", (-2, 1.5, -2.5), (-0.5, 2.3, -2.15)),
        block("lacquer", (0.5, 1.5, -2.5), (2, 2.3, -2.15)),
        block("steel", (-0.4, 1.6, -2.5), (0.4, 1.75, -2.0)),
        block("steel", (-0.15, 1.75, -2.5), (0.15, 2.6, -2.2)),
        block("stone", (-0.35, 0.92, -2.4), (0.35, 0.93, -1.95)),
        pot.moved((-0.15, 0.931, -2.2)),
        sphere("kettle", 48, 96, smooth=True).moved((0.8, 1.035, -2.15), 0.11),
        block("lacquer", (-1.9, 0, -1.2), (-0.9, 0.86, -0.6)),
        block("stone", (-1.95, 0.86, -1.25), (-0.85, 0.9, -0.55)),
        quads("tiles", ((-2, 0.92, -2.49), (4, 0, 0), (0, 0.7, 0))),
        quads("strip", ((-1.9, 1.49, -2.2), (1.3, 0, 0), (0, 0, 0.04)), ((0.6, 1.49, -2.2), (1.3, 0, 0), (0, 0, 0.04))),
        quads("lamp", ((-0.9, 2.59, 0.6), (0.8, 0, 0), (0, 0, 0.3))),
    ]
    floor, *walls = shell()
    floor.material = "floor"
    materials = [
        diffuse("white", WHITE),
        glossy("tiles", (0.7, 0.72, 0.68), 0.25),
        glossy("floor", (0.2, 0.18, 0.16), 0.3),
        glossy("lacquer", (0.45, 0.07, 0.05), 0.3),
        glossy("stone", (0.06, 0.06, 0.065), 0.2),
        glossy("steel", (0.6, 0.59, 0.57), 0.35, metallic=1.0),
        glossy("kettle", (0.75, 0.7, 0.6), 0.15, metallic=1.0),
        diffuse("strip", WHITE, Light(WARM, 8_000)),
        diffuse("lamp", WHITE, Light(DAYLIGHT, 15_000)),
    ]
    camera = {"eye": [0.9, 1.55, 0.7], "target": [-0.1, 1.1, -2.2], "focal_length_mm": 2.2}
    return Scene([floor, *walls, *things], materials, **camera, exposure_s=0.001)
