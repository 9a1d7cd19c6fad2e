"""EMVA 1288: the figures of a sensor as its images show them."""

from __future__ import annotations

import json
import os
import tempfile
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Optional, Union, overload

from . import _photosite
from ._arguments import Path, assignments, invalid, path_of
from ._progress import Progress, listener
from ._sensor import Sensor

__all__ = ["ChannelFigures", "Emva1288Report", "Figures", "SpatialFigures", "emva1288", "emva1288_report"]


@dataclass(frozen=True)
class SpatialFigures:
    """A spatial non-uniformity: total² = row² + column² + pixel². None stands for what temporal noise hides."""

    total: Optional[float]
    row: Optional[float]
    column: Optional[float]
    pixel: Optional[float]


@dataclass(frozen=True)
class Figures:
    """The figures of an EMVA 1288 data sheet. None stands for what cannot be known.

    Attributes:
        system_gain_dn_per_e: system gain K, DN/e⁻.
        responsivity_dn_per_p: responsivity R = K·η, DN per photon.
        quantum_efficiency: η, electrons per photon that falls on the pixel's whole area, 0–1.
        dark_noise_e: temporal dark noise σ_d, without quantisation, e⁻.
        dark_noise_dn: temporal dark noise σ_y.dark, DN.
        saturation_e: saturation capacity, e⁻.
        saturation_p: saturation capacity, photons.
        sensitivity_threshold_p: absolute sensitivity threshold, photons.
        sensitivity_threshold_e: absolute sensitivity threshold, e⁻.
        snr_max: largest signal-to-noise ratio, √saturation_e.
        dynamic_range: saturation_p/sensitivity_threshold_p.
        dsnu_e: dark signal non-uniformity DSNU₁₂₈₈, e⁻.
        prnu_percent: photo response non-uniformity PRNU₁₂₈₈, percent.
        linearity_error_min_percent: smallest (most negative) linearity error, percent.
        linearity_error_max_percent: largest linearity error, percent.
        dark_current_mean_e_per_s: dark current from the mean, e⁻/s.
        dark_current_variance_e_per_s: dark current from the variance, e⁻/s.
        dark_current_mean_error_e_per_s: standard error of that from the mean, e⁻/s; None of expected figures.
        dark_current_variance_error_e_per_s: standard error of that from the variance, e⁻/s; likewise.
    """

    system_gain_dn_per_e: float
    responsivity_dn_per_p: float
    quantum_efficiency: float
    dark_noise_e: float
    dark_noise_dn: float
    saturation_e: float
    saturation_p: float
    sensitivity_threshold_p: float
    sensitivity_threshold_e: float
    snr_max: float
    dynamic_range: float
    dsnu_e: SpatialFigures
    prnu_percent: SpatialFigures
    linearity_error_min_percent: Optional[float]
    linearity_error_max_percent: Optional[float]
    dark_current_mean_e_per_s: Optional[float]
    dark_current_variance_e_per_s: Optional[float]
    dark_current_mean_error_e_per_s: Optional[float] = None
    dark_current_variance_error_e_per_s: Optional[float] = None


@dataclass(frozen=True)
class ChannelFigures:
    """What the images of a channel show.

    Attributes:
        title: the channel, the wavelength of its light and the temperature of the sensor.
        measured: its figures.
        expected: the figures that a sensor's model must show; None of images of another camera.
        not_measured: what the images do not tell, and why.
        wavelengths: ``wavelength_nm`` with the ``expected`` and ``measured`` quantum efficiency of each.
        temperatures: ``temperature_c`` with the ``expected`` dark current, and those ``from_mean`` and
            ``from_variance``, e⁻/s; None where they are not told apart from 0.
        doubling_temperature_k: rise of temperature that doubles the dark current, expected and measured, K.
    """

    title: str
    measured: Figures
    expected: Optional[Figures]
    not_measured: "tuple[dict[str, str], ...]"
    wavelengths: "tuple[dict[str, Any], ...]"
    temperatures: "tuple[dict[str, Any], ...]"
    doubling_temperature_k: "Optional[tuple[float, float]]"


@dataclass(frozen=True)
class Emva1288Report(Sequence[ChannelFigures]):
    """The figures of all channels, in the order of the sensor's.

    Attributes:
        channels: their figures.
        html: the page that ``photosite emva1288-report`` writes, with all curves.
    """

    channels: "tuple[ChannelFigures, ...]"
    html: str = field(repr=False)

    @overload
    def __getitem__(self, index: int) -> ChannelFigures: ...

    @overload
    def __getitem__(self, index: slice) -> "tuple[ChannelFigures, ...]": ...

    def __getitem__(self, index: "Union[int, slice]") -> "Union[ChannelFigures, tuple[ChannelFigures, ...]]":
        return self.channels[index]

    def __len__(self) -> int:
        return len(self.channels)

    def _repr_html_(self) -> str:
        return self.html


def emva1288(
    sensor: "Union[Sensor, Path]",
    /,
    *,
    output: Optional[Path] = None,
    overwrite: bool = False,
    set: Optional[Mapping[str, Any]] = None,
    like: Optional[Path] = None,
    channels: Optional[Sequence[str]] = None,
    wavelength_nm: Optional[float] = None,
    steps: int = 50,
    spatial: int = 50,
    saturation_time_s: Optional[float] = None,
    sweep_nm: Sequence[float] = (),
    temperatures_c: Sequence[float] = (),
    temperature_c: Optional[float] = None,
    gain_db: float = 0.0,
    size_px: "Optional[tuple[int, int]]" = None,
    seed: int = 0,
    threads: Optional[int] = None,
    progress: Progress = None,
) -> Emva1288Report:
    """Takes the images that EMVA 1288 asks for, of a sensor's model before an even light, and measures them.

    Args:
        sensor: a :class:`Sensor`, the name of a preset, or the path of a sensor file.
        output: a folder that keeps the images; without, they go when they are measured.
        overwrite: replace image sets that are in the folder already.
        set: keys of the sensor to change: ``{"noise.read_noise_e": 2}``.
        like: take the same images as this set, a descriptor or a folder of image sets: its exposure times, photons,
            numbers of images and size, in place of ``steps``, ``spatial`` and ``saturation_time_s``.
        channels: names of the channels; without, all.
        wavelength_nm: wavelength of the light, 300 to 1100; without, where each channel's quantum efficiency is
            greatest.
        steps: exposure times of the photon transfer curve, 5 to 1000.
        spatial: images of each stack for spatial non-uniformity, 3 to 10000.
        saturation_time_s: exposure time that saturates; without, long enough to measure the dark current.
        sweep_nm: measure the quantum efficiency at these wavelengths, too.
        temperatures_c: measure the dark current at these temperatures, too.
        temperature_c: temperature of the sensor; without, 25 °C, or that of ``like``.
        gain_db: gain of all exposures.
        size_px: columns and rows of the images; without, 512 × 512, or what the sensor has.
        seed: seed of temporal noise; another camera of the same make is ``set={"serial": 1}``.
        threads: threads to use; without, all cores.
        progress: False for no bar, True for one, None for one in terminals and notebooks, or a function that is called
            with how many images are done, and of how many.

    Returns:
        The figures of each channel, measured and expected: ``report[0].measured.system_gain_dn_per_e``.

    Raises:
        InputError: a sensor, a key or a channel that there is not, exposures that the sensor cannot make.
        FileError: the folder cannot be written to.
    """
    for name, value, least, most in (("steps", steps, 5, 1000), ("spatial", spatial, 3, 10_000)):
        if not (int(value) == value and least <= value <= most):
            raise invalid(name, f"expected a whole number from {least} to {most}, got {value}")
    lights = [("sweep_nm", nm) for nm in sweep_nm]
    if wavelength_nm is not None:
        lights.append(("wavelength_nm", wavelength_nm))
    for name, nm in lights:
        if not 300 <= nm <= 1100:
            raise invalid(name, f"expected wavelengths from 300 to 1100 nm, got {nm}")
    if saturation_time_s is not None and not 0 < saturation_time_s < float("inf"):
        raise invalid("saturation_time_s", f"expected a time above 0, got {saturation_time_s}")
    if seed < 0:
        raise invalid("seed", f"expected a whole number of at least 0, got {seed}")
    name, changes = (sensor.source, sensor.changes) if isinstance(sensor, Sensor) else (path_of("sensor", sensor), [])
    request = {
        "overrides": [*changes, *assignments({} if set is None else set)],
        "like": None if like is None else path_of("like", like),
        "channels": None if channels is None else [str(name) for name in channels],
        "wavelength_nm": None if wavelength_nm is None else float(wavelength_nm),
        "steps": int(steps),
        "spatial": int(spatial),
        "saturation_time_s": None if saturation_time_s is None else float(saturation_time_s),
        "sweep_nm": [float(nm) for nm in sweep_nm],
        "temperatures_c": [float(celsius) for celsius in temperatures_c],
        "temperature_c": None if temperature_c is None else float(temperature_c),
        "gain_db": float(gain_db),
        "size": None if size_px is None else _size(size_px),
        "seed": int(seed),
    }
    told = listener(progress, "emva1288", "images")

    def take(folder: str) -> Emva1288Report:
        _photosite.take_image_sets(name, folder, bool(overwrite), request, threads, told)
        return _evaluated(folder, threads, None)

    if output is not None:
        return take(path_of("output", output))
    with tempfile.TemporaryDirectory(prefix="photosite-emva1288-") as folder:
        return take(os.path.join(folder, "sets"))


def emva1288_report(
    images: Path,
    /,
    *,
    threads: Optional[int] = None,
    progress: Progress = None,
) -> Emva1288Report:
    """Measures image sets as EMVA 1288 has it.

    Args:
        images: a folder that :func:`emva1288` or ``photosite emva1288`` filled, or a descriptor of images of any camera
            (``.txt``): "n 12 640 480" for bits, columns and rows, "b 20000000 1234.5" for exposure time in ns and
            photons a pixel before bright images, "d 20000000" before dark ones, "i images\\\\a.tif" for each.
        threads: threads to use; without, all cores.
        progress: False for no bar, True for one, None for one in terminals and notebooks, or a function that is called
            with how many images are done, and of how many.

    Raises:
        InputError: a folder without image sets, images that do not fit together.
        FileError: a file cannot be read.
    """
    return _evaluated(path_of("images", images), threads, listener(progress, "emva1288", "images"))


def _evaluated(
    path: str, threads: Optional[int], progress: "Optional[Callable[[int, int], object]]"
) -> Emva1288Report:
    text, html = _photosite.evaluate_image_sets(path, threads, progress)
    return Emva1288Report(tuple(_channel(known) for known in json.loads(text)), html)


def _channel(known: "dict[str, Any]") -> ChannelFigures:
    expected, doubling = known["expected"], known["doubling_temperature_k"]
    return ChannelFigures(
        title=known["channel"],
        measured=_figures(known["measured"]),
        expected=None if expected is None else _figures(expected),
        not_measured=tuple(known["not_measured"]),
        wavelengths=tuple(known["wavelengths"]),
        temperatures=tuple(known["temperatures"]),
        doubling_temperature_k=None if doubling is None else (doubling[0], doubling[1]),
    )


def _figures(known: "dict[str, Any]") -> Figures:
    spatial: "dict[str, Any]" = {name: SpatialFigures(**known[name]) for name in ("dsnu_e", "prnu_percent")}
    return Figures(**{**known, **spatial})


def _size(size_px: "Union[Sequence[int], Any]") -> "list[int]":
    try:
        size = [int(side) for side in size_px]
    except (TypeError, ValueError):
        size = []
    if len(size) != 2 or min(size) < 1:
        raise invalid("size_px", f"expected columns and rows, got {size_px}", "for example size_px=(512, 512)")
    return size
