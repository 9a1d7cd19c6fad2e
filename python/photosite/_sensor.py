"""Sensors alone, exposed to anybody's images of light."""

from __future__ import annotations

import copy
import json
from collections.abc import Mapping, Sequence
from typing import Any, Optional, Union, overload

import numpy as np
import numpy.typing as npt

from . import _photosite
from ._arguments import Path, as_array, assignments, floats, invalid, number, path_of
from ._arguments import names as names_of
from ._light import count, exposure_changes
from ._shot import Shot

__all__ = ["Sensor", "expose"]

#: What light is neutral: its name, as ``"D65"``, or wavelengths in nm and values.
Illuminant = Union[str, "tuple[npt.ArrayLike, npt.ArrayLike]", None]


class Sensor:
    """An image sensor, which makes raw images of light that any program has computed.

    Args:
        name: a preset, as ``photosite sensors`` lists them, or the path of a sensor file (.toml).
        set: values for keys of the sensor, as in ``{"noise.read_noise_e": 3, "serial": 7}``.

    Raises:
        InputError: a sensor that is not known, a key that it does not have, a value that it cannot have.

    Sensors can be pickled.
    """

    def __init__(self, name: Path, *, set: "Optional[Mapping[str, Any]]" = None) -> None:
        self._name = path_of("name", name)
        self._keys: "Mapping[str, Any]" = {} if set is None else copy.deepcopy(set)
        self._changes = [_below_sensor(change) for change in assignments(self._keys)]
        self._compiled = _photosite.Sensor(self._name, self._changes)

    @property
    def name(self) -> str:
        """What it is called."""
        return self._compiled.name()

    @property
    def source(self) -> str:
        """The preset or the file that it is of."""
        return self._name

    @property
    def changes(self) -> "list[str]":
        """Its changed keys as the library reads them, ``key=value``."""
        return list(self._changes)

    @property
    def values(self) -> "dict[str, Any]":
        """All its keys by the tables of a sensor file, with changes: ``values["noise"]["read_noise_e"]``."""
        values: "dict[str, Any]" = json.loads(self._compiled.values())
        return values

    @property
    def resolution_px(self) -> "tuple[int, int]":
        """Columns and rows of the whole sensor. One that is exposed to an array has as many as that."""
        columns, rows = self._compiled.resolution()
        return columns, rows

    @property
    def pixel_pitch_um(self) -> "tuple[float, float]":
        """Horizontal and vertical distance of pixels, µm."""
        x, y = self._compiled.pixel_pitch_m()
        return round(x * 1e6, 9), round(y * 1e6, 9)

    @property
    def channels(self) -> "tuple[str, ...]":
        """Names of the channels of its colour filters."""
        return tuple(self._compiled.channels())

    def responses(self) -> "dict[str, tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]]":
        """What each channel makes of light: wavelengths λ in nm, (N,), and the electrons a second that an irradiance of
        1 W·m⁻²·nm⁻¹ frees in a pixel, η(λ)·A·λ/(h·c), (N,), linear in between. η is the quantum efficiency with all
        filters, A the area of a pixel."""
        return {name: (wavelengths, values) for name, wavelengths, values in self._compiled.responses()}

    @overload
    def expose(
        self,
        light: "npt.ArrayLike",
        /,
        *,
        time_s: Optional[float] = ...,
        wavelengths_nm: "Optional[npt.ArrayLike]" = ...,
        unit: Optional[str] = ...,
        one: float = ...,
        wavelength_nm: Optional[float] = ...,
        channels: "Optional[Sequence[str]]" = ...,
        illuminant: Illuminant = ...,
        gain_db: Optional[float] = ...,
        seed: Optional[int] = ...,
        frames: None = ...,
        set: "Optional[Mapping[str, Any]]" = ...,
        threads: Optional[int] = ...,
    ) -> Shot: ...
    @overload
    def expose(
        self,
        light: "npt.ArrayLike",
        /,
        *,
        time_s: Optional[float] = ...,
        wavelengths_nm: "Optional[npt.ArrayLike]" = ...,
        unit: Optional[str] = ...,
        one: float = ...,
        wavelength_nm: Optional[float] = ...,
        channels: "Optional[Sequence[str]]" = ...,
        illuminant: Illuminant = ...,
        gain_db: Optional[float] = ...,
        seed: Optional[int] = ...,
        frames: int,
        set: "Optional[Mapping[str, Any]]" = ...,
        threads: Optional[int] = ...,
    ) -> "list[Shot]": ...
    def expose(
        self,
        light: "npt.ArrayLike",
        /,
        *,
        time_s: Optional[float] = None,
        wavelengths_nm: "Optional[npt.ArrayLike]" = None,
        unit: Optional[str] = None,
        one: float = 1.0,
        wavelength_nm: Optional[float] = None,
        channels: "Optional[Sequence[str]]" = None,
        illuminant: Illuminant = None,
        gain_db: Optional[float] = None,
        seed: Optional[int] = None,
        frames: Optional[int] = None,
        set: "Optional[Mapping[str, Any]]" = None,
        threads: Optional[int] = None,
    ) -> "Union[Shot, list[Shot]]":
        """Exposes the sensor to light that falls on it, a pixel of the sensor for each pixel of an array.

        Args:
            light: with ``wavelengths_nm`` spectral irradiance on the sensor, (H, W, B) in W·m⁻²·nm⁻¹. With ``unit``
                numbers of which ``one`` is so much:

                - ``"lux"``: linear RGB of sRGB's primaries, (H, W, 3), or grey, (H, W). RGB is upsampled to spectra by
                  Jakob and Hanika (2019) and multiplied with D65; white (1, 1, 1) is D65 of ``one`` lx on the sensor;
                - ``"electrons"``: mean photo-electrons of the exposure for each channel of the sensor, (H, W, C);
                - ``"full-well"``: the same as parts of the full well;
                - ``"irradiance"``: W·m⁻² at the single ``wavelength_nm``, (H, W).

                Numbers below 0 count as 0, with a warning. float32, or what converts to it.
            time_s: exposure time, s; automatic unless said, where the light is a rate.
            wavelengths_nm: (B,), increasing: centres of the bands, which reach half way to their neighbours.
            unit: what the numbers are.
            one: how much of the unit a number of 1 is, such as the illuminance of white.
            wavelength_nm: that of ``"irradiance"``.
            channels: names of the channels of ``light``; those of the sensor in their order unless said.
            illuminant: the light that white balance makes neutral; D65 unless said, with a warning.
            gain_db: analogue gain, dB.
            seed: seed of temporal noise. The same seed draws the same random numbers for a pixel, whatever the light and
                however long. Exposures whose noise should be independent need seeds of their own.
            frames: so many exposures, each with temporal noise of its own.
            set: values for keys of ``sensor``, ``exposure``, ``develop`` and ``output``.
            threads: threads to use.

        Returns:
            A shot, or with ``frames`` a list of them.

        Raises:
            InputError: an array of another form, one that holds NaN or infinity, or that the sensor has no use for.
        """
        changes = [*assignments({"sensor.preset": self._name}), *self._changes]
        changes += exposure_changes(None, time_s=time_s, gain_db=gain_db, seed=seed, set=set)
        times, threads, white = count("frames", frames), count("threads", threads, None), _spectrum(illuminant)
        if wavelengths_nm is not None:
            if unit is not None:
                raise invalid("unit", "goes with numbers that are not spectral irradiance", "leave unit or wavelengths_nm out")
            cube, centres = _bands(light, wavelengths_nm)
            compiled = _photosite.expose_irradiance(cube, centres, white, changes, times, threads)
        elif unit is None:
            help = "give wavelengths_nm for spectral irradiance, or unit, for example unit=\"lux\", one=500"
            raise invalid("unit", "nothing says what the pixel values of the light are", help)
        else:
            numbers, names = self._planes(light, unit, channels)
            length = None if wavelength_nm is None else number("wavelength_nm", wavelength_nm)
            compiled = _photosite.expose_planes(
                numbers, names, str(unit), number("one", one), length, white, changes, times, threads
            )
        shots = [Shot(shot) for shot in compiled]
        return shots[0] if frames is None else shots

    def _planes(
        self, light: "npt.ArrayLike", unit: str, channels: "Optional[Sequence[str]]"
    ) -> "tuple[npt.NDArray[np.float32], list[str]]":
        """Numbers as planes, and the names of these."""
        numbers = floats("light", light, "(H, W) or (H, W, C)", (2, 3))
        if numbers.ndim == 2:
            numbers = numbers[:, :, np.newaxis]
        planes = numbers.shape[2]
        if channels is not None:
            names = names_of("channels", channels)
        elif unit in ("lux", "irradiance"):
            names = ["Y"] if planes == 1 else ["R", "G", "B"]
        else:
            names = list(self.channels)
        if len(names) != planes:
            expected = f"(H, W, {len(names)}) of {', '.join(names)}"
            raise invalid("light", f"expected an array {expected}, got one of shape {np.shape(light)}")
        return numbers, names

    def __reduce__(self) -> Any:
        return _sensor, (self._name, self._keys)

    def __repr__(self) -> str:
        columns, rows = self.resolution_px
        return f"<photosite.Sensor {self.name}, {columns} × {rows} px, {', '.join(self.channels)}>"


def _sensor(name: str, keys: "Mapping[str, Any]") -> Sensor:
    return Sensor(name, set=keys)


def _below_sensor(change: str) -> str:
    return change if change.startswith("sensor.") else f"sensor.{change}"


def _bands(
    light: "npt.ArrayLike", wavelengths_nm: "npt.ArrayLike"
) -> "tuple[npt.NDArray[np.float32], list[float]]":
    cube = floats("light", light, "(H, W, B)", (3,))
    centres = as_array("wavelengths_nm", wavelengths_nm, (1,), "(B,)").astype(np.float64)
    if len(centres) != cube.shape[2]:
        raise invalid("wavelengths_nm", f"there are {len(centres)} for an array of shape {cube.shape}, (H, W, B)")
    if not (np.isfinite(centres).all() and (np.diff(centres) > 0).all() and len(centres) > 1 and centres[0] > 0):
        raise invalid("wavelengths_nm", "expected two or more numbers above 0 that increase", "sort the bands by wavelength")
    if centres[-1] < 50:
        raise invalid("wavelengths_nm", f"expected nm, got {centres[0]:g} to {centres[-1]:g}", "multiply µm by 1000")
    return cube, centres.tolist()


def _spectrum(illuminant: Illuminant) -> "Optional[tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]]":
    if illuminant is None:
        return None
    if isinstance(illuminant, str):
        return _photosite.illuminant_spectrum(illuminant)
    if not isinstance(illuminant, tuple) or len(illuminant) != 2:
        help = 'for example illuminant="D65", or (wavelengths_nm, values)'
        raise invalid("illuminant", f"expected a name or two arrays, got {type(illuminant).__name__}", help)
    wavelengths, values = (as_array("illuminant", part, (1,), "(N,)").astype(np.float64) for part in illuminant)
    if (values < 0).any() or not (values > 0).any():
        raise invalid("illuminant", "expected values of 0 and more, not all 0")
    return np.ascontiguousarray(wavelengths), np.ascontiguousarray(values)


def expose(
    stored: Path,
    /,
    *,
    time_s: Optional[float] = None,
    gain_db: Optional[float] = None,
    seed: Optional[int] = None,
    set: "Optional[Mapping[str, Any]]" = None,
    threads: Optional[int] = None,
) -> Shot:
    """Exposes light that a render has left: a folder, or ``electrons.exr`` or ``irradiance.exr`` of one, as the command
    ``photosite expose`` does.

    Args:
        stored: the folder or the file.
        time_s: exposure time, s.
        gain_db: analogue gain, dB.
        seed: seed of temporal noise.
        set: values for keys of ``sensor``, ``exposure``, ``develop`` and ``output``.
        threads: threads to use.

    Raises:
        InputError: a folder without light, a sensor that this light does not serve.
    """
    place = path_of("stored", stored)
    changes = exposure_changes(None, time_s=time_s, gain_db=gain_db, seed=seed, set=set)
    [shot] = _photosite.expose_stored(place, changes, 1, count("threads", threads, None))
    return Shot(shot)
