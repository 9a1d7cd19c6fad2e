#!/usr/bin/env python3
"""Writes balls.gltf and .bin, four balls on a tiled floor, and sky.hdr, the clear sky above them.

The sky is the analytic model of A. J. Preetham, P. Shirley and B. Smits, "A Practical Analytic Model for Daylight",
SIGGRAPH 1999 (appendix A.2), at turbidity 2.6: luminance and chromaticity by direction. The sun is drawn as a hazy disk far
larger than the real one, but with a sun's illuminance. A pixel value of 1 in all channels means white of 1000 nit.
Needs Python only.
"""

import math
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent))
from gltf_file import GltfFile, sphere  # noqa: E402

WIDTH, HEIGHT = 512, 256
TURBIDITY = 2.6
SUN_ELEVATION = math.radians(38.0)
SUN_AZIMUTH = math.radians(-78.0)   # from the middle of the image, to the right positive
SUN_RADIUS = math.radians(7.0)
SUN_EDGE = math.radians(3.0)        # half the width of its soft edge
SUN_LUX = 62_000.0                  # on a plane across its rays
SUN_XY = (0.345, 0.353)
GROUND_XY, GROUND_REFLECTANCE = (0.335, 0.345), 0.22

TILE, TILES = 0.25, 16              # metres, and tiles a side
FLOOR = 400.0


def perez(coefficients, theta, gamma):
    """The distribution of Perez et al.: theta from the zenith, gamma from the sun, radians."""
    a, b, c, d, e = coefficients
    # At the horizon the first exponent tends to minus infinity (b is negative).
    gradation = 1 + a * math.exp(b / max(math.cos(theta), 1e-4))
    return gradation * (1 + c * math.exp(d * gamma) + e * math.cos(gamma) ** 2)


class Sky:
    """Preetham's sky: luminance in nit and chromaticity x, y of a direction."""

    def __init__(self, turbidity, sun_theta):
        t, s = turbidity, sun_theta
        self.sun_theta = s
        self.shapes = (
            (0.1787 * t - 1.4630, -0.3554 * t + 0.4275, -0.0227 * t + 5.3251, 0.1206 * t - 2.5771, -0.0670 * t + 0.3703),
            (-0.0193 * t - 0.2592, -0.0665 * t + 0.0008, -0.0004 * t + 0.2125, -0.0641 * t - 0.8989, -0.0033 * t + 0.0452),
            (-0.0167 * t - 0.2608, -0.0950 * t + 0.0092, -0.0079 * t + 0.2102, -0.0441 * t - 1.6537, -0.0109 * t + 0.0529),
        )
        chi = (4 / 9 - t / 120) * (math.pi - 2 * s)
        zenith_luminance = 1000 * ((4.0453 * t - 4.9710) * math.tan(chi) - 0.2155 * t + 2.4192)
        zenith_x = (
            t * t * (0.00166 * s**3 - 0.00375 * s**2 + 0.00209 * s)
            + t * (-0.02903 * s**3 + 0.06377 * s**2 - 0.03202 * s + 0.00394)
            + (0.11693 * s**3 - 0.21196 * s**2 + 0.06052 * s + 0.25886)
        )
        zenith_y = (
            t * t * (0.00275 * s**3 - 0.00610 * s**2 + 0.00317 * s)
            + t * (-0.04214 * s**3 + 0.08970 * s**2 - 0.04153 * s + 0.00516)
            + (0.15346 * s**3 - 0.26756 * s**2 + 0.06670 * s + 0.26688)
        )
        self.scales = tuple(
            zenith / perez(shape, 0.0, s) for zenith, shape in zip((zenith_luminance, zenith_x, zenith_y), self.shapes)
        )

    def luminance_xy(self, theta, gamma):
        """Luminance and chromaticity `theta` from the zenith and `gamma` from the sun."""
        return tuple(scale * perez(shape, theta, gamma) for scale, shape in zip(self.scales, self.shapes))


def linear_srgb(luminance, x, y):
    """Linear sRGB with white of luminance 1 at (1, 1, 1)."""
    big_x, big_y, big_z = luminance * x / y, luminance, luminance * (1 - x - y) / y
    return (
        3.2404542 * big_x - 1.5371385 * big_y - 0.4985314 * big_z,
        -0.9692660 * big_x + 1.8760108 * big_y + 0.0415560 * big_z,
        0.0556434 * big_x - 0.2040259 * big_y + 1.0572252 * big_z,
    )


def direction(column, row):
    """Unit vector of a pixel's centre: the top row is +Y, the middle of the image looks along -Z."""
    theta, phi = math.pi * (row + 0.5) / HEIGHT, 2 * math.pi * ((column + 0.5) / WIDTH - 0.5)
    return math.sin(theta) * math.sin(phi), math.cos(theta), -math.sin(theta) * math.cos(phi)


def smooth_step(t):
    """0 below 0, 1 above 1, smooth in between."""
    t = min(max(t, 0.0), 1.0)
    return t * t * (3 - 2 * t)


def sky_picture():
    """Rows of linear sRGB in units of 1000 nit."""
    sky = Sky(TURBIDITY, math.pi / 2 - SUN_ELEVATION)
    sun = (
        math.cos(SUN_ELEVATION) * math.sin(SUN_AZIMUTH),
        math.sin(SUN_ELEVATION),
        -math.cos(SUN_ELEVATION) * math.cos(SUN_AZIMUTH),
    )
    angles = [
        [math.acos(max(-1.0, min(1.0, sum(a * b for a, b in zip(direction(i, j), sun))))) for i in range(WIDTH)]
        for j in range(HEIGHT)
    ]

    def disk(gamma):
        return 1 - smooth_step((gamma - SUN_RADIUS + SUN_EDGE) / (2 * SUN_EDGE))

    def solid_angle(row):
        edges = [math.cos(math.pi * (row + k) / HEIGHT) for k in (0, 1)]
        return 2 * math.pi / WIDTH * (edges[0] - edges[1])

    # The disk's luminance follows from its illuminance as sampled by the pixels.
    sun_integral = sum(
        disk(gamma) * math.cos(gamma) * solid_angle(j) for j, row in enumerate(angles) for gamma in row
    )
    sun_luminance = SUN_LUX / sun_integral

    rows, sky_lux = [], 0.0
    for j in range(HEIGHT // 2):
        row = []
        for i in range(WIDTH):
            _, up, _ = direction(i, j)
            gamma = angles[j][i]
            luminance, x, y = sky.luminance_xy(math.acos(up), gamma)
            sky_lux += luminance * up * solid_angle(j)
            rgb = linear_srgb(luminance / 1000, x, y)
            extra = linear_srgb(sun_luminance * disk(gamma) / 1000, *SUN_XY)
            row.append(tuple(max(0.0, a + b) for a, b in zip(rgb, extra)))
        rows.append(row)
    # What lies below the horizon, beyond the floor: plain ground in the same light.
    ground_lux = sky_lux + SUN_LUX * math.sin(SUN_ELEVATION)
    ground = linear_srgb(GROUND_REFLECTANCE * ground_lux / math.pi / 1000, *GROUND_XY)
    rows += [[ground] * WIDTH for _ in range(HEIGHT // 2)]
    print(f"sky {sky_lux:.0f} lux on the ground, with the sun {ground_lux:.0f} lux; disk {sun_luminance:.3g} nit")
    return rows


def write_hdr(path, rows):
    """Radiance's RGBE image with run lengths (G. Ward, "Real Pixels", Graphics Gems II, 1991)."""
    data = bytearray(b"#?RADIANCE\n# A clear sky, written by make.py; 1.0 is white of 1000 nit\nFORMAT=32-bit_rle_rgbe\n\n")
    data += f"-Y {len(rows)} +X {len(rows[0])}\n".encode()
    for row in rows:
        pixels = [rgbe(pixel) for pixel in row]
        data += bytes((2, 2, len(row) >> 8, len(row) & 255))
        for channel in zip(*pixels):
            data += run_lengths(channel)
    path.write_bytes(data)


def rgbe(pixel):
    """Three mantissas and their common exponent e: the bytes m stand for m · 2^(e - 136)."""
    largest = max(pixel)
    if largest < 1e-32:
        return 0, 0, 0, 0
    exponent = math.frexp(largest)[1]
    scale = 256.0 / 2.0**exponent
    return (*(min(255, round(value * scale)) for value in pixel), exponent + 128)


def run_lengths(values):
    """One channel of a scan line: runs of 3 to 127 equal bytes as (128 + n, byte), others as (n, bytes)."""
    out, literal, i = bytearray(), bytearray(), 0
    while i < len(values):
        n = 1
        while i + n < len(values) and n < 127 and values[i + n] == values[i]:
            n += 1
        if n < 3:
            literal += bytes(values[i : i + n])
        if literal and (n >= 3 or len(literal) > 125 or i + n == len(values)):
            out.append(len(literal))
            out += literal
            literal.clear()
        if n >= 3:
            out += bytes((128 + n, values[i]))
        i += n
    return out


def floor(file):
    """Square tiles in two shades around the origin, plain ground up to the horizon around them."""
    light, dark = ([], []), ([], [])

    def quad(part, x0, x1, z0, z1):
        positions, triangles = part
        first = len(positions)
        positions.extend([(x0, 0, z1), (x1, 0, z1), (x1, 0, z0), (x0, 0, z0)])
        triangles.extend([(first, first + 1, first + 2), (first, first + 2, first + 3)])

    half = TILE * TILES / 2
    for i in range(TILES):
        for j in range(TILES):
            x, z = i * TILE - half, j * TILE - half
            quad(light if (i + j) % 2 else dark, x, x + TILE, z, z + TILE)
    plain = ([], [])
    quad(plain, -FLOOR, FLOOR, -FLOOR, -half)
    quad(plain, -FLOOR, FLOOR, half, FLOOR)
    quad(plain, -FLOOR, -half, -half, half)
    quad(plain, half, FLOOR, -half, half)
    for name, (positions, triangles) in (("tile-light", light), ("tile-dark", dark), ("ground", plain)):
        file.shape(name, positions, None, triangles)
        file.place(name, name, name)


def main():
    file = GltfFile()
    # RGB stand-ins; capture.toml names the metals and the glass.
    file.material("gold", (1.0, 0.77, 0.34), metallic=1.0, roughness=0.2)
    file.material("copper", (0.95, 0.64, 0.54), metallic=1.0, roughness=0.2)
    file.material("glass", (1.0, 1.0, 1.0), roughness=0.0)
    file.material("plastic", (0.55, 0.02, 0.03), roughness=0.25)
    file.material("tile-light", (0.55, 0.53, 0.49))
    file.material("tile-dark", (0.20, 0.20, 0.21))
    file.material("ground", (0.24, 0.22, 0.19))
    positions, triangles = sphere(24)
    file.shape("ball", positions, positions, triangles)
    for name, radius, x, z in (
        ("gold", 0.30, -0.80, -0.05),
        ("copper", 0.30, -0.18, -0.55),
        ("glass", 0.25, 0.16, 0.42),
        ("plastic", 0.27, 0.76, -0.12),
    ):
        file.place(name, "ball", name, (x, radius, z), radius)
    floor(file)
    file.write(HERE / "balls.gltf")
    write_hdr(HERE / "sky.hdr", sky_picture())


if __name__ == "__main__":
    main()
