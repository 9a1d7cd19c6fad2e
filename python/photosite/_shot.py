"""Exposures: what a sensor has made of light, with truth at each stage."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Mapping
from contextlib import suppress
from functools import cached_property
from typing import Any, Optional

import numpy as np
import numpy.typing as npt

from . import _photosite
from ._arguments import Path, invalid, path_of
from ._camera import Camera
from ._errors import Error, no_layer
from ._raw import Raw

__all__ = ["Layers", "Shot"]

#: Layers of ground truth and their units.
TRUTH_UNITS = dict(_photosite.truth_units())


class Layers(Mapping[str, "npt.NDArray[np.float32]"]):
    """Arrays by their names, each of which is computed when it is asked for first and kept.

    Attributes:
        units: the unit of each layer by its name; empty for numbers without one.
    """

    def __init__(self, compute: "Callable[[str], npt.NDArray[np.float32]]", units: "Mapping[str, str]") -> None:
        self._compute = compute
        self._known: "dict[str, npt.NDArray[np.float32]]" = {}
        self.units: "Mapping[str, str]" = dict(units)

    def __getitem__(self, name: str) -> "npt.NDArray[np.float32]":
        if name not in self._known:
            if name not in self.units:
                raise no_layer(str(name), self.units)
            self._known[name] = self._compute(name)
        return self._known[name]

    def __contains__(self, name: object) -> bool:
        return name in self.units

    def __iter__(self) -> "Iterator[str]":
        return iter(self.units)

    def __len__(self) -> int:
        return len(self.units)

    def __reduce__(self) -> Any:
        # Another process gets the arrays: it has nothing to compute them of.
        arrays: "dict[str, npt.NDArray[np.float32]]" = {}
        for name in self:
            # Such as disparity without a partner.
            with suppress(Error):
                arrays[name] = self[name]
        return _known_layers, (arrays, {name: self.units[name] for name in arrays})

    def __repr__(self) -> str:
        return f"<photosite.Layers {', '.join(self.units)}>"


def _known_layers(arrays: "dict[str, npt.NDArray[np.float32]]", units: "dict[str, str]") -> Layers:
    return Layers(arrays.__getitem__, units)


def truth_layers(compiled: "_photosite.Light | _photosite.Shot") -> Layers:
    """The ground truth of the scene that light comes from."""
    return Layers(lambda name: compiled.truth([name])[0], TRUTH_UNITS)


def noise_unit(name: str) -> str:
    """The unit of a noise map, with which its name ends."""
    return "e-" if name.endswith("_e") else "DN" if name.endswith("_dn") else ""


class Shot:
    """One exposure. Made by :func:`photosite.render`, ``Light.expose`` and ``Sensor.expose``.

    What takes time or memory is computed when it is asked for, and kept.
    """

    def __init__(self, compiled: "_photosite.Shot", owner: object = None) -> None:
        self._compiled = compiled
        # Files of the scene that are there as long as somebody may ask for more of it.
        self._owner = owner

    # The raw image

    @cached_property
    def raw(self) -> Raw:
        """The raw image: ``np.asarray(shot.raw)`` is (H, W) uint16, with levels, filters and matrices beside."""
        return Raw(self._compiled.raw())

    @cached_property
    def image(self) -> "npt.NDArray[Any]":
        """The image as the capture's ``[develop]`` says: (h, w, 3) uint8, (h, w) without colours, uint16 for more
        than 8 bits. :func:`photosite.develop` develops :attr:`raw` in other ways."""
        return self._compiled.image()

    # What it was made of

    @property
    def channels(self) -> "tuple[str, ...]":
        """Names of the channels of :attr:`electrons`: those of the colour filters."""
        return tuple(self._compiled.channels())

    @cached_property
    def _electrons(self) -> "tuple[npt.NDArray[np.float32], Optional[npt.NDArray[np.float32]]]":
        return self._compiled.electrons()

    @property
    def electrons(self) -> "npt.NDArray[np.float32]":
        """Mean photo-electrons of every channel at every pixel, without noise of the sensor: (H, W, C) float32, e⁻."""
        return self._electrons[0]

    @property
    def variance(self) -> "npt.NDArray[np.float32]":
        """Variance of :attr:`electrons` that light transport has left, (e⁻)²: (H, W, C) float32.

        Raises:
            InputError: light whose variance is not known: that of :class:`photosite.Sensor`, and of a sensor for which
                light was not traced.
        """
        variance = self._electrons[1]
        if variance is None:
            raise invalid("variance", "is not known for this light", "trace light for this sensor to have it")
        return variance

    @cached_property
    def noise(self) -> Layers:
        """What each effect of the sensor has added to each number, by its name: (H, W) float32, e⁻ up to the gain and
        DN behind it, see ``noise.units``. The sum times the gain, with the black level, is the raw image. See
        ``output.noise`` of capture files."""
        names = self._compiled.noise_names()
        return Layers(self._compiled.noise, {name: noise_unit(name) for name in names})

    @cached_property
    def truth(self) -> Layers:
        """Ground truth at the centre of each pixel of the whole sensor, whatever is read out of it, float32.

        ``depth`` along the axis and ``distance`` in m, (H, W); ``position`` in m, ``normal``, ``shading-normal`` of the
        world and ``albedo``, (H, W, 3); ``object-position`` in m and ``nocs`` in the frame of the object, (H, W, 3);
        ``uv``, (H, W, 2); numbers of ``instance`` and ``material``, (H, W); ``flow`` in px and whether its end is
        visible, (H, W, 3); ``disparity`` likewise where the capture has a partner. Where nothing is seen, depths are
        inf, positions NaN, and all else 0.
        """
        return truth_layers(self._compiled)

    @cached_property
    def camera(self) -> Camera:
        """Pose and intrinsics.

        Raises:
            InputError: light that does not come from a scene.
        """
        camera = self.report.get("camera")
        if camera is None:
            raise invalid("camera", "is not known for light that does not come from a scene")
        return Camera.of_report(camera)

    # How it was exposed

    @property
    def frame(self) -> int:
        """Its number in a series, from 0, which decides its temporal noise."""
        return self._compiled.frame()

    @property
    def time_s(self) -> float:
        """Exposure time, s; of an automatic exposure the one that was found."""
        return self._compiled.exposure()[0]

    @property
    def gain_db(self) -> float:
        """Analogue gain, dB."""
        return self._compiled.exposure()[1]

    @property
    def digital_gain_db(self) -> float:
        """Digital gain, dB."""
        return self._compiled.exposure()[2]

    @property
    def system_gain_dn_per_e(self) -> float:
        """EMVA 1288's overall system gain K at these gains, DN/e⁻: a number of the raw image, less the black level, is K
        times the electrons of its pixel and noise, where the sensor is linear; with binning, those of all pixels that
        became one number, whether they were added or averaged."""
        gain: float = self.report["sensor"]["system_gain_dn_per_e"]
        return gain

    @property
    def temperature_c(self) -> float:
        """Temperature of the sensor, °C."""
        return self._compiled.exposure()[3]

    @cached_property
    def noise_ratio(self) -> Optional[float]:
        """Monte Carlo noise over the noise of the sensor at this exposure, root-mean-square over the image, as the command
        tells it: 0.1 is not seen, 1 is as much again. Saturated pixels show no noise and do not count. None in the dark,
        where all pixels are saturated, after a single sample of each pixel, and for light that does not come from a scene."""
        return self._compiled.noise_ratio()

    @cached_property
    def report(self) -> "dict[str, Any]":
        """What ``capture.json`` of the command says of it, without files and timings."""
        report: "dict[str, Any]" = json.loads(self._compiled.report())
        return report

    # Out

    def save(self, folder: Path, *, overwrite: bool = False) -> "dict[str, Any]":
        """Writes what the command writes, with the same bytes: the raw image, the developed image, electrons, and what else
        ``[output]`` of the capture asks for, with ``capture.json`` last.

        The command that gives the same has one seed for light and noise: of a shot whose seed is not that of its light
        it traces other light, with Monte Carlo noise of its own.

        Args:
            folder: created where missing.
            overwrite: whether earlier results there may go.

        Returns:
            What ``capture.json`` holds.

        Raises:
            InputError: a folder with earlier results.
            FileError: one that cannot be written to.
        """
        report: "dict[str, Any]" = json.loads(self._compiled.save(path_of("folder", folder), bool(overwrite)))
        return report

    def to_xarray(self) -> Any:
        """The arrays of the shot as an ``xarray.Dataset``: ``raw``, ``image``, ``electrons`` and, where it is known,
        ``variance``, over ``y`` and ``x`` (px, whole at pixel centres) and ``channel``, with ``units``. Needs xarray."""
        import xarray

        rows, columns = self.electrons.shape[:2]
        arrays: "dict[str, Any]" = {"electrons": (("y", "x", "channel"), self.electrons, {"units": "e-"})}
        if self._electrons[1] is not None:
            arrays["variance"] = (("y", "x", "channel"), self.variance, {"units": "e-2"})
        raw = np.asarray(self.raw)
        coordinates: "dict[str, Any]" = {
            "y": ("y", np.arange(rows), {"units": "px"}),
            "x": ("x", np.arange(columns), {"units": "px"}),
            "channel": list(self.channels),
        }
        # Masked pixels, binning and development change the grid.
        own = "" if raw.shape[:2] == (rows, columns) else "raw_"
        axes = (f"{own}y", f"{own}x") + (("channel",) if raw.ndim == 3 else ())
        arrays["raw"] = (axes, raw, {"units": "DN"})
        picture = "" if self.image.shape[:2] == (rows, columns) else "image_"
        colours = ("rgb",) if self.image.ndim == 3 else ()
        arrays["image"] = ((f"{picture}y", f"{picture}x") + colours, self.image, {"units": "1"})
        if self.image.ndim == 3:
            coordinates["rgb"] = ["R", "G", "B"]
        attributes = {"time_s": self.time_s, "gain_db": self.gain_db, "temperature_c": self.temperature_c}
        return xarray.Dataset(arrays, coordinates, attributes)

    def __reduce__(self) -> Any:
        raise TypeError("a shot cannot be pickled, as it holds its light; pickle its arrays, its raw image or its capture")

    def __repr__(self) -> str:
        shape = " × ".join(str(n) for n in self.raw.shape[1::-1])
        noise = "" if self.noise_ratio is None else f", Monte Carlo noise {self.noise_ratio:.2g} × the sensor's"
        return f"<photosite.Shot {shape} px, {self.time_s * 1e3:g} ms, {self.gain_db:g} dB{noise}>"
