"""Files: written by hand and read here, and written here and read by OpenCV, Pillow and NumPy."""

import cv2
import numpy
from PIL import Image
from pictures import develop, largest, write_exr
from table import Figure, Row

COMMENTED = "{}\n# by hand # twice\n5 # columns\n#\n 3\n"


def netpbm(kind, numbers, maximum):
    """An image of 5 × 3 pixels with comments in its header."""
    header = COMMENTED.format(kind).encode()
    if kind == "P4":
        return header + numpy.packbits(numbers == 0, axis=1).tobytes()
    if kind == "P1":
        return header + " ".join(str(int(n == 0)) for n in numbers.ravel()).encode()
    header += f"# the largest\n{maximum}\n".encode()
    if kind in ("P2", "P3"):
        return header + " ".join(map(str, numbers.ravel())).encode()
    return header + numbers.astype(">u2" if maximum > 255 else "u1").tobytes()


def read_netpbm(tool):
    figures = []
    random = numpy.random.default_rng(5)
    for kind in ["P1", "P2", "P3", "P4", "P5", "P6"]:
        apart = 0
        for maximum in [1] if kind in ("P1", "P4") else [1, 7, 255, 256, 1000, 65535]:
            shape = (3, 5, 3) if kind in ("P3", "P6") else (3, 5)
            numbers = random.integers(0, maximum + 1, shape)
            path = tool.scratch / "picture.pnm"
            path.write_bytes(netpbm(kind, numbers, maximum))
            apart = max(apart, largest(develop(tool, path), numbers / maximum))
        figures.append(Figure(f"{kind} with comments, largest difference over all maxima", apart, 0, 1e-7))
    return figures


def picture(tool, colours=3):
    values = numpy.random.default_rng(3).random((20, 30, colours)).astype("f4")
    return values, write_exr(tool.scratch / "in.exr", values if colours == 3 else values[..., 0])


def written(tool):
    figures = []
    for extension, colours in [("ppm", 3), ("pgm", 1), ("png", 3), ("tiff", 3)]:
        values, path = picture(tool, colours)
        for bits in [8, 16]:
            file = develop(tool, path, "tone_curve=linear", f"bits={bits}", output=f"out.{extension}")
            read = cv2.imread(str(file), cv2.IMREAD_UNCHANGED | cv2.IMREAD_ANYDEPTH | cv2.IMREAD_ANYCOLOR)
            read = read[..., ::-1] if colours == 3 else read[..., None]
            expected = numpy.rint(values * (2**bits - 1))
            figures.append(
                Figure(
                    f"{extension.upper()} of {bits} bits, codes that differ by more than rounding",
                    float((numpy.abs(read - expected) > 1).sum()),
                    0,
                    0,
                    "OpenCV",
                )
            )
    values, path = picture(tool)
    array = develop(tool, path)
    figures.append(Figure("NPY, largest difference", largest(array, values), 0, 0, "NumPy"))
    return figures


#: Row 1 of the luminance table of ITU-T T.81, annex K.
ANNEX_K = numpy.array([16, 11, 10, 16, 24, 40, 51, 61])


def jpeg(tool):
    _, path = picture(tool)
    figures = []
    for quality in [10, 50, 95]:
        file = develop(tool, path, f"jpeg_quality={quality}", output="out.jpg")
        scale = 5000 / quality if quality < 50 else 200 - 2 * quality
        expected = ((ANNEX_K * scale + 50) // 100).clip(1, 255)
        found = Image.open(file).quantization[0][:8]
        figures.append(
            Figure(
                f"quality {quality}: first row of steps, largest difference", largest(found, expected), 0, 0, "Pillow"
            )
        )
    return figures


def density(tool):
    values = numpy.random.default_rng(3).random((20, 30)).astype("f4")
    path = write_exr(tool.scratch / "wide.exr", values, aspect=1.25)
    file = develop(tool, path, "square_pixels=false", output="wide.png")
    columns, rows = Image.open(file).info["aspect"]
    square = develop(tool, file, output="square.png")
    return [
        Figure("rows over columns along equal lengths (pHYs)", rows / columns, 1.25, 1e-6, "Pillow"),
        Figure("columns of square pixels of 30 that are 1.25 wide", float(Image.open(square).size[0]), 38, 0, "Pillow"),
    ]


ROWS = [
    Row("PBM, PGM and PPM", "P1–P6, maximum 1–65535", "photosite develop IMAGE.pgm -o image.npy", read_netpbm),
    Row("Images for other programs", "", "photosite develop IMAGE -o image.png", written),
    Row(
        "Quality of JPEG",
        "S = 5000/q below 50, else 200 − 2q",
        "photosite develop IMAGE -o image.jpg --set develop.jpeg_quality=50",
        jpeg,
    ),
    Row(
        "Shape of pixels in PNG",
        "pHYs",
        "photosite develop IMAGE -o image.png --set develop.square_pixels=false",
        density,
    ),
]
