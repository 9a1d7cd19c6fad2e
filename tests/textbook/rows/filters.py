"""Filters, thresholding and resizing, against OpenCV and Pillow."""

import math

import cv2
import numpy
from pictures import develop, largest, write_exr
from PIL import Image
from table import ROOT, Figure, Row

#: Single precision: sums of some dozen products of numbers up to 1.
SINGLE = 2e-6
BOX = ROOT / "scenes/cornell-box/picture.png"
RANDOM = numpy.random.default_rng(32)


def scene(colours=1):
    """Gradients, an edge, a disk and noise: 61 × 47 pixels."""
    y, x = numpy.mgrid[0:47, 0:61]
    shape = 0.1 + 0.004 * x + 0.4 * (x > 30) + 0.3 * ((x - 18) ** 2 + (y - 22) ** 2 < 90)
    planes = [shape * (1 - 0.2 * c) + RANDOM.normal(0, 0.03, shape.shape) for c in range(colours)]
    picture = numpy.stack(planes, 2) if colours > 1 else planes[0]
    return picture.astype("f4")


def filtered(tool, picture, *settings):
    return develop(tool, write_exr(tool.scratch / "in.exr", picture), *settings)


def integer_gaussian(tool):
    point = numpy.zeros((9, 9), "f4")
    point[4, 4] = 1
    gaussian = ["noise_filter=gaussian", "noise_radius_px=2", "noise_sigma_px=1"]
    window = filtered(tool, point, *gaussian)[2:7, 2:7]
    column = cv2.getGaussianKernel(5, 1)
    table = numpy.rint(window / window[0, 0])
    notes = [[1, 4, 7, 4, 1], [4, 20, 33, 20, 4], [7, 33, 55, 33, 7], [4, 20, 33, 20, 4], [1, 4, 7, 4, 1]]
    given = f"kernel={[[1, 4, 7, 4, 1], [4, 16, 26, 16, 4], [7, 26, 41, 26, 7], [4, 16, 26, 16, 4], [1, 4, 7, 4, 1]]}"
    rounded = filtered(tool, point, given, "kernel_normalised=true")[2:7, 2:7]
    return [
        Figure(
            "numbers that differ from getGaussianKernel(5, 1), largest",
            largest(window, column @ column.T),
            0,
            SINGLE,
            "OpenCV",
        ),
        Figure("over the smallest and rounded: sum of the table", float(table.sum()), 331, 0),
        Figure(
            "entries that differ from the table 1 4 7 4 1 / 4 20 33 20 4 / 7 33 55 33 7 …",
            float((table != notes).sum()),
            0,
            0,
        ),
        # Sampled at pixel centres here, integrated over pixels there.
        Figure("the common table of sum 273, given as a kernel, differs by", largest(window, rounded), 0, 0.013),
    ]


def gaussian(tool):
    figures = []
    for sigma, radius in [(1, 2), (0.6, 1), (2.5, 8)]:
        picture = scene()
        found = filtered(tool, picture, "noise_filter=gaussian", f"noise_radius_px={radius}", f"noise_sigma_px={sigma}")
        size = 2 * radius + 1
        expected = cv2.GaussianBlur(picture, (size, size), sigma, borderType=cv2.BORDER_REFLECT_101)
        figures.append(
            Figure(f"largest difference, {size} × {size}, σ = {sigma}", largest(found, expected), 0, SINGLE, "OpenCV")
        )
    return figures


def separability(tool):
    picture = scene()
    column = cv2.getGaussianKernel(7, 1.4)
    both = (column @ column.T).tolist()
    whole = filtered(tool, picture, f"kernel={both}")
    rows = filtered(tool, picture, f"kernel={column.T.tolist()}")
    columns = filtered(tool, rows, f"kernel={column.tolist()}")
    return [Figure("7 × 7 at once less 7 × 1 after 1 × 7, largest", largest(whole, columns), 0, SINGLE)]


def mean(tool):
    picture = scene()
    found = filtered(tool, picture, "noise_filter=mean", "noise_radius_px=2")
    noise = numpy.float32(0.5) + RANDOM.normal(0, 0.02, (256, 256)).astype("f4")
    smooth = filtered(tool, noise, "noise_filter=mean", "noise_radius_px=1")
    left = float(smooth.std() / noise.std())
    return [
        Figure(
            "largest difference, 5 × 5",
            largest(found, cv2.blur(picture, (5, 5), borderType=cv2.BORDER_REFLECT_101)),
            0,
            SINGLE,
            "OpenCV",
        ),
        # σ of nine neighbours over that of one; the standard deviation of 65 536/9 independent means is known to 0.8 %.
        Figure("noise left by 3 × 3, σ'/σ", left, 1 / 3, 0.01),
    ]


def median(tool):
    rate = 0.4
    draw = RANDOM.random((512, 512))
    noisy = numpy.where(draw < rate / 2, 0, numpy.where(draw < rate, 1, 0.5)).astype("f4")
    found = filtered(tool, noisy, "noise_filter=median", "noise_radius_px=1")
    expected = cv2.medianBlur(noisy, 3)
    q = rate / 2
    five = sum(math.comb(9, k) * q**k * (1 - q) ** (9 - k) for k in range(5, 10))
    inner = found[1:-1, 1:-1]
    blurred = filtered(tool, noisy, "noise_filter=mean", "noise_radius_px=1")
    cv2.imwrite(str(tool.picture("filters.png")), comparison(tool))
    return [
        Figure(
            "pixels within that differ from medianBlur", float((inner != expected[1:-1, 1:-1]).sum()), 0, 0, "OpenCV"
        ),
        # Four standard deviations of a count in which the 25 windows that overlap go together.
        Figure(
            "salt and pepper left of 40 %",
            float((inner != 0.5).mean()),
            2 * five,
            4 * math.sqrt(25 * 2 * five / inner.size),
        ),
        Figure("error of the mean filter, rms", float((blurred - 0.5).std()), 0.5 * math.sqrt(rate) / 3, 0.003),
    ]


def comparison(tool):
    """The Cornell box with salt and pepper on the left and Gaussian noise on the right, through four filters."""
    box = cv2.imread(str(BOX), cv2.IMREAD_GRAYSCALE)[120:330:2, 60:340:2] / 255
    draw = numpy.random.default_rng(1).random(box.shape)
    noisy = numpy.where(draw < 0.04, 0, numpy.where(draw > 0.96, 1, box))
    half = box.shape[1] // 2
    noisy[:, half:] = (box + numpy.random.default_rng(2).normal(0, 0.08, box.shape))[:, half:]
    source = write_exr(tool.scratch / "noisy.exr", noisy.clip(0, 1).astype("f4"))
    settings = [
        ["tone_curve=linear"],
        ["noise_filter=mean"],
        ["noise_filter=median"],
        ["noise_filter=bilateral", "noise_radius_px=4", "noise_sigma_px=2", "noise_sigma_range=0.2"],
    ]
    return numpy.hstack([(255 * develop(tool, source, *s).clip(0, 1) + 0.5).astype("u1") for s in settings])


def bilateral(tool):
    figures = []
    for colours, name in [(1, "grey"), (3, "colours")]:
        picture = scene(colours)
        found = filtered(
            tool,
            picture,
            "noise_filter=bilateral",
            "noise_radius_px=4",
            "noise_sigma_px=2",
            "noise_sigma_range=0.12",
        )
        expected = cv2.bilateralFilter(picture, 9, 0.12, 2, borderType=cv2.BORDER_REFLECT_101)
        # OpenCV takes the exponential from a table.
        figures.append(
            Figure(
                f"largest difference, d = 9, σ_s = 2, σ_r = 0.12, {name}", largest(found, expected), 0, 1e-5, "OpenCV"
            )
        )
    return figures


def kernels(tool):
    figures = []
    for name, kernel in [
        ("Sobel", [[-1, 0, 1], [-2, 0, 2], [-1, 0, 1]]),
        ("Laplace", [[0, 1, 0], [1, -4, 1], [0, 1, 0]]),
        ("of no symmetry", [[0.1, 0.2, 0, 0.3, -0.1], [0.5, 1, -2, 0.25, 0], [0, 0.3, 0.2, 0.1, 0.4]]),
    ]:
        picture = scene(3)
        found = filtered(tool, picture, f"kernel={kernel}")
        expected = cv2.filter2D(picture, -1, numpy.array(kernel, "f4"), borderType=cv2.BORDER_REFLECT_101)
        figures.append(Figure(f"largest difference, {name}", largest(found, expected), 0, 2 * SINGLE, "OpenCV"))
    return figures


def thresholds(tool):
    picture = scene()
    level = filtered(tool, picture, "threshold=level", "threshold_level=0.45")
    _, expected = cv2.threshold(picture, 0.45, 1, cv2.THRESH_BINARY)
    codes = (picture.clip(0, 1) * 255 + 0.5).astype("u1")
    _, parted = cv2.threshold(codes, 0, 1, cv2.THRESH_BINARY | cv2.THRESH_OTSU)
    otsu = filtered(tool, codes.astype("f4") / 255, "threshold=otsu")
    return [
        Figure("pixels that differ at the level 0.45", float((level != expected).sum()), 0, 0, "OpenCV"),
        Figure("pixels that differ by Otsu's level", float((otsu != parted).sum()), 0, 0, "OpenCV"),
    ]


def resizing(tool):
    figures = []
    picture = scene(3)
    filters = {
        "nearest": cv2.INTER_NEAREST_EXACT,
        "linear": cv2.INTER_LINEAR,
        "cubic": cv2.INTER_CUBIC,
        "lanczos": cv2.INTER_LANCZOS4,
    }
    for name, number in filters.items():
        apart = 0
        for size in [(150, 101), (61, 47), (23, 31)]:
            found = filtered(
                tool, picture, f"resize_px={list(size)}", f"resize_filter={name}", "resize_antialias=false"
            )
            apart = max(apart, largest(found, cv2.resize(picture, size, interpolation=number)))
        figures.append(Figure(f"largest difference, {name}, larger and smaller", apart, 0, 5e-6, "OpenCV"))
    grey = scene()
    smaller = filtered(tool, grey, "resize_px=[20, 16]", "resize_filter=linear")
    expected = numpy.asarray(Image.fromarray(grey).resize((20, 16), Image.Resampling.BILINEAR))
    figures.append(
        Figure(
            "largest difference within, linear with antialiasing",
            largest(smaller[2:-2, 2:-2], expected[2:-2, 2:-2]),
            0,
            5e-6,
            "Pillow",
        )
    )
    ramp = numpy.tile(numpy.arange(64, dtype="f4") / 64, (48, 1))
    zoomed = filtered(tool, ramp, "digital_zoom=2", "resize_filter=linear")
    figures.append(
        Figure(
            "slope of a ramp at a digital zoom of 2, over that before",
            float((zoomed[20, 40] - zoomed[20, 20]) * 64 / 20),
            0.5,
            1e-5,
        )
    )
    return figures


ROWS = [
    Row(
        "Gaussian kernel in integers",
        "G(i, j) = e^−(i² + j²)/(2σ²), 5 × 5, σ = 1",
        "photosite develop IMAGE --set develop.noise_filter=gaussian --set develop.noise_radius_px=2 --set develop.noise_sigma_px=1",
        integer_gaussian,
    ),
    Row("Gaussian filter", "I_G = I ∗ G", "photosite develop IMAGE --set develop.noise_filter=gaussian", gaussian),
    Row(
        "Separability", "I ∗ G = (I ∗ g_x) ∗ g_y", "photosite develop IMAGE --set develop.kernel=[[…]]", separability
    ),
    Row("Mean filter", "A = 1/m² · 1, σ' = σ/m", "photosite develop IMAGE --set develop.noise_filter=mean", mean),
    Row(
        "Median filter and salt and pepper",
        "P = 2·Σ_{k≥5} C(9, k)·qᵏ·(1 − q)⁹⁻ᵏ",
        "photosite develop IMAGE --set develop.noise_filter=median",
        median,
        "filters.png",
    ),
    Row(
        "Bilateral filter",
        "w = e^−|Δ|²/(2σ_s²) · e^−d²/(2σ_r²)",
        "photosite develop IMAGE --set develop.noise_filter=bilateral --set develop.noise_sigma_range=0.12",
        bilateral,
    ),
    Row(
        "Any kernel",
        "f(x, y) = Σ k(i, j)·I(x + i, y + j)",
        "photosite develop IMAGE --set develop.kernel=[[-1,0,1],[-2,0,2],[-1,0,1]]",
        kernels,
    ),
    Row("Thresholding", "B = 1 where I > t", "photosite develop IMAGE --set develop.threshold=otsu", thresholds),
    Row(
        "Resizing, digital zoom",
        "s = (i + ½)·d − ½",
        "photosite develop IMAGE --set develop.resize_px=[640,480] --set develop.resize_filter=lanczos",
        resizing,
    ),
]
