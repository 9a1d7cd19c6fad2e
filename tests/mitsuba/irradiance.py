#!/usr/bin/env python3
"""Measures in Mitsuba what a lens lets onto its sensor: irradiance behind a round hole under a uniform sky.

    irradiance.py             measures and stores irradiance.json
    irradiance.py --check     measures some of it anew, with fewer samples, and compares

A black box has a round hole in its lid, and on its floor, v below the lid, lie irradiance meters: one under the hole and
others from where the middle of the hole is seen at an angle to the axis. Outside is a sky of radiance 1 everywhere. A lens
focused at infinity has v = f, so the hole of the stop N has the diameter v/N, and what the meters show is

    E = ∫ cos⁴θ / v² dA over the hole, θ between the axis and the way to dA,

and so must photosite's lens. Rays of an irradiance meter leave into all directions, and few find a small hole: one in
4N². Small stops are measured another way: to a point on the floor the sky in the hole is a disk of radiance 1, which is
made a lamp, and the floor a white matt surface, whose radiance is E/π. Rays to a lamp are aimed. Both ways are taken where
the hole is large, so that the second is itself checked. Needs what references.py needs.
"""

import argparse
import itertools
import json
import math
import sys
import tempfile
from pathlib import Path

import numpy as np

# Beside the exporter, which writes it into the folder of each scene.
sys.path.append(str(Path(__file__).resolve().parents[2] / "crates/photosite-mitsuba/assets"))
from render import load_mitsuba

STORED = Path(__file__).resolve().parent / "irradiance.json"
VARIANT = "llvm_ad_rgb"
# Stops measured as they are, with how many rays that shall come through the hole: the error is 0.1 % and 0.2 %.
HOLES = {1.4: 1_000_000, 2.0: 250_000}
# Stops measured by a lamp.
LAMPS = [1.4, 2.0, 2.8, 4.0, 5.6, 8.0, 11.0, 16.0]
DEGREES = [0, 10, 20, 30, 40]
# Samples by a lamp: the error is below 0.05 %, the largest for the largest hole.
AIMED = 1_048_576
# A check takes this part of the samples.
CHECK_PART = 4
# Each image has so many pixels that all show the same: their spread tells the error of the mean.
SIDE = 64
# Where two measurements may differ, standard errors: 1 in 16 000 does by chance.
SIGMAS = 4
CORNERS = 720


def box(path, radius):
    """A lid at z = 0 with a round hole, and walls down to z = -2; the floor is left to the meter, which looks up only."""
    rings = [(radius, 0.0), (3.0, 0.0), (3.0, -2.0)]
    # The hole is as large as a circle, though it has corners.
    polygon = math.sqrt(2 * math.pi / CORNERS / math.sin(2 * math.pi / CORNERS))
    lines = []
    for ring, (r, z) in enumerate(rings):
        for i in range(CORNERS):
            turn = 2 * math.pi * i / CORNERS
            r_of_ring = r * (polygon if ring == 0 else 1)
            lines.append(f"v {r_of_ring * math.cos(turn):.9f} {r_of_ring * math.sin(turn):.9f} {z}")
    for ring in range(len(rings) - 1):
        for i in range(CORNERS):
            a, b = ring * CORNERS + i + 1, ring * CORNERS + (i + 1) % CORNERS + 1
            lines.append(f"f {a} {a + CORNERS} {b + CORNERS} {b}")
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")


def film():
    return {"type": "hdrfilm", "width": SIDE, "height": SIDE, "pixel_format": "luminance", "component_format": "float32",
            "rfilter": {"type": "box"}}


def by_hole(mitsuba, folder, f_number, x):
    """The scene of a hole and an irradiance meter x off the axis, and how much of it the meter's rays find."""
    path = folder / "box.obj"
    box(path, 0.5 / f_number)
    black = {"type": "diffuse", "reflectance": 0.0}
    meter = {"type": "irradiancemeter", "sampler": {"type": "independent"}, "film": film()}
    scene = mitsuba.load_dict({
        "type": "scene",
        "integrator": {"type": "path", "max_depth": 1},
        "sky": {"type": "constant", "radiance": 1.0},
        "box": {"type": "obj", "filename": str(path), "face_normals": True, "bsdf": black},
        "floor": {
            "type": "rectangle",
            "to_world": mitsuba.ScalarTransform4f().translate([x, 0, -1]).scale(1e-4),
            "bsdf": black,
            "meter": meter,
        },
    })
    # Rays leave by the cosine: the part that finds the hole is E/π.
    return scene, 1.0, HOLES[f_number] / (0.25 / f_number**2 / (1 + x * x) ** 2)


def by_lamp(mitsuba, _, f_number, x):
    """The scene of a lamp as large as the hole over a white floor, looked at x off the axis."""
    transform = mitsuba.ScalarTransform4f
    scene = mitsuba.load_dict({
        "type": "scene",
        "integrator": {"type": "path", "max_depth": 2},
        # Disks face up.
        "lamp": {
            "type": "disk",
            "to_world": transform().rotate([1, 0, 0], 180).scale(0.5 / f_number),
            "emitter": {"type": "area", "radiance": 1.0},
        },
        "floor": {
            "type": "rectangle",
            "to_world": transform().translate([x, 0, -1]).scale(0.01),
            "bsdf": {"type": "diffuse", "reflectance": 1.0},
        },
        "sensor": {
            "type": "perspective",
            "fov": 0.01,
            "near_clip": 1e-4,
            "to_world": transform().look_at([x, 0, -0.9], [x, 0, -1], [0, 1, 0]),
            "sampler": {"type": "independent"},
            "film": film(),
        },
    })
    return scene, math.pi, AIMED


def measure(mitsuba, way, folder, f_number, degrees, part, seed):
    """Irradiance and its standard error, and from how many samples; v = 1."""
    scene, factor, samples = way(mitsuba, folder, f_number, math.tan(math.radians(degrees)))
    per_pass = 256
    passes = math.ceil(samples / part / SIDE**2 / per_pass)
    total = sum(
        np.array(mitsuba.render(scene, spp=per_pass, seed=(seed * 100_000 + i) * 1_000), dtype=np.float64)
        for i in range(passes)
    )
    values = factor * total.ravel() / passes
    return values.mean(), values.std(ddof=1) / SIDE, passes * per_pass * SIDE**2


def main():
    parser = argparse.ArgumentParser(description="Measure the irradiance behind a round hole in Mitsuba 3.")
    parser.add_argument("--check", action="store_true", help="compare fresh measurements, the quick ones, with the stored ones")
    options = parser.parse_args()
    mitsuba = load_mitsuba(VARIANT)
    stored = json.loads(STORED.read_text(encoding="utf-8"))["measured"] if options.check else []
    found, wrong = [], 0
    # Of the holes the largest alone is quick.
    ways = [("hole", by_hole, list(HOLES)[: 1 if options.check else None]), ("lamp", by_lamp, LAMPS)]
    with tempfile.TemporaryDirectory() as scratch:
        for name, way, stops in ways:
            for f_number, degrees in itertools.product(stops, DEGREES):
                place = {"way": name, "f_number": f_number, "angle_deg": degrees}
                part, seed = (CHECK_PART, 1) if options.check else (1, 0)
                mean, error, samples = measure(mitsuba, way, Path(scratch), f_number, degrees, part, seed)
                text = f"{name} of f/{f_number:<4} at {degrees:2}°: {mean:.7f} ± {error:.7f}"
                if options.check:
                    entry = next(entry for entry in stored if place.items() <= entry.items())
                    sigmas = (mean - entry["irradiance"]) / math.hypot(error, entry["standard_error"])
                    wrong += abs(sigmas) > SIGMAS
                    text += f", {sigmas:+.2f} standard errors from the stored one"
                print(text, flush=True)
                digits = {"irradiance": round(mean, 10), "standard_error": round(error, 10)}
                found.append(place | digits | {"samples": samples, "seed": seed})
    if not options.check:
        facts = {"mitsuba": mitsuba.__version__, "variant": VARIANT, "radiance": 1.0, "image_distance": 1.0}
        rows = ",\n".join("    " + json.dumps(entry) for entry in found)
        head = json.dumps(facts, indent=2).removesuffix("\n}")
        STORED.write_text(f'{head},\n  "measured": [\n{rows}\n  ]\n}}\n', encoding="utf-8")
    sys.exit(1 if wrong else 0)


if __name__ == "__main__":
    main()
