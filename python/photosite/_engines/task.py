"""What passes between the driver and its workers, in plain values that JSON can hold."""

from __future__ import annotations

from dataclasses import asdict, dataclass, field, replace
from typing import Any, Optional

__all__ = ["Ended", "Failure", "Job", "Outcome", "Task"]


@dataclass(frozen=True)
class Job:
    """What all tasks of a run have in common.

    Attributes:
        version: of photosite, the same on all machines.
        path: the data set file.
        overrides: changes to keys of its captures.
        fingerprint: of all that decides what is in the pictures.
        frame_count: how many frames the file asks for.
        output: a folder, or the URL of a place in a store.
        threads: threads of a worker.
    """

    version: str
    path: str
    overrides: "list[str]"
    fingerprint: str
    frame_count: int
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
    """What became of a task that a worker has brought to its end.

    Attributes:
        host: the machine.
        seconds: how long it took, without reading the data set file.
        failures: the frames that could not be made; the others are there.
        warnings: what users should know of the pictures.
        error: the error that kept the worker from making any frame, as its class, its message and its parts.
        fault: the traceback of what is no error of photosite.
    """

    host: str
    seconds: float = 0.0
    failures: "list[Failure]" = field(default_factory=lambda: [])
    warnings: "list[str]" = field(default_factory=lambda: [])
    error: "Optional[list[Any]]" = None
    fault: "Optional[str]" = None

    def to_values(self) -> "dict[str, Any]":
        return asdict(self)

    @staticmethod
    def of_values(values: "dict[str, Any]") -> "Outcome":
        outcome = Outcome(**values)
        return replace(outcome, failures=[Failure(**failure) for failure in values["failures"]])


@dataclass(frozen=True)
class Ended:
    """A task is over: its worker tells the outcome, or is gone.

    Attributes:
        key: the number that it was submitted with.
        outcome: None of a worker that is gone.
        why: what is known of how the worker ended.
    """

    key: int
    outcome: Optional[Outcome]
    why: str = ""
