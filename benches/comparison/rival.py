"""Another renderer as a program of its own, and the environment of Python that has it."""

import json
import os
import resource
import subprocess
import sys
import time
from pathlib import Path

import numpy as np

from .environment import BENCHES, ROOT

ENVIRONMENT = ROOT / "target" / "benches-rivals-venv"
# Module, program (comparison/…_program.py) and its further arguments by the names of rivals.
RIVALS = {
    "cycles": ("bpy", "cycles", []),
    "cycles-guided": ("bpy", "cycles", ["guided"]),
    "luxcore": ("pyluxcore", "luxcore", []),
}


class Rival:
    """A scene as another program renders it."""

    def __init__(self, name, python, folder, threads):
        self.name, self.python, self.folder, self.threads = name, python, folder, threads or os.cpu_count()
        _, program, self.more = RIVALS[name]
        self.program = Path(__file__).with_name(f"{program}_program.py")
        # Processor seconds of a render call that are not light transport.
        self.overhead = 0.0
        self.whole = (0.0, 0.0)

    def render(self, samples, seed):
        """A grey image, with the wall and processor seconds of its light transport."""
        out = self.folder / f"{self.name}.npy"
        out.unlink(missing_ok=True)
        command = [self.python, self.program, self.folder, out, samples, seed, self.threads, *self.more]
        before, start = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter()
        done = subprocess.run([str(word) for word in command], stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True, check=False)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        if done.returncode or not out.is_file():
            sys.exit(f"{self.program.name} failed with status {done.returncode}:\n{done.stderr}")
        self.whole = time.perf_counter() - start, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
        seconds = json.loads(out.with_suffix(".json").read_text(encoding="utf-8"))
        return np.load(out).astype(np.float64).mean(axis=2), (seconds["wall_s"], seconds["busy_s"] - self.overhead)

    def warm_up(self):
        """Learns what a render call takes besides light transport: a sample takes next to nothing."""
        self.overhead = min(self.render(1, 0)[1][1] for _ in range(2))


def interpreter(given):
    """The Python that has the rivals: the one given, or that of an environment which is made here."""
    if given:
        return given
    python = ENVIRONMENT / "bin" / "python"
    if not python.is_file():
        subprocess.run([sys.executable, "-m", "venv", str(ENVIRONMENT)], check=True)
        for line in (BENCHES / "requirements-rivals.txt").read_text(encoding="utf-8").splitlines():
            if not line.startswith("#"):
                # What cannot be installed here is left out.
                subprocess.run([str(python), "-m", "pip", "install", "--quiet", *line.split()], check=False)
    return python


def present(name, python):
    """Whether a rival's module can be loaded."""
    return subprocess.run([str(python), "-c", f"import {RIVALS[name][0]}"], capture_output=True, check=False).returncode == 0
