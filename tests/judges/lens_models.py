"""Judges lens models by OpenCV: `photosite project` against cv2.projectPoints, cv2.fisheye and cv2.omnidir.

Usage: lens_models.py PHOTOSITE

Points drawn at random within the picture and grids of coefficients; both directions agree to 1e-6 px.
"""

import itertools
import subprocess
import sys
import tempfile
from pathlib import Path

import cv2
import numpy as np

TOLERANCE_PX = 1e-6
SIZE = (1280, 960)
K = np.array([[1000.0, 2.5, 651.3], [0.0, 1003.0, 472.8], [0.0, 0.0, 1.0]])


def run(photosite, lens, points, *options):
    with tempfile.TemporaryDirectory() as folder:
        capture = Path(folder, "capture.toml")
        capture.write_text(
            "[camera]\nposition_m = [0, 0, 0]\nlook_at_m = [0, 0, -1]\n"
            f"[lens]\nfocus_distance_m = 'infinity'\n{lens}\n"
            f"intrinsics = {{ fx = {K[0, 0]}, fy = {K[1, 1]}, cx = {K[0, 2]}, cy = {K[1, 2]}, skew = {K[0, 1]} }}\n"
            f"[sensor]\nresolution_px = {list(SIZE)}\n".replace("'", '"')
        )
        file = Path(folder, "points.csv")
        file.write_text("\n".join(",".join(map(repr, map(float, point))) for point in points))
        command = [photosite, "project", capture, "--points", file, "--camera-space", *options]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        if done.returncode:
            sys.exit(done.stderr)
        return np.array([[float(x) for x in line.split(",")] for line in done.stdout.split()])


def check(photosite, what, lens, project):
    """`project` is OpenCV's, from points in camera space to pixels."""
    rng = np.random.default_rng(7)
    pixels = rng.uniform((-0.5, -0.5), np.array(SIZE) - 0.5, (500, 2))
    directions = run(photosite, lens, pixels, "--inverse")
    if not np.isfinite(directions).all():
        sys.exit(f"{what}: {np.isnan(directions).any(1).sum()} pixels see nothing")
    points = directions * rng.uniform(0.5, 20, (len(pixels), 1))
    # OpenCV takes what photosite says a pixel sees back to the pixel; then both go forward.
    back = project(points)
    forward = run(photosite, lens, points)
    error = max(np.abs(back - pixels).max(), np.abs(forward - back).max())
    print(f"{what}: {error:.1e} px")
    if not error <= TOLERANCE_PX:
        sys.exit(f"{what}: {error} px from OpenCV")


ZERO = np.zeros((3, 1))


def rectilinear(coefficients):
    matrix = K.copy()
    matrix[0, 1] = 0

    def project(points):
        pixels = cv2.projectPoints(points, ZERO, ZERO, matrix, np.array(coefficients))[0][:, 0]
        # cv2.projectPoints knows no skew.
        pixels[:, 0] += K[0, 1] * (pixels[:, 1] - K[1, 2]) / K[1, 1]
        return pixels

    return project


def main(photosite):
    for k1, k2, p1, s1 in itertools.product((-0.4, -0.1, 0.4), (0.0, 0.12), (0.0, 2e-3), (0.0, 1e-2)):
        lens = f"distortion = {{ model = 'brown-conrady', k = [{k1}, {k2}], p = [{p1}, -1e-3], s = [{s1}, 0, -5e-3, 1e-3] }}"
        coefficients = [k1, k2, p1, -1e-3, 0, 0, 0, 0, s1, 0, -5e-3, 1e-3]
        if k1 == -0.4 and k2 == 0:
            # Alone, it folds back within a picture of this width.
            k2 = 0.2
            lens, coefficients[1] = lens.replace("[-0.4, 0.0]", "[-0.4, 0.2]"), k2
        check(photosite, f"brown-conrady {coefficients}", lens, rectilinear(coefficients))
    k, p = [0.6, -0.2, 0.05, 0.8, -0.1, 0.02], [1e-3, 2e-3]
    lens = f"distortion = {{ model = 'brown-conrady', k = {k}, p = {p} }}"
    check(photosite, "rational", lens, rectilinear([k[0], k[1], *p, *k[2:]]))
    check(photosite, "perspective", "", rectilinear([0.0] * 5))

    for k in itertools.product((-0.05, 0.08), (0.0, 0.01), (-2e-3,), (0.0, 4e-4)):
        lens = f"distortion = {{ model = 'kannala-brandt', k = {list(k)} }}"
        # OpenCV's alpha is the skew over fx.
        matrix = K.copy()
        matrix[0, 1] = 0
        check(photosite, f"fisheye {k}", lens, lambda points: cv2.fisheye.projectPoints(
            points[None], ZERO.ravel(), ZERO.ravel(), matrix, np.array(k), alpha=K[0, 1] / K[0, 0])[0][0])

    for xi, k1, k2, p in itertools.product((0.0, 0.8, 1.3), (-0.1, 0.1), (0.0, 0.05), (0.0, 1e-3)):
        lens = f"projection = 'omnidirectional'\nxi = {xi}\n" \
            f"distortion = {{ model = 'brown-conrady', k = [{k1}, {k2}], p = [{p}, -{p}] }}"
        coefficients = np.array([[k1, k2, p, -p]])
        check(photosite, f"omnidir {xi} {coefficients[0]}", lens, lambda points: cv2.omnidir.projectPoints(
            points[None], ZERO.ravel(), ZERO.ravel(), K, xi, coefficients)[0][0])


if __name__ == "__main__":
    main(*sys.argv[1:])
