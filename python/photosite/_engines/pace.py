"""How much work makes a task of some seconds, at the pace seen so far."""

from __future__ import annotations

from collections import deque

__all__ = ["Pace"]

#: Long against what a task costs, and short against what its loss would.
TASK_S = 25.0
#: Tasks that are remembered: later frames may take longer than the first.
_REMEMBERED = 16


class Pace:
    """Seconds that units of work take: frames, or samples of one."""

    def __init__(self) -> None:
        self._tasks: "deque[tuple[int, float]]" = deque(maxlen=_REMEMBERED)

    def add(self, units: int, seconds: float) -> None:
        """A task of so many units has taken so long."""
        if units > 0:
            self._tasks.append((units, seconds))

    def units(self, left: int, slots: int, least: int = 1) -> int:
        """Units for the next task, of those that are left for so many workers: few at first, as nothing is known, and at
        last, so that all workers end together."""
        if not self._tasks:
            return min(least, left)
        per_unit_s = sum(seconds for _, seconds in self._tasks) / sum(units for units, _ in self._tasks)
        wanted = int(TASK_S / max(per_unit_s, 1e-6))
        fair = -(-left // (2 * max(slots, 1)))
        return min(max(min(wanted, fair), least), left)
