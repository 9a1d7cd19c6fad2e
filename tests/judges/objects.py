#!/usr/bin/env python3
"""Ground truth of objects, judged by pycocotools, OpenCV and NumPy: `python3 tests/judges/objects.py PROGRAM`.

Objects of several files, shared, scaled and painted, stand before and behind one another, through several lenses and
with a rolling shutter. What `objects.json` says of each is compared with the layers of truth and with images of the
object alone: masks as pycocotools decodes them, boxes, visible parts; poses and points as OpenCV projects them.
"""

import argparse
import json
import subprocess
import sys
import tempfile
from pathlib import Path

import cv2
import numpy as np
from pycocotools import mask as coco

SIZE = (96, 72)
# Positions are single precision, of a few metres at most, seen by less than 100 px per radian.
TOLERANCE_PX = 0.02

TETRAHEDRON = "v 0 0 0\nv .4 0 0\nv 0 .5 0\nv 0 0 .3\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"
# A box with a hole through which others are seen.
FRAME = """\
v -1 -1 0
v 1 -1 0
v 1 1 0
v -1 1 0
v -.6 -.6 0
v .6 -.6 0
v .6 .6 0
v -.6 .6 0
f 1 2 6 5
f 2 3 7 6
f 3 4 8 7
f 4 1 5 8
"""
OBJECTS = """\
[[scene.objects]]
file = "tetrahedron.obj"
position_m = [-0.1, -0.1, 0.2]
rotation_deg = [10, 40, 0]
keypoints = { tip = [0, 0.5, 0], far = [0.4, 0, 0] }
[[scene.objects]]
file = "tetrahedron.obj"
name = "small"
category = "thing"
position_m = [0.1, 0.05, -0.3]
quaternion_wxyz = [0.9, 0.1, -0.3, 0.2]
scale = 0.7
material = "red"
[[scene.objects]]
file = "tetrahedron.obj"
name = "stretched"
position_m = [-0.5, 0.2, -0.6]
scale = [1, 2, 1.5]
look_at_m = [0, 0, 3]
[[scene.objects]]
file = "frame.obj"
position_m = [0.05, 0, 0.4]
rotation_deg = [0, 0, 20]
scale = 0.3
keypoints = { corner = [1, 1, 0], hole = [0, 0, 0] }
[[scene.objects]]
file = "tetrahedron.obj"
name = "cut off"
position_m = [1.0, -0.2, 0]
up = "z"
[[scene.objects]]
file = "tetrahedron.obj"
name = "hidden"
position_m = [-0.09, -0.1, -0.4]
scale = 0.1
"""
CAPTURE = """\
[scene]
environment = { illuminant = "D65", illuminance_lux = 500 }
OBJECTS
[[scene.spheres]]
material = "red"
position_m = [-0.3, -0.4, 0]
radius_m = 0.15
[materials.red]
type = "diffuse"
reflectance = 0.3
CAMERA
[sensor]
preset = "sony-imx249-mono"
resolution_px = [96, 72]
pixel_pitch_um = [60, 60]
SENSOR
[exposure]
time_s = 0.001
[render]
samples_per_pixel = 1
max_depth = 2
[output]
raw = []
electrons = false
image = false
objects = true
truth = ["depth", "position", "object-position", "nocs", "instance"]
truth_formats = ["npy"]
"""
STILL = "[camera]\nposition_m = [0.2, 0.3, 2]\nlook_at_m = [0.05, 0, 0]\n"
# Of the camera: along the world's axes, about its own, and from row to row.
MOVES_M_PER_S, TURNS_DEG_PER_S, ROW_TIME_S = [3, -1, 0], [0, 0, 300], 3e-4
MOVING = STILL + f"[camera.motion]\nvelocity_m_per_s = {MOVES_M_PER_S}\nangular_velocity_deg_per_s = {TURNS_DEG_PER_S}\n"
FOCUS = 'f_number = 8\nfocal_length_mm = 4\nfocus_distance_m = "infinity"\n'
LENSES = {
    "perspective": "[lens]\n" + FOCUS,
    "brown-conrady": "[lens]\n" + FOCUS + 'distortion = { model = "brown-conrady", k = [-0.1, 0.02], p = [0.002, -0.001] }\n',
    "fisheye": "[lens]\n" + FOCUS + 'distortion = { model = "kannala-brandt", k = [0.03, -0.01] }\n',
}


def render(program: Path, folder: Path, name: str, capture: str) -> Path:
    (folder / f"{name}.toml").write_text(capture)
    subprocess.run([program, "render", f"{name}.toml", "-o", name, "--quiet"], cwd=folder, check=True)
    return folder / name


def layer(picture: Path, name: str) -> np.ndarray:
    return np.load(picture / f"truth-{name}.npy")


def decoded(mask: dict) -> np.ndarray:
    size = mask["size"]
    return coco.decode(coco.frPyObjects(mask, *size)).astype(bool)


def box_of(inside: np.ndarray):
    rows, columns = np.nonzero(inside)
    if not len(rows):
        return None
    return [columns.min(), rows.min(), np.ptp(columns) + 1, np.ptp(rows) + 1]


def project(camera: dict, thing: dict, points: np.ndarray) -> np.ndarray:
    """By OpenCV, from the frame of an object, (N, 2)."""
    rotation, _ = cv2.Rodrigues(np.array(thing["rotation"]))
    translation, matrix = np.array(thing["translation_m"]), np.array(camera["camera_matrix"])
    distortion = np.array(camera["distortion"], dtype=float)
    points = points.astype(float).reshape(-1, 1, 3)
    if camera["projection"] == "kannala-brandt":
        found, _ = cv2.fisheye.projectPoints(points, rotation, translation, matrix, distortion)
    else:
        found, _ = cv2.projectPoints(points, rotation, translation, matrix, distortion if distortion.size else None)
    return found.reshape(-1, 2)


def at_row(thing: dict, row: float) -> dict:
    """What stands still, where the moving camera stands in the middle of the exposure of a row: stated is the pose halfway."""
    seconds = (row - (SIZE[1] - 1) / 2) * ROW_TIME_S
    halfway, flip = np.array(thing["rotation"]), np.diag([1.0, -1.0, -1.0])
    turned, _ = cv2.Rodrigues(-np.radians(TURNS_DEG_PER_S) * seconds)
    moved = halfway @ np.array(thing["rotation_to_world"]).T @ np.array(MOVES_M_PER_S) * seconds
    turned = flip @ turned @ flip
    return {"rotation": turned @ halfway, "translation_m": turned @ (np.array(thing["translation_m"]) - moved)}


class Complaints(list):
    def expect(self, holds: bool, what: str) -> None:
        if not holds:
            self.append(what)


def tables() -> list[str]:
    return ["[[scene.objects]]" + table for table in OBJECTS.split("[[scene.objects]]")[1:]]


def alone(number: int) -> str:
    """The objects with all but one invisible."""
    return "".join(t if i == number else t + "visible = false\n" for i, t in enumerate(tables()))


def judge(program: Path, folder: Path, lens: str, sensor: str, camera: str, complaints: Complaints) -> dict:
    name = f"{lens}-{'moving' if camera is MOVING else 'still'}"
    capture = CAPTURE.replace("CAMERA", camera + LENSES[lens]).replace("SENSOR", sensor)
    picture = render(program, folder, name, capture.replace("OBJECTS", OBJECTS))
    report = json.loads((picture / "capture.json").read_text())
    objects = json.loads((picture / "objects.json").read_text())["objects"]
    instance, own, nocs = (layer(picture, it) for it in ("instance", "object-position", "nocs"))
    complaints.expect([it["name"] for it in objects] == report["truth"]["instances"], f"{name}: names")
    facts = {"objects": 0, "points": 0, "worst_px": 0.0, "hidden": 0, "partly": 0}
    for number, thing in enumerate(objects):
        at = f"{name} {thing['name']}"
        visible, whole = decoded(thing["visible"]["mask"]), decoded(thing["alone"]["mask"])
        complaints.expect(np.array_equal(visible, instance == thing["number"]), f"{at}: visible mask")
        if number < len(tables()):
            single = folder / f"{name}-{number}"
            only = capture.replace("OBJECTS", alone(number)).replace("[[scene.spheres]]", "[[scene.spheres]]\nname = 'ball'")
            single = render(program, folder, f"{name}-{number}", only)
            number_alone = json.loads((single / "capture.json").read_text())["truth"]["instances"].index(thing["name"])
            others = json.loads((single / "objects.json").read_text())["objects"]
            ball = decoded(others[-1]["visible"]["mask"])
            expected = layer(single, "instance") == number_alone + 1
            # Only the ball is before it there.
            complaints.expect(np.array_equal(whole & ~ball, expected), f"{at}: mask of it alone")
        complaints.expect(not (visible & ~whole).any(), f"{at}: what is seen is a part of all")
        for mask, key in ((visible, "visible"), (whole, "alone")):
            complaints.expect(thing[key]["pixels"] == mask.sum(), f"{at}: pixels {key}")
            complaints.expect(thing[key]["box_px"] == box_of(mask), f"{at}: box {key}")
        part = visible.sum() / whole.sum() if whole.any() else None
        complaints.expect(thing["visible_part"] == part, f"{at}: visible part")
        facts["hidden"] += int(part == 0)
        facts["partly"] += int(part is not None and 0 < part < 1)
        low, high = np.array(thing["box_low_m"]), np.array(thing["box_high_m"])
        points = own[visible]
        room = 1e-5
        complaints.expect(bool(((points >= low - room) & (points <= high + room)).all()), f"{at}: box")
        diagonal = np.linalg.norm(high - low)
        expected = (points - (low + high) / 2) / diagonal + 0.5
        complaints.expect(np.allclose(nocs[visible], expected, atol=1e-5), f"{at}: normalised coordinates")
        to_world = np.array(thing["rotation_to_world"]), np.array(thing["position_m"])
        in_world = points @ to_world[0].T + to_world[1]
        complaints.expect(np.allclose(in_world, layer(picture, "position")[visible], atol=2e-5), f"{at}: world")
        facts["objects"] += 1
        rows, columns = np.nonzero(visible)
        if len(rows):
            found = project(report["camera"], thing, points)
            if camera is MOVING:
                found = [project(report["camera"], at_row(thing, row), p)[0] for row, p in zip(rows, points)]
            error = np.abs(found - np.stack([columns, rows], axis=1)).max()
            facts["worst_px"] = max(facts["worst_px"], float(error))
            complaints.expect(error <= TOLERANCE_PX, f"{at}: points {error:.4f} px from their pixels")
            facts["points"] += len(rows)
        if camera is MOVING:
            # Continuous rows have their time, too, and the point is where it is seen in its own.
            for point in thing["keypoints"]:
                expected = project(report["camera"], at_row(thing, point["px"][1]), np.array(point["position_m"]))[0]
                complaints.expect(np.allclose(expected, point["px"], atol=1e-6), f"{at}: {point['name']}")
                facts["points"] += 1
            continue
        corners = [[(low, high)[i >> axis & 1][axis] for axis in range(3)] for i in range(8)]
        found = project(report["camera"], thing, np.array(corners))
        stated = np.array(thing["box_corners_px"], dtype=float)
        complaints.expect(np.allclose(found, stated, atol=1e-6), f"{at}: corners of the box")
        inside = (stated >= -0.5) & (stated <= np.array(SIZE) - 0.5)
        complaints.expect(thing["is_cut_off"] == (not inside.all()), f"{at}: cut off")
        for point in thing["keypoints"]:
            expected = project(report["camera"], thing, np.array(point["position_m"]))[0]
            complaints.expect(np.allclose(expected, point["px"], atol=1e-6), f"{at}: {point['name']}")
    of_name = {it["name"]: {point["name"]: point["visible"] for point in it["keypoints"]} for it in objects}
    complaints.expect(of_name["frame"] == {"corner": True, "hole": True}, f"{name}: points of the frame {of_name['frame']}")
    return facts


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program", type=Path, help="the photosite binary")
    program = parser.parse_args().program.resolve()
    complaints = Complaints()
    with tempfile.TemporaryDirectory(prefix="objects-") as folder:
        folder = Path(folder)
        (folder / "tetrahedron.obj").write_text(TETRAHEDRON)
        (folder / "frame.obj").write_text(FRAME)
        rolling = f'[sensor.shutter]\nkind = "rolling"\nrow_time_us = {ROW_TIME_S * 1e6:.0f}\n'
        for lens, sensor, camera in [
            ("perspective", "", STILL),
            ("brown-conrady", "", STILL),
            ("fisheye", "", STILL),
            ("perspective", rolling, MOVING),
        ]:
            facts = judge(program, folder, lens, sensor, camera, complaints)
            print(f"{lens}{', moving' if camera is MOVING else ''}: {facts}")
            complaints.expect(facts["hidden"] > 0 and facts["partly"] > 0, f"{lens}: some are hidden, some in part")
    if complaints:
        sys.exit(f"{len(complaints)} complaints:\n" + "\n".join(complaints))
    print("0 complaints")


if __name__ == "__main__":
    main()
