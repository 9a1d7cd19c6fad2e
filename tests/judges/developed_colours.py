#!/usr/bin/env python3
"""Develops photosite's raw files with LibRaw and compares the colours with photosite's own.

    developed_colours.py FOLDER...

Each FOLDER holds raw.dng and image.png of one picture, in light close to D65: LibRaw uses the D65 matrix only. The
picture is compared in blocks of 16 x 16 pixels whose content is even, so that edges, at which demosaicking differs, do
not count. Exit status 0 where all is well, 1 otherwise.

Needs: pip install -r requirements.txt.
"""

import sys
from pathlib import Path

import numpy
import rawpy
from PIL import Image

BLOCK = 16
# Both round to 8 bits once, after computing in single precision or 16-bit integers: one code each.
TOLERANCE = 2.0
# A block counts as even where no channel varies more than this.
EVEN = 6.0


def blocks(picture):
    height, width = (n // BLOCK * BLOCK for n in picture.shape[:2])
    cut = picture[:height, :width].astype(float)
    tiles = cut.reshape(height // BLOCK, BLOCK, width // BLOCK, BLOCK, 3).swapaxes(1, 2)
    return tiles.reshape(-1, BLOCK * BLOCK, 3)


def judge(folder: Path):
    ours = numpy.asarray(Image.open(folder / "image.png").convert("RGB"))
    with rawpy.imread(str(folder / "raw.dng")) as raw:
        theirs = raw.postprocess(
            use_camera_wb=True,
            no_auto_bright=True,
            adjust_maximum_thr=0.0,
            output_color=rawpy.ColorSpace.sRGB,
            gamma=(2.4, 12.92),
            user_flip=0,
        )
    if ours.shape != theirs.shape:
        return [f"{folder}: image.png is {ours.shape}, LibRaw's {theirs.shape}"]
    our_blocks, their_blocks = blocks(ours), blocks(theirs)
    even = (numpy.ptp(our_blocks, axis=1).max(axis=1) <= EVEN) & (numpy.ptp(their_blocks, axis=1).max(axis=1) <= EVEN)
    if not even.any():
        return [f"{folder}: no even block to compare"]
    difference = numpy.abs(our_blocks[even].mean(axis=1) - their_blocks[even].mean(axis=1))
    print(f"{folder}: {even.sum()} blocks, mean difference {difference.mean():.3f} codes, largest {difference.max():.3f}")
    if difference.max() > TOLERANCE:
        worst = difference.max(axis=1).argmax()
        ours_there, theirs_there = our_blocks[even][worst].mean(axis=0), their_blocks[even][worst].mean(axis=0)
        return [f"{folder}: colours differ by {difference.max():.2f} codes: {ours_there} here, {theirs_there} by LibRaw"]
    return []


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
