#!/usr/bin/env python3
"""Writes README.md of this folder: every scene in photosite and in Mitsuba, side by side, with figures.

    page.py             renders all scenes
    page.py NAME...     renders these, and takes over the figures and images of the others

Renders the captures with photosite, compares with the stored references, and puts one image for each scene into
pictures/: photosite's, Mitsuba's, and the map of z-scores from −4 (blue) to 4 (red). Needs what references.py needs.
"""

import json
import math
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

# Beside the exporter, which writes it into the folder of each scene.
sys.path.append(str(Path(__file__).resolve().parents[2] / "crates/photosite-mitsuba/assets"))
from references import HERE, PHOTOSITE, SCENES, names
from render import load_mitsuba

HEAD = """# photosite against Mitsuba 3

Every scene of this suite is rendered by photosite and by [Mitsuba 3](https://mitsuba-renderer.org), which nobody here
wrote, in the responses of the same sensor: mean electrons in every channel of every pixel, each with the variance of the
mean. Where both mean the same, the z-scores

    z = (ours − Mitsuba's) / √(sum of the variances)

follow the normal distribution N(0, 1): mean 0, spread 1, and no pixel beyond the bound that one of so many normal numbers
exceeds with a probability of 1 % (Šidák). `cargo test --release --test mitsuba` holds every scene to that against the
stored references, with channel means within 0.5 %, spreads within 4.5 standard errors of 1, and blocks of a twelfth of the
image within 0.5 % and 4.5 standard errors, so that two thirds of them at least show a fault of 5 %. `references.py
--check` renders references afresh, so that a stored one cannot go stale. Scenes marked *by hand* were written for Mitsuba
from the capture's meaning, the others by `photosite export-mitsuba`.

`branches` lists what a capture can have, one by one, from the types that hold it: each is in a scene of this suite, or the
exporter says by name that Mitsuba has no counterpart.

A suite that lets a wrong renderer pass proves nothing: unit tests of `src/sabotage.rs` make one thing wrong at a time (the
cosine missing, the density of a light sample without the choice of the light, one density for all wavelengths, twice the
aperture's radius) and demand that a scene of this suite sees it.

Mitsuba's microfacets are not shadowed as ours are, and it has no glTF material; `microfacets.py` describes ours to it from
the published equations. Its glass has one index, so dispersion is rendered at one wavelength at a time, each with the
index there. Between the texels of an environment image we mix RGB and it mixes spectra, so that it gets the image in
finer steps. Where one of the two had to be wrong, a third source tells: the spectra that Mitsuba makes of the colours of a
blue sky miss them by up to 0.13 % (integrated under D65 with CIE 1931), ours by up to 0.2 % of white, which shows where a
sky is seen directly and with little noise.

COVERAGE
In each image: photosite, Mitsuba, z of the green or only channel from −4 (blue) to 4 (red).

"""


# What the suite is to cover, and the scenes that do.
COVERAGE = [
    ("the Cornell box, diffuse, measured spectra, area light", ["cornell-box"]),
    ("a thin lens at f/1.4, far out of focus in front and behind", ["thin-lens"]),
    ("point, spot and directional lights with spectra", ["lights-without-surface"]),
    ("constant and HDR-picture environment", ["environment-constant", "environment-picture", "picture-of-lux"]),
    ("a sky with and without its sun, and its ground", ["sky-with-sun", "sky-without-sun"]),
    ("mixes of paints, with rough gold and ground glass", ["mixes", "mixes-rough"]),
    ("panes", ["panes"]),
    ("smooth and rough conductors, Au, Ag, Cu, Al, isotropic and anisotropic",
     ["conductors-smooth", "conductors-rough", "conductor-anisotropic"]),
    ("smooth and rough dielectrics, nested, total internal reflection",
     ["dielectrics-smooth", "dielectrics-rough", "dielectrics-nested", "total-reflection"]),
    ("dispersion, wavelength by wavelength", ["dispersion"]),
    ("sRGB textures, wrap modes, texture transforms, saturated colours", ["textures", "texture-transform"]),
    ("normal map, smooth shading normals", ["normal-map", "conductors-smooth"]),
    ("normal maps on mirrored UVs, from behind, in mirrored nodes", ["normal-map-sides", "mirrored"]),
    ("holes, cut and half open, of either UVs, before lights without a surface too", ["alpha", "holes-and-lamps", "mirrored"]),
    ("a million triangles with instances", ["instances"]),
    ("many small lights, one far brighter", ["many-lights"]),
    ("near infrared: silicon, lamp A, a leaf and a dye", ["near-infrared"]),
    ("metallic-roughness", ["metallic-roughness", "texture-transform"]),
    ("true spheres, seen from outside and inside", ["spheres"]),
    ("true disks and cylinders, seen from outside and inside", ["quadrics"]),
    ("spheres, disks and cylinders that shine", ["round-lamps"]),
]


def coverage():
    """The same as a table; every scene must be in it."""
    missing = set(names()) - {name for _, scenes in COVERAGE for name in scenes}
    if missing:
        sys.exit(f"COVERAGE lacks {', '.join(sorted(missing))}")
    rows = []
    for n, (what, scenes) in enumerate(COVERAGE, 1):
        rows.append(f"| {n} | {what} | " + ", ".join(f"[{name}](#{name})" for name in scenes) + " |")
    rows.append(f"| {len(rows) + 1} | cos⁴: irradiance behind a round hole | [below](#cos4) |")
    return "| | what | scenes |\n|---|---|---|\n" + "\n".join(rows) + "\n"


def cos4():
    """What irradiance.py measured, as a table beside the closed form."""
    stored = json.loads((HERE / "irradiance.json").read_text(encoding="utf-8"))
    entries = {(e["way"], e["f_number"], e["angle_deg"]): e for e in stored["measured"]}
    angles = sorted({angle for _, _, angle in entries})
    rows = []
    for way, f_number in sorted({(way, f_number) for way, f_number, _ in entries}):
        cells = []
        for angle in angles:
            entry = entries[way, f_number, angle]
            # P. D. Foote's formula for a disk, Bull. Bur. Standards 12, 583 (1915).
            t2, a2 = (0.5 / f_number) ** 2, math.tan(math.radians(angle)) ** 2
            exact = math.pi / 2 * (1 - (1 + a2 - t2) / math.sqrt((1 + a2 + t2) ** 2 - 4 * a2 * t2))
            off, error = (100 * x / exact for x in (entry["irradiance"] - exact, entry["standard_error"]))
            cells.append(f"{off:+.2f} ± {error:.2f}")
        rows.append(f"| {way} | f/{f_number:g} | " + " | ".join(cells) + " |")
    head = "| way | stop | " + " | ".join(f"{angle}°" for angle in angles) + " |\n" + "|---" * (len(angles) + 2) + "|\n"
    return f"""## cos4

What Mitsuba's irradiance meters measure behind a round hole under a uniform sky (way *hole*), and by a lamp of the hole's
size over a white floor (way *lamp*), from f/1.4 to f/16 and up to 40° off the axis (`irradiance.py`): differences from the
closed form in percent, with standard errors. Those of one way share their random numbers and go together. `cargo test
--release --test mitsuba` demands that our lens be within 0.5 % of each.

""" + head + "\n".join(rows) + "\n"


def section(name):
    """A scene with its image."""
    folder = SCENES / name
    about = (folder / "capture.toml").read_text(encoding="utf-8").splitlines()[0].removeprefix("# ")
    own = folder / "mitsuba.py"
    hand = " *By hand.*" if own.exists() and "by_hand" in own.read_text(encoding="utf-8") else ""
    return f"## {name}\n\n{about}{hand}\n\n![{name}](pictures/{name}.png)\n"


def developed(picture, white):
    """8-bit RGB of electrons, each channel on its own scale."""
    return np.uint8(255 * np.clip(picture / white, 0, 1) ** (1 / 2.2) + 0.5)


def main():
    mitsuba = load_mitsuba()

    def read(path):
        bitmap = mitsuba.Bitmap(str(path))
        channels = [field.name for field in bitmap.struct_()]
        pixels = np.array(bitmap).reshape(bitmap.height(), bitmap.width(), -1)
        shown = [channels.index(name) for name in (("R", "G", "B") if "R" in channels else ("Y", "Y", "Y"))]
        return pixels[..., shown]

    (HERE / "pictures").mkdir(exist_ok=True)
    page = HERE / "README.md"
    earlier = [line for line in page.read_text(encoding="utf-8").splitlines() if line.startswith("| ")]
    figures = {line.split(" | ")[0].removeprefix("| "): line for line in earlier}
    chosen = sys.argv[1:] or names()
    with tempfile.TemporaryDirectory() as scratch:
        for name in chosen:
            folder, out = SCENES / name, Path(scratch) / name
            subprocess.run([PHOTOSITE, "render", folder / "capture.toml", "-o", out, "--quiet"], check=True)
            compare = [PHOTOSITE, "compare", out / "electrons.exr", folder / "reference.exr", "--json"]
            found = json.loads(subprocess.run(compare, stdout=subprocess.PIPE, check=False).stdout)
            # One channel is shown: the middle one of three.
            channel = found["channels"][len(found["channels"]) // 2]["channel"]
            compare += ["--channels", channel, "--picture", out / "z.png", "--range", "4"]
            subprocess.run(compare, stdout=subprocess.DEVNULL, check=False)
            ours, theirs = read(out / "electrons.exr"), read(folder / "reference.exr")
            white = np.percentile(theirs, 98, axis=(0, 1))
            z = np.array(mitsuba.Bitmap(str(out / "z.png")))[..., :3]
            strip = np.concatenate([developed(ours, white), developed(theirs, white), z], axis=1)
            strip = strip.repeat(3, axis=0).repeat(3, axis=1)
            mitsuba.Bitmap(strip).write(str(HERE / "pictures" / f"{name}.png"))

            facts = json.loads((folder / "reference.json").read_text(encoding="utf-8"))
            worst = max(channel["z_scores"]["largest"] for channel in found["channels"])
            means = ", ".join(f"{c['mean_difference_percent']:+.3f}" for c in found["channels"])
            spreads = ", ".join(f"{c['z_scores']['spread']:.3f}" for c in found["channels"])
            close = all(abs(c["mean_difference_percent"]) < 0.5
                        and abs(c["z_scores"]["spread"] - 1) < 4.5 / math.sqrt(2 * c["z_scores"]["tests"])
                        for c in found["channels"])
            verdict = "agree" if found["verdict"]["agree"] and close else "**differ**"
            figures[name] = (f"| {name} | {means} | {spreads} | {worst:.2f} of {found['verdict']['z_bound']:.2f} "
                           f"| {facts['samples_per_pixel']} | {verdict} |")
            print(name, verdict, flush=True)
    table = "| scene | mean difference, % | spread of z | largest \\|z\\| of its bound | Mitsuba's samples | verdict |\n"
    figures = [figures[name] for name in names()]
    table += "|---|---|---|---|---|---|\n" + "\n".join(figures) + "\n\n"
    head = HEAD.replace("COVERAGE", coverage())
    text = head + f"Mitsuba {mitsuba.__version__}, channels in the order of the files.\n\n" + table
    text += "\n".join([*map(section, names()), cos4()])
    page.write_text(text, encoding="utf-8")
    sys.exit(any("differ" in row.split("|")[-2] for row in figures))


if __name__ == "__main__":
    main()
