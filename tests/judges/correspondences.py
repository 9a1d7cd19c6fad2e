"""Judges flow and disparity of data sets by OpenCV: every pixel's point in the world, projected into the next frame or into the
partner's image, is where ground truth leads; what is said to be visible there lies at the depth that is seen there.

Usage: correspondences.py PHOTOSITE
"""

import json
import subprocess
import sys
import tempfile
from pathlib import Path

import cv2
import numpy as np

# Positions are 32-bit floats: of a metre, seen from half a metre away by 150 px per radian, 2e-5 px each; so are ways.
PIXELS = 5e-5
LAYERS = ("flow", "disparity", "depth", "position", "instance")

CAPTURE = """
[scene]
geometry = ["block.obj"]
environment = { illuminant = "D65", illuminance_lux = 500 }
[[targets]]
type = "chessboard"
name = "board"
squares = [8, 6]
square_mm = 50
position_m = [0, 0, -0.1]
[camera]
position_m = [0, 0, 1.2]
look_at_m = [0, 0, 0]
[lens]
focus_distance_m = "infinity"
intrinsics = { fx = 150.5, fy = 151, cx = 82.5, cy = 58.25 }
[sensor]
preset = "sony-imx249-mono"
resolution_px = [160, 120]
[exposure]
time_s = 0.004
[render]
samples_per_pixel = 1
max_depth = 1
[output]
electrons = false
raw = ["npy"]
truth_formats = ["exr", "npy"]
"""
# A block before the board.
BLOCK = "o block\n" + "".join(
    f"v {x} {y} {z}\n" for x in (0.05, 0.15) for y in (-0.05, 0.1) for z in (0.1, 0.2)
) + "f 1 2 4 3\nf 5 7 8 6\nf 1 5 6 2\nf 3 4 8 7\nf 1 3 7 5\nf 2 6 8 4\n"
RIG = """
[[cameras]]
name = "left"
disparity_to = "right"
[[cameras]]
name = "right"
position_m = [0.12, 0, 0]
disparity_to = "left"
"""
# Toed in, higher, rolled.
ASKEW = RIG.replace("[0.12, 0, 0]", "[0.12, 0.03, -0.02]\nlook_at_m = [0.04, 0, -1]\nup = [0.05, 1, 0]")
ABOVE = RIG.replace("[0.12, 0, 0]", "[0.01, 0.12, 0]")
POSES = {
    "list": """[poses]
list = [ { position_m = [0, 0, 1.2], look_at_m = [0, 0, 0] }, { position_m = [0.3, 0.2, 1.0], look_at_m = [0.1, 0, 0] },
         { position_m = [-0.2, 0.1, 0.8], look_at_m = [0, 0, 0], up = [0.3, 1, 0] } ]
""",
    "grid": "[poses.grid]\ntarget = 'board'\nazimuth_deg = [-20, 25]\nelevation_deg = [10]\ndistance_m = [0.9, 1.2]\n",
    "random": "[poses.random]\ntarget = 'board'\ndistance_m = [0.9, 1.4]\nmargin_px = 1\n",
    "trajectory": """[poses.trajectory]
frame_rate_hz = 10
poses = [ { time_s = 0, position_m = [-0.1, 0, 1.2], look_at_m = [0, 0, 0] },
          { time_s = 1, position_m = [0.5, 0.3, 0.9], look_at_m = [0.1, 0, 0] } ]
""",
}
ZOOM = "[[vary]]\nkey = 'lens.intrinsics.fx'\nsweep = [140, 180]\n"
MOVED = "[[vary]]\nkey = 'targets.0.position_m'\nchoice = [[0, 0, -0.1], [0.06, -0.03, -0.2], [-0.05, 0.02, -0.15]]\n"
DISTORTION = "lens.distortion={ model = 'brown-conrady', k = [-0.1, 0.02], p = [1e-3, -2e-3] }"
FISHEYE = "lens.distortion={ model = 'kannala-brandt', k = [0.05, 0.01, -0.002, 0.0004] }"
FRAMES = 3


def run(*command):
    done = subprocess.run([str(part) for part in command], capture_output=True, text=True)
    if done.returncode:
        sys.exit(f"{command}: {done.stderr}")


class Picture:
    def __init__(self, folder):
        self.folder = folder
        self.report = json.loads((folder / "capture.json").read_text())

    def layer(self, name):
        return np.load(self.folder / f"truth-{name}.npy").astype(float)

    def project(self, points):
        """Pixels and depths of points in the world, by OpenCV."""
        camera = self.report["camera"]
        rotation, _ = cv2.Rodrigues(np.array(camera["rotation"]))
        translation = np.array(camera["translation_m"])
        matrix, coefficients = np.array(camera["camera_matrix"]), np.array(camera["distortion"], float)
        if camera["projection"] == "kannala-brandt":
            pixels = cv2.fisheye.projectPoints(points[None], rotation.ravel(), translation, matrix, coefficients)[0][0]
        else:
            pixels = cv2.projectPoints(points, rotation, translation, matrix, coefficients)[0][:, 0]
        return pixels, (points @ np.array(camera["rotation"]).T + translation)[:, 2]

    def placement(self, name):
        """Target → world."""
        place = np.eye(4)
        for target in self.report["targets"]:
            if target["name"] == name:
                place[:3, :3], place[:3, 3] = target["rotation"], target["translation_m"]
        return place


def check(what, picture, other, layer, sign):
    """`sign` times the way from each pixel to the same point in the other image is what the layer says."""
    depth, position, way = picture.layer("depth"), picture.layer("position"), picture.layer(layer)
    height, width = depth.shape
    seen = np.isfinite(depth)
    points = position[seen]
    # What stands on the board moves with it.
    names = picture.report["truth"]["instances"]
    on_board = np.isin(picture.layer("instance")[seen], [i + 1 for i, name in enumerate(names) if name == "board"])
    assert on_board.any(), names
    moved = other.placement("board") @ np.linalg.inv(picture.placement("board"))
    points[on_board] = points[on_board] @ moved[:3, :3].T + moved[:3, 3]
    pixels, depths = other.project(points)
    grid = np.stack(np.meshgrid(np.arange(width), np.arange(height)), axis=-1).astype(float)
    error = np.abs(way[..., :2][seen] - sign * (pixels - grid[seen])).max()
    visible = way[..., 2][seen] > 0
    inside = ((pixels >= -0.5) & (pixels < np.array([width, height]) - 0.5)).all(axis=1)
    if not (error <= PIXELS and not (visible & ~inside).any() and visible.mean() > 0.3):
        sys.exit(f"{what}: {layer} is off by {error} px; {visible.mean():.0%} visible")
    # Seen from the other camera, what is visible is there, and what is hidden is behind something. A pixel's centre is up to half
    # a pixel away; at edges its neighbours tell.
    there = np.nan_to_num(other.layer("depth"), posinf=1e9)
    nearest = np.clip(np.rint(pixels).astype(int), 0, [width - 1, height - 1])
    around = [there[np.clip(nearest[:, 1] + j, 0, height - 1), np.clip(nearest[:, 0] + i, 0, width - 1)] for i in (-1, 0, 1) for j in (-1, 0, 1)]
    low, high = np.min(around, axis=0), np.max(around, axis=0)
    wrong = (visible & ~((low - 5e-3 <= depths) & (depths <= high + 5e-3))) | (inside & ~visible & (depths < low - 5e-3))
    if wrong.any():
        sys.exit(f"{what}: visibility of {wrong.sum()} pixels of {layer} contradicts depth")
    hidden = (inside & ~visible).sum()
    print(f"{what}: {layer} to {error:.0e} px, way up to {np.abs(way[..., :2][seen]).max():.0f} px, {hidden} pixels hidden")
    return np.abs(way[..., :2][seen]).max(), hidden


def main(photosite):
    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder)
        (folder / "capture.toml").write_text(CAPTURE)
        (folder / "block.obj").write_text(BLOCK)
        cases = {name: (RIG + poses, []) for name, poses in POSES.items()}
        cases["trajectory, still"] = (RIG + POSES["trajectory"].replace("= 10\n", "= 10\nmoving = false\n"), [])
        cases["zoom"] = (RIG + POSES["list"] + ZOOM, [DISTORTION])
        cases["moved"] = (RIG + POSES["list"] + MOVED, [])
        cases["askew, distorted"] = (ASKEW + POSES["random"], [DISTORTION])
        cases["above"] = (ABOVE + POSES["list"], [])
        cases["fisheye"] = (RIG + POSES["grid"], [FISHEYE])
        hidden, longest = 0, 0
        for number, (name, (text, overrides)) in enumerate(cases.items()):
            (folder / "set.toml").write_text(f"capture = 'capture.toml'\nframes = {FRAMES}\nseed = 5\n{text}")
            out = folder / str(number)
            layers = f"output.truth={json.dumps(LAYERS)}"
            run(photosite, "dataset", folder / "set.toml", "-o", out, "--quiet", "--set", layers, *(x for o in overrides for x in ("--set", o)))
            pictures = {(c, f): Picture(out / c / f"{f:06}") for c in ("left", "right") for f in range(FRAMES)}
            moves = "moving" not in text and "trajectory" in text
            # Left image less right one, and upper less lower.
            right = -1 if name == "above" else 1
            for camera, partner, sign in (("left", "right", -right), ("right", "left", right)):
                for frame in range(FRAMES):
                    own = pictures[camera, frame]
                    # capture.json has the poses of the start of a frame that moves.
                    if moves:
                        continue
                    check(f"{name} {camera} {frame}", own, pictures[partner, frame], "disparity", sign)
                    if frame + 1 < FRAMES:
                        way, behind = check(f"{name} {camera} {frame}", own, pictures[camera, frame + 1], "flow", 1)
                        longest, hidden = max(longest, way), hidden + behind
                    else:
                        assert not own.layer("flow").any() and own.report["truth"]["has_next"] is False
            if moves:
                check_moving(name, pictures)
        assert longest > 20 and hidden > 100, (longest, hidden)


def at(picture, time_s):
    """The same image with the pose of that time, by the poses of its report."""
    motion = picture.report["camera"]["motion"]["poses"]
    times = [pose["time_s"] for pose in motion]
    i = max(k for k, t in enumerate(times) if t <= time_s)
    a, b = motion[i], motion[i + 1]
    part = (time_s - a["time_s"]) / (b["time_s"] - a["time_s"])
    p, q = np.array(a["rotation_xyzw"]), np.array(b["rotation_xyzw"])
    angle = np.arccos(min(1.0, abs(p @ q)))
    q = q * np.sign(p @ q)
    turn = p if angle < 1e-9 else (np.sin((1 - part) * angle) * p + np.sin(part * angle) * q) / np.sin(angle)
    x, y, z, w = turn / np.linalg.norm(turn)
    matrix = np.array([[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                       [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                       [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]])
    place = (1 - part) * np.array(a["position_m"]) + part * np.array(b["position_m"])
    # glTF's camera looks along −z with y up.
    rotation = np.diag([1.0, -1, -1]) @ matrix.T
    moved = Picture(picture.folder)
    moved.report["camera"].update(rotation=rotation.tolist(), translation_m=(-rotation @ place).tolist())
    return moved


def check_moving(name, pictures):
    middle = {key: at(picture, picture.report["exposure"]["time_s"] / 2) for key, picture in pictures.items()}
    for camera, partner, sign in (("left", "right", -1), ("right", "left", 1)):
        for frame in range(FRAMES):
            check(f"{name} {camera} {frame}", middle[camera, frame], middle[partner, frame], "disparity", sign)
            if frame + 1 < FRAMES:
                check(f"{name} {camera} {frame}", middle[camera, frame], middle[camera, frame + 1], "flow", 1)


if __name__ == "__main__":
    main(*sys.argv[1:])
