"""A run of a data set, from its arguments to its result."""

from __future__ import annotations

import os
import time
from dataclasses import dataclass
from typing import Callable, Optional

from .. import _photosite
from .._arguments import invalid
from .._errors import Error, warn_all
from .driver import Driver
from .parts import parts_present, remove_needless, sample_ranges
from .plan import FramePlan, Plan
from .sample_plan import SamplePlan
from .task import Job

__all__ = ["EngineRun", "Request", "run"]


@dataclass(frozen=True)
class EngineRun:
    """Result of `Dataset.run`.

    Attributes:
        made: how many frames were made.
        present: how many frames of those that were asked for were there before.
        failed: why frames could not be made, by their numbers.
        lost_workers: how many workers died while the run went on.
        seconds: how long it took.
    """

    made: int
    present: int
    failed: "dict[int, str]"
    lost_workers: int
    seconds: float


@dataclass(frozen=True)
class Request:
    """Arguments of a run; `workers` and `threads` are chosen where they are not stated."""

    path: str
    overrides: "list[str]"
    output: str
    frames: "list[int]"
    workers: Optional[int]
    threads: Optional[int]
    split: str
    retries: int
    keep_going: bool


def run(
    dataset: "_photosite.Dataset", request: Request, told: "Optional[Callable[[int, int], object]]"
) -> EngineRun:
    """Makes the frames that are missing."""
    if request.split not in ("frames", "samples"):
        raise invalid("split", f"expected 'frames' or 'samples', got {request.split!r}")
    begun = time.monotonic()
    output = request.output
    dataset.claim(output)
    missing = dataset.missing(output, request.frames)
    plan, lost = _plan(dataset, request, missing), 0
    if missing:
        workers, threads = _shares(request, len(missing))
        driver = Driver(plan, Job(request.path, request.overrides, output, threads), workers, told)
        driver.run()
        lost = driver.lost_workers
    _, left_out, warnings = dataset.write_index(output)
    remove_needless(dataset, output)
    warn_all([f"calibration/ is without {why.replace('`', '')}" for why in left_out] + warnings)
    made = len(missing) - len(plan.failed)
    result = EngineRun(made, len(request.frames) - len(missing), plan.failed, lost, time.monotonic() - begun)
    if plan.failed and not request.keep_going:
        raise _failed(output, plan.failed)
    return result


def _plan(dataset: "_photosite.Dataset", request: Request, missing: "list[int]") -> Plan:
    if request.split == "frames":
        return FramePlan(missing, request.retries)
    present = parts_present(dataset, request.output, missing)
    return SamplePlan(missing, dataset.samples(), present, sample_ranges(request.output), request.retries)


def _shares(request: Request, frames: int) -> "tuple[int, int]":
    """Workers, and the threads of each."""
    workers, threads = request.workers, request.threads
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    if workers is None:
        workers = max(1, cores // (threads or 1))
        workers = min(workers, frames) if request.split == "frames" else workers
    return workers, threads or max(1, cores // workers)


def _failed(output: str, failed: "dict[int, str]") -> Error:
    """The error of frames that could not be made, with what was said of the first."""
    frames = sorted(failed)
    shown = "".join(f"\n  frame {frame}: {failed[frame]}" for frame in frames[:5])
    more = f"\n  and {len(frames) - 5} more" if len(frames) > 5 else ""
    one = "a frame" if len(frames) == 1 else f"{len(frames)} frames"
    reason = f"{one} could not be made:{shown}{more}"
    help = "the others exist; give keep_going=True for a result that lists them all"
    return Error(f"{output}: {reason}", file=output, reason=reason, help=help)
