"""The scene of many lamps, written by hand."""

import tempfile
from pathlib import Path

import numpy as np
from by_hand import GRID, SPECTRA, at, camera, diffuse, film, illuminant_a, photometric, shapes


def load(mitsuba, folder, export):
    black, daylight = np.zeros(GRID.shape), at(SPECTRA / "illuminants" / "d65.csv")
    materials = {
        "floor": (diffuse(np.full(GRID.shape, 0.5)), None),
        "wall": (diffuse(at(SPECTRA / "cornell" / "green.csv")), None),
        "block": (diffuse(at(SPECTRA / "cornell" / "red.csv")), None),
        "lamp": (diffuse(np.full(GRID.shape, 0.2)), None),
        "lamps": (diffuse(black), photometric(illuminant_a(), 30_000)),
        "bright": (diffuse(black), photometric(daylight, 300_000)),
    }
    # A pinhole focused at infinity: the image lies one focal length behind it.
    counts = film("generic-cmos-color", 64, 64, 45.0, 2.0, 4e-3, 4e-3, 0.00003)
    files = [f"../../geometry/{name}.obj" for name in ("stage", "block", "lamps")]
    with tempfile.TemporaryDirectory() as scratch:
        return mitsuba.load_dict({
            "type": "scene",
            "integrator": {"type": "path", "max_depth": 2},
            "sensor": camera(mitsuba, "perspective", [0, 1.2, 3.6], [0, 0.7, 0], 64 * 45e-6, 4e-3, counts),
        } | shapes(folder, Path(scratch), files, materials))
