#!/usr/bin/env python3
"""Renders the images of docs/gallery.md, each from its capture in scenes/gallery.

    docs/gallery.py                    all, in their full size, to docs/gallery: some hours on two cores
    docs/gallery.py gem street         the named ones
    docs/gallery.py --check            all at 64 × 40 pixels, and compares them with the ones that are there: a minute

The program is the `photosite` on the PATH. Needs docs/requirements-run.txt.
"""

from __future__ import annotations

import argparse
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw, ImageFont

ROOT = Path(__file__).resolve().parent.parent
SCENES = ROOT / "scenes/gallery"
PICTURES = ROOT / "docs/gallery"
FONT = ROOT / "crates/photosite-measure/assets/fonts/DejaVuSans-plots.ttf"
SMALL = (64, 40)
# Mean difference of 8-bit codes between an image and its small render, in blocks of an eighth of their width, past which the
# capture has changed. Measured with three seeds: 1.1 (still-life) to 8.1 (meadow, whose leaves are finer than the small pixels),
# and at most 0.7 between seeds. A third of a stop makes it 7 to 24, a mirrored image 13 to 59: whoever changes a capture so little
# that the check passes need not render its image again.
SAME = 9.0
SENSORS = ["generic-cmos-color", "sony-imx249-color", "sony-imx363-color", "automotive-hdr-color", "generic-stacked-color", "generic-three-chip-ccd",
           "sony-imx249-mono", "sony-imx250-mono", "andor-zyla-55", "onsemi-kai-02170-mono", "textbook-ccd", "swissspad2"]
ISOS = [100, 200, 400, 800, 1600, 3200, 6400, 12800, 25600]
# The part of the still life that the image of speeds shows, in pixels, and their pitch.
ISO_TILE, ISO_PITCH_UM = (426, 266), 3
# Exposure time of the still life at ISO 1, s.
ISO_TIME_S = 20.0
# One-bit frames, and the time that they take together.
COUNTS = [1, 4, 32, 255]


class Maker:
    """Renders in a folder, in full size or small."""

    def __init__(self, folder: Path, small: bool):
        self.folder, self.small = folder, small
        self.rendered: "dict[tuple, Path]" = {}
        self.size = SMALL if small else (1280, 800)
        # Height of a line of text.
        self.line = 1 if small else 26

    def photosite(self, *words: object) -> None:
        done = subprocess.run(["photosite", *map(str, words)], stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
        if done.returncode:
            raise SystemExit(f"photosite {' '.join(map(str, words))}\n{done.stderr}")

    def render(self, capture: str, size: "tuple[int, int]", *sets: str) -> Path:
        scene = SCENES / capture
        if (capture, size, sets) not in self.rendered:
            out = self.rendered[capture, size, sets] = self.folder / f"render-{len(self.rendered)}"
            subprocess.run([sys.executable, scene.parent / "make.py"], check=True)
            changes = [word for key in sets for word in ("--set", key)]
            if size != (1280, 800):
                changes += ["--size", f"{size[0]}x{size[1]}"]
            self.photosite("render", scene, "--quiet", "-o", out, *changes)
        return self.rendered[capture, size, sets]

    def expose(self, light: Path, name: str, *sets: str) -> Image.Image:
        out = self.folder / name
        self.photosite("expose", light, "--quiet", "-o", out, *(word for key in sets for word in ("--set", key)))
        return Image.open(out / "image.png").convert("RGB")

    def tiled(self, tiles: "list[tuple[str, Image.Image]]", columns: int) -> Image.Image:
        """Images side by side, each with a line below."""
        width, height = tiles[0][1].size
        line = self.line
        rows = -(-len(tiles) // columns)
        whole = Image.new("RGB", (columns * width, rows * (height + line)), "white")
        for i, (label, tile) in enumerate(tiles):
            x, y = i % columns * width, i // columns * (height + line)
            whole.paste(tile, (x, y))
            if not self.small:
                font = ImageFont.truetype(str(FONT), 15)
                ImageDraw.Draw(whole).text((x + width / 2, y + height + line / 2), label, "black", font, "mm")
        return whole


def strips(maker: Maker, pictures: "list[tuple[str, Image.Image]]") -> Image.Image:
    """One image of upright strips, each from another one."""
    width, height = pictures[0][1].size
    edges = [round(i * width / len(pictures)) for i in range(len(pictures) + 1)]
    line = maker.line
    whole = Image.new("RGB", (width, height + line), "white")
    for (label, picture), a, b in zip(pictures, edges, edges[1:]):
        whole.paste(picture.crop((a, 0, b, height)), (a, 0))
        if not maker.small:
            ImageDraw.Draw(whole).text(((a + b) / 2, height + line / 2), label, "black", ImageFont.truetype(str(FONT), 15), "mm")
    return whole


def plain(capture: str):
    """What a capture makes, as it is."""
    def make(maker: Maker) -> Image.Image:
        return Image.open(maker.render(capture, maker.size) / "image.png").convert("RGB")
    return make


def twelve_sensors(maker: Maker) -> Image.Image:
    tile = (16, 10) if maker.small else (320, 200)
    light = maker.render("still-life/capture.toml", tile, "output.irradiance={ bands_nm = [380, 1000, 20] }")
    tiles = []
    for name in SENSORS:
        shot = maker.expose(light / "irradiance.exr", f"sensor-{name}", f"sensor.preset={name}", "exposure.auto_mean=0.2", "exposure.max_time_s=0.03", "exposure.max_gain_db=40")
        # Pixels that are wider than high make a wider image.
        tiles.append((name, shot.resize(tile)))
    return maker.tiled(tiles, 4)


def iso(maker: Maker) -> Image.Image:
    tile = (16, 10) if maker.small else ISO_TILE
    # The bowl of fruit, through a third of the focal length onto pixels of a third of the width, as small cameras have them.
    light = maker.render("still-life/capture.toml", tile, f"sensor.resolution_px={list(ISO_TILE)}", f"sensor.pixel_pitch_um=[{ISO_PITCH_UM}, {ISO_PITCH_UM}]",
                         "lens.focal_length_mm=5.4", "camera.look_at_m=[0.11, 0.135, 0]", "render.samples_per_pixel=256")
    # A full well that makes ISO 100 the speed without gain: so many electrons in each µm², which in small renders are wider pixels.
    full_well_e = 2000 * (ISO_PITCH_UM * ISO_TILE[0] / tile[0]) ** 2
    sensor = [f"sensor.charge.full_well_e={full_well_e:.0f}", "sensor.adc.bits=14", f"sensor.adc.conversion_gain_dn_per_e={15_000 / full_well_e:.9f}"]
    tiles = []
    for speed in ISOS:
        # The same light, for so much less time.
        tiles.append((f"ISO {speed}", maker.expose(light, f"iso-{speed}", *sensor, f"exposure.iso={speed}", f"exposure.time_s={ISO_TIME_S / speed:.9f}")))
    return maker.tiled(tiles, 3)


def counted(maker: Maker) -> Image.Image:
    # Counts are no linear function of light: much wider pixels would show another mean.
    size = (320, 200) if maker.small else maker.size
    light = maker.render("street/spad.toml", size)
    # Wider pixels catch more photons.
    time_s = 0.012 * (size[0] / 1280) ** 2
    tiles = []
    for frames in COUNTS:
        label = "one frame" if frames == 1 else f"{frames} frames"
        tiles.append((label, maker.expose(light, f"counted-{frames}", f"sensor.spad.one_bit_frames={frames}", f"sensor.charge.full_well_e={frames}", f"exposure.time_s={time_s * frames / 255}")))
    return strips(maker, tiles)


GALLERY = {
    "room-by-day": plain("room/day.toml"),
    "room-by-sodium": plain("room/sodium.toml"),
    "gem": plain("gem/capture.toml"),
    "caustics": plain("caustics/capture.toml"),
    "lights": plain("lights/capture.toml"),
    "propeller": plain("propeller/capture.toml"),
    "meadow": plain("trees/colour.toml"),
    "meadow-in-infrared": plain("trees/infrared.toml"),
    "still-life": plain("still-life/capture.toml"),
    "twelve-sensors": twelve_sensors,
    "iso": iso,
    "rig": plain("rig/capture.toml"),
    "street": plain("street/colour.toml"),
    "street-counted": counted,
}


def blocks(picture: Image.Image, gamma: float) -> np.ndarray:
    """Means of 8 × 5 blocks, of light rather than codes, as the wide pixels of a small render have them; as codes again."""
    light = (np.asarray(picture.resize((640, 400), Image.Resampling.BOX), float) / 255) ** gamma
    return 255 * light.reshape(5, 80, 8, 80, 3).mean((1, 3)) ** (1 / gamma)


def difference(picture: Image.Image, kept: Path) -> float:
    """Mean difference of 8-bit codes between the blocks of a small image and of the one that is kept."""
    # Black and white dots have a mean of codes alone: that of a power of them depends on how fine the dots are.
    gamma = 1.0 if kept.stem == "street-counted" else 2.2
    return float(np.abs(blocks(picture, gamma) - blocks(Image.open(kept).convert("RGB"), gamma)).mean())


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("names", nargs="*", metavar="NAME", help=", ".join(GALLERY))
    parser.add_argument("--check", action="store_true", help="render small, compare, write nothing")
    options = parser.parse_args()
    unknown = [name for name in options.names if name not in GALLERY]
    if unknown:
        parser.error(f"there is no image {unknown[0]!r}; there are {', '.join(GALLERY)}")
    failed = 0
    with tempfile.TemporaryDirectory() as folder:
        maker = Maker(Path(folder), options.check)
        for name in options.names or GALLERY:
            begun = time.monotonic()
            picture = GALLERY[name](maker)
            kept = PICTURES / f"{name}.jpg"
            if options.check:
                found = difference(picture, kept)
                what = f"{'as before' if found <= SAME else 'not what its capture makes'}, mean difference {found:.1f}"
                failed += found > SAME
            else:
                PICTURES.mkdir(exist_ok=True)
                quality = 92
                while True:
                    picture.save(kept, quality=quality, optimize=True, progressive=True)
                    if kept.stat().st_size <= 250_000:
                        break
                    quality -= 4
                what = "written"
            print(f"{name}: {what}, {time.monotonic() - begun:.1f} s", flush=True)
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
