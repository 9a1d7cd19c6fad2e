"""Judges epipolar geometry, rectified images and depth by OpenCV and NumPy.

Usage: stereo.py PHOTOSITE

A rig looks at a chessboard in the plane z = 0. E, F and the epipoles are held against NumPy and cv2.computeCorrespondEpilines,
rectified images against cv2.initUndistortRectifyMap with cv2.remap (cv2.fisheye for fisheyes, cv2.warpPerspective for plain
pinholes), their valid regions against cv2.stereoRectify, depth and disparity against the plane of the board and
cv2.reprojectImageTo3D, and corners that cv2.findChessboardCorners finds in both images against each other.
"""

import json
import subprocess
import sys
import tempfile
from pathlib import Path

import cv2
import numpy as np
import OpenEXR

SIZE = (320, 240)
CAPTURE = """[[targets]]
type = "chessboard"
name = "board"
squares = [9, 6]
square_mm = 60
[materials]
board-white.emission = {{ luminance_nit = 300 }}
board-black.emission = {{ luminance_nit = 10 }}
[camera]
position_m = [-0.06, 0, 0.65]
look_at_m = [0, 0, 0]
[lens]
type = "pinhole"
focus_distance_m = "infinity"
{}
intrinsics = {{ fx = 250.25, fy = 251, cx = 161.5, cy = 118.25 }}
[sensor]
preset = "sony-imx249-mono"
resolution_px = [320, 240]
pixel_pitch_um = [20, 20]
[exposure]
auto = true
[render]
samples_per_pixel = 16
max_depth = 1
[output]
electrons = false
truth = [{}]
"""
SIDE = "position_m = [0.12, 0.004, -0.006]\nlook_at_m = [0.02, 0.02, -1]\nup = [0.05, 1, 0]\n"
ABOVE = "position_m = [0.004, -0.1, -0.006]\nlook_at_m = [0.02, 0.02, -1]\n"
BAR = 'distortion = { model = "brown-conrady", k = [-0.1, 0.02], p = [1e-3, -2e-3] }'
FISHEYE = 'distortion = { model = "kannala-brandt", k = [0.05, 0.01, -0.002, 0.0004] }'
RIGS = {
    # Lens, the other camera, layers of truth.
    "brown-conrady": (BAR, SIDE, '"depth", "normal"'),
    "fisheye": (FISHEYE, SIDE, '"depth", "normal"'),
    "pinhole": ("", SIDE, '"depth"'),
    "above": (BAR, ABOVE, '"depth", "normal"'),
}


def run(*arguments):
    done = subprocess.run([str(argument) for argument in arguments], capture_output=True, text=True)
    if done.returncode:
        sys.exit(f"{arguments}: {done.stderr}")
    return done.stdout


def nodes(path):
    file = cv2.FileStorage(str(path), cv2.FILE_STORAGE_READ)
    return {key: file.getNode(key).mat() for key in "M1 D1 M2 D2 R T E F e1 e2 R1 R2 P1 P2 H1 H2 Q".split()}


def planes(path):
    return {name: channel.pixels for name, channel in OpenEXR.File(str(path), separate_channels=True).channels().items()}


def linear(picture, x, y):
    """The image at places between its pixels; those beyond it are NaN."""
    rows, columns = picture.shape
    inside = (x >= 0) & (y >= 0) & (x <= columns - 1) & (y <= rows - 1)
    x, y = np.clip(x, 0, columns - 1.001), np.clip(y, 0, rows - 1.001)
    i, j = x.astype(int), y.astype(int)
    s, t = x - i, y - j
    value = (1 - t) * ((1 - s) * picture[j, i] + s * picture[j, i + 1]) + t * ((1 - s) * picture[j + 1, i] + s * picture[j + 1, i + 1])
    return np.where(inside, value, np.nan)


def epipolar(name, node, reports, is_fisheye):
    t, r = node["T"].ravel(), node["R"]
    cross = np.array([[0, -t[2], t[1]], [t[2], 0, -t[0]], [-t[1], t[0], 0]])
    e = cross @ r
    f = np.linalg.inv(node["M2"]).T @ e @ np.linalg.inv(node["M1"])
    assert np.abs(node["E"] - e).max() < 1e-15 and np.abs(node["F"] - f).max() < 1e-15, name
    for key, matrix in (("e1", f), ("e2", f.T)):
        null, found = np.linalg.svd(matrix)[2][2], node[key].ravel()
        assert 1 - abs(null @ found) / np.linalg.norm(found) < 1e-9, (name, key)
    points = []
    for report, k, d in zip(reports, ("M1", "M2"), ("D1", "D2")):
        pixels = np.array(report["targets"][0]["points_px"])[:, None]
        if is_fisheye:
            points.append(cv2.fisheye.undistortPoints(pixels, node[k], node[d].ravel(), P=node[k]))
        else:
            stop = (cv2.TERM_CRITERIA_COUNT + cv2.TERM_CRITERIA_EPS, 200, 1e-12)
            points.append(cv2.undistortPoints(pixels, node[k], node[d], P=node[k], criteria=stop))
    lines = cv2.computeCorrespondEpilines(points[0], 1, node["F"])[:, 0]
    distance = np.abs((lines[:, :2] * points[1][:, 0]).sum(1) + lines[:, 2]).max()
    print(f"{name}: points are {distance:.1e} px off their epipolar lines")
    assert distance < 1e-4, name
    return points


def rectified(name, node, folder, out, report, is_fisheye):
    vertical = report["is_vertical"]
    undistorted = []
    for i, camera in ((1, "left"), (2, "right")):
        k, d, r, p = (node[f"{key}{i}"] for key in "MDRP")
        picture = cv2.imread(str(folder / camera / "000000/image.png"), cv2.IMREAD_UNCHANGED).astype(np.float32)
        found = cv2.imread(str(out / camera / "000000/image.png"), cv2.IMREAD_UNCHANGED).astype(np.float32)
        # The offset of P2 is of points, not of directions.
        p = p[:, :3]
        if is_fisheye:
            maps = cv2.fisheye.initUndistortRectifyMap(k, d.ravel(), r, p, SIZE, cv2.CV_32FC1)
        else:
            maps = cv2.initUndistortRectifyMap(k, d, r, p, SIZE, cv2.CV_32FC1)
        wanted = linear(picture, maps[0].astype(float), maps[1].astype(float))
        seen = np.isfinite(wanted)
        assert seen.mean() > 0.8, (name, seen.mean())
        # Half a code of rounding, and places of hundreds of pixels in 32-bit floats times edges of 255 codes.
        off = np.abs(found - wanted)[seen].max()
        assert off < 0.51, f"{name}: {camera} is {off} codes off"
        # OpenCV rounds places to 1/32 px: up to 1/64 along both axes.
        by_opencv = cv2.remap(picture, maps[0], maps[1], cv2.INTER_LINEAR)
        kernel = np.ones((5, 5), np.uint8)
        spread = cv2.dilate(found, kernel) - cv2.erode(found, kernel)
        assert (np.abs(found - by_opencv) <= 1 + spread / 32)[seen].all(), name
        print(f"{name}: {camera} is {off:.2f} codes off, where rounding is 0.5; OpenCV's own by {np.abs(found - by_opencv)[seen].max():.1f}")
        # Beyond the image: black, but for the half of the outermost pixels that has no neighbours to be mixed with.
        beyond = (maps[0] < -0.5) | (maps[1] < -0.5) | (maps[0] > SIZE[0] - 0.5) | (maps[1] > SIZE[1] - 0.5)
        assert (found[beyond] == 0).all(), name
        part = 1 - beyond.mean()
        assert abs(part - report["valid_part"][i - 1]) < 1e-4, (name, part, report["valid_part"])
        if name == "pinhole":
            by_homography = cv2.warpPerspective(picture, node[f"H{i}"], SIZE, flags=cv2.INTER_LINEAR)
            assert (np.abs(found - by_homography) <= 1 + spread / 32)[seen].all(), name
        undistorted.append(found.astype(np.uint8))
    if not is_fisheye:
        zero_disparity = getattr(cv2, "CALIB_ZERO_DISPARITY", getattr(cv2, "STEREO_ZERO_DISPARITY", None))
        matrices = [node[key] for key in "M1 D1 M2 D2".split()]
        roi = cv2.stereoRectify(*matrices, SIZE, node["R"], node["T"], flags=zero_disparity, alpha=-1)[5:7]
        # OpenCV looks at nine points of each edge.
        off = np.abs(np.array(roi) - np.array(report["valid_region_px"])).max()
        print(f"{name}: valid regions {report['valid_region_px']}, OpenCV's {roi}")
        assert off <= 2, (name, roi, report["valid_region_px"])
    found = []
    for picture in undistorted:
        ok, corners = cv2.findChessboardCorners(picture, (8, 5))
        assert ok, name
        stop = (cv2.TERM_CRITERIA_COUNT + cv2.TERM_CRITERIA_EPS, 50, 1e-4)
        found.append(cv2.cornerSubPix(picture, corners, (4, 4), (-1, -1), stop).reshape(-1, 2))
    across = (found[0] - found[1])[:, 0 if vertical else 1]
    print(f"{name}: detected corners differ by {np.sqrt((across**2).mean()):.3f} px across rows")
    # What detection leaves of corners of 10 grey levels of noise on 8 bits.
    assert np.sqrt((across**2).mean()) < 0.15, name


def depths(name, photosite, node, out, report, reports, has_normals):
    x, y = np.meshgrid(np.arange(SIZE[0]), np.arange(SIZE[1]))
    focal, (cx, cy), baseline = report["focal_length_px"], report["principal_point_px"], report["baseline_m"]
    rays = np.stack([(x - cx) / focal, (y - cy) / focal, np.ones_like(x, float)], -1)
    for i, camera in enumerate(("left", "right")):
        truth = planes(out / camera / "000000/truth.exr")
        depth, disparity = truth["depth"].astype(float), truth["disparity"].astype(float)
        seen = np.isfinite(depth)
        assert 0.2 < seen.mean() and (disparity[~seen] == 0).all(), name
        # The plane z = 0 of the world.
        camera_report = reports[i]["camera"]
        to_world = np.array(camera_report["rotation"]).T @ np.array(report["rotations"][i]).T
        wanted = -camera_report["position_m"][2] / (rays @ to_world.T)[..., 2]
        off = np.abs(depth / wanted - 1)[seen].max()
        print(f"{name}: depth of {camera} is {off:.1e} of itself off")
        # 32-bit floats; without normals, what the board's depth changes over half a pixel: its tilt over the focal length.
        assert off < (2e-6 if has_normals else 0.01), name
        assert np.abs(disparity[seen] * depth[seen] / (focal * baseline) - 1).max() < 1e-6, name
        if i == 0:
            again = nodes(out / "stereo.yaml")
            for key in ("P1", "P2", "Q"):
                assert np.abs(again[key] - node[key]).max() < 1e-9, (name, key)
            by_opencv = cv2.reprojectImageTo3D(truth["disparity"].astype(np.float32), node["Q"])[..., 2]
            assert np.abs(by_opencv[seen] / depth[seen] - 1).max() < 1e-6, name
    # A map of a matcher: floats, and whole numbers of 1/16 px.
    for step in (None, 0.0625):
        matched = np.random.default_rng(3).uniform(-3, 60, SIZE[::-1]).astype(np.float32)
        if step:
            matched = (matched.clip(0) / step).astype(np.uint16)
        np.save(out / "matched.npy", matched)
        options = ["--disparity-step-px", step] if step else []
        run(photosite, "depth", out / "matched.npy", "--rectified", out, "-o", out / "z.npy", "--force", "--quiet", *options)
        found = np.load(out / "z.npy")
        disparity = matched.astype(np.float32) * np.float32(step or 1)
        by_opencv = cv2.reprojectImageTo3D(disparity, node["Q"])[..., 2]
        assert (np.isinf(found) == (disparity <= 0)).all(), name
        seen = disparity > 0
        assert np.abs(found[seen] / by_opencv[seen] - 1).max() < 1e-6, name
        run(photosite, "depth", out / "z.npy", "--rectified", out, "--inverse", "-o", out / "d.npy", "--force", "--quiet")
        assert np.abs(np.load(out / "d.npy")[seen] / disparity[seen] - 1).max() < 1e-6, name


def main(photosite):
    photosite = str(Path(photosite).resolve())
    for name, (lens, other, truth) in RIGS.items():
        with tempfile.TemporaryDirectory() as scratch:
            scratch = Path(scratch)
            (scratch / "capture.toml").write_text(CAPTURE.format(lens, truth))
            (scratch / "set.toml").write_text(
                f'capture = "capture.toml"\n[[cameras]]\nname = "left"\n[[cameras]]\nname = "right"\n{other}')
            folder, out = scratch / "rig", scratch / "rectified"
            run(photosite, "dataset", scratch / "set.toml", "-o", folder, "--quiet")
            report = json.loads(run(photosite, "rectify", folder, "-o", out, "--json"))
            node = nodes(folder / "calibration/opencv/stereo/left-right.yaml")
            reports = [json.loads((folder / camera / "000000/capture.json").read_text()) for camera in ("left", "right")]
            is_fisheye = name == "fisheye"
            epipolar(name, node, reports, is_fisheye)
            rectified(name, node, folder, out, report, is_fisheye)
            depths(name, photosite, node, out, report, reports, "normal" in truth)


if __name__ == "__main__":
    main(*sys.argv[1:])
