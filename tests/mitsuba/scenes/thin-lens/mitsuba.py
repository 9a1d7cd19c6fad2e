"""The scene of the thin lens, written by hand."""

import tempfile
from pathlib import Path

import numpy as np
from by_hand import GRID, SPECTRA, at, camera, diffuse, film, illuminant_a, photometric, shapes

FOCAL_LENGTH, F_NUMBER, FOCUS = 0.2, 1.4, 2.3


def load(mitsuba, folder, export):
    materials = {
        "floor": (diffuse(np.full(GRID.shape, 0.5)), None),
        "wall": (diffuse(at(SPECTRA / "cornell" / "green.csv")), None),
        "block": (diffuse(at(SPECTRA / "cornell" / "red.csv")), None),
        "post": (diffuse(at(SPECTRA / "cornell" / "white.csv")), None),
        "lamp": (diffuse(np.zeros(GRID.shape)), photometric(illuminant_a(), 2000)),
    }
    # 1/f = 1/u + 1/v.
    image_distance = 1 / (1 / FOCAL_LENGTH - 1 / FOCUS)
    counts = film("generic-cmos-color", 64, 64, 2100.0, F_NUMBER, FOCAL_LENGTH, image_distance, 0.00000005)
    lens = {"aperture_radius": FOCAL_LENGTH / F_NUMBER / 2, "focus_distance": FOCUS}
    files = ["../../geometry/stage.obj", "../../geometry/block.obj", "posts.obj"]
    with tempfile.TemporaryDirectory() as scratch:
        return mitsuba.load_dict({
            "type": "scene",
            "integrator": {"type": "path", "max_depth": 6},
            "sensor": camera(mitsuba, "thinlens", [0, 0.8, 2.6], [0, 0.6, 0], 64 * 2.1e-3, image_distance, counts, **lens),
        } | shapes(folder, Path(scratch), files, materials))
