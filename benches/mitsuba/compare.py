#!/usr/bin/env python3
"""Renders the Cornell box in Mitsuba 3 and in photosite on the same cores, and compares speed and error.

    pip install -r benches/mitsuba/requirements.txt      # and LLVM 17 or later, Debian: apt install libllvm19
    cargo build --release
    python benches/mitsuba/compare.py

Both programs get the same triangles, measured spectra, camera, depth, roulette and sensor: 256 × 256 pixels, box filter,
64 samples a pixel, spectral, in the response functions of photosite's sensor, so that both estimate the same three numbers
a pixel, electrons. Mitsuba gets the capture from `photosite export-mitsuba`, which tests/mitsuba holds against scenes
written by hand. Runs of the two alternate. Mitsuba is warm: one render before the
measurement pays for tracing and compiling its kernels. Times are those of light transport alone: photosite's `trace_s`,
Mitsuba's time in `render`. Loading, sensor and files are left out on both sides.

Definitions, for a picture x and a reference r of the same program (many samples, another seed), each channel divided by
the reference's mean in that channel:

    relMSE     = mean over pixels and channels of (x − r)² / (r² + 0.01)
    efficiency = 1 / (relMSE · seconds), the reciprocal of the time to a relMSE of 1 with independent samples

The reference's own noise adds samples/reference samples to the relMSE of independent samples, 1.6 % as it stands. relMSE
says nothing about bias that picture and reference share; therefore the two references are compared with each other too.
"""

import argparse
import glob
import json
import os
import statistics
import subprocess
import sys
import tempfile
import time
import tomllib
from pathlib import Path

import numpy as np

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]
CAPTURE = HERE / "cornell-box.toml"
EPSILON = 0.01


def arguments():
    parser = argparse.ArgumentParser(description="Compare photosite with Mitsuba 3 on the Cornell box.")
    parser.add_argument("--photosite", type=Path, default=ROOT / "target" / "release" / "photosite", metavar="FILE")
    parser.add_argument("--runs", type=int, default=5, help="measured renders of each program (default: %(default)s)")
    parser.add_argument("--samples", type=int, default=64, help="samples a pixel (default: %(default)s)")
    parser.add_argument("--reference", type=int, default=4096, help="samples of the references (default: %(default)s)")
    parser.add_argument("--roulette-depth", type=int, default=5, help="of both programs (default: %(default)s)")
    parser.add_argument("--threads", type=int, help="of both programs (default: all cores)")
    parser.add_argument("--variant", default="llvm_ad_spectral", help="of Mitsuba (default: %(default)s)")
    parser.add_argument("--mitsuba-only", action="store_true", help="leave photosite out")
    parser.add_argument("--json", type=Path, metavar="FILE", help="write the figures here as well")
    return parser.parse_args()


# Mitsuba.


class Mitsuba:
    """The scene in Mitsuba 3."""

    def __init__(self, options, folder):
        # Mitsuba finds LLVM when its backend starts, by this variable or the loader's default names.
        if "llvm" in options.variant and "DRJIT_LIBLLVM_PATH" not in os.environ:
            found = sorted(glob.glob("/usr/lib/*/libLLVM.so.19*") + glob.glob("/usr/lib/llvm-19/lib/libLLVM*.so*"))
            if found:
                os.environ["DRJIT_LIBLLVM_PATH"] = found[0]
        import drjit
        import mitsuba

        if options.variant not in mitsuba.variants():
            sys.exit(f"Mitsuba has no variant {options.variant}; it has {', '.join(mitsuba.variants())}")
        mitsuba.set_variant(options.variant)
        self.drjit = drjit
        if options.threads:
            drjit.set_thread_count(options.threads)
            mitsuba.Thread.set_thread_count(options.threads)
        self.mitsuba = mitsuba
        self.name = f"Mitsuba {mitsuba.__version__} {options.variant}"
        out = folder / "mitsuba"
        command = [options.photosite, "export-mitsuba", CAPTURE, "-o", out, "--quiet"]
        command += ["--set", f"render.roulette_depth={options.roulette_depth}"]
        if subprocess.run([str(word) for word in command], check=False).returncode:
            sys.exit("photosite cannot export the capture")
        self.scene = mitsuba.load_file(str(out / "scene.xml"))

    def render(self, samples, seed):
        """A picture and the seconds it took."""
        start = time.perf_counter()
        picture = self.mitsuba.render(self.scene, spp=samples, seed=seed)
        self.drjit.eval(picture)
        self.drjit.sync_thread()
        seconds = time.perf_counter() - start
        return np.array(picture, dtype=np.float64), seconds

    def reference(self, samples):
        """A picture of many samples, in parts that fit into memory."""
        part = 256
        parts = max(1, samples // part)
        return sum(self.render(part, 1_000_000 + i)[0] for i in range(parts)) / parts


# photosite.


class Photosite:
    """The scene in photosite, through its command."""

    def __init__(self, options, sampler, folder):
        self.options, self.sampler, self.folder = options, sampler, folder
        self.name = f"photosite, {sampler}"

    def render(self, samples, seed):
        """A picture, electrons a pixel and channel without noise, and the seconds that light transport took."""
        command = [
            self.options.photosite, "render", CAPTURE, "-o", self.folder, "--force", "--json", "--quiet", "--seed", str(seed),
            "--set", f"render.samples_per_pixel={samples}",
            "--set", f"render.sampler=\"{self.sampler}\"",
            "--set", f"render.roulette_depth={self.options.roulette_depth}",
        ]
        if self.options.threads:
            command += ["--threads", str(self.options.threads)]
        done = subprocess.run([str(word) for word in command], stdout=subprocess.PIPE, stdin=subprocess.DEVNULL, check=False)
        if done.returncode != 0:
            sys.exit(f"photosite failed with status {done.returncode}")
        seconds = json.loads(done.stdout)["timings"]["trace_s"]
        return self._read(self.folder / "electrons.exr"), seconds

    def reference(self, samples):
        """A picture of many samples."""
        return self.render(samples, 1_000_000)[0]

    @staticmethod
    def _read(path):
        import mitsuba

        bitmap = mitsuba.Bitmap(str(path))
        names = [field.name for field in bitmap.struct_()]
        pixels = np.array(bitmap, dtype=np.float64).reshape(bitmap.height(), bitmap.width(), -1)
        return np.stack([pixels[..., names.index(channel)] for channel in "RGB"], axis=-1)


# The comparison.


def relative_error(picture, reference):
    """relMSE as the head of this file defines it."""
    mean = reference.mean(axis=(0, 1))
    x, r = picture / mean, reference / mean
    return float(np.mean((x - r) ** 2 / (r**2 + EPSILON)))


def main():
    options = arguments()
    if not options.photosite.is_file():
        sys.exit(f"{options.photosite} is missing: run cargo build --release first")
    capture = tomllib.loads(CAPTURE.read_text(encoding="utf-8"))
    columns, rows = capture["sensor"]["resolution_px"]
    paths = columns * rows * options.samples
    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder)
        mitsuba = Mitsuba(options, folder)
        renderers = [mitsuba]
        if not options.mitsuba_only:
            renderers += [Photosite(options, sampler, folder / sampler) for sampler in ("independent", "sobol")]
        cores = options.threads or os.cpu_count()
        print(f"Cornell box, {columns} × {rows} pixels, {options.samples} samples, "
              f"depth {capture['render']['max_depth']}, roulette from {options.roulette_depth}, {cores} threads")

        mitsuba.render(options.samples, 0)
        seconds = {renderer.name: [] for renderer in renderers}
        pictures = {renderer.name: [] for renderer in renderers}
        for run in range(options.runs):
            for renderer in renderers:
                picture, took = renderer.render(options.samples, 1 + run)
                seconds[renderer.name].append(took)
                pictures[renderer.name].append(picture)

        # Both samplers of photosite estimate the same picture: one reference serves both.
        references = {mitsuba.name: mitsuba.reference(options.reference)}
        if not options.mitsuba_only:
            reference = renderers[-1].reference(options.reference)
            references |= {renderer.name: reference for renderer in renderers[1:]}

    results = {}
    print(f"\n{'':36} {'seconds':>8} {'Mpaths/s':>9} {'ratio':>6} {'relMSE':>9} {'efficiency':>11} {'ratio':>6}")
    for renderer in renderers:
        took = statistics.median(seconds[renderer.name])
        error = statistics.mean(relative_error(x, references[renderer.name]) for x in pictures[renderer.name])
        entry = {"seconds": took, "paths_per_s": paths / took, "relmse": error, "efficiency": 1 / (error * took)}
        results[renderer.name] = entry
        base = results[mitsuba.name]
        print(f"{renderer.name:36} {took:8.3f} {entry['paths_per_s'] / 1e6:9.3f} "
              f"{entry['paths_per_s'] / base['paths_per_s']:6.2f} {error:9.5f} {entry['efficiency']:11.1f} "
              f"{entry['efficiency'] / base['efficiency']:6.2f}")
    print("\nMedian seconds and mean relMSE of "
          f"{options.runs} runs; ratios are to Mitsuba, above 1 is better than Mitsuba.")

    if not options.mitsuba_only:
        ours, theirs = references[renderers[-1].name], references[mitsuba.name]
        ratio = ours.mean(axis=(0, 1)) / theirs.mean(axis=(0, 1))
        difference = relative_error(ours, theirs)
        results["agreement"] = {"mean_ratio": ratio.tolist(), "relmse": difference}
        print("References, photosite / Mitsuba, mean electrons in R, G, B: " + ", ".join(f"{value:.4f}" for value in ratio)
              + f"; relMSE between them {difference:.2e}, of one of {options.reference} independent samples "
              f"{results[mitsuba.name]['relmse'] * options.samples / options.reference:.2e}")
    if options.json:
        options.json.write_text(json.dumps(results, indent=2) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
