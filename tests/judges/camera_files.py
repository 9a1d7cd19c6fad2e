"""Judges camera files by their readers: cv2.FileStorage, YAML and pycolmap, which then project the same points.

Usage: camera_files.py PHOTOSITE
"""

import subprocess
import sys
import tempfile
from pathlib import Path

import cv2
import numpy as np
import pycolmap
import yaml

LENSES = {
    "perspective": "",
    "brown-conrady": "distortion = { model = 'brown-conrady', k = [-0.1, 0.02], p = [1e-3, -2e-3] }",
    "rational": "distortion = { model = 'brown-conrady', k = [0.1, 0.02, 0.01, 0.3, 0.1, 0.02], p = [1e-3, -2e-3] }",
    "fisheye": "distortion = { model = 'kannala-brandt', k = [0.05, 0.01, -0.002, 0.0004] }",
    "omnidirectional": "xi = 1.1\ndistortion = { model = 'brown-conrady', k = [-0.1, 0.02], p = [1e-3, -2e-3] }",
}
FORMATS = {
    "opencv": LENSES,
    "ros": ["perspective", "brown-conrady", "rational", "fisheye"],
    "kalibr": ["perspective", "brown-conrady", "fisheye", "omnidirectional"],
    "colmap": ["perspective", "brown-conrady", "rational", "fisheye"],
    "euroc": ["perspective", "brown-conrady", "fisheye"],
}
CAPTURE = """[camera]
position_m = [0.3, 1.2, 2.5]
look_at_m = [0.1, 0.4, -1]
[lens]
focus_distance_m = "infinity"
intrinsics = {{ fx = 500.25, fy = 502, cx = 321.5, cy = 238.125 }}
{}
[sensor]
resolution_px = [640, 480]
"""


def by_opencv(model, points, rotation, translation, matrix, coefficients, xi=None):
    rotation, _ = cv2.Rodrigues(np.asarray(rotation))
    translation = np.asarray(translation, float).reshape(3, 1)
    coefficients = np.asarray(coefficients, float).ravel()
    if model == "omnidir":
        return cv2.omnidir.projectPoints(points[None], rotation, translation, matrix, xi, coefficients[None])[0][0]
    if model == "fisheye":
        return cv2.fisheye.projectPoints(points[None], rotation.ravel(), translation.ravel(), matrix, coefficients)[0][0]
    return cv2.projectPoints(points, rotation, translation, matrix, coefficients)[0][:, 0]


def matrix_of(fx, fy, cx, cy):
    return np.array([[fx, 0, cx], [0, fy, cy], [0, 0, 1.0]])


def read_opencv(path, points, _):
    file = cv2.FileStorage(str(path), cv2.FILE_STORAGE_READ)
    size = [int(file.getNode(key).real()) for key in ("image_width", "image_height")]
    assert size == [640, 480], size
    node = {key: file.getNode(key).mat() for key in ("camera_matrix", "distortion_coefficients", "rotation", "translation_m")}
    xi = file.getNode("xi").real() if not file.getNode("xi").empty() else None
    return by_opencv(file.getNode("distortion_model").string(), points, node["rotation"], node["translation_m"],
                     node["camera_matrix"], node["distortion_coefficients"], xi)


def read_ros(path, points, pose):
    file = yaml.safe_load(path.read_text())
    array = lambda key: np.array(file[key]["data"], float).reshape(file[key]["rows"], file[key]["cols"])
    assert (file["image_width"], file["image_height"]) == (640, 480)
    assert np.array_equal(array("projection_matrix")[:, :3], array("camera_matrix"))
    model = {"plumb_bob": "calib3d", "rational_polynomial": "calib3d", "equidistant": "fisheye"}[file["distortion_model"]]
    return by_opencv(model, points, *pose, array("camera_matrix"), array("distortion_coefficients"))


def read_kalibr(path, points, pose):
    camera = yaml.safe_load(path.read_text())["cam0"]
    *xi, fx, fy, cx, cy = camera["intrinsics"]
    assert camera["resolution"] == [640, 480]
    model = {("pinhole", "none"): "calib3d", ("pinhole", "radtan"): "calib3d", ("pinhole", "equidistant"): "fisheye",
             ("omni", "radtan"): "omnidir"}[camera["camera_model"], camera["distortion_model"]]
    coefficients = camera["distortion_coeffs"] or [0.0] * 4
    return by_opencv(model, points, *pose, matrix_of(fx, fy, cx, cy), coefficients, *xi)


def read_euroc(path, points, pose):
    camera = yaml.safe_load(path.read_text())
    assert np.allclose(np.array(camera["T_BS"]["data"]).reshape(4, 4), np.eye(4), atol=1e-15)
    model = {"radial-tangential": "calib3d", "equidistant": "fisheye"}[camera["distortion_model"]]
    return by_opencv(model, points, *pose, matrix_of(*camera["intrinsics"]), camera["distortion_coefficients"])


def read_colmap(path, points, _):
    model = pycolmap.Reconstruction(str(path))
    image = next(iter(model.images.values()))
    assert image.name == "image.png"
    pose = image.cam_from_world() if callable(image.cam_from_world) else image.cam_from_world
    in_camera = points @ pose.rotation.matrix().T + pose.translation
    camera = model.cameras[image.camera_id]
    # COLMAP counts from the corner of the first pixel.
    return np.array([camera.img_from_cam(point) for point in in_camera]).reshape(-1, 2) - 0.5


def main(photosite):
    points = np.random.default_rng(5).uniform((-0.8, -0.3, -1.5), (1.0, 1.0, 0.0), (50, 3))
    readers = {"opencv": read_opencv, "ros": read_ros, "kalibr": read_kalibr, "colmap": read_colmap, "euroc": read_euroc}
    with tempfile.TemporaryDirectory() as folder:
        capture, csv = Path(folder, "capture.toml"), Path(folder, "points.csv")
        csv.write_text("\n".join(",".join(map(repr, map(float, point))) for point in points))
        for lens, keys in LENSES.items():
            capture.write_text(CAPTURE.format(keys.replace("'", '"')))
            wanted = subprocess.run([photosite, "project", capture, "--points", csv], capture_output=True, text=True, check=True)
            wanted = np.array([[float(x) for x in line.split(",")] for line in wanted.stdout.split()])
            assert np.isfinite(wanted).all()
            pose = None
            for kind in FORMATS:
                out = Path(folder, f"{kind}-{lens}")
                done = subprocess.run([photosite, "camera", capture, "--format", kind, "-o", out], capture_output=True, text=True)
                if lens not in FORMATS[kind]:
                    assert done.returncode == 1 and "no model" in done.stderr, (kind, lens, done)
                    continue
                if done.returncode:
                    sys.exit(done.stderr)
                if kind == "opencv":
                    file = cv2.FileStorage(str(out), cv2.FILE_STORAGE_READ)
                    pose = file.getNode("rotation").mat(), file.getNode("translation_m").mat()
                error = np.abs(readers[kind](out, points, pose) - wanted).max()
                print(f"{kind} {lens}: {error:.1e} px")
                if not error <= 1e-6:
                    sys.exit(f"{kind} {lens}: {error} px")


if __name__ == "__main__":
    main(*sys.argv[1:])
