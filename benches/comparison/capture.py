"""A scene of the comparison as a file: the capture of photosite, from which it exports Mitsuba's scene."""

from dataclasses import dataclass

import numpy as np

from .gltf import Glb
from .materials import LUMINANCE, Light

CAPTURE = """\
[scene]
geometry = ["scene.glb"]
{environment}
{spheres}{materials}
[camera]
position_m = {eye}
look_at_m = {target}

[lens]
type = "{lens}"
focal_length_mm = {focal_length_mm}
f_number = {f_number}
focus_distance_m = {focus}
falloff = "none"

[sensor]
preset = "generic-cmos-color"
resolution_px = [{size}, {size}]
pixel_pitch_um = [{pitch}, {pitch}]

[exposure]
time_s = {exposure_s}

[render]
samples_per_pixel = 64
max_depth = 8
roulette_depth = 5
"""

SPHERE = """\
[[scene.spheres]]
material = "{material}"
position_m = {centre}
radius_m = {radius}

"""

SENSOR_MM = 2.56


@dataclass
class Panorama:
    """An equirectangular image of what surrounds a scene, h × w × 3 in linear sRGB; the luminance of a white of 1."""

    image: np.ndarray
    nit_per_unit: float

    def toml(self):
        return f'{{ image = "environment.hdr", nit_per_unit = {self.nit_per_unit:_} }}'

    def write(self, path):
        """Writes the image as Radiance HDR, whose values it has from now on, too."""
        peak = np.maximum(self.image.max(axis=-1, keepdims=True), 1e-30)
        exponent = np.ceil(np.log2(peak * 256.0 / 255.0))
        mantissa = np.clip(np.rint(self.image * 256.0 / 2.0**exponent), 0, 255)
        height, width, _ = self.image.shape
        pixels = np.concatenate([mantissa, exponent + 128], axis=-1).astype(np.uint8)
        path.write_bytes(f"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y {height} +X {width}\n".encode() + pixels.tobytes())


@dataclass
class Scene:
    """Shapes, surfaces, surroundings and a camera of 2.56 mm × 2.56 mm; a pinhole unless there is a `focus_m`."""

    meshes: list
    materials: list
    eye: list
    target: list
    focal_length_mm: float
    environment: Light | Panorama | None = None
    f_number: float = 2.0
    focus_m: float | None = None
    exposure_s: float = 0.002

    def grey(self):
        """The scene without colours, so that programs with spectra and without make the same image."""
        around = self.environment
        if isinstance(around, Panorama):
            around = Panorama(np.repeat((around.image @ LUMINANCE)[..., None], 3, axis=2), around.nit_per_unit)
        elif around:
            around = around.grey()
        return Scene(**{**vars(self), "materials": [m.grey() for m in self.materials], "environment": around})

    def write(self, folder, of_triangles=False, size=256):
        """Writes the scene, its balls true spheres unless all is to be `of_triangles`, and returns its capture file."""
        balls = [] if of_triangles else [mesh for mesh in self.meshes if mesh.ball]
        folder.mkdir(parents=True, exist_ok=True)
        Glb().write(folder / "scene.glb", [mesh for mesh in self.meshes if mesh not in balls], self.materials)
        if isinstance(self.environment, Panorama):
            self.environment.write(folder / "environment.hdr")
        capture = folder / "capture.toml"
        text = CAPTURE.format(
            environment=f"environment = {self.environment.toml()}\n" if self.environment else "",
            spheres="".join(SPHERE.format(material=b.material, centre=[float(x) for x in b.ball[0]], radius=b.ball[1]) for b in balls),
            materials="".join(material.toml() for material in self.materials),
            eye=self.eye,
            target=self.target,
            lens="thin" if self.focus_m else "pinhole",
            focal_length_mm=self.focal_length_mm,
            f_number=self.f_number,
            focus=self.focus_m or '"infinity"',
            exposure_s=self.exposure_s,
            size=size,
            pitch=SENSOR_MM * 1000 / size,
        )
        capture.write_text(text, encoding="utf-8")
        return capture
