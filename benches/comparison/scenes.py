"""The scenes of the comparison.

| | |
|---|---|
| a | Mitsuba's own Cornell box (`mitsuba.cornell_box()`): diffuse walls, two boxes, a small lamp |
| b | the same room with a glass sphere (index 1.5, radius 0.35) and a rough gold one (GGX, α = 0.1, radius 0.5): caustics |
| c | a displaced sphere of 1.31 million flat triangles on a grey floor, under a constant sky and an area light |
| d | a hall of 40 m with columns under 100 000 small lamps, their luminances over two decades |
| e | a vase of painted and of bare metal, all in textures of glTF, under an image of a sky with a sun |
| f | a room lit by the sky through one window, which the camera does not see |
| g | a room lit by what a door that stands ajar lets in |
| h | a room whose only lamp is behind a screen and shines at the wall |
| i | a lamp inside a globe of glass on a table |
| j | a kitchen of glossy tiles, lacquer and steel |
| k | the stage of scenes/depth-of-field through a lens of a large aperture |

f to j are in indoor.py, e and k in models.py. All but k are seen through a pinhole without falloff, which Mitsuba's cameras do
not have.
"""

import numpy as np

from . import indoor, models
from .capture import Scene
from .materials import Light, diffuse, glass, gold
from .meshes import Mesh, box, quads, sphere

WHITE, GREEN, RED = (0.885809, 0.698859, 0.666422), (0.105421, 0.37798, 0.076425), (0.570068, 0.0430135, 0.0443706)
LAMP = Light((18.387, 13.9873, 6.75357), 10_000)


def room():
    """The Cornell box of 2 m without what stands in it."""
    return [
        quads("white", ((-1, -1, 1), (2, 0, 0), (0, 0, -2)), ((-1, 1, -1), (2, 0, 0), (0, 0, 2)), ((-1, -1, -1), (2, 0, 0), (0, 2, 0))),
        quads("green", ((1, -1, -1), (0, 0, 2), (0, 2, 0))),
        quads("red", ((-1, -1, 1), (0, 0, -2), (0, 2, 0))),
        quads("lamp", ((-0.23, 0.99, -0.18), (0.46, 0, 0), (0, 0, 0.38))),
    ]


ROOM_MATERIALS = [diffuse("white", WHITE), diffuse("green", GREEN), diffuse("red", RED), diffuse("lamp", WHITE, LAMP)]
# Half of 256 pixels of 10 µm over the tangent of half of 39.3077°.
ROOM_CAMERA = {"eye": [0.0, 0.0, 3.9], "target": [0.0, 0.0, 0.0], "focal_length_mm": 3.58395}


def cornell_box():
    """Scene a."""
    blocks = [
        box("white", (0.335, -0.7, 0.38), (0.286891, 0, 0.0877115), (0, 0.3, 0), (-0.0877115, 0, 0.286891)),
        box("white", (-0.33, -0.4, -0.28), (0.28491, 0, -0.0939491), (0, 0.61, 0), (0.0939491, 0, 0.28491)),
    ]
    return Scene(room() + blocks, ROOM_MATERIALS, **ROOM_CAMERA)


def glass_and_gold():
    """Scene b."""
    balls = [
        sphere("glass", 64, 128, smooth=True).moved((0.45, -0.65, 0.35), 0.35),
        sphere("gold", 64, 128, smooth=True).moved((-0.4, -0.5, -0.3), 0.5),
    ]
    return Scene(room() + balls, [*ROOM_MATERIALS, glass("glass"), gold("gold", 0.1**0.5)], **ROOM_CAMERA)


def bumpy(direction):
    """Radius of the displaced sphere."""
    return 1.0 + 0.03 * np.prod(np.sin(40.0 * direction), axis=-1)


def displaced_sphere(bands=640, sectors=1025):
    """Scene c."""
    meshes = [
        sphere("sphere", bands, sectors, bumpy).moved((0, 1, 0)),
        quads("floor", ((-10, 0, 10), (20, 0, 0), (0, 0, -20))),
        quads("lamp", ((1.0, 4.0, 0.5), (1, 0, 0), (0, 0, 1))),
    ]
    materials = [diffuse("sphere", (0.7, 0.5, 0.3)), diffuse("floor", (0.5, 0.5, 0.5))]
    materials += [diffuse("lamp", (0.5, 0.5, 0.5), Light((1, 1, 1), 10_000))]
    camera = {"eye": [0.0, 1.8, 3.9], "target": [0.0, 0.9, 0.0], "focal_length_mm": 3.58395}
    return Scene(meshes, materials, **camera, environment=Light((0.4, 0.5, 0.7), 500))


def lamps(count=100_000, levels=16):
    """Scene d. Lamps are triangles of a centimetre under the ceiling that shine down."""
    random = np.random.default_rng(8)
    corners = random.uniform((-20, 3, -20), (20, 5, 20), (count, 3))
    angle = random.uniform(0, 2 * np.pi, count)

    def edge(angle):
        return 0.012 * np.stack([np.cos(angle), np.zeros(count), np.sin(angle)], axis=-1)

    # Clockwise seen from above.
    positions = np.stack([corners, corners + edge(angle), corners + edge(angle + 2.0)], axis=1)
    meshes, materials = [], [diffuse("hall", (0.5, 0.5, 0.5))]
    for level in range(levels):
        own = positions[level::levels].reshape(-1, 3)
        meshes.append(Mesh(f"lamp-{level}", own, np.arange(len(own)).reshape(-1, 3)))
        materials.append(diffuse(f"lamp-{level}", (0.5, 0.5, 0.5), Light((1, 1, 1), round(1e5 * 100 ** (level / levels)))))
    columns = [box("hall", (x, 2.5, z), (0.3, 0, 0), (0, 2.5, 0), (0, 0, 0.3)) for x in range(-16, 17, 8) for z in range(-16, 17, 8)]
    walls = box("hall", (0, 2.5, 0), (20, 0, 0), (0, 2.6, 0), (0, 0, 20))
    camera = {"eye": [-18.0, 1.7, 13.0], "target": [0.0, 1.0, 0.0], "focal_length_mm": 1.8}
    return Scene([walls, *columns, *meshes], materials, **camera)


SCENES = {
    "a": ("Cornell box", cornell_box),
    "b": ("glass and gold", glass_and_gold),
    "c": ("1.31 M triangles", displaced_sphere),
    "d": ("100 000 lamps", lamps),
    "e": ("textured model", models.vase),
    "f": ("window", indoor.window),
    "g": ("door ajar", indoor.door_ajar),
    "h": ("lamp behind a screen", indoor.screen),
    "i": ("glass lamp", indoor.glass_lamp),
    "j": ("kitchen", indoor.kitchen),
    "k": ("depth of field", models.depth_of_field),
}
# Those with caustics, which references of photosite find from their lamps.
FOCUSED = "bi"
