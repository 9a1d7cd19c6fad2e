#!/usr/bin/env python3
"""OpenCV's block matching finds the depth of a scene that a projector throws dots on:

    active_stereo.py PHOTOSITE [--folder DIR]

Two cameras side by side, 60 mm apart, take images of grey bodies before a slanting wall, which have no pattern of their
own. Between them stands a projector with a slide of dots at random. Ground truth must fulfil z = b·f/d to 0.02 px at every
pixel. Where both cameras see the surface, StereoSGBM must find its disparity, and with it its depth, to its own resolution:
what it finds of a slanting plane whose images are drawn without photosite. (Its numbers are sixteenths of a pixel, but it
favours whole pixels, so that it resolves a seventh.)
"""

import argparse
import json
import subprocess
import tempfile
from pathlib import Path

import cv2
import numpy as np

SIZE = (640, 480)
FOCAL_PX = 800.0
BASELINE_M = 0.06
# Disparities that are searched for, and the window that is compared, px.
FIRST, SEARCHED, WINDOW = 16, 64, 9
# The slide: how many dots, which part of them shines, how wide all are, and with that how wide one is in the images.
DOTS, DOT_SHARE, SLIDE_DEG = (240, 180), 0.4, 50
DOT_PX = FOCAL_PX * 2 * np.tan(np.radians(SLIDE_DEG / 2)) / DOTS[0]

CAPTURE = """
[scene]
geometry = ["bodies.obj"]

[[lights]]
type = "projector"
image = "dots.png"
position_m = [0, 0.02, 0]
look_at_m = [0, 0, -1]
horizontal_fov_deg = %d
flux_lm = 60

[materials]
grey = { type = "diffuse", reflectance = 0.6 }

[camera]
position_m = [0, 0, 0]
look_at_m = [0, 0, -1]

[lens]
type = "thin"
f_number = 8.0
focal_length_mm = 4.688
focus_distance_m = 1.0
intrinsics = { fx = 800.0, fy = 800.0, cx = 320.0, cy = 240.0 }

[sensor]
preset = "sony-imx249-mono"
resolution_px = [640, 480]

[exposure]
time_s = 0.02

[render]
samples_per_pixel = 32
max_depth = 3

[output]
raw = ["npy"]
truth = ["depth", "disparity"]
truth_formats = ["npy"]
"""

DATASET = """
capture = "capture.toml"

[[cameras]]
name = "left"
position_m = [-0.03, 0, 0]
disparity_to = "right"

[[cameras]]
name = "right"
position_m = [0.03, 0, 0]
disparity_to = "left"
"""


def bodies():
    """A slanting wall, a ball and a box, as OBJ."""
    lines = ["usemtl grey"]
    corners = [(-1.2, -1.0, -1.0), (1.2, -1.0, -1.4), (1.2, 1.0, -1.4), (-1.2, 1.0, -1.0)]
    lines += [f"v {x} {y} {z}" for x, y, z in corners] + ["f 1 2 3 4"]
    count = len(corners)
    rows, columns, radius, centre = 32, 64, 0.13, np.array([-0.16, 0.02, -0.85])
    for i in range(rows + 1):
        for j in range(columns):
            a, b = np.pi * i / rows, 2 * np.pi * j / columns
            x, y, z = centre + radius * np.array([np.sin(a) * np.cos(b), np.cos(a), np.sin(a) * np.sin(b)])
            lines.append(f"v {x:.7f} {y:.7f} {z:.7f}")
    for i in range(rows):
        for j in range(columns):
            a, b = (count + 1 + i * columns + k % columns for k in (j, j + 1))
            if i > 0:
                lines.append(f"f {a} {b} {b + columns}")
            if i < rows - 1:
                lines.append(f"f {a} {b + columns} {a + columns}")
    count += (rows + 1) * columns
    for i in range(8):
        turned = np.array([0.1 * (2 * (i & 1) - 1), 0.1 * (2 * (i >> 1 & 1) - 1), 0.1 * (2 * (i >> 2 & 1) - 1)])
        cos, sin = np.cos(0.6), np.sin(0.6)
        x, y, z = turned[0] * cos + turned[2] * sin + 0.17, turned[1] - 0.04, turned[2] * cos - turned[0] * sin - 0.95
        lines.append(f"v {x:.7f} {y:.7f} {z:.7f}")
    for face in [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]:
        lines.append("f " + " ".join(str(count + 1 + corner) for corner in face))
    return "\n".join(lines) + "\n"


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("photosite", type=Path)
    parser.add_argument("--folder", type=Path, help="keep the images here")
    arguments = parser.parse_args()
    folder = arguments.folder or Path(tempfile.mkdtemp())
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "bodies.obj").write_text(bodies())
    (folder / "capture.toml").write_text(CAPTURE % SLIDE_DEG)
    (folder / "pair.toml").write_text(DATASET)
    dots = (np.random.default_rng(1).random(DOTS[::-1]) < DOT_SHARE).astype(np.uint8) * 255
    cv2.imwrite(str(folder / "dots.png"), cv2.resize(dots, None, fx=4, fy=4, interpolation=cv2.INTER_NEAREST))
    subprocess.run([arguments.photosite.resolve(), "dataset", "pair.toml", "-o", "pair", "--quiet"], cwd=folder, check=True)

    pictures, layers = {}, {}
    for camera in ("left", "right"):
        made = folder / "pair" / camera / "000000"
        report = json.loads((made / "capture.json").read_text())
        signal = np.load(made / "raw.npy").astype(float) - report["sensor"]["black_level_dn"]
        pictures[camera] = np.clip(signal / np.percentile(signal, 99) * 240, 0, 255).round().astype(np.uint8)
        cv2.imwrite(str(folder / f"{camera}.png"), pictures[camera])
        layers[camera] = {layer: np.load(made / f"truth-{layer}.npy") for layer in ("depth", "disparity")}
    depth = np.squeeze(layers["left"]["depth"])
    disparity, across, visible = np.moveaxis(layers["left"]["disparity"], -1, 0)

    seen = np.isfinite(depth)
    error = np.abs(FOCAL_PX * BASELINE_M / depth[seen] - disparity[seen]).max()
    within("truth", z_is_bf_over_d_px=(error, 0.02), across_px=(np.abs(across[seen]).max(), 0.02))

    # Left of it nothing is searched for; windows that reach over the border see less than the others.
    inner = np.zeros_like(seen)
    inner[WINDOW:-WINDOW, FIRST + SEARCHED + WINDOW : -WINDOW] = True
    both = inner & seen & (visible == 1)
    found = match(pictures["left"], pictures["right"])
    matched = both & (found >= FIRST)
    wrong = np.abs(found - disparity)[matched]
    resolution = resolution_px(inner)
    depths = FOCAL_PX * BASELINE_M / found[matched]
    of_depth = depth[matched] ** 2 / (FOCAL_PX * BASELINE_M) * resolution
    print(f"StereoSGBM resolves {resolution:.4f} px of a slanting plane drawn by numpy")
    within("StereoSGBM", not_found_percent=(100 * (1 - matched.sum() / both.sum()), 2),
           beyond_a_pixel_percent=(100 * (wrong > 1).mean(), 2),
           disparity_resolutions=(np.median(wrong) / resolution, 1),
           depth_resolutions=(np.median(np.abs(depths - depth[matched]) / of_depth), 1))


def match(left, right):
    """Disparities, px."""
    matcher = cv2.StereoSGBM_create(minDisparity=FIRST, numDisparities=SEARCHED, blockSize=WINDOW, P1=8 * WINDOW**2,
                                    P2=32 * WINDOW**2, disp12MaxDiff=1, uniquenessRatio=5, mode=cv2.STEREO_SGBM_MODE_HH)
    return matcher.compute(left, right) / 16


def resolution_px(inner):
    """The median error that the matcher itself makes of dots as large as ours: on a plane that slants as the wall does, whose
    images are drawn without photosite, each pixel the mean of 16 × 16 points."""
    fine, (width, height) = 16, SIZE
    random = np.random.default_rng(2)
    dots = np.where(random.random((int(height / DOT_PX) + 2, int(2 * width / DOT_PX) + 2)) < DOT_SHARE, 1.0, 0.02)
    x, y = ((np.arange(count * fine) + 0.5) / fine for count in SIZE)
    first, slope = 42.0, -0.01

    def picture(at):
        points = dots[(y / DOT_PX).astype(int)][:, (at / DOT_PX).astype(int)]
        level = points.reshape(height, fine, width, fine).mean(axis=(1, 3)) * 100
        # About as many electrons as the images have.
        return (random.poisson(level * 20) / 20).round().astype(np.uint8)

    # What is at x in the left image is at x - first - slope x in the right one.
    found = match(picture(x), picture((x + first) / (1 - slope)))
    true = first + slope * (np.arange(width) + 0.5)
    return np.median(np.abs(found - true)[inner & (found >= FIRST)])


def within(name, **figures):
    """Prints figures with their limits, and fails where one exceeds it."""
    print(f"{name}: " + ", ".join(f"{figure} {value:.5g} (≤ {limit})" for figure, (value, limit) in figures.items()))
    for figure, (value, limit) in figures.items():
        assert value <= limit, f"{name}: {figure}"


if __name__ == "__main__":
    main()
