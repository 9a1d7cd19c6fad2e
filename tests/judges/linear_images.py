#!/usr/bin/env python3
"""Writes images of linear light with OpenEXR and has photosite develop them: what their headers say must be followed.

    linear_images.py PHOTOSITE

- Primaries: those of each identifier that OpenEXR knows, as chromaticities and as colorInteropID, and those of XYZ. The
  colours are compared with a matrix of NumPy's by Bradford's method. Whites have four or five digits, 1e-4 of themselves, which
  a matrix to sRGB multiplies by up to ten: 1e-3.
- Compression without loss, either order of lines, halves and floats: the same numbers, bit by bit.
- Windows: each pixel where OpenEXR's own places it, 0 elsewhere.

Exit status 0 where all is well, 1 otherwise.

Needs: pip install -r requirements-exr.txt.
"""

import subprocess
import sys
import tempfile
from pathlib import Path

import numpy
import OpenEXR

D65 = (0.31271, 0.32902)
BRADFORD = numpy.array([[0.8951, 0.2664, -0.1614], [-0.7502, 1.7135, 0.0367], [0.0389, -0.0685, 1.0296]])
IDENTIFIERS = ["rec709", "ap0", "ap1", "p3d65", "rec2020", "adobergb"]
XYZ = (1.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1 / 3, 1 / 3)


def to_xyz(points):
    """Linear RGB to XYZ, Y = 1 for white."""
    columns = numpy.array([[x, y, 1 - x - y] for x, y in numpy.reshape(points, (4, 2))]).T
    primaries, white = columns[:, :3], columns[:, 3] / columns[1, 3]
    return primaries * numpy.linalg.solve(primaries, white), white


def to_srgb(points):
    srgb, d65 = to_xyz((0.64, 0.33, 0.3, 0.6, 0.15, 0.06, *D65))
    matrix, white = to_xyz(points)
    adapted = numpy.linalg.inv(BRADFORD) @ numpy.diag(BRADFORD @ d65 / (BRADFORD @ white)) @ BRADFORD
    return numpy.linalg.inv(srgb) @ adapted @ matrix


def main():
    photosite = Path(sys.argv[1]).resolve()
    wrong = []
    random = numpy.random.default_rng(1)
    colours = random.random((5, 7, 3)).astype("f4")
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)

        def developed(header, pixels):
            header = {"compression": OpenEXR.NO_COMPRESSION, "type": OpenEXR.scanlineimage, **header}
            OpenEXR.File(header, {"RGB": pixels}).write(str(folder / "a.exr"))
            command = [photosite, "develop", "a.exr", "-o", "a.npy", "--force", "--quiet"]
            subprocess.run(command, cwd=folder, check=True)
            return numpy.load(folder / "a.npy")

        def check(what, found, expected, tolerance):
            if found.shape != expected.shape or not numpy.abs(found - expected).max() <= tolerance:
                wrong.append(f"{what}: {found.ravel()[:3]} for {expected.ravel()[:3]}")

        for identifier in IDENTIFIERS:
            identifier = f"lin_{identifier}_scene"
            points = OpenEXR.colorInteropIDToChromaticities(identifier)
            expected = colours @ to_srgb(points).T
            check(identifier, developed({"colorInteropID": identifier}, colours), expected, 1e-3)
            check(f"chromaticities of {identifier}", developed({"chromaticities": points}, colours), expected, 1e-3)
        check("chromaticities of XYZ", developed({"chromaticities": XYZ}, colours), colours @ to_srgb(XYZ).T, 1e-3)
        for kind in ["NO", "RLE", "ZIPS", "ZIP", "PIZ"]:
            for order in [OpenEXR.INCREASING_Y, OpenEXR.DECREASING_Y]:
                for pixels in [colours, colours.astype("f2")]:
                    header = {"compression": getattr(OpenEXR, f"{kind}_COMPRESSION"), "lineOrder": order}
                    check(f"{kind} {order} {pixels.dtype}", developed(header, pixels), pixels.astype("f4"), 0)
        window = lambda *corners: tuple(numpy.array(corner, "i4") for corner in corners)
        for left, top in [(0, 0), (-3, 2), (4, -1), (10, 10)]:
            # A display window of 9 × 8 pixels from column 2, row 1 on.
            whole = numpy.zeros((8, 9, 3), "f4")
            for (y, x, c), value in numpy.ndenumerate(colours):
                if 0 <= y + top - 1 < 8 and 0 <= x + left - 2 < 9:
                    whole[y + top - 1, x + left - 2, c] = value
            header = {"dataWindow": window((left, top), (left + 6, top + 4)), "displayWindow": window((2, 1), (10, 8))}
            try:
                check(f"data window from {left}, {top}", developed(header, colours), whole, 0)
            except subprocess.CalledProcessError:
                if whole.any():
                    wrong.append(f"data window from {left}, {top}: refused")
    print("\n".join(wrong) or "images of linear light are what their headers say")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
