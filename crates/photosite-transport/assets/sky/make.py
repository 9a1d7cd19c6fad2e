#!/usr/bin/env python3
"""Makes hosek-wilkie.bin, the coefficients of the spectral sky and sun of Hosek and Wilkie (2012, 2013; their licence is
beside this file), from the copy of their data that Mitsuba 3 ships with:

    python make.py .../site-packages/mitsuba/data/sunsky/sunsky_datasets.bin

All numbers are 32-bit little-endian floats, the last index runs fastest:

  sky   [turbidity 1-10][ground albedo 0, 1][elevation, 6 control points][wavelength, 320-720 nm by 40][9 parameters, radiance]
  sun   [turbidity 1-10][elevation, 45 segments][wavelength][powers 0-3 of the elevation within the segment]
  limb  [wavelength][powers 0-5 of the cosine to the normal of the sun]
"""
import struct
import sys
from pathlib import Path

import numpy as np

data = Path(sys.argv[1]).read_bytes()
(count,) = struct.unpack_from("<I", data, 14)
fields, at = {}, 18
for _ in range(count):
    (length,) = struct.unpack_from("<H", data, at)
    name = data[at + 2 : at + 2 + length].decode()
    at += 2 + length
    axes, kind, offset = struct.unpack_from("<HBQ", data, at)
    shape = struct.unpack_from(f"<{axes}Q", data, at + 11)
    at += 11 + 8 * axes
    assert kind == 11, "64-bit floats"
    fields[name] = np.frombuffer(data, "<f8", int(np.prod(shape)), offset).reshape(shape)
sky = np.concatenate([fields["sky_params_spec"], fields["sky_rad_spec"][..., None]], axis=-1)
parts = [sky, fields["sun_rad_spec"], fields["sun_ld_spec"]]
numbers = np.concatenate([part.ravel() for part in parts]).astype("<f4")
(Path(__file__).parent / "hosek-wilkie.bin").write_bytes(numbers.tobytes())
