#!/usr/bin/env python3
"""Demosaics photosite's charts with the colour-demosaicing package and compares how close both come to the truth.

    demosaicing.py FOLDER...

Each FOLDER, named after its chart and Bayer phase, holds what `cargo run --example write_demosaic_charts` wrote: raw.tiff,
truth.tiff and an image for each of photosite's methods. The peak signal-to-noise ratio is that of all channels, without
a border of 12 pixels: the package repeats the pixel at the edge, which has another phase of the mosaic, where photosite
mirrors at it. The same method must come equally close within 0.01 dB, and photosite's best at least as close as the
package's. Exit status 0 where all is well, 1 otherwise.

Needs: pip install -r requirements.txt.
"""

import sys
import warnings
from pathlib import Path

import numpy
import tifffile

warnings.simplefilter("ignore")
from colour_demosaicing import (
    demosaicing_CFA_Bayer_bilinear,
    demosaicing_CFA_Bayer_Malvar2004,
    demosaicing_CFA_Bayer_Menon2007,
)

THEIRS = {
    "bilinear": demosaicing_CFA_Bayer_bilinear,
    "malvar": demosaicing_CFA_Bayer_Malvar2004,
    "menon": demosaicing_CFA_Bayer_Menon2007,
}
OURS = ("nearest", "bilinear", "guided", "malvar", "menon", "lmmse")
BORDER = 12
SAME = 0.01


def read(path):
    return tifffile.imread(path).astype(float) / 65535.0


def psnr(picture, truth):
    inner = (slice(BORDER, -BORDER),) * 2
    # Ours is clipped to what codes can hold.
    return -10.0 * numpy.log10(numpy.mean((numpy.clip(picture, 0.0, 1.0)[inner] - truth[inner]) ** 2))


def judge(folder: Path):
    phase = folder.name.rsplit("-", 1)[1]
    mosaic, truth = read(folder / "raw.tiff"), read(folder / "truth.tiff")
    ours = {name: psnr(read(folder / f"{name}.tiff"), truth) for name in OURS}
    theirs = {name: psnr(method(mosaic, phase), truth) for name, method in THEIRS.items()}
    print(folder.name + ": " + ", ".join(f"{name} {ours[name]:.3f}" + (f" | {theirs[name]:.3f}" if name in theirs else "") for name in OURS))
    for name in theirs:
        if abs(ours[name] - theirs[name]) > SAME:
            yield f"{folder}: {name} reaches {ours[name]:.3f} dB here, {theirs[name]:.3f} dB there"
    if max(ours.values()) < max(theirs.values()) - SAME:
        yield f"{folder}: the best here reaches {max(ours.values()):.3f} dB, there {max(theirs.values()):.3f} dB"


def main():
    folders = [Path(argument) for argument in sys.argv[1:]]
    if not folders:
        sys.exit(__doc__)
    complaints = [complaint for folder in folders for complaint in judge(folder)]
    for complaint in complaints:
        print(complaint, file=sys.stderr)
    sys.exit(1 if complaints else 0)


if __name__ == "__main__":
    main()
