"""The driver of a run: gives tasks to processes of this machine, and starts those anew that die."""

from __future__ import annotations

import json
import os
import queue
import signal
import subprocess
import sys
import threading
import time
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any, Callable, Optional

from .._errors import Error, ResourceError, make, warn_all
from .plan import Plan
from .task import Failure, Job, Outcome, Task

__all__ = ["Driver"]

#: Between two looks at pauses that are over.
_LOOK_S = 0.5
#: What a worker gets to keep a checkpoint of the image under way.
_GRACE_S = 5.0
#: Workers that end before they have begun.
_MOST_STILLBORN = 3

#: A worker's answers; None when it is gone.
Answers = queue.Queue[tuple["WorkerProcess", Optional[dict[str, Any]]]]


class WorkerProcess:
    """A process, and the task that it is at."""

    def __init__(self, job: Job, answers: Answers) -> None:
        package = str(Path(__file__).resolve().parents[2])
        paths = [package, *filter(None, [os.environ.get("PYTHONPATH")])]
        # Ctrl-C in a terminal is for the driver, which ends its workers.
        self._process = subprocess.Popen(
            [sys.executable, "-m", "photosite._engines.worker"],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            env={**os.environ, "PYTHONPATH": os.pathsep.join(paths)},
            start_new_session=True,
        )
        self.is_ready = False
        self.task: Optional[Task] = None
        self._answers = answers
        threading.Thread(target=self._listen, daemon=True).start()
        self._send(asdict(job))

    def begin(self, task: Task) -> None:
        """Gives it a task."""
        self.task = task
        self._send(asdict(task))

    def why_gone(self) -> str:
        """How it ended."""
        status = self._process.wait()
        return f"was ended by {_signal(-status)}" if status < 0 else f"ended with status {status}"

    def ask_to_end(self) -> None:
        """Interrupts what is under way; without a task it ends when nothing more can come."""
        if self.task is not None and os.name != "nt":
            self._process.send_signal(signal.SIGINT)
        elif self._process.stdin is not None:
            self._process.stdin.close()

    def end(self, until: float) -> None:
        """Waits for its end up to a moment, then kills it."""
        try:
            self._process.wait(max(0.0, until - time.monotonic()))
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()

    def _listen(self) -> None:
        assert self._process.stdout is not None
        for line in self._process.stdout:
            # One that is killed may leave half a line.
            if line.endswith(b"\n"):
                self._answers.put((self, json.loads(line)))
        self._answers.put((self, None))

    def _send(self, values: "dict[str, Any]") -> None:
        assert self._process.stdin is not None
        try:
            self._process.stdin.write(json.dumps(values).encode() + b"\n")
            self._process.stdin.flush()
        except OSError:
            # It is gone, which its listener tells.
            pass


class Driver:
    """Brings a plan to its end on so many workers.

    Attributes:
        lost_workers: how many workers have died.
    """

    def __init__(self, plan: Plan, job: Job, workers: int, told: "Optional[Callable[[int, int], object]]") -> None:
        self.lost_workers = 0
        self._plan, self._job, self._most, self._told = plan, job, workers, told
        self._workers: "list[WorkerProcess]" = []
        self._answers: Answers = queue.Queue()
        self._stillborn = 0
        self._warned: "set[str]" = set()
        self._said: "Optional[tuple[int, int]]" = None

    def run(self) -> None:
        """Returns when all frames are there or given up.

        Raises:
            Error: what keeps all frames from being made.
        """
        try:
            self._tell()
            while self._running() or not self._plan.is_over():
                self._submit()
                self._take_answers()
                self._tell()
        finally:
            self._close()

    def _running(self) -> int:
        return sum(worker.task is not None for worker in self._workers)

    def _submit(self) -> None:
        while self._running() < self._most:
            task = self._plan.next(self._most, time.monotonic())
            if task is None:
                return
            idle = next((worker for worker in self._workers if worker.task is None), None)
            if idle is None:
                idle = WorkerProcess(self._job, self._answers)
                self._workers.append(idle)
            idle.begin(task)

    def _take_answers(self) -> None:
        """Takes all answers that are there, for the first of which it waits a while."""
        try:
            worker, answer = self._answers.get(timeout=_LOOK_S)
            while True:
                self._take(worker, answer)
                worker, answer = self._answers.get_nowait()
        except queue.Empty:
            return

    def _take(self, worker: WorkerProcess, answer: "Optional[dict[str, Any]]") -> None:
        if answer is None:
            self._lost(worker)
        elif "ready" in answer:
            worker.is_ready, self._stillborn = True, 0
        else:
            task, worker.task = worker.task, None
            assert task is not None
            self._done(task, Outcome.of_values(answer))

    def _lost(self, worker: WorkerProcess) -> None:
        self._workers.remove(worker)
        self.lost_workers += 1
        why = worker.why_gone()
        self._stillborn += not worker.is_ready
        if self._stillborn >= _MOST_STILLBORN:
            reason = f"workers do not start: the last one {why}"
            help = "see what they say on standard error; if memory runs out, ask for fewer with workers="
            raise ResourceError(reason, reason=reason, help=help)
        if worker.task is not None:
            self._plan.lost(worker.task, why, time.monotonic())

    def _done(self, task: Task, outcome: Outcome) -> None:
        failed = set(self._plan.failed)
        self._plan.done(task, _checked(task, outcome), time.monotonic())
        for frame in self._plan.failed.keys() - failed:
            self._warn(f"frame {frame} is skipped: {self._plan.failed[frame]}")
        for warning in outcome.warnings:
            self._warn(warning)

    def _warn(self, message: str) -> None:
        if message not in self._warned:
            self._warned.add(message)
            warn_all([message])

    def _tell(self) -> None:
        now = self._plan.progress()
        if self._told is not None and now != self._said:
            self._told(*now)
            self._said = now

    def _close(self) -> None:
        for worker in self._workers:
            worker.ask_to_end()
        until = time.monotonic() + _GRACE_S
        for worker in self._workers:
            worker.end(until)


def _checked(task: Task, outcome: Outcome) -> Outcome:
    """Raises what would keep other tasks of the run from being done, too. What may pass is a failure of each frame."""
    if outcome.fault is not None:
        reason = f"a worker failed:\n{outcome.fault}"
        raise Error(reason, reason=reason)
    if outcome.error is None:
        return outcome
    kind, message, parts = outcome.error
    if not parts["is_temporary"]:
        raise make(kind, message, **parts)
    return replace(outcome, error=None, failures=[Failure(frame, message, True) for frame in task.frames])


def _signal(number: int) -> str:
    try:
        name = signal.Signals(number).name
    except ValueError:
        name = f"signal {number}"
    return f"{name}, as when memory runs out" if name == "SIGKILL" else name
