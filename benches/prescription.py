#!/usr/bin/env python3
"""Times renders through the glass of a prescription against those through a thin lens of the same focal length and f-number.

    cargo build --release
    python3 benches/prescription.py            # some minutes on two cores

Two scenes, the Cornell box and scenes/depth-of-field, each from where it fills a sensor of full frame or less. Both lenses are
focused on the same plane and have the same pixels behind them. Noise is that of single pixels, each channel divided by its
mean: for images a and b of two seeds

    relMSE = mean over pixels and channels of ½·(a − b)² / (m² + 0.01),   m = (a + b)/2

Time to equal noise is relMSE times processor time, which for a render is that of the whole command less that of one sample a
pixel. Runs of both lenses alternate. Two more tables follow: how long it takes until the first ray can be drawn through a
lens, with a round stop and with blades, and what `render.light_paths` gains through the glass. All are Markdown.
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


# What `startup` and `light_paths` render.
BARRELS = ["canon-rf24", "canon-ef50", "canon-ef85"]
BLADES = 7
CAUSTICS = ("canon-ef50", 2.8, 5.9)


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


def tools():
    """What reads an image, and the relMSE of two of them."""
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

    return electrons, relmse


def startup(options):
    """Processor seconds until the first ray is drawn: of a render of one sample a pixel, less those through a thin lens."""
    capture = ROOT / "scenes" / "three-lenses" / "capture.toml"
    print("\nProcessor seconds before the first ray of scenes/three-lenses at f/4, beyond those of a thin lens; the least of "
          f"{options.runs} runs\n")
    print(f"| lens | round stop | {BLADES} blades |\n|---|---|---|")
    keys = ["lens.f_number=4", "render.samples_per_pixel=1"]
    with tempfile.TemporaryDirectory() as folder:

        def seconds(*more):
            one = lambda: command.render(options.photosite, capture, folder, 1, [*more, *keys])[1]
            return min(one() for _ in range(options.runs))

        thin = seconds("lens.type=thin", "lens.focal_length_mm=51", "lens.blades=0")
        for lens in BARRELS:
            row = [seconds(f"lens.prescription={lens}", f"lens.blades={blades}") - thin for blades in (0, BLADES)]
            print(f"| {lens} | {row[0]:.2f} | {row[1]:.2f} |", flush=True)


def light_paths(options):
    """The time to equal noise with paths from lamps over that without, through glass: a room with a ball of glass and one of
    gold under a small lamp."""
    from comparison import scenes

    electrons, relmse = tools()
    lens, f_number, distance_m = CAUSTICS
    keys = [
        f"lens.prescription={lens}", f"lens.f_number={f_number}", f"lens.focus_distance_m={distance_m}",
        f"camera.position_m=[0, 0, {distance_m}]", "sensor.resolution_px=[128, 128]", "sensor.pixel_pitch_um=[187.5, 187.5]",
        "exposure.time_s=1e-6",
    ]
    print(f"\nA room with balls of glass and gold through {lens} at f/{f_number}, with paths from lamps and without, "
          f"{options.samples} samples a pixel\n")
    print("| render.light_paths | processor s | relMSE | time to equal noise |\n|---|---|---|---|")
    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder)
        capture = scenes.glass_and_gold().write(folder / "scene")
        products = {}
        for paths in (0, 1):

            def render(seed, samples, paths=paths):
                more = [*keys, f"render.light_paths={paths}", f"render.samples_per_pixel={samples}"]
                busy = command.render(options.photosite, capture, folder / "out", seed, more)[1]
                return busy, electrons(folder / "out")

            overhead = render(0, 1)[0]
            runs = [render(1 + run, options.samples) for run in range(options.runs)]
            busy = statistics.median(run[0] for run in runs) - overhead
            noise = statistics.mean(relmse(a[1], b[1]) for a, b in zip(runs[::2], runs[1::2]))
            products[paths] = busy * noise
            print(f"| {paths} | {busy:.1f} | {noise:.4f} | {products[paths] / products[0]:.2f} |", flush=True)


def main():
    options = arguments()
    enter()
    electrons, relmse = tools()
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
    startup(options)
    light_paths(options)
    print(f"\nGoal, at most 1.5 times the time to equal noise: {'reached' if reached else '**not reached**'}.")
    return 0 if reached else 1


if __name__ == "__main__":
    sys.exit(main())
