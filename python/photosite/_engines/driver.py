"""The driver of a run: gives tasks to an engine, and takes what comes back."""

from __future__ import annotations

import time
from dataclasses import replace
from typing import Callable, Optional, Protocol

from .._errors import Error, make, warn_all
from .plan import Plan
from .task import Ended, Failure, Outcome, Task

__all__ = ["Driver", "Engine"]

#: Between two looks at pauses that are over, and at workers that came.
_LOOK_S = 0.5
#: Without a worker before that is said.
_PATIENCE_S = 10.0


class Engine(Protocol):
    """What carries out tasks on workers."""

    #: How many workers are gone that should not be.
    lost_workers: int

    def slots(self) -> int:
        """How many tasks can be under way at once; 0 as long as there is no worker."""
        ...

    def submit(self, key: int, task: Task) -> None:
        """Gives a task to a worker."""
        ...

    def ended(self, wait_s: float) -> "list[Ended]":
        """Tasks that have ended since, for which it waits so long at most."""
        ...

    def close(self) -> None:
        """Ends what is under way, and lets go of the workers."""
        ...


class Driver:
    """Brings a plan to its end."""

    def __init__(self, engine: Engine, plan: Plan, told: "Optional[Callable[[int, int], object]]") -> None:
        self._engine, self._plan, self._told = engine, plan, told
        self._running: "dict[int, Task]" = {}
        self._warned: "set[str]" = set()
        self._said: "Optional[tuple[int, int]]" = None
        self._count = 0
        self._idle_since = time.monotonic()

    def run(self) -> None:
        """Returns when all frames are there or given up.

        Raises:
            Error: what keeps all frames from being made.
        """
        self._tell()
        while self._running or not self._plan.is_over():
            self._submit()
            for ended in self._engine.ended(_LOOK_S):
                self._take(ended)
            self._tell()

    def _submit(self) -> None:
        slots = self._engine.slots()
        if slots > 0:
            self._idle_since = time.monotonic()
        elif time.monotonic() - self._idle_since > _PATIENCE_S:
            self._warn("no worker of the cluster has as many cores as threads= asks for; the run waits for one")
        while len(self._running) < slots:
            task = self._plan.next(slots, time.monotonic())
            if task is None:
                return
            self._count += 1
            self._running[self._count] = task
            self._engine.submit(self._count, task)

    def _take(self, ended: Ended) -> None:
        task, now = self._running.pop(ended.key), time.monotonic()
        if ended.outcome is None:
            self._plan.lost(task, ended.why, now)
            return
        failed = set(self._plan.failed)
        self._plan.done(task, _checked(task, ended.outcome), now)
        for frame in self._plan.failed.keys() - failed:
            self._warn(f"frame {frame} is skipped: {self._plan.failed[frame]}")
        for warning in ended.outcome.warnings:
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


def _checked(task: Task, outcome: Outcome) -> Outcome:
    """Raises what would keep other tasks of the run from being done, too. What may pass is a failure of each frame."""
    if outcome.fault is not None:
        reason = f"a worker on {outcome.host} failed:\n{outcome.fault}"
        raise Error(reason, reason=reason)
    if outcome.error is None:
        return outcome
    kind, message, parts = outcome.error
    message = f"{message} (on the machine {outcome.host})"
    if not parts["is_temporary"]:
        raise make(kind, message, **parts)
    return replace(outcome, error=None, failures=[Failure(frame, message, True) for frame in task.frames])
