#!/usr/bin/env python3
"""Converts colours with the colour-science package and compares them with photosite's.

    colours.py colours.json

colours.json is what `cargo run --example convert_colours` prints. Exit status 0 where all is well, 1 otherwise.
Needs: pip install -r requirements.txt.
"""

import json
import sys
import warnings

import numpy

warnings.simplefilter("ignore")
import colour

# Both compute in double precision; what differs are constants of published formulas.
TOLERANCE = 1e-6
# Values are encoded in single precision.
SINGLE = 3e-7
complaints = []


def check(name, ours, theirs, tolerance=TOLERANCE):
    error = numpy.abs(numpy.asarray(ours, float) - numpy.asarray(theirs, float)).max()
    print(f"{name}: largest difference {error:.1e}")
    if not error <= tolerance:
        complaints.append(f"{name} differs by {error}, more than {tolerance}")


def hsi(rgb):
    """HSI as Gonzalez and Woods define it (eqs. 7-16 to 7-19), which colour-science does not have. Its arc cosine loses half
    of all digits near 0 and 180 degrees, so that it needs more of them."""
    r, g, b = rgb.astype(numpy.longdouble).T
    intensity = (r + g + b) / 3
    cosine = ((r - g) + (r - b)) / 2 / numpy.sqrt((r - g) ** 2 + (r - b) * (g - b))
    angle = numpy.degrees(numpy.arccos(numpy.clip(cosine, -1, 1)))
    return numpy.stack([numpy.where(b <= g, angle, 360 - angle), 1 - rgb.min(axis=1) / intensity, intensity], axis=1)


def main():
    with open(sys.argv[1]) as file:
        ours = json.load(file)
    rgb = numpy.array(ours["rgb"])
    white = numpy.array(ours["white"])
    white_xy = white[:2] / white.sum()
    degrees = numpy.array([360.0, 1.0, 1.0])
    check("HSV", ours["hsv"], colour.RGB_to_HSV(rgb) * degrees)
    check("HSL", ours["hsl"], colour.RGB_to_HSL(rgb) * degrees)
    check("HSV to RGB", ours["rgb_of_hsv"], colour.HSV_to_RGB(rgb / degrees))
    check("HSL to RGB", ours["rgb_of_hsl"], colour.HSL_to_RGB(rgb / degrees))
    check("HSI", ours["hsi"], hsi(rgb))
    check("HSI to RGB", ours["rgb_of_hsi"], rgb)
    primaries = colour.RGB_COLOURSPACES["sRGB"].primaries
    npm = colour.normalised_primary_matrix(primaries, white_xy)
    xyz = rgb @ npm.T
    check("sRGB to XYZ", ours["xyz"], xyz)
    lab = colour.XYZ_to_Lab(xyz, white_xy)
    check("L*a*b*", ours["lab"], lab)
    check("L*a*b* to XYZ", ours["xyz_of_lab"], colour.Lab_to_XYZ(lab, white_xy))
    xyy = colour.XYZ_to_xyY(xyz)
    check("xyY", ours["xyy"], xyy)
    check("xyY to XYZ", ours["xyz_of_xyy"], colour.xyY_to_XYZ(xyy))
    check("sRGB encoding", ours["encoded_srgb"], colour.models.eotf_inverse_sRGB(rgb), SINGLE)
    a, b = numpy.moveaxis(numpy.array(ours["pairs"]), 1, 0)
    for name, method in (("76", "CIE 1976"), ("94", "CIE 1994"), ("2000", "CIE 2000")):
        check(f"delta E {name}", ours[f"delta_e_{name}"], colour.delta_E(a, b, method=method))
    theirs = colour.adaptation.matrix_chromatic_adaptation_VonKries(ours["bradford_from"], white, transform="Bradford")
    check("Bradford", ours["bradford"], theirs)
    aces = numpy.array(ours["aces_white"])
    for name, theirs, xy in (
        ("sRGB", "sRGB", white_xy),
        ("Display P3", "Display P3", white_xy),
        ("Rec. 2020", "ITU-R BT.2020", white_xy),
        ("ACEScg", "ACEScg", aces[:2] / aces.sum()),
    ):
        npm = colour.normalised_primary_matrix(colour.RGB_COLOURSPACES[theirs].primaries, xy)
        check(f"matrix of {name}", ours["spaces"][name], npm)
    check("white of ACEScg", aces[:2] / aces.sum(), colour.RGB_COLOURSPACES["ACEScg"].whitepoint)
    # Their second radiation constant is that of ITS-90, ours that of CODATA 2018; a blackbody's spectrum depends on its
    # product with the reciprocal temperature.
    lights = ours["lights"]
    pairs = [[light["temperature_k"] * 1.4388e-2 / 1.438776877e-2, light["tint"] / 3000.0] for light in lights]
    observer = colour.MSDS_CMFS["CIE 1931 2 Degree Standard Observer"]
    uv = numpy.array([colour.temperature.CCT_to_uv_Ohno2013(pair, cmfs=observer) for pair in pairs])
    theirs = colour.UCS_uv_to_xy(uv)
    check("temperature and tint", [light["xy"] for light in lights], theirs, 1e-6)
    for complaint in complaints:
        print(complaint, file=sys.stderr)
    sys.exit(1 if complaints else 0)


if __name__ == "__main__":
    main()
