"""What the comparison measures."""

import statistics
from dataclasses import dataclass, field

import numpy as np

EPSILON = 0.01


def relative_error(picture, reference):
    """relMSE of an image's channels, each divided by the reference's mean: mean of (x − r)² / (r² + 0.01)."""
    mean = reference.mean(axis=(0, 1))
    x, r = picture / mean, reference / mean
    return float(np.mean((x - r) ** 2 / (r**2 + EPSILON)))


def brightness(picture):
    """The sum of the channels, an image without colour and so without its noise."""
    return picture.sum(axis=2, keepdims=True)


def coarse(picture, side=4):
    """Means of squares of pixels: errors that neighbours share are not averaged out by them."""
    height, width, channels = (picture.shape[0] // side, picture.shape[1] // side, picture.shape[2])
    whole = picture[: height * side, : width * side]
    return whole.reshape(height, side, width, side, channels).mean(axis=(1, 3))


@dataclass
class Runs:
    """Renders of one program with one sampler."""

    paths: int
    wall: list = field(default_factory=list)
    busy: list = field(default_factory=list)
    error: list = field(default_factory=list)
    grey_error: list = field(default_factory=list)
    coarse_error: list = field(default_factory=list)
    # Wall and processor seconds of whole programs, from their start to their end.
    whole: list = field(default_factory=list)

    def add(self, picture, seconds, reference):
        """Adds a render."""
        self.wall.append(seconds[0])
        self.busy.append(seconds[1])
        self.error.append(relative_error(picture, reference))
        self.grey_error.append(relative_error(brightness(picture), brightness(reference)))
        self.coarse_error.append(relative_error(coarse(picture), coarse(reference)))

    @property
    def relmse(self):
        """Mean over the runs."""
        return statistics.mean(self.error)

    @property
    def grey_relmse(self):
        """The same of the sum of the channels."""
        return statistics.mean(self.grey_error)

    @property
    def coarse_relmse(self):
        """The same of means of 4 × 4 pixels."""
        return statistics.mean(self.coarse_error)

    def whole_s(self):
        """Median wall and processor seconds of the whole program."""
        return [statistics.median(seconds) for seconds in zip(*self.whole, strict=True)]

    def efficiency(self):
        """1 / (relMSE · s)."""
        return 1.0 / (self.relmse * statistics.median(self.wall))


@dataclass
class Ratio:
    """A quotient of two series of runs that alternated."""

    median: float
    low: float
    high: float

    @classmethod
    def of(cls, above, below, factor=1.0):
        """The median of the quotients of neighbouring runs, with the smallest and the largest."""
        quotients = [factor * a / b for a, b in zip(above, below, strict=True)]
        return cls(statistics.median(quotients), min(quotients), max(quotients))

    def __str__(self):
        return f"{self.median:.2f} ({self.low:.2f}–{self.high:.2f})"
