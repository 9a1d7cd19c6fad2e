"""The Cornell box, written by hand."""

import tempfile
from pathlib import Path

import numpy as np
from by_hand import GRID, SPECTRA, at, camera, diffuse, film, photometric, shapes


def load(mitsuba, folder, export):
    light = photometric(at(SPECTRA / "cornell" / "light.csv"), 10_000)
    materials = {name: (diffuse(at(SPECTRA / "cornell" / f"{name}.csv")), None) for name in ("white", "red", "green")}
    materials["lamp"] = (diffuse(np.full(GRID.shape, 0.78)), light)
    # The pinhole is focused at infinity: the image lies one focal length behind it.
    counts = film("generic-cmos-color", 64, 64, 45.0, 2.0, 4.032e-3, 4.032e-3, 0.0001)
    with tempfile.TemporaryDirectory() as scratch:
        box = shapes(folder, Path(scratch), ["../../../../scenes/cornell-box/cornell-box.obj"], materials, scale=0.001)
        return mitsuba.load_dict({
            "type": "scene",
            "integrator": {"type": "path", "max_depth": 8},
            "sensor": camera(mitsuba, "perspective", [0.278, 0.273, -0.8], [0.278, 0.273, 0], 64 * 45e-6, 4.032e-3, counts),
        } | box)
