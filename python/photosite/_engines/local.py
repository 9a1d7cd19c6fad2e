"""Processes of this machine, which are started again when they die."""

from __future__ import annotations

import json
import os
import queue
import signal
import subprocess
import sys
import threading
import time
from dataclasses import asdict
from pathlib import Path
from typing import Any, Optional

from .._errors import ResourceError
from .task import Ended, Job, Outcome, Task

__all__ = ["LocalEngine"]

#: What a worker gets to keep a checkpoint of the picture under way.
_GRACE_S = 5.0
#: Workers that end before they have begun.
_MOST_STILLBORN = 3


class _Worker:
    """A process, and the task that it is at."""

    def __init__(self, answers: "queue.Queue[tuple[_Worker, Optional[dict[str, Any]]]]") -> None:
        package = str(Path(__file__).resolve().parents[2])
        paths = [package, *filter(None, [os.environ.get("PYTHONPATH")])]
        # Ctrl-C in a terminal is for the driver, which ends its workers.
        self.process = subprocess.Popen(
            [sys.executable, "-m", "photosite._engines.local_worker"],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            env={**os.environ, "PYTHONPATH": os.pathsep.join(paths)},
            start_new_session=True,
        )
        self.is_ready = False
        self.key: "Optional[int]" = None
        self._answers = answers
        threading.Thread(target=self._listen, daemon=True).start()

    def _listen(self) -> None:
        assert self.process.stdout is not None
        for line in self.process.stdout:
            # One that is killed may leave half a line.
            if line.endswith(b"\n"):
                self._answers.put((self, json.loads(line)))
        self._answers.put((self, None))

    def send(self, values: "dict[str, Any]") -> None:
        assert self.process.stdin is not None
        try:
            self.process.stdin.write(json.dumps(values).encode() + b"\n")
            self.process.stdin.flush()
        except (BrokenPipeError, OSError):
            # It is gone, which its listener tells.
            pass


class LocalEngine:
    """So many processes of this machine."""

    def __init__(self, job: Job, workers: int) -> None:
        self.lost_workers = 0
        self._job, self._most = asdict(job), workers
        self._workers: "list[_Worker]" = []
        self._answers: "queue.Queue[tuple[_Worker, Optional[dict[str, Any]]]]" = queue.Queue()
        self._stillborn = 0

    def slots(self) -> int:
        return self._most

    def submit(self, key: int, task: Task) -> None:
        idle = next((worker for worker in self._workers if worker.key is None), None)
        if idle is None:
            idle = _Worker(self._answers)
            self._workers.append(idle)
        idle.key = key
        idle.send({"job": self._job, "task": asdict(task)})

    def ended(self, wait_s: float) -> "list[Ended]":
        ended: "list[Ended]" = []
        try:
            worker, answer = self._answers.get(timeout=wait_s)
            while True:
                ended += self._ended(worker, answer)
                worker, answer = self._answers.get_nowait()
        except queue.Empty:
            return ended

    def _ended(self, worker: _Worker, answer: "Optional[dict[str, Any]]") -> "list[Ended]":
        if answer is None:
            return self._gone(worker)
        if "ready" in answer:
            worker.is_ready, self._stillborn = True, 0
            return []
        key, worker.key = worker.key, None
        assert key is not None
        return [Ended(key, Outcome.of_values(answer))]

    def _gone(self, worker: _Worker) -> "list[Ended]":
        self._workers.remove(worker)
        self.lost_workers += 1
        status = worker.process.wait()
        why = f"was ended by {_signal(-status)}" if status < 0 else f"ended with status {status}"
        self._stillborn += not worker.is_ready
        if self._stillborn >= _MOST_STILLBORN:
            reason = f"workers do not start: the last one {why}"
            help = "see what they say on standard error; if memory runs out, ask for fewer with workers="
            raise ResourceError(reason, reason=reason, help=help)
        return [] if worker.key is None else [Ended(worker.key, None, why)]

    def close(self) -> None:
        for worker in self._workers:
            # One without a task ends when nothing more can come.
            if worker.key is not None and os.name != "nt":
                worker.process.send_signal(signal.SIGINT)
            elif worker.process.stdin is not None:
                worker.process.stdin.close()
        until = time.monotonic() + _GRACE_S
        for worker in self._workers:
            try:
                worker.process.wait(max(0.0, until - time.monotonic()))
            except subprocess.TimeoutExpired:
                worker.process.kill()
                worker.process.wait()


def _signal(number: int) -> str:
    try:
        name = signal.Signals(number).name
    except ValueError:
        name = f"signal {number}"
    return f"{name}, as when memory runs out" if name == "SIGKILL" else name
