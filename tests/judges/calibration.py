#!/usr/bin/env python3
"""OpenCV calibrates cameras from our photographs of targets and finds what was put in:

    calibration.py PHOTOSITE [chessboard] [charuco] [fisheye] [stereo] [--samples N] [--folder DIR]

18 views of 1280 × 960 pixels through a lens with distortion, f = 1500 px (a fisheye 600 px), with all the noise of a sensor
that counts 10 000 electrons where the board is white. The targets shine by themselves, as on a screen, so that a few
samples per pixel are enough. What is not named is left out; without names all are judged. Renders that are in DIR already are
taken as they are.
"""

import argparse
import functools
import json
import math
import subprocess
import tempfile
from pathlib import Path

import cv2
import numpy as np

SIZE = (1280, 960)
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
{lens}
f_number = 8.0
focus_distance_m = "infinity"
falloff = "none"

[sensor]
preset = "sony-imx249-mono"
resolution_px = [1280, 960]

[exposure]
time_s = {time}

[render]
samples_per_pixel = {samples}
max_depth = 1

[output]
raw = ["npy"]
"""

CHESSBOARD = 'type = "chessboard"\nsquares = [10, 7]\nsquare_mm = 25.0'
CHARUCO = 'type = "charuco"\nsquares = [10, 7]\nsquare_mm = 25.0\nmarker_mm = 16.0\ndictionary = "DICT_5X5_100"'
RECTILINEAR = """type = "pinhole"
focal_length_mm = 8.79
intrinsics = { fx = 1500.0, fy = 1500.0, cx = 650.0, cy = 470.0 }
distortion = { model = "brown-conrady", k = [-0.12, 0.05, 0.0], p = [0.0005, -0.0004] }"""
FISHEYE = """type = "pinhole"
focal_length_mm = 3.516
intrinsics = { fx = 600.0, fy = 600.0, cx = 650.0, cy = 470.0 }
distortion = { model = "kannala-brandt", k = [0.04, -0.01, 0.002, -0.0005] }"""

# Tilts about the board's axes and roll in degrees, distance in m, and where on the board the camera looks in m. Quarter turns
# tell a principal point that is off from a camera that is turned, which without them look the same.
POSES = [
    (0, 0, 0, 0.48, 0.00, 0.00), (25, 0, 90, 0.46, 0.00, 0.00), (-25, 0, 183, 0.46, 0.00, 0.00),
    (0, 28, 270, 0.46, 0.00, 0.00), (0, -28, -4, 0.46, 0.00, 0.00), (22, 22, 98, 0.50, 0.00, 0.00),
    (-22, 22, 172, 0.50, 0.00, 0.00), (22, -22, 270, 0.50, 0.00, 0.00), (-22, -22, 5, 0.50, 0.00, 0.00),
    (15, 10, 90, 0.60, 0.05, 0.05), (-15, 10, 180, 0.60, -0.08, 0.05), (15, -10, 270, 0.60, 0.04, -0.05),
    (-15, -10, 0, 0.60, -0.08, -0.05), (30, 0, 102, 0.62, 0.05, 0.00), (-30, 0, 168, 0.62, -0.09, 0.00),
    (0, 32, 270, 0.60, 0.00, 0.07), (0, -32, 0, 0.60, 0.00, -0.07), (10, -15, 90, 0.62, 0.00, 0.00),
]
# Where the right camera of the pair stands and how it is turned, in the frame of the left (x right, y up, z backward).
RIGHT_M = np.array([0.10, 0.004, -0.006])
RIGHT_ROTATION = cv2.Rodrigues(np.radians([0.8, 7.0, -1.0]))[0]


def camera_pose(pose, closer):
    """Position and axes (columns x right, y up, z backward) of the camera of a pose."""
    about_x, about_y, roll, distance, x, y = pose
    a, b, r = (math.radians(angle) for angle in (about_x, about_y, roll))
    back = np.array([math.sin(b) * math.cos(a), math.sin(a), math.cos(b) * math.cos(a)])
    side = np.cross([0.0, 1.0, 0.0], back)
    side /= np.linalg.norm(side)
    up = math.cos(r) * np.cross(back, side) + math.sin(r) * side
    return np.array([x, y, 0.0]) + distance * closer * back, np.column_stack([np.cross(up, back), up, back])


class View:
    """A photograph, with what is known of it."""

    def __init__(self, name, number, target, lens, position, axes):
        path = arguments.folder / f"{name}.toml"
        listed = lambda vector: "[" + ", ".join(repr(float(v)) for v in vector) + "]"
        text = CAPTURE.format(target=target, lens=lens, position=listed(position), up=listed(axes[:, 1]),
                              look_at=listed(position - axes[:, 2]), time=0.0093, samples=arguments.samples)
        path.write_text(text)
        out = arguments.folder / f"{name}-{number:02}"
        if not (out / "capture.json").exists():
            command = [arguments.photosite, "render", path, "-o", out, "--quiet", "--seed", str(number)]
            subprocess.run(command, check=True)
        report = json.loads((out / "capture.json").read_text())
        sensor, camera, board = report["sensor"], report["camera"], report["targets"][0]
        signal = np.load(out / "raw.npy").astype(float) - sensor["black_level_dn"]
        electrons = signal / sensor["system_gain_dn_per_e"]
        white = np.percentile(electrons, 98)
        assert abs(white / WHITE_E - 1) < 0.1, f"white counts {white:.0f} electrons"
        self.picture = np.clip(electrons / WHITE_E * 220, 0, 255).round().astype(np.uint8)
        self.matrix, self.distortion = np.array(camera["camera_matrix"]), np.array(camera["distortion"])
        self.rotation, self.translation = np.array(camera["rotation"]), np.array(camera["translation_m"])
        self.board = np.array([[*point["xy_mm"], 0.0] for point in board["points"]]) / 1e3
        world = np.array(board["points_world_m"]).reshape(-1, 1, 3)
        pose = cv2.Rodrigues(self.rotation)[0], self.translation
        if camera["projection"] == "kannala-brandt":
            truth, _ = cv2.fisheye.projectPoints(world, *pose, self.matrix, self.distortion)
        else:
            truth, _ = cv2.projectPoints(world, *pose, self.matrix, self.distortion)
        self.truth = truth.reshape(-1, 2)

    def detect(self, detector):
        """Numbers and places of the points that are found. A chessboard may be read from either end; which, the truth
        says."""
        found = detector(self.picture)
        assert found is not None, "nothing is found"
        ids, corners = found
        if np.linalg.norm(corners - self.truth[ids], axis=1).max() > 5:
            corners = corners[::-1]
        return ids, corners


def refined(picture, corners, window):
    """Corners to a part of a pixel. OpenCV's gradients want edges that are not steps, which a lens without blur leaves:
    the image is smoothed as a lens with a spot of three pixels would have."""
    smooth = cv2.GaussianBlur(picture.astype(np.float32), (0, 0), 1.5)
    criteria = (cv2.TERM_CRITERIA_EPS + cv2.TERM_CRITERIA_MAX_ITER, 100, 1e-5)
    start = corners.astype(np.float32).reshape(-1, 1, 2)
    return cv2.cornerSubPix(smooth, start, (window, window), (-1, -1), criteria).reshape(-1, 2)


def chessboard_corners(picture):
    found, corners = cv2.findChessboardCorners(cv2.GaussianBlur(picture, (0, 0), 1), (9, 6))
    return (np.arange(54), refined(picture, corners, 11)) if found else None


def charuco_corners(picture):
    board = cv2.aruco.CharucoBoard((10, 7), 0.025, 0.016, cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_5X5_100))
    corners, ids, _, _ = cv2.aruco.CharucoDetector(board).detectBoard(picture)
    # The markers begin 4.5 mm from the corners.
    return (ids.ravel(), refined(picture, corners, 7)) if ids is not None else None


def within(name, **figures):
    """Prints figures with their limits, and fails where one exceeds it."""
    print(f"{name}: " + ", ".join(f"{figure} {value:.5g} (≤ {limit})" for figure, (value, limit) in figures.items()))
    for figure, (value, limit) in figures.items():
        assert value <= limit, f"{name}: {figure}"


def calibrate(name, target, lens, detector, closer=1.0):
    """Takes and detects all views, calibrates, compares. Returns what is needed for a pair."""
    views = [View(name, i, target, lens, *camera_pose(pose, closer)) for i, pose in enumerate(POSES)]
    found = [view.detect(detector) for view in views]
    error = np.concatenate([corners - view.truth[ids] for view, (ids, corners) in zip(views, found)])
    within(f"{name}, {len(error)} corners", bias_px=(np.abs(error.mean(axis=0)).max(), 0.01),
           rms_px=(math.sqrt((error**2).sum(axis=1).mean()), 0.05))
    boards = [view.board[ids].reshape(-1, 1, 3) for view, (ids, _) in zip(views, found)]
    corners = [corners.astype(np.float64).reshape(-1, 1, 2) for _, corners in found]
    matrix, distortion = views[0].matrix, views[0].distortion
    if lens == FISHEYE:
        flags = cv2.CALIB_RECOMPUTE_EXTRINSIC | cv2.CALIB_FIX_SKEW
        listed = [[part.reshape(1, -1, part.shape[-1]) for part in parts] for parts in (boards, corners)]
        rms, got, coefficients, _, _ = cv2.fisheye.calibrate(*listed, SIZE, None, None, flags=flags)
    else:
        as_f32 = [[part.astype(np.float32) for part in parts] for parts in (boards, corners)]
        rms, got, coefficients, _, _ = cv2.calibrateCamera(*as_f32, SIZE, None, None, flags=cv2.CALIB_FIX_K3)
    difference = np.abs(got - matrix)
    within(f"{name}, calibrated", f_px=(max(difference[0, 0], difference[1, 1]), 0.5), c_px=(difference[:2, 2].max(), 0.5),
           k1=(abs(coefficients.ravel()[0] - distortion[0]), 0.001), reprojection_px=(rms, 0.05))
    return views, found, got, coefficients


def stereo():
    """A second camera beside the first: baseline and rotation between both."""
    views, found, matrix, distortion = chessboard()
    detected = []
    for i, pose in enumerate(POSES):
        position, axes = camera_pose(pose, 1.0)
        right = View("right", i, CHESSBOARD, RECTILINEAR, position + axes @ RIGHT_M, axes @ RIGHT_ROTATION)
        # Where the board leaves the image there is no pair.
        margin = 15
        if (right.truth > margin).all() and (right.truth < np.array(SIZE) - margin).all():
            detected.append((i, right, right.detect(chessboard_corners)[1]))
    assert len(detected) >= 10, f"only {len(detected)} pairs"
    boards = [views[i].board.astype(np.float32) for i, _, _ in detected]
    lefts = [found[i][1].astype(np.float32) for i, _, _ in detected]
    rights = [corners.astype(np.float32) for _, _, corners in detected]
    guess = matrix.copy(), distortion.copy()
    result = cv2.stereoCalibrate(boards, lefts, rights, matrix, distortion, *guess, SIZE,
                                 flags=cv2.CALIB_USE_INTRINSIC_GUESS | cv2.CALIB_FIX_K3)
    rotation, translation = result[5], result[6].ravel()
    i, right, _ = detected[0]
    true_rotation = right.rotation @ views[i].rotation.T
    true_translation = right.translation - true_rotation @ views[i].translation
    baseline = abs(np.linalg.norm(translation) / np.linalg.norm(true_translation) - 1)
    turn = np.degrees(np.linalg.norm(cv2.Rodrigues(rotation @ true_rotation.T)[0]))
    within(f"stereo, {len(detected)} pairs", baseline_percent=(100 * baseline, 0.05), rotation_deg=(turn, 0.01))


@functools.cache
def chessboard():
    return calibrate("chessboard", CHESSBOARD, RECTILINEAR, chessboard_corners)


JUDGED = {
    "chessboard": chessboard,
    "charuco": lambda: calibrate("charuco", CHARUCO, RECTILINEAR, charuco_corners),
    "fisheye": lambda: calibrate("fisheye", CHESSBOARD, FISHEYE, chessboard_corners, closer=0.45),
    "stereo": stereo,
}
parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
parser.add_argument("photosite")
parser.add_argument("names", nargs="*", metavar="NAME", help=", ".join(JUDGED))
parser.add_argument("--samples", type=int, default=12)
parser.add_argument("--folder", type=Path, default=None)
arguments = parser.parse_args()
unknown = set(arguments.names) - set(JUDGED)
if unknown:
    parser.error(f"no judge {', '.join(sorted(unknown))}; there are {', '.join(JUDGED)}")
arguments.folder = arguments.folder or Path(tempfile.mkdtemp())
arguments.folder.mkdir(parents=True, exist_ok=True)
for name in arguments.names or JUDGED:
    JUDGED[name]()
