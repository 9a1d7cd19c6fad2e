"""Judges lens models by OpenCV: `photosite project` against cv2.projectPoints, cv2.fisheye and cv2.omnidir.

Usage: lens_models.py PHOTOSITE

Points drawn at random within the image and grids of coefficients; both directions agree to 1e-6 px.

Then images: a chessboard is rendered through every model, on square pixels and others, with skew, in parts and binned, and in
image.png OpenCV finds its corners where a pinhole shows them, to 0.2 px and on average to 0.05 px; raw.dng develops to the same image.
"""

import itertools
import json
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


# What is rendered: a name, keys of [lens], and by how much less a pinhole would enlarge the middle.
STRAIGHT = [
    ("brown-conrady", "distortion = { model = 'brown-conrady', k = [-0.25, 0.08], p = [2e-3, -1e-3] }", 1),
    ("rational", "distortion = { model = 'brown-conrady', k = [0.4, -0.2, 0.05, 0.8, -0.1, 0.02], p = [1e-3, 2e-3] }", 1),
    ("thin prism", "distortion = { model = 'brown-conrady', k = [-0.2, 0.05], p = [0, 0], s = [0.02, 0, -0.01, 0] }", 1),
    ("polynomial", "distortion = { model = 'polynomial', k = [0.2, 0.05] }", 1),
    ("division", "distortion = { model = 'division', k = [-0.3] }", 1),
    ("fisheye", "distortion = { model = 'kannala-brandt', k = [0.05, 0.01, -0.002, 0.0004] }", 1),
    ("omnidirectional", "projection = 'omnidirectional'\nxi = 1.1\ndistortion = { model = 'brown-conrady', k = [-0.1, 0.02], p = [1e-3, -2e-3] }", 2.1),
]
# Pixel pitch, skew, changes.
GRIDS = [
    ((5.0, 5.0), 0.0, {}),
    ((16.6, 12.4), 0.0, {}),
    ((5.0, 9.0), 0.0, {}),
    ((5.0, 5.0), 12.0, {}),
    ((5.0, 5.0), 0.0, {"region_px": [40, 20, 240, 200]}),
    ((6.0, 5.0), 4.0, {"region_px": [40, 20, 240, 200], "binning": [2, 2]}),
]


def straight(photosite, what, lens, times, pitch, skew, window):
    """Corners of a chessboard in image.png."""
    size = (320, 240)
    fx, cx, cy = 260.0 * times, 163.0, 117.0
    fy = fx * pitch[0] / pitch[1]
    x, y, width, height = window.get("region_px", [0, 0, *size])
    across, down = window.get("binning", [1, 1])
    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder)
        (folder / "capture.toml").write_text((
            "[scene]\nenvironment = { illuminant = 'D65', illuminance_lux = 2000 }\n"
            "[[targets]]\ntype = 'chessboard'\nname = 'board'\nsquares = [7, 6]\nsquare_mm = 50\n"
            "[camera]\nposition_m = [0.03, 0.02, 0.4]\nlook_at_m = [0.01, 0, 0]\n"
            f"[lens]\ntype = 'pinhole'\nfocal_length_mm = 4\nf_number = 4\nfocus_distance_m = 'infinity'\n{lens}\n"
            # What is sharper than pixels has no place between them.
            f"psf = {{ kind = 'gaussian', sigma_um = {0.6 * max(pitch)} }}\n"
            f"intrinsics = {{ fx = {fx}, fy = {fy}, cx = {cx}, cy = {cy}, skew = {skew * times} }}\n"
            f"[sensor]\npreset = 'sony-imx249-mono'\nresolution_px = {list(size)}\npixel_pitch_um = {list(pitch)}\n"
            "[exposure]\nauto = true\n" + "".join(f"{key} = {value}\n" for key, value in window.items()) +
            # Noise of coarse pixels is as much coarser in square ones.
            f"[render]\nsamples_per_pixel = {round(64 * (max(pitch) / min(pitch)) ** 2)}\nmax_depth = 2\n[output]\nelectrons = false\n").replace("'", '"'))
        for command in (["render", "capture.toml", "-o", "out", "--quiet"], ["develop", "out/raw.dng", "-o", "again.png", "--quiet"]):
            done = subprocess.run([photosite, *command], cwd=folder, capture_output=True, text=True)
            if done.returncode:
                sys.exit(done.stderr)
        report = json.loads((folder / "out/capture.json").read_text())
        picture = cv2.imread(str(folder / "out/image.png"), cv2.IMREAD_GRAYSCALE)
        assert (folder / "again.png").read_bytes() == (folder / "out/image.png").read_bytes(), f"{what}: develop differs from render"
    # The pinhole, by hand: the finer pitch is kept, and positions count from the corner of the part that is read out.
    read = np.array([pitch[0] * across, pitch[1] * down])
    stretch = read / read.min()
    assert picture.shape[::-1] == tuple(int(n * s + 0.5) for n, s in zip((width // across, height // down), stretch)), picture.shape
    scale = stretch / (across, down)
    matrix = np.array([[fx / times * scale[0], skew * scale[0], (cx + 0.5 - x) * scale[0] - 0.5],
                       [0, fy / times * scale[1], (cy + 0.5 - y) * scale[1] - 0.5], [0, 0, 1]])
    assert np.allclose(report["image"]["camera_matrix"], matrix, atol=1e-9), (what, report["image"], matrix)
    assert report["image"]["resolution_px"] == list(picture.shape[::-1]) and report["image"]["projection"] == "perspective"
    board, camera = report["targets"][0], report["camera"]
    points = np.array(board["points_world_m"]) @ np.array(camera["rotation"]).T + camera["translation_m"]
    wanted = (points @ matrix.T)[:, :2] / points[:, 2:]
    # cornerSubPix finds where edges meet in windows that hold one corner each.
    apart = np.linalg.norm(wanted[1:] - wanted[:-1], axis=1).min()
    half = int(0.3 * apart)
    inside = ((wanted > half + 3) & (wanted < np.array(picture.shape[::-1]) - 4 - half)).all(1)
    wanted = wanted[inside]
    stop = (cv2.TERM_CRITERIA_EPS + cv2.TERM_CRITERIA_COUNT, 100, 1e-4)
    found = cv2.cornerSubPix(picture, wanted.astype(np.float32)[:, None].copy(), (half, half), (-1, -1), stop)[:, 0]
    error, mean = np.abs(found - wanted).max(), np.abs((found - wanted).mean(0)).max()
    print(f"{what} on {pitch[0]} x {pitch[1]} um, skew {skew}, {window}: {len(wanted)} corners, {error:.3f} px, mean {mean:.3f} px")
    assert len(wanted) >= 15, what
    # Noise of the image moves a corner by some 0.05 px, and their mean by less than 0.02 px.
    if not (error <= 0.2 and mean <= 0.05):
        sys.exit(f"{what}: corners are {error} px from where a pinhole shows them, {mean} px on average")


def main(photosite):
    photosite = str(Path(photosite).resolve())
    for what, lens, times in STRAIGHT:
        for pitch, skew, window in GRIDS if what in ("brown-conrady", "fisheye") else GRIDS[:2]:
            straight(photosite, what, lens, times, pitch, skew, window)
    straight(photosite, "no distortion", "", 1, (16.6, 12.4), 0.0, {})
    for k1, k2, p1, s1 in itertools.product((-0.4, -0.1, 0.4), (0.0, 0.12), (0.0, 2e-3), (0.0, 1e-2)):
        lens = f"distortion = {{ model = 'brown-conrady', k = [{k1}, {k2}], p = [{p1}, -1e-3], s = [{s1}, 0, -5e-3, 1e-3] }}"
        coefficients = [k1, k2, p1, -1e-3, 0, 0, 0, 0, s1, 0, -5e-3, 1e-3]
        if k1 == -0.4 and k2 == 0:
            # Alone, it folds back within an image of this width.
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
