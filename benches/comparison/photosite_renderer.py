"""A capture in photosite, through its command."""

import json
import resource
import subprocess
import sys

import numpy as np


class Photosite:
    """A capture as photosite renders it."""

    def __init__(self, mitsuba, photosite, capture, folder, sampler, splitting, threads):
        self.mitsuba, self.photosite, self.capture, self.threads = mitsuba, photosite, capture, threads
        self.sampler, self.splitting = sampler, splitting
        self.folder = folder / f"{sampler}-{splitting}"
        self.name = f"photosite, {sampler}" + (f", splitting {splitting}" if splitting > 1 else "")
        # Processor seconds of all that is not light transport: loading, building, sensor, files.
        self.overhead = 0.0

    def render(self, samples, seed):
        """A picture, mean electrons without noise, with the wall and processor seconds of its light transport."""
        command = [
            self.photosite, "render", self.capture, "-o", self.folder, "--force", "--json", "--quiet", "--seed", seed,
            "--set", f"render.samples_per_pixel={samples}",
            "--set", f'render.sampler="{self.sampler}"',
            "--set", f"render.splitting={self.splitting}",
        ]  # fmt: skip
        if self.threads:
            command += ["--threads", self.threads]
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        done = subprocess.run([str(word) for word in command], stdout=subprocess.PIPE, stdin=subprocess.DEVNULL, check=False)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        if done.returncode:
            sys.exit(f"photosite failed with status {done.returncode}")
        busy = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
        seconds = json.loads(done.stdout)["timings"]["trace_s"], busy - self.overhead
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
