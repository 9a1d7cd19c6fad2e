"""Lenses: holes, thin lenses, what stands before them, and how they are focused."""

import numpy as np
from PIL import Image
from scipy.signal import fftconvolve
from scipy.special import j1

from table import FOLDER, Figure, Row

#: The lamp of lamp.obj, mm, and its distance, m.
LAMP_MM, LAMP_M = 4, 2
PITCH_MM = 0.01
#: Schott's data sheet of N-BK7.
BK7_B, BK7_C = [1.03961212, 0.231792344, 1.01046945], [0.00600069867, 0.0200179144, 103.560653]


def electrons(tool, folder):
    """The mean electrons of a folder, and the standard deviation that light transport leaves in their sum."""
    planes = tool.planes(folder / "electrons.exr")
    return planes["Y"].astype(float), float(planes["variance.Y"].sum()) ** 0.5


def width_px(picture):
    """Root mean square distance from the middle, of x and y in the mean."""
    x = np.arange(picture.shape[0]) - (picture.shape[0] - 1) / 2
    return (((picture * x**2).sum() + (picture * x[:, None] ** 2).sum()) / 2 / picture.sum()) ** 0.5


def spot_px(blur_mm, lamp_mm):
    """The same of a disk of a diameter, spread over a square of a side and over pixels: variances add."""
    return ((blur_mm / PITCH_MM) ** 2 / 16 + (lamp_mm / PITCH_MM) ** 2 / 12 + 1 / 12) ** 0.5


def of_width(what, found, blur_mm, lamp_mm, part=0.01):
    expected = spot_px(blur_mm, lamp_mm)
    return Figure(what, width_px(found), expected, part * expected)


def index_of_bk7(lambda_nm):
    squared = (lambda_nm * 1e-3) ** 2
    return (1 + sum(b * squared / (squared - c) for b, c in zip(BK7_B, BK7_C))) ** 0.5


def power(n, r1, r2, d):
    """Lensmaker's equation, 1/mm."""
    return (n - 1) * (1 / r1 - 1 / r2 + (n - 1) * d / (n * r1 * r2))


def hole(tool):
    wide, noise = electrons(tool, tool.render("hole.toml", "wide"))
    narrow, _ = electrons(tool, tool.render("hole.toml", "narrow", "lens.diameter_mm=0.25"))
    scale = 50 / (1000 * LAMP_M)
    ratio = wide.sum() / narrow.sum()
    return [
        of_width("width of the spot, 0.5 mm, px", wide, 0.5 * (1 + scale), LAMP_MM * scale),
        of_width("width of the spot, 0.25 mm, px", narrow, 0.25 * (1 + scale), LAMP_MM * scale),
        Figure("light through 0.5 mm over that through 0.25 mm", ratio, 4, 3 * 2**0.5 * 4 * noise / wide.sum()),
    ]


def diffraction(tool):
    """Of the spot, what lies within the first dark ring of the diffraction alone."""
    overrides = ["lens.diameter_mm=0.1", "sensor.resolution_px=[512, 512]", "render.samples_per_pixel=256"]
    plain, _ = electrons(tool, tool.render("hole.toml", "plain", *overrides))
    spread, noise = electrons(tool, tool.render("hole.toml", "spread", *overrides, "lens.psf.kind=airy"))
    shown = (spread / spread.max()) ** 0.4 * 255
    Image.fromarray(shown[128:384, 128:384].astype(np.uint8)).save(tool.picture("airy.png"))
    n, fine = 768, 2
    r = np.hypot(*(np.mgrid[: n * fine, : n * fine] - (n * fine - 1) / 2)) * PITCH_MM / fine
    x = np.pi * 0.1 * r / (550e-6 * 50)
    airy = (2 * j1(x) / x) ** 2
    # Within the rings that the grid holds; what lies outside is 2/(πx) of all.
    airy *= (np.pi * 0.1 / (550e-6 * 50)) ** 2 / (4 * np.pi) * (PITCH_MM / fine) ** 2
    sharp = (r <= 0.1 * (1 + 0.025) / 2).astype(float)
    square = np.ones((20 * fine // 2,) * 2)
    kernel = fftconvolve(sharp / sharp.sum(), square / square.sum(), mode="same")
    blurred = fftconvolve(airy, kernel, mode="same")
    ring = 1.22 * 550e-6 * 50 / 0.1
    expected = blurred[r <= ring].sum()
    here = np.hypot(*(np.mgrid[:512, :512] - 255.5)) * PITCH_MM <= ring
    return [Figure("part of the light within the first dark ring", spread[here].sum() / plain.sum(), expected, 0.005)]


def thin_lens(tool):
    lens = tool.report(tool.render("point.toml", "thin", "render.samples_per_pixel=1"))["lens"]
    u, f = 2000, 50
    return [Figure("distance of the sensor, mm", lens["image_distance_mm"], u * f / (u - f), 1e-9)]


def out_of_focus(tool):
    """A lamp at 2 m, focused on 1 m."""
    f, n, u = 50, 4, 1000
    v = u * f / (u - f)
    blur = f / n * v * abs(1 / u - 1 / (1000 * LAMP_M))
    found, _ = electrons(tool, tool.render("point.toml", "blurred", "lens.focus_distance_m=1"))
    return [of_width("width of the spot, px", found, blur, LAMP_MM * v / (1000 * LAMP_M))]


def lensmaker(tool):
    p_d = power(index_of_bk7(587.5618), 50, -52, 4)
    v = 1 / (p_d - 1 / (1000 * LAMP_M))
    diameter = 1 / p_d / 4
    figures = []
    for nm in [450, 550, 650]:
        source = f'materials.lamp.emission.spectrum={{ file = "{FOLDER}/line-{nm}.csv" }}'
        folder = tool.render("lensmaker.toml", str(nm), source)
        if not figures:
            lens = tool.report(folder)["lens"]
            figures.append(Figure("f at 587.6 nm, mm", lens["focal_length_mm"], 1 / p_d, 1e-6))
        found, _ = electrons(tool, folder)
        blur = diameter * v * abs(power(index_of_bk7(nm), 50, -52, 4) - p_d)
        figures.append(of_width(f"width of the spot at {nm} nm, px", found, blur, LAMP_MM * v / (1000 * LAMP_M)))
    return figures


def diverging(tool):
    found, _ = electrons(tool, tool.render("diverging.toml", "diverging"))
    blur = 50 * abs(1 / -200 - 1 / 50 - 1 / (1000 * LAMP_M))
    return [of_width("width of the spot, px", found, blur, LAMP_MM * 50 / (1000 * LAMP_M))]


def close_up(tool):
    """The lamp brought to where it is sharp: half a metre before the close-up lens, of which the main lens sees an entrance
    pupil behind it."""
    pupil = 0.020 / (1 - 0.020 * 2)
    distance = 0.5 + pupil
    folder = tool.render("close-up.toml", "sharp", f"camera.position_m=[0, 0, {distance - LAMP_M}]", "camera.look_at_m=[0, 0, -9]")
    lens = tool.report(folder)["lens"]
    found, _ = electrons(tool, folder)
    return [
        Figure("in focus, m before the close-up lens", lens["focus_distance_m"] - pupil, 0.5, 1e-9),
        of_width("width of the lamp's image, px", found, 0, LAMP_MM * 50 / 500, 0.005),
    ]


def minimum_focus(tool):
    changes = ["lens.min_focus_distance_m=1.2", "lens.autofocus.method=exact", "render.samples_per_pixel=1"]
    lens = tool.report(tool.render("autofocus.toml", "near", *changes))["lens"]
    return [Figure("focused on a star at 0.8 m, m", lens["focus_distance_m"], 1.2, 1e-12)]


def autofocus(tool):
    folder = tool.render("autofocus.toml", "contrast")
    Image.open(folder / "image.png").convert("L").quantize(16).save(tool.picture("autofocus.png"))
    contrast = tool.report(folder)["lens"]
    exact = tool.report(tool.render("autofocus.toml", "exact", "lens.autofocus.method=exact"))["lens"]
    u, f, n = 0.8, 0.025, 2
    v = u * f / (u - f)
    # A blur of a pixel.
    pixel = 6e-6 / (f / n * v)
    return [
        Figure("by contrast, 1/u, 1/m", 1 / contrast["focus_distance_m"], 1 / u, pixel),
        Figure("exactly, u, m", exact["focus_distance_m"], u, 1e-6),
    ]


def bare(tool):
    """Under the same light from everywhere, E = π·L, where behind a lens E = π·L·sin²θ' with tan θ' = 1/2N."""
    without, _ = electrons(tool, tool.render("bare.toml", "without"))
    lens = ["lens.type=thin", "lens.f_number=4", 'lens.focus_distance_m="infinity"']
    behind, _ = electrons(tool, tool.render("bare.toml", "behind", *lens))
    middle = np.s_[15:17, 15:17]
    ratio = without.mean() / behind[middle].mean()
    return [Figure("light without a lens over that at f/4", ratio, 1 + 4 * 4**2, 0.1)]


def falloff(tool):
    picture, _ = electrons(tool, tool.render("falloff.toml", "wide"))
    Image.fromarray((picture[::6, ::6] / picture.max() * 255).astype(np.uint8)).save(tool.picture("falloff.png"))
    height, width = picture.shape
    corner = picture[:8, :8].mean() / picture[height // 2 - 4 : height // 2 + 4, width // 2 - 4 : width // 2 + 4].mean()
    x, y = [(n / 2 - 4) * 5.86e-3 for n in (width, height)]
    cos = 4 / (16 + x * x + y * y) ** 0.5
    return [Figure("light at the corner over that in the middle", corner, cos**4, 0.002)]


def zoom(tool):
    path = tool.scratch / "zoom.toml"
    path.write_text(
        f"""capture = "{FOLDER}/point.toml"
[poses.trajectory]
frame_rate_hz = 2
moving = false
poses = [
    {{ time_s = 0, position_m = [0, 0, 0], look_at_m = [0, 0, -1], focal_length_mm = 25 }},
    {{ time_s = 1, position_m = [0, 0, -1], look_at_m = [0, 0, -2], focal_length_mm = 50 }},
]
"""
    )
    tool.run("dataset", path, "-o", "zoom", "--quiet", "--set", "lens.focus_distance_m=2", "--set", "render.samples_per_pixel=1")
    lengths = [tool.report(tool.scratch / f"zoom/camera/00000{i}")["lens"]["focal_length_mm"] for i in range(3)]
    return [Figure(f"f of frame {i}, mm", found, 25 + 12.5 * i, 1e-9) for i, found in enumerate(lengths)]


ROWS = [
    Row("Pinhole camera of a finite hole", "blur = D·(1 + v/Z), light ∝ D²", "hole.toml", hole),
    Row("Diffraction at the hole", "I = (2·J₁(x)/x)², x = π·D·r/(λ·v)", "hole.toml", diffraction, "airy.png"),
    Row("Thin lens", "1/f = 1/u + 1/v", "point.toml", thin_lens),
    Row("Out of focus", "c = D·v·|1/u − 1/u′|", "point.toml", out_of_focus),
    Row(
        "Lensmaker's equation, longitudinal colour",
        "1/f = (n−1)·(1/R₁ − 1/R₂ + (n−1)·d/(n·R₁·R₂)), n = n(λ)",
        "lensmaker.toml",
        lensmaker,
    ),
    Row("Diverging lens", "c = D·v·|1/f − 1/v − 1/Z|, f < 0", "diverging.toml", diverging),
    Row("Close-up lens", "in focus at 1/P before it, magnified f·P", "close-up.toml", close_up),
    Row("Nearest focus", "u ≥ u_min", "autofocus.toml", minimum_focus),
    Row("Autofocus by contrast", "max Σ|∇g|²", "autofocus.toml", autofocus, "autofocus.png"),
    Row("Bare sensor", "E = ∫ L·cosθ dΩ = π·L", "bare.toml", bare),
    Row("Falloff of a lens", "E = L·π/4·(D/v)²·cos⁴α", "falloff.toml", falloff, "falloff.png"),
    Row("Zoom along a trajectory", "f = f(t)", "photosite dataset", zoom),
]
