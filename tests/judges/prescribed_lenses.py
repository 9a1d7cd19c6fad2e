"""Judges images through lenses from a prescription by a tracer of its own in NumPy.

Usage: prescribed_lenses.py PHOTOSITE [grid] [edge] [off-axis] [light] [wave]

- grid: small square lamps before a retrofocus lens, in light of 450, 550 and 650 nm: their images have their middles
  where chief rays land, within 0.02 px, and so has the difference between the colours.
- edge: a slanted edge before a double Gauss: its MTF by `photosite measure mtf` is the geometric MTF of traced rays times
  that of the pixel, within 0.01.
- off-axis: the same of two edges at 12 degrees from the axis, across and along the way to it, which differ by up to 0.4.
- light: uniform light at three stops: irradiance over radiance is the projected solid angle that passes all apertures times
  what Fresnel's equations leave, over the field, within 0.3 %.
- wave: with `psf = { kind = "wave" }`, the same of an edge on the axis at f/4 and of two beside it at f/8 against the MTF of
  diffraction, from optical paths of the tracer, within 0.02.

Lenses are read from crates/photosite-lens/assets/lenses, by Python's tomllib. Exit status 0 where all is well.
"""

import json
import math
import sys
import tempfile
from pathlib import Path

import numpy as np

from traced_lens import CAMERA, Lens, bare, channels, quads, render, run, sensor

complaints = []


def check(is_well, message):
    print(("" if is_well else "NOT WELL: ") + message)
    if not is_well:
        complaints.append(message)


def picture(photosite, folder, lamps, name, f_number, gap, seen_by, samples, render_keys="", lens_keys=""):
    """Of lamps in an OBJ file through a lens that ships, with the tables of a sensor: the folder of its results."""
    return render(
        photosite, folder,
        f"[scene]\ngeometry = ['{lamps}']\n[materials.lamp]\ntype = 'diffuse'\nreflectance = 0\ndouble_sided = true\n"
        "emission = { spectrum = 'illuminants/d65', luminance_nit = 1000 }\n"
        + CAMERA + f"[lens]\nprescription = '{name}'\nf_number = {f_number}\nimage_distance_mm = {gap}\n{lens_keys}" + seen_by
        + f"[render]\nsamples_per_pixel = {samples}\nmax_depth = 1\n{render_keys}[output]\nimage = false\nraw = []\n",
    )


def grid(photosite, folder):
    name, f_number = "retrofocus", 22
    gap = Lens(name).gaps[-1] + 1.0
    lens = Lens.stopped_down(name, gap, f_number)
    efl, pupil, _ = lens.first_order()
    distance = lens.object_distance() + pupil
    size, pitch = (340, 24), 0.1
    scale = efl / distance
    places = [(x, y) for x, y in zip(np.linspace(-0.46, 0.46, 13) * size[0], np.tile([-3.3, 0.4, 2.7], 5))]
    lamps = [(float(x) * pitch / scale, float(y) * pitch / scale) for x, y in places]
    half = 4 * pitch / scale * 1e-3
    corners = [(-half, -half), (half, -half), (half, half), (-half, half)]
    quads(folder / "lamps.obj", [[(x * 1e-3 + a, y * 1e-3 + b, -distance * 1e-3) for a, b in corners] for x, y in lamps])
    worst, shifts, wanted_shifts = 0.0, {}, {}
    for nm in (450, 550, 650):
        out = picture(photosite, folder, "lamps.obj", name, f_number, gap, sensor(folder, size, pitch * 1e3, nm), 1024)
        light = channels(out / "electrons.exr")["Y"]
        shifts[nm], wanted_shifts[nm] = [], []
        for x, y in lamps:
            height = math.hypot(x, y)
            landing = lens.chief_landing(np.array([0.0, height, pupil - distance]), nm)[1] if height else 0.0
            towards = np.array([x, y]) / height if height else np.zeros(2)
            wanted = np.array([size[0] / 2 - towards[0] * landing / pitch, size[1] / 2 + towards[1] * landing / pitch])
            i, j = np.rint(wanted).astype(int)
            part = light[max(j - 9, 0):j + 9, max(i - 9, 0):i + 9]
            rows_, columns_ = np.mgrid[max(j - 9, 0):max(j - 9, 0) + part.shape[0], max(i - 9, 0):max(i - 9, 0) + part.shape[1]] + 0.5
            found = np.array([(columns_ * part).sum(), (rows_ * part).sum()]) / part.sum()
            worst = max(worst, np.linalg.norm(found - wanted))
            shifts[nm].append(found)
            wanted_shifts[nm].append(wanted)
    check(worst < 0.02, f"grid: {len(lamps)} lamps in light of three wavelengths are within {worst:.4f} px of their chief rays")
    colour = np.linalg.norm(np.array(wanted_shifts[450]) - np.array(wanted_shifts[650]), axis=1).max()
    off = np.linalg.norm(np.array(shifts[450]) - np.array(shifts[650]) - np.array(wanted_shifts[450]) + np.array(wanted_shifts[650]), axis=1).max()
    check(off < 0.02, f"grid: lateral colour of up to {colour:.4f} px between 450 and 650 nm is found within {off:.4f} px")


def edge(photosite, folder):
    name, f_number, nm, gap = "double-gauss", 2.8, 550, 65.0
    size, pitch = (64, 128), 0.005
    lens = Lens.stopped_down(name, gap, f_number)
    _, pupil, diameter = lens.first_order()
    # Its designer puts the sensor 0.4 mm before the paraxial focus.
    distance = Lens(name, gap + 0.4).object_distance() + pupil
    turn, far = math.radians(5), 0.2
    along, across = np.array([math.sin(turn), math.cos(turn), 0]) * far, np.array([math.cos(turn), -math.sin(turn), 0]) * far
    middle = np.array([0, 0, -distance * 1e-3])
    quads(folder / "edge.obj", [[middle + along, middle - along, middle - along + across, middle + along + across]])
    out = picture(photosite, folder, "edge.obj", name, f_number, gap, sensor(folder, size, pitch * 1e3, nm), 2048)
    found = json.loads(run(photosite, "measure", "mtf", out / "electrons.exr", "--channel", "Y", "--json").stdout)
    reach = 0.6 * diameter / math.hypot(diameter, distance)
    landings, left = beam(lens, np.array([0.0, 0.0, pupil - distance]), nm, np.zeros(2), reach)
    worst = worst_mtf(found, pitch, landings[:, 0], left, turn)
    check(worst < 0.01, f"edge: MTF up to half a cycle a pixel within {worst:.4f} of that of traced rays")


def off_axis(photosite, folder):
    """An edge to the right of the axis across the way to it, and one to the left along it, as far out."""
    name, f_number, nm, gap = "double-gauss", 2.8, 550, 65.0
    pitch, height, half = 0.01, 20.0, 64
    column = round(height / pitch)
    size = (2 * (column + half), 2 * half)
    lens = Lens.stopped_down(name, gap, f_number)
    _, pupil, diameter = lens.first_order()
    z = -Lens(name, gap + 0.4).object_distance()
    scale = 1 / abs(lens.chief_landing(np.array([0.0, 1.0, z]), nm)[1])
    object_height = height * scale
    for _ in range(5):
        object_height *= height / abs(lens.chief_landing(np.array([0.0, object_height, z]), nm)[1])
    turn, long = math.radians(5), 1.3 * scale
    edges = {
        "tangential": (1, np.array([math.sin(turn), math.cos(turn), 0])),
        "sagittal": (-1, np.array([math.cos(turn), math.sin(turn), 0])),
    }
    squares = []
    for side, along in edges.values():
        across = np.array([along[1], -along[0], 0])
        corners = [along, -along, across - along, across + along]
        squares.append([(long * corner + [side * object_height, 0, z - pupil]) * 1e-3 for corner in corners])
    quads(folder / "edges.obj", squares)
    # Black pixels between the edges end early by the target, which no other reaches.
    seen_by = sensor(folder, size, pitch * 1e3, nm)
    out = picture(photosite, folder, "edges.obj", name, f_number, gap, seen_by, 2048, "noise_target = 1e-6\n")
    for kind, (side, along) in edges.items():
        width, rows = (half, 2 * half) if kind == "tangential" else (2 * half, half)
        region = [size[0] // 2 + side * column - width // 2, (size[1] - rows) // 2, width, rows]
        found = json.loads(run(photosite, "measure", "mtf", out / "electrons.exr", "--channel", "Y", "--region", ",".join(map(str, region)), "--json").stdout)
        point = np.array([side * object_height, 0, z])
        towards = np.array([0, 0, pupil]) - point
        reach = 0.7 * diameter / math.hypot(diameter, towards[2])

        def of(place):
            return beam(lens, place, nm, (towards / np.linalg.norm(towards))[:2], reach)

        ends = [np.average(places, axis=0, weights=left) for places, left in (of(point - 0.3 * scale * along), of(point + 0.3 * scale * along))]
        edge_x, edge_y = (ends[1] - ends[0]) / np.linalg.norm(ends[1] - ends[0])
        landings, left = of(point)
        worst = worst_mtf(found, pitch, landings @ [edge_y, -edge_x], left, math.atan2(edge_x, edge_y))
        check(worst < 0.01, f"off-axis: MTF of a {kind} edge {height:g} mm from the axis within {worst:.4f} of that of traced rays")


WAVE = "psf = { kind = 'wave' }\n"


def wave(photosite, folder):
    """Objects in the plane that is in focus to first order, as the keys have it; best focus lies elsewhere at f/4."""
    name, nm, gap, turn = "double-gauss", 550, 65.0, math.radians(5)

    def compare(kind, lens, point, normal, found, pitch):
        frequencies, values = (np.array(found[key]) for key in ("frequency_cy_per_px", "mtf"))
        # Beyond, the noise of the edge counts more than what is left of it.
        frequencies, values = frequencies[frequencies <= 0.35], values[frequencies <= 0.35]
        pixel = np.sinc(frequencies * math.cos(turn)) * np.sinc(frequencies * math.sin(turn))
        wanted = lens.wave_mtf(point, nm, normal, frequencies / pitch)
        worst = np.abs(values - wanted * pixel).max()
        check(worst < 0.02, f"wave: MTF of {kind} within {worst:.4f} of that of optical paths, {wanted[-1]:.2f} at {frequencies[-1] / pitch:.0f}/mm")

    def measured(out, *region):
        return json.loads(run(photosite, "measure", "mtf", out / "electrons.exr", "--channel", "Y", *region, "--json").stdout)

    # On the axis
    size, pitch = (64, 96), 0.01
    lens = Lens.stopped_down(name, gap, 4)
    _, pupil, _ = lens.first_order()
    z = -lens.object_distance()
    along, across = (np.array(way) * 0.2 for way in ((math.sin(turn), math.cos(turn), 0), (math.cos(turn), -math.sin(turn), 0)))
    middle = np.array([0, 0, (z - pupil) * 1e-3])
    quads(folder / "edge.obj", [[middle + along, middle - along, middle - along + across, middle + along + across]])
    out = picture(photosite, folder, "edge.obj", name, 4, gap, sensor(folder, size, pitch * 1e3, nm), 1024, lens_keys=WAVE)
    compare("an edge on the axis at f/4", lens, np.array([0.0, 0.0, z]), (1, 0), measured(out), pitch)

    # Beside it
    pitch, height, half = 0.02, 13.0, 48
    column = round(height / pitch)
    size = (2 * (column + half), 2 * half)
    lens = Lens.stopped_down(name, gap, 8)
    _, pupil, _ = lens.first_order()
    object_height = height / abs(lens.chief_landing(np.array([0.0, 1.0, z]), nm)[1])
    for _ in range(5):
        object_height *= height / abs(lens.chief_landing(np.array([0.0, object_height, z]), nm)[1])
    scale = object_height / height
    edges = {
        "tangential": (1, np.array([math.sin(turn), math.cos(turn), 0])),
        "sagittal": (-1, np.array([math.cos(turn), math.sin(turn), 0])),
    }
    squares = []
    for side, along in edges.values():
        across = np.array([along[1], -along[0], 0])
        corners = [along, -along, across - along, across + along]
        squares.append([(1.3 * scale * corner + [side * object_height, 0, z - pupil]) * 1e-3 for corner in corners])
    quads(folder / "edges.obj", squares)
    # Black pixels between the edges end early by the target, which no other reaches.
    seen_by = sensor(folder, size, pitch * 1e3, nm)
    out = picture(photosite, folder, "edges.obj", name, 8, gap, seen_by, 512, "noise_target = 1e-6\n", WAVE)
    for kind, (side, along) in edges.items():
        width, rows = (half, 2 * half) if kind == "tangential" else (2 * half, half)
        region = [size[0] // 2 + side * column - width // 2, (size[1] - rows) // 2, width, rows]
        # The judge's point lies up from the axis, where the images lie beside it: x is across there, and y away from it.
        normal = (0, 1) if kind == "tangential" else (1, 0)
        found = measured(out, "--region", ",".join(map(str, region)))
        compare(f"a {kind} edge {height:g} mm from the axis at f/8", lens, np.array([0.0, object_height, z]), normal, found, pitch)


def beam(lens, point, nm, middle, reach):
    """Where rays of equal étendue from a point land, mm, and how much the surfaces leave of each."""
    side = np.linspace(-reach, reach, 801)
    p, q = (grid.ravel() for grid in np.meshgrid(middle[0] + side, middle[1] + side))
    direction = np.stack([p, q, np.sqrt(1 - p**2 - q**2)], 1)
    landing, passes, left = lens.land(np.tile(point, (len(p), 1)), direction, nm)
    return landing[passes, :2], left[passes]


def worst_mtf(found, pitch, x, weight, turn):
    """How far a measured MTF is from that of landings along the normal of an edge, in pixels that are turned against it."""
    worst = 0.0
    for frequency, value in zip(found["frequency_cy_per_px"], found["mtf"]):
        if frequency > 0.5:
            break
        geometric = abs((weight * np.exp(2j * np.pi * frequency / pitch * x)).sum()) / weight.sum()
        wanted = geometric * np.sinc(frequency * math.cos(turn)) * np.sinc(frequency * math.sin(turn))
        worst = max(worst, abs(value - wanted))
    return worst


def light(photosite, folder):
    name, nm, gap = "cooke-triplet", 550, 42.20778
    bare(name, folder / "bare.toml")
    size, pitch = (60, 8), 0.6
    on_axis = {}
    for f_number in (5.0022, 8, 16):
        lens = Lens.stopped_down(name, gap, f_number)
        out = render(
            photosite, folder,
            "[scene]\nenvironment = { illuminant = 'D65', illuminance_lux = 500 }\n[[scene.spheres]]\nmaterial = 'black'\nposition_m = [0, 0, 5]\nradius_m = 0.01\n"
            "[materials.black]\ntype = 'diffuse'\nreflectance = 0\n" + CAMERA
            + f"[lens]\nprescription = '{folder / 'bare.toml'}'\nf_number = {f_number}\nimage_distance_mm = {gap}\n" + sensor(folder, size, pitch * 1e3, nm)
            + "[render]\nsamples_per_pixel = 1024\nmax_depth = 1\n[output]\nimage = false\nraw = []\n",
        )
        mean = channels(out / "electrons.exr")["Y"]
        heights = np.hypot(*(np.mgrid[0:size[1], 0:size[0]] + 0.5 - np.array([size[1] / 2, size[0] / 2])[:, None, None])) * pitch
        knots = np.linspace(0, heights.max() + pitch, 25)
        curve = np.array([lens.solid_angle(h, nm) for h in knots])
        ratio = mean / np.interp(heights, knots, curve)
        on_axis[f_number] = ratio.mean()
        # Of 48 pixels each, so that chance is below a thousandth.
        rings = [ring.mean() / ratio.mean() - 1 for ring in np.array_split(ratio.ravel()[np.argsort(heights.ravel())], 10)]
        worst = np.abs(rings).max()
        check(worst < 3e-3, f"light: at f/{f_number} over ten rings within {worst:.1e} of the integral of T over S; the corner has {curve[-2] / curve[0]:.3f} of the middle")
    spread = max(on_axis.values()) / min(on_axis.values()) - 1
    check(spread < 2e-3, f"light: the same factor at all three stops, within {spread:.1e}")


PARTS = {"grid": grid, "edge": edge, "off-axis": off_axis, "light": light, "wave": wave}


def main():
    photosite, *names = sys.argv[1:]
    photosite = str(Path(photosite).resolve())
    for name in names or PARTS:
        with tempfile.TemporaryDirectory() as folder:
            folder = Path(folder)
            PARTS[name](photosite, folder)
    sys.exit(f"{len(complaints)} complaints" if complaints else 0)


if __name__ == "__main__":
    main()
