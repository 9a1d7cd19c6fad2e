#!/usr/bin/env python3
"""OpenCV, AprilTag and two rasterisers judge printed calibration targets: targets.py PHOTOSITE

Every marker of every dictionary is decoded from our SVG; chessboards and circles lie where their sizes say, in SVG (resvg)
and in PDF (PDFium), to a hundredth of a millimetre; AprilTag's own detector reads Kalibr's grid upright.
"""

import io
import json
import subprocess
import sys
import tempfile
from pathlib import Path

import cv2
import numpy as np
import pypdfium2
import resvg_py
from PIL import Image
from pupil_apriltags import Detector

PHOTOSITE = sys.argv[1]
FOLDER = Path(tempfile.mkdtemp())
FAMILIES = {
    "DICT_4X4_50": 50, "DICT_4X4_100": 100, "DICT_4X4_250": 250, "DICT_4X4_1000": 1000,
    "DICT_5X5_50": 50, "DICT_5X5_100": 100, "DICT_5X5_250": 250, "DICT_5X5_1000": 1000,
    "DICT_6X6_50": 50, "DICT_6X6_100": 100, "DICT_6X6_250": 250, "DICT_6X6_1000": 1000,
    "DICT_7X7_50": 50, "DICT_7X7_100": 100, "DICT_7X7_250": 250, "DICT_7X7_1000": 1000,
    "DICT_ARUCO_ORIGINAL": 1024, "DICT_ARUCO_MIP_36h12": 250, "DICT_APRILTAG_16h5": 30, "DICT_APRILTAG_25h9": 35,
    "DICT_APRILTAG_36h10": 2320, "DICT_APRILTAG_36h11": 587,
}


def write(kind, extension, *changes):
    path = FOLDER / f"target.{extension}"
    arguments = [argument for change in changes for argument in ("--set", change)]
    subprocess.run([PHOTOSITE, "target", kind, "-o", path, "--quiet", "--force", *arguments], check=True)
    return path


def raster_svg(path, px_per_mm):
    """Grey values, at so many dots per inch that a stated millimetre has so many pixels."""
    png = resvg_py.svg_to_bytes(svg_string=path.read_text(), dpi=px_per_mm * 25.4)
    return np.array(Image.open(io.BytesIO(bytes(png))).convert("L"))


def raster_pdf(path, px_per_mm):
    """The page says its size in points; PDFium stretches it to whole pixels."""
    page = pypdfium2.PdfDocument(path)[0]
    return np.array(page.render(scale=px_per_mm * 25.4 / 72).to_pil().convert("L")), page


def raster(path, px_per_mm, sheet_mm):
    """Grey values, and pixels a millimetre across and down."""
    if path.suffix == ".svg":
        image = raster_svg(path, px_per_mm)
        assert np.abs(np.array(image.shape[::-1]) - sheet_mm * px_per_mm).max() <= 1, f"{path}: {image.shape}"
        return image, np.array([px_per_mm, px_per_mm])
    image, page = raster_pdf(path, px_per_mm)
    # Sizes of pages are single-precision numbers of points.
    assert np.abs(np.array(page.get_size()) / 72 * 25.4 - sheet_mm).max() < 1e-4, f"{path}: {page.get_size()}"
    return image, np.array(image.shape[::-1]) / sheet_mm


def decode_every_marker():
    for name, count in FAMILIES.items():
        # Rows of 40, and what is left as a row of its own.
        across = min(count, 40)
        sheets = [(0, across, count // across), (count - count % across, count % across, 1)]
        decoded = sum(decode(name, *sheet) for sheet in sheets if sheet[1])
        assert decoded == count, f"{name}: {decoded} of {count}"
        print(f"{name}: all {count} markers decoded")


def decode(name, first, across, down):
    path = write("marker-grid", "svg", f"dictionary={name}", f"first_id={first}", f"markers=[{across}, {down}]",
                 "marker_mm=10", "separation_mm=3", "margin_mm=3")
    dictionary = cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, name))
    parameters = cv2.aruco.DetectorParameters()
    parameters.minMarkerPerimeterRate = 0.01
    # No error is forgiven.
    parameters.errorCorrectionRate = 0.0
    parameters.maxErroneousBitsInBorderRate = 0.0
    corners, ids, _ = cv2.aruco.ArucoDetector(dictionary, parameters).detectMarkers(raster_svg(path, 5))
    found = {int(i): c[0] for i, c in zip(ids.ravel(), corners)}
    assert len(ids) == len(found) == across * down, f"{name}: {len(ids)} markers of {across * down}"
    for marker, quad in found.items():
        wanted = (np.array([(marker - first) % across, (marker - first) // across]) * 13 + 3) * 5
        # Which corner is the first says which way up it is.
        assert np.abs(quad[0] - wanted).max() < 2, f"{name} {marker}: {quad[0]} instead of {wanted}"
    return len(found)


def sizes():
    """Corners and circles in the rasters against the points that we state."""
    worst = {}
    for kind in ("chessboard", "charuco", "circle-grid", "asymmetric-circle-grid", "dot-chart"):
        facts = json.loads(write(kind, "json").read_text())
        points = np.array([point["xy_mm"] for point in facts["points"]]) - facts["sheet_mm"][0]
        sheet_mm = np.diff(facts["sheet_mm"], axis=0)[0]
        for extension in ("svg", "pdf"):
            image, scale = raster(write(kind, extension), 20, sheet_mm)
            measure = circles if "diameter_mm" in facts["target"] else corners
            worst[f"{kind}.{extension}"] = measure(image, points, scale, facts["target"])
    for name, error in worst.items():
        print(f"{name}: points within {error * 1e3:.1f} µm")
        # A fifth of a pixel; the rasterisers round coverage to sixteenths.
        assert error < 0.01, name


def corners(image, points, scale, _):
    start = (points * scale - 0.5).astype(np.float32).reshape(-1, 1, 2)
    criteria = (cv2.TERM_CRITERIA_EPS + cv2.TERM_CRITERIA_MAX_ITER, 100, 1e-4)
    found = cv2.cornerSubPix(image, start + 1.7, (12, 12), (-1, -1), criteria).reshape(-1, 2)
    return float(np.abs((found + 0.5) / scale - points).max())


def circles(image, points, scale, target):
    """Centroids and areas of what is dark around each point."""
    dark = 255.0 - image
    half = int(0.5 * np.sort(np.linalg.norm((points - points[0]) * scale, axis=1))[1])
    error = 0.0
    for x, y in points * scale:
        left, top = max(int(x) - half, 0), max(int(y) - half, 0)
        part = dark[top:int(y) + half, left:int(x) + half]
        rows, columns = np.mgrid[:part.shape[0], :part.shape[1]]
        centre = np.array([(columns * part).sum(), (rows * part).sum()]) / part.sum() + [left + 0.5, top + 0.5]
        diameter = 2 * np.sqrt(part.sum() / 255 / scale.prod() / np.pi)
        error = max(error, np.abs((centre - [x, y]) / scale).max(), abs(diameter - target["diameter_mm"]))
    return float(error)


def kalibr_grid():
    """Kalibr's border of two bits has AprilTag's tag, with a border of one, in its middle: painted white around it, the
    detector finds it upright, and numbered from the bottom left."""
    facts = json.loads(write("aprilgrid", "json").read_text())
    scale, low = 10, np.array(facts["sheet_mm"][0])
    image = raster_svg(write("aprilgrid", "svg"), scale)
    for marker in facts["markers"]:
        quad = (np.array(marker["corners_xy_mm"]) - low) * scale
        (left, top), (right, bottom) = quad.min(axis=0).round().astype(int), quad.max(axis=0).round().astype(int)
        cell = round((right - left) / 10)
        inner = image[top + cell:bottom - cell, left + cell:right - cell].copy()
        image[top - 3 * cell:bottom + 3 * cell, left - 3 * cell:right + 3 * cell] = 255
        image[top + cell:bottom - cell, left + cell:right - cell] = inner
    found = {d.tag_id: d for d in Detector(families="tag36h11").detect(image)}
    assert set(found) == set(range(36)), f"aprilgrid: tags {sorted(found)}"
    for tag, detection in found.items():
        middle = (np.array([tag % 6, -(tag // 6)]) * 24 * 1.3 + [12, -12] - low) * scale
        assert np.abs(detection.center - middle).max() < 2, f"tag {tag} at {detection.center} instead of {middle}"
        # AprilTag's homography maps its own up (0, -1) to the top of the upright tag.
        up = detection.homography @ [0, -1, 1]
        assert up[1] / up[2] < detection.center[1] - cell, f"tag {tag} is not upright"
    print("aprilgrid: AprilTag reads all 36 tags upright")


def photograph(kind, *changes):
    """An image of a target seen from the side, what capture.json says of target and camera, and a projection."""
    capture, out = write(kind, "toml", *changes), FOLDER / "photograph"
    size = np.diff(json.loads(write(kind, "json", *changes).read_text())["sheet_mm"], axis=0)[0].max() / 1e3
    settings = [f"camera.position_m=[{-1.2 * size}, {0.9 * size}, {4.9 * size}]", "camera.up=[0.1, 1, 0]",
                "sensor.preset=sony-imx249-mono", "sensor.resolution_px=[1000, 800]", "sensor.pixel_pitch_um=[4.5, 4.5]",
                "lens.type=pinhole", "render.samples_per_pixel=16"]
    arguments = [argument for setting in settings for argument in ("--set", setting)]
    subprocess.run([PHOTOSITE, "render", capture, "-o", out, "--quiet", "--force", *arguments], check=True)
    report = json.loads((out / "capture.json").read_text())
    camera, target = report["camera"], report["targets"][0]

    def project(xy_mm):
        board = np.column_stack([np.atleast_2d(xy_mm) / 1e3, np.zeros(len(np.atleast_2d(xy_mm)))])
        world = board @ np.array(target["rotation"]).T + target["translation_m"]
        pixels, _ = cv2.projectPoints(world, cv2.Rodrigues(np.array(camera["rotation"]))[0],
                                      np.array(camera["translation_m"]), np.array(camera["camera_matrix"]), None)
        return pixels.reshape(-1, 2)

    points = np.array([point["xy_mm"] for point in target["points"]])
    world = points / 1e3 @ np.array(target["rotation"])[:, :2].T + target["translation_m"]
    assert np.abs(world - target["points_world_m"]).max() < 1e-9, f"{kind}: points in the world"
    return cv2.imread(str(out / "image.png"), cv2.IMREAD_GRAYSCALE), target, points, project


def photographs():
    for kind, *changes in (("charuco",), ("marker-grid", "dictionary=DICT_6X6_250"),
                           ("marker-grid", "dictionary=DICT_APRILTAG_36h11", "first_id=500"), ("aprilgrid",)):
        image, target, points, project = photograph(kind, *changes)
        parameters = cv2.aruco.DetectorParameters()
        parameters.cornerRefinementMethod = cv2.aruco.CORNER_REFINE_SUBPIX
        if kind == "aprilgrid":
            parameters.markerBorderBits = 2
        name = target["markers"][0]["dictionary"]
        dictionary = cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, name))
        corners, ids, _ = cv2.aruco.ArucoDetector(dictionary, parameters).detectMarkers(image)
        wanted = {marker["id"]: project(marker["corners_xy_mm"]) for marker in target["markers"]}
        assert ids is not None and sorted(ids.ravel()) == sorted(wanted), f"{kind}: {sorted(ids.ravel())}"
        error = max(np.abs(quad[0] - wanted[int(i)]).max() for i, quad in zip(ids.ravel(), corners))
        print(f"{kind} photographed: all {len(wanted)} markers of {name}, corners within {error:.2f} px")
        # Which corner is which, and where it is to what refinement by gradients makes of steps. The squares of an aprilgrid
        # touch its tags, and contours go astray there.
        assert error < (3.0 if kind == "aprilgrid" else 1.0), kind
    for kind, flags in (("circle-grid", cv2.CALIB_CB_SYMMETRIC_GRID), ("asymmetric-circle-grid", cv2.CALIB_CB_ASYMMETRIC_GRID)):
        image, target, points, project = photograph(kind)
        found, centres = cv2.findCirclesGrid(image, tuple(target["target"]["circles"]), flags=flags)
        assert found, kind
        # What is seen of a circle is an ellipse, whose middle is not the image of the circle's.
        angles = np.linspace(0, 2 * np.pi, 400, endpoint=False)
        circle = np.column_stack([np.cos(angles), np.sin(angles)]) * target["target"]["diameter_mm"] / 2
        middles = np.array([cv2.fitEllipse(project(point + circle).astype(np.float32))[0] for point in points])
        centres = centres.reshape(-1, 2)
        if np.abs(centres - middles).max() > 5:
            centres = centres[::-1]
        error = centres - middles
        print(f"{kind} photographed: bias {np.abs(error.mean(axis=0)).max():.3f} px, RMS {np.sqrt((error**2).sum(1).mean()):.3f} px")
        assert np.abs(error.mean(axis=0)).max() < 0.01 and np.sqrt((error**2).sum(1).mean()) < 0.05, kind


if "--sizes" not in sys.argv:
    decode_every_marker()
sizes()
kalibr_grid()
photographs()
