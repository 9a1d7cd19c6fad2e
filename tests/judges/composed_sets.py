#!/usr/bin/env python3
"""Data sets of placed objects, as COCO and BOP: `composed_sets.py PHOTOSITE [BOP_TOOLKIT]`.

Objects are dropped on a table, a different number in each frame. pycocotools reads the COCO form, and masks, boxes and categories
must be those that NumPy finds in the layers of truth. The BOP form is read by formulas of its documentation, or by the BOP toolkit
itself where its folder is given: model points that OpenCV projects by K[R|t] cover the mask of the object alone, and the depth of
those that are seen is that of the image.
"""

import json
import subprocess
import sys
import tempfile
from pathlib import Path

import cv2
import numpy as np
from pycocotools.coco import COCO

PHOTOSITE = sys.argv[1]
SIZE = (240, 180)
FRAMES = 5
TABLE = """
[scene]
environment = "even"
ground = { height_m = 0, reflectance = 0.3 }
[camera]
position_m = [0.5, 0.7, 0.9]
look_at_m = [0, 0.05, 0]
[lens]
type = "pinhole"
focal_length_mm = 12
[sensor]
preset = "sony-imx249-color"
resolution_px = [240, 180]
pixel_pitch_um = [48, 48]
[exposure]
time_s = 0.01
[render]
samples_per_pixel = 4
max_depth = 3
[output]
electrons = false
objects = true
truth = ["depth", "instance", "object-position"]
truth_formats = ["exr", "npy"]
"""
SET = f"""
capture = "table.toml"
frames = {FRAMES}
seed = 11
[[place]]
objects = ["block.obj", "wedge.obj"]
count = [3, 5]
method = "drop"
scale = [0.8, 1.2]
category = "part"
region = {{ min_m = [-0.15, 0, -0.15], max_m = [0.15, 0.3, 0.15] }}
[[place]]
objects = ["spike.obj"]
count = [1, 3]
method = "rest"
category = "distractor"
region = {{ min_m = [-0.25, 0, -0.25], max_m = [0.25, 0.3, 0.25] }}
"""
BLOCK = "".join(f"v {x} {y} {z}\n" for x in (-0.06, 0.06) for y in (-0.03, 0.03) for z in (-0.04, 0.04)) \
    + "f 1 2 4 3\nf 5 7 8 6\nf 1 5 6 2\nf 3 4 8 7\nf 1 3 7 5\nf 2 6 8 4\n"
WEDGE = "v -0.05 0 -0.05\nv 0.05 0 -0.05\nv 0.05 0 0.05\nv -0.05 0 0.05\nv -0.05 0.08 -0.05\nv -0.05 0.08 0.05\n" \
    + "f 1 2 3 4\nf 1 4 6 5\nf 1 5 2\nf 4 3 6\nf 2 5 6 3\n"
SPIKE = "v -0.05 0 -0.03\nv 0.05 0 -0.03\nv 0 0 0.06\nv 0 0.1 0\nf 1 2 3\nf 1 4 2\nf 2 4 3\nf 3 4 1\n"


def photosite(folder, *words):
    done = subprocess.run([PHOTOSITE, *words], cwd=folder, capture_output=True, text=True)
    if done.returncode:
        sys.exit(f"{words}: {done.stderr}")


def layer(folder, frame, name):
    return np.load(folder / f"set/camera/{frame:06}/truth-{name}.npy")


def coco(folder, objects):
    photosite(folder, "layout", "set", "--format", "coco", "-o", "coco")
    data = COCO(str(folder / "coco/annotations/instances.json"))
    assert len(data.imgs) == FRAMES
    names = {category["id"]: category["name"] for category in data.cats.values()}
    assert {"part", "distractor"} <= set(names.values()), names
    found = 0
    for image in data.imgs.values():
        frame = int(Path(image["file_name"]).stem[-6:])
        instance = layer(folder, frame, "instance")
        annotations = {a["id"]: a for a in data.loadAnns(data.getAnnIds(imgIds=image["id"]))}
        masks = [data.annToMask(a).astype(bool) for a in annotations.values()]
        told = [names[a["category_id"]] for a in annotations.values()]
        for thing in objects[frame]:
            seen = instance == thing["number"]
            if thing["category"] is None or not seen.any():
                continue
            same = [i for i, mask in enumerate(masks) if (mask == seen).all()]
            assert len(same) == 1 and told[same[0]] == thing["category"], (frame, thing["name"])
            rows, columns = seen.nonzero()
            box = [columns.min(), rows.min(), np.ptp(columns) + 1, np.ptp(rows) + 1]
            annotation = list(annotations.values())[same[0]]
            assert annotation["bbox"] == box and annotation["area"] == seen.sum(), (frame, thing["name"])
            found += 1
        # The ground is none that was placed, and stands under its name.
        assert len(annotations) == len(np.unique(instance[instance > 0])), frame
    print(f"coco: {found} masks, boxes and categories")


def bop(folder, objects):
    photosite(folder, "layout", "set", "--format", "bop", "-o", "bop")
    models = {int(number): info for number, info in json.loads((folder / "bop/models/models_info.json").read_text()).items()}
    meshes = {number: points_of(folder / f"bop/models/obj_{number:06}.ply") for number in models}
    scene = folder / "bop/train/000000"
    cameras, poses, infos = (read(scene / f"scene_{kind}.json") for kind in ("camera", "gt", "gt_info"))
    checked, worst, depths = 0, 0.0, 0.0
    for frame in range(FRAMES):
        matrix = np.array(cameras[frame]["cam_K"]).reshape(3, 3)
        depth = layer(folder, frame, "depth") * 1e3
        instance = layer(folder, frame, "instance")
        placed = [thing for thing in objects[frame] if thing["category"] is not None]
        # All that was placed is there, once.
        assert len(poses[frame]) == len(infos[frame]) == len(placed), frame
        left = list(placed)
        for i, (pose, info) in enumerate(zip(poses[frame], infos[frame])):
            rotation, translation = np.array(pose["cam_R_m2c"]).reshape(3, 3), np.array(pose["cam_t_m2c"]).reshape(3)
            thing = min(left, key=lambda t: np.linalg.norm(np.array(t["translation_m"]) * 1e3 - translation))
            left.remove(thing)
            worst = max(worst, np.abs(np.array(thing["rotation"]) - rotation).max())
            seen = instance == thing["number"]
            mask, visible = (cv2.imread(str(scene / kind / f"{frame:06}_{i:06}.png"), cv2.IMREAD_UNCHANGED) > 0
                             for kind in ("mask", "mask_visib"))
            assert (visible == seen).all() and not (visible & ~mask).any(), (frame, thing["name"])
            assert info["px_count_visib"] == seen.sum()
            assert abs(info["visib_fract"] - thing["visible_part"]) < 1e-12 or thing["is_cut_off"], (info, thing)
            # The models are convex, and as large as the object is: they cover the hull of their corners.
            points = meshes[pose["obj_id"]]
            pixels = cv2.projectPoints(points, cv2.Rodrigues(rotation)[0], translation, matrix, None)[0].astype(np.float32)
            hull = cv2.convexHull(pixels)
            side = np.array([[cv2.pointPolygonTest(hull, (float(x), float(y)), True) for x in range(SIZE[0])] for y in range(SIZE[1])])
            assert not ((mask != (side > 0)) & (np.abs(side) > 1e-2)).any(), f"mask of {thing['name']} in frame {frame}"
            # What the image sees of it lies where the pose puts its own coordinates.
            own = layer(folder, frame, "object-position")[seen] * 1e3
            if len(own):
                depths = max(depths, np.abs((own @ rotation.T + translation)[:, 2] - depth[seen]).max())
            checked += int(mask.sum())
    assert worst < 1e-9 and depths < 1e-3, (worst, depths)
    print(f"bop: {checked} pixels of masks; rotations within {worst:.1e}, depth within {depths:.1e} mm")


def points_of(path):
    if TOOLKIT:
        from bop_toolkit_lib import inout

        return inout.load_ply(str(path))["pts"]
    head, body = path.read_text().split("end_header\n")
    count = int(next(line.split()[2] for line in head.splitlines() if line.startswith("element vertex")))
    return np.array([line.split()[:3] for line in body.splitlines()[:count]], float)


def read(path):
    if TOOLKIT:
        from bop_toolkit_lib import inout

        load = {"scene_camera": inout.load_scene_camera, "scene_gt": inout.load_scene_gt}.get(path.stem)
        return load(str(path)) if load else inout.load_json(str(path), keys_to_int=True)
    return {int(frame): block for frame, block in json.loads(path.read_text()).items()}


TOOLKIT = len(sys.argv) > 2
if TOOLKIT:
    sys.path.insert(0, sys.argv[2])
with tempfile.TemporaryDirectory() as folder:
    folder = Path(folder)
    for name, text in {"block.obj": BLOCK, "wedge.obj": WEDGE, "spike.obj": SPIKE, "table.toml": TABLE, "set.toml": SET}.items():
        (folder / name).write_text(text)
    PHOTOSITE = str(Path(PHOTOSITE).resolve())
    photosite(folder, "dataset", "set.toml", "-o", "set", "--quiet")
    objects = [json.loads((folder / f"set/camera/{frame:06}/objects.json").read_text())["objects"] for frame in range(FRAMES)]
    assert len({len(things) for things in objects}) > 1, "the number of objects varies"
    coco(folder, objects)
    bop(folder, objects)
