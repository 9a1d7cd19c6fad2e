#!/usr/bin/env python3
"""Writes README.md of this folder: every scene in photosite and in Mitsuba, side by side, with figures.

Renders the captures with photosite, compares with the stored references, and puts one picture for each scene into
pictures/: photosite's, Mitsuba's, and the map of z-scores from −4 (blue) to 4 (red). Needs what references.py needs.
"""

import json
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

from references import HERE, PHOTOSITE, SCENES, names
from render import load_mitsuba

HEAD = """# photosite against Mitsuba 3

Every scene of this suite is rendered by photosite and by [Mitsuba 3](https://mitsuba-renderer.org), which nobody here
wrote, in the responses of the same sensor: mean electrons in every channel of every pixel, each with the variance of the
mean. Where both mean the same, the z-scores

    z = (ours − Mitsuba's) / √(sum of the variances)

follow the normal distribution N(0, 1): mean 0, spread 1, and no pixel beyond the bound that one of so many normal numbers
exceeds with a probability of 1 % (Šidák). `cargo test --release --test mitsuba` holds every scene to that against the
stored references, with channel means within 0.5 % and spreads within 0.03 of 1; `references.py --check` renders
references afresh, so that a stored one cannot go stale. Scenes marked *by hand* were written for Mitsuba from the
capture's meaning, the others by `photosite export-mitsuba`.

Mitsuba's microfacets are not shadowed as ours are; `microfacets.py` describes ours to it from the published equations.
What Mitsuba has no counterpart for (the falloff of a lens, dispersion in one render, glTF's metallic-roughness model)
is compared with closed forms and numerical integrals in `tests/physics` instead.

In each picture: photosite, Mitsuba, z of the green or only channel from −4 (blue) to 4 (red).

"""


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
    rows, figures = [], []
    with tempfile.TemporaryDirectory() as scratch:
        for name in names():
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

            about = (folder / "capture.toml").read_text(encoding="utf-8").splitlines()[0].removeprefix("# ")
            facts = json.loads((folder / "reference.json").read_text(encoding="utf-8"))
            own = folder / "mitsuba.py"
            hand = " *By hand.*" if own.exists() and "by_hand" in own.read_text(encoding="utf-8") else ""
            rows.append(f"## {name}\n\n{about}{hand}\n\n![{name}](pictures/{name}.png)\n")
            worst = max(channel["z_scores"]["largest"] for channel in found["channels"])
            means = ", ".join(f"{c['mean_difference_percent']:+.3f}" for c in found["channels"])
            spreads = ", ".join(f"{c['z_scores']['spread']:.3f}" for c in found["channels"])
            verdict = "agree" if found["verdict"]["agree"] else "**differ**"
            figures.append(f"| {name} | {means} | {spreads} | {worst:.2f} of {found['verdict']['z_bound']:.2f} "
                           f"| {facts['samples_per_pixel']} | {verdict} |")
            print(name, verdict, flush=True)
    table = "| scene | mean difference, % | spread of z | largest \\|z\\| of its bound | Mitsuba's samples | verdict |\n"
    table += "|---|---|---|---|---|---|\n" + "\n".join(figures) + "\n\n"
    text = HEAD + f"Mitsuba {mitsuba.__version__}, channels in the order of the files.\n\n" + table + "\n".join(rows)
    (HERE / "README.md").write_text(text, encoding="utf-8")
    sys.exit(any("differ" in row.split("|")[-2] for row in figures))


if __name__ == "__main__":
    main()
