#!/usr/bin/env python3
"""Renders scenes in Mitsuba 3 and in photosite on the same cores, and compares speed and error.

    cargo build --release
    python3 benches/compare.py                 # a, b and c, about half an hour the first time, for the references

Mitsuba is installed on the first run, into target/benches-venv; its LLVM variant needs LLVM 17 or later (Debian: apt
install libllvm19). What the scenes are says benches/comparison/scenes.py. Both programs get the same shapes, spectra,
camera, depth, roulette and sensor; glTF's metals and glossy coats (e, j, k) are "principled" in Mitsuba, a model of its own.
Balls are true spheres; with --triangles they are made of triangles. With --avx2 Mitsuba's kernels are those of a machine
without AVX-512. 256 × 256 pixels unless --size says otherwise, box filter, four wavelengths a path, in the response functions
of photosite's sensor, so that both estimate the same three values per pixel, electrons.
"default" is photosite with no key of [render] set but the samples. In all others no path is split unless their name
says so: "splitting 4" is `render.splitting = 4`, as many samples, each with four paths from the first rough surface on; "light
paths 1" is `render.light_paths`. Runs of all alternate. Mitsuba is warm: its kernel is
compiled before the measurement. Times are those of light transport alone: photosite's `trace_s`, Mitsuba's time in `render`.
Loading, sensor and files are left out on both sides. Beside them stand the times of whole programs, from start to end:
photosite's command, and a program in Python that loads the scene in Mitsuba, renders it once and writes a file; its kernel
comes from Dr.Jit's cache on disk.

Definitions, for an image x and a reference r of the same program (many samples, other seeds), each channel divided by
the reference's mean in that channel:

    relMSE     = mean over pixels and channels of (x − r)² / (r² + 0.01)
    efficiency = 1 / (relMSE · seconds), the reciprocal of the time to a relMSE of 1 with independent samples

The relMSE of all runs is averaged. Besides, relMSE of the sum of the channels tells how much of the error is noise of
colour, and relMSE of means of 4 × 4 pixels whether the errors of neighbours go together. Ratios above 1 are better than
Mitsuba's best sampler: the median of neighbouring runs, with the smallest and the largest. On a machine with other work to do,
trust those by processor time, which for photosite is that of the whole command less that of a render of one sample. relMSE says
nothing about bias that image and reference share; therefore the references of the two programs are compared with each other
too. Tables are Markdown.
"""

import argparse
import json
import os
import sys
import tempfile
from copy import copy
from pathlib import Path

from comparison.environment import ROOT, enter

WAYS = ["default", "independent", "sobol", "sobol, light paths 1", "sobol, splitting 4"]


def arguments():
    parser = argparse.ArgumentParser(description="Compare photosite with Mitsuba 3.")
    parser.add_argument("scenes", nargs="*", default=["a", "b", "c"], metavar="SCENE", help="a to k (default: a b c)")
    parser.add_argument("--photosite", type=Path, default=ROOT / "target" / "release" / "photosite", metavar="FILE")
    parser.add_argument("--before", type=Path, metavar="FILE", help="another build of photosite, rendered beside for the ratio to it")
    parser.add_argument("--runs", type=int, default=5, help="measured renders of each program (default: %(default)s)")
    parser.add_argument("--samples", type=int, nargs="+", default=[64],
                        help="samples per pixel (default: 64); multijitter rounds up to a product of two near numbers")
    parser.add_argument("--reference", type=int, default=4096, help="samples of the references (default: %(default)s)")
    parser.add_argument("--cache", type=Path, default=ROOT / "target" / "benches-references", metavar="FOLDER",
                        help="where references are kept (default: %(default)s)")
    parser.add_argument("--size", type=int, default=256, help="pixels along each side (default: %(default)s)")
    parser.add_argument("--ways", nargs="+", choices=WAYS, default=WAYS, metavar="WAY",
                        help=f"of photosite: {'; '.join(WAYS)} (default: all)")
    parser.add_argument("--samplers", nargs="+", choices=["independent", "multijitter"], default=["independent", "multijitter"],
                        help="of Mitsuba (default: both)")
    parser.add_argument("--threads", type=int, help="of both programs (default: all cores)")
    parser.add_argument("--triangles", action="store_true", help="the balls of b are made of triangles, for both programs")
    parser.add_argument("--avx2", action="store_true", help="Mitsuba compiles for AVX2, as on a machine without AVX-512")
    parser.add_argument("--variant", default="llvm_ad_spectral", help="of Mitsuba (default: %(default)s)")
    parser.add_argument("--json", type=Path, metavar="FILE", help="write the figures here as well")
    return parser.parse_args()


def reference(renderer, samples, cache, key):
    """A renderer's image of many samples, from the folder that keeps them or new."""
    import numpy as np

    kept = cache / f"{key}-{samples}.npy"
    if kept.is_file():
        return np.load(kept)
    picture = renderer.reference(samples)
    cache.mkdir(parents=True, exist_ok=True)
    np.save(kept, picture)
    return picture


def compare(mitsuba, key, options, folder):
    """All figures of a scene."""
    from comparison import scenes
    from comparison.figures import Runs, relative_error
    from comparison.mitsuba_renderer import Mitsuba, read_exr
    from comparison.photosite_renderer import Photosite

    capture = scenes.SCENES[key][1]().write(folder, options.triangles, options.size)
    read = read_exr(mitsuba)
    theirs = [Mitsuba(mitsuba, options.photosite, capture, folder, sampler, options.threads) for sampler in options.samplers]
    ours = [Photosite(read, options.photosite, capture, folder, way, options.threads) for way in options.ways]
    # Each way of the build before renders right after its counterpart.
    before = {}
    if options.before:
        for way in ours:
            earlier = copy(way)
            earlier.photosite, earlier.folder, earlier.name = options.before, folder / "before" / way.folder.name, f"{way.name}, before"
            before[way.name] = earlier
    # All ways of a program estimate the same image: one reference serves all, in which nothing is shared.
    light = {"light_paths": 1} if key in scenes.FOCUSED else {}
    most = Photosite(read, options.photosite, capture, folder, "sobol, splitting 4", options.threads, **light)
    kind = f"{key}-{{}}" + ("-triangles" if options.triangles else "") + (f"-{options.size}" if options.size != 256 else "")
    truth = {
        "Mitsuba": reference(theirs[-1], options.reference, options.cache, kind.format("mitsuba")),
        "photosite": reference(most, options.reference, options.cache, kind.format("photosite")),
    }
    result = {
        "mean_ratio": (truth["photosite"].mean(axis=(0, 1)) / truth["Mitsuba"].mean(axis=(0, 1))).tolist(),
        "relmse_of_references": relative_error(truth["photosite"], truth["Mitsuba"]),
        "samples": {},
        "before": {},
    }
    for samples in options.samples:
        everything = [*theirs, *(renderer for way in ours for renderer in (way, before.get(way.name)) if renderer)]
        runs = {renderer.name: Runs(options.size**2 * samples) for renderer in everything}
        for renderer in everything:
            renderer.warm_up(samples)
        for run in range(options.runs):
            for renderer in everything:
                picture, seconds = renderer.render(samples, 1 + run)
                runs[renderer.name].add(picture, seconds, truth[renderer.name.split(",")[0]])
                runs[renderer.name].whole.append(renderer.whole_program(samples, 1 + run))
        result["before"][samples] = {name: runs.pop(earlier.name) for name, earlier in before.items()}
        result["samples"][samples] = runs
    return result


def main():
    options = arguments()
    unknown = set(options.scenes) - set("abcdefghijk")
    if unknown:
        sys.exit(f"there is no scene {', '.join(sorted(unknown))}: a to k")
    for program in filter(None, (options.photosite, options.before)):
        if not program.is_file():
            sys.exit(f"{program} is missing: run cargo build --release first")
    enter()
    from comparison.mitsuba_renderer import start
    from comparison.tables import report, report_before, summarise

    mitsuba = start(options.variant, options.threads, options.avx2)
    registers = ", AVX2" if options.avx2 else ""
    print(f"Mitsuba {mitsuba.__version__} {options.variant}{registers}, {options.threads or os.cpu_count()} threads, "
          f"{options.runs} runs, references of {options.reference} samples")
    results = {}
    with tempfile.TemporaryDirectory() as folder:
        for key in options.scenes:
            results[key] = compare(mitsuba, key, options, Path(folder) / key)
            report(key, results[key])
            sys.stdout.flush()
    summarise(results)
    if options.before:
        report_before(results)
    if options.json:
        plain = json.dumps(results, indent=2, default=vars)
        options.json.write_text(plain + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
