"""Judges the layouts of data sets by readers that others wrote: pycolmap, pycocotools, PyYAML, OpenCV; BOP by its documented
formulas. Every layout must put the corners of the targets where capture.json has them.

Usage: layouts.py PHOTOSITE
"""

import csv
import json
import subprocess
import sys
import tempfile
from pathlib import Path

import cv2
import numpy as np
import pycolmap
import yaml
from pycocotools import mask as coco_mask
from pycocotools.coco import COCO

SIZE = (160, 120)
# Both sides calculate in double precision, from numbers that are written with all digits.
PIXELS = 1e-6

CAPTURE = """
[scene]
geometry = ["block.obj"]
environment = { illuminant = "D65", illuminance_lux = 500 }
[[targets]]
type = "chessboard"
name = "board"
squares = [6, 5]
square_mm = 40
position_m = [0.1, 0.05, -0.1]
look_at_m = [0.2, 0.3, 2]
[[targets]]
type = "aprilgrid"
name = "tags"
tags = [3, 2]
tag_mm = 50
position_m = [-0.25, 0.0, -0.3]
look_at_m = [0, 0.2, 2]
[camera]
position_m = [0, 0, 1.2]
look_at_m = [0, 0, 0]
[lens]
type = "pinhole"
f_number = 4
focus_distance_m = "infinity"
intrinsics = { fx = 150.5, fy = 151, cx = 82.5, cy = 58.25 }
[sensor]
preset = "sony-imx249-mono"
resolution_px = [160, 120]
[exposure]
time_s = 0.004
[render]
samples_per_pixel = 1
max_depth = 2
[output]
electrons = false
truth = ["depth", "instance"]
truth_formats = ["exr", "npy"]
"""
# A block before the chessboard.
BLOCK = "o block\n" + "".join(
    f"v {x} {y} {z}\n" for x in (0.1, 0.2) for y in (-0.05, 0.1) for z in (0.2, 0.3)
) + "f 1 2 4 3\nf 5 7 8 6\nf 1 5 6 2\nf 3 4 8 7\nf 1 3 7 5\nf 2 6 8 4\n"
RIG = """
capture = "capture.toml"
frames = 4
[[cameras]]
name = "left"
[[cameras]]
name = "right"
position_m = [0.12, 0.01, -0.02]
look_at_m = [0.05, 0, -1]
up = [0.05, 1, 0]
"""
STILL = RIG + """
[poses.random]
look_at_m = [0, 0, -0.1]
distance_m = [0.9, 1.3]
tilt_deg = [0, 35]
margin_px = 30
"""
MOVING = RIG + """
[poses.trajectory]
frame_rate_hz = 10
poses = [
  { time_s = 0, position_m = [-0.1, 0, 1.2], look_at_m = [0, 0, 0] },
  { time_s = 1, position_m = [0.3, 0.2, 1.2], look_at_m = [0.1, 0, 0] },
]
"""
DISTORTION = "lens.distortion={ model = 'brown-conrady', k = [-0.1, 0.02], p = [1e-3, -2e-3] }"


def run(*command):
    done = subprocess.run([str(part) for part in command], capture_output=True, text=True)
    if done.returncode:
        sys.exit(f"{command}: {done.stderr}")


class Set:
    """A data set, with what its own reports say."""

    def __init__(self, photosite, folder, name, text, *overrides):
        self.photosite, self.folder = photosite, folder / name
        (folder / f"{name}.toml").write_text(text)
        run(photosite, "dataset", folder / f"{name}.toml", "-o", self.folder, "--quiet", *(x for o in overrides for x in ("--set", o)))
        self.lines = [json.loads(line) for line in (self.folder / "manifest.jsonl").read_text().splitlines()]
        assert [(line["frame"], line["camera"]) for line in self.lines] == [(f, c) for f in range(4) for c in ("left", "right")]
        self.reports = {(line["camera"], line["frame"]): json.loads((self.folder / line["folder"] / "capture.json").read_text())
                        for line in self.lines}

    def layout(self, kind):
        out = self.folder.with_name(f"{self.folder.name}-{kind}")
        run(self.photosite, "layout", self.folder, "--format", kind, "-o", out, "--quiet")
        return out

    def path(self, camera, frame, name):
        return self.folder / camera / f"{frame:06}" / name

    def corners(self, camera, frame):
        """All points of targets in the world and in the image, with whether they are visible."""
        targets = self.reports[camera, frame]["targets"]
        joined = lambda key: np.concatenate([np.array(target[key], float) for target in targets])
        return joined("points_world_m"), joined("points_px"), joined("points_visible").astype(bool)


def close(what, found, wanted, limit=PIXELS):
    error = np.abs(np.asarray(found) - np.asarray(wanted)).max()
    print(f"{what}: {error:.1e}")
    if not error <= limit:
        sys.exit(f"{what}: off by {error}, which is more than {limit}")


def project(points, from_world, matrix, coefficients):
    rotation, _ = cv2.Rodrigues(from_world[:3, :3])
    return cv2.projectPoints(points, rotation, from_world[:3, 3], matrix, np.asarray(coefficients, float))[0][:, 0]


def matrix_of(fx, fy, cx, cy):
    return np.array([[fx, 0, cx], [0, fy, cy], [0, 0, 1.0]])


def same_grey(made, camera, frame, path):
    found, wanted = cv2.imread(str(path), cv2.IMREAD_UNCHANGED), cv2.imread(str(made.path(camera, frame, "image.png")), 0)
    assert found.dtype == np.uint8 and np.array_equal(found, wanted), path


def colmap(made):
    out = made.layout("colmap")
    model = pycolmap.Reconstruction(str(out / "sparse/0"))
    assert len(model.images) == 8 and len(model.cameras) == 2 and len(model.points3D) > 40
    worst = []
    for image in model.images.values():
        camera, frame = image.name.split("/")[0], int(image.name.split("/")[1][:6])
        assert (out / "images" / image.name).read_bytes() == made.path(camera, frame, "image.png").read_bytes()
        pose = image.cam_from_world() if callable(image.cam_from_world) else image.cam_from_world
        world, pixels, visible = made.corners(camera, frame)
        in_camera = world @ pose.rotation.matrix().T + pose.translation
        # COLMAP counts from the corner of the first pixel.
        found = np.array([model.cameras[image.camera_id].img_from_cam(point) for point in in_camera]).reshape(-1, 2) - 0.5
        worst.append(np.abs(found - pixels).max())
        assert len(image.points2D) == visible.sum()
        close_to = np.array([point.xy for point in image.points2D]) - 0.5
        points = np.array([model.points3D[point.point3D_id].xyz for point in image.points2D])
        worst.append(np.abs(close_to - pixels[visible]).max())
        worst.append(np.abs(points - world[visible]).max())
    close("colmap: corners", max(worst), 0)
    assert sum(point.track.length() for point in model.points3D.values()) == sum(made.corners(*key)[2].sum() for key in made.reports)


def euroc(made, velocity, limit=PIXELS):
    mav = made.layout("euroc") / "mav0"
    rows = list(csv.reader((mav / "state_groundtruth_estimate0/data.csv").open()))
    assert len(rows[0]) == 17 and rows[0][0] == "#timestamp"
    states = {int(row[0]): np.array(row[1:], float) for row in rows[1:]}
    assert list(states) == sorted(states) and len(states) == 4
    worst = []
    for number, camera in enumerate(("left", "right")):
        sensor = yaml.safe_load((mav / f"cam{number}/sensor.yaml").read_text())
        to_body = np.array(sensor["T_BS"]["data"]).reshape(4, 4)
        assert sensor["resolution"] == list(SIZE) and sensor["sensor_type"] == "camera"
        assert number or np.allclose(to_body, np.eye(4), atol=1e-12)
        listed = list(csv.reader((mav / f"cam{number}/data.csv").open()))
        assert listed[0] == ["#timestamp [ns]", "filename"] and [int(row[0]) for row in listed[1:]] == list(states)
        for frame, (stamp, name) in enumerate(listed[1:]):
            same_grey(made, camera, frame, mav / f"cam{number}/data" / name)
            state = states[int(stamp)]
            w, *v = state[3:7]
            # A quaternion as a matrix: R = (w² − v·v)·1 + 2·v·vᵀ + 2·w·[v]ₓ.
            v, cross = np.array(v), np.array([[0, -v[2], v[1]], [v[2], 0, -v[0]], [-v[1], v[0], 0]])
            to_world = np.eye(4)
            to_world[:3, :3] = (w * w - v @ v) * np.eye(3) + 2 * np.outer(v, v) + 2 * w * cross
            to_world[:3, 3] = state[:3]
            world, pixels, _ = made.corners(camera, frame)
            found = project(world, np.linalg.inv(to_world @ to_body), matrix_of(*sensor["intrinsics"]), sensor["distortion_coefficients"])
            worst.append(np.abs(found - pixels).max())
            if not number:
                # A difference of 1e-4 s of positions of about 1 m, with 16 digits.
                assert np.allclose(state[7:10], velocity, atol=1e-10), state[7:10]
    close(f"euroc {made.folder.name}: corners", max(worst), 0, limit)


def kalibr(made):
    out = made.layout("kalibr")
    chain = yaml.safe_load((out / "camchain.yaml").read_text())
    worst = []
    for frame in range(4):
        report = made.reports["left", frame]["camera"]
        pose = np.eye(4)
        pose[:3, :3], pose[:3, 3] = report["rotation"], report["translation_m"]
        for number, camera in enumerate(("left", "right")):
            block = chain[f"cam{number}"]
            if number:
                pose = np.array(block["T_cn_cnm1"]) @ pose
            world, pixels, _ = made.corners(camera, frame)
            found = project(world, pose, matrix_of(*block["intrinsics"]), block["distortion_coeffs"])
            worst.append(np.abs(found - pixels).max())
            names = sorted(path.name for path in (out / f"cam{number}").iterdir())
            assert len(names) == 4 and all(int(name[:-13]) > 0 and len(name[-13:-4]) == 9 for name in names)
            same_grey(made, camera, frame, out / f"cam{number}" / names[frame])
    close("kalibr: corners", max(worst), 0)
    targets = {target["name"]: np.array([point["xy_mm"] for point in target["points"]]) / 1e3
               for target in made.reports["left", 0]["targets"]}
    board, tags = (yaml.safe_load((out / f"target-{name}.yaml").read_text()) for name in ("board", "tags"))
    # Kalibr's checkerboard: inner corners in rows.
    assert board["target_type"] == "checkerboard"
    rows, columns = board["targetRows"], board["targetCols"]
    grid = [(c * board["colSpacingMeters"], r * board["rowSpacingMeters"]) for r in range(rows) for c in range(columns)]
    close("kalibr: checkerboard", grid, targets["board"], 1e-9)
    # Kalibr's aprilgrid: corners in rows from the bottom left, y up; ours points down.
    assert tags["target_type"] == "aprilgrid"
    side, gap = tags["tagSize"], tags["tagSize"] * tags["tagSpacing"]
    along = lambda i: (i // 2) * (side + gap) + (i % 2) * side
    grid = [(along(c), -along(r)) for r in range(2 * tags["tagRows"]) for c in range(2 * tags["tagCols"])]
    close("kalibr: aprilgrid", grid, targets["tags"], 1e-9)


def objects_of(report):
    """The numbers that are those of one name in one place."""
    numbers = {}
    for i, (name, place) in enumerate(zip(report["truth"]["instances"], report["truth"]["instances_to_world"])):
        numbers.setdefault((name, json.dumps(place)), []).append(i + 1)
    return {name: found for (name, _), found in numbers.items()}


def coco(made):
    out = made.layout("coco")
    data = COCO(str(out / "annotations/instances.json"))
    assert len(data.imgs) == 8
    seen = 0
    for image in data.imgs.values():
        camera, frame = image["file_name"].split("/")[0], int(image["file_name"].split("/")[1][:6])
        assert (image["width"], image["height"]) == SIZE and (out / "images" / image["file_name"]).is_file()
        instance = np.load(made.path(camera, frame, "truth-instance.npy"))
        objects = objects_of(made.reports[camera, frame])
        found = {}
        for annotation in data.loadAnns(data.getAnnIds(imgIds=image["id"])):
            category = data.cats[annotation["category_id"]]
            found[category["name"]] = annotation
            mask = np.isin(instance, objects[category["name"]])
            assert np.array_equal(data.annToMask(annotation).astype(bool), mask)
            packed = data.annToRLE(annotation)
            assert annotation["area"] == coco_mask.area(packed) == mask.sum()
            assert annotation["bbox"] == list(coco_mask.toBbox(packed))
            if category["supercategory"] != "target":
                continue
            target = next(t for t in made.reports[camera, frame]["targets"] if t["name"] == category["name"])
            assert category["keypoints"] == [point["name"] for point in target["points"]]
            points = np.array(annotation["keypoints"], float).reshape(-1, 3)
            assert annotation["num_keypoints"] == (points[:, 2] > 0).sum()
            visible, pixels = np.array(target["points_visible"]), np.array(target["points_px"])
            within = ((pixels >= -0.5) & (pixels < np.array(SIZE) - 0.5)).all(axis=1)
            assert np.array_equal(points[:, 2], np.where(visible, 2, np.where(within, 1, 0)))
            assert np.array_equal(points[within, :2], pixels[within]) and not points[~within].any()
            seen += visible.sum()
        assert found.keys() == {name for name, numbers in objects.items() if np.isin(instance, numbers).any()}
    print(f"coco: {len(data.anns)} masks and {seen} key points")


def vertices(path):
    """x, y, z of an ascii PLY file."""
    head, body = path.read_text().split("end_header\n")
    count = int(next(line.split()[2] for line in head.splitlines() if line.startswith("element vertex")))
    return np.array([line.split()[:3] for line in body.splitlines()[:count]], float)


def bop(made):
    out = made.layout("bop")
    models = {int(key): value for key, value in json.loads((out / "models/models_info.json").read_text()).items()}
    meshes = {number: vertices(out / f"models/obj_{number:06}.ply") for number in models}
    assert sorted(models) == [1, 2, 3]
    for number, points in meshes.items():
        wanted = np.linalg.norm(points[:, None] - points[None], axis=2).max()
        assert abs(models[number]["diameter"] - wanted) < 1e-3, "floats of PLY files have 7 digits"
    width, height = SIZE
    corners, checked = [], 0
    for scene, camera in enumerate(("left", "right")):
        folder = out / f"train/{scene:06}"
        cameras, poses, infos = (json.loads((folder / f"scene_{kind}.json").read_text()) for kind in ("camera", "gt", "gt_info"))
        for frame in range(4):
            same_grey(made, camera, frame, folder / f"gray/{frame:06}.png")
            block = cameras[str(frame)]
            matrix = np.array(block["cam_K"]).reshape(3, 3)
            from_world = np.array(block["cam_R_w2c"]).reshape(3, 3), np.array(block["cam_t_w2c"])
            world, pixels, _ = made.corners(camera, frame)
            in_camera = (world * 1e3 @ from_world[0].T + from_world[1]) @ matrix.T
            corners.append(np.abs(in_camera[:, :2] / in_camera[:, 2:] - pixels).max())
            code = cv2.imread(str(folder / f"depth/{frame:06}.png"), cv2.IMREAD_UNCHANGED)
            depth = np.load(made.path(camera, frame, "truth-depth.npy")) * 1e3
            assert code.dtype == np.uint16 and np.array_equal(code == 0, ~np.isfinite(depth))
            # Half a step, and the last bit of 32-bit floats.
            assert np.abs(code * block["depth_scale"] - depth)[code > 0].max() <= 0.5 * block["depth_scale"] + 1e-3
            instance = np.load(made.path(camera, frame, "truth-instance.npy"))
            objects = objects_of(made.reports[camera, frame])
            targets = {target["name"]: target for target in made.reports[camera, frame]["targets"]}
            for i, (pose, info) in enumerate(zip(poses[str(frame)], infos[str(frame)], strict=True)):
                rotation, translation = np.array(pose["cam_R_m2c"]).reshape(3, 3), np.array(pose["cam_t_m2c"])
                assert abs(np.linalg.det(rotation) - 1) < 1e-9
                read = lambda kind: cv2.imread(str(folder / kind / f"{frame:06}_{i:06}.png"), cv2.IMREAD_UNCHANGED)
                mask, visible = read("mask") > 0, read("mask_visib") > 0
                # What object it is, is known by what is seen of it, or by the order.
                name = list(objects)[pose["obj_id"] - 1]
                assert np.array_equal(visible, np.isin(instance, objects[name])), name
                if name in targets:
                    points = np.array([[*point["xy_mm"], 0.0] for point in targets[name]["points"]])
                    found = cv2.projectPoints(points, cv2.Rodrigues(rotation)[0], translation, matrix, None)[0][:, 0]
                    corners.append(np.abs(found - np.array(targets[name]["points_px"])).max())
                # All models are convex: they cover the hull of their corners.
                found = cv2.projectPoints(meshes[pose["obj_id"]], cv2.Rodrigues(rotation)[0], translation, matrix, None)[0]
                hull = cv2.convexHull(found.astype(np.float32))
                columns, rows = np.meshgrid(np.arange(-width, 2 * width), np.arange(-height, 2 * height))
                side = [cv2.pointPolygonTest(hull, (float(x), float(y)), True) for x, y in zip(columns.ravel(), rows.ravel())] \
                    if frame == 0 else None
                if side is not None:
                    side = np.array(side).reshape(columns.shape)
                    # 32-bit corners, and 32-bit rays.
                    inside, unsure = side > 0, np.abs(side) < 1e-2
                    part = np.s_[height:2 * height, width:2 * width]
                    assert not ((mask != inside[part]) & ~unsure[part]).any(), f"mask of {name}"
                    assert abs(info["px_count_all"] - inside.sum()) <= unsure.sum(), f"px_count_all of {name}"
                    checked += mask.sum()
                assert not (visible & ~mask).any()
                assert info["px_count_visib"] == visible.sum() and info["px_count_valid"] == (mask & (code > 0)).sum()
                assert abs(info["visib_fract"] - visible.sum() / info["px_count_all"]) < 1e-12
                # misc.calc_2d_bbox of the BOP toolkit.
                ys, xs = visible.nonzero()
                box = [xs.min(), ys.min(), xs.max() - xs.min(), ys.max() - ys.min()] if len(xs) else [-1] * 4
                assert info["bbox_visib"] == box
    close("bop: corners", max(corners), 0)
    print(f"bop: {checked} pixels of masks")


def calibration(made):
    """calibration/ in the data set itself."""
    nodes = {}
    for camera in ("left", "right"):
        file = cv2.FileStorage(str(made.folder / f"calibration/opencv/{camera}.yaml"), cv2.FILE_STORAGE_READ)
        nodes[camera] = [file.getNode(key).mat() for key in ("camera_matrix", "distortion_coefficients", "rotation", "translation_m")]
        ros = yaml.safe_load((made.folder / f"calibration/ros/{camera}.yaml").read_text())
        assert np.array_equal(np.reshape(ros["camera_matrix"]["data"], (3, 3)), nodes[camera][0])
    assert np.allclose(nodes["left"][2], np.eye(3), atol=1e-12) and np.allclose(nodes["left"][3], 0, atol=1e-12)
    report = made.reports["left", 2]["camera"]
    matrix, coefficients, rotation, translation = nodes["right"]
    world, pixels, _ = made.corners("right", 2)
    left = world @ np.array(report["rotation"]).T + report["translation_m"]
    found = cv2.projectPoints(left, cv2.Rodrigues(rotation)[0], translation, matrix, coefficients)[0][:, 0]
    close("calibration/: corners", found, pixels)


def main(photosite):
    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder)
        (folder / "capture.toml").write_text(CAPTURE)
        (folder / "block.obj").write_text(BLOCK)
        distorted = Set(photosite, folder, "distorted", STILL, DISTORTION)
        colmap(distorted)
        euroc(distorted, [0, 0, 0])
        kalibr(distorted)
        coco(distorted)
        calibration(distorted)
        # Between two of 32 poses in 0.2 s each camera goes straight. On a rig that turns by 0.2 rad/s the right one, 0.12 m from
        # the left, is off by (0.2·0.2/32)²/8 · 0.12 m, times f/z of at most 150 px / 0.9 m: 4e-6 px.
        euroc(Set(photosite, folder, "moving", MOVING, DISTORTION), [0.4, 0.2, 0], 1e-5)
        bop(Set(photosite, folder, "straight", STILL))


if __name__ == "__main__":
    main(*sys.argv[1:])
