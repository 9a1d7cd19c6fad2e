#!/usr/bin/env python3
"""Takes the image sets of EMVA 1288 anew with `photosite.Sensor`, of spectral irradiance as other renderers have it.

    python_sensor.py FOLDER

FOLDER holds what `photosite emva1288 SENSOR` has written for a sensor without colours. The light of each of its images
becomes a cube of spectral irradiance with a band of 1 nm, which the sensor of the Python package is exposed to, and the
image that this gives takes the place of the other. Then emva1288_figures.py lets the EMVA 1288 tool recover what was put
into the sensor, as it does for the command's own images.

Needs: the package photosite.
"""

import json
import sys
from pathlib import Path

import numpy as np

import photosite as ps

# h·c, J·nm, of the exact values of CODATA 2018.
HC = 6.62607015e-34 * 299_792_458 * 1e9


def main(folder):
    sets = json.loads((folder / "emva1288.json").read_text())
    [channel] = sets["channels"]
    wavelength = channel["wavelength_nm"]
    sensor = ps.Sensor(sets["sensor"])
    area = np.prod(sensor.pixel_pitch_um) * 1e-12
    columns, rows = sets["size_px"]
    descriptor = folder / channel["descriptor"]
    taken, time_s, photons = 0, 0.0, 0.0
    for line in descriptor.read_text().splitlines():
        kind, *values = line.split()
        if kind in "bd":
            time_s = float(values[0]) * 1e-9
            photons = float(values[1]) if kind == "b" else 0.0
        elif kind == "i":
            # Photons of the exposure as irradiance in the middle one of three bands.
            cube = np.zeros((rows, columns, 3), np.float32)
            cube[:, :, 1] = photons * HC / wavelength / (area * time_s)
            bands = [wavelength - 1, wavelength, wavelength + 1]
            shot = sensor.expose(cube, wavelengths_nm=bands, time_s=time_s, seed=taken, illuminant=(bands, [0, 1, 0]),
                                 set={"exposure.temperature_c": channel["temperature_c"]})
            path = descriptor.parent / values[0].replace("\\", "/")
            assert path.exists(), path
            shot.raw.save(path)
            taken += 1
    print(f"{taken} images of {sensor} at {wavelength} nm")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
