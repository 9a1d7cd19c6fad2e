#!/usr/bin/env python3
"""Renders a scene in Mitsuba 3 with the variance of every pixel's mean.

    render.py SCENE.xml PICTURE.exr [--samples N] [--batches K] [--seed S] [--variant V]

The samples are rendered in K independent batches of N/K each; with x_k the images of the batches,

    mean     = Σ x_k / K
    variance = Σ (x_k − mean)² / (K·(K − 1)), of the mean.

A variance from few batches is uncertain itself, and z-scores by it have longer tails than normal ones: take at least 64.

PICTURE.exr holds a channel for each response of the scene's film and one called "variance.…" for each, as photosite's
electrons.exr does, so that `photosite compare` reads both.
"""

import argparse
import glob
import os
from pathlib import Path

import numpy as np

VARIANT = "llvm_ad_spectral"
# Needs no LLVM, and takes longer.
SLOW_VARIANT = "scalar_spectral"


def find_llvm():
    """The path of a library of LLVM that is new enough, where one is stated or lies where Debian puts it."""
    found = sorted(glob.glob("/usr/lib/*/libLLVM.so.19*") + glob.glob("/usr/lib/llvm-19/lib/libLLVM*.so*"))
    return os.environ.get("DRJIT_LIBLLVM_PATH") or next(iter(found), None)


def load_mitsuba(variant=VARIANT):
    """The module, set to a variant. Its LLVM is found by the loader's names or by those of Debian."""
    llvm = find_llvm()
    if "llvm" in variant and llvm:
        os.environ["DRJIT_LIBLLVM_PATH"] = llvm
    import mitsuba

    mitsuba.set_variant(variant)
    return mitsuba


def render(mitsuba, scene, samples, batches, seed=0):
    """Mean and variance of the mean, rows × columns × channels, and the names of the channels."""
    import drjit

    per_batch = max(1, samples // batches)
    mean = squares = 0.0
    for batch in range(batches):
        # Seeds of neighbouring batches must not overlap: Mitsuba derives a seed for every pass from the one it gets.
        picture = mitsuba.render(scene, spp=per_batch, seed=(seed * batches + batch) * 1_000)
        picture = np.array(picture, dtype=np.float64)
        delta = picture - mean
        mean = mean + delta / (batch + 1)
        squares = squares + delta * (picture - mean)
    drjit.flush_malloc_cache()
    names = [name for name in scene.sensors()[0].film().bitmap().struct_()]
    return mean, squares / (batches * (batches - 1)), [field.name for field in names]


def write(mitsuba, path, mean, variance, names):
    """Means and variances in one EXR file."""
    channels = names + [f"variance.{name}" for name in names]
    pixels = np.concatenate([mean, variance], axis=-1).astype(np.float32)
    bitmap = mitsuba.Bitmap(pixels, pixel_format=mitsuba.Bitmap.PixelFormat.MultiChannel, channel_names=channels)
    bitmap.write(str(path))


def main():
    parser = argparse.ArgumentParser(description="Render a scene in Mitsuba 3 with variances.")
    parser.add_argument("scene", type=Path)
    parser.add_argument("picture", type=Path)
    parser.add_argument("--samples", type=int, default=16384, help="a pixel (default: %(default)s)")
    parser.add_argument("--batches", type=int, default=128, help="(default: %(default)s)")
    parser.add_argument("--seed", type=int, default=0)
    variant = VARIANT if find_llvm() else SLOW_VARIANT
    parser.add_argument("--variant", default=variant, help=f"(default: {VARIANT} where LLVM 19 is found, else {SLOW_VARIANT})")
    options = parser.parse_args()
    if options.batches < 2:
        parser.error("one batch has no variance: --batches 2 at least, 64 for z-scores")
    mitsuba = load_mitsuba(options.variant)
    scene = mitsuba.load_file(str(options.scene))
    write(mitsuba, options.picture, *render(mitsuba, scene, options.samples, options.batches, options.seed))


if __name__ == "__main__":
    main()
