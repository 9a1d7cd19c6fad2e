#!/usr/bin/env python3
"""Lets LibRaw and exiftool read the DNG files of `Raw.from_array`: numbers bit for bit, levels, filters, an even white.

    raw_arrays.py FOLDER

FOLDER is made, and filled with the files.

Needs: the package photosite, rawpy, exiftool.
"""

import subprocess
import sys
from pathlib import Path

import numpy as np
import photosite as ps
import rawpy

FILTERS = ["RGGB", "BGGR", "GRBG", "GBRG", "mono", "rccb"]
BITS = [8, 10, 12, 14, 16]
SHAPE = (96, 120)


def main(folder):
    folder.mkdir(parents=True)
    complaints = []
    random = np.random.default_rng(1)
    for cfa in FILTERS:
        for bits in BITS:
            white = 2**bits - 1
            numbers = random.integers(0, white, SHAPE, dtype=np.uint16, endpoint=True)
            path = folder / f"{cfa}-{bits}.dng"
            black = 4.0
            ps.Raw.from_array(numbers, cfa=cfa, black_level_dn=black, white_level_dn=white).save(path)
            with rawpy.imread(str(path)) as raw:
                if not np.array_equal(raw.raw_image_visible, numbers):
                    complaints.append(f"{path.name}: LibRaw reads other numbers")
                if raw.white_level != white or set(raw.black_level_per_channel) != {black}:
                    complaints.append(f"{path.name}: levels {raw.black_level_per_channel} to {raw.white_level}")
                if cfa in ("mono", "rccb"):
                    continue
                tile = "".join(chr(raw.color_desc[raw.raw_colors[y, x]]) for y in (0, 1) for x in (0, 1))
                if tile != cfa:
                    complaints.append(f"{path.name}: LibRaw takes the filters for {tile}")
            # A grey scene is grey: channels of linear sRGB that are equal are no colour.
            grey = np.full(SHAPE, white // 2, np.uint16)
            ps.Raw.from_array(grey, cfa=cfa, white_level_dn=white).save(path)
            with rawpy.imread(str(path)) as raw:
                rgb = raw.postprocess(use_camera_wb=True, no_auto_bright=True).reshape(-1, 3)
            if np.ptp(rgb.mean(axis=0)) > 1:
                complaints.append(f"{path.name}: LibRaw develops grey as {rgb.mean(axis=0)}")
    files = sorted(map(str, folder.glob("*.dng")))
    said = subprocess.run(["exiftool", "-validate", "-warning", "-a", *files], capture_output=True, text=True).stdout
    fine = said.count("Validate                        : OK")
    if fine != len(files):
        complaints.append(f"exiftool finds {fine} of {len(files)} files valid:\n{said}")
    print(f"{len(files)} files of {', '.join(FILTERS)} with {', '.join(map(str, BITS))} bits")
    for complaint in complaints:
        print(complaint, file=sys.stderr)
    return bool(complaints)


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1])))
