"""What is left to do of images that are traced in parts, each some samples of every pixel."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass, field
from typing import Optional

from .plan import Pace, Retries
from .task import Outcome, Task

__all__ = ["SamplePlan"]

#: Parts of an image, about: each takes as much disk as the film of the whole.
_MOST_PARTS = 16


@dataclass
class _Frame:
    """A frame: ranges of samples that are to be traced, and what is there or under way."""

    number: int
    #: Ranges that may be cut, and those that an earlier run has begun, which may not.
    gaps: "deque[tuple[int, int]]"
    begun: "deque[tuple[int, int]]"
    parts: "list[tuple[int, int]]"
    under_way: "set[tuple[int, int]]" = field(default_factory=lambda: set())


class SamplePlan:
    """Tasks of samples of one frame, and one more for each frame that puts its parts together."""

    def __init__(
        self,
        frames: "list[int]",
        samples: int,
        present: "dict[int, list[tuple[int, int]]]",
        begun: "list[tuple[int, int]]",
        retries: int,
    ) -> None:
        self.failed: "dict[int, str]" = {}
        self._samples = samples
        self._frames = {frame: _frame(frame, samples, present[frame], begun) for frame in frames}
        self._all = samples * len(frames)
        self._retries = Retries(retries)
        self._pace = Pace()
        self._merges: "deque[Task]" = deque()
        for number in frames:
            self._merge_if_whole(number)

    def next(self, workers: int, now: float) -> Optional[Task]:
        again = self._retries.next(now)
        if again is not None:
            return again
        if self._merges:
            return self._merges.popleft()
        for frame in self._frames.values():
            if frame.begun or frame.gaps:
                taken = frame.begun.popleft() if frame.begun else self._cut(frame, workers)
                frame.under_way.add(taken)
                return Task([frame.number], samples=list(taken))
        return None

    def done(self, task: Task, outcome: Outcome, now: float) -> None:
        [number] = task.frames
        if outcome.failures:
            failure = outcome.failures[0]
            if failure.is_temporary:
                self._retries.failed(_key(task), task, failure, now)
            else:
                self._give_up(number, failure.message)
            return
        if task.samples is None:
            self._frames.pop(number, None)
            return
        frame = self._frames.get(number)
        # None of a frame that another part has failed of.
        if frame is not None:
            first, end = task.samples
            self._pace.add(end - first, outcome.seconds)
            frame.under_way.discard((first, end))
            frame.parts.append((first, end))
            self._merge_if_whole(number)

    def lost(self, task: Task, why: str, now: float) -> None:
        if not self._retries.lost(_key(task), task, now):
            self._give_up(task.frames[0], f"all workers that tried it are gone; the last one {why}")

    def is_over(self) -> bool:
        waits = any(frame.gaps or frame.begun for frame in self._frames.values())
        return not (self._merges or len(self._retries) or waits)

    def progress(self) -> "tuple[int, int]":
        return self._all - sum(map(self._left, self._frames.values())), self._all

    def _cut(self, frame: _Frame, workers: int) -> "tuple[int, int]":
        """Cuts the next range off the first gap."""
        first, end = frame.gaps.popleft()
        left = sum(end - first for frame in self._frames.values() for first, end in frame.gaps) + end - first
        # Few images for many workers take more parts each.
        parts = max(_MOST_PARTS, 2 * workers // len(self._frames))
        least = -(-self._samples // parts)
        cut = first + self._pace.units(left, workers, least)
        if cut + least > end:
            return first, end
        frame.gaps.appendleft((cut, end))
        return first, cut

    def _left(self, frame: _Frame) -> int:
        return self._samples - sum(end - first for first, end in frame.parts)

    def _merge_if_whole(self, number: int) -> None:
        frame = self._frames[number]
        if not (frame.gaps or frame.begun or frame.under_way):
            self._merges.append(Task([number], parts=[list(part) for part in sorted(frame.parts)]))

    def _give_up(self, number: int, message: str) -> None:
        self._frames.pop(number, None)
        self.failed.setdefault(number, message)


def _frame(
    number: int, samples: int, present: "list[tuple[int, int]]", begun: "list[tuple[int, int]]"
) -> _Frame:
    """A frame of which some parts are there. Ranges that an earlier run began, maybe with checkpoints, stay whole."""
    parts = _apart(present)
    rest = _apart(begun, parts)
    fixed = sorted(parts + rest)
    ends = [0, *(edge for part in fixed for edge in part), samples]
    gaps = [(first, end) for first, end in zip(ends[::2], ends[1::2]) if first < end]
    return _Frame(number, deque(gaps), deque(rest), parts)


def _apart(ranges: "list[tuple[int, int]]", beside: "Optional[list[tuple[int, int]]]" = None) -> "list[tuple[int, int]]":
    """Those of the ranges, from the first on, that overlap neither each other nor others."""
    kept = list(beside or [])
    chosen: "list[tuple[int, int]]" = []
    for first, end in sorted(ranges):
        if all(end <= other_first or other_end <= first for other_first, other_end in kept):
            kept.append((first, end))
            chosen.append((first, end))
    return chosen


def _key(task: Task) -> object:
    return task.frames[0], tuple(task.samples or ())
