#!/usr/bin/env python3
"""Times renders that stop in each pixel once light's noise is low enough beside the sensor's, against renders of as many
samples everywhere as 99 % of those pixels have at most.

    cargo build --release
    python3 benches/noise_target.py            # half an hour on two cores: little noise takes many samples

The scene is scenes/depth-of-field at the lowest gain, in few large pixels, exposed so that the brightest disc of a lamp
fills two fifths of the full well. Noise of light and of the sensor together is √(1 + r²) times that of the sensor, with r
the ratio of both in the whole image (`render.noise_ratio`); a target of 0.14 makes that 1 % more. Times are processor
times. Of the even render a part of the samples is traced: its time is so many times longer, and its noise is so many times
smaller in square, as samples are traced one like the other; the fifth of a second that reading and building take counts
among them. The table is Markdown.
"""

import argparse
import statistics
import tempfile
from pathlib import Path

from comparison import command
from comparison.environment import ROOT, enter

CAPTURE = ROOT / "scenes" / "depth-of-field" / "capture.toml"
# One in sixteen pixels a side, sixteen times as large, and an eighth of the exposure.
SENSOR = ["sensor.resolution_px=[50, 32]", "sensor.pixel_pitch_um=[96, 96]", "exposure.time_s=5e-6"]


def arguments():
    parser = argparse.ArgumentParser(description="Time renders that stop pixel by pixel.")
    parser.add_argument("--photosite", type=Path, default=ROOT / "target" / "release" / "photosite", metavar="FILE")
    parser.add_argument("--target", type=float, default=0.14, help="noise of light over that of the sensor (default: %(default)s)")
    parser.add_argument("--part", type=int, default=64, metavar="N", help="one in so many samples of the even render is traced (default: %(default)s)")
    parser.add_argument("--runs", type=int, default=1, help="renders of each kind (default: %(default)s)")
    return parser.parse_args()


def total_noise(report, part=1):
    """Noise of light and sensor over that of the sensor, for so many times the samples of the report."""
    return (1 + report["render"]["noise_ratio"] ** 2 / part) ** 0.5


def main():
    options = arguments()
    enter()
    import numpy as np

    times, noises, paths = {"noise target": [], "even": []}, {"noise target": [], "even": []}, {}
    with tempfile.TemporaryDirectory() as folder:
        def render(name, seed, part, *keys):
            report, busy = command.render(options.photosite, CAPTURE, folder, seed, [*SENSOR, *keys])
            times[name].append(part * busy)
            noises[name].append(total_noise(report, part))
            paths[name] = part * report["paths"]

        for run in range(options.runs):
            render("noise target", run, 1, f"render.noise_target={options.target}", "render.samples_per_pixel=100000000")
            samples = np.percentile(np.load(Path(folder) / "samples.npy"), 99)
            render("even", run, options.part, f"render.samples_per_pixel={round(samples / options.part)}")
    print(f"Noise target {options.target}, runs: {options.runs}; of the even render one in {options.part} samples\n")
    print("| | paths, millions | processor seconds | total noise over the sensor's |")
    print("|---|---|---|---|")
    for name in times:
        print(f"| {name} | {paths[name] / 1e6:.1f} | {statistics.median(times[name]):.1f} | {statistics.median(noises[name]):.4f} |")
    quotients = [a / b for a, b in zip(times["noise target"], times["even"], strict=True)]
    noise = statistics.median(noises["noise target"]) / statistics.median(noises["even"])
    median = statistics.median(quotients)
    spread = f" ({min(quotients):.2f}–{max(quotients):.2f})" if len(quotients) > 1 else ""
    verdict = "reached" if median < 1 / 3 and noise < 1.01 else "**not reached**"
    print(f"\nGoal, the same total noise within 1 % in at most a third of the time: {noise - 1:+.2%} in {median:.2f}{spread} "
          f"of the time, {verdict}.")


if __name__ == "__main__":
    main()
