"""A worker process: a job and its tasks come on standard input, answers go to standard output, a line each."""

from __future__ import annotations

import json
import os
import queue
import sys
import threading
import time
import traceback
from dataclasses import asdict
from typing import Any, Optional

from .. import _photosite
from .._errors import Error
from .parts import part_folder, remove_parts
from .task import Failure, Job, Outcome, Task

__all__ = ["main"]


class _Worker:
    """Carries out one task after the other, with a data set that it reads once."""

    def __init__(self, job: Job) -> None:
        self._job = job
        self._dataset: "Optional[_photosite.Dataset]" = None

    def outcome(self, task: Task) -> Outcome:
        """Makes the frames of a task that are not there, and tells what became of it."""
        try:
            if self._dataset is None:
                self._dataset = _photosite.Dataset.read(self._job.path, self._job.overrides, "cpu")
            begun = time.monotonic()
            failures, warnings = self._make(self._dataset, task)
            return Outcome(time.monotonic() - begun, [Failure(*failure) for failure in failures], warnings)
        except Error as error:
            return Outcome(error=list(error.__reduce__()[1]))
        except Exception:  # noqa: BLE001
            return Outcome(fault=traceback.format_exc())

    def _make(self, dataset: "_photosite.Dataset", task: Task) -> "tuple[list[tuple[int, str, bool]], list[str]]":
        job = self._job
        if task.samples is not None:
            first, end = task.samples
            folder = part_folder(job.output, first, end)
            return dataset.make_part(folder, task.frames, (first, end), job.path, job.threads)
        if not task.parts:
            return dataset.make(job.output, task.frames, job.threads)
        folders = [part_folder(job.output, first, end) for first, end in task.parts]
        failures, warnings = dataset.merge(job.output, task.frames, folders, job.threads)
        if not failures:
            remove_parts(dataset, folders, task.frames)
        return failures, warnings


def main() -> None:
    """Works until there is nothing more to come."""
    # What else is printed must not come between answers.
    answers = os.fdopen(os.dup(1), "w", encoding="utf-8")
    os.dup2(2, 1)
    asked: "queue.Queue[dict[str, Any]]" = queue.Queue()
    threading.Thread(target=_listen, args=(asked,), daemon=True).start()
    print('{"ready": true}', file=answers, flush=True)
    worker = _Worker(Job(**asked.get()))
    while True:
        print(json.dumps(asdict(worker.outcome(Task(**asked.get())))), file=answers, flush=True)


def _listen(asked: "queue.Queue[dict[str, Any]]") -> None:
    for line in sys.stdin:
        asked.put(json.loads(line))
    # The driver has done, or is dead: nobody waits for what is under way.
    os._exit(0)


if __name__ == "__main__":
    try:
        main()
    except KeyboardInterrupt:
        # The image under way has left a checkpoint.
        sys.exit(130)
