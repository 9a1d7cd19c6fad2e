"""Messages between the driver and its workers, in plain values that JSON can hold."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any, Optional

__all__ = ["Failure", "Job", "Outcome", "Task"]


@dataclass(frozen=True)
class Job:
    """What all tasks of a run have in common.

    Attributes:
        path: the data set file.
        overrides: changes to keys of its captures.
        output: the folder of the data set.
        threads: threads of a worker.
    """

    path: str
    overrides: "list[str]"
    output: str
    threads: int


@dataclass(frozen=True)
class Task:
    """A piece of the work.

    Attributes:
        frames: numbers of the frames to make.
        samples: the samples of each pixel to trace, from one up to, but without, the other; all of them if None.
        parts: ranges of samples that lie in folders of parts, to be put together; none to be traced.
    """

    frames: "list[int]"
    samples: "Optional[list[int]]" = None
    parts: "list[list[int]]" = field(default_factory=lambda: [])


@dataclass(frozen=True)
class Failure:
    """A frame that could not be made, and why."""

    frame: int
    message: str
    is_temporary: bool


@dataclass(frozen=True)
class Outcome:
    """Result of a task that a worker has brought to its end.

    Attributes:
        seconds: how long it took, without reading the data set file.
        failures: the frames that could not be made; the others are there.
        warnings: what users should know of the images.
        error: the error that kept the worker from making any frame, as its class, its message and its parts.
        fault: the traceback of what is no error of photosite.
    """

    seconds: float = 0.0
    failures: "list[Failure]" = field(default_factory=lambda: [])
    warnings: "list[str]" = field(default_factory=lambda: [])
    error: "Optional[list[Any]]" = None
    fault: "Optional[str]" = None

    @staticmethod
    def of_values(values: "dict[str, Any]") -> "Outcome":
        """The outcome of which JSON holds the values."""
        outcome = Outcome(**values)
        return replace(outcome, failures=[Failure(**failure) for failure in values["failures"]])
