"""Light: traced once, exposed as often as one likes."""

from __future__ import annotations

import json
from collections.abc import Mapping
from functools import cached_property
from typing import Any, Optional, Union, overload

import numpy as np
import numpy.typing as npt

from . import _photosite
from ._arguments import Path, assignments, invalid, number, path_of
from ._camera import Camera
from ._capture import Capture, CaptureLike, loaded
from ._errors import warn_all
from ._progress import Progress, listener
from ._shot import Layers, Shot, truth_layers

__all__ = ["Light", "devices", "render", "render_into", "trace"]


class Light:
    """Light that was traced: the rates at which it frees electrons. Made by :func:`trace`."""

    def __init__(self, compiled: "_photosite.Light", capture: Capture) -> None:
        self._compiled = compiled
        self._capture = capture

    @property
    def capture(self) -> Capture:
        """The capture that it was traced for."""
        return self._capture

    @property
    def channels(self) -> "tuple[str, ...]":
        """Names of the channels: those of the sensor's colour filters."""
        return tuple(self._compiled.channels())

    @cached_property
    def _rates(self) -> "tuple[npt.NDArray[np.float32], npt.NDArray[np.float32]]":
        return self._compiled.rates()

    @property
    def electrons_per_s(self) -> "npt.NDArray[np.float32]":
        """Mean rate of photo-electrons of every channel at every pixel, e⁻/s: (H, W, C) float32."""
        return self._rates[0]

    @property
    def variance(self) -> "npt.NDArray[np.float32]":
        """Variance of :attr:`electrons_per_s` that light transport has left, (e⁻/s)²: (H, W, C) float32."""
        return self._rates[1]

    @cached_property
    def _irradiance(self) -> "Optional[tuple[npt.NDArray[np.float32], npt.NDArray[np.float64]]]":
        return self._compiled.irradiance()

    @property
    def irradiance(self) -> "npt.NDArray[np.float32]":
        """Spectral irradiance on the sensor in bands, W·m⁻²·nm⁻¹: (H, W, B) float32.

        Raises:
            InputError: a capture that did not ask for it with ``output.irradiance``.
        """
        return self._bands()[0]

    @property
    def wavelengths_nm(self) -> "npt.NDArray[np.float64]":
        """Central wavelengths of the bands of :attr:`irradiance`, nm: (B,) float64."""
        return self._bands()[1]

    def _bands(self) -> "tuple[npt.NDArray[np.float32], npt.NDArray[np.float64]]":
        if self._irradiance is None:
            help = 'load the capture with set={"output.irradiance": True}'
            raise invalid("irradiance", "was not kept when light was traced", help)
        return self._irradiance

    @property
    def samples(self) -> "npt.NDArray[np.uint32]":
        """Samples of each pixel: (H, W) uint32."""
        return self._compiled.samples()

    @property
    def paths(self) -> int:
        """Camera paths that were traced."""
        return self._compiled.paths()

    @property
    def trace_s(self) -> float:
        """Wall-clock seconds that it took."""
        return self._compiled.trace_s()

    @cached_property
    def noise_ratio(self) -> Optional[float]:
        """Monte Carlo noise over the noise of the sensor at the exposure of the capture, root-mean-square over the image,
        as the command tells it: 0.1 is not seen, 1 is as much again. None in the dark, where all pixels are saturated
        and after a single sample of each pixel."""
        return self._compiled.noise_ratio()

    @cached_property
    def truth(self) -> Layers:
        """Ground truth of the scene, as :attr:`Shot.truth`."""
        return truth_layers(self._compiled)

    @cached_property
    def camera(self) -> Camera:
        """Pose and intrinsics."""
        return Camera.of_report(json.loads(self._compiled.camera()))

    @overload
    def expose(
        self,
        *,
        time_s: Optional[float] = ...,
        gain_db: Optional[float] = ...,
        seed: Optional[int] = ...,
        frames: None = ...,
        set: "Optional[Mapping[str, Any]]" = ...,
        threads: Optional[int] = ...,
        device: str = ...,
    ) -> Shot: ...
    @overload
    def expose(
        self,
        *,
        time_s: Optional[float] = ...,
        gain_db: Optional[float] = ...,
        seed: Optional[int] = ...,
        frames: int,
        set: "Optional[Mapping[str, Any]]" = ...,
        threads: Optional[int] = ...,
        device: str = ...,
    ) -> "list[Shot]": ...
    def expose(
        self,
        *,
        time_s: Optional[float] = None,
        gain_db: Optional[float] = None,
        seed: Optional[int] = None,
        frames: Optional[int] = None,
        set: "Optional[Mapping[str, Any]]" = None,
        threads: Optional[int] = None,
        device: str = "cpu",
    ) -> "Union[Shot, list[Shot]]":
        """Exposes the sensor to this light.

        Args:
            time_s: exposure time, s.
            gain_db: analogue gain, dB.
            seed: seed of the sensor's temporal noise; the fixed pattern belongs to ``sensor.serial``. The same seed draws
                the same random numbers for a pixel at every time and gain. Exposures whose noise should be independent
                need seeds of their own.
            frames: so many exposures, one after the other, each with temporal noise of its own: frames of the series that
                ``render_into`` writes, with image lag, gain control and the times of a bracket.
            set: values for other keys of ``sensor``, ``exposure``, ``develop`` and ``output``, as in
                ``{"sensor.noise.read_noise_e": 3}``. A sensor with other filters or quantum efficiency needs light that
                was traced with ``output.irradiance``.
            threads: threads to use; as many as there are cores unless said.
            device: what exposes, as for :func:`trace`. A card pays for series of many frames, whose light stays there. What
                it lacks of a sensor the processor does, with a warning.

        Returns:
            A shot, or with ``frames`` a list of them.

        Raises:
            InputError: an exposure that the sensor cannot make, a key that light transport has used already.
            ResourceError: a device that is not there.
        """
        changes = exposure_changes(self._capture, time_s=time_s, gain_db=gain_db, seed=seed, set=set)
        shots = self._compiled.expose(changes, count("frames", frames), count("threads", threads, None), device)
        made = [Shot(shot, self._capture) for shot in shots]
        return made[0] if frames is None else made

    def to_xarray(self) -> Any:
        """Its arrays as an ``xarray.Dataset``: ``electrons_per_s`` and ``variance`` over ``y``, ``x`` (px, whole at pixel
        centres) and ``channel``, and where it is kept ``irradiance`` over ``wavelength_nm``. Needs xarray."""
        import xarray

        rows, columns = self.electrons_per_s.shape[:2]
        arrays: "dict[str, Any]" = {
            "electrons_per_s": (("y", "x", "channel"), self.electrons_per_s, {"units": "e-/s"}),
            "variance": (("y", "x", "channel"), self.variance, {"units": "e-2/s2"}),
        }
        coordinates: "dict[str, Any]" = {
            "y": ("y", np.arange(rows), {"units": "px"}),
            "x": ("x", np.arange(columns), {"units": "px"}),
            "channel": list(self.channels),
        }
        if self._irradiance is not None:
            arrays["irradiance"] = (("y", "x", "wavelength_nm"), self.irradiance, {"units": "W m-2 nm-1"})
            coordinates["wavelength_nm"] = ("wavelength_nm", self.wavelengths_nm, {"units": "nm"})
        return xarray.Dataset(arrays, coordinates)

    def __reduce__(self) -> Any:
        raise TypeError("light cannot be pickled, as it holds its scene; pickle its capture, or save a shot of it")

    def __repr__(self) -> str:
        columns, rows = self._compiled.resolution()
        return f"<photosite.Light {columns} × {rows} px, {', '.join(self.channels)}, {self.paths} paths>"


def exposure_changes(
    capture: Optional[Capture],
    *,
    time_s: Optional[float],
    gain_db: Optional[float],
    seed: Optional[int],
    set: "Optional[Mapping[str, Any]]",
) -> "list[str]":
    """What a call says of an exposure, as changes to a capture."""
    named = {"exposure.time_s": time_s, "exposure.gain_db": gain_db, "render.seed": seed}
    changes = assignments({} if set is None else set)
    if any(change.startswith("exposure.frames=") for change in changes):
        raise invalid("set", "exposure.frames is not for a single exposure", "ask for several with frames=")
    if capture is not None and capture._compiled.series()[0] != 1:
        # Frames are asked for by the call.
        changes.append("exposure.frames=1")
    return changes + assignments({key: value for key, value in named.items() if value is not None})


@overload
def count(name: str, value: Optional[int], default: int = ...) -> int: ...
@overload
def count(name: str, value: Optional[int], default: None) -> Optional[int]: ...
def count(name: str, value: Optional[int], default: Optional[int] = 1) -> Optional[int]:
    """A number of things, of which there is at least one."""
    if value is None:
        return default
    if isinstance(value, bool) or not isinstance(value, (int, np.integer)) or not 0 < value < 1 << 32:
        raise invalid(name, f"expected a whole number above 0, got {value!r}")
    return int(value)


def _to_trace(capture: CaptureLike, samples: Optional[int], seed: Optional[int]) -> Capture:
    named = {"render.samples_per_pixel": samples, "render.seed": seed}
    return loaded(capture).set({key: value for key, value in named.items() if value is not None})


def devices() -> "list[dict[str, Any]]":
    """Devices of this machine that can trace light, as the command ``photosite devices --json`` lists them: ``device`` is
    what :func:`trace` takes. Packages that were built without graphics cards have the processor alone.
    """
    found: "list[dict[str, Any]]" = json.loads(_photosite.devices())
    return found


def trace(
    capture: CaptureLike,
    /,
    *,
    samples: Optional[int] = None,
    seed: Optional[int] = None,
    threads: Optional[int] = None,
    progress: Progress = None,
    film_memory_gib: Optional[float] = None,
    checkpoint: Optional[Path] = None,
    device: str = "cpu",
) -> Light:
    """Traces the light of a capture, in memory. Of a series in which things move it is that of the first image.

    Args:
        capture: a capture, or what :func:`load` takes.
        samples: samples of each pixel.
        seed: seed of light transport and of the sensor's noise.
        threads: threads to use; as many as there are cores unless said. The light does not depend on it.
        progress: True for a bar, False for none, or a function of the paths that are done and all paths; a bar in
            terminals and notebooks unless said.
        film_memory_gib: most memory for the film, GiB: an image that needs more is traced in strips; 4 unless said.
        checkpoint: a folder in which work that is interrupted (Ctrl-C) is kept, and from which the same call goes on,
            as the command ``photosite render`` does. It is gone when the work is done.
        device: what traces the light: "cpu"; "gpu", the first graphics card; "gpu:1" or "gpu:NAME", one of
            :func:`devices`; "auto", a graphics card where there is one that has what the settings ask for, and the
            processor with a warning elsewhere.

    Raises:
        InputError: what only the whole scene shows to be wrong, or what a graphics card cannot render.
        ResourceError: an image that needs more memory than there is, or a device that is not there.
        KeyboardInterrupt: Ctrl-C, within 0.1 s.
    """
    wanted = _to_trace(capture, samples, seed)
    memory = None if film_memory_gib is None else number("film_memory_gib", film_memory_gib)
    frames, moves = wanted._compiled.series()
    if moves and frames > 1:
        warn_all([f"things move, so light is traced for the first of {frames} images alone; render_into makes them all"])
    place = None if checkpoint is None else path_of("checkpoint", checkpoint)
    compiled = _photosite.trace(
        wanted._compiled, count("threads", threads, None), listener(progress, "tracing"), memory, place, device
    )
    return Light(compiled, wanted)


def render(
    capture: CaptureLike,
    /,
    *,
    samples: Optional[int] = None,
    seed: Optional[int] = None,
    threads: Optional[int] = None,
    progress: Progress = None,
    film_memory_gib: Optional[float] = None,
    device: str = "cpu",
) -> Shot:
    """Traces the light of a capture and exposes to it once: ``trace(capture, …).expose()``. A warning tells of Monte Carlo
    noise that may be seen beside that of the sensor, as the command does; ``Shot.noise_ratio`` is its figure.

    Args and errors are those of :func:`trace`.
    """
    light = trace(
        capture, samples=samples, seed=seed, threads=threads, progress=progress, film_memory_gib=film_memory_gib, device=device
    )
    shot = light.expose(threads=threads)
    seen = shot._compiled.seen_noise()
    if seen is not None:
        warn_all([seen])
    return shot


def render_into(
    capture: CaptureLike,
    folder: Path,
    /,
    *,
    samples: Optional[int] = None,
    seed: Optional[int] = None,
    threads: Optional[int] = None,
    progress: Progress = None,
    film_memory_gib: Optional[float] = None,
    overwrite: bool = False,
    device: str = "cpu",
) -> "dict[str, Any]":
    """Renders a capture into a folder, with all images of its series, as the command ``photosite render`` does.

    What is interrupted leaves a checkpoint there, and the same call goes on from it. What is there already, made by the
    same version of the same keys and files, is left as it is. A warning tells of Monte Carlo noise that may be seen beside
    that of the sensor.

    Args:
        folder: created where missing.
        overwrite: whether other earlier results there may go.

    The other arguments are those of :func:`trace`.

    Returns:
        What ``capture.json`` holds.

    Raises:
        InputError: a folder with results of another render.
        KeyboardInterrupt: Ctrl-C.
    """
    wanted = _to_trace(capture, samples, seed)
    report: "dict[str, Any]" = json.loads(
        _photosite.render_to(
            wanted._compiled,
            path_of("folder", folder),
            overwrite,
            count("threads", threads, None),
            listener(progress, "rendering"),
            film_memory_gib,
            device,
        )
    )
    return report
