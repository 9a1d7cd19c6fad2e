#!/usr/bin/env python3
"""Renders the references of the suite in Mitsuba 3.

    references.py [NAME...]            renders and stores them (all scenes where none is named)
    references.py --check [NAME...]    renders them afresh with another seed and compares with the stored ones

A scene is a folder scenes/NAME with capture.toml and what it names. Mitsuba gets it from `photosite export-mitsuba`, unless
mitsuba.py in that folder says otherwise: a function load(mitsuba, folder, export) that returns a Mitsuba scene whose film
has the channels of the capture's sensor and counts electrons, or a list of scenes that have some of the channels each. It
describes the scene by hand, or calls export(), which returns the path of the exported one, to change that.

Beside the capture are stored reference.exr, the image with its variances, and reference.json, where it comes from. A
`scale` there is what an image was multiplied by later, its variances by the square: the f-number's share of the light,
which is a constant factor of the image, was π/4·(D/v)² when it was rendered and has been π·sin²θ' since (tan θ' = D/2v).
Needs Python 3.11, `pip install -r requirements.txt`, LLVM 17 or later (Debian: apt install libllvm19) and
`cargo build --release`.
"""

import argparse
import importlib.util
import json
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

# Beside the exporter, which writes it into the folder of each scene.
sys.path.append(str(Path(__file__).resolve().parents[2] / "crates/photosite-mitsuba/assets"))
from render import VARIANT, load_mitsuba, render, write

HERE = Path(__file__).resolve().parent
SCENES = HERE / "scenes"
PHOTOSITE = HERE.parents[1] / "target" / "release" / "photosite"
BATCHES = 128
# Fresh images for a check take this part of the samples of the stored ones.
CHECK_PART = 2


def names():
    return sorted(path.parent.name for path in SCENES.glob("*/capture.toml"))


def own_load(folder):
    """The load function of a scene that has its own."""
    path = folder / "mitsuba.py"
    if not path.exists():
        return None
    spec = importlib.util.spec_from_file_location(f"scene_{folder.name}", path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module.load


def load(mitsuba, folder, scratch):
    """The scene in Mitsuba."""

    def export(*options):
        out = scratch / folder.name
        command = [PHOTOSITE, "export-mitsuba", folder / "capture.toml", "-o", out, "--quiet", "--force", *options]
        if subprocess.run(command, check=False).returncode:
            sys.exit(f"photosite cannot export {folder.name}")
        return out / "scene.xml"

    own = own_load(folder)
    return own(mitsuba, folder, export) if own else mitsuba.load_file(str(export()))


def settings(folder):
    """Samples of the reference, from the comment `# reference: N samples` of the capture, or the default."""
    for line in (folder / "capture.toml").read_text(encoding="utf-8").splitlines():
        if line.startswith("# reference: "):
            return int(line.split()[2])
    return 8192


def picture(mitsuba, scenes, samples, seed):
    """Mean, variance and names of the channels of a scene or of several."""
    scenes = scenes if isinstance(scenes, list) else [scenes]
    parts = [render(mitsuba, scene, samples, BATCHES, seed) for scene in scenes]
    mean, variance = (np.concatenate([part[i] for part in parts], axis=-1) for i in (0, 1))
    return mean, variance, [name for part in parts for name in part[2]]


def store(mitsuba, name, scratch):
    folder = SCENES / name
    samples, seed = settings(folder), 0
    start = time.perf_counter()
    write(mitsuba, folder / "reference.exr", *picture(mitsuba, load(mitsuba, folder, scratch), samples, seed))
    facts = {
        "scene": "mitsuba.py" if own_load(folder) else "photosite export-mitsuba",
        "mitsuba": mitsuba.__version__,
        "variant": VARIANT,
        "samples_per_pixel": samples,
        "batches": BATCHES,
        "seed": seed,
    }
    (folder / "reference.json").write_text(json.dumps(facts, indent=2) + "\n", encoding="utf-8")
    print(f"{name}: {time.perf_counter() - start:.0f} s", flush=True)
    return True


def check(mitsuba, name, scratch):
    folder = SCENES / name
    fresh = scratch / f"{name}.exr"
    samples = max(BATCHES, settings(folder) // CHECK_PART)
    write(mitsuba, fresh, *picture(mitsuba, load(mitsuba, folder, scratch), samples, seed=1))
    print(f"{name}, a fresh reference against the stored one:", flush=True)
    return subprocess.run([PHOTOSITE, "compare", fresh, folder / "reference.exr"], check=False).returncode == 0


def main():
    parser = argparse.ArgumentParser(description="Render the references of the suite in Mitsuba 3.")
    parser.add_argument("names", nargs="*", metavar="NAME")
    parser.add_argument("--check", action="store_true", help="compare fresh references with the stored ones")
    options = parser.parse_args()
    chosen = options.names or names()
    unknown = set(chosen) - set(names())
    if unknown:
        sys.exit(f"no scene {', '.join(sorted(unknown))}; there are {', '.join(names())}")
    mitsuba = load_mitsuba()
    with tempfile.TemporaryDirectory() as scratch:
        done = [(check if options.check else store)(mitsuba, name, Path(scratch)) for name in chosen]
    sys.exit(0 if all(done) else 1)


if __name__ == "__main__":
    main()
