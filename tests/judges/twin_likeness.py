#!/usr/bin/env python3
"""Compares images of a sensor with those of its twin by programs that know nothing of either.

    twin_likeness.py PHOTOSITE [--serials N]

The original is a CMOS sensor with unequal, heavy-tailed pixels, row noise and fixed patterns. `photosite fit` makes its
twin of an EMVA 1288 image set. Both take dark images, even light at half of saturation, and a scene of edges and textures,
with the same light and N serial numbers each (16 by default). Exit status 0 where

- scikit-learn's logistic regression and random forest, trained on statistics, spectra and pixels of patches of 64 × 64 of
  some serial numbers, tell the twin from the original in at most 55 % of patches of others, give or take two standard
  deviations of guesses (1.1 % for 2048 patches; patches are taken less the mean of their image, which the fit knows to a
  thousandth);
- pixel values less their mean have the same distribution, by the Kolmogorov-Smirnov statistic D: at most 0.01, and a twin
  whose read noise is taken for normal is told by it in the dark, and by the classifiers in 75 % of patches at least;
- a denoiser (a perceptron on 7 × 7 pixels) trained on pairs of the twin loses at most 0.3 dB on images of the original
  against one that is trained on pairs of the original.
"""

import argparse
import json
import subprocess
import sys
import tempfile
import warnings
from pathlib import Path

import numpy as np
from scipy.ndimage import gaussian_filter
from scipy.stats import ks_2samp, kurtosis, skew
from sklearn.decomposition import PCA
from sklearn.ensemble import RandomForestClassifier
from sklearn.exceptions import ConvergenceWarning
from sklearn.linear_model import LogisticRegression
from sklearn.neural_network import MLPRegressor
from sklearn.pipeline import make_pipeline
from sklearn.preprocessing import StandardScaler

SIZE = 512
PATCH = 64
SCENE = 192
FRAMES = 2
# Percent of the patches.
MOST_TOLD = 55
LEAST_TOLD = 75
GAIN_DB = 12
ORIGINAL = "sony-imx250-mono"
CHANGES = {
    "noise.read_noise_e": 2.4,
    "noise.read_noise_spread_percent": 35,
    "noise.read_noise_degrees_of_freedom": 6,
    "noise.row_noise_e": 0.5,
    "noise.dsnu_e": 1.0,
    "noise.dsnu_column_e": 0.4,
    "noise.prnu_percent": 0.6,
}
# Without the shape of the read noise, to see that the comparison sees it.
NORMAL = {"noise.read_noise_spread_percent": 0}


class Camera:
    """A sensor, original or twin, as `photosite expose` takes images with it."""

    def __init__(self, photosite, sensor, changes, gain_db, folder):
        self.photosite, self.sensor, self.changes, self.gain_db, self.folder = photosite, sensor, changes, gain_db, folder

    def images(self, electrons, serial, seed, frames=FRAMES):
        """Digital numbers of an image of mean electrons, taken `frames` times."""
        light = self.folder / "light.npy"
        np.save(light, electrons.astype(np.float32))
        settings = {
            "sensor.preset": self.sensor,
            "sensor.serial": serial,
            "sensor.resolution_px": f"[{electrons.shape[1]}, {electrons.shape[0]}]",
            "exposure.time_s": 0.001,
            "exposure.gain_db": self.gain_db,
            "output.raw": "['npy']",
            **{f"sensor.{key}": value for key, value in self.changes.items()},
        }
        command = [self.photosite, "expose", str(light), "--unit", "electrons", "--quiet", "--force"]
        command += ["--frames", str(frames), "--seed", str(seed), "-o", str(self.folder / "images")]
        command += [word for key, value in settings.items() for word in ("--set", f"{key}={value}")]
        subprocess.run(command, check=True)
        files = sorted((self.folder / "images").glob("**/*raw*.npy"))
        assert len(files) == frames, files
        return np.stack([np.load(file) for file in files]).astype(float)


def scene(seed):
    """Mean electrons of edges, gradients and textures, from the dark to half of saturation."""
    random = np.random.default_rng(seed)
    y, x = np.mgrid[:SCENE, :SCENE]
    image = np.full((SCENE, SCENE), 0.3)
    for _ in range(80):
        cx, cy, radius = random.uniform(0, SCENE), random.uniform(0, SCENE), random.uniform(6, 50)
        image[(x - cx) ** 2 + (y - cy) ** 2 < radius**2] = random.uniform(0.0, 1.0) ** 2
    texture = gaussian_filter(random.standard_normal((SCENE, SCENE)), 2)
    image *= 1 + 0.15 * texture / texture.std()
    return gaussian_filter(np.clip(image, 0, 1), 0.7)


def patches(image):
    tiles = image.reshape(SIZE // PATCH, PATCH, SIZE // PATCH, PATCH).swapaxes(1, 2)
    return tiles.reshape(-1, PATCH, PATCH)


def statistics(patch, mean):
    """Moments, tails, lines, last bits and spectrum of a patch of an image of this mean."""
    centred = patch - patch.mean()
    sigma = centred.std()
    quantiles = np.quantile(np.abs(centred), [0.5, 0.9, 0.99, 0.999]) / sigma
    spectrum = np.log(np.abs(np.fft.fft2(centred)) ** 2 + 1)
    radius = np.hypot(*np.meshgrid(*[np.fft.fftfreq(PATCH)] * 2))
    rings = [spectrum[(radius >= a) & (radius < a + 0.1)].mean() for a in np.arange(0.01, 0.5, 0.1)]
    axes = [spectrum[0, 1:].mean(), spectrum[1:, 0].mean()]
    lines = [centred.mean(axis).std() for axis in (0, 1)]
    even = (patch % 2 == 0).mean()
    return [patch.mean() - mean, sigma, skew(centred.ravel()), kurtosis(centred.ravel()), *quantiles, *lines, even, *rings, *axes]


CLASSIFIERS = {
    "logistic regression": lambda: make_pipeline(StandardScaler(), LogisticRegression(max_iter=1000)),
    "random forest": lambda: RandomForestClassifier(300, min_samples_leaf=5, random_state=0, n_jobs=-1),
}


def told_apart(kind, cameras, electrons, serials):
    """Largest percentage of patches that a classifier, trained on half of the serial numbers, tells apart in the other half, and
    the standard deviation of guesses."""
    rows, pixels, labels, halves = [], [], [], []
    for label, camera in enumerate(cameras):
        for serial in range(serials):
            # Two sensors never share a serial number, so that nothing is told by a pattern that was seen before.
            for image in camera.images(electrons, 100 * (label + 1) + serial, seed=serial):
                for patch in patches(image):
                    rows.append(statistics(patch, image.mean()))
                    pixels.append((patch - image.mean()).ravel())
                    labels.append(label)
                    halves.append(serial % 2)
    rows, pixels, labels, halves = map(np.array, (rows, pixels, labels, halves))
    right = {}
    for half in (0, 1):
        train, test = halves != half, halves == half
        parts = PCA(40, random_state=0, svd_solver="randomized").fit(pixels[train])
        reduced = parts.transform(pixels)
        for inputs, values in {"statistics": rows, "pixels": reduced, "both": np.hstack([rows, reduced])}.items():
            for name, make in CLASSIFIERS.items():
                found = make().fit(values[train], labels[train]).predict(values[test]) == labels[test]
                right.setdefault((name, inputs), []).append(found.mean())
    percent = {key: 100 * np.mean(parts) for key, parts in right.items()}
    for (name, inputs), told in percent.items():
        print(f"{kind}, {name} on {inputs}: {told:.1f} % told apart")
    # Patches of one place of one sensor share a pattern.
    return max(percent.values()), 50 / np.sqrt(len(labels) / FRAMES)


def distance(cameras, electrons, serials):
    """Kolmogorov-Smirnov statistic of pixel values less their mean, without the steps of whole numbers."""
    random = np.random.default_rng(0)
    values = []
    for label, camera in enumerate(cameras):
        images = [camera.images(electrons, 100 * (label + 1) + serial, seed=serial, frames=1)[0] for serial in range(serials)]
        values.append(np.concatenate([(image - image.mean()).ravel() for image in images]))
    return ks_2samp(*[value + random.uniform(-0.5, 0.5, value.size) for value in values]).statistic


def neighbours(image):
    reach = 3
    padded = np.pad(image, reach, mode="reflect")
    windows = np.lib.stride_tricks.sliding_window_view(padded, (2 * reach + 1,) * 2)
    return windows.reshape(-1, (2 * reach + 1) ** 2)


def denoiser(camera, scale, serial):
    """A perceptron that finds the value of a pixel, trained on images of the camera and the light that they are of."""
    inputs, wanted = [], []
    for number in range(4):
        light = scene(number)
        image = (camera.images(scale * light, serial + number, seed=number, frames=1)[0] - camera.black) / camera.white
        inputs.append(neighbours(image))
        wanted.append(light.ravel() - image.ravel())
    inputs, wanted = np.concatenate(inputs), np.concatenate(wanted)
    network = MLPRegressor(hidden_layer_sizes=(64, 32), random_state=0, max_iter=12, batch_size=512)
    with warnings.catch_warnings():
        # Twelve rounds are all that is wanted.
        warnings.simplefilter("ignore", ConvergenceWarning)
        return network.fit(inputs, wanted)


def quality(network, camera, scale):
    """Peak signal-to-noise ratio in dB over new images of the camera."""
    errors = []
    for number in range(20, 24):
        light = scene(number)
        image = (camera.images(scale * light, number, seed=number, frames=1)[0] - camera.black) / camera.white
        found = image.ravel() + network.predict(neighbours(image))
        errors.append(((found - light.ravel()) ** 2).mean())
    return -10 * np.log10(np.mean(errors))


def main():
    arguments = argparse.ArgumentParser(description="Compares images of a sensor with those of its twin.")
    arguments.add_argument("photosite")
    arguments.add_argument("--serials", type=int, default=16)
    arguments = arguments.parse_args()
    complaints = []
    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder)
        sets = [word for key, value in CHANGES.items() for word in ("--set", f"{key}={value}")]
        run = [arguments.photosite, "emva1288", ORIGINAL, "--quiet", "-o", f"{folder}/set", *sets, "--set", "serial=7"]
        subprocess.run([*run, "--gain-db", str(GAIN_DB), "--size", "256x256", "--steps", "20"], check=True)
        run = [arguments.photosite, "fit", f"{folder}/set", "-o", f"{folder}/twin.toml", "--json"]
        told = {p["key"]: p["value"] for p in json.loads(subprocess.run(run, check=True, capture_output=True).stdout)["parameters"]}
        original = Camera(arguments.photosite, ORIGINAL, CHANGES, GAIN_DB, folder)
        twin = Camera(arguments.photosite, f"{folder}/twin.toml", {}, 0, folder)
        gain = told["adc.conversion_gain_dn_per_e"]
        half = 0.5 * 4095 / gain
        for camera in (original, twin):
            camera.black, camera.white = told["adc.black_level_dn"], gain * half
        lights = {"dark images": 0.0, "flats": half}
        for kind, electrons in lights.items():
            electrons = np.full((SIZE, SIZE), electrons)
            percent, deviation = told_apart(kind, [original, twin], electrons, arguments.serials)
            if percent > MOST_TOLD + 2 * deviation:
                complaints.append(f"{kind}: {percent:.1f} % are told apart")
            found = distance([original, twin], electrons, arguments.serials)
            print(f"{kind}, Kolmogorov-Smirnov: D = {found:.4f}")
            if found > 0.01:
                complaints.append(f"{kind}: distributions differ by {found:.4f}")
        normal = Camera(arguments.photosite, f"{folder}/twin.toml", {**NORMAL, "noise.read_noise_degrees_of_freedom": 1000}, 0, folder)
        darkness = np.zeros((SIZE, SIZE))
        percent, _ = told_apart("dark images, read noise taken for normal", [original, normal], darkness, arguments.serials)
        found = distance([original, normal], darkness, arguments.serials)
        print(f"dark images, read noise taken for normal, Kolmogorov-Smirnov: D = {found:.4f}")
        if percent < LEAST_TOLD or found < 0.02:
            complaints.append("read noise that was taken for normal is not told from the original's")
        # A twentieth of the light, where noise counts.
        scale = 0.05 * half
        for camera in (original, twin):
            camera.white = gain * scale
        by_own, by_twin = (quality(denoiser(camera, scale, serial), original, scale) for camera, serial in [(original, 300), (twin, 400)])
        print(f"denoisers on the original: {by_own:.2f} dB trained on its own images, {by_twin:.2f} dB on the twin's")
        if by_own - by_twin > 0.3:
            complaints.append(f"the twin's denoiser loses {by_own - by_twin:.2f} dB")
    for complaint in complaints:
        print(f"error: {complaint}", file=sys.stderr)
    return bool(complaints)


if __name__ == "__main__":
    sys.exit(main())
