"""From the pixels to numbers: bandwidth, samples, levels, gain and curve."""

import json
import math

import cv2
import numpy
from rows.sensor import DOTS, centroids, dots
from table import Figure, Row

FLAT, BALL = "sensor-flat.toml", "sensor-ball.toml"
#: The mean electrons of each pixel, beside its number.
ELECTRONS = ['output.noise=["photo_electrons_e"]', 'output.noise_formats=["npy"]']


def bandwidth(tool):
    """Autocovariance along rows of an image of even light, whose noise a narrow line has passed."""
    bandwidth_mhz, clock_mhz = 2, 14.75
    settings = [f"sensor.video.bandwidth_mhz={bandwidth_mhz}", f"sensor.video.pixel_clock_mhz={clock_mhz}"]
    # Little light, whose shot noise is far above what is left of the noise of rendering.
    settings += ["render.samples_per_pixel=64", "exposure.time_s=0.0001"]
    raw = numpy.load(tool.render(FLAT, "narrow", *settings) / "raw.npy").astype(float)[:, 20:]
    noise = raw - raw.mean()
    covariance = lambda dx, dy: float((noise[: noise.shape[0] - dy, : noise.shape[1] - dx] * noise[dy:, dx:]).mean())
    variance = covariance(0, 0)
    a = math.exp(-2 * math.pi * bandwidth_mhz / clock_mhz)
    # Bartlett: ρ of N numbers of which (1 + a²)/(1 − a²) count as one; 5 σ.
    tolerance = 5 * math.sqrt((1 + a * a) / (1 - a * a) / noise.size)
    plot([covariance(k, 0) / variance for k in range(13)], [a**k for k in range(13)], tool.picture("bandwidth.png"))
    figures = [Figure(f"ρ({k})", covariance(k, 0) / variance, a**k, tolerance) for k in (1, 2, 3, 5)]
    figures.append(Figure("ρ of neighbours in a column", covariance(0, 1) / variance, 0, tolerance))
    wide = numpy.load(tool.render(FLAT, "wide", *settings[2:]) / "raw.npy").astype(float)
    # Both variances are known to √(2/N), the narrow one of fewer independent numbers.
    ratio = variance / wide.var()
    figures.append(Figure("variance over that of a wide line", float(ratio), (1 - a) / (1 + a), 2.5 * tolerance * (1 - a) / (1 + a)))
    return figures


def plot(measured, expected, path):
    """ρ(k): bars as measured, dots as expected."""
    picture = numpy.full((220, 360, 3), 255, numpy.uint8)
    place = lambda k, rho: (25 + 26 * k, int(195 - 170 * rho))
    cv2.line(picture, (10, 195), (350, 195), (120, 120, 120), 1, cv2.LINE_AA)
    for k, (bar, dot) in enumerate(zip(measured, expected)):
        cv2.rectangle(picture, (place(k, 0)[0] - 8, place(k, bar)[1]), (place(k, 0)[0] + 8, 195), (200, 160, 90), -1)
        cv2.circle(picture, place(k, dot), 4, (40, 40, 200), -1, cv2.LINE_AA)
        cv2.putText(picture, str(k), (place(k, 0)[0] - 4, 212), cv2.FONT_HERSHEY_SIMPLEX, 0.35, (60, 60, 60), 1, cv2.LINE_AA)
    cv2.imwrite(str(path), picture)


def sampling(tool):
    """Focal lengths in samples, fitted to the centres of the dots."""
    size, figures = (192, 81), []
    for interpolation in ["linear", "nearest"]:
        settings = f'sensor.frame_grabber={{ size_px = {list(size)}, interpolation = "{interpolation}" }}'
        folder = tool.render(DOTS, interpolation, settings, "develop.square_pixels=false")
        raw = numpy.load(folder / "raw.npy").astype(float)
        points, pixels = dots(folder)
        s = (size[0] / 128, size[1] / 108)
        row, column = numpy.indices(raw.shape)
        near = (pixels + 0.5) * s - 0.5
        found = centroids(raw, near, (column, row), (9 * s[0], 9 * s[1]))
        fits = [numpy.polyfit(points[:, axis] / points[:, 2], found[:, axis], 1) for axis in (0, 1)]
        # o_x, o_y and f/s_x, f/s_y of the lecture, with the size of a sample on the sensor for s.
        told = json.loads((folder / "capture.json").read_text())
        if interpolation == "linear":
            pitch_mm = [um / 1e3 for um in told["sensor"]["pixel_pitch_um"]]
            for axis, name in enumerate("xy"):
                figures.append(Figure(f"f/s_{name}, samples", float(fits[axis][0]), 6 / pitch_mm[axis], 0.3))
                figures.append(Figure(f"o_{name}, samples", float(fits[axis][1]), (size[axis] - 1) / 2, 0.05))
            camera = numpy.array(told["image"]["camera_matrix"])
            figures.append(Figure("f_x of capture.json", float(camera[0, 0]), 300 * s[0], 1e-6))
            figures.append(Figure("aspect of a sample", float(told["image"]["pixel_aspect"]), s[1] / s[0], 1e-9))
            cv2.imwrite(str(tool.picture("frame-grabber.png")), cv2.imread(str(folder / "image.png")))
        else:
            figures.append(Figure("f/s_x of samples that are held", float(fits[0][0]), 300 * s[0], 1.5))
    return figures


def quantisation(tool):
    """Mean square error of the numbers of a ball whose brightness takes all values, each counted alike."""
    figures, pictures = [], []
    for bits in (8, 6, 3, 1):
        folder = tool.render(BALL, f"bits-{bits}", f"sensor.adc.bits={bits}", "sensor.charge.full_well_e=1e9", "exposure.time_s=0.005", *ELECTRONS)
        raw = numpy.load(folder / "raw.npy").astype(float)
        told = json.loads((folder / "capture.json").read_text())
        # One number is so many electrons.
        step = 1 / told["sensor"]["system_gain_dn_per_e"]
        electrons = numpy.load(folder / "noise-photo_electrons_e.npy").astype(float)
        within = (electrons > 0) & (electrons < step * (2**bits - 1))
        # The middle of the ball is beyond white. Half a step at black, whole ones up to half of the last; of two levels both
        # halves. Each step is cut into as many bins.
        error, part = (raw * step - electrons)[within], electrons[within] / step
        last = math.floor(part.max() + 0.5) - 0.5 if bits > 1 else 1.0
        bins = 20 * max(1, round(2 * last))
        index = (part / last * bins).astype(int)
        of_bins = [(error[index == i] ** 2).mean() for i in range(bins) if (index == i).any()]
        # A bin that is h wide has its mean square to h²/12 of it and less.
        figures.append(Figure(f"{2**bits} levels: error², steps²", float(numpy.mean(of_bins) / step**2), 1 / 12, 0.02 / 12))
        assert told["sensor"]["bits"] == bits
        pictures.append(cv2.imread(str(folder / "image.png"))[::2, ::2])
    cv2.imwrite(str(tool.picture("quantisation.png")), numpy.hstack(pictures))
    return figures


def gain_control(tool):
    """Gains of a series that begins 16 dB too dark."""
    attack = 0.3
    control = f"exposure.gain_control={{ target = 0.5, attack = {attack}, limits_db = [0, 36] }}"
    settings = [control, "exposure.frames=16", "sensor.adc.gain_db_range=[0, 40]", "exposure.time_s=0.0008"]
    folder = tool.render(FLAT, "agc", *settings, "render.samples_per_pixel=64")
    gains = numpy.array(json.loads((folder / "capture.json").read_text())["exposure"]["frame_gains_db"])
    missing = gains[-1] - gains
    fit = numpy.polyfit(numpy.arange(10), numpy.log(missing[:10] / missing[0]), 1)
    # What is left after 15 frames, 0.7^15 = 0.5 % of the error, bends the last points by 10 %.
    level = numpy.load(folder / "raw-0015.npy").astype(float)
    told = json.loads((folder / "capture.json").read_text())["sensor"]
    reached = (level.mean() - told["black_level_dn"]) / (told["white_level_dn"] - told["black_level_dn"])
    return [
        Figure("error of the second image over the first's", float(missing[1] / missing[0]), 1 - attack, 0.005),
        Figure("time constant of the attack, images", float(-1 / fit[0]), -1 / math.log(1 - attack), 0.12),
        Figure("mean of the last image", float(reached), 0.5, 0.01),
    ]


def gamma(tool):
    """The slope of the numbers over the electrons in a plot of logarithms, and what development makes of them."""
    figures, pictures = [], []
    for value in (0.4, 1, 2.2, 5):
        settings = [f"sensor.video.gamma={value}", 'output.raw=["npy", "dng"]', "sensor.charge.full_well_e=1e9", *ELECTRONS]
        folder = tool.render(BALL, f"gamma-{value}", *settings)
        raw = numpy.load(folder / "raw.npy").astype(float)
        electrons = numpy.load(folder / "noise-photo_electrons_e.npy").astype(float)
        seen = (raw > 300) & (electrons > 0)
        slope = numpy.polyfit(numpy.log(electrons[seen]), numpy.log(raw[seen]), 1)[0]
        # Numbers above 300 are good to 1/600.
        figures.append(Figure(f"slope for γ = {value}", float(slope), value, 0.003 * max(1, value)))
        pictures.append(cv2.imread(str(folder / "image.png"))[::2, ::2])
    # The table of the raw file straightens them: all look alike but where few numbers are left.
    difference = numpy.abs(pictures[0].astype(float) - pictures[1])
    figures.append(Figure("developed, γ = 0.4 beside 1: largest difference, of 255", float(difference.max()), 0, 2))
    return figures


ROWS = [
    Row("Bandwidth of the video line", "ρ(k) = exp(−2π·k·f_c/f_p)", FLAT, bandwidth, "bandwidth.png"),
    Row("Samples that are not the pixels", "x = (o_x − x_im)·s_x;  f_x = f/s_x", DOTS, sampling, "frame-grabber.png"),
    Row("Amplitude quantisation", "⟨e²⟩ = q²/12,  q = R/(L − 1)", BALL, quantisation, "quantisation.png"),
    Row("Automatic gain control", "error of image n: (1 − attack)ⁿ, dB", FLAT, gain_control),
    Row("Sensor curve", "i = g^γ·(b + n)^γ", BALL, gamma),
]
