"""The figures that a photographer asks, by the formulas of the notes, and exiftool's own."""

import json
import math
import subprocess

from table import Figure, Row

F, N, U, PITCH, WIDTH = 0.05, 4, 2, 10e-6, 192
V = U * F / (U - F)
#: The default, of the diagonal.
C = WIDTH * PITCH * math.sqrt(2) / 1440


def info(tool, *overrides):
    folder = tool.render("point.toml", "info", "render.samples_per_pixel=1", *overrides)
    report = tool.report(folder)
    return folder, report, report["lens"]["figures"]


def depth_of_field(tool):
    figures = []
    for c in (C, 30e-6):
        _, _, found = info(tool, f"lens.circle_of_confusion_um={c * 1e6}")
        h = F * F / (N * c) + F
        near, far = U * (h - F) / (h + U - 2 * F), U * (h - F) / (h - U)
        name = f"c = {c * 1e6:.3g} µm"
        figures += [
            Figure(f"{name}: near limit, m", found["depth_of_field_m"][0], near, 1e-9),
            Figure(f"{name}: far limit, m", found["depth_of_field_m"][1], far, 1e-9),
            Figure(f"{name}: hyperfocal distance, m", found["hyperfocal_m"], h, 1e-9),
        ]
    return figures


def by_exiftool(tool):
    """exiftool leaves out + f, and takes the circle of confusion of the sensor's diagonal over 1440."""
    folder, _, found = info(tool)
    tags = ["-HyperfocalDistance", "-CircleOfConfusion"]
    printed = subprocess.run(["exiftool", "-n", "-j", *tags, folder / "raw.dng"], capture_output=True, text=True, check=True)
    exif = json.loads(printed.stdout)[0]
    return [
        Figure("hyperfocal distance − f, m", found["hyperfocal_m"] - F, float(exif["HyperfocalDistance"]), 1e-4, "exiftool"),
        Figure(
            "circle of confusion, µm", found["circle_of_confusion_um"], float(exif["CircleOfConfusion"]) * 1e3, 1e-6, "exiftool"
        ),
    ]


def view(tool):
    _, report, found = info(tool)
    size = WIDTH * PITCH
    angle = lambda s: math.degrees(2 * math.atan(s / 2 / V))
    return [
        Figure("angle of view across, °", found["angle_of_view_deg"][0], angle(size), 1e-9),
        Figure("angle of view down, °", found["angle_of_view_deg"][1], angle(size), 1e-9),
        Figure("angle of view of the diagonal, °", found["angle_of_view_deg"][2], angle(size * math.sqrt(2)), 1e-9),
        Figure("field at the focus distance, m", found["field_at_focus_m"][0], size * U / V, 1e-12),
        Figure("scale of the image", found["magnification"], V / U, 1e-12),
        Figure("a pixel at the focus distance, mm", found["pixel_at_focus_mm"][0], 1e3 * PITCH * U / V, 1e-12),
        Figure("pixel pitch, µm", report["sensor"]["pixel_pitch_um"][0], 10, 1e-9),
    ]


def opening(tool):
    _, report, found = info(tool)
    time = report["exposure"]["time_s"]
    return [
        Figure("entrance pupil, mm", found["entrance_pupil_mm"], 1e3 * F / N, 1e-12),
        Figure("exposure value", report["exposure"]["exposure_value"], math.log2(N * N / time), 1e-12),
        Figure("diffraction spot, µm", found["diffraction_spot_um"], 2.44 * 0.55 * N * V / F, 1e-9),
        Figure("diffraction spot, px", found["diffraction_spot_px"], 2.44 * 0.55e-6 * N * V / F / PITCH, 1e-9),
    ]


ROWS = [
    Row(
        "Depth of field",
        "H = f²/(N·c) + f; near = u·(H − f)/(H + u − 2f), far = u·(H − f)/(H − u)",
        "point.toml",
        depth_of_field,
    ),
    Row("Hyperfocal distance of our DNG", "H − f = f²/(N·c), c = diagonal/1440", "point.toml", by_exiftool),
    Row("Angle of view and scale", "α = 2·atan(s/2v), m = v/u", "point.toml", view),
    Row("Opening", "D = f/N, EV = log₂(N²/t), d = 2.44·λ·v/D", "point.toml", opening),
]
