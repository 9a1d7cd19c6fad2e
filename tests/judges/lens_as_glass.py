"""Judges lenses from a prescription by the same lenses as glass in the scene.

Usage: lens_as_glass.py PHOTOSITE [cooke-triplet] [double-gauss] [--times N]

Surfaces of a lens become meshes of glass before a camera that has no optics but a round hole behind the last of them. Black
rings around each surface stop what its semi-aperture stops, and the stop of the double Gauss has five blades. What is seen
through them is a chequered wall in focus, with small lamps far out of focus before it, in light of 550 nm. The same camera
with `lens.prescription` must take the same image: z, the difference over its standard deviation, follows N(0, 1) over all
pixels, and so do sums over blocks of them.

Paths end with the segment that meets a lamp if all surfaces let them through: light that surfaces reflect to and fro, which
a prescription does not have, would take more segments. Lenses have no coatings, and lose what Fresnel's equations say.

Of the triplet it notices coatings, light of 600 nm, a sensor that is 0.1 mm off, and a stop that is 0.5 % too small; not a
stop that is 0.2 % too small. Of the double Gauss it notices blades that are half a blade off; not 2 degrees.

--times N takes N times as many samples. Exit status 0 where all is well.
"""

import argparse
import json
import math
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

from traced_lens import CAMERA, Lens, bare, channels, quads, render, sensor

NM = 550
# Of meshes. Normals between points are those of the sphere, so that rays turn as at spheres, up to 1e-3 mm too late.
RINGS, AZIMUTHS = 32, 360
# Their polygons are as large as circles.
AS_LARGE = math.sqrt(2 * math.pi / AZIMUTHS / math.sin(2 * math.pi / AZIMUTHS))
SIZE = (48, 32)
BLOCK = 4
# Pitch in mm, samples of a pixel through glass (a minute each on two cores), and blades of the stop with their rotation.
LENSES = {"cooke-triplet": (0.6, 8192, None), "double-gauss": (0.85, 8192, (5, 10))}
# Of one z among all; of the mean and of spreads. One lens in 400 fails by chance.
Z_ONE, Z_ALL = 5, 3.5
complaints = []


def check(is_well, message):
    print(("" if is_well else "NOT WELL: ") + message)
    if not is_well:
        complaints.append(message)


class Turned:
    """An OBJ file of surfaces that lines of points (r, z) make around the z axis: here in mm, in the file in m from the
    entrance pupil."""

    def __init__(self, pupil):
        self.pupil, self.lines, self.points, self.normals = pupil, [], 0, 0

    def add(self, material, profile, centre=None):
        """Fronts are towards -z where r grows; around a centre on the axis the surface is as smooth as a sphere."""
        angle = 2 * np.pi * np.arange(AZIMUTHS) / AZIMUTHS
        points = np.concatenate([
            np.stack([r * np.cos(angle), r * np.sin(angle), np.full(AZIMUTHS, z)], 1) for r, z in profile
        ])
        self.lines.append(f"usemtl {material}")
        self.lines += [f"v {x:.10g} {y:.10g} {z:.10g}" for x, y, z in (points - [0, 0, self.pupil]) * 1e-3]
        if centre is not None:
            normals = points - [0, 0, centre]
            normals *= (-np.sign(normals[:, 2]) / np.linalg.norm(normals, axis=1))[:, None]
            self.lines += [f"vn {x:.9g} {y:.9g} {z:.9g}" for x, y, z in normals]
        for ring in range(len(profile) - 1):
            for i in range(AZIMUTHS):
                j = (i + 1) % AZIMUTHS
                inner, outer = ring * AZIMUTHS, (ring + 1) * AZIMUTHS
                corners = [inner + i, inner + j, outer + j, outer + i]
                if np.all(profile[ring][0] == 0):
                    del corners[1]
                names = [f"{self.points + k + 1}" for k in corners]
                if centre is not None:
                    names = [f"{name}//{self.normals + k + 1}" for name, k in zip(names, corners)]
                self.lines.append("f " + " ".join(names))
        self.points += len(points)
        self.normals += 0 if centre is None else len(points)


def polygon(radius, blades, rotation_deg):
    """Distances from the axis, at all azimuths, of the edges of a regular polygon in a circle."""
    from_corner = (2 * np.pi * np.arange(AZIMUTHS) / AZIMUTHS - math.radians(rotation_deg)) % (2 * np.pi / blades)
    return radius * math.cos(np.pi / blades) / np.cos(from_corner - np.pi / blades)


def glass(lens, blades, path):
    """Writes a lens as meshes and gives their materials, how many surfaces refract, and the hole's z and radius."""
    meshes, index, materials = Turned(lens.first_order()[1]), lens.index(NM), ["black = { type = 'diffuse', reflectance = 0 }"]
    barrel, black = 1.2 * max(lens.semi) + 1, []

    def sag(i, r):
        return r * r / lens.radii[i] / (1 + math.sqrt(1 - (r / lens.radii[i]) ** 2))

    for i, semi in enumerate(lens.semi):
        profile = [(r, lens.z[i] + sag(i, r)) for r in np.linspace(0, semi, RINGS + 1)]
        rim = semi * AS_LARGE, profile[-1][1]
        if index[i] != index[i + 1]:
            # A plane is a sphere with its centre far away.
            meshes.add(f"glass-{i}", [*profile[:-1], rim], lens.z[i] + min(lens.radii[i], 1e9))
            materials.append(f"glass-{i} = {{ type = 'dielectric', index = {index[i + 1] / index[i]} }}")
        if i == lens.stop and blades:
            # In air, since glass would have to end with the blades.
            assert index[i] == index[i + 1] == 1
            rim = polygon(semi, *blades), rim[1]
        meshes.add("black", [rim, (barrel, rim[1])])
        black.append(rim[1])
    hole = max(lens.z[-2], black[-1]) + 0.1
    meshes.add("black", [(barrel, min(0.0, black[0])), (barrel, hole)])
    path.write_text("\n".join(meshes.lines) + "\n")
    return "\n".join(materials) + "\n", len(materials) - 1, hole, lens.semi[-1] + 0.5


def scene(lens, pitch, folder):
    """A wall and lamps before it, as the files of their geometry and the materials that they have."""
    efl, pupil, diameter = lens.first_order()
    far = lens.object_distance() + pupil
    near = 1 / (1 / far + 12 * pitch / diameter / efl)
    # Were they darker, a few rays that meet a brighter one would decide about pixels at its edge, and z would not be normal.
    random, squares = np.random.default_rng(1), {200: [], 300: [], 600: [], 1000: [], 5000: []}

    def add(luminance, distance, middle, size):
        """In a plane across the axis; where the middle of the lens sees it in the image, px."""
        (x, y), (u, v) = ((np.array(middle) + sign * np.array(size) / 2) * pitch * distance / efl * 1e-3 for sign in (-1, 1))
        z = -distance * 1e-3
        squares[luminance].append([(x, y, z), (u, y, z), (u, v, z), (x, v, z)])

    cell = 2.9
    for a in range(-11, 12):
        for b in range(-8, 9):
            add([(200, 300), (600, 1000)][(a + b) % 2][random.integers(2)], far, (a * cell, b * cell), (cell, cell))
    for middle in [(0.7, 0.4), (-14.2, 9.1), (17.5, 10.8), (12.3, -8.6), (-18.1, -10.2)]:
        add(5000, near, middle, (3, 3))
    materials = ""
    for luminance, corners in squares.items():
        quads(folder / f"{luminance}.obj", corners, f"lamp-{luminance}")
        materials += f"lamp-{luminance} = {{ type = 'diffuse', reflectance = 0, emission = {{ spectrum = 'illuminants/d65', luminance_nit = {luminance} }} }}\n"
    return [f"{luminance}.obj" for luminance in squares], materials


def judge(photosite, folder, name, times):
    pitch, samples, blades = LENSES[name]
    # Focused on about 20 times the focal length.
    open_lens = Lens(name)
    lens = Lens(name, open_lens.gaps[-1] + open_lens.first_order()[0] / 19)
    bare(name, folder / "bare.toml")
    geometry, of_scene = scene(lens, pitch, folder)
    of_lens, surfaces, hole, hole_radius = glass(lens, blades, folder / "lens.obj")
    of_stop = "blades = {}\nblade_rotation_deg = {}\n".format(*blades) if blades else ""

    def picture(kind, geometry, materials, position_mm, optics, depth, samples, seed):
        out = render(
            photosite, folder,
            f"[scene]\ngeometry = {geometry}\n[materials]\n{materials}" + CAMERA.replace("[0, 0, 0]", f"[0, 0, {position_mm * 1e-3}]")
            + f"[lens]\n{optics}\n" + sensor(folder, SIZE, pitch * 1e3, NM)
            + f"[render]\nsamples_per_pixel = {samples}\nmax_depth = {depth}\nroulette_depth = {depth}\nsampler = 'independent'\nseed = {seed}\n"
            + "[output]\nimage = false\nraw = []\n",
            kind,
        )
        return out / "electrons.exr"

    traced = picture(
        "prescription", geometry, of_scene, 0,
        f"prescription = '{folder / 'bare.toml'}'\nimage_distance_mm = {lens.gaps[-1]}\n{of_stop}", 1, 4 * samples * times, 1
    )
    behind = lens.sensor_z - hole
    seen = picture(
        "glass", [*geometry, "lens.obj"], of_scene + of_lens, hole - lens.first_order()[1],
        f"type = 'hole'\nimage_distance_mm = {behind}\nf_number = {behind / 2 / hole_radius}", surfaces + 1, samples * times, 3
    )
    a, b = channels(traced), channels(seen)
    difference, variance = a["Y"] - b["Y"], a["variance.Y"] + b["variance.Y"]
    check((variance > 0).all(), f"{name}: light is in all {variance.size} pixels")
    mean = difference.sum() / b["Y"].sum()
    sigma = math.sqrt(variance.sum()) / b["Y"].sum()
    check(abs(mean) < Z_ALL * sigma, f"{name}: the mean differs by {mean:+.3%}, its standard deviation is {sigma:.3%}")

    def blocks(picture, side):
        return picture.reshape(SIZE[1] // side, side, SIZE[0] // side, side).sum((1, 3))

    for side, what in (1, "pixels"), (BLOCK, f"blocks of {BLOCK} x {BLOCK} pixels"):
        z = blocks(difference, side) / np.sqrt(blocks(variance, side))
        spread = math.sqrt((z**2).mean())
        uncertain = 1 / math.sqrt(2 * z.size)
        check(
            np.abs(z).max() < Z_ONE and abs(spread - 1) < Z_ALL * uncertain,
            f"{name}: z of {z.size} {what} have the mean {z.mean():+.3f}, the spread {spread:.3f} (N(0, 1): within {uncertain:.3f}), the largest is {np.abs(z).max():.2f}",
        )


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("photosite")
    parser.add_argument("names", nargs="*", metavar="lens", help=f"of {', '.join(LENSES)}")
    parser.add_argument("--times", type=int, default=1)
    arguments = parser.parse_args()
    for name in arguments.names or LENSES:
        with tempfile.TemporaryDirectory() as folder:
            judge(str(Path(arguments.photosite).resolve()), Path(folder), name, arguments.times)
    sys.exit(f"{len(complaints)} complaints" if complaints else 0)


if __name__ == "__main__":
    main()
