#!/usr/bin/env python3
"""Renders scenes in Mitsuba 3 and in photosite on the same cores, and compares speed and error.

    cargo build --release
    python3 benches/compare.py                 # a, b and c, about half an hour the first time, for the references

Mitsuba is installed on the first run, into target/benches-venv; its LLVM variant needs LLVM 17 or later (Debian: apt
install libllvm19). What the scenes are says benches/comparison/scenes.py. Both programs get the same shapes, spectra,
camera, depth, roulette and sensor. The balls of b are true spheres; with --triangles they are made of triangles. With
--avx2 Mitsuba's kernels are those of a machine without AVX-512. 256 × 256 pixels, box filter, four wavelengths a path, in
the response functions of photosite's sensor, so that both estimate the same three numbers per pixel, electrons.
"Splitting 4" is photosite with `render.splitting = 4`: as many samples, each with four paths from the first rough surface
on; "reuse 16" and "light paths 1" are `render.reuse` and `render.light_paths`. Runs of all alternate. Mitsuba is warm: its kernel is compiled before the measurement. Times are those of light transport alone:
photosite's `trace_s`, Mitsuba's time in `render`. Loading, sensor and files are left out on both sides.

Definitions, for a picture x and a reference r of the same program (many samples, other seeds), each channel divided by
the reference's mean in that channel:

    relMSE     = mean over pixels and channels of (x − r)² / (r² + 0.01)
    efficiency = 1 / (relMSE · seconds), the reciprocal of the time to a relMSE of 1 with independent samples

The relMSE of all runs is averaged. Besides, relMSE of the sum of the channels tells how much of the error is noise of
colour. Ratios above 1 are better than Mitsuba's best sampler: the median of neighbouring runs, with the smallest and the
largest. On a machine with other work to do, trust those by processor time, which for photosite is that of the whole
command less that of a render of one sample. relMSE says nothing about bias that picture and reference share; therefore
the references of the two programs are compared with each other too. Tables are Markdown.
"""

import argparse
import json
import os
import statistics
import sys
import tempfile
from copy import copy
from pathlib import Path

from comparison.environment import ROOT, enter


def arguments():
    parser = argparse.ArgumentParser(description="Compare photosite with Mitsuba 3.")
    parser.add_argument("scenes", nargs="*", default=["a", "b", "c"], metavar="SCENE", help="a, b, c, d (default: a b c)")
    parser.add_argument("--photosite", type=Path, default=ROOT / "target" / "release" / "photosite", metavar="FILE")
    parser.add_argument("--before", type=Path, metavar="FILE", help="another build of photosite, rendered beside for the ratio to it")
    parser.add_argument("--runs", type=int, default=5, help="measured renders of each program (default: %(default)s)")
    parser.add_argument("--samples", type=int, nargs="+", default=[64], help="samples per pixel (default: 64)")
    parser.add_argument("--reference", type=int, default=4096, help="samples of the references (default: %(default)s)")
    parser.add_argument("--cache", type=Path, default=ROOT / "target" / "benches-references", metavar="FOLDER",
                        help="where references are kept (default: %(default)s)")
    parser.add_argument("--threads", type=int, help="of both programs (default: all cores)")
    parser.add_argument("--triangles", action="store_true", help="the balls of b are made of triangles, for both programs")
    parser.add_argument("--avx2", action="store_true", help="Mitsuba compiles for AVX2, as on a machine without AVX-512")
    parser.add_argument("--variant", default="llvm_ad_spectral", help="of Mitsuba (default: %(default)s)")
    parser.add_argument("--json", type=Path, metavar="FILE", help="write the figures here as well")
    return parser.parse_args()


def reference(renderer, samples, cache, key):
    """A renderer's picture of many samples, from the folder that keeps them or new."""
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
    from comparison.mitsuba_renderer import Mitsuba
    from comparison.photosite_renderer import Photosite

    capture = scenes.write(key, folder, options.triangles)
    theirs = [Mitsuba(mitsuba, options.photosite, capture, folder, sampler) for sampler in ("independent", "multijitter")]
    ours = [
        Photosite(mitsuba, options.photosite, capture, folder, sampler, options.threads, **ways)
        for sampler, ways in (
            ("independent", {}),
            ("sobol", {}),
            ("sobol", {"reuse": 16}),
            ("sobol", {"light_paths": 1}),
            ("sobol", {"splitting": 4}),
        )
    ]
    # Each way of the build before renders right after its counterpart.
    before = {}
    if options.before:
        for way in ours:
            earlier = copy(way)
            earlier.photosite, earlier.folder, earlier.name = options.before, folder / "before" / way.folder.name, f"{way.name}, before"
            before[way.name] = earlier
    # All ways of a program estimate the same picture: one reference serves all, in which nothing is shared.
    light = {"light_paths": 1} if key == "b" else {}
    most = Photosite(mitsuba, options.photosite, capture, folder, "sobol", options.threads, splitting=4, **light)
    of_triangles = "-triangles" if options.triangles else ""
    truth = {
        "Mitsuba": reference(theirs[-1], options.reference, options.cache, f"{key}-mitsuba{of_triangles}"),
        "photosite": reference(most, options.reference, options.cache, f"{key}-photosite{of_triangles}"),
    }
    result = {
        "mean_ratio": (truth["photosite"].mean(axis=(0, 1)) / truth["Mitsuba"].mean(axis=(0, 1))).tolist(),
        "relmse_of_references": relative_error(truth["photosite"], truth["Mitsuba"]),
        "samples": {},
        "before": {},
    }
    for samples in options.samples:
        everything = [*theirs, *(renderer for way in ours for renderer in (way, before.get(way.name)) if renderer)]
        runs = {renderer.name: Runs(256 * 256 * samples) for renderer in everything}
        for renderer in everything:
            renderer.warm_up(samples)
        for run in range(options.runs):
            for renderer in everything:
                picture, seconds = renderer.render(samples, 1 + run)
                runs[renderer.name].add(picture, seconds, truth[renderer.name.split(",")[0]])
        result["before"][samples] = {name: runs.pop(earlier.name) for name, earlier in before.items()}
        result["samples"][samples] = runs
    return result


def best(runs, program, undivided=False):
    """The name of a program's way of the highest efficiency; if asked, of those that trace one path a sample and no more."""
    more = ("splitting", "reuse", "light paths")
    names = (name for name in runs if name.startswith(program) and not (undivided and any(way in name for way in more)))
    return max(names, key=lambda name: runs[name].efficiency())


def report(key, result):
    """Prints a scene's tables as Markdown."""
    from comparison import scenes
    from comparison.figures import Ratio

    print(f"\n### {key}: {scenes.SCENES[key][0]}")
    for samples, runs in result["samples"].items():
        base = runs[best(runs, "Mitsuba")]
        print(f"\n{samples} samples per pixel; ratios to {best(runs, 'Mitsuba')}.\n")
        print("| | Mpaths/s | ratio | by processor time | relMSE | efficiency | ratio | by processor time | relMSE of the sum | ratio by processor time |")
        print("|---|---|---|---|---|---|---|---|---|---|")
        for name, r in runs.items():
            gain, grey_gain = base.relmse / r.relmse, base.grey_relmse / r.grey_relmse
            cells = [
                name,
                f"{r.paths / statistics.median(r.wall) / 1e6:.2f}",
                Ratio.of(base.wall, r.wall),
                Ratio.of(base.busy, r.busy),
                f"{r.relmse:.5f}",
                f"{r.efficiency():.1f}",
                Ratio.of(base.wall, r.wall, gain),
                Ratio.of(base.busy, r.busy, gain),
                f"{r.grey_relmse:.5f}",
                Ratio.of(base.busy, r.busy, grey_gain),
            ]
            print("| " + " | ".join(str(cell) for cell in cells) + " |")
    means = ", ".join(f"{value:.4f}" for value in result["mean_ratio"])
    print(f"\nReferences, photosite / Mitsuba: mean electrons in R, G, B {means}; relMSE between them {result['relmse_of_references']:.1e}.")


def summarise(results):
    """Prints what matters of all scenes as Markdown: the best sampler of each program, and the goals."""
    from comparison import scenes
    from comparison.figures import Ratio

    print("\n### In short\n")
    print("The best of each, for paths per second of those that trace one path a sample. Goals: paths per second at least 1, efficiency at "
          "least 2.\n")
    print("| scene | samples | paths per second | by processor time | efficiency | by processor time | |")
    print("|---|---|---|---|---|---|---|")
    for key, result in results.items():
        for samples, runs in result["samples"].items():
            ours, theirs = runs[best(runs, "photosite")], runs[best(runs, "Mitsuba")]
            undivided = runs[best(runs, "photosite", undivided=True)]
            gain = theirs.relmse / ours.relmse
            rate, efficiency = Ratio.of(theirs.wall, undivided.wall), Ratio.of(theirs.wall, ours.wall, gain)
            missed = [name for name, ratio, goal in (("paths", rate, 1), ("efficiency", efficiency, 2)) if ratio.median < goal]
            verdict = f"**not reached**: {', '.join(missed)}" if missed else "reached"
            print(f"| {key}: {scenes.SCENES[key][0]} | {samples} | {rate} | {Ratio.of(theirs.busy, undivided.busy)} "
                  f"| {efficiency} | {Ratio.of(theirs.busy, ours.busy, gain)} | {verdict} |")


def report_before(results):
    """Prints the paths per second of this build over those of the one before as Markdown."""
    from comparison.figures import Ratio

    print("\n### Paths per second, this build over the one before\n")
    print("| scene | samples | | ratio | by processor time |")
    print("|---|---|---|---|---|")
    for key, result in results.items():
        for samples, before in result["before"].items():
            for name, earlier in before.items():
                now = result["samples"][samples][name]
                print(f"| {key} | {samples} | {name} | {Ratio.of(earlier.wall, now.wall)} | {Ratio.of(earlier.busy, now.busy)} |")


def main():
    options = arguments()
    unknown = set(options.scenes) - set("abcd")
    if unknown:
        sys.exit(f"there is no scene {', '.join(sorted(unknown))}: a, b, c, d")
    for program in filter(None, (options.photosite, options.before)):
        if not program.is_file():
            sys.exit(f"{program} is missing: run cargo build --release first")
    enter()
    from comparison.mitsuba_renderer import start

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
