"""Where a sensor's cells are and what they cover."""

import json
import math

import cv2
import numpy
from table import Figure, Row

DOTS = "sensor-dots.toml"
#: Rows of regular hexagons lie so many pitches apart.
REGULAR = math.sqrt(3) / 2
HEXAGONS = ["sensor.cells=hexagonal", f"sensor.pixel_pitch_um=[20, {20 * REGULAR}]"]


def report(folder):
    return json.loads((folder / "capture.json").read_text())


def dots(folder):
    """The dots of the grid in the camera's coordinates, and where OpenCV projects them."""
    told = report(folder)
    target, camera = told["targets"][0], told["camera"]
    world = numpy.array(target["points_world_m"])
    rotation = cv2.Rodrigues(numpy.array(camera["rotation"]))[0]
    translation = numpy.array(camera["translation_m"])
    pixels = cv2.projectPoints(world, rotation, translation, numpy.array(camera["camera_matrix"]), None)[0][:, 0]
    return world @ numpy.array(camera["rotation"]).T + translation, pixels


def centroids(raw, near, places, radius):
    """Centroids of dark dots in cells at places (x, y), each about where it is nearly."""
    x, y = places
    found = []
    for centre in near:
        window = numpy.hypot((x - centre[0]) / radius[0], (y - centre[1]) / radius[1]) < 1
        white = numpy.median(raw[window & (raw > 0.5 * raw.max())])
        dark = numpy.where(window, white - raw, 0)
        found.append([(dark * x).sum() / dark.sum(), (dark * y).sum() / dark.sum()])
    return numpy.array(found)


def formats(tool):
    rows = tool.json("sensors", "--formats", "4000x3000")
    sizes = {name: row for row in rows for name in row["names"]}
    expected = {
        # Type, width and height in mm, as camera tables have them.
        "1/3.2": (4.54, 3.42), "1/3": (4.8, 3.6), "1/2.7": (5.37, 4.04), "1/2.5": (5.76, 4.29), "1/2": (6.4, 4.8),
        "1/1.8": (7.18, 5.32), "2/3": (8.8, 6.6), "1": (12.8, 9.6), "4/3": (17.3, 13), "aps-c": (23.6, 15.6),
        "full-frame": (36, 24), "medium-format-44x33": (44, 33),
    }  # fmt: skip
    return [
        Figure(f"{name}: pitch of 4000 columns, µm", sizes[name]["pixel_pitch_um"][0], width / 4, 1e-3)
        for name, (width, _) in expected.items()
    ]


def hexagonal_positions(tool):
    folder = tool.render(DOTS, "hexagons", *HEXAGONS)
    raw = numpy.load(folder / "raw.npy").astype(float)
    row, column = numpy.indices(raw.shape)
    _, pixels = dots(folder)
    # Every second row lies half a pitch farther to the right.
    found = centroids(raw, pixels, (column + 0.5 * (row % 2), row), (9, 9 / REGULAR))
    shifted = centroids(raw, pixels, (column, row), (9, 9 / REGULAR))
    draw(folder, raw, tool.picture("hexagons.png"))
    # Of the 40 cells on the edge of a dot of 91, each is right to 0.03 of white with its 256 samples, 5 pitches away from the
    # centre: 0.03·5·√40/91 pitches, of which the largest of 30 dots is twice that.
    return [
        Figure("largest error of a dot's centre, pitches", float(numpy.hypot(*(found - pixels).T).max()), 0, 0.02, "OpenCV"),
        Figure("mean shift if the stagger is forgotten, pitches", float((pixels - shifted)[:, 0].mean()), 0.25, 0.02),
    ]


def draw(folder, raw, path):
    """A dot's cells as the hexagons that they are."""
    scale, (left, top, width, height) = 20, (47, 40, 26, 26)
    picture = numpy.zeros((int(height * REGULAR * scale), width * scale), numpy.uint8)
    corners = [(math.cos(a) / math.sqrt(3), math.sin(a) / math.sqrt(3)) for a in (math.pi / 6 + k * math.pi / 3 for k in range(6))]
    for y in range(top - 1, top + height + 1):
        for x in range(left - 1, left + width + 1):
            centre = (x - left + 0.5 + 0.5 * (y % 2), (y - top + 0.5) * REGULAR)
            hexagon = numpy.array([[(centre[0] + dx) * scale, (centre[1] + dy) * scale] for dx, dy in corners])
            grey = int(255 * (raw[y, x] / raw.max()) ** (1 / 2.2))
            cv2.fillConvexPoly(picture, numpy.round(hexagon * 16).astype(numpy.int32), grey, cv2.LINE_AA, 4)
    cv2.imwrite(str(path), cv2.resize(picture, None, fx=0.6, fy=0.6, interpolation=cv2.INTER_AREA))


def hexagonal_sampling(tool):
    """The lattice of cells, from what each sees of a wall, and the area of a cell, from what it counts."""
    # Truth is in the pixels of the image, which has the sensor's rows only if it is not brought to square pixels.
    as_cells = ["develop.square_pixels=false", 'output.truth=["position"]', 'output.truth_formats=["npy"]']
    folder = tool.render(DOTS, "lattice", *HEXAGONS, *as_cells)
    square = tool.render(DOTS, "square")
    seen = numpy.load(folder / "truth-position.npy")
    seen = seen if seen.shape[-1] == 3 else numpy.moveaxis(seen, 0, -1)
    # About the middle, in pitches: 1 m away a pitch of 20 µm behind 6 mm is 20/6 mm.
    pitch = 20e-6 / 6e-3
    along = (seen[54, 65] - seen[54, 64])[:2] / pitch
    next_row = (seen[55, 64] - seen[54, 64])[:2] / pitch
    lattice = numpy.array([along, next_row])
    reciprocal = numpy.linalg.inv(lattice).T
    ways = [a * reciprocal[0] + b * reciprocal[1] for a in (-1, 0, 1) for b in (-1, 0, 1) if (a, b) != (0, 0)]
    band = min(numpy.linalg.norm(way) for way in ways) / 2
    density = 1 / abs(numpy.linalg.det(lattice))
    counts = [numpy.load(f / "raw.npy")[5:100, 5:120].max() for f in (folder, square)]
    return [
        Figure("shift of the next row, pitches", float(abs(next_row[0])), 0.5, 1e-4),
        Figure("cells for the same isotropic band, hexagonal over square", float(density / (2 * band) ** 2), REGULAR, 1e-4),
        # Largest of many numbers of a noise of 1e-3 and less.
        Figure("light of a hexagon over that of its square of the same pitch", float(counts[0] / counts[1]), REGULAR, 2e-3),
    ]


def circle(tool):
    diameter_mm = 2.0
    folder = tool.render(
        "sensor-flat.toml", "circle", f"sensor.image_circle_mm={diameter_mm}", "exposure.stages=[]", "render.samples_per_pixel=4"
    )
    raw = numpy.load(folder / "raw.npy").astype(float)
    lit = int((raw > 0.5 * raw.max()).sum())
    cv2.imwrite(str(tool.picture("image-circle.png")), cv2.resize(numpy.uint8(200 * (raw > 0.5 * raw.max())), (200, 150)))
    d = diameter_mm / 10e-3
    # Gauss' circle problem: of the cells along the edge, 2·√2·d at most, each is right to a half at random; 3 σ.
    return [Figure("cells that see light", lit, math.pi / 4 * d * d, 3 * 0.5 * math.sqrt(2 * math.sqrt(2) * d))]


def linear_array(tool):
    """A row of pixels that flies past the dots and records a line every 2 ms."""
    speed, line_s = 1.0, 2e-3
    settings = ["sensor.shutter={ kind = \"scanning\", row_time_us = 2000 }", "sensor.resolution_px=[128, 200]"]
    settings += ["camera.position_m=[0, 0.2, 1]", "camera.look_at_m=[0, 0.2, 0]", f"camera.motion.velocity_m_per_s=[0, {-speed}, 0]"]
    folder = tool.render(DOTS, "line", *settings)
    raw = numpy.load(folder / "raw.npy").astype(float)
    target = report(folder)["targets"][0]
    near = numpy.array(target["points_px"])
    row, column = numpy.indices(raw.shape)
    found = centroids(raw, near, (column, row), (9, 15))
    spacing = numpy.diff(found.reshape(5, 6, 2), axis=0)[..., 1]
    columns = numpy.diff(found.reshape(5, 6, 2), axis=1)[..., 0]
    # Edges of dots as above; 24 distances of two centres each.
    return [
        Figure("lines between rows of dots 60 mm apart", float(spacing.mean()), 0.06 / (speed * line_s), 0.02),
        Figure("largest error of the places in capture.json, pixels", float(numpy.hypot(*(found - near).T).max()), 0, 0.02),
        Figure("pixels between columns of dots 60 mm apart", float(columns.mean()), 0.06 * 6e-3 / 20e-6, 0.01),
    ]


ROWS = [
    Row("Formats", "p = width / columns", "sensors --formats 4000x3000", formats),
    Row(
        "Hexagonal cells: where they are",
        "x = (c + ½·(r mod 2))·p,  y = r·p·√3/2",
        DOTS,
        hexagonal_positions,
        "hexagons.png",
    ),
    Row(
        "Hexagonal cells: what they sample",
        "A = p²·√3/2; an isotropic band needs √3/2 of the square cells, 13.4 % less",
        DOTS,
        hexagonal_sampling,
    ),
    Row("Linear array", "lines: Y/(v·t_line); pixels: f·X/(Z·p)", DOTS, linear_array),
    Row("Circular image area", "A = π/4·d²", "sensor-flat.toml", circle, "image-circle.png"),
]
