#!/usr/bin/env python3
"""Ten thousand small frames by four workers of this machine: time, memory, disk, and where the time of a frame goes.

    cargo build --release && pip install . && python3 benches/many_frames.py target/release/photosite

The set is made by `Dataset.run` in a process of its own. Meanwhile the memory of its workers is looked
at; in the end all images must be there, every file must have the sum that the manifest states, no worker may have
grown by more than a twentieth since frame 500, a frame may take 15 ms of processor time, and the disk that is taken may be a tenth off what
`--dry-run` has told.
"""

import argparse
import json
import os
import shutil
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
CORNELL_BOX = ROOT / "scenes" / "cornell-box"
SET = """\
capture = "{capture}"
frames = {frames}
set = ["sensor.resolution_px=[64, 64]", "render.samples_per_pixel=1", "output.truth=['depth']"]

[poses.random]
look_at_m = [0.278, 0.273, 0.2]
distance_m = [0.9, 1.1]

[[vary]]
key = "exposure.time_s"
log_uniform = [0.002, 0.01]
"""
RUN = """\
import sys, photosite as ps
ps.Dataset(sys.argv[1]).run(sys.argv[2], workers=int(sys.argv[3]), threads=1, progress=False)
"""
#: Frames after which nothing is new to a worker.
WARM = 500
#: Processor time of a frame.
MOST_CPU_MS = 15.0
STEPS = ["load_s", "build_s", "trace_s", "expose_s", "develop_s", "write_s"]


def where_the_time_goes(program, file, place, frames):
    """Steps of frames after the first, one by one on one thread."""
    command = [program, "dataset", file, "-o", place, "--frames", f"0..{frames}", "--threads", "1", "--jobs", "1", "--json"]
    begun, used = time.monotonic(), os.times()
    lines = subprocess.run(command, check=True, capture_output=True, text=True).stdout.splitlines()
    now = os.times()
    wall_ms = 1e3 * (time.monotonic() - begun) / frames
    cpu_ms = 1e3 * (now.children_user + now.children_system - used.children_user - used.children_system) / frames
    pictures = [json.loads(line) for line in lines[:-1]][1:]
    medians = {step: 1e3 * statistics.median(picture["steps"][step] for picture in pictures) for step in STEPS}
    whole = 1e3 * statistics.median(picture["seconds"] for picture in pictures)
    print("| step | ms, median |\n|---|---|")
    for step, ms in medians.items():
        print(f"| {step.removesuffix('_s')} | {ms:.2f} |")
    print(f"| until it is on the disk | {whole - sum(medians.values()):.2f} |")
    print(f"\n{frames} frames on one thread: {cpu_ms:.1f} ms of processor time and {wall_ms:.1f} ms a frame, with the start of the "
          "program; bringing a frame to the disk takes a thread of its own, beside the next frame.\n")
    return cpu_ms


def resident_bytes(process):
    """Memory that a process holds, None of one that has ended."""
    try:
        pages = Path(f"/proc/{process}/statm").read_text(encoding="utf-8").split()[1]
    except (OSError, IndexError):
        return None
    return int(pages) * os.sysconf("SC_PAGE_SIZE")


def children_of(process):
    try:
        return [int(child) for child in Path(f"/proc/{process}/task/{process}/children").read_text(encoding="utf-8").split()]
    except OSError:
        return []


def watched_run(file, place, workers, frames):
    """Makes the set; the memory of each worker when WARM frames were there, its least and its most from then on."""
    run = subprocess.Popen([sys.executable, "-c", RUN, file, place, str(workers)])
    memory = {}
    pictures = Path(place) / "camera"
    while run.poll() is None:
        time.sleep(1)
        done = sum(1 for name in os.listdir(pictures) if not name.startswith(".")) if pictures.exists() else 0
        if WARM <= done < frames:
            for child in children_of(run.pid):
                # One that is about to end holds nothing.
                if (now := resident_bytes(child)):
                    first, least, most = memory.get(child, (now, now, now))
                    memory[child] = first, min(least, now), max(most, now)
    if run.returncode:
        sys.exit(f"the run ended with {run.returncode}")
    return memory


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program")
    parser.add_argument("--frames", type=int, default=10_000)
    parser.add_argument("--workers", type=int, default=4)
    parser.add_argument("--folder", help="where to make it; without, a temporary folder")
    args = parser.parse_args()
    program = str(Path(args.program).resolve())
    with tempfile.TemporaryDirectory(dir=args.folder) as folder:
        shutil.copytree(CORNELL_BOX, Path(folder) / "scene")
        file = str(Path(folder) / "set.toml")
        Path(file).write_text(SET.format(capture="scene/capture.toml", frames=args.frames), encoding="utf-8")
        cpu_ms = where_the_time_goes(program, file, str(Path(folder) / "few"), min(args.frames, 300))
        place = str(Path(folder) / "set")
        told = subprocess.run(
            [program, "dataset", file, "-o", place, "--dry-run", "--json"], check=True, capture_output=True, text=True
        )
        predicted = json.loads(told.stdout)["disk_bytes"]
        begun = time.monotonic()
        memory = watched_run(file, place, args.workers, args.frames)
        seconds = time.monotonic() - begun
        # Reads every file.
        subprocess.run([program, "dataset", file, "-o", place, "--index-only", "--verify", "-q"], check=True)
        lines = [json.loads(line) for line in (Path(place) / "manifest.jsonl").read_text(encoding="utf-8").splitlines()]
        names = {line["folder"] for line in lines}
        complete = len(lines) == len(names) == args.frames
        taken = sum(file.stat().st_size for file in (Path(place) / "camera").rglob("*") if file.is_file())
        grown = max(most / first for first, _, most in memory.values()) - 1
        shrunk = 1 - min(least / first for first, least, _ in memory.values())
        most = max(most for _, _, most in memory.values())
        print(f"{args.frames} frames of 64 × 64 pixels by {args.workers} workers in {seconds:.0f} s: "
              f"{1e3 * seconds / args.frames:.1f} ms a frame, {'complete' if complete else 'NOT COMPLETE'}, every sum as the manifest has it.")
        print(f"A worker holds at most {most / 2**20:.0f} MiB; from frame {WARM} to the end +{100 * grown:.1f} % and −{100 * shrunk:.1f} %.")
        print(f"Disk: {taken / 1e6:.1f} MB, predicted {predicted / 1e6:.1f} MB ({100 * (predicted / taken - 1):+.1f} %).")
        goals = cpu_ms <= MOST_CPU_MS and complete and len(memory) >= args.workers and max(grown, shrunk) <= 0.05 and abs(predicted / taken - 1) <= 0.1
        print("\nGoals reached." if goals else "\nGOALS NOT REACHED.")
        return 0 if goals else 1


if __name__ == "__main__":
    sys.exit(main())
