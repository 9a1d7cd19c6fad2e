#!/usr/bin/env python3
"""Renders scenes on a graphics card and on the processor, and compares speed and images; a few minutes, one table.

    cargo build --release --features gpu
    python3 benches/gpu.py                       # scenes a, b and c of benches/comparison, on the first card
    python3 benches/gpu.py --mitsuba             # beside Mitsuba 3 on the same card (cuda_ad_spectral)
    python3 benches/gpu.py --device gpu:0 --samples 16 --size 64 a     # on Mesa's software, to try the script

Paths per second are those of light transport, `trace_s`, of the fastest of the runs. On a card that has the scene's tables and
compiled kernels in it, which a render of one sample shows: that is taken off, and stands in a column of its own. "means" is the
largest difference between the means of a channel on both devices, "spread" the root mean square of the differences of pixels over
their standard deviations (`photosite compare`), both with independent numbers of other seeds, so that 1 is what
noise alone gives. "same" says whether two
runs on the card give the same bytes.

A second table has the exposures of a sensor of 24 megapixels, by photosite expose: milliseconds of each frame after the first, with the
way back of its numbers, and of one development, on the card with the time that its kernels take to compile.
"""

import argparse
import importlib.util
import json
import struct
import subprocess
import sys
import tempfile
from pathlib import Path

from comparison.environment import ROOT, enter


def arguments():
    parser = argparse.ArgumentParser(description="Compare graphics cards with the processor.")
    parser.add_argument("scenes", nargs="*", default=["a", "b", "c"], metavar="SCENE", help="of benches/comparison (default: a b c)")
    parser.add_argument("--photosite", type=Path, default=ROOT / "target" / "release" / "photosite", metavar="FILE")
    parser.add_argument("--device", default="gpu", help="one of `photosite devices` (default: the first card)")
    parser.add_argument("--runs", type=int, default=3, help="measured renders of each (default: %(default)s)")
    parser.add_argument("--samples", type=int, default=1024, help="samples per pixel on the card (default: %(default)s)")
    parser.add_argument("--of-cpu", type=int, default=64, help="samples per pixel on the processor (default: %(default)s)")
    parser.add_argument("--size", type=int, default=512, help="pixels along each side (default: %(default)s)")
    parser.add_argument("--megapixels", type=float, default=24, help="of the sensor that is exposed (default: %(default)s)")
    parser.add_argument("--mitsuba", action="store_true", help="beside Mitsuba's cuda_ad_spectral, independent sampler")
    return parser.parse_args()


class Program:
    """The program on a device, into folders of its own."""

    def __init__(self, options, capture, folder, device):
        self.options, self.capture, self.folder, self.device = options, capture, folder / device.replace(":", "-"), device

    def render(self, name, samples, seed, sampler="sobol"):
        """Seconds of light transport, and the folder."""
        from comparison import command

        out = self.folder / name
        keys = [f"render.samples_per_pixel={samples}", 'render.strategy="plain"', f'render.sampler="{sampler}"']
        report, _ = command.render(self.options.photosite, self.capture, out, seed, keys, "--device", self.device)
        return report["timings"]["trace_s"], out

    def rate(self, name, samples):
        """Paths per second of the fastest run, seconds before the first path, and the folders of the runs."""
        begin = min(self.render(f"{name}-begin", 1, 1)[0] for _ in range(2))
        runs = [self.render(f"{name}-{run}", samples, 1) for run in range(self.options.runs)]
        seconds = min(seconds for seconds, _ in runs)
        return self.options.size**2 * (samples - 1) / max(seconds - begin, 1e-9), begin, [out for _, out in runs]


def compared(options, a, b):
    """Largest relative difference of means, and the largest spread of z."""
    files = [str(folder / "electrons.exr") for folder in (a, b)]
    done = subprocess.run([str(options.photosite), "compare", *files, "--json"], stdout=subprocess.PIPE, check=False)
    channels = json.loads(done.stdout)["channels"]
    means = max(abs(channel["mean_b"] / channel["mean_a"] - 1) for channel in channels)
    return means, max(channel["z_scores"]["spread"] for channel in channels)


def of_mitsuba(options, capture, folder):
    """Paths per second of Mitsuba on the same card."""
    import mitsuba
    from comparison.mitsuba_renderer import Mitsuba

    mitsuba.set_variant("cuda_ad_spectral")
    renderer = Mitsuba(mitsuba, options.photosite, capture, folder, "independent", None)
    renderer.warm_up(options.samples)
    seconds = min(renderer.render(options.samples, run)[1][0] for run in range(options.runs))
    return options.size**2 * options.samples / seconds


def exposed(options, folder, device):
    """Milliseconds of a frame after the first, and of one development, of a sensor that light falls on evenly from the left to the right."""
    ramp = folder / "ramp.pgm"
    rows = round((options.megapixels * 1e6 / 1.5) ** 0.5)
    columns = 3 * rows // 2
    row = b"".join(struct.pack(">H", 65535 * i // columns) for i in range(columns))
    ramp.write_bytes(f"P5 {columns} {rows} 65535\n".encode() + rows * row)
    timings = []
    for frames in (1, 9):
        out = folder / f"exposed-{device.replace(':', '-')}-{frames}"
        sets = ["exposure.time_s=0.01", f"exposure.frames={frames}", "output.raw=[]", "output.electrons=false"]
        words = [str(options.photosite), "expose", str(ramp), "--unit", "electrons", "--one", "20000", "--linear", "--quiet", "--device", device]
        words += ["-o", str(out), *(word for key in sets for word in ("--set", key))]
        subprocess.run(words, check=True, stderr=subprocess.DEVNULL)
        timings.append(json.loads((out / "capture.json").read_text())["timings"])
    return 1e3 * (timings[1]["expose_s"] - timings[0]["expose_s"]) / 8, 1e3 * timings[1]["develop_s"]


def main():
    options = arguments()
    if not options.photosite.is_file():
        sys.exit(f"{options.photosite} is missing: run cargo build --release --features gpu first")
    # Scenes are written with NumPy, which comes with the environment of the other comparisons
    if options.mitsuba or importlib.util.find_spec("numpy") is None:
        enter()
    from comparison import scenes

    print(subprocess.run([str(options.photosite), "devices"], stdout=subprocess.PIPE, text=True, check=True).stdout)
    print(f"`{options.device}`, {options.size} × {options.size} pixels, {options.samples} samples on the card, {options.of_cpu} on the processor\n")
    theirs = " Mitsuba, M/s | ratio |" if options.mitsuba else ""
    print(f"| scene | card, M paths/s | begins in, s | processor, M/s | ratio |{theirs} means | spread | same |")
    print("|---|---|---|---|---|" + ("---|---|" if theirs else "") + "---|---|---|")
    with tempfile.TemporaryDirectory() as temporary:
        for key in options.scenes:
            folder = Path(temporary) / key
            capture = scenes.SCENES[key][1]().write(folder, False, options.size)
            card, cpu = (Program(options, capture, folder, device) for device in (options.device, "cpu"))
            rate, begin, runs = card.rate("card", options.samples)
            of_cpu, _, _ = cpu.rate("cpu", options.of_cpu)
            # Other random numbers on either: the difference is that of noise
            pair = [program.render("pair", options.of_cpu, seed, "independent")[1] for seed, program in ((2, card), (3, cpu))]
            means, spread = compared(options, *pair)
            same = len({(out / "electrons.exr").read_bytes() for out in runs}) == 1
            row = [key, f"{rate / 1e6:.2f}", f"{begin:.2f}", f"{of_cpu / 1e6:.2f}", f"{rate / of_cpu:.2f}"]
            if options.mitsuba:
                other = of_mitsuba(options, capture, folder)
                row += [f"{other / 1e6:.1f}", f"{rate / other:.2f}"]
            row += [f"{100 * means:.3f} %", f"{spread:.3f}", "yes" if same else "NO"]
            print("| " + " | ".join(row) + " |", flush=True)
        print(f"\n| {options.megapixels:g} megapixels | a frame, ms | development, ms |\n|---|---|---|")
        for device in (options.device, "cpu"):
            frame, development = exposed(options, Path(temporary), device)
            print(f"| {device} | {frame:.0f} | {development:.0f} |", flush=True)


if __name__ == "__main__":
    main()
