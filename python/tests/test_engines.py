"""Data sets on several processes: with real workers, and with ones that fail on purpose."""

from __future__ import annotations

import os
import random
import shutil
import signal
import subprocess
import sys
import threading
import time
from collections import Counter
from dataclasses import asdict
from pathlib import Path
from typing import Any, Callable, Optional

import photosite as ps
import pytest
from conftest import Command, contents
from photosite._engines import driver, plan
from photosite._engines.driver import Answers, Driver
from photosite._engines.plan import FramePlan, Pace, Plan
from photosite._engines.sample_plan import SamplePlan
from photosite._engines.task import Failure, Job, Outcome, Task

ON_POSIX = pytest.mark.skipif(os.name == "nt", reason="sends signals")


def workers_of(driver: int) -> "list[int]":
    """Worker processes of a driver."""
    # Whole lines, however narrow a terminal is said to be.
    command = ["ps", "-ww", "-eo", "pid,ppid,args"]
    lines = subprocess.run(command, capture_output=True, text=True, check=True).stdout.splitlines()
    fields = [line.split(None, 2) for line in lines[1:]]
    return [int(pid) for pid, parent, what in fields if int(parent) == driver and "_engines.worker" in what]


def lives(pid: int) -> bool:
    try:
        return Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()[0] != "Z"
    except FileNotFoundError:
        return False


def until(condition: Callable[[], object], seconds: float = 60) -> None:
    end = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < end, "it does not come"
        time.sleep(0.005)


@pytest.fixture
def whole(command: Command, file: Path, tmp_path: Path) -> "dict[str, bytes]":
    """What one process makes of the data set."""
    command("dataset", file, "-o", tmp_path / "whole", "-q")
    return contents(tmp_path / "whole")


def test_workers_make_what_one_process_makes(file: Path, tmp_path: Path, whole: "dict[str, bytes]") -> None:
    told: "list[tuple[int, int]]" = []
    dataset = ps.Dataset(file)
    first = dataset.run(tmp_path / "out", workers=2, frames=[3, 1], progress=lambda *now: told.append(now))
    assert (first.made, first.present, first.failed, first.lost_workers) == (2, 0, {}, 0) and first.seconds > 0
    assert told[0] == (0, 2) and told[-1] == (2, 2) and told == sorted(told)
    assert sorted(os.listdir(tmp_path / "out" / "left")) == ["000001", "000003"]
    times = {path: path.stat().st_mtime_ns for path in (tmp_path / "out").rglob("raw.dng")}
    rest = dataset.run(tmp_path / "out", workers=2, threads=1)
    assert (rest.made, rest.present) == (3, 2)
    assert contents(tmp_path / "out") == whole
    assert all(path.stat().st_mtime_ns == time for path, time in times.items()), "nothing is made twice"
    assert not workers_of(os.getpid())
    again = ps.Dataset(file, output=tmp_path / "out").run()
    assert (again.made, again.present) == (0, 5)


def test_changed_keys_reach_the_workers(command: Command, file: Path, tmp_path: Path) -> None:
    command("dataset", file, "-o", tmp_path / "theirs", "-q", "--set", "render.samples_per_pixel=3")
    ps.Dataset(file, set={"render.samples_per_pixel": 3}).run(tmp_path / "ours", workers=1)
    assert contents(tmp_path / "ours") == contents(tmp_path / "theirs")


@ON_POSIX
def test_a_worker_that_is_killed_loses_its_frame_at_most(file: Path, tmp_path: Path) -> None:
    keys = {"render.samples_per_pixel": 300}
    out = tmp_path / "out"
    killed: "list[int]" = []

    def kill() -> None:
        for count in (2, 4):
            until(lambda: len(list(out.glob("[lr]*/[0-9]*"))) >= count)
            worker = workers_of(os.getpid())[0]
            os.kill(worker, signal.SIGKILL)
            killed.append(worker)

    killer = threading.Thread(target=kill)
    killer.start()
    done = ps.Dataset(file, set=keys).run(out, workers=2, threads=1)
    killer.join()
    assert done.made == 5 and done.lost_workers == 2 and len(killed) == 2
    ps.Dataset(file, set=keys, output=tmp_path / "theirs").render()
    assert contents(out) == contents(tmp_path / "theirs")
    assert not list(out.rglob("*.partial")), "nothing of the dead is left"


DRIVER = """
import sys
import photosite as ps
try:
    ps.Dataset(sys.argv[1], set={"render.samples_per_pixel": 300}).run("out", workers=2, threads=1, split=sys.argv[2])
except KeyboardInterrupt:
    print("stopped", flush=True)
"""


@ON_POSIX
@pytest.mark.skipif(not Path("/proc").exists(), reason="looks at processes")
@pytest.mark.parametrize("split", ["frames", "samples"])
@pytest.mark.parametrize("how", [signal.SIGKILL, signal.SIGINT])
def test_a_driver_that_ends_takes_its_workers_along_and_goes_on(
    file: Path, tmp_path: Path, how: signal.Signals, split: str
) -> None:
    out = tmp_path / "out"
    command = [sys.executable, "-c", DRIVER, str(file), split]
    process = subprocess.Popen(command, cwd=tmp_path, stdout=subprocess.PIPE, text=True)
    try:
        until(lambda: len(list(out.glob("[lr]*/[0-9]*"))) >= 2)
        workers = workers_of(process.pid)
        assert len(workers) == 2
        process.send_signal(how)
        output, _ = process.communicate(timeout=30)
    finally:
        process.kill()
    assert output == ("" if how == signal.SIGKILL else "stopped\n")
    until(lambda: not any(map(lives, workers)), 10)
    made = {path: path.stat().st_mtime_ns for path in out.glob("[lr]*/[0-9]*/capture.json")}
    dataset = ps.Dataset(file, set={"render.samples_per_pixel": 300}, output=out)
    done = dataset.run(workers=2, threads=1, split=split)
    assert made and done.present + done.made == 5
    assert all(path.stat().st_mtime_ns == time for path, time in made.items())
    ps.Dataset(file, set={"render.samples_per_pixel": 300}, output=tmp_path / "theirs").render()
    assert contents(out) == contents(tmp_path / "theirs")
    assert not (out / ".photosite-parts").exists()


def test_parts_become_the_pictures_of_one_run(file: Path, tmp_path: Path) -> None:
    keys = {"render.samples_per_pixel": 64}
    told: "list[tuple[int, int]]" = []
    dataset = ps.Dataset(file, set=keys)
    done = dataset.run(tmp_path / "out", workers=2, split="samples", progress=lambda *now: told.append(now))
    assert done.made == 5 and told[-1] == (5 * 64, 5 * 64) and len(told) > 5
    ps.Dataset(file, set=keys, output=tmp_path / "theirs").render()
    assert contents(tmp_path / "out") == contents(tmp_path / "theirs")
    assert not (tmp_path / "out/.photosite-parts").exists(), "parts take much disk"


def test_frames_that_fail_are_told_and_the_others_made(file: Path, tmp_path: Path) -> None:
    file.write_text(file.read_text() + '[[vary]]\nkey = "lens.f_number"\nsweep = [4, -4]\n')
    dataset = ps.Dataset(file)
    with pytest.warns(ps.PhotositeWarning, match="frame 3 is skipped.*lens.f_number"):
        done = dataset.run(tmp_path / "out", workers=2, keep_going=True)
    assert sorted(done.failed) == [2, 3, 4] and "f_number" in done.failed[4] and (done.made, done.present) == (2, 0)
    with pytest.warns(ps.PhotositeWarning), pytest.raises(ps.Error, match="3 frames could not be made") as caught:
        dataset.run(tmp_path / "out", workers=2)
    assert "frame 2: " in str(caught.value) and not caught.value.is_temporary
    assert len((tmp_path / "out/manifest.jsonl").read_text().splitlines()) == 4, "of those that are there"


def test_places_that_cannot_be_used(file: Path, tmp_path: Path) -> None:
    dataset = ps.Dataset(file)
    ps.Dataset(file, set={"render.samples_per_pixel": 1}).run(tmp_path / "other", frames=[0], workers=1)
    before = contents(tmp_path / "other")
    with pytest.raises(ps.InputError, match="contains another data set"):
        dataset.run(tmp_path / "other")
    assert contents(tmp_path / "other") == before
    (tmp_path / "full").mkdir()
    (tmp_path / "full/letter.txt").write_text("dear")
    with pytest.raises(ps.InputError, match="does not contain a data set"):
        dataset.run(tmp_path / "full")
    with pytest.raises(ps.InputError, match="is a file"):
        dataset.run(file)
    with pytest.raises(ps.InputError, match="temporary folder"):
        dataset.run()
    with pytest.raises(ps.InputError, match="output: 's3://bucket/set' is a URL") as caught:
        dataset.run("s3://bucket/set")
    assert caught.value.help and "give a folder" in caught.value.help
    assert not Path("s3:").exists()
    assert os.listdir(tmp_path / "full") == ["letter.txt"]


@pytest.mark.skipif(hasattr(os, "geteuid") and os.geteuid() == 0, reason="root may write everywhere")
def test_a_folder_that_must_not_be_written_to(file: Path, tmp_path: Path) -> None:
    (tmp_path / "out").mkdir(mode=0o500)
    with pytest.raises(PermissionError, match="out"):
        ps.Dataset(file).run(tmp_path / "out")


def test_a_full_disk_ends_the_run_and_damages_nothing(
    file: Path, tmp_path: Path, whole: "dict[str, bytes]", monkeypatch: pytest.MonkeyPatch
) -> None:
    disk = tmp_path / "disk"
    disk.mkdir()
    mount = ["mount", "-t", "tmpfs", "-o", "size=512k", "tmpfs", str(disk)]
    if shutil.which("mount") is None or subprocess.run(mount, capture_output=True, check=False).returncode:
        pytest.skip("only some users may mount a small disk")
    monkeypatch.setattr(plan, "_FIRST_PAUSE_S", 0.01)
    try:
        (disk / "filler").write_bytes(bytes(300_000))
        dataset = ps.Dataset(file)
        with pytest.raises(ps.Error, match="No space left") as caught:
            dataset.run(disk / "out", workers=2, threads=1)
        assert caught.value.is_temporary
        (disk / "filler").unlink()
        for name, bytes_ in contents(disk / "out").items():
            assert bytes_ == whole[name], name
        subprocess.run(["mount", "-o", "remount,size=64m", str(disk)], check=True)
        dataset.run(disk / "out", workers=2, threads=1)
        assert contents(disk / "out") == whole
    finally:
        subprocess.run(["umount", str(disk)], check=True)


def test_a_file_that_is_gone(file: Path, tmp_path: Path) -> None:
    dataset = ps.Dataset(file)
    file.rename(tmp_path / "elsewhere.toml")
    with pytest.raises(FileNotFoundError, match="set.toml"):
        dataset.run(tmp_path / "out", workers=1)


def test_a_file_that_has_changed(file: Path, tmp_path: Path) -> None:
    dataset = ps.Dataset(file)
    file.write_text(file.read_text().replace("seed = 1", "seed = 2"))
    with pytest.raises(ps.InputError, match="contains another data set"):
        dataset.run(tmp_path / "out", workers=1)


def test_workers_that_do_not_start(file: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "executable", shutil.which("false"))
    with pytest.raises(ps.ResourceError, match="workers do not start: the last one ended with status 1"):
        ps.Dataset(file).run(tmp_path / "out", workers=1)


@pytest.mark.parametrize(
    ("arguments", "complaint"),
    [
        ({"split": "pixels"}, "split: expected"),
        ({"workers": 0}, "workers: expected at least 1"),
        ({"threads": 0}, "threads: expected at least 1"),
        ({"retries": -1}, "retries: expected at least 0"),
        ({"frames": [4, 5]}, "frames: there is no frame 5"),
    ],
)
def test_arguments_are_checked(file: Path, tmp_path: Path, arguments: "dict[str, Any]", complaint: str) -> None:
    with pytest.raises(ps.InputError, match=complaint):
        ps.Dataset(file).run(tmp_path / "out", **arguments)
    assert not (tmp_path / "out").exists()


class FakeWorkers:
    """Stand for processes: each ends its tasks at once, as it is told to."""

    def __init__(self, end: "Callable[[Task], Optional[Outcome]]") -> None:
        self.tasks: "list[Task]" = []
        self._end = end

    def __call__(self, job: Job, answers: Answers) -> "FakeWorker":
        return FakeWorker(self, answers)

    def answer(self, task: Task) -> "Optional[dict[str, Any]]":
        self.tasks.append(task)
        outcome = self._end(task)
        return None if outcome is None else asdict(outcome)


class FakeWorker:
    """One of these."""

    def __init__(self, workers: FakeWorkers, answers: Answers) -> None:
        self.task: "Optional[Task]" = None
        self.is_ready = True
        self._workers, self._answers = workers, answers

    def begin(self, task: Task) -> None:
        self.task = task
        self._answers.put((self, self._workers.answer(task)))  # type: ignore[arg-type]

    def why_gone(self) -> str:
        return "was ended by SIGKILL"

    def ask_to_end(self) -> None:
        pass

    def end(self, until: float) -> None:
        pass


def drive(count: int, work: Plan, end: "Callable[[Task], Optional[Outcome]]") -> "list[Task]":
    """The tasks of a plan, as so many workers get them."""
    workers = FakeWorkers(end)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(driver, "WorkerProcess", workers)
        Driver(work, Job("set.toml", [], "out", 1), count, None).run()
    return workers.tasks


def test_tasks_grow_with_the_pace_and_shrink_at_the_end() -> None:
    tasks = drive(4, FramePlan(list(range(2000)), 3), lambda task: Outcome(0.5 * len(task.frames)))
    sizes = [len(task.frames) for task in tasks]
    assert sum(sizes) == 2000 and sizes[:4] == [1] * 4, "nothing is known at first"
    assert max(sizes) == plan.TASK_S / 0.5
    assert sizes[-1] == 1 and len(sizes) < 100
    begun = 0
    for size in sizes:
        assert size <= max(1, -(-(2000 - begun) // 8)), "the others would wait for one that has so many"
        begun += size


def test_tasks_follow_frames_that_become_slow() -> None:
    measured = Pace()
    measured.add(100, 10.0)
    assert measured.units(10_000, 2) == 250
    for _ in range(20):
        measured.add(10, 50.0)
    assert measured.units(10_000, 2) == 5


def test_a_frame_that_takes_its_workers_along_is_given_up() -> None:
    seen: "Counter[int]" = Counter()

    def end(task: Task) -> Optional[Outcome]:
        seen.update(task.frames)
        return None if 7 in task.frames else Outcome(0.01 * len(task.frames))

    work = FramePlan(list(range(40)), 3)
    drive(2, work, end)
    assert list(work.failed) == [7] and "SIGKILL" in work.failed[7]
    assert seen[7] == 4 and set(seen) == set(range(40)) and max(seen[i] for i in range(40) if i != 7) <= 2


def test_what_may_pass_is_tried_again_and_what_does_not_ends_the_run(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(plan, "_FIRST_PAUSE_S", 0.001)
    tries: "Counter[int]" = Counter()

    def full(most: int) -> "Callable[[Task], Outcome]":
        def end(task: Task) -> Outcome:
            tries.update(task.frames)
            failures = [Failure(i, "disk full", True) for i in task.frames if i == 3 and tries[i] <= most]
            return Outcome(0.1, failures)

        return end

    work = FramePlan(list(range(9)), 3)
    drive(2, work, full(3))
    assert tries[3] == 4 and not work.failed and work.progress() == (9, 9)
    tries.clear()
    with pytest.raises(ps.Error, match="frame 3 failed 4 times, at last: disk full") as caught:
        drive(2, FramePlan(list(range(9)), 3), full(9))
    assert caught.value.is_temporary and tries[3] == 4


def test_errors_of_a_worker_end_the_run_unless_they_may_pass(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(plan, "_FIRST_PAUSE_S", 0.001)
    parts: "dict[str, Any]" = {"file": None, "line": None, "key": "", "reason": "no", "help": None}
    answers = [Outcome(error=["FileError", "busy", {**parts, "errno": 16, "is_temporary": True}])]
    work = FramePlan([0, 1], 3)
    drive(1, work, lambda task: answers.pop() if answers else Outcome(0.1))
    assert work.progress() == (2, 2) and not work.failed
    error = Outcome(error=["InputError", "no such key", {**parts, "is_temporary": False}])
    with pytest.raises(ps.InputError, match="no such key"):
        drive(1, FramePlan([0, 1], 3), lambda task: error)
    with pytest.raises(ps.Error, match="a worker failed:\nTraceback"):
        drive(1, FramePlan([0, 1], 3), lambda task: Outcome(fault="Traceback"))


@pytest.mark.parametrize("seed", range(20))
def test_parts_cover_each_sample_once_whatever_was_there(seed: int) -> None:
    luck = random.Random(seed)
    samples = luck.randrange(1, 400)
    ranges = [tuple(sorted(luck.sample(range(samples + 1), 2))) for _ in range(luck.randrange(4))]
    begun: Any = sorted(set(ranges))
    present = {frame: [part for part in begun if luck.random() < 0.5] for frame in range(3)}
    losses = Counter[Any]()

    def end(task: Task) -> Optional[Outcome]:
        key = (task.frames[0], tuple(task.samples or ()))
        if losses[key] < 3 and luck.random() < 0.2:
            losses[key] += 1
            return None
        return Outcome(luck.uniform(0.1, 40))

    work = SamplePlan([0, 1, 2], samples, present, begun, 3)
    tasks = drive(3, work, end)
    assert not work.failed and work.progress() == (3 * samples, 3 * samples)
    merges = {task.frames[0]: task.parts for task in tasks if task.samples is None}
    assert set(merges) == {0, 1, 2}
    traced = {(task.frames[0], *task.samples) for task in tasks if task.samples is not None}
    for frame, parts in merges.items():
        assert parts[0][0] == 0 and parts[-1][1] == samples
        assert all(one[1] == next[0] for one, next in zip(parts, parts[1:])), parts
        for first, end_ in parts:
            assert (first, end_) in present[frame] or (frame, first, end_) in traced
        assert len(parts) <= 2 * 16 + 2 * len(begun) + 1
