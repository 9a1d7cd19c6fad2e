"""The scenes of the comparison, written into a folder: a capture file and its geometry.

| | |
|---|---|
| a | Mitsuba's own Cornell box (`mitsuba.cornell_box()`): diffuse walls, two boxes, a small lamp |
| b | the same room with a glass sphere (index 1.5, radius 0.35) and a rough gold one (GGX, α = 0.1, radius 0.5): caustics |
| c | a displaced sphere of 1.31 million flat triangles on a grey floor, under a constant sky and an area light |
| d | a hall of 40 m with columns under 100 000 small lamps, their luminances over two decades |

All are seen through a pinhole without falloff, which Mitsuba's cameras do not have.
"""

import numpy as np

from .meshes import Mesh, box, quads, sphere, write_glb

CAPTURE = """\
[scene]
geometry = ["scene.glb"]
{environment}
{spheres}{materials}
[camera]
position_m = {eye}
look_at_m = {target}

[lens]
type = "pinhole"
focal_length_mm = {focal_length_mm}
f_number = 2.0
focus_distance_m = "infinity"
falloff = "none"

[sensor]
preset = "generic-cmos-color"
resolution_px = [256, 256]
pixel_pitch_um = [10.0, 10.0]

[exposure]
time_s = 0.002

[render]
samples_per_pixel = 64
max_depth = 8
roulette_depth = 5
"""

WHITE, GREEN, RED = (0.885809, 0.698859, 0.666422), (0.105421, 0.37798, 0.076425), (0.570068, 0.0430135, 0.0443706)
LAMP = 'emission = { linear_rgb = [18.387, 13.9873, 6.75357], luminance_nit = 10_000 }'


def diffuse(name, rgb, emission=""):
    """A material of a linear sRGB reflectance."""
    more = f"double_sided = false\n{emission}\n" if emission else ""
    return f'[materials.{name}]\ntype = "diffuse"\nreflectance = {{ linear_rgb = {list(rgb)} }}\n{more}\n'


def room():
    """The Cornell box of 2 m without what stands in it."""
    return [
        quads("white", ((-1, -1, 1), (2, 0, 0), (0, 0, -2)), ((-1, 1, -1), (2, 0, 0), (0, 0, 2)), ((-1, -1, -1), (2, 0, 0), (0, 2, 0))),
        quads("green", ((1, -1, -1), (0, 0, 2), (0, 2, 0))),
        quads("red", ((-1, -1, 1), (0, 0, -2), (0, 2, 0))),
        quads("lamp", ((-0.23, 0.99, -0.18), (0.46, 0, 0), (0, 0, 0.38))),
    ]


ROOM_MATERIALS = diffuse("white", WHITE) + diffuse("green", GREEN) + diffuse("red", RED) + diffuse("lamp", WHITE, LAMP)
# Half of 256 pixels of 10 µm over the tangent of half of 39.3077°.
ROOM_CAMERA = {"eye": [0.0, 0.0, 3.9], "target": [0.0, 0.0, 0.0], "focal_length_mm": 3.58395}


def cornell_box():
    """Scene a."""
    blocks = [
        box("white", (0.335, -0.7, 0.38), (0.286891, 0, 0.0877115), (0, 0.3, 0), (-0.0877115, 0, 0.286891)),
        box("white", (-0.33, -0.4, -0.28), (0.28491, 0, -0.0939491), (0, 0.61, 0), (0.0939491, 0, 0.28491)),
    ]
    return room() + blocks, {"environment": "", "materials": ROOM_MATERIALS, **ROOM_CAMERA}


def glass_and_gold():
    """Scene b."""
    balls = [
        sphere("glass", 64, 128, smooth=True).moved((0.45, -0.65, 0.35), 0.35),
        sphere("gold", 64, 128, smooth=True).moved((-0.4, -0.5, -0.3), 0.5),
    ]
    materials = ROOM_MATERIALS + '[materials.glass]\ntype = "dielectric"\nindex = 1.5\n\n'
    materials += f'[materials.gold]\ntype = "conductor"\nmetal = "Au"\nroughness = {0.1**0.5:.9f}\n'
    return room() + balls, {"environment": "", "materials": materials, **ROOM_CAMERA}


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
    materials = diffuse("sphere", (0.7, 0.5, 0.3)) + diffuse("floor", (0.5, 0.5, 0.5))
    materials += diffuse("lamp", (0.5, 0.5, 0.5), "emission = { linear_rgb = [1, 1, 1], luminance_nit = 10_000 }")
    camera = {"eye": [0.0, 1.8, 3.9], "target": [0.0, 0.9, 0.0], "focal_length_mm": 3.58395}
    return meshes, {"environment": "environment = { linear_rgb = [0.4, 0.5, 0.7], luminance_nit = 500 }\n", "materials": materials, **camera}


def lamps(count=100_000, levels=16):
    """Scene d. Lamps are triangles of a centimetre under the ceiling that shine down."""
    random = np.random.default_rng(8)
    corners = random.uniform((-20, 3, -20), (20, 5, 20), (count, 3))
    angle = random.uniform(0, 2 * np.pi, count)

    def edge(angle):
        return 0.012 * np.stack([np.cos(angle), np.zeros(count), np.sin(angle)], axis=-1)

    # Clockwise seen from above.
    positions = np.stack([corners, corners + edge(angle), corners + edge(angle + 2.0)], axis=1)
    meshes, materials = [], diffuse("hall", (0.5, 0.5, 0.5))
    for level in range(levels):
        own = positions[level::levels].reshape(-1, 3)
        meshes.append(Mesh(f"lamp-{level}", own, np.arange(len(own)).reshape(-1, 3)))
        luminance = 1e5 * 100 ** (level / levels)
        materials += diffuse(f"lamp-{level}", (0.5, 0.5, 0.5), f"emission = {{ linear_rgb = [1, 1, 1], luminance_nit = {luminance:.0f} }}")
    columns = [box("hall", (x, 2.5, z), (0.3, 0, 0), (0, 2.5, 0), (0, 0, 0.3)) for x in range(-16, 17, 8) for z in range(-16, 17, 8)]
    walls = box("hall", (0, 2.5, 0), (20, 0, 0), (0, 2.6, 0), (0, 0, 20))
    camera = {"eye": [-18.0, 1.7, 13.0], "target": [0.0, 1.0, 0.0], "focal_length_mm": 1.8}
    return [walls, *columns, *meshes], {"environment": "", "materials": materials, **camera}


SCENES = {
    "a": ("Cornell box", cornell_box),
    "b": ("glass and gold", glass_and_gold),
    "c": ("1.31 M triangles", displaced_sphere),
    "d": ("100 000 lamps", lamps),
}


SPHERE = """\
[[scene.spheres]]
material = "{material}"
position_m = {centre}
radius_m = {radius}

"""


def write(key, folder, of_triangles=False):
    """Writes a scene, its balls true spheres unless all is to be `of_triangles`, and returns its capture file."""
    meshes, values = SCENES[key][1]()
    balls = [] if of_triangles else [mesh for mesh in meshes if mesh.ball]
    folder.mkdir(parents=True, exist_ok=True)
    write_glb(folder / "scene.glb", [mesh for mesh in meshes if mesh not in balls])
    spheres = "".join(SPHERE.format(material=ball.material, centre=list(ball.ball[0]), radius=ball.ball[1]) for ball in balls)
    capture = folder / "capture.toml"
    capture.write_text(CAPTURE.format(spheres=spheres, **values), encoding="utf-8")
    return capture
