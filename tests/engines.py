#!/usr/bin/env python3
"""Workers that are killed make one data set: `python3 tests/engines.py PROGRAM`.

The Python package must be there. A driver of its own process makes a stereo set on four workers (Dataset.run). At random
moments a worker that is at work gets SIGKILL, and once the driver, which is started again. In the end

- every file has the bytes of a run of PROGRAM in one process, and there is no other file;
- of images that were begun, as the system tells of their folders, for each killed worker at most those of one frame
  are begun twice;
- no process is left, those of a killed driver included.
"""

import argparse
import ctypes
import hashlib
import os
import random
import re
import signal
import struct
import subprocess
import sys
import tempfile
import threading
import time
import uuid
from pathlib import Path
from typing import Callable

from chaos import CAPTURE

SET = """\
capture = 'capture.toml'
frames = FRAMES
[[cameras]]
name = 'left'
[[cameras]]
name = 'right'
position_m = [0.05, 0, 0]
look_at_m = [0.05, 0, -1]
[poses.random]
target = 'board'
distance_m = [0.6, 0.9]
margin_px = 1
"""
DRIVER = """\
import sys
import photosite as ps
if __name__ == "__main__":
    print(ps.Dataset("set.toml").run("out", workers=4, threads=1, split=sys.argv[1], progress=False))
"""
WORKERS = 4
CAMERAS = ("left", "right")
#: In the environment of all processes of this run.
MARK = f"PHOTOSITE_ENGINES_TEST={uuid.uuid4()}"


def marked() -> "dict[int, tuple[int, str]]":
    """Parents and commands of the processes of this run that live, without this one."""
    found = {}
    for entry in Path("/proc").iterdir():
        try:
            if entry.name.isdigit() and MARK.encode() in (entry / "environ").read_bytes().split(b"\0"):
                stat = (entry / "stat").read_text().rsplit(")", 1)[1].split()
                if stat[0] != "Z":
                    command = (entry / "cmdline").read_bytes().replace(b"\0", b" ").decode(errors="replace")
                    found[int(entry.name)] = int(stat[1]), command
        except OSError:
            pass
    found.pop(os.getpid(), None)
    return found


class Begun:
    """Counts the folders in which images are begun, CAMERA/.NUMBER.XXXXXX.partial, with inotify."""

    def __init__(self, folder: Path) -> None:
        self.names: "list[str]" = []
        libc = ctypes.CDLL(None, use_errno=True)
        self._file = libc.inotify_init1(0)
        for camera in CAMERAS:
            created = 0x100
            if libc.inotify_add_watch(self._file, os.fsencode(folder / camera), created) < 0:
                raise OSError(ctypes.get_errno(), f"cannot watch {folder / camera}")
        threading.Thread(target=self._listen, daemon=True).start()

    def _listen(self) -> None:
        while True:
            events, at = os.read(self._file, 1 << 16), 0
            while at < len(events):
                camera, mask, _, length = struct.unpack_from("iIII", events, at)
                name = events[at + 16 : at + 16 + length].rstrip(b"\0").decode()
                if mask & 0x4000:
                    raise SystemExit("inotify lost events")
                if re.fullmatch(r"\.\d+\.\w+\.partial", name):
                    self.names.append(f"{camera}/{name}")
                at += 16 + length


def workers_of(driver: int) -> "list[int]":
    return [pid for pid, (parent, what) in marked().items() if parent == driver and "_engines.worker" in what]


class Test:
    def __init__(self, options: argparse.Namespace, folder: Path) -> None:
        self.options, self.folder, self.output = options, folder, folder / "out"
        self.drivers = 0

    def start(self) -> "subprocess.Popen[bytes]":
        self.drivers += 1
        with open(self.folder / f"driver-{self.drivers}.log", "wb") as log:
            command = [sys.executable, "driver.py", self.options.split]
            return subprocess.Popen(command, cwd=self.folder, stdout=log, stderr=subprocess.STDOUT)

    def done(self) -> int:
        return sum(name.isdigit() for camera in CAMERAS for name in os.listdir(self.output / camera))

    def wait(self, driver: "subprocess.Popen[bytes]", until: Callable[[], bool], what: str) -> None:
        begun = time.monotonic()
        while not until():
            if driver.poll() is not None:
                sys.exit(f"the driver ended with {driver.returncode} before {what}:\n{self.log()}")
            if time.monotonic() - begun > self.options.limit_s:
                sys.exit(f"no {what} in {self.options.limit_s} s:\n{self.log()}")
            time.sleep(0.005)

    def log(self) -> str:
        return (self.folder / f"driver-{self.drivers}.log").read_text(errors="replace")

    def disturb(self) -> None:
        """Kills workers, and the driver in between, each when so many images exist."""
        pictures = self.options.frames * len(CAMERAS)
        # Some moments before the end: whoever is killed is to be at work.
        moments = sorted(random.sample(range(2, pictures - 3 * WORKERS), self.options.kills + 1))
        of_driver = random.choice(moments[2:-2])
        driver = self.start()
        try:
            for moment in moments:
                self.wait(driver, lambda: self.done() >= moment, f"image {moment}")
                time.sleep(random.uniform(0, 0.2))
                if moment == of_driver:
                    self.kill_driver(driver)
                    driver = self.start()
                    continue
                self.wait(driver, lambda: bool(workers_of(driver.pid)), "worker")
                worker = random.choice(workers_of(driver.pid))
                print(f"image {self.done()}: SIGKILL to worker {worker}", flush=True)
                os.kill(worker, signal.SIGKILL)
            status = driver.wait(self.options.limit_s)
        finally:
            driver.kill()
            driver.wait()
        if status:
            sys.exit(f"the driver ended with {status}:\n{self.log()}")
        print(self.log(), end="")

    def kill_driver(self, driver: "subprocess.Popen[bytes]") -> None:
        workers = workers_of(driver.pid)
        print(f"image {self.done()}: SIGKILL to the driver", flush=True)
        driver.kill()
        driver.wait()
        gone(lambda: {pid: what for pid, what in marked().items() if pid in workers}, "workers outlive the driver")


def gone(left: Callable[[], "dict[int, tuple[int, str]]"], complaint: str) -> None:
    until = time.monotonic() + 10
    while left():
        if time.monotonic() > until:
            sys.exit(f"{complaint}: {left()}")
        time.sleep(0.05)


def sums(folder: Path) -> "dict[str, str]":
    files = (path for path in folder.rglob("*") if path.is_file())
    return {str(path.relative_to(folder)): hashlib.sha256(path.read_bytes()).hexdigest() for path in files}


def dataset(program: Path, folder: Path, output: str, *more: str) -> None:
    command = [str(program), "dataset", "set.toml", "-o", output, "--quiet", *more]
    subprocess.run(command, cwd=folder, check=True)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program", type=Path, help="the photosite binary")
    parser.add_argument("--split", choices=["frames", "samples"], default="frames")
    parser.add_argument("--frames", type=int, default=60)
    parser.add_argument("--kills", type=int, default=10)
    parser.add_argument("--samples", type=int, default=125, help="samples per pixel: how long a frame takes")
    parser.add_argument("--seed", type=int, default=34)
    parser.add_argument("--limit-s", type=float, default=120, help="longest wait for an image")
    options = parser.parse_args()
    options.program = options.program.resolve()
    random.seed(options.seed)
    name, value = MARK.split("=")
    os.environ[name] = value
    begun = time.monotonic()
    with tempfile.TemporaryDirectory(prefix="engines-") as place:
        folder = Path(place)
        (folder / "capture.toml").write_text(CAPTURE.replace("SAMPLES", str(options.samples)))
        (folder / "set.toml").write_text(SET.replace("FRAMES", str(options.frames)))
        (folder / "driver.py").write_text(DRIVER)
        dataset(options.program, folder, "whole")
        whole_s = time.monotonic() - begun
        # Frames that there are not: the folder is made, and nothing in it.
        dataset(options.program, folder, "out", "--frames", str(options.frames))
        pictures = Begun(folder / "out")
        Test(options, folder).disturb()
        whole, found = sums(folder / "whole"), sums(folder / "out")
        gone(marked, "processes are left")
    differ = [name for name in sorted(whole.keys() | found.keys()) if whole.get(name) != found.get(name)]
    if differ:
        sys.exit(f"{len(differ)} files differ from those of one process: {', '.join(differ[:10])}")
    all_s = f"{time.monotonic() - begun:.0f} s, of which {whole_s:.0f} for one process"
    killed = f"{options.kills} workers and the driver killed; all {len(whole)} files have the bytes of one process"
    if options.split == "samples":
        print(f"by samples: {killed}; {all_s}")
        return
    twice = len(pictures.names) - options.frames * len(CAMERAS)
    # With the driver each of its workers may die.
    most = (options.kills + WORKERS) * len(CAMERAS)
    print(f"{killed}; {twice} images were begun twice, at most {most} may be; {all_s}")
    if not 0 < twice <= most:
        sys.exit("no kill hit an image under way" if twice <= 0 else "more was made twice than was under way")


if __name__ == "__main__":
    main()
