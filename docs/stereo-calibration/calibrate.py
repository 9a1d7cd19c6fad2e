"""Calibrates the stereo rig of a data set with OpenCV, compares with the truth, and draws what is left.

Usage: calibrate.py DATASET [PLOTS]
"""

import json
import sys
from pathlib import Path

import cv2
import matplotlib
import numpy as np

matplotlib.use("Agg")
from matplotlib import pyplot as plt

CORNERS = (9, 6)
SQUARE_M = 0.025
CAMERAS = ("left", "right")


def detect(picture):
    """The inner corners of the board, row by row from its top left, to a part of a pixel."""
    found, corners = cv2.findChessboardCorners(picture, CORNERS)
    assert found, "no board"
    criteria = (cv2.TERM_CRITERIA_EPS + cv2.TERM_CRITERIA_MAX_ITER, 100, 1e-5)
    # Its gradients want softer edges than those of a lens that is perfectly sharp.
    soft = cv2.GaussianBlur(picture.astype(np.float32), (0, 0), 1.5)
    corners = cv2.cornerSubPix(soft, corners, (11, 11), (-1, -1), criteria).reshape(-1, 2)
    # The board may be read from either end; in these pictures it is never upside down.
    return corners if corners[0, 0] < corners[-1, 0] else corners[::-1]


def truth_of(dataset, camera):
    """Matrix, distortion, and the pose from the left camera: OpenCV's own files."""
    file = cv2.FileStorage(str(dataset / f"calibration/opencv/{camera}.yaml"), cv2.FILE_STORAGE_READ)
    return [file.getNode(key).mat() for key in ("camera_matrix", "distortion_coefficients", "rotation", "translation_m")]


dataset = Path(sys.argv[1])
lines = [json.loads(line) for line in (dataset / "manifest.jsonl").read_text().splitlines()]
found, exact = {camera: [] for camera in CAMERAS}, {camera: [] for camera in CAMERAS}
for line in lines:
    folder = dataset / line["folder"]
    found[line["camera"]].append(detect(cv2.imread(str(folder / "image.png"), cv2.IMREAD_GRAYSCALE)))
    report = json.loads((folder / "capture.json").read_text())
    exact[line["camera"]].append(np.array(report["targets"][0]["points_px"]))
size = tuple(report["camera"]["resolution_px"])

columns, rows = np.meshgrid(range(CORNERS[0]), range(CORNERS[1]))
board = np.stack([columns, rows, 0 * rows], axis=-1).reshape(-1, 3).astype(np.float32) * SQUARE_M
boards = [board] * len(found["left"])

matrices, lenses, residuals = {}, {}, {}
for camera in CAMERAS:
    rms, matrix, lens, turns, moves = cv2.calibrateCamera(boards, found[camera], size, None, None, flags=cv2.CALIB_FIX_K3)
    matrices[camera], lenses[camera] = matrix, lens
    seen = [cv2.projectPoints(board, turn, move, matrix, lens)[0].reshape(-1, 2) for turn, move in zip(turns, moves)]
    residuals[camera] = np.array(found[camera]) - np.array(seen)
    true_matrix, true_lens, _, _ = truth_of(dataset, camera)
    print(f"{camera}: reprojection error {rms:.3f} px")
    values = [*matrix[[0, 1, 0, 1], [0, 1, 2, 2]], *lens.ravel()[:4]]
    truths = [*true_matrix[[0, 1, 0, 1], [0, 1, 2, 2]], *true_lens.ravel()[:4]]
    for name, value, true in zip(("fx", "fy", "cx", "cy", "k1", "k2", "p1", "p2"), values, truths):
        print(f"  {name}  {value:10.4f}   true {true:10.4f}   difference {value - true:+.4f}")

rms, *_, rotation, translation, _, _ = cv2.stereoCalibrate(
    boards, found["left"], found["right"], matrices["left"], lenses["left"], matrices["right"], lenses["right"], size,
    flags=cv2.CALIB_FIX_INTRINSIC)
_, _, true_rotation, true_translation = truth_of(dataset, "right")
baseline, true_baseline = np.linalg.norm(translation), np.linalg.norm(true_translation)
turn = np.degrees(np.linalg.norm(cv2.Rodrigues(rotation @ true_rotation.T)[0]))
print(f"pair: reprojection error {rms:.3f} px")
print(f"  baseline {1e3 * baseline:.3f} mm   true {1e3 * true_baseline:.3f} mm   difference {100 * (baseline / true_baseline - 1):+.3f} %")
print(f"  rotation is off by {turn:.4f}°")
for camera in CAMERAS:
    error = np.array(found[camera]) - np.array(exact[camera])
    print(f"{camera}: corners found {np.sqrt((error**2).sum(axis=2).mean()):.3f} px (RMS) from where they are")

if len(sys.argv) > 2:
    figure, (errors, views, truths) = plt.subplots(1, 3, figsize=(12, 4), layout="constrained")
    for camera, colour in zip(CAMERAS, ("#0072b2", "#d55e00")):
        errors.plot(*residuals[camera].reshape(-1, 2).T, ".", ms=3, alpha=0.6, color=colour, label=camera)
        rms = np.sqrt((residuals[camera] ** 2).sum(axis=2).mean(axis=1))
        views.bar(np.arange(len(rms)) + (0.2 if camera == "right" else -0.2), rms, 0.4, color=colour, label=camera)
        error = (np.array(found[camera]) - np.array(exact[camera])).reshape(-1, 2)
        truths.plot(*error.T, ".", ms=3, alpha=0.6, color=colour, label=camera)
    errors.set(title="reprojection error of each corner", xlabel="x / px", ylabel="y / px", aspect="equal")
    views.set(title="reprojection error of each view", xlabel="view", ylabel="RMS / px")
    truths.set(title="corner found less true corner", xlabel="x / px", ylabel="y / px", aspect="equal")
    limit = 1.05 * max(np.abs([*errors.get_xlim(), *errors.get_ylim(), *truths.get_xlim(), *truths.get_ylim()]))
    for axes in (errors, truths):
        axes.set(xlim=(-limit, limit), ylim=(-limit, limit))
        axes.grid(alpha=0.3)
    errors.legend()
    figure.savefig(sys.argv[2], dpi=80)
