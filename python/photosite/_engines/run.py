"""A run of a data set on an engine, from its arguments to its result."""

from __future__ import annotations

import os
import time
from dataclasses import dataclass
from typing import Callable, Optional

from .. import _photosite
from .._arguments import invalid
from .._errors import Error, warn_all
from .driver import Driver, Engine
from .installed import needed
from .output import Folder, Output, open_output
from .plan import FramePlan, Plan
from .sample_plan import SamplePlan
from .task import Job

__all__ = ["EngineRun", "Request", "run"]


@dataclass(frozen=True)
class EngineRun:
    """What a run of a data set on an engine has made.

    Attributes:
        made: how many frames were made.
        present: how many frames of those that were asked for were there before.
        failed: why frames could not be made, by their numbers.
        lost_workers: how many workers died, or went away, while the run went on.
        seconds: how long it took.
    """

    made: int
    present: int
    failed: "dict[int, str]"
    lost_workers: int
    seconds: float


@dataclass(frozen=True)
class Request:
    """What is asked of a run; `workers` and `threads` are chosen where they are not stated."""

    path: str
    overrides: "list[str]"
    output: str
    frames: "list[int]"
    engine: str
    address: Optional[str]
    workers: Optional[int]
    threads: Optional[int]
    split: str
    retries: int
    keep_going: bool


def run(
    dataset: "_photosite.Dataset", request: Request, told: "Optional[Callable[[int, int], object]]"
) -> EngineRun:
    """Makes the frames that are missing."""
    _check(request)
    begun = time.monotonic()
    output = open_output(request.output)
    fingerprint = output.claim(dataset)
    missing = output.missing(dataset, request.frames)
    plan, lost = _plan(dataset, request, output, missing), 0
    if missing:
        workers, threads = _shares(request, len(missing) if request.split == "frames" else None)
        job = Job(
            version=_photosite.__version__,
            path=request.path,
            overrides=request.overrides,
            fingerprint=fingerprint,
            frame_count=dataset.frame_count(),
            output=request.output,
            threads=threads,
        )
        engine = _engine(request, job, workers)
        try:
            Driver(engine, plan, told).run()
        finally:
            engine.close()
        lost = engine.lost_workers
    warn_all(output.finish(dataset))
    made = len(missing) - len(plan.failed)
    result = EngineRun(made, len(request.frames) - len(missing), plan.failed, lost, time.monotonic() - begun)
    if plan.failed and not request.keep_going:
        raise _failed(request.output, plan.failed)
    return result


def _check(request: Request) -> None:
    """Refuses what no place has to be taken for."""
    if request.split not in ("frames", "samples"):
        raise invalid("split", f"expected 'frames' or 'samples', got {request.split!r}")
    if request.engine not in ("local", "ray", "dask"):
        raise invalid("engine", f"expected 'local', 'ray' or 'dask', got {request.engine!r}")
    if request.engine == "local" and request.address is not None:
        raise invalid("address", "the local engine does not take one", "leave it out, or name the engine that it belongs to")
    if request.engine == "ray":
        needed("ray", "ray", "engine", "ray")
    if request.engine == "dask":
        needed("dask.distributed", "dask[distributed]", "engine", "dask")


def _plan(dataset: "_photosite.Dataset", request: Request, output: Output, missing: "list[int]") -> Plan:
    if request.split == "frames":
        return FramePlan(missing, request.retries)
    if not isinstance(output, Folder):
        reason = "parts of pictures need a folder that all machines see, not a store"
        raise invalid("split", reason, "give a folder, or split='frames'")
    present = output.parts(dataset, missing)
    return SamplePlan(missing, dataset.samples(), present, output.sample_ranges(), request.retries)


def _shares(request: Request, tasks: Optional[int]) -> "tuple[Optional[int], int]":
    """Workers and the threads of each. Machines of a cluster know better how many workers they take."""
    workers, threads = request.workers, request.threads
    if request.engine != "local":
        return workers, threads or 1
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    if workers is None:
        workers = max(1, cores // (threads or 1))
        workers = workers if tasks is None else min(workers, tasks)
    return workers, threads or max(1, cores // workers)


def _engine(request: Request, job: Job, workers: Optional[int]) -> Engine:
    if request.engine == "ray":
        from .on_ray import RayEngine

        return RayEngine(job, request.address, workers)
    if request.engine == "dask":
        from .on_dask import DaskEngine

        return DaskEngine(job, request.address, workers)
    from .local import LocalEngine

    return LocalEngine(job, workers or 1)


def _failed(output: str, failed: "dict[int, str]") -> Error:
    """The error of frames that could not be made, with what was said of the first."""
    frames = sorted(failed)
    shown = "".join(f"\n  frame {frame}: {failed[frame]}" for frame in frames[:5])
    more = f"\n  and {len(frames) - 5} more" if len(frames) > 5 else ""
    one = "a frame" if len(frames) == 1 else f"{len(frames)} frames"
    reason = f"{one} could not be made:{shown}{more}"
    help = "the others exist; give keep_going=True for a result that lists them all"
    return Error(f"{output}: {reason}", file=output, reason=reason, help=help)
