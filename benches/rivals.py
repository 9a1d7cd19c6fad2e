#!/usr/bin/env python3
"""Renders scenes in Cycles, in LuxCore and in photosite, each as it comes, for equally long, and compares the errors.

    cargo build --release
    python3 benches/rivals.py                  # e to j, ten processor seconds a render: about two hours

Cycles is Blender's renderer, as it comes and with path guiding; it is used through its module `bpy`, which is under the GPL: a separate program
that this bench starts, neither linked to photosite nor shipped with it. LuxCore is rendered by BIDIRCPU, its bidirectional path
tracer. Both are installed on the first run into target/benches-rivals-venv (benches/requirements-rivals.txt, Python 3.11;
--python names another environment); what cannot be loaded is left out, and a line says so.

All get the same triangles, camera, box filter and materials without colour, so that it does not matter that photosite traces
spectra. Cycles and photosite end paths at eight segments, LuxCore each of its two halves at four. The keys of [render] are left
out for photosite, and the others keep their defaults but for what changes the image that is estimated (clamping, softened
reflections, denoising).

Samples are chosen so that light transport takes the stated processor seconds: whole render less one of a single sample. For an
image x and a reference r of the same program that took --reference times as long, both divided by the mean of r:

    relMSE = mean over pixels of (x − r)² / (r² + 0.01);   ratio = their relMSE · seconds / ours

Errors are those of the sum of photosite's channels and of the mean of the others' channels. References are compared, too: the
mean light of each over photosite's, in units of radiance, and the relMSE between them after a 4 × 4 box filter.
"""

import argparse
import os
import statistics
import sys
import tempfile
from pathlib import Path

from comparison.environment import ROOT, enter

NAMES = {"photosite": "photosite", "cycles": "Cycles", "cycles-guided": "Cycles, guided", "luxcore": "LuxCore, BIDIRCPU"}


def arguments():
    parser = argparse.ArgumentParser(description="Compare photosite with Cycles and LuxCore.")
    parser.add_argument("scenes", nargs="*", default=list("efghij"), metavar="SCENE", help="a to k (default: e to j)")
    parser.add_argument("--photosite", type=Path, default=ROOT / "target" / "release" / "photosite", metavar="FILE")
    parser.add_argument("--rivals", nargs="+", choices=list(NAMES)[1:], default=list(NAMES)[1:], help="(default: all)")
    parser.add_argument("--python", type=Path, metavar="FILE", help="a Python that has bpy and pyluxcore")
    parser.add_argument("--seconds", type=float, default=10, help="of the processor, of each render (default: %(default)s)")
    parser.add_argument("--reference", type=float, default=20, help="times as long for references (default: %(default)s)")
    parser.add_argument("--runs", type=int, default=3, help="measured renders of each program (default: %(default)s)")
    parser.add_argument("--size", type=int, default=128, help="pixels along each side (default: %(default)s)")
    parser.add_argument("--threads", type=int, help="of all programs (default: all cores)")
    parser.add_argument("--images", type=Path, metavar="FOLDER", help="write the references here, as PNG files")
    return parser.parse_args()


class Ours:
    """photosite with its defaults, the sum of its channels in units of radiance."""

    name = "photosite"

    def __init__(self, renderer, per_unit):
        self.renderer, self.per_unit = renderer, per_unit

    def render(self, samples, seed):
        picture, seconds = self.renderer.render(samples, seed)
        return picture.sum(axis=2) / self.per_unit, seconds

    def warm_up(self):
        self.renderer.warm_up(1)

    @property
    def whole(self):
        return self.renderer.whole


def samples_for(program, seconds):
    """How many samples take that long, from ever longer trials."""
    samples, busy = 4, 0.0
    while busy < min(1.0, seconds / 3):
        samples *= 2
        busy = program.render(samples, 2_000_000 + samples)[1][1]
    return max(1, round(samples * seconds / busy))


def electrons_per_unit(read, options, scene, folder):
    """Electrons of the sum of the channels for a white of radiance 1, with a scene's exposure, aperture and pixels."""
    from comparison import neutral
    from comparison.capture import Scene
    from comparison.materials import Light, diffuse
    from comparison.meshes import quads
    from comparison.photosite_renderer import Photosite

    behind = quads("grey", ((0, 0, 5), (0.01, 0, 0), (0, 0.01, 0)))
    white = Scene([behind], [diffuse("grey", (0.5, 0.5, 0.5))], [0, 0, 0], [0, 0, -1], 3.0, Light((1, 1, 1), neutral.NIT))
    white.exposure_s = scene.exposure_s
    picture, _ = Photosite(read, options.photosite, white.write(folder, size=options.size), folder, "default", options.threads).render(4, 1)
    return picture.sum(axis=2).mean() * neutral.on_axis_sr(scene) / neutral.on_axis_sr(white)


def measure(key, options, rivals, read, folder):
    """All figures of a scene by the names of programs."""
    from comparison import neutral, scenes
    from comparison.figures import Runs
    from comparison.photosite_renderer import Photosite
    from comparison.rival import Rival

    scene = scenes.SCENES[key][1]().grey()
    capture = scene.write(folder, of_triangles=True, size=options.size)
    neutral.write(scene, folder, options.size)
    per_unit = electrons_per_unit(read, options, scene, folder / "white")
    ours = Ours(Photosite(read, options.photosite, capture, folder, "default", options.threads), per_unit)
    result = {}
    for program in [ours, *(Rival(name, rivals[name], folder, options.threads) for name in rivals)]:
        program.warm_up()
        samples = samples_for(program, options.seconds)
        reference, _ = program.render(round(samples * options.reference), 1_000_000)
        runs = Runs(options.size**2 * samples)
        for run in range(options.runs):
            picture, seconds = program.render(samples, 1 + run)
            runs.add(picture[..., None], seconds, reference[..., None])
            runs.whole.append(program.whole)
        result[program.name] = (samples, runs, reference)
        print(f"scene {key}: {program.name} done", file=sys.stderr)
    return result


def report(key, result):
    """Prints a scene's table as Markdown."""
    from comparison.figures import coarse, relative_error
    from comparison.scenes import SCENES

    print(f"\n### {key}: {SCENES[key][0]}\n")
    print("| | samples | of the processor, s | whole program, s | of the processor, s | relMSE | ratio | relMSE of 4 × 4 pixels | ratio "
          "| mean of the reference | relMSE between references |")
    print("|---|---|---|---|---|---|---|---|---|---|---|")
    _, ours, truth = result["photosite"]
    own = statistics.median(ours.busy)
    for name, (samples, runs, reference) in result.items():
        busy, (wall, whole) = statistics.median(runs.busy), runs.whole_s()
        longer = busy / own
        scaled = reference * (truth.mean() / reference.mean())
        between = relative_error(coarse(scaled[..., None]), coarse(truth[..., None]))
        print(f"| {NAMES[name]} | {samples} | {busy:.2f} | {wall:.2f} | {whole:.2f} | {runs.relmse:.5f} | {longer * runs.relmse / ours.relmse:.3g} "
              f"| {runs.coarse_relmse:.5f} | {longer * runs.coarse_relmse / ours.coarse_relmse:.3g} | {reference.mean() / truth.mean():.3f} "
              f"| {between:.1e} |")
    sys.stdout.flush()


def write_image(path, grey):
    """Writes a reference as a PNG file, its mean at 0.3."""
    import numpy as np
    from comparison.gltf import png

    shade = np.clip(grey / grey.mean() * 0.3, 0, 1) ** (1 / 2.2)
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(png(np.repeat(np.rint(shade * 255).astype(np.uint8)[..., None], 3, axis=2)))


def main():
    options = arguments()
    unknown = set(options.scenes) - set("abcdefghijk")
    if unknown:
        sys.exit(f"there is no scene {', '.join(sorted(unknown))}: a to k")
    if not options.photosite.is_file():
        sys.exit(f"{options.photosite} is missing: run cargo build --release first")
    enter()
    import mitsuba
    from comparison.mitsuba_renderer import read_exr
    from comparison.rival import RIVALS, interpreter, present

    mitsuba.set_variant("scalar_rgb")
    python = interpreter(options.python)
    rivals = {name: python for name in options.rivals if present(name, python)}
    print(f"{options.threads or os.cpu_count()} threads, {options.size} × {options.size} pixels, {options.seconds:g} processor seconds a "
          f"render, {options.runs} runs, references of {options.reference:g} times as long. Ratios above 1: photosite is better.")
    for name in sorted(set(options.rivals) - rivals.keys()):
        print(f"\n{NAMES[name]}: left out, {RIVALS[name][0]} cannot be loaded by {python}.")
    with tempfile.TemporaryDirectory() as folder:
        for key in options.scenes:
            result = measure(key, options, rivals, read_exr(mitsuba), Path(folder) / key)
            report(key, result)
            for name, (_, _, reference) in result.items():
                if options.images:
                    write_image(options.images / f"{key}-{name}.png", reference)


if __name__ == "__main__":
    main()
