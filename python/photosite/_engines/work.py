"""What a worker does: one task after the other, with a data set that it reads once."""

from __future__ import annotations

import platform
import threading
import time
import traceback
from typing import Any, Optional

from .. import _photosite
from .._errors import Error, InputError, make
from .output import open_output
from .task import Job, Outcome, Task

__all__ = ["carry_out"]

#: The data set of the last task, and what it is of: the next task most likely is of the same.
_known: "Optional[tuple[Job, _photosite.Dataset]]" = None
_lock = threading.Lock()


def carry_out(job: "dict[str, Any]", task: "dict[str, Any]") -> "dict[str, Any]":
    """Makes the frames of a task that are not there, and tells what became of it."""
    host = platform.node()
    try:
        outcome = _made(host, Job(**job), Task(**task))
    except Error as error:
        outcome = Outcome(host, error=list(error.__reduce__()[1]))
    except OSError as refused:
        # Of what is put aside for a while; another machine, or a later moment, may have room.
        passing = make("FileError", f"cannot write temporary files: {refused}", refused.errno, is_temporary=True)
        outcome = Outcome(host, error=list(passing.__reduce__()[1]))
    except Exception:  # noqa: BLE001
        outcome = Outcome(host, fault=traceback.format_exc())
    return outcome.to_values()


def _made(host: str, job: Job, task: Task) -> Outcome:
    if job.version != _photosite.__version__:
        reason = f"photosite is {_photosite.__version__} here, and {job.version} where the run was started"
        help = "install the same version on all machines"
        raise InputError(reason, reason=reason, help=help)
    dataset = _dataset(job)
    begun = time.monotonic()
    failures, warnings = open_output(job.output).make(dataset, job, task)
    return Outcome(host, time.monotonic() - begun, failures, warnings)


def _dataset(job: Job) -> "_photosite.Dataset":
    global _known
    with _lock:
        # Files that have changed since have another fingerprint.
        if _known is None or _known[0] != job:
            _known = job, _photosite.Dataset.read(job.path, job.overrides)
        return _known[1]
