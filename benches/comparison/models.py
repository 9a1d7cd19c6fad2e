"""Scenes of the comparison from files of glTF: e, a model in textures that is made here, and k, the stage of this repository."""

import numpy as np

from .capture import Panorama, Scene
from .environment import ROOT
from .gltf import read_gltf
from .materials import Light, Material, diffuse, glossy
from .meshes import lathe, quads

STAGE = ROOT / "scenes" / "depth-of-field" / "depth-of-field.gltf"


def noise(random, size, octaves):
    """Smooth noise of 0 to 1 that repeats at the borders, size × size."""
    total = np.zeros((size, size))
    for octave in range(octaves):
        cells = 4 * 2**octave
        grid = random.random((cells, cells))
        at = np.arange(size) * cells / size
        low = at.astype(int)
        part = at - low
        part = part * part * (3 - 2 * part)
        high = (low + 1) % cells
        rows = grid[low] * (1 - part)[:, None] + grid[high] * part[:, None]
        total += (rows[:, low] * (1 - part) + rows[:, high] * part) / 2**octave
    return (total - total.min()) / (total.max() - total.min())


def paint_over_metal(size=256):
    """Textures of a metal with stripes of paint that has come off here and there: colour (sRGB), roughness and metallic."""
    random = np.random.default_rng(5)
    worn, fine = noise(random, size, 5), noise(random, size, 7)
    stripe = np.floor(np.arange(size) * 9 / size).astype(int) % 3
    colours = np.array([(0.72, 0.15, 0.1), (0.85, 0.8, 0.7), (0.1, 0.25, 0.45)])
    bare = worn > 0.62
    metal = np.array([0.83, 0.72, 0.55])
    colour = np.where(bare[..., None], metal, colours[stripe][:, None, :]) * (0.8 + 0.2 * fine[..., None])
    rough = np.where(bare, 0.25 + 0.2 * fine, 0.35 + 0.3 * fine)
    packed = np.stack([np.zeros_like(rough), rough, bare.astype(float)], axis=-1)
    return [np.rint(np.clip(image, 0, 1) * 255).astype(np.uint8) for image in (colour, packed)]


def sky(height=128):
    """A sky brighter towards the horizon, a sun of eight degrees behind haze, and a dim ground."""
    theta = np.pi * (np.arange(height) + 0.5) / height
    phi = 2 * np.pi * (np.arange(2 * height) + 0.5) / (2 * height) - np.pi
    up = np.cos(theta)[:, None, None] * np.ones((1, 2 * height, 1))
    above = np.array([0.25, 0.45, 0.9]) + np.array([0.5, 0.4, 0.2]) * (1 - np.clip(up, 0, 1)) ** 3
    image = np.where(up > 0, above, np.array([0.16, 0.14, 0.12]))
    sun = (np.radians(55), np.radians(50))
    cosine = np.cos(theta)[:, None] * np.cos(sun[0]) + np.sin(theta)[:, None] * np.sin(sun[0]) * np.cos(phi - sun[1])
    return image + np.array([1.0, 0.9, 0.75]) * 150.0 * np.clip((cosine - np.cos(np.radians(4.5))) / 0.001, 0, 1)[..., None]


def vase():
    """Scene e."""
    height = np.linspace(0, 1, 120)
    radius = 0.16 + 0.17 * np.sin(np.pi * height**0.8) ** 2 - 0.06 * height + 0.12 * height**12
    outside = lathe("vase", np.concatenate([[0.0], radius]), np.concatenate([[0.0], 0.002 + 0.9 * height]), 160)
    colour, metal = paint_over_metal()
    materials = [
        Material("vase", "metallic-roughness", colour_texture=colour, metal_texture=metal),
        diffuse("table", (0.42, 0.4, 0.38)),
    ]
    camera = {"eye": [0.0, 0.85, 1.7], "target": [0.0, 0.42, 0.0], "focal_length_mm": 2.9}
    table = quads("table", ((-1.2, 0, 1.2), (2.4, 0, 0), (0, 0, -2.4)))
    return Scene([table, outside], materials, **camera, environment=Panorama(sky(), 3_000), exposure_s=0.00006)


def stated(material):
    """A material of the stage, as its file has it."""
    surface = material["pbrMetallicRoughness"]
    colour = surface["baseColorFactor"][:3]
    if "emissiveFactor" not in material:
        return glossy(material["name"], colour, surface["roughnessFactor"], surface["metallicFactor"])
    # Strengths are luminances of white.
    strength = material["extensions"]["KHR_materials_emissive_strength"]["emissiveStrength"]
    rgb = material["emissiveFactor"]
    return diffuse(material["name"], colour, Light(tuple(rgb), round(strength * float(np.dot(rgb, (0.2126, 0.7152, 0.0722))))))


def depth_of_field():
    """Scene k: the view of its capture, 21 degrees wide, and as large an aperture, 8.9 mm, without blades."""
    meshes, materials = read_gltf(STAGE)
    # The lamps' normals are smooth, by which Mitsuba tells front from back.
    lamps = {material["name"] for material in materials if "emissiveFactor" in material}
    for mesh in meshes:
        if mesh.material in lamps:
            mesh.normals = None
    focal_length = 12.5 * 2.56 / 4.8
    return Scene(
        meshes,
        [stated(material) for material in materials],
        eye=[0.0, 0.045, 0.0],
        target=[0.0, 0.018, -0.3],
        focal_length_mm=round(focal_length, 4),
        environment=Light((1.0, 1.0, 1.0), 4),
        f_number=round(focal_length / (12.5 / 1.4), 4),
        focus_m=0.3,
        exposure_s=0.0005,
    )
