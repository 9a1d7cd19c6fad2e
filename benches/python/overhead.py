"""What Python costs over the command, what a call costs, and how much memory a large raw image takes.

    cargo build --release && pip install . && python benches/python/overhead.py target/release/photosite

Times are of pairs, one after the other, so that a busy machine slows down both; medians are printed.
"""

from __future__ import annotations

import argparse
import json
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

import photosite as ps

CORNELL_BOX = Path(__file__).parents[2] / "scenes/cornell-box/capture.toml"


def timed(work: object) -> float:
    begun = time.perf_counter()
    work()  # type: ignore[operator]
    return time.perf_counter() - begun


def cornell_box(binary: str, pairs: int, samples: int) -> None:
    """A render with all its files, by the command and in a Python process that is there already."""
    samples_of = f"render.samples_per_pixel={samples}"
    with tempfile.TemporaryDirectory() as folder:
        place = Path(folder)

        def command() -> None:
            arguments = ["render", str(CORNELL_BOX), "-q", "--force", "-o", str(place / "command"), "--set", samples_of]
            subprocess.run([binary, *arguments], check=True)

        def python() -> None:
            ps.trace(ps.load(CORNELL_BOX), samples=samples, progress=False).expose().save(place / "python", overwrite=True)

        command(), python()
        ratios, seconds = [], []
        for _ in range(pairs):
            seconds.append((timed(command), timed(python)))
            ratios.append(seconds[-1][1] / seconds[-1][0])
        medians = [statistics.median(of) for of in zip(*seconds)]
        print(f"Cornell box, {samples} samples: command {medians[0]:.3f} s, Python {medians[1]:.3f} s, "
              f"ratio {statistics.median(ratios):.3f} (median of {pairs} pairs)")


def calls() -> None:
    """Calls on an image of few pixels, whose time is that of the call."""
    small = ps.load(CORNELL_BOX, set={"sensor.resolution_px": [8, 8], "render.samples_per_pixel": 1})
    light = ps.trace(small)
    shot = light.expose()
    raw = shot.raw
    sensor = ps.Sensor("sony-imx249-color")
    cube, nm = np.full((8, 8, 31), 1e-3, np.float32), np.arange(400.0, 701.0, 10.0)
    for name, call in [
        ("trace", lambda: ps.trace(small)),
        ("Light.expose", lambda: light.expose()),
        ("Light.expose(time_s=)", lambda: light.expose(time_s=0.01)),
        ("Sensor.expose", lambda: sensor.expose(cube, wavelengths_nm=nm, time_s=0.01, illuminant="D65")),
        ("develop", lambda: ps.develop(raw)),
        ("np.asarray(raw)", lambda: np.asarray(raw)),
        ("load", lambda: ps.load(CORNELL_BOX)),
    ]:
        call()
        times = [timed(call) for _ in range(50)]
        print(f"{name}: {1e3 * statistics.median(times):.2f} ms")


def large_raw() -> None:
    """Peak memory of a process before and after NumPy sees a raw image of 24 MP."""
    code = """
import json, resource, numpy as np, photosite as ps, sys
sensor = ps.Sensor("sony-imx249-mono")
shot = sensor.expose(np.full((4000, 6000), 1000, np.float32), unit="electrons", time_s=0.01, illuminant="D65")
raw = shot.raw
def now():
    return int(open("/proc/self/statm").read().split()[1]) * resource.getpagesize() / 2**20
before = now()
array = np.asarray(raw)
total = int(array.sum(dtype=np.uint64))
after = now()
again = np.asarray(shot.raw)
print(json.dumps([array.nbytes / 2**20, before, after, bool(np.shares_memory(array, again)), bool(array.flags.owndata)]))
"""
    done = subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True)
    size, before, after, shares, owns = json.loads(done.stdout)
    print(f"24 MP raw of {size:.0f} MiB: {before:.0f} MiB before NumPy sees it, {after:.0f} MiB after; "
          f"two arrays share memory: {shares}; the array owns its memory: {owns}")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("binary", help="the command, built with --release")
    parser.add_argument("--pairs", type=int, default=9)
    parser.add_argument("--samples", type=int, default=64)
    options = parser.parse_args()
    cornell_box(options.binary, options.pairs, options.samples)
    calls()
    large_raw()
