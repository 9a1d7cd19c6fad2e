"""What is wrong with an argument is said with its name, whatever it is."""

from __future__ import annotations

import pickle
from pathlib import Path
from typing import Any, Callable

import numpy as np
import pytest

import photosite as ps

LIGHT = np.ones((8, 8, 3), np.float32)
NM = [450.0, 550.0, 650.0]


@pytest.fixture(scope="module")
def shot() -> ps.Shot:
    sensor = ps.Sensor("sony-imx249-color")
    return sensor.expose(LIGHT, wavelengths_nm=NM, time_s=1e-4, illuminant="D65")


def endless() -> "dict[str, Any]":
    values: "dict[str, Any]" = {}
    values["scene"] = values
    return values


#: A call with the name of the argument that is wrong.
WRONG: "dict[str, tuple[Callable[[], object], str]]" = {
    "path-of-bytes": (lambda: ps.read_raw(b"raw.dng"), "path"),  # type: ignore[arg-type]
    "path-of-nothing": (lambda: ps.load(""), "source"),
    "path-that-is-none": (lambda: ps.read_raw("\ud800"), "path"),
    "number-as-path": (lambda: ps.Dataset(5), "path"),  # type: ignore[arg-type]
    "key-of-bytes": (lambda: ps.load({}, set={b"exposure.time_s": 1}), "set"),  # type: ignore[dict-item]
    "key-with-a-line": (lambda: ps.load({}, set={"exposure.time_s\n": 1}), "set"),
    "key-with-a-value": (lambda: ps.load({}, set={"exposure.time_s=3": 1}), "set"),
    "key-of-nothing": (lambda: ps.load({}, set={"": 1}), "set"),
    "endless-dictionary": (lambda: ps.load(endless()), "capture"),
    "endless-change": (lambda: ps.load({}, set={"scene": endless()}), "scene"),
    "endless-list": (lambda: ps.load({}, set={"scene": {"geometry": endless()}}), "scene"),
    "like": (lambda: ps.develop(np.ones((4, 4), np.uint16), like=5), "like"),  # type: ignore[arg-type]
    "one": (lambda: ps.Sensor("sony-imx249-color").expose(LIGHT, unit="lux", one="x"), "one"),  # type: ignore[call-overload]
    "unit": (lambda: ps.Sensor("sony-imx249-color").expose(LIGHT, unit=5), "unit"),  # type: ignore[call-overload]
    "channels": (lambda: ps.Sensor("sony-imx249-color").expose(LIGHT, unit="lux", channels=5), "channels"),  # type: ignore[call-overload]
    "illuminant": (
        lambda: ps.Sensor("sony-imx249-color").expose(LIGHT, unit="lux", illuminant=([400, 500],)),  # type: ignore[call-overload]
        "illuminant",
    ),
    "dark-illuminant": (
        lambda: ps.Sensor("sony-imx249-color").expose(LIGHT, unit="lux", illuminant=([400, 500], [0, 0])),
        "illuminant",
    ),
    "micrometres": (
        lambda: ps.Sensor("sony-imx249-color").expose(LIGHT, wavelengths_nm=[0.45, 0.55, 0.65]),
        "wavelengths_nm",
    ),
    "negative-wavelength": (
        lambda: ps.Sensor("sony-imx249-color").expose(LIGHT, wavelengths_nm=[-450, 550, 650]),
        "wavelengths_nm",
    ),
    "masked": (
        lambda: ps.Sensor("sony-imx249-color").expose(np.ma.masked_greater(LIGHT, 0.5), wavelengths_nm=NM),
        "light",
    ),
    "threads": (lambda: ps.Sensor("sony-imx249-color").expose(LIGHT, unit="lux", threads=10**6), "threads"),
    "frames-in-set": (
        lambda: ps.Sensor("sony-imx249-color").expose(LIGHT, unit="lux", set={"exposure.frames": 3}),
        "set",
    ),
    "film-memory": (lambda: ps.trace({}, film_memory_gib="much"), ""),  # type: ignore[arg-type]
    "size": (lambda: ps.emva1288("sony-imx249-mono", size_px="ab"), "size_px"),  # type: ignore[arg-type]
}


@pytest.mark.parametrize("case", list(WRONG))
def test_a_wrong_argument_is_named(case: str) -> None:
    call, name = WRONG[case]
    with pytest.raises(ps.InputError) as error:
        call()
    assert name in ("", error.value.key) and error.value.file == "<python>"


def test_numbers_of_numpy_are_numbers() -> None:
    for number in (np.float64(0.02), np.float32(0.02), np.longdouble(0.02), np.array(0.02)):
        capture = ps.load(Path(__file__).parents[2] / "scenes/cornell-box/capture.toml", set={"exposure.time_s": number})
        assert capture.values["exposure"]["time_s"] == pytest.approx(0.02)


def test_layers_are_a_mapping(shot: ps.Shot) -> None:
    assert shot.noise.get("prnu") is None and "prnu" not in shot.noise
    with pytest.raises(KeyError) as error:
        shot.noise["prnu"]
    assert isinstance(error.value, ps.InputError) and "did you mean prnu_e?" in str(error.value)


def test_what_cannot_be_pickled_says_what_can(shot: ps.Shot) -> None:
    with pytest.raises(TypeError, match="its raw image"):
        pickle.dumps(shot)
    assert np.array_equal(np.asarray(pickle.loads(pickle.dumps(shot.raw))), np.asarray(shot.raw))


def test_what_a_caller_does_later_changes_nothing() -> None:
    keys = {"noise.read_noise_e": 3.0}
    sensor = ps.Sensor("sony-imx249-mono", set=keys)
    keys["noise.read_noise_e"] = 9.0
    assert pickle.loads(pickle.dumps(sensor)).values["noise"]["read_noise_e"] == 3
