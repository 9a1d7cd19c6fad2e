"""Comparison of images: how far they lie apart, and whether noise explains it."""

from __future__ import annotations

import json
import math
import os
from dataclasses import dataclass, field
from typing import Any, Optional, Union, cast

import numpy as np
import numpy.typing as npt

from . import _photosite
from ._arguments import Path, as_array, floats, invalid, is_path
from ._raw import Raw

__all__ = ["Comparison", "DifferencePicture", "compare"]

#: An image: numbers, a raw image, or the path of a file.
Picture = Union["npt.ArrayLike", Raw, Path]
#: Variances: one for all numbers, an array of them, or the path of an EXR file.
Variance = Union[float, "npt.ArrayLike", Path]


@dataclass(frozen=True)
class DifferencePicture:
    """The differences of two images in false colours: blue where a is below b, red where it is above.

    Attributes:
        image: (H, W, 3) uint8.
        shows: what the colours stand for: differences, relative differences or z-scores.
        range: the difference at the ends of the colours.
    """

    image: "npt.NDArray[np.uint8]"
    shows: str
    range: float


@dataclass(frozen=True)
class Comparison:
    """How two images differ; b counts as the reference.

    Attributes:
        outcome: ``"agree"``, ``"differ"``, or ``"not judged"`` without variances and limits.
        failures: why they differ, a sentence each.
        channels: figures of each channel by its name: ``mean_a``, ``mean_b``, ``mean_difference``,
            ``mean_difference_percent``, ``rmse``, ``relative_mse``, ``mae``, ``peak``, ``psnr_db``, ``pixels``,
            ``non_finite``, ``variance_of``, ``z_scores``. None stands for what is infinite or does not exist.
        worst: the pixels that differ most: ``x``, ``y``, ``channel``, ``a``, ``b``, and ``z`` and ``p_value`` if known.
        verdict: whether noise explains the differences, and by which bounds; None where no channel has the variances of
            both images.
        untested: what noise cannot be asked about, and what to do about it.
        report: all of it as ``photosite compare --json`` prints it.
    """

    outcome: str
    failures: "tuple[str, ...]"
    channels: "dict[str, dict[str, Any]]"
    worst: "tuple[dict[str, Any], ...]"
    verdict: "Optional[dict[str, Any]]"
    untested: "tuple[dict[str, Any], ...]"
    report: "dict[str, Any]" = field(repr=False)
    _pictures: Any = field(repr=False, compare=False)

    @property
    def agrees(self) -> Optional[bool]:
        """Whether nothing tells the images apart; None where they are not judged."""
        return None if self.outcome == "not judged" else self.outcome == "agree"

    def picture(self, *, range: Optional[float] = None) -> DifferencePicture:
        """The differences as an image.

        Args:
            range: the difference at the ends of the colours; without, 4 for z-scores, and of relative differences what
                nearly all pixels stay within.
        """
        a, b, how = self._pictures
        if range is not None and not (math.isfinite(range) and range > 0):
            raise invalid("range", f"expected a number above 0, got {range}")
        return DifferencePicture(*_photosite.difference_picture(a, b, how, range))

    def __reduce__(self) -> Any:
        # What was compared stays behind; its differences cannot be drawn any more.
        return _unpickle, (self.report,)


def compare(
    a: Picture,
    b: Picture,
    /,
    *,
    variance_a: Optional[Variance] = None,
    variance_b: Optional[Variance] = None,
    samples_a: Optional[int] = None,
    samples_b: Optional[int] = None,
    channels: Optional["list[str]"] = None,
    masked: bool = False,
    alpha: float = 0.01,
    epsilon: float = 0.01,
    peak: Optional[float] = None,
    worst: int = 5,
    max_mean_difference_percent: Optional[float] = None,
    max_rmse: Optional[float] = None,
    max_relative_mse: Optional[float] = None,
) -> Comparison:
    """Compares two images, as ``photosite compare`` does.

    Args:
        a: an array (H, W) or (H, W, C), a :class:`Raw`, or the path of an EXR, PNG, TIFF, JPEG, NPY or raw file. Channels
            of an array are those of its attribute ``channels``, if it has one, or else ``Y``, or ``R``, ``G``, ``B`` and
            alpha ``A``; two axes of uint16 are ``raw``.
        b: the reference, of the same size and unit.
        variance_a: variance of the mean of each pixel of a: a number for all, 0 where a is exact, an array of the shape
            of a, or the path of an EXR file whose channel ``variance.X``, or else ``X``, is that of ``X``; without, what
            the file of a says.
        variance_b: the same of b.
        samples_a: samples per pixel whose second moments ``m2_X`` stand beside ``X`` in a, as of Mitsuba's integrator
            ``moment``, in place of a variance.
        samples_b: the same of b.
        channels: compare these channels only; of a mosaic ``raw``, or ``R``, ``G``, ``B``.
        masked: compare the masked pixels of raw images, too, not only those that see light.
        alpha: probability of saying that images differ which agree.
        epsilon: the ε of the relative MSE, the mean of (a − b)²/(b² + ε·mean(b)²).
        peak: white for the PSNR; without, the largest number that the image can hold, or the largest of b.
        worst: how many of the pixels that differ most are listed.
        max_mean_difference_percent: most that the mean of a channel may differ, in percent of that of b.
        max_rmse: most that the root mean squared error of a channel may be, in the unit of the images.
        max_relative_mse: most that the relative mean squared error of a channel may be.

    Raises:
        InputError: images that do not fit together, channels that do not exist, arrays that do not hold numbers.
        FileError: a file cannot be read.
    """
    _number("alpha", alpha, 0 < alpha < 1, "between 0 and 1")
    _number("epsilon", epsilon, epsilon >= 0, "of at least 0")
    _number("peak", peak, peak is None or peak > 0, "above 0")
    limits = {
        "max_mean_difference_percent": max_mean_difference_percent,
        "max_rmse": max_rmse,
        "max_relative_mse": max_relative_mse,
    }
    for name, limit in limits.items():
        _number(name, limit, limit is None or limit >= 0, "of at least 0")
    if worst < 0:
        raise invalid("worst", f"expected a whole number of at least 0, got {worst}")
    if isinstance(channels, str):
        raise invalid("channels", "expected a list of names, got one string", f"write channels=[{channels!r}]")
    compared_a = _compared("a", a, variance_a, samples_a, masked)
    compared_b = _compared("b", b, variance_b, samples_b, masked)
    names = None if channels is None else [str(name) for name in channels]
    how = {"channels": names, "alpha": alpha, "epsilon": epsilon, "peak": peak, "worst": int(worst), **limits}
    report: "dict[str, Any]" = json.loads(_photosite.compare(compared_a, compared_b, how))
    return _comparison(report, (compared_a, compared_b, how))


def _comparison(report: "dict[str, Any]", pictures: Any) -> Comparison:
    return Comparison(
        outcome=report["outcome"],
        failures=tuple(report["failures"]),
        channels={figures["channel"]: figures for figures in report["channels"]},
        worst=tuple(report["worst"]),
        verdict=report["verdict"],
        untested=tuple(report["untested"]),
        report=report,
        _pictures=pictures,
    )


def _unpickle(report: "dict[str, Any]") -> Comparison:
    return _comparison(report, (None, None, None))


def _number(name: str, value: Optional[float], is_fit: bool, wanted: str) -> None:
    if value is not None and not (math.isfinite(value) and is_fit):
        raise invalid(name, f"expected a number {wanted}, got {value}")


def _compared(
    name: str, picture: Picture, variance: Optional[Variance], samples: Optional[int], masked: bool
) -> "_photosite.ComparedPicture":
    """An image with its variances."""
    compared = _of(name, picture, masked)
    if samples is not None:
        if variance is not None:
            raise invalid(f"samples_{name}", f"cannot be combined with variance_{name}", "give one of them")
        if samples < 2:
            raise invalid(f"samples_{name}", f"expected at least 2, got {samples}")
        return compared.with_second_moments(int(samples))
    argument = f"variance_{name}"
    if variance is None:
        return compared
    if is_path(variance):
        return compared.with_variances_from(_of(argument, variance, masked))
    if np.ndim(variance) == 0:
        constant = float(cast(float, variance))
        _number(argument, constant, constant >= 0, "of at least 0")
        return compared.with_constant_variance(constant)
    array = floats(argument, variance, "(H, W) or (H, W, C)", (2, 3))
    if not isinstance(picture, Raw) and not is_path(picture) and array.shape != np.shape(picture):
        raise invalid(argument, f"expected shape {np.shape(picture)}, that of {name}, got {array.shape}")
    deep = array if array.ndim == 3 else array[:, :, None]
    channels = compared.channels()
    if deep.shape[2] != len(channels):
        has = f"{name} has {', '.join(channels)}"
        raise invalid(argument, f"expected an array (H, W, {len(channels)}), as {has}, got one of shape {array.shape}")
    return compared.with_variances_from(_photosite.ComparedPicture.of_array(argument, deep, channels, None, None))


def _of(name: str, picture: Any, masked: bool) -> "_photosite.ComparedPicture":
    if is_path(picture):
        return _photosite.ComparedPicture.read(os.fspath(picture), masked)
    if isinstance(picture, Raw):
        return _photosite.ComparedPicture.of_raw(name, picture._compiled, masked)  # pyright: ignore[reportPrivateUsage]
    array = as_array(name, picture, (2, 3), "(H, W) or (H, W, C)")
    numbers = floats(name, array, "(H, W) or (H, W, C)", (2, 3))
    deep = numbers if numbers.ndim == 3 else numbers[:, :, None]
    known: Any = getattr(picture, "channels", None)
    channels = None if known is None else [str(channel) for channel in known]
    if channels is None and deep.shape[2] > 4:
        channels = [str(index) for index in range(deep.shape[2])]
    if channels is not None and len(channels) != deep.shape[2]:
        raise invalid(name, f"has {deep.shape[2]} channels, but the names are {', '.join(channels)}")
    maximum = {"uint8": 255, "uint16": 65_535}.get(array.dtype.name)
    return _photosite.ComparedPicture.of_array(name, deep, channels, None, maximum)
