#!/usr/bin/env python3
"""OpenCV calibrates a camera from our photographs of targets and finds what was put in: calibration.py PHOTOSITE [--full] [--folder DIR]

18 views of 1280 × 960 pixels through a lens with distortion, f = 1500 px, with the noise of a sensor that counts 10 000
electrons where the board is white. The targets shine by themselves, as on a screen, so that a few samples are enough.
Without --full: the chessboard alone, and fewer samples a pixel.
"""

import json
import math
import subprocess
import sys
import tempfile
from pathlib import Path

import cv2
import numpy as np

PHOTOSITE, FULL = sys.argv[1], "--full" in sys.argv
# Renders that are there already are taken as they are.
FOLDER = Path(sys.argv[sys.argv.index("--folder") + 1] if "--folder" in sys.argv else tempfile.mkdtemp())
SAMPLES = 64 if FULL else 8
WHITE_E = 10_000

CAPTURE = """
[[targets]]
name = "board"
{target}

[materials]
board-white.emission = {{ luminance_nit = 300 }}
board-black.emission = {{ luminance_nit = 10 }}

[camera]
position_m = {position}
look_at_m = {look_at}
up = {up}

[lens]
type = "pinhole"
focal_length_mm = 8.79
f_number = 8.0
focus_distance_m = "infinity"
falloff = "none"
intrinsics = {{ fx = 1500.0, fy = 1500.0, cx = 650.0, cy = 470.0 }}
distortion = {{ model = "brown-conrady", k = [-0.12, 0.05, 0.0], p = [0.0005, -0.0004] }}

[sensor]
preset = "sony-imx249-mono"
resolution_px = [1280, 960]

[exposure]
time_s = 0.0092

[render]
samples_per_pixel = {samples}
max_depth = 1

[output]
raw = ["npy"]
"""

CHESSBOARD = 'type = "chessboard"\nsquares = [10, 7]\nsquare_mm = 25.0'
CHARUCO = 'type = "charuco"\nsquares = [10, 7]\nsquare_mm = 25.0\nmarker_mm = 16.0\ndictionary = "DICT_5X5_100"'

# Tilts about the board's axes and roll in degrees, distance in m, and where on the board the camera looks in m.
POSES = [
    (0, 0, 0, 0.48, 0.00, 0.00), (25, 0, 0, 0.46, 0.00, 0.00), (-25, 0, 3, 0.46, 0.00, 0.00),
    (0, 28, 0, 0.46, 0.00, 0.00), (0, -28, -4, 0.46, 0.00, 0.00), (22, 22, 8, 0.50, 0.00, 0.00),
    (-22, 22, -8, 0.50, 0.00, 0.00), (22, -22, 0, 0.50, 0.00, 0.00), (-22, -22, 5, 0.50, 0.00, 0.00),
    (15, 10, 0, 0.60, 0.08, 0.05), (-15, 10, 0, 0.60, -0.08, 0.05), (15, -10, 0, 0.60, 0.08, -0.05),
    (-15, -10, 0, 0.60, -0.08, -0.05), (30, 0, 12, 0.62, 0.09, 0.00), (-30, 0, -12, 0.62, -0.09, 0.00),
    (0, 32, 0, 0.60, 0.00, 0.07), (0, -32, 0, 0.60, 0.00, -0.07), (10, -15, 90, 0.62, 0.00, 0.00),
]


def view(number, name, target, pose):
    """Renders a view: 8-bit picture, points of the target in metres, where they appear by OpenCV's own projection."""
    about_x, about_y, roll, distance, x, y = pose
    a, b, r = (math.radians(angle) for angle in (about_x, about_y, roll))
    towards = np.array([math.sin(b) * math.cos(a), math.sin(a), math.cos(b) * math.cos(a)])
    side = np.cross([0.0, 1.0, 0.0], towards)
    side /= np.linalg.norm(side)
    up = math.cos(r) * np.cross(towards, side) + math.sin(r) * side
    look_at = np.array([x, y, 0.0])
    path = FOLDER / f"{name}.toml"
    listed = lambda vector: "[" + ", ".join(repr(float(v)) for v in vector) + "]"
    path.write_text(CAPTURE.format(target=target, position=listed(look_at + distance * towards), look_at=listed(look_at),
                                   up=listed(up), samples=SAMPLES))
    out = FOLDER / f"{name}-{number:02}"
    if not (out / "capture.json").exists():
        subprocess.run([PHOTOSITE, "render", path, "-o", out, "--quiet", "--seed", str(number)], check=True)
    report = json.loads((out / "capture.json").read_text())
    sensor = report["sensor"]
    signal = np.load(out / "raw.npy").astype(float) - sensor["black_level_dn"]
    electrons = signal / sensor["system_gain_dn_per_e"]
    picture = np.clip(electrons / WHITE_E * 220, 0, 255).round().astype(np.uint8)
    placed = report["targets"][0]
    world = np.array(placed["points_world_m"])
    board = np.array([[*point["xy_mm"], 0.0] for point in placed["points"]]) / 1e3
    camera = report["camera"]
    matrix, distortion = np.array(camera["camera_matrix"]), np.array(camera["distortion"])
    rotation, translation = np.array(camera["rotation"]), np.array(camera["translation_m"])
    truth, _ = cv2.projectPoints(world, cv2.Rodrigues(rotation)[0], translation, matrix, distortion)
    return picture, electrons, board, truth.reshape(-1, 2), matrix, distortion


def refined(picture, corners, window):
    """Corners to a part of a pixel. OpenCV's gradients want edges that are not steps, which a lens without blur leaves:
    the picture is smoothed as a lens with a spot of three pixels would have."""
    smooth = cv2.GaussianBlur(picture.astype(np.float32), (0, 0), 1.5)
    criteria = (cv2.TERM_CRITERIA_EPS + cv2.TERM_CRITERIA_MAX_ITER, 100, 1e-5)
    return cv2.cornerSubPix(smooth, corners.astype(np.float32).reshape(-1, 1, 2), (window, window), (-1, -1), criteria)


def chessboard_corners(picture):
    found, corners = cv2.findChessboardCorners(cv2.GaussianBlur(picture, (0, 0), 1), (9, 6))
    return (np.arange(54), refined(picture, corners, 11).reshape(-1, 2)) if found else None


def charuco_corners(picture):
    board = cv2.aruco.CharucoBoard((10, 7), 0.025, 0.016, cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_5X5_100))
    corners, ids, _, _ = cv2.aruco.CharucoDetector(board).detectBoard(picture)
    # The markers begin 4.5 mm from the corners.
    return (ids.ravel(), refined(picture, corners, 7).reshape(-1, 2)) if ids is not None else None


def judge(name, target, detect):
    boards, images, errors = [], [], []
    for number, pose in enumerate(POSES):
        picture, electrons, board, truth, matrix, distortion = view(number, name, target, pose)
        white = np.percentile(electrons, 98)
        assert abs(white / WHITE_E - 1) < 0.1, f"white counts {white:.0f} electrons"
        found = detect(picture)
        assert found is not None, f"{name}: nothing found in view {number}"
        ids, corners = found
        # A chessboard may be read from either end; which, says the truth.
        if np.linalg.norm(corners - truth[ids], axis=1).max() > 5:
            corners = corners[::-1]
        error = corners - truth[ids]
        errors.append(error)
        boards.append(board[ids].astype(np.float32))
        images.append(corners.astype(np.float32).reshape(-1, 1, 2))
    error = np.concatenate(errors)
    bias, rms = np.abs(error.mean(axis=0)).max(), math.sqrt((error**2).sum(axis=1).mean())
    size = (1280, 960)
    flags = cv2.CALIB_FIX_K3
    reprojection, found, coefficients, _, _ = cv2.calibrateCamera(boards, images, size, None, None, flags=flags)
    f = np.abs(np.diag(found)[:2] - np.diag(matrix)[:2]).max()
    c = np.abs(found[:2, 2] - matrix[:2, 2]).max()
    k1 = abs(coefficients.ravel()[0] - distortion[0])
    print(f"{name}: {len(error)} corners; bias {bias:.4f} px, RMS {rms:.4f} px (largest {np.abs(error).max():.3f}); "
          f"|Δf| {f:.3f} px, |Δc| {c:.3f} px, |Δk1| {k1:.5f}, reprojection {reprojection:.4f} px")
    # RMS of the distance and of OpenCV's reprojection error: both over x and y together.
    for figure, value, limit in (("bias", bias, 0.01), ("RMS", rms, 0.05), ("f", f, 0.5), ("c", c, 0.5), ("k1", k1, 0.001),
                                 ("reprojection", reprojection, 0.05)):
        assert value <= limit, f"{name}: {figure} {value} exceeds {limit}"


judge("chessboard", CHESSBOARD, chessboard_corners)
if FULL:
    judge("charuco", CHARUCO, charuco_corners)
