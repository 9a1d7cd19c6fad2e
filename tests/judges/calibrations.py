"""Judges calibrations that photosite reads: cv2.FileStorage, YAML and pycolmap write them, and project the same points.

Usage: calibrations.py PHOTOSITE

Each lens of each format sees 1,000 points through a camera turned and moved at random. What photosite renders is what
`photosite project` says of it; both programs may differ by 1e-6 px. Models that photosite has not are refused by name.
"""

import copy
import subprocess
import sys
import tempfile
from pathlib import Path

import cv2
import numpy as np
import pycolmap
import yaml

POINTS = 1000
LARGEST_PX = 1e-6
SIZE = (640, 480)
MATRIX = np.array([[500.25, 0, 321.5], [0, 502.0, 238.125], [0, 0, 1]])
SHORT = [-0.1, 0.02, 1e-3, -2e-3]
CALIB3D = {
    "pinhole": [0.0] * 5,
    "radtan": SHORT + [0.005],
    "rational": [0.1, 0.02, 1e-3, -2e-3, 0.01, 0.3, 0.1, 0.02],
    "thin prism": [0.1, 0.02, 1e-3, -2e-3, 0.01, 0.3, 0.1, 0.02, 1e-3, -5e-4, 7e-4, 2e-4],
}
FISHEYE = [0.05, 0.01, -0.002, 0.0004]
COLMAP = {
    "SIMPLE_PINHOLE": [500, 321, 239], "PINHOLE": [500, 502, 321, 239], "SIMPLE_RADIAL": [500, 321, 239, -0.1],
    "RADIAL": [500, 321, 239, -0.1, 0.02], "OPENCV": [500, 502, 321, 239, *SHORT],
    "FULL_OPENCV": [500, 502, 321, 239, 0.1, 0.02, 1e-3, -2e-3, 0.01, 0.3, 0.1, 0.02],
    "SIMPLE_FISHEYE": [500, 321, 239], "FISHEYE": [500, 502, 321, 239], "SIMPLE_RADIAL_FISHEYE": [500, 321, 239, 0.05],
    "RADIAL_FISHEYE": [500, 321, 239, 0.05, 0.01], "OPENCV_FISHEYE": [500, 502, 321, 239, *FISHEYE],
    "SIMPLE_DIVISION": [500, 321, 239, -0.05], "DIVISION": [500, 502, 321, 239, 0.03],
}
REFUSED = {"FOV": 5, "THIN_PRISM_FISHEYE": 12, "RAD_TAN_THIN_PRISM_FISHEYE": 16, "EUCM": 6}


class Judge:
    def __init__(self, photosite, folder):
        self.photosite, self.folder = photosite, Path(folder)
        rng = np.random.default_rng(11)
        # World to camera, with points before it and within 30 degrees of its axis.
        self.turn, self.move = rng.uniform(-0.8, 0.8, 3), rng.uniform(-2, 2, 3)
        depth = rng.uniform(0.5, 8, POINTS)
        seen = np.column_stack([*rng.uniform(-0.55, 0.55, (2, POINTS)) * depth, depth])
        self.rotation = cv2.Rodrigues(self.turn)[0]
        self.points = (seen - self.move) @ self.rotation

    def run(self, calibration, camera_keys, lens_keys=""):
        """photosite project with a calibration; its pixels, or its error."""
        capture, points = self.folder / "capture.toml", self.folder / "points.csv"
        capture.write_text(
            f"[camera]\n{camera_keys}\n[lens]\ncalibration = '{calibration}'\n{lens_keys}\nfocus_distance_m = 'infinity'\n"
            f"[sensor]\nresolution_px = {list(SIZE)}\npixel_pitch_um = [5.0, 5.0]\n")
        points.write_text("\n".join(",".join(map(repr, map(float, point))) for point in self.points))
        done = subprocess.run([self.photosite, "project", capture, "--points", points], capture_output=True, text=True)
        if done.returncode:
            return done.stderr
        return np.array([[float(x) for x in line.split(",")] for line in done.stdout.split()])

    def compare(self, name, wanted, *arguments):
        found = self.run(*arguments)
        assert not isinstance(found, str), f"{name}: {found}"
        assert found.shape == wanted.shape == (POINTS, 2) and np.isfinite(found).all(), f"{name}: {found}"
        error = np.abs(found - wanted).max()
        print(f"{name}: {error:.1e} px")
        assert error <= LARGEST_PX, f"{name}: {error} px"

    def refused(self, name, *arguments, says):
        error = self.run(*arguments)
        assert isinstance(error, str) and says in error, f"{name}: {error}"
        print(f"{name}: refused")

    def by_opencv(self, model, coefficients, xi=None, pose=None):
        turn, move = pose or (self.turn, self.move)
        turn, move, c = turn.reshape(3, 1), move.reshape(3, 1), np.array(coefficients)
        if model == "fisheye":
            return cv2.fisheye.projectPoints(self.points[None], turn, move, MATRIX, c)[0][0]
        if model == "omnidir":
            return cv2.omnidir.projectPoints(self.points[None], turn, move, MATRIX, xi, c[None])[0][0]
        return cv2.projectPoints(self.points, turn, move, MATRIX, c)[0][:, 0]

    def opencv(self):
        lenses = [(name, "calib3d", c, None) for name, c in CALIB3D.items()]
        lenses += [("fisheye", "fisheye", FISHEYE, None), ("mirror", "omnidir", SHORT, 1.1)]
        for ending in ("yaml", "xml", "json"):
            for name, model, coefficients, xi in lenses:
                file = cv2.FileStorage(str(self.folder / f"camera.{ending}"), cv2.FILE_STORAGE_WRITE)
                for key, value in zip(("image_width", "image_height"), SIZE):
                    file.write(key, value)
                file.write("distortion_model", model)
                file.write("camera_matrix", MATRIX)
                file.write("distortion_coefficients", np.array(coefficients))
                file.write("rotation", self.rotation)
                file.write("translation_m", self.move)
                # As OpenCV's sample has the views; the first is another.
                view = np.concatenate([cv2.Rodrigues(self.rotation)[0].ravel(), self.move.ravel()])
                file.write("extrinsic_parameters", np.array([np.linspace(0.1, 0.6, 6), view]))
                if xi is not None:
                    file.write("xi", xi)
                file.release()
                wanted = self.by_opencv(model, coefficients, xi)
                self.compare(f"opencv {ending} {name}", wanted, f"camera.{ending}", "calibration_pose = 'world'")
                self.compare(f"opencv {ending} {name} view", wanted, f"camera.{ending}", "calibration_pose = 'view 1'")
        tilted = dict(camera_matrix=MATRIX.tolist(), dist=[[*CALIB3D["thin prism"], 0.01, 0.02]], image_size=list(SIZE))
        (self.folder / "tilted.yaml").write_text(yaml.safe_dump(tilted))
        self.refused("opencv tilted sensor", "tilted.yaml", "position_m = [0, 0, 0]\nlook_at_m = [0, 0, 1]", says="tilted")

    def pose_keys(self):
        """The pose as a capture has it."""
        centre = -self.rotation.T @ self.move
        return (f"position_m = {centre.tolist()}\nlook_at_m = {(centre + self.rotation[2]).tolist()}\n"
                f"up = {(-self.rotation[1]).tolist()}")

    def ros(self):
        for name, model, coefficients in [("pinhole", "plumb_bob", CALIB3D["pinhole"]), ("radtan", "plumb_bob", CALIB3D["radtan"]),
                                          ("rational", "rational_polynomial", CALIB3D["rational"]), ("fisheye", "equidistant", FISHEYE)]:
            matrix = lambda rows, values: dict(rows=rows, cols=len(values) // rows, data=[float(v) for v in values])
            file = dict(image_width=SIZE[0], image_height=SIZE[1], camera_name="c", distortion_model=model,
                        camera_matrix=matrix(3, MATRIX.ravel()), distortion_coefficients=matrix(1, coefficients),
                        rectification_matrix=matrix(3, np.eye(3).ravel()),
                        projection_matrix=matrix(3, np.column_stack([MATRIX, np.zeros(3)]).ravel()))
            (self.folder / "info.yaml").write_text(yaml.safe_dump(file))
            wanted = self.by_opencv("fisheye" if model == "equidistant" else "calib3d", coefficients)
            self.compare(f"ros {name}", wanted, "info.yaml", self.pose_keys())

    def kalibr(self):
        """The camera of a rig whose first is the world, and from an IMU."""
        pose = np.eye(4)
        pose[:3, :3], pose[:3, 3] = self.rotation, self.move
        matrix = [float(x) for x in (MATRIX[0, 0], MATRIX[1, 1], MATRIX[0, 2], MATRIX[1, 2])]
        for name, camera, model, coefficients, opencv, xi in [
            ("none", "pinhole", "none", [], "calib3d", None), ("radtan", "pinhole", "radtan", SHORT, "calib3d", None),
            ("equidistant", "pinhole", "equidistant", FISHEYE, "fisheye", None), ("omni", "omni", "radtan", SHORT, "omnidir", 1.1)]:
            one = dict(camera_model=camera, intrinsics=([xi] if xi else []) + matrix, distortion_model=model,
                       distortion_coeffs=coefficients, resolution=list(SIZE), rostopic="/c", T_cam_imu=np.eye(4).tolist())
            # A copy: PyYAML writes what two tables share as an anchor, which Kalibr's files do not have.
            two = copy.deepcopy(dict(one, T_cn_cnm1=pose.tolist(), T_cam_imu=pose.tolist()))
            for flow in (False, None):
                (self.folder / "camchain.yaml").write_text(yaml.safe_dump(dict(cam0=one, cam1=two), default_flow_style=flow))
                wanted = self.by_opencv(opencv, coefficients or [0.0] * 4, xi)
                keys = ("calibration_pose = 'imu'", "calibration_camera = 'cam1'")
                self.compare(f"kalibr {name} from the IMU", wanted, "camchain.yaml", *keys)
            # The first camera stands upright at the origin: its axes are those of OpenCV with half a turn about x.
            half = np.diag([1.0, -1.0, -1.0])
            rotation = self.rotation @ half
            points, self.points = self.points, self.points @ half
            wanted = self.by_opencv(opencv, coefficients or [0.0] * 4, xi, (cv2.Rodrigues(rotation)[0].ravel(), self.move))
            self.compare(f"kalibr {name} from the first", wanted, "camchain.yaml", "calibration_pose = 'cam0'", "calibration_camera = 'cam1'")
            self.points = points
        for model in ("eucm", "ds"):
            (self.folder / "camchain.yaml").write_text(yaml.safe_dump(dict(cam0=dict(one, camera_model=model))))
            self.refused(f"kalibr {model}", "camchain.yaml", self.pose_keys(), says=f"no camera model \"{model}\"")
        (self.folder / "camchain.yaml").write_text(yaml.safe_dump(dict(cam0=dict(one, camera_model="pinhole", intrinsics=matrix, distortion_model="fov"))))
        self.refused("kalibr fov", "camchain.yaml", self.pose_keys(), says="no distortion model \"fov\"")

    def rig(self):
        """A data set whose rig is a chain of Kalibr's writes the same chain, wherever the rig stands."""
        matrix = [100.25, 101.0, 65.5, 47.25]
        turns = [cv2.Rodrigues(np.array(turn))[0] for turn in ([0.02, -0.05, 0.01], [-0.03, 0.04, 0.02])]
        chain = {}
        for number in range(3):
            chain[f"cam{number}"] = dict(
                camera_model="pinhole", intrinsics=[x + number for x in matrix], distortion_model="radtan",
                distortion_coeffs=[-0.05, 0.01, 1e-3, -1e-3], resolution=[128, 96], rostopic="/c")
            if number:
                pose = np.eye(4)
                pose[:3, :3], pose[:3, 3] = turns[number - 1], [-0.1, 0.01 * number, 0.002]
                chain[f"cam{number}"]["T_cn_cnm1"] = pose.tolist()
        (self.folder / "chain.yaml").write_text(yaml.safe_dump(chain))
        (self.folder / "rig.toml").write_text(
            '[scene]\nenvironment = { illuminant = "D65", illuminance_lux = 500 }\n'
            "[[targets]]\ntype = 'chessboard'\nname = 'board'\nsquares = [9, 6]\nsquare_mm = 30\n"
            "[lens]\ncalibration = 'chain.yaml'\nfocus_distance_m = 'infinity'\n"
            "[sensor]\npreset = 'sony-imx249-mono'\nresolution_px = [128, 96]\n[exposure]\ntime_s = 0.004\n"
            "[render]\nsamples_per_pixel = 1\nmax_depth = 1\n[output]\nelectrons = false\n")
        cameras = "".join(
            f"[[cameras]]\nname = '{name}'\nset = ['lens.calibration_camera={name}', 'camera.calibration_pose=cam0']\n"
            for name in chain)
        poses = "[poses]\nlist = [{ position_m = [0.3, 1.2, 2.5], look_at_m = [0.1, 0.4, -1] }]\n"
        for name, more in (("where it stands", ""), ("at a pose", poses)):
            (self.folder / "set.toml").write_text(f"capture = 'rig.toml'\n{cameras}{more}")
            out = self.folder / f"set {name}"
            done = subprocess.run([self.photosite, "dataset", self.folder / "set.toml", "-o", out, "--quiet"], capture_output=True, text=True)
            assert done.returncode == 0, done.stderr
            found = yaml.safe_load((out / "calibration/camchain.yaml").read_text())
            for camera, wanted in chain.items():
                for key in ("intrinsics", "distortion_coeffs", "T_cn_cnm1"):
                    if key in wanted:
                        error = np.abs(np.array(found[camera][key]) - np.array(wanted[key])).max()
                        assert error < 1e-9, f"rig {name}: {camera}.{key} is {error} off"
            print(f"rig {name}: the same chain")

    def colmap(self):
        seen = self.points @ self.rotation.T + self.move
        pose = pycolmap.Rigid3d(pycolmap.Rotation3d(self.rotation), self.move)
        for model, parameters in COLMAP.items():
            camera = pycolmap.Camera(camera_id=3, model=model, width=SIZE[0], height=SIZE[1], params=parameters)
            x, y, z, w = pose.rotation.quat
            (self.folder / "cameras.txt").write_text("# Camera list\n3 {} {} {} {}\n".format(model, *SIZE, " ".join(map(repr, map(float, camera.params)))))
            (self.folder / "images.txt").write_text("# Image list\n1 {} 3 a picture.png\n\n".format(
                " ".join(repr(float(v)) for v in (w, x, y, z, *self.move))))
            wanted = np.array(camera.img_from_cam(seen)) - 0.5
            self.compare(f"colmap {model}", wanted, "cameras.txt", "calibration_pose = 'a picture.png'")
        for model, count in REFUSED.items():
            (self.folder / "cameras.txt").write_text(f"3 {model} 640 480 {' '.join(['0.1'] * count)}\n")
            self.refused(f"colmap {model}", "cameras.txt", self.pose_keys(), says=f"no camera model \"{model}\"")


def main(photosite):
    with tempfile.TemporaryDirectory() as folder:
        judge = Judge(str(Path(photosite).resolve()), folder)
        judge.opencv()
        judge.ros()
        judge.kalibr()
        judge.rig()
        judge.colmap()


if __name__ == "__main__":
    main(*sys.argv[1:])
