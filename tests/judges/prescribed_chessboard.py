"""A chessboard through a lens from a prescription, calibrated by OpenCV, finds the model that `photosite camera` fits.

Usage: prescribed_chessboard.py PHOTOSITE

Ten views through a wide lens of 12.7 % barrel distortion, with the noise of a sensor. OpenCV calibrates from corners that it finds
itself. Its focal length is that of the fitted model within 0.2 %, its principal point within 0.5 px, and the fitted model, with the
poses that suit it best, is as near to the corners as what OpenCV found, within 0.02 px.
"""

import subprocess
import sys
import tempfile
from pathlib import Path

import cv2
import numpy as np

SIZE = (480, 320)
CAPTURE = """
[[targets]]
name = "board"
type = "chessboard"
squares = [12, 9]
square_mm = 100

[materials]
board-white.emission = {{ luminance_nit = 300 }}
board-black.emission = {{ luminance_nit = 10 }}

[camera]
position_m = {position}
look_at_m = {look_at}
up = {up}

[lens]
prescription = "canon-rf24"
f_number = 8
focus_distance_m = 1.2

[sensor]
preset = "sony-imx249-mono"
resolution_px = [480, 320]
pixel_pitch_um = [75, 75]

[exposure]
auto = true
auto_mean = 0.3

[render]
samples_per_pixel = 16
max_depth = 1

[develop]
distortion = false

[output]
raw = []
electrons = false
"""
# Where the camera stands, what it looks at, m, and its roll, degrees.
VIEWS = [
    ((0, 0, 0.95), (0, 0, 0), 0), ((0.55, 0, 0.95), (0.05, 0, 0), 90), ((-0.55, 0.05, 0.95), (0, 0, 0), 180), ((0, 0.4, 1.1), (0, 0.0, 0), 270),
    ((0, -0.5, 0.95), (0, 0, 0), 4), ((0.4, 0.4, 1.15), (0.0, 0, 0), 95), ((-0.4, 0.35, 1.0), (-0.15, 0.05, 0), 0), ((0.45, -0.35, 1.0), (0.1, -0.1, 0), 183),
    ((-0.4, -0.4, 1.1), (-0.05, -0.1, 0), 275), ((0.1, 0.1, 1.05), (0.2, 0.1, 0), 0),
]


def run(*arguments):
    done = subprocess.run([str(argument) for argument in arguments], capture_output=True, text=True, check=False)
    if done.returncode:
        sys.exit(f"{arguments}: {done.stderr}")


def view(photosite, folder, i, position, look_at, roll):
    forward = np.subtract(look_at, position) / np.linalg.norm(np.subtract(look_at, position))
    right = np.cross(forward, (0, 1, 0))
    right /= np.linalg.norm(right)
    turn = np.radians(roll)
    up = np.cross(right, forward) * np.cos(turn) + right * np.sin(turn)
    capture = folder / f"{i}.toml"
    capture.write_text(CAPTURE.format(position=list(position), look_at=list(look_at), up=[float(x) for x in up]))
    run(photosite, "render", capture, "-o", folder / str(i), "--quiet")
    return cv2.imread(str(folder / f"{i}/image.png"), cv2.IMREAD_GRAYSCALE)


def main():
    photosite = Path(sys.argv[1]).resolve()
    inner = (11, 8)
    board = np.zeros((inner[0] * inner[1], 3), np.float32)
    board[:, :2] = np.mgrid[0:inner[0], 0:inner[1]].T.reshape(-1, 2) * 0.1
    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder)
        pictures = [view(photosite, folder, i, *place) for i, place in enumerate(VIEWS)]
        corners = []
        for i, picture in enumerate(pictures):
            found, points = cv2.findChessboardCornersSB(picture, inner, flags=cv2.CALIB_CB_EXHAUSTIVE | cv2.CALIB_CB_ACCURACY)
            if found:
                corners.append(points.reshape(-1, 1, 2).astype(np.float32))
            else:
                print(f"view {i}: not all of the board is found")
        if len(corners) < 8:
            sys.exit(f"the board is found in {len(corners)} of {len(VIEWS)} views")
        run(photosite, "camera", folder / "0.toml", "--format", "opencv", "-o", folder / "camera.yaml")
        file = cv2.FileStorage(str(folder / "camera.yaml"), cv2.FILE_STORAGE_READ)
        fitted = [file.getNode(key).mat() for key in ("camera_matrix", "distortion_coefficients")]
    rms, matrix, coefficients, _, _ = cv2.calibrateCamera(
        [board] * len(corners), corners, SIZE, None, None, flags=cv2.CALIB_RATIONAL_MODEL | cv2.CALIB_ZERO_TANGENT_DIST
    )
    squares = []
    for points in corners:
        _, rotation, translation = cv2.solvePnP(board, points, *fitted)
        rotation, translation = cv2.solvePnPRefineLM(board, points, *fitted, rotation, translation)
        squares.append(((cv2.projectPoints(board, rotation, translation, *fitted)[0] - points) ** 2).sum(axis=2).ravel())
    rms_fitted = float(np.sqrt(np.concatenate(squares).mean()))
    focal = matrix[0, 0] / fitted[0][0, 0] - 1
    centre = np.linalg.norm(matrix[:2, 2] - fitted[0][:2, 2])
    print(
        f"{len(corners)} views: rms {rms:.4f} px by OpenCV's camera, {rms_fitted:.4f} px by the fitted one; "
        f"focal length {100 * focal:+.3f} %, principal point {centre:.3f} px"
    )
    if not (abs(focal) < 2e-3 and centre < 0.5 and rms_fitted < rms + 0.02 and rms < 0.15):
        sys.exit("the calibration does not find the fitted model")


if __name__ == "__main__":
    main()
