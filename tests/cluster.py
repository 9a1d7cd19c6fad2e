#!/usr/bin/env python3
"""Schedulers make a data set while what they run is killed: `python3 tests/cluster.py PROGRAM --engine slurm|openjd`.

slurm: a controller and two nodes of its own run on this machine (Debian's slurm-wlm and munge, as root). `photosite
submit slurm --submit` sends the set; at random moments a photosite is killed (KILL), now and then a whole node with its
job. openjd: `photosite submit openjd` writes the template, which `openjd run` (openjd-cli) runs; at random moments the
photosite is killed, which ends the run, and it is given again.

In the end every file must have the bytes of a run that nobody disturbed, by SHA-256. A kill may cost the picture that the
process was making, and no other: none that was there once may have been made again.
"""

import argparse
import hashlib
import json
import os
import random
import re
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))
from chaos import CAPTURE  # noqa: E402

SET = """\
capture = 'capture.toml'
frames = FRAMES
[[cameras]]
name = 'left'
[[cameras]]
name = 'right'
position_m = [0.05, 0, 0]
[poses.random]
target = 'board'
distance_m = [0.6, 0.9]
margin_px = 1
"""

SLURM_CONF = """\
ClusterName=judge
SlurmctldHost=HOST(127.0.0.1)
SlurmUser=root
SlurmdUser=root
AuthType=auth/munge
AuthInfo=socket=DIR/munge.socket
CredType=cred/munge
MpiDefault=none
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
ReturnToService=2
SlurmdTimeout=4
SlurmctldTimeout=10
MinJobAge=3600
KillWait=2
JobRequeue=1
StateSaveLocation=DIR/state
SlurmdSpoolDir=DIR/spool-%n
SlurmctldPidFile=DIR/slurmctld.pid
SlurmdPidFile=DIR/slurmd-%n.pid
SlurmctldLogFile=DIR/slurmctld.log
SlurmdLogFile=DIR/slurmd-%n.log
SlurmctldPort=PORT0
NodeName=a NodeHostname=HOST NodeAddr=127.0.0.1 Port=PORT1 CPUs=1 RealMemory=2000
NodeName=b NodeHostname=HOST NodeAddr=127.0.0.1 Port=PORT2 CPUs=1 RealMemory=2000
PartitionName=main Nodes=a,b Default=YES MaxTime=60 State=UP
"""


class NotHere(Exception):
    """The machine has not what the engine takes."""


def sums(folder: Path) -> dict[str, str]:
    files = (path for path in folder.rglob("*") if path.is_file())
    return {str(path.relative_to(folder)): hashlib.sha256(path.read_bytes()).hexdigest() for path in files}


def alive(pid: int) -> bool:
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return False
    stat = Path(f"/proc/{pid}/stat")
    return stat.exists() and stat.read_text().rsplit(")", 1)[1].split()[0] != "Z"


class Set:
    """The data set, its reference, and the processes that make it."""

    def __init__(self, options: argparse.Namespace, root: Path):
        self.options, self.root = options, root
        # Names with blanks and quotes are for users to choose.
        self.inputs = root / "in puts"
        self.output = root / "it's out"
        self.inputs.mkdir()
        (self.inputs / "capture.toml").write_text(
            CAPTURE.replace("SAMPLES", str(options.samples)).replace("[64, 48]", "[32, 24]")
        )
        self.file = self.inputs / "stereo set.toml"
        self.file.write_text(SET.replace("FRAMES", str(options.frames)))
        # Tells which photosite are those of this set, and what they say.
        self.begun = root / "begun"
        self.begun.mkdir()
        self.wrapper = root / "photosite judged"
        self.wrapper.write_text(
            f"#!/bin/bash\necho $$ > '{self.begun}'/$$.pid\nexec '{options.program}' \"$@\" 2> >(tee '{self.begun}'/$$.log >&2)\n"
        )
        self.wrapper.chmod(0o755)
        # Which folder each picture was when it was first seen.
        self.seen: dict[str, int] = {}

    def whole(self) -> dict[str, str]:
        folder = self.root / "whole"
        start = time.monotonic()
        command = [self.options.program, "dataset", self.file, "-o", folder, "--quiet", "--threads", "1"]
        subprocess.run(command, check=True)
        self.alone_s = time.monotonic() - start
        return sums(folder)

    def pids(self) -> list[int]:
        pids = [int(path.stem) for path in self.begun.glob("*.pid")]
        return [pid for pid in pids if alive(pid)]

    def at_work(self) -> dict[int, str]:
        """The processes that make a picture at this moment, with its name, as status tells."""
        command = [self.options.program, "status", self.output, "--json"]
        said = subprocess.run(command, capture_output=True, text=True).stdout.splitlines()
        lines = [json.loads(line) for line in said]
        running = [line for line in lines if line.get("state") == "running" and "process" in line]
        return {line["process"]: line["folder"] for line in running if alive(line["process"])}

    def done(self) -> int:
        """How many pictures exist; each is remembered."""
        there = {str(path.relative_to(self.output)): path.stat().st_ino for path in self.output.glob("*/[0-9]*")}
        for name, inode in there.items():
            self.seen.setdefault(name, inode)
        return len(there)

    def made_again(self) -> list[str]:
        self.done()
        return [name for name, inode in self.seen.items() if (self.output / name).stat().st_ino != inode]


def kill_one(set_: Set) -> bool:
    """Kills a photosite while it makes a picture."""
    running = set_.at_work()
    if not running:
        return False
    pid = random.choice(sorted(running))
    try:
        os.kill(pid, signal.SIGKILL)
    except ProcessLookupError:
        return False
    return True


class Moments:
    """Random moments, spread over the pictures of a set: once so many are done, somebody is killed."""

    def __init__(self, count: int, pictures: int):
        self.left = sorted(random.sample(range(1, pictures - 4), count))

    def is_one(self, done: int) -> bool:
        return bool(self.left) and done >= self.left[0]

    def over(self) -> None:
        self.left.pop(0)


def free_ports(count: int) -> list[int]:
    sockets = [socket.create_server(("127.0.0.1", 0)) for _ in range(count)]
    ports = [server.getsockname()[1] for server in sockets]
    for server in sockets:
        server.close()
    return ports


class Slurm:
    """A cluster of its own, which is gone in the end."""

    def __init__(self, root: Path):
        self.root = root / "slurm"
        if os.geteuid() != 0:
            raise NotHere("Slurm's daemons are started as root only")
        for program in ("munged", "slurmctld", "slurmd", "sbatch"):
            if not shutil.which(program, path=os.environ["PATH"] + ":/usr/sbin"):
                raise NotHere(f"{program} is not installed (slurm-wlm, munge)")
        for folder in ("state", "spool-a", "spool-b"):
            (self.root / folder).mkdir(parents=True)
        text = SLURM_CONF.replace("DIR", str(self.root)).replace("HOST", socket.gethostname().split(".")[0])
        for number, port in enumerate(free_ports(3)):
            text = text.replace(f"PORT{number}", str(port))
        self.conf = self.root / "slurm.conf"
        self.conf.write_text(text)
        self.environment = {**os.environ, "SLURM_CONF": str(self.conf), "PATH": os.environ["PATH"] + ":/usr/sbin"}

    def run(self, *words: str, check: bool = True) -> str:
        outcome = subprocess.run(words, env=self.environment, capture_output=True, text=True)
        if check and outcome.returncode:
            raise NotHere(f"{' '.join(words)} ended with {outcome.returncode}: {outcome.stderr}")
        return outcome.stdout

    def start(self) -> None:
        # A key, a socket and files of its own: those in /etc and /run stay as they are.
        key = self.root / "munge.key"
        key.write_bytes(random.randbytes(128))
        key.chmod(0o600)
        self.run(
            "munged", "--force", f"--key-file={key}", f"--socket={self.root}/munge.socket",
            f"--pid-file={self.root}/munged.pid", f"--log-file={self.root}/munged.log",
            f"--seed-file={self.root}/munged.seed",
        )
        self.run("slurmctld", "-c")
        for node in "ab":
            self.start_node(node)
        for _ in range(60):
            states = self.run("sinfo", "-h", "-N", "-o", "%T", check=False).split()
            if states == ["idle", "idle"]:
                return
            time.sleep(0.5)
        raise NotHere(f"the nodes do not come up: {states}")

    def start_node(self, node: str) -> None:
        self.run("slurmd", "-N", node)

    def stop(self) -> None:
        for name in ("slurmd-a", "slurmd-b", "slurmctld", "munged"):
            self.end(name)

    def end(self, name: str, how: int = signal.SIGTERM) -> None:
        path = self.root / f"{name}.pid"
        try:
            pid = int(path.read_text())
            os.kill(pid, how)
        except (FileNotFoundError, ProcessLookupError, ValueError):
            return
        for _ in range(100):
            if not alive(pid):
                return
            time.sleep(0.1)
        os.kill(pid, signal.SIGKILL)

    def states(self) -> dict[str, str]:
        """The state of each job, by its number."""
        lines = self.run("squeue", "-h", "-a", "-t", "all", "-r", "-o", "%A|%T", check=False).split()
        return dict(line.split("|") for line in lines)

    def hurry(self) -> None:
        """Slurm holds a requeued job back for two minutes, for which nobody here waits."""
        for line in self.run("squeue", "-h", "-r", "-t", "pending", "-o", "%A|%r", check=False).split():
            job, reason = line.split("|")
            if reason == "BeginTime":
                self.run("scontrol", "update", f"JobId={job}", "StartTime=now", check=False)

    def kill_node(self, node: str) -> None:
        """As if it had lost its power: the daemon, those that watch its jobs, and the jobs; none tells of another."""
        jobs = [int(folder.name) for folder in Path("/proc").glob("[0-9]*") if node_of(int(folder.name), self.conf) == node]
        watchers = {parent_of(pid) for pid in jobs} - set(jobs)
        self.end(f"slurmd-{node}", signal.SIGKILL)
        for pid in [*watchers - {0, 1}, *jobs]:
            try:
                os.kill(pid, signal.SIGKILL)
            except ProcessLookupError:
                pass


def node_of(pid: int, conf: Path) -> str:
    """The node of the cluster with this file that a process runs on."""
    try:
        entries = Path(f"/proc/{pid}/environ").read_bytes().split(b"\0")
    except OSError:
        return ""
    if f"SLURM_CONF={conf}".encode() not in entries:
        return ""
    names = [entry.split(b"=", 1)[1].decode() for entry in entries if entry.startswith(b"SLURMD_NODENAME=")]
    return names[0] if names else ""


def parent_of(pid: int) -> int:
    try:
        return int(Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()[1])
    except OSError:
        return 0


def by_slurm(set_: Set) -> tuple[int, list[str]]:
    options = set_.options
    slurm = Slurm(set_.root)
    events = []
    try:
        slurm.start()
        command = [
            options.program, "submit", "slurm", set_.file, "-o", set_.output, "--submit", "--json", "--tasks", "6",
            "--threads", "1", "--retries", "20", "--program", set_.wrapper, "--directive=--mem=300M",
        ]
        outcome = subprocess.run(command, env=slurm.environment, cwd=set_.root, capture_output=True, text=True)
        if outcome.returncode:
            sys.exit(f"submit ended with {outcome.returncode}: {outcome.stderr}")
        said = json.loads(outcome.stdout)
        events.append(f"{said['tasks']} tasks as jobs {said['jobs']}")
        last = said["jobs"][1]
        moments = Moments(options.kills, 2 * options.frames)
        nodes = set(random.sample(range(options.kills), 1)) if options.kills > 1 else set()
        kills = 0
        while True:
            if time.monotonic() - options.begun_s > options.limit_s:
                sys.exit(f"not done in {options.limit_s} s: {slurm.states()}, {set_.done()} pictures")
            states = slurm.states()
            if states.get(last) in ("COMPLETED", "FAILED", "CANCELLED"):
                break
            slurm.hurry()
            if moments.is_one(set_.done()):
                if kills in nodes:
                    running = sorted(set_.at_work())
                    if running and (node := node_of(running[0], slurm.conf)):
                        slurm.kill_node(node)
                        events.append(f"node {node} was killed with its job, and started again")
                        slurm.start_node(node)
                        kills += 1
                        moments.over()
                elif kill_one(set_):
                    kills += 1
                    moments.over()
            time.sleep(0.1)
        if states[last] != "COMPLETED":
            sys.exit(f"the last job is {states[last]}: {states}\n" + "\n".join(p.read_text() for p in set_.root.glob("*.log")))
        requeued = sum(int(n) for n in re.findall(r"Restarts=(\d+)", slurm.run("scontrol", "show", "jobs")))
        events.append(f"{requeued} times a job was requeued")
        return kills, events
    finally:
        slurm.stop()
        for pid in set_.pids():
            os.kill(pid, signal.SIGKILL)


def by_openjd(set_: Set) -> tuple[int, list[str]]:
    options = set_.options
    openjd = shutil.which("openjd")
    if not openjd:
        raise NotHere("openjd is not installed (pip install openjd-cli)")
    template = set_.root / "bundle" / "template.json"
    command = [
        options.program, "submit", "openjd", set_.file, "-o", set_.output, "--write", template, "--tasks", "6",
        "--threads", "1", "--program", set_.wrapper, "--quiet",
    ]
    subprocess.run(command, check=True)
    subprocess.run([openjd, "check", template], check=True, stdout=subprocess.DEVNULL)
    moments = Moments(options.kills, 2 * options.frames)
    kills = runs = 0
    while True:
        with open(set_.root / f"openjd-{runs}.log", "wb") as log:
            process = subprocess.Popen([openjd, "run", template], stdout=log, stderr=log, cwd=set_.root)
        runs += 1
        try:
            while process.poll() is None:
                if time.monotonic() - options.begun_s > options.limit_s:
                    sys.exit(f"not done in {options.limit_s} s: {set_.done()} pictures")
                if moments.is_one(set_.done()) and kill_one(set_):
                    kills += 1
                    moments.over()
                time.sleep(0.02)
        finally:
            process.kill()
            process.wait()
        if process.returncode == 0:
            return kills, [f"{runs} runs"]
        if runs > options.kills + 2:
            sys.exit(f"openjd run fails again and again:\n{(set_.root / f'openjd-{runs - 1}.log').read_text()}")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program", type=Path, help="the photosite binary")
    parser.add_argument("--engine", choices=["slurm", "openjd"], required=True)
    parser.add_argument("--frames", type=int, default=60)
    parser.add_argument("--kills", type=int, default=10)
    parser.add_argument("--samples", type=int, default=300, help="samples per pixel: how long a frame takes")
    parser.add_argument("--limit-s", type=float, default=600, help="give up after this time")
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    options.program = options.program.resolve()
    options.begun_s = time.monotonic()
    random.seed(options.seed)
    with tempfile.TemporaryDirectory(prefix="cluster-") as folder:
        set_ = Set(options, Path(folder))
        whole = set_.whole()
        try:
            kills, events = {"slurm": by_slurm, "openjd": by_openjd}[options.engine](set_)
        except NotHere as reason:
            print(f"skipped: {reason}")
            return
        found, again = sums(set_.output), set_.made_again()
        begun = [path.read_text(errors="replace") for path in set_.begun.glob("*.log")]
    spent = time.monotonic() - options.begun_s
    print(
        f"{options.engine}: {options.frames} frames by two cameras, {kills} kills, {len(begun)} times photosite was started, "
        f"{'; '.join(events)}; {spent:.0f} s, of which {set_.alone_s:.0f} s are those of one process alone"
    )
    if kills < options.kills:
        sys.exit(f"only {kills} kills were had: more --samples make frames longer")
    differ = [name for name in sorted(whole.keys() | found.keys()) if whole.get(name) != found.get(name)]
    if again:
        sys.exit(f"{len(again)} pictures that were there have been made again: {', '.join(again[:10])}")
    if differ:
        sys.exit(f"{len(differ)} files differ from those of a run that nobody disturbed: {', '.join(differ[:10])}")
    print(f"all {len(whole)} files have the bytes of a run that nobody disturbed")


if __name__ == "__main__":
    main()
