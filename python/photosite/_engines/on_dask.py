"""Dask: tasks are Dask's tasks. Its scheduler gives those of a dead worker to another one, some times."""

from __future__ import annotations

import queue
from dataclasses import asdict
from typing import Any, Optional

from .._errors import InputError
from .address import unreachable
from .installed import needed
from .task import Ended, Job, Outcome, Task
from .work import carry_out

__all__ = ["DaskEngine"]

#: For the scheduler to answer.
_ANSWER_S = 10


class DaskEngine:
    """A Dask cluster: that of an address, or of the client that this process has."""

    def __init__(self, job: Job, address: Optional[str], workers: Optional[int]) -> None:
        self.lost_workers = 0
        self._dask = needed("dask.distributed", "dask[distributed]", "engine", "dask")
        self._job, self._most, self._threads = asdict(job), workers, job.threads
        self._client, self._is_ours = self._connected(address)
        self._running: "dict[Any, int]" = {}
        self._done: "queue.Queue[Any]" = queue.Queue()
        self._seen: "set[str]" = set()

    def _connected(self, address: Optional[str]) -> "tuple[Any, bool]":
        if address is None:
            try:
                return self._dask.default_client(), False
            except ValueError:
                reason = "Dask needs the address of its scheduler"
                help = 'give address="tcp://host:8786", or make a dask.distributed.Client first'
                raise InputError(f"address: {reason}", file="<python>", key="address", reason=reason, help=help) from None
        try:
            return self._dask.Client(address, timeout=_ANSWER_S, set_as_default=False), True
        except (OSError, ValueError, TypeError) as refused:
            raise unreachable(address, str(refused)) from None

    def slots(self) -> int:
        workers: "dict[str, int]" = self._client.nthreads()
        # A worker that is started again has another address.
        self.lost_workers += len(self._seen - workers.keys())
        self._seen = set(workers)
        slots = sum(threads // self._threads for threads in workers.values())
        return slots if self._most is None else min(slots, self._most)

    def submit(self, key: int, task: Task) -> None:
        # The same call twice is a call, too.
        future = self._client.submit(carry_out, self._job, asdict(task), pure=False)
        self._running[future] = key
        future.add_done_callback(self._done.put)

    def ended(self, wait_s: float) -> "list[Ended]":
        done: "list[Any]" = []
        try:
            done.append(self._done.get(timeout=wait_s))
            while True:
                done.append(self._done.get_nowait())
        except queue.Empty:
            return [self._ended(future) for future in done]

    def _ended(self, future: Any) -> Ended:
        key = self._running.pop(future)
        if future.status == "finished":
            return Ended(key, Outcome.of_values(future.result()))
        error = future.exception() if future.status == "error" else None
        if error is None or isinstance(error, self._dask.scheduler.KilledWorker):
            return Ended(key, None, "was lost repeatedly" if error else f"was {future.status}")
        return Ended(key, Outcome("Dask", fault=repr(error)))

    def close(self) -> None:
        # Those under way end by themselves: Dask stops no thread.
        self._client.cancel(list(self._running))
        if self._is_ours:
            self._client.close()
