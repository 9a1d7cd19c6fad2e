"""A capture in photosite, through its command."""

import numpy as np

from . import command


class Photosite:
    """A capture as photosite renders it."""

    def __init__(self, mitsuba, photosite, capture, folder, sampler, threads, splitting=1, reuse=1, light_paths=0):
        self.mitsuba, self.photosite, self.capture, self.threads = mitsuba, photosite, capture, threads
        self.sampler, self.splitting, self.reuse, self.light_paths = sampler, splitting, reuse, light_paths
        ways = (("splitting", splitting, 1), ("reuse", reuse, 1), ("light paths", light_paths, 0))
        parts = [sampler] + [f"{name} {value}" for name, value, usual in ways if value != usual]
        self.folder = folder / "-".join(parts).replace(" ", "-")
        self.name = ", ".join(["photosite", *parts])
        # Processor seconds of all that is not light transport: loading, building, sensor, files.
        self.overhead = 0.0

    def render(self, samples, seed):
        """A picture, mean electrons without noise, with the wall and processor seconds of its light transport."""
        keys = [
            f"render.samples_per_pixel={samples}",
            f'render.sampler="{self.sampler}"',
            f"render.splitting={self.splitting}",
            f"render.reuse={self.reuse}",
            f"render.light_paths={self.light_paths}",
        ]
        options = ["--threads", self.threads] if self.threads else []
        report, busy = command.render(self.photosite, self.capture, self.folder, seed, keys, *options)
        seconds = report["timings"]["trace_s"], busy - self.overhead
        return self._electrons(), seconds

    def warm_up(self, _samples):
        """Learns what a render takes besides light transport."""
        self.overhead = min(self.render(1, 0)[1][1] for _ in range(3))

    def reference(self, samples):
        """A picture of many samples."""
        return self.render(samples, 1_000_000)[0]

    def _electrons(self):
        bitmap = self.mitsuba.Bitmap(str(self.folder / "electrons.exr"))
        names = [field.name for field in bitmap.struct_()]
        pixels = np.array(bitmap, dtype=np.float64).reshape(bitmap.height(), bitmap.width(), -1)
        return np.stack([pixels[..., names.index(channel)] for channel in "RGB"], axis=-1)
