#!/usr/bin/env python3
"""Times renders through the glass of a prescription against those through a thin lens of the same focal length and f-number.

    cargo build --release
    python3 benches/prescription.py            # some minutes on two cores

Two scenes, the Cornell box and scenes/depth-of-field, each from where it fills a sensor of full frame or less. Both lenses are
focused on the same plane and have the same pixels behind them. Noise is that of single pixels, each channel divided by its
mean: for pictures a and b of two seeds

    relMSE = mean over pixels and channels of ½·(a − b)² / (m² + 0.01),   m = (a + b)/2

Time to equal noise is relMSE times processor time, which for a render is that of the whole command less that of one sample a
pixel. Runs of both lenses alternate. The table is Markdown.
"""

import argparse
import statistics
import sys
import tempfile
from pathlib import Path

from comparison import command
from comparison.environment import ROOT, enter

# Camera and sensor of each scene; the distance of the plane in focus from the entrance pupil, m.
SCENES = {
    "Cornell box": (
        "cornell-box",
        0.9,
        ["camera.position_m=[0.278, 0.273, -1.0]", "sensor.resolution_px=[192, 192]", "sensor.pixel_pitch_um=[125, 125]"],
    ),
    "depth of field": (
        "depth-of-field",
        0.3,
        ["sensor.resolution_px=[240, 156]", "sensor.pixel_pitch_um=[95, 95]"],
    ),
}
# Focal length, mm, and f-number of lenses that ship.
LENSES = {"canon-ef50": (51.2, 1.8), "double-gauss": (99.5, 2.0)}
# The wider one for both scenes, the longer one for the box.
CASES = [("Cornell box", "canon-ef50"), ("depth of field", "canon-ef50"), ("Cornell box", "double-gauss")]


def arguments():
    parser = argparse.ArgumentParser(description="Time renders through a prescription.")
    parser.add_argument("--photosite", type=Path, default=ROOT / "target" / "release" / "photosite", metavar="FILE")
    parser.add_argument("--samples", type=int, default=64, help="a pixel (default: %(default)s)")
    parser.add_argument("--runs", type=int, default=4, help="of each lens, an even number (default: %(default)s)")
    return parser.parse_args()


def lens_tables(name, distance_m):
    """The two tables of a lens, by what they are called here."""
    focal_length_mm, f_number = LENSES[name]
    thin = f"focal_length_mm = {focal_length_mm}\nf_number = {f_number}\nfocus_distance_m = {distance_m}\n"
    # Focus counts from the sensor, about one focal length and its extension behind the pupil.
    extension_m = 1 / (1e3 / focal_length_mm - 1 / distance_m)
    traced = f'prescription = "{name}"\nf_number = {f_number}\nfocus_distance_m = {distance_m + extension_m:.4f}\n'
    return {"thin": thin, "prescription": traced}


def with_lens(capture, table):
    """A capture file with another lens table, beside the first since paths are relative to it."""
    head, rest = capture.read_text(encoding="utf-8").split("[lens]\n")
    after = rest[rest.index("[sensor]") :]
    return f"{head}[lens]\n{table}\n{after}"


def main():
    options = arguments()
    enter()
    import mitsuba
    import numpy as np

    mitsuba.set_variant("scalar_rgb")

    def electrons(folder):
        bitmap = mitsuba.Bitmap(str(folder / "electrons.exr"))
        names = [field.name for field in bitmap.struct_()]
        pixels = np.array(bitmap, dtype=np.float64).reshape(bitmap.height(), bitmap.width(), -1)
        return np.stack([pixels[..., names.index(channel)] for channel in "RGB"], axis=-1)

    def relmse(a, b):
        a, b = (picture / picture.mean(axis=(0, 1)) for picture in (a, b))
        return float(np.mean(0.5 * (a - b) ** 2 / ((0.5 * (a + b)) ** 2 + 0.01)))

    reached = True
    print(f"{options.samples} samples per pixel, {options.runs} runs of each\n")
    print("| scene | lens | Mpaths/s a core, thin | prescription | time of a path | relMSE, thin | prescription | noise of a path | time to equal noise |")
    print("|---|---|---|---|---|---|---|---|---|")
    for scene, lens in CASES:
        name, distance_m, keys = SCENES[scene]
        source = ROOT / "scenes" / name / "capture.toml"
        pictures, times, paths = {}, {}, 0
        with tempfile.TemporaryDirectory() as folder:
            folder = Path(folder)
            for file in source.parent.iterdir():
                (folder / file.name).symlink_to(file)
            captures = {}
            for kind, table in lens_tables(lens, distance_m).items():
                captures[kind] = folder / f"{kind}.toml"
                captures[kind].write_text(with_lens(source, table), encoding="utf-8")
                pictures[kind], times[kind] = [], []

            def render(kind, seed, samples):
                more = [*keys, "exposure.time_s=1e-6", f"render.samples_per_pixel={samples}"]
                return command.render(options.photosite, captures[kind], folder / kind, seed, more)

            overhead = {kind: min(render(kind, 0, 1)[1] for _ in range(2)) for kind in captures}
            for run in range(options.runs):
                for kind in captures:
                    report, busy = render(kind, 1 + run, options.samples)
                    paths = report["paths"]
                    times[kind].append(busy - overhead[kind])
                    pictures[kind].append(electrons(folder / kind))
        seconds = {kind: statistics.median(times[kind]) for kind in times}
        noise = {kind: statistics.mean(map(relmse, of_kind[::2], of_kind[1::2])) for kind, of_kind in pictures.items()}
        time, error = (of["prescription"] / of["thin"] for of in (seconds, noise))
        reached = reached and time * error <= 1.5
        rates = [f"{paths / seconds[kind] / 1e6:.2f}" for kind in ("thin", "prescription")]
        print(f"| {scene} | {lens} | {rates[0]} | {rates[1]} | {time:.2f} | {noise['thin']:.5f} | {noise['prescription']:.5f} "
              f"| {error:.2f} | {time * error:.2f} |", flush=True)
    print(f"\nGoal, at most 1.5 times the time to equal noise: {'reached' if reached else '**not reached**'}.")
    return 0 if reached else 1


if __name__ == "__main__":
    sys.exit(main())
