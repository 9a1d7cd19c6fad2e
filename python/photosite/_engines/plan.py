"""What is left to do of a run, cut into tasks."""

from __future__ import annotations

import heapq
from collections import Counter, deque
from typing import Optional, Protocol

from .._errors import Error
from .task import Failure, Outcome, Task

__all__ = ["FramePlan", "Pace", "Plan", "Retries"]

#: Long against what a task costs, and short against what its loss would.
TASK_S = 25.0
#: Tasks that are remembered: later frames may take longer than the first.
_REMEMBERED = 16
#: Before the second try, s; doubled before each further one.
_FIRST_PAUSE_S = 1.0


class Plan(Protocol):
    """What is left to do."""

    #: The frames that cannot be made, and why.
    failed: "dict[int, str]"

    def next(self, workers: int, now: float) -> Optional[Task]:
        """The next task for one of so many workers, or None as long as there is none."""
        ...

    def done(self, task: Task, outcome: Outcome, now: float) -> None:
        """A worker has brought a task to its end."""
        ...

    def lost(self, task: Task, why: str, now: float) -> None:
        """The worker of a task is gone."""
        ...

    def is_over(self) -> bool:
        """Whether nothing waits; tasks may be under way."""
        ...

    def progress(self) -> "tuple[int, int]":
        """What is done, and of how much."""
        ...


class Retries:
    """Pieces of work that wait for another try.

    A piece that fails for a reason that may pass is tried again after a pause, and ends the run when the reason stays:
    it would keep all others from being done. A piece that takes its workers with it is given up.
    """

    def __init__(self, retries: int) -> None:
        self._most = retries
        self._waiting: "list[tuple[float, int, Task]]" = []
        self._failures: "Counter[object]" = Counter()
        self._losses: "Counter[object]" = Counter()
        self._count = 0

    def __len__(self) -> int:
        return len(self._waiting)

    def next(self, now: float) -> Optional[Task]:
        """The next one whose pause is over."""
        if self._waiting and self._waiting[0][0] <= now:
            return heapq.heappop(self._waiting)[2]
        return None

    def failed(self, key: object, task: Task, failure: Failure, now: float) -> None:
        """It has failed for a reason that may pass."""
        self._failures[key] += 1
        tries = self._failures[key]
        if tries > self._most:
            reason = f"frame {failure.frame} failed {tries} times, at last: {failure.message}"
            help = "remove the cause, and call run again, which continues with what is missing"
            raise Error(reason, reason=reason, help=help, is_temporary=True)
        self._add(now + _FIRST_PAUSE_S * 2 ** (tries - 1), task)

    def lost(self, key: object, task: Task, now: float) -> bool:
        """Its worker is gone; whether it gets another one."""
        self._losses[key] += 1
        if self._losses[key] > self._most:
            return False
        self._add(now, task)
        return True

    def _add(self, when: float, task: Task) -> None:
        self._count += 1
        heapq.heappush(self._waiting, (when, self._count, task))


class Pace:
    """Seconds that units of work take: frames, or samples of one."""

    def __init__(self) -> None:
        self._tasks: "deque[tuple[int, float]]" = deque(maxlen=_REMEMBERED)

    def add(self, units: int, seconds: float) -> None:
        """A task of so many units has taken so long."""
        if units > 0:
            self._tasks.append((units, seconds))

    def units(self, left: int, workers: int, least: int = 1) -> int:
        """Units for the next task, of those that are left for so many workers: few at first, as nothing is known, and at
        last, so that all workers end together."""
        if not self._tasks:
            return min(least, left)
        per_unit_s = sum(seconds for _, seconds in self._tasks) / sum(units for units, _ in self._tasks)
        wanted = int(TASK_S / max(per_unit_s, 1e-6))
        fair = -(-left // (2 * max(workers, 1)))
        return min(max(min(wanted, fair), least), left)


class FramePlan:
    """Tasks of whole frames."""

    def __init__(self, frames: "list[int]", retries: int) -> None:
        self.failed: "dict[int, str]" = {}
        self._all, self._done = len(frames), 0
        self._fresh = deque(frames)
        self._retries = Retries(retries)
        self._pace = Pace()

    def next(self, workers: int, now: float) -> Optional[Task]:
        again = self._retries.next(now)
        if again is not None:
            return again
        count = self._pace.units(len(self._fresh), workers)
        return Task([self._fresh.popleft() for _ in range(count)]) if count else None

    def done(self, task: Task, outcome: Outcome, now: float) -> None:
        # Of a rig several cameras may fail; the first says why.
        failures = {failure.frame: failure for failure in reversed(outcome.failures)}
        self._pace.add(len(task.frames), outcome.seconds)
        self._done += len(task.frames) - len(failures)
        for frame, failure in failures.items():
            if failure.is_temporary:
                self._retries.failed(frame, Task([frame]), failure, now)
            else:
                self._done += 1
                self.failed[frame] = failure.message

    def lost(self, task: Task, why: str, now: float) -> None:
        # One of them may be what ends workers: each by itself shows which. Those that are there take no time.
        for frame in task.frames:
            if not self._retries.lost(frame, Task([frame]), now):
                self._done += 1
                self.failed[frame] = f"all workers that tried it are gone; the last one {why}"

    def is_over(self) -> bool:
        return not self._fresh and not len(self._retries)

    def progress(self) -> "tuple[int, int]":
        return self._done, self._all
