"""Sensors fitted to the images of a camera."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path as FilePath
from typing import Any, Optional

import numpy as np
import numpy.typing as npt

from . import _photosite
from ._arguments import Path, invalid, path_of
from ._progress import Progress, listener

__all__ = ["CameraFit", "Parameter", "fit"]


@dataclass(frozen=True)
class Parameter:
    """A parameter of a sensor, found in images.

    Attributes:
        value: the value.
        standard_error: its standard error, in the same unit.
        unit: the unit; empty for figures without one.
    """

    value: float
    standard_error: float
    unit: str


@dataclass(frozen=True)
class CameraFit:
    """The twin of a camera.

    Attributes:
        parameters: keys of the sensor file that the images tell.
        assumed: keys that a sensor file needs and the images do not tell, with the reason for each value.
        left_out: what the images do not tell, ``figure`` and ``reason`` of each.
        notes: statements about the images, such as light that drifts.
        report: all that ``photosite fit --json`` prints: the curves, the defective pixels, and of images at several gains
            ``gain_steps``, too.
        sensor_file: text of the sensor file.
        prnu_map: with ``maps``, the response of each pixel over their mean, rows x columns; None without flats.
        dsnu_map_e: with ``maps``, the offset of each pixel's dark signal in electrons of the sensor file; None where DSNU
            changes with gain.
    """

    parameters: "Mapping[str, Parameter]"
    assumed: "Mapping[str, str]"
    left_out: "tuple[dict[str, str], ...]"
    notes: "tuple[str, ...]"
    report: "dict[str, Any]" = field(repr=False)
    sensor_file: str = field(repr=False)
    prnu_map: "Optional[npt.NDArray[np.float32]]" = field(repr=False, compare=False)
    dsnu_map_e: "Optional[npt.NDArray[np.float32]]" = field(repr=False, compare=False)
    _fitted: _photosite.FittedCamera = field(repr=False, compare=False)

    def save(self, path: Path) -> None:
        """Writes the sensor file, which :class:`Sensor` and captures name by its path. Maps stand beside it, as
        ``NAME.prnu.npy`` and ``NAME.dsnu.npy``, and take the place of PRNU and DSNU; with them ``NAME.defects.csv``, the
        places of defective pixels.

        Args:
            path: its name ends in ``.toml``.
        """
        file = FilePath(path_of("path", path))
        maps = {"prnu": self.prnu_map, "dsnu": self.dsnu_map_e}
        for name, values in maps.items():
            if values is not None:
                np.save(file.with_name(f"{file.stem}.{name}.npy"), values)
        has_maps = any(values is not None for values in maps.values())
        defects = self._fitted.defects_csv() if has_maps else None
        if defects is not None:
            file.with_name(f"{file.stem}.defects.csv").write_text(defects, encoding="utf-8")
        text = self._fitted.sensor_file(file.stem) if has_maps else self.sensor_file
        file.write_text(text, encoding="utf-8")


def fit(
    images: Path,
    /,
    *,
    channel: Optional[str] = None,
    system_gain_dn_per_e: Optional[float] = None,
    temperature_c: Optional[float] = None,
    pixel_pitch_um: Optional[float] = None,
    wavelength_nm: Optional[float] = None,
    maps: bool = False,
    threads: Optional[int] = None,
    progress: Progress = None,
) -> CameraFit:
    """Fits a sensor file to the images of a camera, as ``photosite fit`` does.

    Args:
        images: an EMVA 1288 set (a descriptor, ``.txt``, or a folder that :func:`emva1288` filled), or a folder of flats
            and dark images, or of dark images alone.
        channel: channel to fit, of image sets of a colour sensor or of a mosaic.
        system_gain_dn_per_e: system gain K, for images that do not tell it.
        temperature_c: temperature of the sensor, where no image states it.
        pixel_pitch_um: distance of the pixels, which images do not tell.
        wavelength_nm: wavelength of the light, for the statement about the quantum efficiency.
        maps: True for the measured patterns of response and dark signal, too: the twin of this very camera.
        threads: threads to use; without, all cores.
        progress: False for no bar, True for one, None for one in terminals and notebooks, or a function that is called
            with how many images are done, and of how many.

    Returns:
        Parameters with their standard errors: ``fit.parameters["noise.read_noise_e"].value``.

    Raises:
        InputError: images that are not of one camera, or of which none are dark.
        FileError: a file cannot be read.
    """
    numbers = {
        "system_gain_dn_per_e": system_gain_dn_per_e,
        "pixel_pitch_um": pixel_pitch_um,
        "wavelength_nm": wavelength_nm,
    }
    for name, value in numbers.items():
        if value is not None and not 0 < value < float("inf"):
            raise invalid(name, f"expected a number above 0, got {value}")
    known = {
        "channel": channel,
        "system_gain": None if system_gain_dn_per_e is None else float(system_gain_dn_per_e),
        "temperature_c": None if temperature_c is None else float(temperature_c),
        "pixel_pitch_um": None if pixel_pitch_um is None else [float(pixel_pitch_um)] * 2,
        "wavelength_nm": None if wavelength_nm is None else float(wavelength_nm),
    }
    told = listener(progress, "fit", "images")
    fitted = _photosite.fit_camera(path_of("images", images), known, maps, threads, told)
    report: "dict[str, Any]" = json.loads(fitted.report())
    prnu_map, dsnu_map_e = fitted.maps() if maps else [None, None]
    parameters = {p["key"]: Parameter(p["value"], p["standard_error"], p["unit"]) for p in report["parameters"]}
    return CameraFit(
        parameters=parameters,
        assumed={a["key"]: a["reason"] for a in report["assumed"]},
        left_out=tuple(report["left_out"]),
        notes=tuple(report["notes"]),
        report=report,
        sensor_file=fitted.sensor_file(),
        prnu_map=prnu_map,
        dsnu_map_e=dsnu_map_e,
        _fitted=fitted,
    )
