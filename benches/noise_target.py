#!/usr/bin/env python3
"""Times renders that stop in each pixel once light's noise is low enough beside the sensor's, against renders of as many
samples everywhere as 99 % of those pixels have got.

    cargo build --release
    python3 benches/noise_target.py            # long: what is compared has as many samples everywhere as the worst pixels

The scene is scenes/depth-of-field at half its resolution, at the lowest gain. Both renders alternate. Noise of light
and of the sensor together is √(1 + r²) times that of the sensor, with r the ratio of both in the whole picture
(`render.noise_ratio`); a target of 0.14 makes that 1 % more. Times are those of light transport. The table is Markdown.
"""

import argparse
import statistics
import tempfile
from pathlib import Path

from comparison import command
from comparison.environment import ROOT, enter

CAPTURE = ROOT / "scenes" / "depth-of-field" / "capture.toml"
# Half the pixels a side, twice as large.
SIZE = ["sensor.resolution_px=[400, 260]", "sensor.pixel_pitch_um=[12, 12]"]


def arguments():
    parser = argparse.ArgumentParser(description="Time renders that stop pixel by pixel.")
    parser.add_argument("--photosite", type=Path, default=ROOT / "target" / "release" / "photosite", metavar="FILE")
    parser.add_argument("--target", type=float, default=0.14, help="noise of light over that of the sensor (default: %(default)s)")
    parser.add_argument("--runs", type=int, default=3, help="renders of each kind (default: %(default)s)")
    return parser.parse_args()


def total_noise(report):
    """Noise of light and sensor over that of the sensor."""
    return (1 + report["render"]["noise_ratio"] ** 2) ** 0.5


def main():
    options = arguments()
    enter()
    import numpy as np

    times, noises, paths = {"noise target": [], "even": []}, {"noise target": [], "even": []}, {}
    with tempfile.TemporaryDirectory() as folder:
        def render(seed, *keys):
            return command.render(options.photosite, CAPTURE, folder, seed, [*SIZE, *keys])

        for run in range(options.runs):
            stopping = render(run, f"render.noise_target={options.target}", "render.samples_per_pixel=1000000")
            samples = int(np.percentile(np.load(Path(folder) / "samples.npy"), 99))
            even = render(run, f"render.samples_per_pixel={samples}")
            for name, report in (("noise target", stopping), ("even", even)):
                times[name].append(report["timings"]["trace_s"])
                noises[name].append(total_noise(report))
                paths[name] = report["paths"]
    print(f"Noise target {options.target}, {options.runs} runs\n")
    print("| | paths, millions | seconds | total noise over the sensor's |")
    print("|---|---|---|---|")
    for name in times:
        print(f"| {name} | {paths[name] / 1e6:.1f} | {statistics.median(times[name]):.1f} | {statistics.median(noises[name]):.4f} |")
    quotients = [a / b for a, b in zip(times["noise target"], times["even"], strict=True)]
    noise = statistics.median(noises["noise target"]) / statistics.median(noises["even"])
    median = statistics.median(quotients)
    verdict = "reached" if median < 1 / 3 and noise < 1.01 else "**not reached**"
    print(f"\nGoal, the same total noise within 1 % in at most a third of the time: {noise - 1:+.2%} in {median:.2f} "
          f"({min(quotients):.2f}–{max(quotients):.2f}) of the time, {verdict}.")


if __name__ == "__main__":
    main()
