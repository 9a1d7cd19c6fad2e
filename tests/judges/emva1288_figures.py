#!/usr/bin/env python3
"""Lets the EMVA 1288 tool recover what was put into a sensor, from the image sets of `photosite emva1288`.

    emva1288_figures.py FOLDER [REPORT.json]
    emva1288_figures.py --without-times PHOTOSITE FOLDER
    emva1288_figures.py --twin FOLDER FOLDER

FOLDER holds emva1288.json and the sets of each channel, as TIFF, PNG or DNG (read by LibRaw). REPORT.json is what
`photosite emva1288-report FOLDER --json` printed: its figures must be the tool's to numerical precision. Exit status 0
where all is well, 1 otherwise.

With --without-times the first channel's set is evaluated as public ones are given whose exposure times nobody noted: every
time is 0 and one dark pair stands for all. PHOTOSITE, the program, and the tool must find the same.

With --twin the second folder has the set of a twin of the first folder's sensor, which photosite fit has found in its
images: what the tool finds in both must be equal within 2 %.

Every figure is printed with its deviation from what was put in, the limit, and the standard error that the number of
pixels and images leaves. A limit below four standard errors is an error too: no camera could keep it.

What the tool does otherwise than its users may think:
- it knows two images as a pair and more as a stack, one exposure time for both stacks, and wants a bright and a dark
  pair at every exposure time;
- saturation is the exposure of the largest temporal variance: up to one step, and a few standard deviations of the
  pixels, below the capacity. The tool searches for it from the bright end and stops at the first point above its two
  darker neighbours. Beyond saturation the variance is that of the few pixels whose read noise is still below the last
  code, some 1e-3 DN^2 in any order, and there the search can end: a sensor of 32378 e- was found to have 35548, the
  exposure of the last step. So it is told the point, as it has an option for;
- sigma_d is that of no exposure time: the offset of the dark variances over exposure time, less 1/12 DN^2;
- the absolute sensitivity threshold is taken as sigma_y.dark/K + 1/2, an approximation of
  sqrt((sigma_y.dark/K)^2 + 1/4) + 1/2;
- it tells dark currents, but no doubling temperature: that is fitted here to its dark currents.

Needs: pip install -r requirements-emva1288.txt.
"""

import json
import logging
import subprocess
import sys
import warnings
from pathlib import Path

import numpy
import rawpy
from emva1288.process.data import Data1288
from emva1288.process.loader import LoadImageData
from emva1288.process.parser import ParseEmvaDescriptorFile
from emva1288.process.results import Results1288
from emva1288.process.routines import load_image

# Percent of what was put in.
LIMITS = {
    "K": 0.5,
    "QE": 0.5,
    "sigma_d": 2.0,
    "DSNU": 1.5,
    "PRNU": 1.0,
    "dark current, mean": 1.0,
    "dark current, variance": 3.0,
    "doubling temperature": 2.0,
    "QE at a wavelength": 1.0,
}
# Percent of the original's figure.
TWIN_LIMIT = 2.0
# Percent of the signal.
LINEARITY_LIMIT = 0.05
# The tool fits by an iteration that ends at relative steps of 1.5e-8.
PRECISION = 1e-6


def load(name):
    if Path(name).suffix == ".dng":
        with rawpy.imread(str(name)) as raw:
            return raw.raw_image_visible.copy()
    return load_image(name)


def load_set(path, spatial=None):
    """What the tool makes of a descriptor; of sets without stacks, together with the stacks of another."""
    images = ParseEmvaDescriptorFile(str(path), loglevel=logging.ERROR).images
    data = LoadImageData(images, fload=load, loglevel=logging.ERROR).data
    if spatial is not None:
        data["spatial"] = spatial
    moments = Data1288(data, loglevel=logging.ERROR).data
    saturation = int(numpy.argmax(moments["temporal"]["s2_y"]))
    return data, Results1288(moments, index_u_ysat=saturation, loglevel=logging.ERROR)


class Judge:
    def __init__(self):
        self.complaints = []

    def figure(self, name, limit, put_in, found, standard_error):
        """Compares a figure; the standard error is relative."""
        deviation = 100 * (found / put_in - 1)
        error = 100 * standard_error
        print(f"  {name:28} {put_in:12.6g} {found:12.6g} {deviation:+8.3f} % of {limit:4} %  (standard error {error:.3f} %)")
        if not abs(deviation) <= limit:
            self.complaints.append(f"{name}: {found} instead of {put_in}, {deviation:+.3f} % off")
        if 4 * error > limit:
            self.complaints.append(f"{name}: a limit of {limit} % is out of reach of a standard error of {error:.3f} %")

    def same(self, name, tool, ours):
        if tool is None or numpy.isnan(tool):
            agree = ours is None
        else:
            agree = ours is not None and abs(ours - tool) <= PRECISION * max(abs(tool), 1e-3)
        if not agree:
            self.complaints.append(f"{name}: {ours} by photosite, {tool} by the tool")


def standard_errors(result, pixels):
    """Relative standard errors of the figures, from the moments of normal noise: a variance of n differences has a
    standard error of its sqrt(2/n), a mean of two images one of sigma/sqrt(2 n)."""
    t = result.temporal
    last = result.index_sensitivity_max + 1
    signal = (t["u_y"] - t["u_ydark"])[:last]
    of_difference = 2 / pixels * (t["s2_y"] ** 2 + t["s2_ydark"] ** 2)[:last]
    gain = numpy.sqrt(numpy.sum(signal**2 * of_difference)) / numpy.sum(signal**2) / result.K

    # Weights of the points in slope and offset of a line.
    time = t["texp"] * 1e-9
    spread = time - time.mean()
    slope = spread / numpy.sum(spread**2)
    offset = 1 / len(time) - time.mean() * slope
    dark = t["s2_ydark"]
    variance_error = numpy.sqrt(2 / pixels) * dark
    mean_error = numpy.sqrt(dark / (2 * pixels))
    of_dark_noise = numpy.sqrt(numpy.sum((offset * variance_error) ** 2)) / (2 * (result.sigma_y_dark**2 - 1 / 12))
    of_mean = numpy.sqrt(numpy.sum((slope * mean_error) ** 2)) / abs(numpy.sum(slope * t["u_ydark"]))
    of_variance = numpy.sqrt(numpy.sum((slope * variance_error) ** 2)) / abs(numpy.sum(slope * dark))

    # A pattern's own spread over the image, and the temporal noise that averaging leaves of it; rows and columns are few.
    def spatial(measured, row, column):
        parts = [measured / numpy.sqrt(pixels), row / numpy.sqrt(result.spatial["M"]), column / numpy.sqrt(result.spatial["N"])]
        return numpy.sqrt(2) * numpy.linalg.norm(parts)

    of_stack = [
        spatial(result.s_2_y_measured_dark, result.s_2_y_row_dark, result.s_2_y_col_dark),
        spatial(result.s_2_y_measured, result.s_2_y_row, result.s_2_y_col),
    ]
    of_dsnu = of_stack[0] / (2 * result.s_2_y_dark)
    of_prnu = numpy.hypot(*of_stack) / (2 * (result.s_2_y - result.s_2_y_dark))
    return {
        "K": gain,
        "QE": gain,
        "sigma_d": numpy.hypot(of_dark_noise, gain),
        "DSNU": numpy.hypot(of_dsnu, gain),
        "PRNU": of_prnu,
        "dark current, mean": numpy.hypot(of_mean, gain),
        "dark current, variance": numpy.hypot(of_variance, 2 * gain),
    }


def linearity(judge, result, pixels):
    """The largest deviation of points whose means have these standard errors is about three of the largest of them."""
    t = result.temporal
    signal = t["u_y"] - t["u_ydark"]
    inside = slice(result.index_linearity_min, result.index_linearity_max + 1)
    error = numpy.sqrt((t["s2_y"] + t["s2_ydark"]) / (2 * pixels)) / signal
    expected = 300 * error[inside].max()
    print(f"  linearity error              {result.LE_min:+.4f} to {result.LE_max:+.4f} % of {LINEARITY_LIMIT} %  (noise: about {expected:.4f} %)")
    if max(-result.LE_min, result.LE_max) > LINEARITY_LIMIT:
        judge.complaints.append(f"linearity error {result.LE_min} to {result.LE_max} %")
    if expected > LINEARITY_LIMIT:
        judge.complaints.append(f"noise alone makes linearity errors of {expected} %")


def compare_measured(judge, result, measured):
    for name, tool, ours in [
        ("K", result.K, measured["system_gain_dn_per_e"]),
        ("R", result.R, measured["responsivity_dn_per_p"]),
        ("QE", result.QE / 100, measured["quantum_efficiency"]),
        ("sigma_d", result.sigma_d, measured["dark_noise_e"]),
        ("sigma_y.dark", result.sigma_y_dark, measured["dark_noise_dn"]),
        ("saturation, e", result.u_e_sat, measured["saturation_e"]),
        ("saturation, p", result.u_p_sat, measured["saturation_p"]),
        ("SNR", result.SNR_max, measured["snr_max"]),
        ("DSNU", result.DSNU1288, measured["dsnu_e"]["total"]),
        ("DSNU of rows", result.DSNU1288_row, measured["dsnu_e"]["row"]),
        ("DSNU of columns", result.DSNU1288_col, measured["dsnu_e"]["column"]),
        ("DSNU of pixels", result.DSNU1288_pixel, measured["dsnu_e"]["pixel"]),
        ("PRNU", result.PRNU1288, measured["prnu_percent"]["total"]),
        ("PRNU of rows", result.PRNU1288_row, measured["prnu_percent"]["row"]),
        ("PRNU of columns", result.PRNU1288_col, measured["prnu_percent"]["column"]),
        ("PRNU of pixels", result.PRNU1288_pixel, measured["prnu_percent"]["pixel"]),
        ("smallest linearity error", result.LE_min, measured["linearity_error_min_percent"]),
        ("largest linearity error", result.LE_max, measured["linearity_error_max_percent"]),
        ("dark current, mean", result.u_I_mean, measured["dark_current_mean_e_per_s"]),
        ("dark current, variance", result.u_I_var, measured["dark_current_variance_e_per_s"]),
    ]:
        judge.same(name, tool, ours)
    # The exact threshold from the tool's noise.
    noise = result.sigma_y_dark / result.K
    judge.same("threshold", numpy.sqrt(noise**2 + 0.25) + 0.5, measured["sensitivity_threshold_e"])


def saturation(judge, result, put_in):
    """Between the capacity and where the highest of the pixels' distributions touches it, less a step."""
    capacity = put_in["saturation_p"]
    spread = numpy.hypot(1 / put_in["snr_max"], (put_in["prnu_percent"]["total"] or 0) / 100)
    step = result.temporal["u_p"][0]
    lowest = capacity * (1 - 4 * spread) - step
    print(f"  saturation capacity          {put_in['saturation_e']:12.6g} {result.u_e_sat:12.6g}  (at least {lowest / capacity * put_in['saturation_e']:.6g})")
    if not lowest <= result.u_p_sat <= capacity + step:
        judge.complaints.append(f"saturation capacity {result.u_p_sat} photons instead of {capacity}")


def judge_channel(judge, folder, channel, report):
    put_in = channel["expected"]
    data, result = load_set(folder / channel["descriptor"])
    pixels = data["width"] * data["height"]
    errors = standard_errors(result, pixels)
    found = {
        "K": (put_in["system_gain_dn_per_e"], result.K),
        "QE": (put_in["quantum_efficiency"], result.QE / 100),
        "sigma_d": (put_in["dark_noise_e"], result.sigma_d),
        "DSNU": (put_in["dsnu_e"]["total"], result.DSNU1288),
        "PRNU": (put_in["prnu_percent"]["total"], result.PRNU1288),
        "dark current, mean": (put_in["dark_current_mean_e_per_s"], result.u_I_mean),
        "dark current, variance": (put_in["dark_current_variance_e_per_s"], result.u_I_var),
    }
    for name, (expected, value) in found.items():
        judge.figure(name, LIMITS[name], expected, value, errors[name])
    linearity(judge, result, pixels)
    saturation(judge, result, put_in)
    if report:
        compare_measured(judge, result, report["measured"])

    worst = 0.0
    for i, point in enumerate(channel["wavelengths"]):
        if point["descriptor"] is None:
            continue
        _, of_wavelength = load_set(folder / point["descriptor"], data["spatial"])
        efficiency = of_wavelength.R / result.K
        deviation = 100 * (efficiency / point["quantum_efficiency"] - 1)
        worst = max(worst, deviation, key=abs)
        if not abs(deviation) <= LIMITS["QE at a wavelength"]:
            judge.complaints.append(f"QE at {point['wavelength_nm']} nm: {deviation:+.3f} % off")
        if report:
            judge.same(f"QE at {point['wavelength_nm']} nm", efficiency, report["wavelengths"][i]["measured"])
    if channel["wavelengths"]:
        print(f"  QE at {len(channel['wavelengths'])} wavelengths: at most {worst:+.3f} % off of {LIMITS['QE at a wavelength']} %")
        if 400 * errors["K"] > LIMITS["QE at a wavelength"]:
            judge.complaints.append("the standard error of K leaves no quantum efficiency within its limit")

    currents = []
    for i, point in enumerate(channel["temperatures"]):
        _, of_temperature = load_set(folder / point["descriptor"], data["spatial"])
        current = of_temperature.u_I_mean_DN / result.K
        currents.append((point["temperature_c"], current))
        at = f"dark current at {point['temperature_c']:g} C"
        its_errors = standard_errors(of_temperature, pixels)
        judge.figure(at, LIMITS["dark current, mean"], point["dark_current_e_per_s"], current, its_errors["dark current, mean"])
        if report:
            judge.same(at, current, report["temperatures"][i]["from_mean"])
    if len(currents) > 1:
        temperatures, values = numpy.array(currents).T
        slope = numpy.polyfit(temperatures, numpy.log2(values), 1)[0]
        spread = numpy.sqrt(numpy.sum((temperatures - temperatures.mean()) ** 2))
        # The error of K is common to all currents and does not change their ratios.
        error = its_errors["dark current, mean"] / numpy.log(2) / spread / abs(slope)
        judge.figure("doubling temperature", LIMITS["doubling temperature"], channel["doubling_temperature_k"], 1 / slope, error)
        if report:
            judge.same("doubling temperature", 1 / slope, report["doubling_temperature_k"][1])


def without_times(text):
    """A descriptor whose times are 0, with the first of its dark pairs, and its lines ended as Windows does."""
    series = []
    for line in text.splitlines():
        if line[0] in "bd":
            series.append([line])
        elif line[0] == "i":
            series[-1].append(line)
    lines = [line for line in text.splitlines() if line[0] in "vn"]
    has_dark_pair = False
    for head, *images in series:
        kind, _, *photons = head.split()
        is_dark_pair = kind == "d" and len(images) == 2
        if not (is_dark_pair and has_dark_pair):
            lines += [" ".join([kind, "000.00", *photons]), *images]
        has_dark_pair |= is_dark_pair
    return "# exposure times: not noted\r\n\r\n" + "\r\n".join(lines) + "\r\n"


def judge_without_times(judge, photosite, folder):
    channel = json.loads((folder / "emva1288.json").read_text())["channels"][0]
    path = (folder / channel["descriptor"]).with_name("without-times.txt")
    path.write_text(without_times((folder / channel["descriptor"]).read_text()), newline="")
    command = [photosite, "emva1288-report", path, "-o", path.with_suffix(".html"), "--force", "--json"]
    report = json.loads(subprocess.run(command, capture_output=True, text=True, check=True).stdout)[0]
    _, result = load_set(path)
    compare_measured(judge, result, report["measured"])
    print(f"without times: K {result.K:.6g}, QE {result.QE:.4g} %, sigma_d {result.sigma_d:.4g} e-, by both")
    missing = [entry["figure"] for entry in report["not_measured"]]
    if "dark current" not in missing or report["measured"]["dark_current_mean_e_per_s"] is not None:
        judge.complaints.append(f"without times: not measured are {missing}")


def judge_twin(judge, original, twin):
    """Each figure is a sample of its set: a limit below four standard errors of the difference is no limit."""
    results, errors = [], []
    for folder in (original, twin):
        [channel] = json.loads((folder / "emva1288.json").read_text())["channels"]
        data, result = load_set(folder / channel["descriptor"])
        results.append(result)
        errors.append(standard_errors(result, data["width"] * data["height"]))
    for name, found in {
        "K": lambda r: r.K,
        "QE": lambda r: r.QE,
        "sigma_d": lambda r: r.sigma_d,
        "DSNU": lambda r: r.DSNU1288,
        "PRNU": lambda r: r.PRNU1288,
        "dark current, mean": lambda r: r.u_I_mean,
        "dark current, variance": lambda r: r.u_I_var,
    }.items():
        of_difference = numpy.hypot(*[error[name] for error in errors])
        judge.figure(name, TWIN_LIMIT, found(results[0]), found(results[1]), of_difference)
    for name, found in {
        "sigma_y.dark": lambda r: r.sigma_y_dark,
        "saturation, e": lambda r: r.u_e_sat,
        "saturation, p": lambda r: r.u_p_sat,
        "threshold": lambda r: r.u_p_min,
        "SNR": lambda r: r.SNR_max,
        "dynamic range": lambda r: r.DR,
    }.items():
        judge.figure(name, TWIN_LIMIT, found(results[0]), found(results[1]), 0.0)


def main():
    # Parts of a pattern that are not there have negative variances now and then.
    warnings.simplefilter("ignore", RuntimeWarning)
    if sys.argv[1:2] == ["--without-times"] and len(sys.argv) == 4:
        judge = Judge()
        judge_without_times(judge, sys.argv[2], Path(sys.argv[3]))
        for complaint in judge.complaints:
            print(complaint, file=sys.stderr)
        sys.exit(1 if judge.complaints else 0)
    if sys.argv[1:2] == ["--twin"] and len(sys.argv) == 4:
        judge = Judge()
        judge_twin(judge, Path(sys.argv[2]), Path(sys.argv[3]))
        for complaint in judge.complaints:
            print(complaint, file=sys.stderr)
        sys.exit(1 if judge.complaints else 0)
    if len(sys.argv) not in (2, 3):
        sys.exit(__doc__)
    folder = Path(sys.argv[1])
    contents = json.loads((folder / "emva1288.json").read_text())
    report = json.loads(Path(sys.argv[2]).read_text()) if len(sys.argv) == 3 else None
    judge = Judge()
    for i, channel in enumerate(contents["channels"]):
        print(f"{contents['sensor']}, channel {channel['channel']} at {channel['wavelength_nm']:g} nm:")
        judge_channel(judge, folder, channel, report and report[i])
    for complaint in judge.complaints:
        print(complaint, file=sys.stderr)
    sys.exit(1 if judge.complaints else 0)


if __name__ == "__main__":
    main()
