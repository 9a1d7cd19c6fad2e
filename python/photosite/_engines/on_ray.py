"""Ray: tasks are Ray's tasks, whose retries are the driver's."""

from __future__ import annotations

import time
import warnings
from dataclasses import asdict
from typing import Any, Optional

from .address import check_reachable, unreachable
from .installed import needed
from .task import Ended, Job, Outcome, Task
from .work import carry_out

__all__ = ["RayEngine"]


class RayEngine:
    """A Ray cluster: the one that this process is connected to, that at an address, or one of this machine."""

    def __init__(self, job: Job, address: Optional[str], workers: Optional[int]) -> None:
        self.lost_workers = 0
        self._ray = needed("ray", "ray", "engine", "ray")
        self._job, self._most = asdict(job), workers
        self._is_ours = not self._ray.is_initialized()
        if self._is_ours:
            self._connect(address)
        # A worker that dies is the driver's affair, which then gives out its frames one by one.
        remote = self._ray.remote(num_cpus=job.threads, max_retries=0)
        self._carry_out = remote(carry_out)
        self._threads = job.threads
        self._running: "dict[Any, int]" = {}

    def _connect(self, address: Optional[str]) -> None:
        if address is not None:
            check_reachable(address)
        try:
            with warnings.catch_warnings():
                # Of Ray's next version.
                warnings.simplefilter("ignore", FutureWarning)
                self._ray.init(address=address, log_to_driver=False, configure_logging=False)
        except (ConnectionError, RuntimeError, ValueError, OSError) as refused:
            raise unreachable(address or "local", f"Ray says: {refused}") from None

    def slots(self) -> int:
        # Machines come and go; a task has all of its threads on one of them.
        alive = [node["Resources"].get("CPU", 0) for node in self._ray.nodes() if node["Alive"]]
        slots = sum(int(cores) // self._threads for cores in alive)
        return slots if self._most is None else min(slots, self._most)

    def submit(self, key: int, task: Task) -> None:
        self._running[self._carry_out.remote(self._job, asdict(task))] = key

    def ended(self, wait_s: float) -> "list[Ended]":
        if not self._running:
            # Maybe machines come.
            time.sleep(wait_s)
            return []
        done, _ = self._ray.wait(list(self._running), num_returns=1, timeout=wait_s)
        if done:
            more, _ = self._ray.wait(list(self._running), num_returns=len(self._running), timeout=0)
            done = list({*done, *more})
        return [self._ended(reference) for reference in done]

    def _ended(self, reference: Any) -> Ended:
        key = self._running.pop(reference)
        try:
            return Ended(key, Outcome.of_values(self._ray.get(reference)))
        except self._ray.exceptions.RayTaskError as error:
            # Workers answer with errors: this one could not even begin.
            return Ended(key, Outcome("Ray", fault=str(error)))
        except self._ray.exceptions.RayError as error:
            self.lost_workers += 1
            return Ended(key, None, f"was lost: {str(error).splitlines()[0]}")

    def close(self) -> None:
        for reference in self._running:
            # As Ctrl-C in the worker.
            self._ray.cancel(reference)
        if self._is_ours:
            self._ray.shutdown()
