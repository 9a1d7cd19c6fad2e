"""Judges camera files by their readers: cv2.FileStorage, YAML and pycolmap, which then project the same points.

Usage: camera_files.py PHOTOSITE

The files of rigs are judged by cv2.stereoRectify (CALIB_ZERO_DISPARITY, alpha = -1) and cv2.fisheye.stereoRectify, and by
points that both cameras see: undistorted and rectified by what the files say, they lie in one row, f·b/Z apart.
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


BAR = 'distortion = {{ model = "brown-conrady", k = [{}], p = [1e-3, -2e-3] }}'
RIGS = {
    # Of each camera: where it stands, what it looks at, changes.
    "side by side": ("calib3d", [([0, 0, 0], [0, 0, -1], []), ([0.12, 0, 0], [0.12, 0, -1], [])]),
    "turned": ("calib3d", [([0, 0, 0], [0.02, 0.03, -1], []), ([0.12, 0.01, -0.02], [0.05, -0.02, -1], ["lens.intrinsics.fx=510"])]),
    "right one first": ("calib3d", [([0.2, 0, 0], [0.1, 0, -1], []), ([0, 0.02, 0.01], [0.1, 0.05, -1], ["lens.intrinsics.cy=45"])]),
    "one above the other": ("calib3d", [([0, 0, 0], [0.02, 0, -1], []), ([0.01, -0.15, 0.02], [0.02, -0.1, -1], [])]),
    "three": ("calib3d", [([0, 0, 0], [0, 0, -1], []), ([0.12, 0, 0], [0.1, 0, -1], []), ([0.02, 0.2, 0], [0, 0.15, -1], [])]),
    "fisheyes": ("fisheye", [([0, 0, 0], [0.02, 0.03, -1], []), ([0.12, 0.01, -0.02], [0.05, -0.02, -1], [])]),
}
RIG_LENSES = {
    "calib3d": BAR.format("-0.1, 0.02"),
    "fisheye": 'distortion = { model = "kannala-brandt", k = [0.05, 0.01, -0.002, 0.0004] }',
}


def ros_matrices(path):
    file = yaml.safe_load(path.read_text())
    keys = ("camera_matrix", "distortion_coefficients", "rectification_matrix", "projection_matrix")
    return [np.array(file[key]["data"], float).reshape(file[key]["rows"], file[key]["cols"]) for key in keys]


def rigs(photosite):
    rng = np.random.default_rng(11)
    zero_disparity = getattr(cv2, "CALIB_ZERO_DISPARITY", getattr(cv2, "STEREO_ZERO_DISPARITY", None))
    for name, (model, cameras) in RIGS.items():
        with tempfile.TemporaryDirectory() as folder:
            folder = Path(folder)
            (folder / "capture.toml").write_text(
                '[scene]\nenvironment = { illuminant = "D65", illuminance_lux = 500 }\n'
                "[[targets]]\ntype = 'chessboard'\nname = 'board'\nsquares = [9, 6]\nsquare_mm = 30\n"
                "[camera]\nposition_m = [0.3, 1.2, 2.5]\nlook_at_m = [0.1, 0.4, -1]\n"
                f'[lens]\nfocus_distance_m = "infinity"\n{RIG_LENSES[model]}\n'
                "intrinsics = { fx = 100.25, fy = 101, cx = 65.5, cy = 47.25 }\n"
                "[sensor]\npreset = 'sony-imx249-mono'\nresolution_px = [128, 96]\n[exposure]\ntime_s = 0.004\n"
                "[render]\nsamples_per_pixel = 1\nmax_depth = 1\n[output]\nelectrons = false\n")
            names = [f"cam{i}" for i in range(len(cameras))]
            (folder / "set.toml").write_text("capture = 'capture.toml'\n" + "".join(
                f"[[cameras]]\nname = '{camera}'\nposition_m = {at}\nlook_at_m = {to}\nset = {changes}\n".replace("'", '"')
                for camera, (at, to, changes) in zip(names, cameras)))
            done = subprocess.run([photosite, "dataset", "set.toml", "-o", "out", "--quiet"], cwd=folder, capture_output=True, text=True)
            if done.returncode:
                sys.exit(done.stderr)
            files = folder / "out/calibration"
            chain = yaml.safe_load((files / "camchain.yaml").read_text())
            poses = [np.eye(4)]
            for camera in names[1:]:
                poses.append(np.array(chain[camera]["T_cn_cnm1"]) @ poses[-1])
            for other in range(1, len(names)):
                ros = files / "ros" / (f"cam0-{names[other]}" if len(names) > 2 else "")
                (k1, d1, r1, p1), (k2, d2, r2, p2) = [ros_matrices(ros / f"{names[i]}.yaml") for i in (0, other)]
                rotation, translation = poses[other][:3, :3].copy(), poses[other][:3, 3:].copy()
                stereo = cv2.FileStorage(str(files / f"opencv/stereo/cam0-{names[other]}.yaml"), cv2.FILE_STORAGE_READ)
                node = {key: stereo.getNode(key).mat() for key in "M1 D1 M2 D2 R T R1 R2 P1 P2 Q".split()}
                for key, wanted in dict(M1=k1, D1=d1, M2=k2, D2=d2, R=rotation, T=translation, R1=r1, R2=r2, P1=p1, P2=p2).items():
                    assert np.allclose(node[key].ravel(), wanted.ravel(), atol=1e-12, rtol=0), (name, key, node[key], wanted)
                vertical = name == "one above the other" or other == 2
                if model == "calib3d":
                    found = cv2.stereoRectify(k1, d1, k2, d2, (128, 96), rotation, translation, flags=zero_disparity, alpha=-1)
                else:
                    found = cv2.fisheye.stereoRectify(k1, d1, k2, d2, (128, 96), rotation, translation, flags=zero_disparity)
                error = max(np.abs(found[0] - r1).max(), np.abs(found[1] - r2).max())
                assert error < 1e-12, f"{name}: rectification is {error} off"
                if model == "calib3d":
                    # OpenCV takes corners through 32-bit floats: 1e-7 of 100 px, some times over.
                    error = max(np.abs(a - b).max() for a, b in ((found[2], p1), (found[3], p2), (found[4], node["Q"])))
                    assert error < 1e-4, f"{name}: P is {error} off"
                # Points before both cameras, through the whole chain.
                points = np.column_stack([rng.uniform(-0.3, 0.3, (40, 2)), rng.uniform(0.8, 3, 40)])
                seen = []
                for k, d, r, p, (turn, move) in ((k1, d1, r1, p1, (np.eye(3), np.zeros(3))), (k2, d2, r2, p2, (rotation, translation.ravel()))):
                    if model == "fisheye":
                        pixels = cv2.fisheye.projectPoints(points[None], cv2.Rodrigues(turn)[0], move, k, d.ravel())[0][0]
                        seen.append(cv2.fisheye.undistortPoints(pixels[:, None], k, d.ravel(), R=r, P=p[:, :3])[:, 0])
                    else:
                        pixels = cv2.projectPoints(points, cv2.Rodrigues(turn)[0], move, k, d)[0]
                        stop = (cv2.TERM_CRITERIA_COUNT + cv2.TERM_CRITERIA_EPS, 200, 1e-12)
                        seen.append(cv2.undistortPointsIter(pixels, k, d, r, p[:, :3], stop)[:, 0] if hasattr(cv2, "undistortPointsIter")
                                    else cv2.undistortPoints(pixels, k, d, R=r, P=p[:, :3], criteria=stop)[:, 0])
                along, across = (1, 0) if vertical else (0, 1)
                apart = seen[1] - seen[0]
                wanted = p2[along, 3] / (points @ r1.T)[:, 2]
                error = max(np.abs(apart[:, across]).max(), np.abs(apart[:, along] - wanted).max())
                print(f"rig {name}, {names[other]}: {error:.1e} px")
                assert error < 1e-5, f"{name}: points are {error} px off their row or disparity"
                assert abs(abs(p2[along, 3]) / p2[0, 0] - np.linalg.norm(translation)) < 1e-12 and p2[across, 3] == 0


def main(photosite):
    photosite = str(Path(photosite).resolve())
    rigs(photosite)
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
