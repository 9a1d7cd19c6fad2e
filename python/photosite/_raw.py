"""Raw images: digital numbers and what is known of them."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple, Optional, Union, cast

import numpy as np
import numpy.typing as npt

from . import _photosite
from ._arguments import Path, as_array, assignments, invalid, is_path, path_of

__all__ = ["Cfa", "ColourCalibration", "PixelArea", "Raw", "develop", "read_raw"]


@dataclass(frozen=True)
class Cfa:
    """A colour filter array: which channel each pixel has.

    Attributes:
        pattern: as sensor files say it: ``"RGGB"``, ``"mono"``, ``"x-trans"``, ``"RGRG/GBGB"``; ``"full:RGB"`` where
            every pixel has all channels.
        channels: names of the channels.
        tile: rows of the tile that repeats from the top-left pixel, as indices into ``channels``; of a full layout the
            channels of one pixel.
    """

    pattern: str
    channels: "tuple[str, ...]"
    tile: "tuple[tuple[int, ...], ...]"

    @property
    def is_full(self) -> bool:
        """Whether every pixel has a number of every channel, and there are several."""
        return self.pattern.startswith("full:")

    def channel_map(self, rows: int, columns: int) -> "npt.NDArray[np.uint8]":
        """Which channel each number of a raw image has.

        Args:
            rows: rows of the image.
            columns: numbers in a row: pixels of a mosaic, pixels times channels of a full layout.

        Returns:
            (rows, columns) uint8, indices into ``channels``.
        """
        tile = np.array(self.tile, np.uint8)
        repeats = (-(-rows // tile.shape[0]), -(-columns // tile.shape[1]))
        return np.ascontiguousarray(np.tile(tile, repeats)[:rows, :columns])

    def mosaic(self, channels: "npt.ArrayLike") -> "npt.NDArray[Any]":
        """Of each pixel the value of the channel that it has.

        Args:
            channels: (H, W, C) numbers of all channels, such as ``shot.electrons`` of a whole sensor.

        Returns:
            (H, W) of the same type; of a full layout the array itself.

        Raises:
            InputError: an array of another shape.
        """
        values = as_array("channels", channels, (3,), "(H, W, C)")
        if values.shape[2] != len(self.channels):
            expected = f"(H, W, {len(self.channels)}) of {', '.join(self.channels)}"
            raise invalid("channels", f"expected an array {expected}, got one of shape {values.shape}")
        if self.is_full:
            return values
        which = self.channel_map(values.shape[0], values.shape[1]).astype(np.intp)
        return np.ascontiguousarray(np.take_along_axis(values, which[:, :, np.newaxis], 2)[:, :, 0])

    def __str__(self) -> str:
        return self.pattern


class PixelArea(NamedTuple):
    """A rectangle of pixels."""

    x: int
    y: int
    width: int
    height: int


@dataclass(frozen=True, eq=False)
class ColourCalibration:
    """What a camera's numbers mean in one light.

    Attributes:
        light: EXIF's number of the light: 17 is CIE illuminant A, 21 is D65, 23 is D50.
        temperature_k: its correlated colour temperature, K.
        colour_matrix: (C, 3) float64, XYZ → camera, a row for each channel; the largest response to the light's own
            white of Y = 1 is 1.
        forward_matrix: (3, C) float64, white-balanced camera → XYZ adapted to D50; None where it is not known.
    """

    light: int
    temperature_k: float
    colour_matrix: "npt.NDArray[np.float64]"
    forward_matrix: "Optional[npt.NDArray[np.float64]]"


class Raw:
    """A raw image: digital numbers, and what a developer needs to know about them.

    It is what a capture makes (``shot.raw``) and what :func:`read_raw` reads. ``np.asarray(raw)`` is the whole frame,
    masked pixels included, (H, W) uint16, or (H, W, C) of sensors with all channels at every pixel: what ``raw.npy`` of
    the command holds. That array shares the memory of the image, which never changes, and so cannot be written to;
    ``np.array(raw)`` is a copy of your own. Raw images can be pickled.
    """

    def __init__(self, compiled: "_photosite.Raw") -> None:
        # Made by the package: `read_raw`, `Raw.from_array`, `with_data`.
        self._compiled = compiled

    @classmethod
    def from_array(
        cls,
        data: "npt.ArrayLike",
        *,
        cfa: str = "mono",
        black_level_dn: "Union[float, Sequence[float]]" = 0.0,
        white_level_dn: int = 65_535,
        bits: Optional[int] = None,
        colour_matrix: "Optional[npt.ArrayLike]" = None,
        as_shot_neutral: "Optional[Sequence[float]]" = None,
        noise_profile: "Optional[npt.ArrayLike]" = None,
        camera_model: str = "",
        camera_serial: str = "",
        exposure_time_s: float = 0.0,
        iso: Optional[int] = None,
        f_number: Optional[float] = None,
        focal_length_mm: Optional[float] = None,
        pixel_pitch_um: Optional[float] = None,
    ) -> "Raw":
        """A raw image of digital numbers, to be saved as DNG, developed or measured.

        Args:
            data: (H, W) or (H, W, C) integers from 0 to 65535.
            cfa: the colour filter array: ``"RGGB"``, ``"mono"``, ``"full:RGB"``; see :class:`Cfa`.
            black_level_dn: number of no light, DN; or one for each channel, in the order of ``cfa.channels`` of the image.
            white_level_dn: smallest number at which a pixel counts as saturated, DN.
            bits: bits of the numbers; without, those that the white level needs, 8 or more.
            colour_matrix: (C, 3), XYZ → camera under D65, a row for each channel. Without, channels R, G and B are taken
                for those of linear sRGB, so that developers that want colours have some; others have none.
            as_shot_neutral: the camera's response to the scene's white, per channel; without, equal ones.
            noise_profile: (C, 2), S and O of each channel: the variance of the normalised signal x is S·x + O.
            camera_model: name of the camera.
            camera_serial: serial number of the camera.
            exposure_time_s: exposure time, s.
            iso: ISO speed.
            f_number: f-number.
            focal_length_mm: focal length, mm.
            pixel_pitch_um: distance of the pixels, µm.

        Raises:
            InputError: numbers that are none of 16 bits, or more than ``bits``; a shape that does not suit the filters.
        """
        numbers = _digital_numbers("data", data)
        if not (0 < white_level_dn <= 65_535 and int(white_level_dn) == white_level_dn):
            raise invalid("white_level_dn", f"expected a whole number from 1 to 65535, got {white_level_dn}")
        shape, white = numbers.shape[:2], int(white_level_dn)
        flat = numbers.reshape(-1)
        raw = cls(_photosite.Raw.of_numbers((shape[0], shape[1]), flat, cfa, 0.0, white))
        if raw.shape != numbers.shape:
            raise invalid("data", f"expected shape {raw.shape} of {cfa!r}, got {numbers.shape}")
        known = raw._known
        channels = raw.cfa.channels
        known["bits"] = _bits(bits, raw.bits, int(numbers.max()))
        known["black_level_dn"] = {**known["black_level_dn"], **_black_level(raw, black_level_dn)}
        metadata: "dict[str, Any]" = known["metadata"]
        metadata.update(_colours(channels, raw.cfa.pattern, colour_matrix, as_shot_neutral))
        if noise_profile is not None:
            metadata["noise_profile"] = _numbers("noise_profile", noise_profile, (len(channels), 2))
        amounts = {"exposure_time_s": exposure_time_s, "iso": iso, "f_number": f_number}
        amounts.update({"focal_length_mm": focal_length_mm, "pixel_pitch_um": pixel_pitch_um})
        for name, value in amounts.items():
            if value is not None and not (0 <= value < float("inf") and (value > 0 or name == "exposure_time_s")):
                raise invalid(name, f"expected a number above 0, got {value}")
        metadata.update(camera_model=str(camera_model), camera_serial=str(camera_serial))
        metadata.update(exposure_time_s=float(exposure_time_s), iso=None if iso is None else int(iso))
        metadata["f_number"] = None if f_number is None else float(f_number)
        metadata["focal_length_m"] = None if focal_length_mm is None else focal_length_mm * 1e-3
        metadata["pixel_pitch_m"] = None if pixel_pitch_um is None else [pixel_pitch_um * 1e-6] * 2
        return cls(_photosite.Raw.of_description(json.dumps(known), np.ascontiguousarray(flat)))

    # Numbers

    @property
    def shape(self) -> "tuple[int, ...]":
        """(H, W), or (H, W, C)."""
        shape: "tuple[int, ...]" = self._compiled.__array_interface__["shape"]
        return shape

    @property
    def ndim(self) -> int:
        """2, or 3 where every pixel has all channels."""
        return len(self.shape)

    @property
    def dtype(self) -> "np.dtype[np.uint16]":
        """uint16."""
        return np.dtype(np.uint16)

    def __len__(self) -> int:
        return self.shape[0]

    def __getitem__(self, key: Any) -> Any:
        return np.asarray(self)[key]

    def __array__(self, dtype: Any = None, copy: Optional[bool] = None) -> "npt.NDArray[Any]":
        shared: npt.NDArray[np.uint16] = np.asarray(self._compiled)
        wanted = shared.dtype if dtype is None else np.dtype(dtype)
        if wanted == shared.dtype:
            return shared.copy() if copy else shared
        if copy is False:
            raise ValueError(f"an array of {wanted} is a copy of the digital numbers, which are uint16")
        return shared.astype(wanted)

    def __dlpack__(
        self,
        *,
        stream: Any = None,
        max_version: "Optional[tuple[int, int]]" = None,
        dl_device: "Optional[tuple[int, int]]" = None,
        copy: Optional[bool] = None,
    ) -> Any:
        """Shares the memory with consumers that can be told that it is read-only; others get a copy."""
        shared: npt.NDArray[Any] = np.asarray(self)
        if dl_device is not None and tuple(dl_device) != self.__dlpack_device__():
            raise BufferError(f"a raw image is in the memory of the processor, not on device {dl_device}")
        if stream is not None:
            raise BufferError("a raw image is in the memory of the processor, which has no streams")
        if not copy and max_version is not None and max_version[0] >= 1:
            try:
                return shared.__dlpack__(max_version=max_version)
            except (BufferError, TypeError):  # a NumPy of before 2.1 exports nothing that is read-only
                if copy is False:
                    raise
        if copy is False:
            raise BufferError("a raw image is read-only, and this consumer cannot be told so")
        return shared.copy().__dlpack__()

    def __dlpack_device__(self) -> "tuple[int, int]":
        return (1, 0)  # the processor

    @property
    def active(self) -> "npt.NDArray[np.uint16]":
        """The pixels that see light, without masked ones around: (h, w) or (h, w, C) uint16, which shares memory."""
        x, y, width, height = self.active_area
        whole: npt.NDArray[np.uint16] = np.asarray(self)
        return whole[y : y + height, x : x + width]

    def with_data(self, data: "npt.ArrayLike") -> "Raw":
        """A raw image of other numbers of which all holds that holds of these.

        Args:
            data: integers of the same shape, from 0 to 2**bits - 1; they are copied.

        Raises:
            InputError: another shape, numbers that are no integers or out of range.
        """
        numbers = _digital_numbers("data", data)
        if numbers.shape != self.shape:
            raise invalid("data", f"expected shape {self.shape}, got {numbers.shape}")
        largest = int(numbers.max())
        if largest >= 1 << self.bits:
            help = "clip them, or scale them to the range of the sensor"
            raise invalid("data", f"the number {largest} takes more than the {self.bits} bits of the sensor", help)
        return Raw(self._compiled.with_numbers(numbers.reshape(-1)))

    # What is known of them

    @cached_property
    def _known(self) -> "dict[str, Any]":
        known: "dict[str, Any]" = json.loads(self._compiled.description())
        return known

    @property
    def _metadata(self) -> "dict[str, Any]":
        metadata: "dict[str, Any]" = self._known["metadata"]
        return metadata

    @cached_property
    def cfa(self) -> Cfa:
        """The colour filter array."""
        cfa = self._known["cfa"]
        width: int = cfa["width"]
        tile: "list[int]" = cfa["tile"]
        rows = tuple(tuple(tile[i : i + width]) for i in range(0, len(tile), width))
        return Cfa(self._compiled.cfa(), tuple(cfa["channels"]), rows)

    @property
    def active_cfa(self) -> str:
        """The colour filter array of ``active``, as :attr:`Cfa.pattern` has it."""
        return self._compiled.active_cfa()

    @property
    def bits(self) -> int:
        """Bits of the digital numbers, 1–16."""
        bits: int = self._known["bits"]
        return bits

    @cached_property
    def black_level_dn(self) -> "Union[float, npt.NDArray[np.float32]]":
        """Linear number of no light, DN: one for all numbers, or float32 of the shape of the image."""
        levels = self._known["black_level_dn"]
        is_uniform = not levels["column_deltas"] and not levels["row_deltas"] and len(set(levels["tile"])) == 1
        if is_uniform:
            return float(levels["tile"][0])
        of_all: npt.NDArray[np.float32] = self._compiled.black_levels_dn()
        of_all.flags.writeable = False
        return of_all

    @property
    def white_level_dn(self) -> int:
        """Smallest linear number at which a pixel counts as saturated, DN."""
        level: int = self._known["white_level_dn"]
        return level

    @property
    def linearisation(self) -> "Optional[npt.NDArray[np.uint16]]":
        """For each digital number one proportional to light, the last for all beyond; None where they are linear."""
        table = self._known["linearisation"]
        return None if table is None else np.array(table, np.uint16)

    @property
    def active_area(self) -> PixelArea:
        """The pixels that see light; the whole frame where none are masked."""
        area: "Optional[dict[str, int]]" = self._known["active_area"]
        return PixelArea(0, 0, self.shape[1], self.shape[0]) if area is None else PixelArea(**area)

    @cached_property
    def calibrations(self) -> "tuple[ColourCalibration, ...]":
        """What the numbers mean in up to three lights, in the order of DNG files."""

        def of(known: "dict[str, Any]", temperature_k: float) -> ColourCalibration:
            matrix, columns = np.array(known["colour_matrix"], np.float64), known["forward_matrix"]
            forward = None if columns is None else np.ascontiguousarray(np.array(columns, np.float64).T)
            return ColourCalibration(known["light"], temperature_k, matrix, forward)

        return tuple(map(of, self._metadata["calibrations"], self._compiled.light_temperatures_k()))

    @property
    def as_shot_neutral(self) -> "Optional[npt.NDArray[np.float64]]":
        """The camera's response to the scene's white, (C,), the largest 1; None where it is not known."""
        neutral = self._metadata["as_shot_neutral"]
        return None if neutral is None else np.array(neutral, np.float64)

    @property
    def as_shot_white_xy(self) -> "Optional[tuple[float, float]]":
        """CIE x and y of the scene's white, where that is what a file says in place of the camera's response."""
        xy = self._metadata["as_shot_white_xy"]
        return None if xy is None else (xy[0], xy[1])

    @property
    def noise_profile(self) -> "npt.NDArray[np.float64]":
        """(C, 2), S and O of each channel: the variance of the normalised signal x is S·x + O; (0, 2) if unknown."""
        return np.array(self._metadata["noise_profile"], np.float64).reshape(-1, 2)

    @property
    def camera_model(self) -> str:
        """Sensor preset or name; empty where it is not known."""
        model: str = self._metadata["camera_model"]
        return model

    @property
    def camera_serial(self) -> str:
        """Serial number of the camera; empty where it is not known."""
        serial: str = self._metadata["camera_serial"]
        return serial

    @property
    def exposure_time_s(self) -> float:
        """Exposure time, s; 0 where it is not known."""
        time_s: float = self._metadata["exposure_time_s"]
        return time_s

    @property
    def iso(self) -> Optional[int]:
        """Saturation-based ISO speed, which says what the gain was."""
        iso: Optional[int] = self._metadata["iso"]
        return iso

    @property
    def f_number(self) -> Optional[float]:
        """f-number, where there is a lens."""
        f_number: Optional[float] = self._metadata["f_number"]
        return f_number

    @property
    def focal_length_m(self) -> Optional[float]:
        """Focal length, m, where there is a lens."""
        focal_length_m: Optional[float] = self._metadata["focal_length_m"]
        return focal_length_m

    @property
    def pixel_pitch_m(self) -> "Optional[tuple[float, float]]":
        """Pixel pitch along x and y, m."""
        pitch = self._metadata["pixel_pitch_m"]
        return None if pitch is None else (pitch[0], pitch[1])

    @property
    def pixel_aspect(self) -> float:
        """Width of a pixel over its height."""
        return self._compiled.pixel_aspect()

    @property
    def baseline_exposure_ev(self) -> float:
        """By how much a developer brightens the image unasked, EV."""
        ev: float = self._metadata["baseline_exposure_ev"]
        return ev

    # Files

    def save(self, path: Path) -> None:
        """Writes a file, in the place of an older one: the bytes that the command writes.

        Args:
            path: its extension says the format: ``.dng``, which holds all that is known, or ``.tiff``, ``.pgm``,
                ``.npy`` or ``.exr``.

        Raises:
            InputError: another extension, or an image that the format cannot hold.
            FileError: the file cannot be written.
        """
        self._compiled.save(path_of("path", path))

    def __reduce__(self) -> Any:
        return _unpickle, (self._compiled.description(), np.asarray(self).reshape(-1))

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Raw):
            return NotImplemented
        is_same = self._compiled.description() == other._compiled.description()
        return is_same and np.array_equal(np.asarray(self), np.asarray(other))

    __hash__ = None  # type: ignore[assignment]

    def __repr__(self) -> str:
        size = " × ".join(map(str, (self.shape[1], self.shape[0])))
        black = self.black_level_dn
        black_text = f"{float(black.mean()):g} on average" if isinstance(black, np.ndarray) else f"{black:g}"
        of = f" of {self.camera_model}" if self.camera_model else ""
        return f"<Raw{of}: {size} pixels, {self.cfa}, {self.bits} bits, black {black_text} DN, white {self.white_level_dn} DN>"


def _unpickle(description: str, numbers: "npt.NDArray[np.uint16]") -> Raw:
    return Raw(_photosite.Raw.of_description(description, np.ascontiguousarray(numbers)))


# XYZ → linear sRGB (IEC 61966-2-1), a row for each channel.
_SRGB = {
    "R": [3.2406, -1.5372, -0.4986],
    "G": [-0.9689, 1.8758, 0.0415],
    "B": [0.0557, -0.2040, 1.0570],
}
# EXIF's number of CIE illuminant D65.
_D65 = 21


def _bits(bits: Optional[int], least: int, largest: int) -> int:
    if bits is None:
        bits = least
    if not (1 <= bits <= 16 and int(bits) == bits):
        raise invalid("bits", f"expected a whole number from 1 to 16, got {bits}")
    if largest >= 1 << int(bits):
        help = "state the bits or the white level of the numbers, or clip them"
        raise invalid("data", f"the number {largest} takes more than {bits} bits", help)
    return int(bits)


def _black_level(raw: Raw, level: "Union[float, Sequence[float]]") -> "dict[str, Any]":
    """Tile of black levels, and its columns."""
    levels = np.atleast_1d(np.asarray(level, np.float64))
    if not (np.all(levels >= 0) and np.all(levels <= 65_535)):
        raise invalid("black_level_dn", f"expected numbers from 0 to 65535, got {level}")
    channels = raw.cfa.channels
    if levels.shape == (1,):
        return {"width": 1, "tile": [float(levels[0])]}
    if levels.shape != (len(channels),):
        raise invalid("black_level_dn", f"expected one number, or one for each of {', '.join(channels)}, got {level}")
    tile = [[float(levels[channel]) for channel in row] for row in raw.cfa.tile]
    return {"width": len(tile[0]), "tile": [number for row in tile for number in row]}


def _numbers(name: str, values: Any, shape: "tuple[int, ...]") -> Any:
    """Finite numbers of this shape as lists."""
    try:
        array = np.asarray(values, np.float64)
    except (TypeError, ValueError):
        array = np.empty(0)
    if array.shape != shape or not np.all(np.isfinite(array)):
        raise invalid(name, f"expected finite numbers of shape {shape}, got {values!r}")
    return array.tolist()


def _colours(channels: "tuple[str, ...]", pattern: str, matrix: Any, neutral: Any) -> "dict[str, Any]":
    if matrix is None and (pattern == "mono" or not set(channels) <= set(_SRGB)):
        if neutral is not None:
            raise invalid("as_shot_neutral", "says nothing without a colour_matrix", "give both")
        return {}
    rows = [_SRGB[name] for name in channels] if matrix is None else _numbers("colour_matrix", matrix, (len(channels), 3))
    calibration = {"light": _D65, "colour_matrix": rows, "forward_matrix": None}
    white = [1.0] * len(channels) if neutral is None else _numbers("as_shot_neutral", neutral, (len(channels),))
    if min(white) <= 0:
        raise invalid("as_shot_neutral", f"expected numbers above 0, got {neutral}")
    largest = max(white)
    return {"calibrations": [calibration], "as_shot_neutral": [number / largest for number in white]}


def _digital_numbers(name: str, data: Any) -> "npt.NDArray[np.uint16]":
    """Integers of 16 bits, C-contiguous."""
    array = as_array(name, data, (2, 3), "(H, W) or (H, W, C)")
    help = "round and clip them first: np.clip(np.rint(data), 0, 65535).astype(np.uint16)"
    if array.dtype.kind not in "ui":
        raise invalid(name, f"expected integers of 16 bits, got an array of {array.dtype}", help)
    if array.dtype != np.uint16 and (int(array.min()) < 0 or int(array.max()) > 65_535):
        found = f"from {int(array.min())} to {int(array.max())}"
        raise invalid(name, f"expected integers from 0 to 65535, got those {found}", help)
    return np.ascontiguousarray(array, np.uint16)


def read_raw(path: Path) -> Raw:
    """Reads a raw file.

    Args:
        path: a DNG, TIFF, PBM, PGM, PPM or NPY file, an EXR file of digital numbers, or a PNG file of 16 bits of grey
            that says nothing of colours. Files other than DNG and EXR say nothing but their numbers, which are taken for
            those of a monochrome sensor, or of one with R, G and B at every pixel.

    Raises:
        InputError: a file of another kind, or a damaged one.
        FileError: the file cannot be read.
    """
    return Raw(_photosite.Raw.read(path_of("path", path)))


def develop(
    raw: "Union[Raw, Path, npt.ArrayLike]",
    /,
    *,
    like: Optional[Raw] = None,
    linear: bool = False,
    **keys: Any,
) -> "npt.NDArray[Any]":
    """Develops a raw image, or light of high dynamic range, to an image, as ``photosite develop`` does.

    Args:
        raw: a :class:`Raw`, the path of a file that ``photosite develop`` reads, or an array (H, W) or (H, W, 3) of
            integers from 0 to 65535.
        like: the raw image whose levels, filters and matrices hold for the array. Without, an array (H, W) is taken for
            that of a monochrome sensor, black at 0 and white at 65535; ``raw={"cfa": "RGGB", "black_level_dn": 64,
            "white_level_dn": 4095}`` says otherwise.
        linear: linear light in float32 instead of codes: what EXR and NPY files hold.
        **keys: keys of the table ``[develop]`` of capture files: ``white_balance``, ``demosaic``, ``highlights``,
            ``tone_curve``, ``colour_space``, ``exposure_ev``, ``bits`` and more; ``photosite schema`` describes them all.

    Returns:
        (H, W, 3) uint8, or uint16 with ``bits=16``: the codes of the command's PNG or TIFF file; (H, W) of grey images;
        float32 with ``linear``, and of colours that are none for viewers, as CIELAB and XYZ are.

    Raises:
        InputError: a key or value that there is not, or one that the image has no use for.
        FileError: the file cannot be read.
    """
    settings = assignments(keys, "develop.")
    if is_path(raw):
        if like is not None:
            raise invalid("like", "a file itself says what its pixel values mean", "read it with read_raw, or leave out like")
        return _photosite.develop(None, path_of("raw", raw), settings, bool(linear))
    if isinstance(raw, Raw):
        image = raw
    elif like is not None:
        if not isinstance(cast(object, like), Raw):
            raise invalid("like", f"expected a Raw, got {type(like).__name__}")
        image = like.with_data(raw)
    else:
        numbers = _digital_numbers("raw", raw)
        image = Raw.from_array(numbers, cfa="mono" if numbers.ndim == 2 else "full:RGB")
    return _photosite.develop(image._compiled, None, settings, bool(linear))  # pyright: ignore[reportPrivateUsage]
