"""Progress: a bar in terminals and notebooks, or whatever the caller does with the numbers."""

from __future__ import annotations

import sys
import time
import warnings
from typing import Any, Callable, Optional, Union

#: True for a bar, False for none, None for one where somebody watches, or a function of what is done and what there is
#: to do.
Progress = Union[bool, Callable[[int, int], object], None]


def listener(progress: Progress, label: str, unit: str = "paths") -> "Optional[Callable[[int, int], object]]":
    """What is to be told of progress."""
    if callable(progress):
        return progress
    if progress is None:
        progress = _is_notebook() or sys.stderr.isatty()
    return _bar(label, unit) if progress else None


def _is_notebook() -> bool:
    """Whether a notebook shows what is printed."""
    return "ipykernel" in sys.modules and "IPython" in sys.modules


def _bar(label: str, unit: str) -> "Callable[[int, int], object]":
    """tqdm's bar where that is installed, else a plain line."""
    try:
        with warnings.catch_warnings():
            # That a notebook lacks widgets, and gets a bar of text.
            warnings.simplefilter("ignore")
            from tqdm.auto import tqdm
    except ImportError:
        return _Line(label)
    return _Tqdm(tqdm, label, unit)


class _Tqdm:
    def __init__(self, tqdm: Any, label: str, unit: str) -> None:
        self._make, self._label, self._unit = tqdm, label, unit
        self._shown: Any = None

    def __call__(self, done: int, all: int) -> None:
        if self._shown is None:
            self._shown = self._make(total=all, initial=done, desc=self._label, unit=f" {self._unit}", unit_scale=True)
        self._shown.total = all
        self._shown.update(done - self._shown.n)
        if done >= all:
            self._shown.close()


class _Line:
    """A line on standard error that is written over ten times a second."""

    def __init__(self, label: str) -> None:
        self._label = label
        self._begun = self._said = time.monotonic()
        self._before: "Optional[int]" = None

    def __call__(self, done: int, all: int) -> None:
        now = time.monotonic()
        is_done = done >= all
        if self._before is None:
            # What was done before says nothing of the pace.
            self._before = done
        if now - self._said < 0.1 and not is_done:
            return
        self._said = now
        end = "\n" if is_done else ""
        share = done / max(all, 1)
        spent = now - self._begun
        left = ""
        if not is_done and done > self._before:
            left = f", {spent * (all - done) / (done - self._before):.0f} s left"
        # Blanks, where the line before was longer.
        print(f"\r{self._label} {share:4.0%}  {spent:.1f} s{left:16}", end=end, file=sys.stderr, flush=True)
