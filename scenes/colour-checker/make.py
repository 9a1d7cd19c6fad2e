#!/usr/bin/env python3
"""Writes colour-checker.obj and .mtl: 24 patches on a dark board in front of a grey wall.

Millimetres, +Y up; the face of the chart is centred on the origin and looks along +z. Patches and board lie in one plane
without gaps or overlaps: the board is cut into strips around the patches. Needs Python only.
"""

import csv
from pathlib import Path

PATCH, GAP, BORDER, THICKNESS = 40.0, 6.0, 14.0, 4.0
COLUMNS, ROWS = 6, 4
WALL = 3000.0

HERE = Path(__file__).resolve().parent
SPECTRA = HERE.parents[1] / "crates" / "photosite-core" / "assets" / "spectra"
NAMES = sorted(path.stem for path in (SPECTRA / "colour-checker").glob("*.csv"))


def cuts(count):
    """Where a row of patches begins and ends: board edge, patch, gap, patch …, board edge, centred on 0."""
    width = count * PATCH + (count - 1) * GAP + 2 * BORDER
    edges = [0.0]
    for i in range(count):
        edges += [BORDER + i * (PATCH + GAP), BORDER + i * (PATCH + GAP) + PATCH]
    return [edge - width / 2 for edge in edges + [width]]


def table(path):
    """Columns of a CSV file of the library by name."""
    with open(path, encoding="utf-8") as file:
        rows = list(csv.DictReader(line for line in file if not line.startswith("#")))
    return {name: [float(row[name]) for row in rows] for name in rows[0]}


def interpolate(spectrum, wavelength):
    """A tabulated spectrum, held constant beyond its ends."""
    x, y = spectrum["wavelength_nm"], spectrum["value"]
    if wavelength <= x[0] or wavelength >= x[-1]:
        return y[0] if wavelength <= x[0] else y[-1]
    i = next(i for i, edge in enumerate(x) if edge > wavelength)
    return y[i - 1] + (y[i] - y[i - 1]) * (wavelength - x[i - 1]) / (x[i] - x[i - 1])


def linear_srgb(reflectance):
    """Linear sRGB of a reflectance under D65, for programs that do not know spectra."""
    observer = table(SPECTRA / "cie-1931-2deg.csv")
    d65 = table(SPECTRA / "illuminants" / "d65.csv")
    xyz, white = [0.0] * 3, 0.0
    for i, wavelength in enumerate(observer["wavelength_nm"]):
        light = interpolate(d65, wavelength)
        white += light * observer["y"][i]
        for c, name in enumerate("xyz"):
            xyz[c] += light * interpolate(reflectance, wavelength) * observer[name][i]
    x, y, z = (value / white for value in xyz)
    rgb = (
        3.2404542 * x - 1.5371385 * y - 0.4985314 * z,
        -0.9692660 * x + 1.8760108 * y + 0.0415560 * z,
        0.0556434 * x - 0.2040259 * y + 1.0572252 * z,
    )
    return [max(0.0, value) for value in rgb]


def main():
    xs, ys = cuts(COLUMNS), cuts(ROWS)
    lines = ["# 24 patches of 40 mm on a dark board. Written by make.py. Millimetres.", "mtllib colour-checker.mtl"]

    def quad(*corners):
        lines.extend("v " + " ".join(f"{value:g}" for value in corner) for corner in corners)
        lines.append("f -4 -3 -2 -1")

    def front(x0, x1, y0, y1, z=0.0):
        quad((x0, y0, z), (x1, y0, z), (x1, y1, z), (x0, y1, z))

    for i, name in enumerate(NAMES):
        row, column = divmod(i, COLUMNS)
        # Patch 1 is at the top left, and y grows upwards.
        x, y = 1 + 2 * column, 1 + 2 * (ROWS - 1 - row)
        lines += [f"o {name}", f"usemtl {name}"]
        front(xs[x], xs[x + 1], ys[y], ys[y + 1])

    lines += ["o board", "usemtl board"]
    for j in range(len(ys) - 1):
        if j % 2 == 0:
            front(xs[0], xs[-1], ys[j], ys[j + 1])
        else:
            for i in range(0, len(xs) - 1, 2):
                front(xs[i], xs[i + 1], ys[j], ys[j + 1])
    left, right, bottom, top, back = xs[0], xs[-1], ys[0], ys[-1], -THICKNESS
    quad((left, bottom, back), (left, bottom, 0), (left, top, 0), (left, top, back))
    quad((right, bottom, 0), (right, bottom, back), (right, top, back), (right, top, 0))
    quad((left, bottom, back), (right, bottom, back), (right, bottom, 0), (left, bottom, 0))
    quad((left, top, 0), (right, top, 0), (right, top, back), (left, top, back))

    lines += ["o wall", "usemtl wall"]
    front(-WALL / 2, WALL / 2, -WALL / 2, WALL / 2, back)
    (HERE / "colour-checker.obj").write_text("\n".join(lines) + "\n", encoding="utf-8")

    materials = ["# Linear sRGB under D65, for programs that know RGB only. Written by make.py."]
    for name in NAMES:
        kd = linear_srgb(table(SPECTRA / "colour-checker" / f"{name}.csv"))
        materials += [f"newmtl {name}", "Kd " + " ".join(f"{value:.4f}" for value in kd)]
    for name, grey in (("board", 0.03), ("wall", 0.18)):
        materials += [f"newmtl {name}", f"Kd {grey} {grey} {grey}"]
    (HERE / "colour-checker.mtl").write_text("\n".join(materials) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
