"""Judges pictures through lenses from a prescription by a tracer of its own in NumPy.

Usage: prescribed_lenses.py PHOTOSITE [grid] [edge] [light]

- grid: small square lamps before a retrofocus lens, in light of 450, 550 and 650 nm: their pictures have their middles
  where chief rays land, within 0.02 px, and so has the difference between the colours.
- edge: a slanted edge before a double Gauss: its MTF by `photosite measure mtf` is the geometric MTF of traced rays times
  that of the pixel, within 0.01.
- light: uniform light at three stops: irradiance over radiance is the projected solid angle that passes all apertures times
  what Fresnel's equations leave, over the field, within 0.3 %.

Lenses are read from crates/photosite-lens/assets/lenses, by Python's tomllib. Exit status 0 where all is well.
"""

import json
import math
import subprocess
import sys
import tempfile
import tomllib
from pathlib import Path

import numpy as np
import OpenEXR

ROOT = Path(__file__).parents[2]
D_NM = 587.5618
complaints = []


def check(is_well, message):
    print(("" if is_well else "NOT WELL: ") + message)
    if not is_well:
        complaints.append(message)


class Lens:
    """Spheres and planes, mm; z = 0 at the first vertex, +z towards the sensor."""

    def __init__(self, name, last_gap=None, stop_radius=None):
        file = tomllib.loads((ROOT / f"crates/photosite-lens/assets/lenses/{name}.toml").read_text())
        self.surfaces = file["surfaces"]
        self.glasses = file["glasses"]
        assert not any(key in surface for surface in self.surfaces for key in ("conic", "asphere"))
        self.radii = [surface.get("radius", math.inf) for surface in self.surfaces]
        self.gaps = [surface["thickness"] for surface in self.surfaces]
        self.semi = [surface["semi_aperture"] for surface in self.surfaces]
        self.stop = next(i for i, surface in enumerate(self.surfaces) if surface.get("stop"))
        if last_gap is not None:
            self.gaps[-1] = last_gap
        if stop_radius is not None:
            self.semi[self.stop] = stop_radius
        self.z = np.concatenate([[0.0], np.cumsum(self.gaps)])

    @property
    def sensor_z(self):
        return self.z[-1]

    def index(self, nm):
        """Before each surface, and behind the last."""
        um = nm * 1e-3
        indices = [1.0]
        for surface in self.surfaces:
            glass = self.glasses.get(surface.get("glass"))
            if glass is None:
                indices.append(1.0)
            elif "sellmeier_b" in glass:
                terms = zip(glass["sellmeier_b"], glass["sellmeier_c_um2"])
                indices.append(math.sqrt(1 + sum(b * um**2 / (um**2 - c) for b, c in terms)))
            else:
                indices.append(math.sqrt(sum(a * um**e for a, e in glass["polynomial"])))
        return indices

    def first_order(self, nm=D_NM):
        """Focal length, entrance pupil from the first vertex, its diameter."""
        n = self.index(nm)

        def through(y, u, surfaces):
            heights = []
            for k, i in enumerate(surfaces):
                if k:
                    y += u * self.gaps[surfaces[k - 1]]
                heights.append(y)
                u = (n[i] * u - y / self.radii[i] * (n[i + 1] - n[i])) / n[i + 1]
            return y, u, heights

        every = list(range(len(self.radii)))
        _, u, _ = through(1.0, 0.0, every)
        efl = -1.0 / u
        # Heights at the stop of the rays (1, 0) and (0, 1) before the first surface.
        a = through(1.0, 0.0, every)[2][self.stop]
        b = through(0.0, 1.0, every)[2][self.stop]
        return efl, b / a, 2 * self.semi[self.stop] / abs(a)

    def object_distance(self, nm=D_NM):
        """What the sensor is in the paraxial focus of, from the first vertex, mm."""
        n = self.index(nm)

        def at_sensor(y, u):
            for i, gap in enumerate(self.gaps):
                u = (n[i] * u - y / self.radii[i] * (n[i + 1] - n[i])) / n[i + 1]
                y += u * gap
            return y

        return -at_sensor(0.0, 1.0) / at_sensor(1.0, 0.0)

    def trace(self, origin, direction, nm, surfaces=None, clip=True, outwards=False):
        """Through some surfaces in their order: points, directions, which pass, and what Fresnel's equations leave."""
        n = self.index(nm)
        p, d = np.array(origin, float), np.array(direction, float)
        passes, left = np.ones(len(p), bool), np.ones(len(p))
        order = range(len(self.radii)) if surfaces is None else surfaces
        for i in reversed(order) if outwards else order:
            radius, (before, behind) = self.radii[i], ((n[i + 1], n[i]) if outwards else (n[i], n[i + 1]))
            p[:, 2] -= self.z[i]
            p -= d * (p[:, 2] / d[:, 2])[:, None]
            c = 0.0 if math.isinf(radius) else 1.0 / radius
            b = d[:, 2] - c * (p[:, 0] * d[:, 0] + p[:, 1] * d[:, 1])
            height2 = c * (p[:, 0] ** 2 + p[:, 1] ** 2)
            root = b * b - c * height2
            passes &= root >= 0
            along = np.sqrt(np.maximum(root, 0))
            p += d * (height2 / (b + np.where(b > 0, along, -along)))[:, None]
            if clip:
                passes &= np.hypot(p[:, 0], p[:, 1]) <= self.semi[i]
            normal = np.stack([-c * p[:, 0], -c * p[:, 1], 1 - c * p[:, 2]], 1)
            normal *= np.sign((normal * d).sum(1))[:, None]
            cosine, ratio = (normal * d).sum(1), before / behind
            cosine2 = 1 - ratio**2 * (1 - cosine**2)
            passes &= cosine2 >= 0
            refracted = np.sqrt(np.maximum(cosine2, 0))
            s = (before * cosine - behind * refracted) / (before * cosine + behind * refracted)
            q = (behind * cosine - before * refracted) / (behind * cosine + before * refracted)
            left *= 1 - (s**2 + q**2) / 2
            d = ratio * d + (refracted - ratio * cosine)[:, None] * normal
            p[:, 2] += self.z[i]
        return p, d, passes, left

    def land(self, origin, direction, nm, clip=True):
        p, d, passes, left = self.trace(origin, direction, nm, clip=clip)
        return p + d * ((self.sensor_z - p[:, 2]) / d[:, 2])[:, None], passes, left

    def chief_landing(self, point, nm):
        """Where the ray of an object point (0, y, z) through the middle of the stop lands."""
        aim = np.array([0.0, self.first_order()[1]])
        before = list(range(self.stop + 1))

        def at_stop(height):
            towards = np.array([[0.0, height, aim[1]]]) - point
            towards /= np.linalg.norm(towards)
            return self.trace([point], towards, nm, before, clip=False)[0][0, 1], towards

        low, high = 0.0, 1e-3
        for _ in range(50):
            (a, _), (b, towards) = at_stop(low), at_stop(high)
            if abs(b) < 1e-12 or a == b:
                break
            low, high = high, high - b * (high - low) / (b - a)
        return self.land([point], towards, nm, clip=False)[0][0]

    def solid_angle(self, height, nm):
        """∬ T dp dq over the directions that pass from the sensor point (0, height)."""
        rim = self.semi[-1] + abs(height)
        reach = 1.05 * rim / math.hypot(rim, self.sensor_z - self.z[-2])
        low, high = np.array([-reach, -reach]), np.array([reach, reach])
        # Where they are is seen in a coarse grid, and summed in a fine one.
        for across in (200, 300):
            cell = (high - low) / across
            p, q = (grid.ravel() for grid in np.meshgrid(*(low[:, None] + cell[:, None] * (np.arange(across) + 0.5))))
            inside = p**2 + q**2 < 1
            p, q = p[inside], q[inside]
            origin = np.tile([0.0, height, self.sensor_z], (len(p), 1))
            direction = np.stack([p, q, -np.sqrt(1 - p**2 - q**2)], 1)
            _, _, passes, left = self.trace(origin, direction, nm, outwards=True)
            passing = np.stack([p, q], 1)[passes]
            low, high = passing.min(0) - 1.5 * cell, passing.max(0) + 1.5 * cell
        return left[passes].sum() * cell.prod()


def run(photosite, *arguments):
    done = subprocess.run([photosite, *map(str, arguments)], capture_output=True, text=True, check=False)
    if done.returncode:
        sys.exit(f"{arguments}: {done.stderr}")
    return done


def channels(path):
    with OpenEXR.File(str(path), separate_channels=True) as file:
        return {name: channel.pixels.astype(float) for name, channel in file.parts[0].channels.items()}


def sensor(folder, size, pitch_um, nm):
    """One that sees one wavelength, so that no path goes for others."""
    (folder / "line.csv").write_text(f"wavelength_nm,value\n{nm - 1},0\n{nm},1\n{nm + 1},0\n")
    return (
        "[sensor]\npreset = 'generic-cmos-color'\ncfa = 'mono'\nwithout = ['channels.R', 'channels.G', 'channels.B']\n"
        f"channels.Y.quantum_efficiency = {{ file = 'line.csv' }}\nresolution_px = {list(size)}\n"
        f"pixel_pitch_um = [{pitch_um}, {pitch_um}]\n[exposure]\ntime_s = 1e-3\n"
    )


def render(photosite, folder, text, *options):
    (folder / "capture.toml").write_text(text)
    out = folder / "out"
    run(photosite, "render", folder / "capture.toml", "-o", out, "--force", "--quiet", *options)
    return out


CAMERA = "[camera]\nposition_m = [0, 0, 0]\nlook_at_m = [0, 0, -1]\n"


def quads(path, squares):
    """An OBJ file of squares across the axis, each of its own corners, m."""
    lines = [f"v {float(x)!r} {float(y)!r} {float(z)!r}" for corners in squares for x, y, z in corners]
    lines += [f"f {4 * i + 1} {4 * i + 2} {4 * i + 3} {4 * i + 4}" for i in range(len(squares))]
    path.write_text("usemtl lamp\n" + "\n".join(lines) + "\n")


def grid(photosite, folder):
    name, f_number = "retrofocus", 22
    gap = Lens(name).gaps[-1] + 1.0
    open_lens = Lens(name)
    lens = Lens(name, gap)
    efl, pupil, _ = lens.first_order()
    lens = Lens(name, gap, open_lens.semi[open_lens.stop] * open_lens.first_order()[0] / open_lens.first_order()[2] / f_number)
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
        out = render(
            photosite, folder,
            "[scene]\ngeometry = ['lamps.obj']\n[materials.lamp]\ntype = 'diffuse'\nreflectance = 0\ndouble_sided = true\nemission = { spectrum = 'illuminants/d65', luminance_nit = 1000 }\n"
            + CAMERA + f"[lens]\nprescription = '{name}'\nf_number = {f_number}\nimage_distance_mm = {gap}\n" + sensor(folder, size, pitch * 1e3, nm)
            + "[render]\nsamples_per_pixel = 1024\nmax_depth = 1\n[output]\nimage = false\nraw = []\n",
        )
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
    open_lens = Lens(name)
    radius = open_lens.semi[open_lens.stop] * open_lens.first_order()[0] / open_lens.first_order()[2] / f_number
    lens = Lens(name, gap, radius)
    _, pupil, diameter = lens.first_order()
    # Its designer puts the sensor 0.4 mm before the paraxial focus.
    distance = Lens(name, gap + 0.4).object_distance() + pupil
    turn, far = math.radians(5), 0.2
    along, across = np.array([math.sin(turn), math.cos(turn), 0]) * far, np.array([math.cos(turn), -math.sin(turn), 0]) * far
    middle = np.array([0, 0, -distance * 1e-3])
    quads(folder / "edge.obj", [[middle + along, middle - along, middle - along + across, middle + along + across]])
    out = render(
        photosite, folder,
        "[scene]\ngeometry = ['edge.obj']\n[materials.lamp]\ntype = 'diffuse'\nreflectance = 0\ndouble_sided = true\n"
        "emission = { spectrum = 'illuminants/d65', luminance_nit = 1000 }\n"
        + CAMERA + f"[lens]\nprescription = '{name}'\nf_number = {f_number}\nimage_distance_mm = {gap}\n" + sensor(folder, size, pitch * 1e3, nm)
        + "[render]\nsamples_per_pixel = 2048\nmax_depth = 1\n[output]\nimage = false\nraw = []\n",
    )
    found = json.loads(run(photosite, "measure", "mtf", out / "electrons.exr", "--channel", "Y", "--json").stdout)
    # Rays of equal étendue from the point on the axis.
    n = 801
    reach = 0.6 * diameter / math.hypot(diameter, distance)
    side = np.linspace(-reach, reach, n)
    p, q = (grid.ravel() for grid in np.meshgrid(side, side))
    direction = np.stack([p, q, np.sqrt(1 - p**2 - q**2)], 1)
    landing, passes, left = lens.land(np.tile([0.0, 0.0, pupil - distance], (len(p), 1)), direction, nm)
    x, weight = landing[passes, 0], left[passes]
    worst = 0.0
    for frequency, value in mtf_curve(found):
        if frequency > 0.5:
            break
        phase = 2 * np.pi * frequency / pitch * x
        geometric = abs((weight * np.exp(1j * phase)).sum()) / weight.sum()
        wanted = geometric * np.sinc(frequency * math.cos(turn)) * np.sinc(frequency * math.sin(turn))
        worst = max(worst, abs(value - wanted))
    check(worst < 0.01, f"edge: MTF up to half a cycle a pixel within {worst:.4f} of that of traced rays")


def mtf_curve(found):
    return zip(found["frequency_cy_per_px"], found["mtf"])


def light(photosite, folder):
    name, nm, gap = "cooke-triplet", 550, 42.20778
    open_lens = Lens(name)
    bare(name, folder / "bare.toml")
    efl, _, diameter = open_lens.first_order()
    size, pitch = (60, 8), 0.6
    on_axis = {}
    for f_number in (5.0022, 8, 16):
        radius = open_lens.semi[open_lens.stop] * efl / diameter / f_number
        lens = Lens(name, gap, radius)
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


PARTS = {"grid": grid, "edge": edge, "light": light}


def main():
    photosite, *names = sys.argv[1:]
    photosite = str(Path(photosite).resolve())
    for name in names or PARTS:
        with tempfile.TemporaryDirectory() as folder:
            folder = Path(folder)
            PARTS[name](photosite, folder)
    sys.exit(f"{len(complaints)} complaints" if complaints else 0)


def bare(name, path):
    """The lens without coatings, whose losses are those of Fresnel's equations."""
    text = (ROOT / f"crates/photosite-lens/assets/lenses/{name}.toml").read_text()
    path.write_text(text.replace("semi_aperture =", 'coating = "none", semi_aperture ='))


if __name__ == "__main__":
    main()
