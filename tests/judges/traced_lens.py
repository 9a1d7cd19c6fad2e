"""A tracer of lenses in NumPy, and renders of them: what the judges of lenses from a prescription share.

Lenses are read from crates/photosite-lens/assets/lenses by Python's tomllib; of photosite nothing is used but the command.
"""

import math
import subprocess
import sys
import tomllib
from pathlib import Path

import numpy as np
import OpenEXR

ROOT = Path(__file__).parents[2]
D_NM = 587.5618


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

    @classmethod
    def stopped_down(cls, name, last_gap, f_number):
        """The stop is that of the focal length and the pupil at infinity."""
        lens = cls(name)
        efl, _, diameter = lens.first_order()
        return cls(name, last_gap, lens.semi[lens.stop] * efl / diameter / f_number)

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

    def trace(self, origin, direction, nm, surfaces=None, clip=True, outwards=False, met=None):
        """Through some surfaces in their order: points, directions, which pass, and what Fresnel's equations leave.

        Of each surface `met` gets the points on it and the optical path from those before.
        """
        n = self.index(nm)
        p, d = np.array(origin, float), np.array(direction, float)
        passes, left = np.ones(len(p), bool), np.ones(len(p))
        order = range(len(self.radii)) if surfaces is None else surfaces
        for i in reversed(order) if outwards else order:
            radius, (before, behind) = self.radii[i], ((n[i + 1], n[i]) if outwards else (n[i], n[i + 1]))
            start = p.copy()
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
            if met is not None:
                met.append((p.copy(), before * np.linalg.norm(p - start, axis=1)))
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

    def wave_mtf(self, point, nm, normal, per_mm, degree=16, rays=121, across=384):
        """MTF of diffraction at frequencies along a normal on the sensor, of an object point (0, y, z) or on the axis.

        The optical path from the point to where a ray lands, less D times the way from the chief ray's landing there, and the
        places on all surfaces, are polynomials of the direction cosines D at the sensor, fitted to rays. The transfer is the
        autocorrelation of exp(2 pi i W / wavelength) over what passes all apertures.
        """
        normal = np.asarray(normal) / np.linalg.norm(normal)
        chief = self.chief_landing(point, nm)
        _, pupil, diameter = self.first_order()
        towards = np.array([0.0, 0.0, pupil]) - point
        axis = towards / np.linalg.norm(towards)
        reach = 0.75 * diameter / np.linalg.norm(towards)
        sides = np.linspace(-reach, reach, rays)
        p, q = (grid.ravel() for grid in np.meshgrid(axis[0] + sides, axis[1] + sides))
        direction = np.stack([p, q, np.sqrt(1 - p**2 - q**2)], 1)
        met = []
        behind, d, passes, _ = self.trace(np.tile(point, (len(p), 1)), direction, nm, clip=False, met=met)
        to_sensor = (self.sensor_z - behind[:, 2]) / d[:, 2]
        landing = behind + d * to_sensor[:, None]
        near = passes & np.all([np.hypot(*place[:, :2].T) < 1.08 * semi for (place, _), semi in zip(met, self.semi)], axis=0)
        path = sum(length for _, length in met) + to_sensor
        path = path - (d * (landing - chief)).sum(1)
        wanted = np.stack([path] + [place[:, i] for place, _ in met for i in (0, 1)], 1)[near]
        cosines = d[near, :2]
        middle, half = (cosines.max(0) + cosines.min(0)) / 2, (cosines.max(0) - cosines.min(0)).max() / 2

        def terms(c):
            c = (c - middle) / half
            x, y = (np.polynomial.legendre.legvander(column, degree) for column in c.T)
            return np.concatenate([x[:, : degree + 1 - j] * y[:, j : j + 1] for j in range(degree + 1)], 1)

        fit, *_ = np.linalg.lstsq(terms(cosines), wanted, rcond=None)
        off = np.abs(terms(cosines) @ fit - wanted)[passes[near]]
        assert off[:, 0].max() < 0.02 * nm * 1e-6 and off[:, 1:].max() < 2e-3, (off[:, 0].max() / (nm * 1e-6), off[:, 1:].max())
        side = half * (np.arange(across) + 0.5) / across * 2 - half
        u, v = np.meshgrid(side, side)
        there = middle + u.ravel()[:, None] * normal + v.ravel()[:, None] * np.array([-normal[1], normal[0]])
        found = terms(there) @ fit
        inside = np.all(np.abs((there - middle) / half) <= 1, axis=1)
        inside &= np.all([np.hypot(found[:, 2 * i + 1], found[:, 2 * i + 2]) <= semi for i, semi in enumerate(self.semi)], axis=0)
        w = found[:, 0] - found[inside, 0].mean()
        field = np.where(inside, np.exp(2j * np.pi * w / (nm * 1e-6)), 0).reshape(across, across)
        correlated = np.fft.ifft((np.abs(np.fft.fft(field, 2 * across, axis=1)) ** 2).sum(0))[:across]
        step = 2 * half / across / (nm * 1e-6)
        transfer = np.abs(correlated) / abs(correlated[0])
        return np.interp(per_mm, step * np.arange(across), transfer)

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


def render(photosite, folder, text, name="out"):
    capture, out = folder / f"{name}.toml", folder / name
    capture.write_text(text)
    run(photosite, "render", capture, "-o", out, "--force", "--quiet")
    return out


CAMERA = "[camera]\nposition_m = [0, 0, 0]\nlook_at_m = [0, 0, -1]\n"


def quads(path, squares, material="lamp"):
    """An OBJ file of squares across the axis, each of its own corners, m."""
    lines = [f"v {float(x)!r} {float(y)!r} {float(z)!r}" for corners in squares for x, y, z in corners]
    lines += [f"f {4 * i + 1} {4 * i + 2} {4 * i + 3} {4 * i + 4}" for i in range(len(squares))]
    path.write_text(f"usemtl {material}\n" + "\n".join(lines) + "\n")


def bare(name, path):
    """The lens without coatings, whose losses are those of Fresnel's equations."""
    text = (ROOT / f"crates/photosite-lens/assets/lenses/{name}.toml").read_text()
    path.write_text(text.replace("semi_aperture =", 'coating = "none", semi_aperture ='))
