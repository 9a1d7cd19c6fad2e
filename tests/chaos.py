#!/usr/bin/env python3
"""Workers that are killed at random make a data set together: `python3 tests/chaos.py PROGRAM [options]`.

Some processes get the same command for the same folder. Each is killed (KILL), asked to end (TERM) or held on for a
while (STOP, CONT) at random moments, and started again; now and then the disk is full (a small tmpfs, where the user
may mount one). When all kills are done and the set is complete, every file must have the bytes of a run that nobody
disturbed, and nothing else may be left. A worker must end with a status that fits what was done to it.
"""

import argparse
import errno
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass, field
from pathlib import Path

CAPTURE = """\
[scene]
environment = { illuminant = 'D65', illuminance_lux = 500 }
[[targets]]
type = 'chessboard'
name = 'board'
squares = [9, 6]
square_mm = 30
[camera]
position_m = [0, 0, 0.6]
look_at_m = [0, 0, 0]
[lens]
type = 'pinhole'
f_number = 4
focal_length_mm = 6
focus_distance_m = 'infinity'
[sensor]
preset = 'sony-imx249-mono'
resolution_px = [64, 48]
pixel_pitch_um = [100, 100]
[exposure]
time_s = 0.004
[render]
samples_per_pixel = SAMPLES
max_depth = 3
[output]
checkpoint_interval_s = 0.01
"""
SET = "capture = 'capture.toml'\nframes = FRAMES\n[poses.random]\ntarget = 'board'\ndistance_m = [0.6, 0.9]\nmargin_px = 1\n"

# Statuses of a worker by what was done to it; beside these, 0 and 75 (another try) are always right.
KILLED, ENDED, DISK_FULL = -signal.SIGKILL, 143, 1


@dataclass
class Worker:
    process: subprocess.Popen
    log: Path
    stopped_until: float = 0.0
    was_ended: bool = False
    was_ended_at_start: bool = False
    saw_full_disk: bool = False


@dataclass
class Counts:
    kills: int = 0
    ends: int = 0
    holds: int = 0
    full_disks: int = 0
    statuses: dict = field(default_factory=dict)


def command(program: Path, output: Path) -> list[str]:
    return [str(program), "dataset", "set.toml", "-o", str(output), "--quiet", "--threads", "1"]


def contents(folder: Path) -> dict[str, bytes]:
    return {str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def listens(process: subprocess.Popen) -> bool:
    """Whether a process catches SIGTERM yet: in its first milliseconds, the signal itself ends it."""
    try:
        status = Path(f"/proc/{process.pid}/status").read_text()
    except FileNotFoundError:
        return True
    caught = next(line for line in status.splitlines() if line.startswith("SigCgt:")).split()[1]
    return bool(int(caught, 16) >> (signal.SIGTERM - 1) & 1)


def mounted(folder: Path, mib: int) -> bool:
    """Whether a small disk of its own is there now; only some users may mount one."""
    mount = ["mount", "-t", "tmpfs", "-o", f"size={mib}m", "tmpfs", str(folder)]
    return subprocess.run(mount, capture_output=True).returncode == 0


def fill(disk: Path) -> Path:
    """Leaves some hundred kilobytes at most, or nothing where workers write meanwhile."""
    path = disk / "filler"
    free = shutil.disk_usage(disk).free
    try:
        with open(path, "wb") as file:
            file.write(b"\0" * max(0, free - random.randrange(1, 300_000)))
    except OSError as error:
        if error.errno != errno.ENOSPC:
            raise
    return path


def disturb(options: argparse.Namespace, inputs: Path, disk: Path, is_small: bool) -> Counts:
    """Starts workers again and again until so many were killed; ends them all, and leaves the set as it is."""
    workers: list[Worker] = []
    try:
        return disturbed(options, inputs, disk, is_small, workers)
    finally:
        for worker in workers:
            worker.process.kill()
            worker.process.wait()


def disturbed(options: argparse.Namespace, inputs: Path, disk: Path, is_small: bool, workers: list[Worker]) -> Counts:
    output = disk / "out"
    counts, faults = Counts(), []
    filler, filled_until, next_fill = None, 0.0, time.monotonic() + 2.0

    def start(number: int) -> Worker:
        log = inputs / f"worker-{number}.log"
        with open(log, "wb") as to:
            process = subprocess.Popen(command(options.program, output), cwd=inputs, stderr=to, stdin=subprocess.DEVNULL)
        return Worker(process, log, saw_full_disk=filler is not None)

    def ended(worker: Worker) -> None:
        status = worker.process.returncode
        counts.statuses[status] = counts.statuses.get(status, 0) + 1
        text = worker.log.read_text(errors="replace")
        right = {0, 75, KILLED} | ({ENDED} if worker.was_ended else set())
        if worker.was_ended_at_start:
            right.add(-signal.SIGTERM)
        if worker.saw_full_disk and "No space left on device" in text:
            right.add(DISK_FULL)
        if status not in right or "panicked" in text:
            faults.append(f"a worker ended with {status}:\n{text}")

    started = 0
    begin = time.monotonic()
    while counts.kills < options.kills and not faults:
        if time.monotonic() - begin > options.limit_s:
            sys.exit(f"only {counts.kills} kills in {options.limit_s} s")
        while len(workers) < options.workers:
            workers.append(start(started))
            started += 1
        time.sleep(random.expovariate(1 / options.pause_s))
        now = time.monotonic()
        if filler and now > filled_until:
            filler.unlink()
            filler, next_fill = None, now + random.uniform(1.0, 3.0)
        elif is_small and not filler and now > next_fill:
            filler, filled_until = fill(disk), now + random.uniform(0.05, 0.5)
            counts.full_disks += 1
            for worker in workers:
                worker.saw_full_disk = True
        for worker in workers:
            if worker.stopped_until and now > worker.stopped_until:
                worker.process.send_signal(signal.SIGCONT)
                worker.stopped_until = 0.0
        worker = random.choice(workers)
        match random.choices(["kill", "end", "hold"], [6, 2, 2])[0]:
            case "kill" if worker.process.poll() is None:
                worker.process.kill()
                counts.kills += 1
            case "end" if worker.process.poll() is None:
                worker.was_ended_at_start |= not listens(worker.process)
                worker.process.terminate()
                worker.was_ended = True
                counts.ends += 1
            case "hold" if worker.process.poll() is None and not worker.stopped_until:
                worker.process.send_signal(signal.SIGSTOP)
                worker.stopped_until = now + random.uniform(0.05, 0.5)
                counts.holds += 1
        for worker in [worker for worker in workers if worker.process.poll() is not None]:
            workers.remove(worker)
            ended(worker)
        done = len(list(output.glob("camera/[0-9]*")))
        if done == options.frames and counts.kills < options.kills:
            # There is nothing left to disturb: some images lose a file, some go.
            for number in random.sample(range(options.frames), options.frames // 2):
                picture = output / "camera" / f"{number:06}"
                try:
                    random.choice(list(picture.iterdir())).unlink()
                except (FileNotFoundError, IndexError):
                    pass
    if filler:
        filler.unlink()
    if faults:
        sys.exit(faults[0])
    return counts


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program", type=Path, help="the photosite binary")
    parser.add_argument("--workers", type=int, default=8)
    parser.add_argument("--frames", type=int, default=200)
    parser.add_argument("--kills", type=int, default=1000)
    parser.add_argument("--samples", type=int, default=4000, help="samples per pixel: how long a frame takes")
    parser.add_argument("--pause-s", type=float, default=0.05, help="mean time between two disturbances")
    parser.add_argument("--limit-s", type=float, default=3600, help="give up after this time")
    parser.add_argument("--seed", type=int, default=None)
    options = parser.parse_args()
    options.program = options.program.resolve()
    seed = options.seed if options.seed is not None else random.randrange(1 << 32)
    random.seed(seed)
    print(f"seed {seed}", flush=True)
    with tempfile.TemporaryDirectory(prefix="chaos-") as folder:
        inputs, disk = Path(folder) / "in", Path(folder) / "disk"
        inputs.mkdir()
        disk.mkdir()
        (inputs / "capture.toml").write_text(CAPTURE.replace("SAMPLES", str(options.samples)))
        (inputs / "set.toml").write_text(SET.replace("FRAMES", str(options.frames)))
        subprocess.run(command(options.program, inputs / "whole"), cwd=inputs, check=True)
        whole = contents(inputs / "whole")
        # Room for the set, for an image of each worker, and little more
        mib = 4 + 2 * sum(map(len, whole.values())) // (1 << 20)
        is_small = mounted(disk, mib)
        try:
            counts = disturb(options, inputs, disk, is_small)
            last = subprocess.run(command(options.program, disk / "out"), cwd=inputs)
            if last.returncode:
                sys.exit(f"the last run ended with {last.returncode}")
            found = contents(disk / "out")
        finally:
            if is_small:
                subprocess.run(["umount", str(disk)], check=True)
    differ = [name for name in sorted(whole.keys() | found.keys()) if whole.get(name) != found.get(name)]
    print(
        f"{options.frames} frames by {options.workers} workers: {counts.kills} kills, {counts.ends} asked to end, "
        f"{counts.holds} held on, {counts.full_disks} times a full disk{'' if is_small else ' (no tmpfs here)'}; "
        f"statuses {dict(sorted(counts.statuses.items()))}"
    )
    if differ:
        sys.exit(f"{len(differ)} files differ from those of a run that nobody disturbed: {', '.join(differ[:10])}")
    print(f"all {len(whole)} files have the bytes of a run that nobody disturbed")


if __name__ == "__main__":
    main()
