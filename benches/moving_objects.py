#!/usr/bin/env python3
"""Frames of a data set in which objects move and change their colour: how long each takes after the first.

    cargo build --release && python3 benches/moving_objects.py target/release/photosite

Twenty objects share a mesh of 200,000 triangles. Poses of one object and the colour of a material vary. The geometry
and the hierarchy over it are built for the first frame alone: building a later one may take a twentieth of that.
"""

import json
import math
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path

BANDS, SECTORS, OBJECTS, FRAMES = 200, 500, 20, 20
MOST_PART = 1 / 20
STEPS = ["load_s", "build_s", "trace_s", "expose_s", "develop_s", "write_s"]
CAPTURE = """\
[scene]
environment = "even"
{objects}
[materials.paint]
type = "diffuse"
reflectance = 0.5
[camera]
position_m = [0, 3, 8]
look_at_m = [0, 0, 0]
[sensor]
preset = "generic-cmos-color"
resolution_px = [64, 48]
pixel_pitch_um = [100, 100]
[exposure]
time_s = 0.001
[render]
samples_per_pixel = 1
"""
OBJECT = '[[scene.objects]]\nfile = "ball.obj"\nname = "ball-{i}"\nposition_m = [{x}, 0, {z}]\nscale = 0.4\nmaterial = "paint"\n'
SET = """\
capture = "base.toml"
frames = {frames}
[[vary]]
key = "scene.objects.ball-0.position_m"
box = [[-2, 0, -2], [2, 0.5, 2]]
[[vary]]
key = "materials.paint.reflectance"
uniform = [0.1, 0.9]
"""


def ball():
    """A sphere as OBJ."""
    lines = []
    for band in range(BANDS + 1):
        angle = math.pi * band / BANDS
        for sector in range(SECTORS):
            turn = 2 * math.pi * sector / SECTORS
            x, z = math.sin(angle) * math.cos(turn), math.sin(angle) * math.sin(turn)
            lines.append(f"v {x:.6f} {math.cos(angle):.6f} {z:.6f}")
    for band in range(BANDS):
        for sector in range(SECTORS):
            a, b = band * SECTORS + sector + 1, band * SECTORS + (sector + 1) % SECTORS + 1
            lines += [f"f {a} {b} {a + SECTORS}", f"f {b} {b + SECTORS} {a + SECTORS}"]
    return "\n".join(lines) + "\n"


def main():
    program = Path(sys.argv[1]).resolve()
    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder)
        (folder / "ball.obj").write_text(ball())
        objects = "".join(OBJECT.format(i=i, x=i % 5 - 2, z=i // 5 - 2) for i in range(OBJECTS))
        (folder / "base.toml").write_text(CAPTURE.format(objects=objects))
        (folder / "set.toml").write_text(SET.format(frames=FRAMES))
        command = [program, "dataset", "set.toml", "-o", "out", "--threads", "1", "--jobs", "1", "--json", "--quiet"]
        lines = subprocess.run(command, cwd=folder, check=True, stdout=subprocess.PIPE, text=True).stdout.splitlines()
    first, *later = [json.loads(line)["steps"] for line in lines if '"picture"' in line]
    print("| step | first frame, ms | later frames, ms, median |\n|---|---|---|")
    for step in STEPS:
        print(f"| {step[:-2]} | {1e3 * first[step]:.1f} | {1e3 * statistics.median(s[step] for s in later):.2f} |")
    part = statistics.median(s["build_s"] for s in later) / first["build_s"]
    print(f"\nBuilding a later frame takes {part:.4f} of what the first takes; at most {MOST_PART} is the goal.")
    sys.exit(part > MOST_PART)


if __name__ == "__main__":
    main()
