"""A scene of the comparison for programs that read no capture: arrays and a description, which any Python can read."""

import json
import math

import numpy as np

from .capture import SENSOR_MM, Panorama
from .gltf import png

# Luminance that is 1 in programs without units.
NIT = 1000.0
MAX_DEPTH = 8


def lens(scene):
    """The distance of the image behind the lens and the diameter of the aperture, mm."""
    f = scene.focal_length_mm
    distance = f if scene.focus_m is None else f * scene.focus_m / (scene.focus_m - f / 1000)
    return distance, f / scene.f_number


def on_axis_sr(scene):
    """Projected solid angle of the aperture as the middle of the sensor sees it, to which electrons are proportional."""
    distance, diameter = lens(scene)
    return math.pi * math.sin(math.atan(diameter / 2 / distance)) ** 2


def described(material, folder):
    """A material as plain data, its textures written as files."""
    textures = {}
    for name in ("colour_texture", "metal_texture"):
        image = getattr(material, name)
        if image is not None:
            (folder / f"{material.name}-{name}.png").write_bytes(png(image))
            textures[name] = f"{material.name}-{name}.png"
    radiance = [value / NIT for value in material.light.radiance()] if material.light else None
    keys = ("kind", "rgb", "roughness", "metallic", "index")
    return {**{key: getattr(material, key) for key in keys}, "radiance": radiance, **textures}


def write(scene, folder, size):
    """Writes scene.json and scene.npz. Balls are triangles; an environment's image is what the capture has."""
    distance, diameter = lens(scene)
    around = scene.environment
    if isinstance(around, Panorama):
        environment = {"image": "environment.hdr", "scale": around.nit_per_unit / NIT}
    else:
        environment = around and {"radiance": [value / NIT for value in around.radiance()]}
    arrays, meshes = {}, []
    for i, mesh in enumerate(scene.meshes):
        parts = {"positions": mesh.positions, "triangles": mesh.triangles, "normals": mesh.normals, "uvs": mesh.uvs}
        present = {name: array for name, array in parts.items() if array is not None}
        arrays.update({f"{i}-{name}": array for name, array in present.items()})
        meshes.append({"material": mesh.material, "arrays": sorted(present)})
    description = {
        "size": size,
        "eye": scene.eye,
        "target": scene.target,
        "field_of_view_deg": math.degrees(2 * math.atan(SENSOR_MM / 2 / distance)),
        "aperture_radius_m": diameter / 2000 if scene.focus_m else 0.0,
        "focus_m": scene.focus_m or 1.0,
        "max_depth": MAX_DEPTH,
        "environment": environment,
        "materials": {material.name: described(material, folder) for material in scene.materials},
        "meshes": meshes,
    }
    np.savez(folder / "scene.npz", **arrays)
    (folder / "scene.json").write_text(json.dumps(description, indent=1), encoding="utf-8")
