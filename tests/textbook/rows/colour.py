"""Colour spaces and models against colour-science, and white balance by the lamps' names."""

import colour
import cv2
import numpy
import tifffile
from pictures import develop, largest, write_exr
from table import Figure, Row

#: Part of full scale that single precision and rounding to it may differ by.
EXACT = 1e-6
SRGB = colour.RGB_COLOURSPACES["sRGB"]


def colours(tool):
    """Linear sRGB of 40 × 30 colours, with greys, primaries and near greys among them, and the file that holds them."""
    picture = numpy.random.default_rng(7).random((30, 40, 3)).astype("f4")
    picture[0, :3] = numpy.eye(3)
    picture[1, :10] = numpy.linspace(0, 1, 10)[:, None]
    picture[2, :20] = 0.5 + 0.01 * picture[2, :20]
    return picture.astype(float), write_exr(tool.scratch / "colours.exr", picture)


def white(tool):
    """X, Y and Z of sRGB's white."""
    path = write_exr(tool.scratch / "white.exr", numpy.ones((1, 1, 3), "f4"))
    return develop(tool, path, "colour_space=xyz", output="white.npy")[0, 0].astype(float)


def to_xyz(tool):
    return colour.normalised_primary_matrix(SRGB.primaries, colour.XYZ_to_xy(white(tool)))


def hue_models(tool):
    linear, path = colours(tool)
    encoded = colour.models.eotf_inverse_sRGB(linear)
    figures = []
    for model, convert in [("hsv", colour.RGB_to_HSV), ("hsl", colour.RGB_to_HSL)]:
        found = develop(tool, path, f"colour_model={model}") / [360, 1, 1]
        expected = convert(encoded)
        # Hues go around: 0 and 1 are one.
        turn = numpy.abs(found - expected)
        turn[..., 0] = numpy.minimum(turn[..., 0], 1 - turn[..., 0])
        figures.append(
            Figure(
                f"{model.upper()}, largest difference (hues over 360°)", float(turn.max()), 0, EXACT, "colour-science"
            )
        )
    r, g, b = numpy.moveaxis(encoded, 2, 0)
    intensity = (r + g + b) / 3
    with numpy.errstate(invalid="ignore", divide="ignore"):
        saturation = numpy.where(intensity > 0, 1 - encoded.min(2) / intensity, 0)
        cosine = 0.5 * ((r - g) + (r - b)) / numpy.sqrt((r - g) ** 2 + (r - b) * (g - b))
        angle = numpy.degrees(numpy.arccos(cosine.clip(-1, 1)))
    hue = numpy.where(b <= g, angle, 360 - angle)
    hsi = develop(tool, path, "colour_model=hsi")
    coloured = saturation > 1e-6
    figures += [
        Figure(
            "HSI, saturation and intensity, largest difference",
            max(largest(hsi[..., 1], saturation), largest(hsi[..., 2], intensity)),
            0,
            EXACT,
        ),
        # An arc cosine loses half the digits near 0° and 180°.
        Figure("HSI, hue, largest difference over 360°", largest(hsi[..., 0][coloured], hue[coloured]) / 360, 0, 1e-5),
    ]
    return figures


def cielab(tool):
    linear, path = colours(tool)
    matrix, reference = to_xyz(tool), white(tool)
    xyz = develop(tool, path, "colour_space=xyz")
    lab = develop(tool, path, "colour_model=lab")
    expected = linear @ matrix.T
    return [
        Figure("white's x", float(colour.XYZ_to_xy(reference)[0]), 0.3127, 5e-5, "IEC 61966-2-1"),
        Figure("white's y", float(colour.XYZ_to_xy(reference)[1]), 0.3290, 5e-5, "IEC 61966-2-1"),
        Figure("X, Y, Z, largest difference", largest(xyz, expected), 0, EXACT, "colour-science"),
        Figure(
            "L*, a*, b* over 100, largest difference",
            largest(lab, colour.XYZ_to_Lab(expected, colour.XYZ_to_xy(reference))) / 100,
            0,
            EXACT,
            "colour-science",
        ),
    ]


def grey(tool):
    linear, path = colours(tool)
    luminance = linear @ to_xyz(tool)[1]
    found = develop(tool, path, "colour_model=grey")
    floats = develop(tool, path, "colour_model=encoded-grey")
    png = develop(tool, path, "colour_model=grey", "bits=16", output="grey.png")
    coded = cv2.imread(str(png), cv2.IMREAD_UNCHANGED) / 65535
    return [
        Figure("linear Y in NPY, largest difference", largest(found, luminance), 0, EXACT, "colour-science"),
        Figure(
            "encoded Y in NPY, largest difference",
            largest(floats, colour.models.eotf_inverse_sRGB(luminance)),
            0,
            EXACT,
            "colour-science",
        ),
        # Codes of 16 bits, half a code.
        Figure(
            "encoded Y in PNG, largest difference",
            largest(coded, colour.models.eotf_inverse_sRGB(luminance)),
            0,
            0.51 / 65535,
            "colour-science, OpenCV",
        ),
    ]


def files(tool):
    _, path = colours(tool)
    figures = []
    for model in ["hsv", "lab"]:
        array = develop(tool, path, f"colour_model={model}")
        tiff = develop(tool, path, f"colour_model={model}", output="model.tiff")
        figures.append(
            Figure(
                f"{model.upper()} in TIFF and NPY, largest difference",
                largest(tifffile.imread(tiff), array),
                0,
                0,
                "tifffile",
            )
        )
    return figures


LAMPS = {
    "candle": 1850,
    "incandescent": 2856,
    "halogen": 3200,
    "fluorescent": 4230,
    "d50": 5003,
    "flash": 5503,
    "daylight": 6504,
    "overcast": 7000,
    "shade": 8000,
    "blue-sky": 10000,
}


def lamps(tool):
    folder = tool.render("lamps.toml", "lamps")
    figures, strip = [], []
    for lamp, kelvin in LAMPS.items():
        png = tool.scratch / f"{lamp}.png"
        done = tool.json("develop", folder / "raw.dng", "-o", png, "--set", f"develop.white_balance={lamp}")
        # The daylight locus of the CIE is a fit, and the raw file's matrices are interpolated: the way from a white to
        # the camera's response and back is exact, but for the fixed point.
        figures.append(
            Figure(f"colour temperature of {lamp}, K", done["temperature_k"], kelvin, 4e-3 * kelvin, "CIE 15")
        )
        strip.append(cv2.imread(str(png)))
    rows = [numpy.hstack(strip[:5]), numpy.hstack(strip[5:])]
    cv2.imwrite(str(tool.picture("lamps.png")), numpy.vstack(rows))
    card = develop(tool, folder / "raw.dng", "white_balance=incandescent", "colour_model=lab")[6:20, 20:44].mean((0, 1))
    # Under the lamp whose name is given, a grey card is grey: below what eyes tell.
    figures.append(
        Figure("chroma of a grey card under incandescent light", float(numpy.hypot(card[1], card[2])), 0, 1, "")
    )
    return figures


ROWS = [
    Row(
        "Hue, saturation and value, lightness, intensity",
        "V = max, L = (max + min)/2, I = (R + G + B)/3",
        "photosite develop IMAGE -o hsv.npy --set develop.colour_model=hsv",
        hue_models,
    ),
    Row(
        "CIE XYZ and L*a*b*",
        "L* = 116·f(Y/Yₙ) − 16, a* = 500·(f(X/Xₙ) − f(Y/Yₙ)), b* = 200·(f(Y/Yₙ) − f(Z/Zₙ))",
        "photosite develop IMAGE -o lab.exr --set develop.colour_model=lab",
        cielab,
    ),
    Row(
        "Grey by luminance",
        "Y = 0.2126·R + 0.7152·G + 0.0722·B",
        "photosite develop IMAGE -o grey.pgm --set develop.colour_model=grey",
        grey,
    ),
    Row("Models in files", "", "photosite develop IMAGE -o lab.tiff --set develop.colour_model=lab", files),
    Row("White balance by lamp", "(u, v) of a blackbody or of daylight", "lamps.toml", lamps, "lamps.png"),
]
