"""A capture in photosite, through its command."""

import time

import numpy as np

from . import command

# Keys of [render] in each way to render a scene; "default" sets none of them.
ONE_PATH = {"sampler": "sobol", "splitting": 1, "light_paths": 0}
WAYS = {
    "default": {},
    "independent": {**ONE_PATH, "sampler": "independent"},
    "sobol": ONE_PATH,
    "sobol, light paths 1": {**ONE_PATH, "light_paths": 1},
    "sobol, splitting 4": {**ONE_PATH, "splitting": 4},
}
# Ways that trace one path a sample.
UNDIVIDED = ("independent", "sobol")


class Photosite:
    """A capture as photosite renders it, with other values of some keys of [render]."""

    def __init__(self, read, photosite, capture, folder, way, threads, **keys):
        """`read` turns an EXR file into names of its channels and an array."""
        self.read, self.photosite, self.capture, self.threads = read, photosite, capture, threads
        self.keys = {**WAYS[way], **keys}
        self.folder = folder / way.replace(", ", "-").replace(" ", "-")
        self.name = f"photosite, {way}"
        # Processor seconds of all that is not light transport: loading, building, sensor, files.
        self.overhead = 0.0
        # Wall and processor seconds of the last command.
        self.whole = (0.0, 0.0)

    def render(self, samples, seed):
        """An image, mean electrons without noise, with the wall and processor seconds of its light transport."""
        report, busy = self._command(samples, seed, self.keys)
        seconds = report["timings"]["trace_s"], busy - self.overhead
        return self._electrons(), seconds

    def _command(self, samples, seed, render_keys):
        keys = [f"render.samples_per_pixel={samples}"]
        keys += [f'render.{key}="{value}"' if isinstance(value, str) else f"render.{key}={value}" for key, value in render_keys.items()]
        options = ["--threads", self.threads] if self.threads else []
        start = time.perf_counter()
        report, busy = command.render(self.photosite, self.capture, self.folder, seed, keys, *options)
        self.whole = time.perf_counter() - start, busy
        return report, busy

    def warm_up(self, _samples):
        """Learns what a render takes besides light transport. Pilots of a way are part of that, so here are none."""
        self.overhead = min(self._command(1, 0, ONE_PATH)[1] for _ in range(3))

    def whole_program(self, _samples, _seed):
        """Wall and processor seconds of the command that rendered last."""
        return self.whole

    def reference(self, samples):
        """An image of many samples."""
        return self.render(samples, 1_000_000)[0]

    def _electrons(self):
        names, pixels = self.read(self.folder / "electrons.exr")
        return np.stack([pixels[..., names.index(channel)] for channel in "RGB"], axis=-1)
