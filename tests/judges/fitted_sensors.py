#!/usr/bin/env python3
"""Fits sensors to image sets that were made of known ones, and counts how often the truth lies within two stated errors.

    fitted_sensors.py PHOTOSITE [--seeds N] [--size PX]

For each of N seeds (40 by default) and three sensors (a CMOS sensor with noise of rows and columns, a CCD with hot pixels and a response that bends,
a CMOS sensor of unequal, heavy-tailed pixels at 12 dB) `photosite emva1288` takes a set with another serial number and
`photosite fit` reads it. Every parameter that the fit tells is compared with what the images were made of. Exit status 0
where

- the truth lies within two standard errors in 95.45 % of all cases, give or take four standard deviations of that count;
- no case lies beyond six;
- K and the quantum efficiency lie within 1 %, dark noise within 2 %, DSNU and PRNU of pixels within 3 %;
- what is left out with a bound lies below it, but for one case in twenty and four standard deviations.
"""

import argparse
import json
import math
import re
import subprocess
import sys
import tempfile
from collections import defaultdict
from pathlib import Path

GAIN_DB = 12
# Arguments of the set, and the keys that it is made with; what a key is at 12 dB is the product with its factor.
SENSORS = {
    "CMOS with columns": (
        "sony-imx249-mono",
        [],
        {
            "adc.conversion_gain_dn_per_e": 0.1245,
            "adc.black_level_dn": 64,
            "noise.read_noise_e": 6.3,
            "noise.row_noise_e": 1.5,
            "noise.column_noise_e": 0.6,
            "noise.dark_current_e_per_s": 0.4,
            "noise.dark_current_nonuniformity_percent": 30.0,
            "noise.dsnu_e": 1.5,
            "noise.dsnu_row_e": 0.6,
            "noise.dsnu_column_e": 0.8,
            "noise.prnu_percent": 0.6,
            "noise.prnu_row_percent": 0.2,
            "noise.prnu_column_percent": 0.3,
        },
    ),
    "CCD": (
        "textbook-ccd",
        # Charge that is left behind ties pixels to their neighbours, which the fit has no figure for.
        ["ccd.vertical_cti=0", "ccd.horizontal_cti=0", "noise.dark_current_reference_c=25"],
        {
            "adc.conversion_gain_dn_per_e": 0.43,
            "adc.black_level_dn": 500,
            "noise.read_noise_e": 10.0,
            "noise.dark_current_e_per_s": 10.0,
            "noise.dsnu_e": 3.0,
            "noise.prnu_percent": 1.0,
            "charge.full_well_e": 120000.0,
            "adc.amplifier_nonlinearity_percent": -2.0,
            "quantum_efficiency": 0.65,
            "defects.hot_per_million": 2000.0,
            "defects.hot_dark_current_e_per_s": 400.0,
            "defects.dead_per_million": 500.0,
        },
    ),
    "CMOS at 12 dB": (
        "sony-imx250-mono",
        [],
        {
            "adc.conversion_gain_dn_per_e": 0.366,
            "adc.black_level_dn": 100,
            "noise.read_noise_e": 2.2,
            "noise.read_noise_spread_percent": 30.0,
            "noise.read_noise_degrees_of_freedom": 6.0,
            "noise.row_noise_e": 0.3,
            "noise.dsnu_e": 0.9,
            "noise.dsnu_column_e": 0.5,
            "noise.prnu_percent": 0.5,
            "noise.prnu_column_percent": 0.2,
        },
    ),
}
# Percent of the truth.
LIMITS = {
    "adc.conversion_gain_dn_per_e": 1.0,
    "quantum_efficiency": 1.0,
    "noise.read_noise_e": 2.0,
    "noise.dsnu_e": 3.0,
    "noise.prnu_percent": 3.0,
}
BOUND = re.compile(r"not told apart from 0: below (\S+)")
FIGURES = {
    "noise.row_noise_e": "row noise",
    "noise.column_noise_e": "column noise",
    "noise.dsnu_e": "DSNU of pixels",
    "noise.dsnu_row_e": "DSNU of rows",
    "noise.dsnu_column_e": "DSNU of columns",
    "noise.prnu_row_percent": "PRNU of rows",
    "noise.prnu_column_percent": "PRNU of columns",
    "noise.dark_current_nonuniformity_percent": "dark current non-uniformity",
}


def fit(photosite, name, seed, size, folder):
    preset, more, truth = SENSORS[name]
    # Sensors of one serial number have patterns in common: none is used twice.
    serial = 1000 * (1 + list(SENSORS).index(name)) + seed
    # A bend has a list of terms.
    stated = {key: [value] if "nonlinearity" in key else value for key, value in truth.items()}
    changes = [f"{key}={value}" for key, value in stated.items() if key != "quantum_efficiency"] + more + [f"serial={serial}"]
    gain = ["--gain-db", str(GAIN_DB)] if "dB" in name else []
    sets = [word for change in changes for word in ("--set", change)]
    run = [photosite, "emva1288", preset, "--quiet", "-o", f"{folder}/set", "--force", "--size", f"{size}x{size}"]
    subprocess.run([*run, "--seed", str(seed), *gain, *sets], check=True)
    run = [photosite, "fit", f"{folder}/set", "-o", f"{folder}/sensor.toml", "--force", "--json"]
    report = json.loads(subprocess.run(run, check=True, capture_output=True).stdout)
    expected = json.loads(Path(f"{folder}/set/emva1288.json").read_text())["channels"][0]["expected"]
    # What the standard finds where a response bends is not the sensor's own.
    truth = {"quantum_efficiency": expected["quantum_efficiency"], **truth}
    if gain:
        truth["adc.conversion_gain_dn_per_e"] *= 10 ** (GAIN_DB / 20)
    return truth, report


def main():
    arguments = argparse.ArgumentParser(description="Fits sensors to sets that were made of known ones.")
    arguments.add_argument("photosite")
    arguments.add_argument("--seeds", type=int, default=40)
    arguments.add_argument("--size", type=int, default=256)
    arguments = arguments.parse_args()
    complaints, counts, bounds = [], [0, 0], [0, 0]
    for name in SENSORS:
        found = defaultdict(list)
        left_out = defaultdict(int)
        for seed in range(arguments.seeds):
            with tempfile.TemporaryDirectory() as folder:
                truth, report = fit(arguments.photosite, name, seed, arguments.size, folder)
            told = {p["key"]: p for p in report["parameters"]}
            reasons = {n["figure"]: n["reason"] for n in report["left_out"]}
            for key, value in truth.items():
                if key in told:
                    found[key].append((told[key]["value"], told[key]["standard_error"], value))
                else:
                    left_out[key] += 1
                bound = BOUND.search(reasons.get(FIGURES.get(key, ""), ""))
                if bound:
                    bounds[0] += 1
                    bounds[1] += value > float(bound[1])
        print(f"{name}, {arguments.seeds} seeds:")
        print(f"  {'parameter':42} {'truth':>10} {'mean':>10} {'error':>9} {'spread':>9}  in 2 s  worst")
        for key in truth:
            cases = found[key]
            if not cases:
                print(f"  {key:42} {truth[key]:10.6g} left out in all")
                if key in LIMITS:
                    complaints.append(f"{name}: {key} was left out")
                continue
            z = [(value - true) / error for value, error, true in cases]
            inside = sum(abs(score) <= 2 for score in z)
            counts[0] += len(z)
            counts[1] += inside
            mean = sum(value for value, _, _ in cases) / len(cases)
            spread = math.sqrt(sum((value - mean) ** 2 for value, _, _ in cases) / max(len(cases) - 1, 1))
            error = sum(error for _, error, _ in cases) / len(cases)
            worst = max(z, key=abs)
            note = f"  left out {left_out[key]} times" if left_out[key] else ""
            print(
                f"  {key:42} {truth[key]:10.6g} {mean:10.6g} {error:9.2g} {spread:9.2g}  {inside:3}/{len(z):<3} {worst:+.1f}{note}"
            )
            if abs(worst) > 6:
                complaints.append(f"{name}: {key} lies {worst:+.1f} standard errors off")
            off = max(100 * abs(value / true - 1) for value, _, true in cases)
            if off > LIMITS.get(key, math.inf):
                complaints.append(f"{name}: {key} is {off:.2f} % off")
    total, inside = counts
    expected = 0.9545
    slack = 4 * math.sqrt(expected * (1 - expected) / total)
    print(f"within two standard errors: {inside} of {total}, {100 * inside / total:.1f} % (95.4 ± {100 * slack:.1f})")
    if abs(inside / total - expected) > slack:
        complaints.append(f"{100 * inside / total:.1f} % within two standard errors")
    if bounds[0]:
        most = 0.05 * bounds[0] + 4 * math.sqrt(0.05 * 0.95 * bounds[0])
        print(f"bounds at 95 %: {bounds[1]} of {bounds[0]} do not hold")
        if bounds[1] > most:
            complaints.append(f"{bounds[1]} of {bounds[0]} bounds do not hold")
    for complaint in complaints:
        print(f"error: {complaint}", file=sys.stderr)
    return bool(complaints)


if __name__ == "__main__":
    sys.exit(main())
