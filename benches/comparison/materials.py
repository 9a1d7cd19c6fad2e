"""Materials of the comparison, described once for all programs."""

from dataclasses import dataclass, replace

import numpy as np

# Of linear sRGB (BT.709).
LUMINANCE = np.array([0.2126, 0.7152, 0.0722])


def grey(rgb):
    """The grey of the same luminance."""
    return (round(float(LUMINANCE @ np.array(rgb)), 6),) * 3


@dataclass(frozen=True)
class Light:
    """Light that a surface gives, or what surrounds a scene: a colour of linear sRGB brought to a luminance."""

    rgb: tuple
    luminance_nit: float

    def toml(self):
        return f"{{ linear_rgb = {list(self.rgb)}, luminance_nit = {self.luminance_nit:_} }}"

    def radiance(self):
        """Linear sRGB whose luminance is in nit."""
        rgb = np.array(self.rgb)
        return (rgb * self.luminance_nit / float(LUMINANCE @ rgb)).tolist()

    def grey(self):
        return Light((1.0, 1.0, 1.0), self.luminance_nit)


@dataclass(frozen=True)
class Material:
    """A surface: "diffuse", "dielectric", "conductor" (gold, which is none of glTF's metals), or glTF's "metallic-roughness".

    Roughness is glTF's: microfacets have α = roughness². Textures are arrays of bytes, h × w × 3, sRGB the colour's; that of metal
    has roughness in green and metallic in blue. Surfaces with textures are described by the glTF file alone.
    """

    name: str
    kind: str = "diffuse"
    rgb: tuple = (1.0, 1.0, 1.0)
    roughness: float = 0.0
    metallic: float = 0.0
    index: float = 1.5
    light: Light | None = None
    colour_texture: np.ndarray | None = None
    metal_texture: np.ndarray | None = None

    def grey(self):
        """The same surface without colour. Gold becomes a metal of glTF, which all programs have."""
        grey_texture = self.colour_texture
        if grey_texture is not None:
            linear = (grey_texture / 255.0) ** 2.2 @ LUMINANCE
            grey_texture = np.repeat(np.rint(linear ** (1 / 2.2) * 255.0).astype(np.uint8)[..., None], 3, axis=2)
        metal = {"kind": "metallic-roughness", "metallic": 1.0} if self.kind == "conductor" else {}
        return replace(self, rgb=grey(self.rgb), light=self.light and self.light.grey(), colour_texture=grey_texture, **metal)

    def toml(self):
        """The table of a capture file."""
        if self.colour_texture is not None:
            return ""
        rgb = f"{{ linear_rgb = {list(self.rgb)} }}"
        keys = {
            "diffuse": f"reflectance = {rgb}\n",
            "dielectric": f"index = {self.index}\n",
            "conductor": f'metal = "Au"\nroughness = {self.roughness:.9f}\n',
            "metallic-roughness": f"base_colour = {rgb}\nmetallic = {self.metallic}\nroughness = {self.roughness}\n",
        }[self.kind]
        if self.light:
            keys += f"double_sided = false\nemission = {self.light.toml()}\n"
        return f'[materials.{self.name}]\ntype = "{self.kind}"\n{keys}\n'


def diffuse(name, rgb, light=None):
    """A matt surface, which may be a lamp's."""
    return Material(name, rgb=tuple(rgb), light=light)


def glossy(name, rgb, roughness, metallic=0.0):
    """A surface as glTF describes it: glossy under a coat of index 1.5, or metal."""
    return Material(name, "metallic-roughness", tuple(rgb), roughness, metallic)


def glass(name, index=1.5):
    """Clear glass."""
    return Material(name, "dielectric", index=index)


def gold(name, roughness):
    """Rough gold; its colour is what programs without spectra take."""
    return Material(name, "conductor", (1.0, 0.78, 0.34), roughness)
