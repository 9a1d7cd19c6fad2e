"""Two views: epipolar geometry, rectification, depth from disparity, triangulation."""

import functools

import cv2
import numpy as np
from PIL import Image

from table import Figure, Row

SIZE = (240, 180)
#: Focal length over pixel pitch.
FOCAL = 2600 / 15
STOP = (cv2.TERM_CRITERIA_COUNT + cv2.TERM_CRITERIA_EPS, 200, 1e-12)


def rig(tool):
    """The data set of stereo.toml and what it says of its cameras."""
    folder = tool.scratch / "rig"
    tool.run("dataset", tool.capture("stereo.toml"), "-o", folder, "--quiet")
    file = cv2.FileStorage(str(folder / "calibration/opencv/stereo/left-right.yaml"), cv2.FILE_STORAGE_READ)
    node = {key: file.getNode(key).mat() for key in "M1 D1 M2 D2 R T E F e1 e2 R1 R2 P1 P2 Q".split()}
    return folder, node


def corners(tool, folder, node):
    """The board's corners in both images without distortion, and in the coordinates of the left camera, m."""
    pixels, world = [], None
    for i, camera in ((1, "left"), (2, "right")):
        report = tool.report(folder / camera / "000000")
        points = np.array(report["targets"][0]["points_px"])[:, None]
        k, d = node[f"M{i}"], node[f"D{i}"]
        pixels.append(cv2.undistortPoints(points, k, d, P=k, criteria=STOP)[:, 0])
        if world is None:
            pose = report["camera"]
            world = np.array(report["targets"][0]["points_world_m"]) @ np.array(pose["rotation"]).T + pose["translation_m"]
    return pixels, world


def geometry(tool):
    folder, node = rig(tool)
    (left, right), _ = corners(tool, folder, node)
    lines = cv2.computeCorrespondEpilines(left[:, None], 1, node["F"])[:, 0]
    distance = np.abs((lines[:, :2] * right).sum(1) + lines[:, 2]).max()
    sizes = np.linalg.svd(node["E"])[1]
    baseline = np.linalg.norm(node["T"])
    # Those of the board lie in a plane, which leaves F open.
    points = np.random.default_rng(1).uniform([-0.3, -0.2, 0.5], [0.3, 0.2, 2], (60, 3))
    left = cv2.projectPoints(points, np.zeros(3), np.zeros(3), node["M1"], None)[0]
    right = cv2.projectPoints(points, cv2.Rodrigues(node["R"])[0], node["T"], node["M2"], None)[0]
    by_points = cv2.findFundamentalMat(left, right, cv2.FM_8POINT)[0]
    cosine = abs((by_points * node["F"]).sum()) / np.linalg.norm(by_points) / np.linalg.norm(node["F"])
    return [
        Figure("largest distance of a corner from its line, px", distance, 0, 1e-4, "OpenCV's lines"),
        Figure("first singular value of E, m", sizes[0], baseline, 1e-12),
        Figure("second singular value of E, m", sizes[1], baseline, 1e-12),
        Figure("third singular value of E, m", sizes[2], 0, 1e-12),
        Figure("cosine between F and that of 60 points alone", cosine, 1, 1e-6, "OpenCV, eight-point"),
    ]


def epipoles(tool):
    _, node = rig(tool)
    figures = []
    for name, key, matrix in (("left", "e1", node["F"]), ("right", "e2", node["F"].T)):
        null = np.linalg.svd(matrix)[2][2]
        found = node[key].ravel()
        figures += [
            Figure(f"{name}: column, px", found[0] / found[2], null[0] / null[2], 1e-6 * abs(null[0] / null[2]), "NumPy's null space"),
            Figure(f"{name}: row, px", found[1] / found[2], null[1] / null[2], 1e-6 * abs(null[0] / null[2]), "NumPy's null space"),
        ]
    return figures


@functools.cache
def places():
    return np.meshgrid(np.arange(SIZE[0]), np.arange(SIZE[1]))


def rectification(tool):
    folder, node = rig(tool)
    out = tool.scratch / "rectified"
    report = tool.json("rectify", folder, "-o", out, "--lines", 8)
    by_opencv = cv2.stereoRectify(
        *(node[key] for key in ("M1", "D1", "M2", "D2")), SIZE, node["R"], node["T"], flags=cv2.CALIB_ZERO_DISPARITY, alpha=-1
    )
    figures = [Figure("R₁ and R₂ beside OpenCV's", max(np.abs(by_opencv[i] - node[f"R{i + 1}"]).max() for i in (0, 1)), 0, 1e-9, "OpenCV")]
    places = []
    for i, camera in ((1, "left"), (2, "right")):
        k, d, r, p = (node[f"{key}{i}"] for key in "MDRP")
        pixels = np.array(tool.report(folder / camera / "000000")["targets"][0]["points_px"])[:, None]
        places.append(cv2.undistortPoints(pixels, k, d, R=r, P=p[:, :3], criteria=STOP)[:, 0])
        maps = cv2.initUndistortRectifyMap(k, d, r, p[:, :3], SIZE, cv2.CV_32FC1)
        picture = cv2.imread(str(folder / camera / "000000/image.png"))
        found = cv2.imread(str(out / camera / "000000/image.png"))
        wanted = cv2.remap(picture, *maps, cv2.INTER_LINEAR)
        inside = (maps[0] > 0) & (maps[1] > 0) & (maps[0] < SIZE[0] - 1) & (maps[1] < SIZE[1] - 1)
        off = np.abs(found.astype(float) - wanted)[inside].max()
        # OpenCV may round places to 1/32 px, where an edge has up to 255 codes: 255/64 along both axes.
        figures.append(Figure(f"{camera}: codes beside those of cv2.remap", off, 0, 9, "OpenCV"))
    off = np.abs(places[0] - places[1])[:, 1].max()
    figures.append(Figure("largest difference of a corner's rows, px", off, 0, 1e-4, "OpenCV's undistortPoints"))
    figures.append(Figure("f, px", report["focal_length_px"], FOCAL, 1e-9))
    draw(tool, out)
    return figures


def draw(tool, out):
    """Both pairs with their epipolar lines, one above the other."""
    pairs = [Image.open(out / f"epipolar/000000-{kind}.png") for kind in ("original", "rectified")]
    page = Image.new("RGB", (pairs[0].width, 2 * pairs[0].height + 6), "white")
    for i, pair in enumerate(pairs):
        page.paste(pair, (0, i * (pair.height + 6)))
    # The sensor's noise does not compress.
    page.point(lambda code: (code + 10) // 20 * 20).quantize(200, dither=Image.Dither.NONE).save(tool.picture("epipolar.png"), optimize=True)


def disparity(tool):
    folder, node = rig(tool)
    out = tool.scratch / "rectified"
    report = tool.json("rectify", folder, "-o", out)
    truth = tool.planes(out / "left/000000/truth.exr")
    seen = np.isfinite(truth["depth"])
    wanted = report["focal_length_px"] * report["baseline_m"] / truth["depth"][seen]
    by_opencv = cv2.reprojectImageTo3D(truth["disparity"].astype(np.float32), node["Q"])[..., 2]
    tool.run("depth", out / "left/000000/truth.exr", "--channel", "disparity", "--rectified", out, "-o", "depth.npy", "--quiet")
    tool.run("depth", "depth.npy", "--rectified", out, "--inverse", "-o", "disparity.npy", "--quiet")
    depth, back = (np.load(tool.scratch / name) for name in ("depth.npy", "disparity.npy"))
    # The plane z = 0 of the board, behind the balls.
    camera = tool.report(folder / "left/000000")["camera"]
    focal, (cx, cy) = report["focal_length_px"], report["principal_point_px"]
    x, y = places()
    to_world = np.array(camera["rotation"]).T @ node["R1"].T
    plane = -camera["position_m"][2] / (np.stack([(x - cx) / focal, (y - cy) / focal, np.ones(x.shape)], -1) @ to_world.T)[..., 2]
    on_board = seen & (np.abs(truth["depth"] / plane - 1) < 0.01)
    return [
        Figure("disparity times Z over f·b, farthest from 1", np.abs(truth["disparity"][seen] / wanted - 1).max(), 0, 1e-6),
        Figure("part of pixels with a depth that see the board", on_board.sum() / seen.sum(), 1, 0.1),
        Figure("depth of the board over the plane's, farthest from 1", np.abs(truth["depth"][on_board] / plane[on_board] - 1).max(), 0, 1e-6),
        Figure("depth by `photosite depth` over OpenCV's, farthest from 1", np.abs(depth[seen] / by_opencv[seen] - 1).max(), 0, 1e-6, "OpenCV"),
        Figure("disparity, there and back, farthest from 1", np.abs(back[seen] / truth["disparity"][seen] - 1).max(), 0, 1e-6),
    ]


def triangulation(tool):
    folder, node = rig(tool)
    (left, right), world = corners(tool, folder, node)
    first = node["M1"] @ np.eye(3, 4)
    second = node["M2"] @ np.hstack([node["R"], node["T"].reshape(3, 1)])
    points = cv2.triangulatePoints(first, second, left.T, right.T)
    points = (points[:3] / points[3]).T
    return [
        Figure("largest distance of a corner from its place, µm", 1e6 * np.linalg.norm(points - world, axis=1).max(), 0, 1, "OpenCV"),
    ]


ROWS = [
    Row("Essential and fundamental matrix", "E = [T]ₓ·R, F = K₂⁻ᵀ·E·K₁⁻¹, x₂ᵀ·F·x₁ = 0", "stereo.toml", geometry),
    Row("Epipoles", "F·e₁ = 0, Fᵀ·e₂ = 0", "stereo.toml", epipoles),
    Row("Rectification", "H = P·R·K⁻¹ after the lens: rows agree", "photosite rectify rig -o rectified --lines 8", rectification, "epipolar.png"),
    Row("Depth from disparity", "d = f·b/Z, Z = f·b/d", "photosite depth disparity.npy --rectified rectified -o depth.npy", disparity),
    Row("Triangulation", "x₁ × P₁·X = 0, x₂ × P₂·X = 0", "stereo.toml", triangulation),
]
