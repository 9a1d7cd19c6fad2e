"""Comparison, beside the command and NumPy."""

from __future__ import annotations

import json
import pickle
from pathlib import Path

import numpy as np
import photosite as ps
import pytest
from conftest import Command


def pictures(seed: int = 0) -> "tuple[np.ndarray, np.ndarray]":
    random = np.random.default_rng(seed)
    b = random.uniform(1, 2, (20, 30, 3)).astype(np.float32)
    return b + random.normal(0, 0.1, b.shape).astype(np.float32), b


def test_errors_are_those_of_numpy() -> None:
    a, b = pictures()
    found = ps.compare(a, b)
    assert found.outcome == "not judged" and found.agrees is None and list(found.channels) == ["R", "G", "B"]
    for i, name in enumerate("RGB"):
        difference = a[..., i].astype(float) - b[..., i]
        figures = found.channels[name]
        assert figures["mean_difference"] == pytest.approx(difference.mean(), rel=1e-9)
        assert figures["rmse"] == pytest.approx(np.sqrt((difference**2).mean()), rel=1e-9)
        assert figures["mae"] == pytest.approx(np.abs(difference).mean(), rel=1e-9)
        assert figures["psnr_db"] == pytest.approx(20 * np.log10(float(b[..., i].max()) / figures["rmse"]), rel=1e-9)
    worst = found.worst[0]
    at = np.unravel_index(np.abs(a - b).argmax(), a.shape)
    assert (worst["y"], worst["x"], worst["channel"]) == (at[0], at[1], "RGB"[at[2]])


def test_noise_explains_what_it_explains() -> None:
    a, b = pictures()
    agree = ps.compare(a, b, variance_a=0.01, variance_b=0)
    assert agree.outcome == "agree" and agree.agrees and agree.verdict is not None
    z = (a.astype(float) - b) / 0.1
    assert agree.channels["R"]["z_scores"]["spread"] == pytest.approx(z[..., 0].std(), rel=0.01)
    variance = np.full(a.shape, 0.01, np.float32)
    assert ps.compare(a, b, variance_a=variance, variance_b=0).channels["R"] == agree.channels["R"]
    differ = ps.compare(a, b, variance_a=0.001, variance_b=0)
    assert differ.agrees is False and "noise does not explain" in differ.failures[0]


def test_limits() -> None:
    a, b = pictures()
    assert ps.compare(a, b, max_rmse=0.2).agrees
    assert ps.compare(a, b, max_rmse=0.05).agrees is False
    assert ps.compare(a, a, max_relative_mse=0, max_mean_difference_percent=0).agrees


@pytest.mark.parametrize("options", [{}, {"channels": ["G"]}, {"max_rmse": 1e9, "worst": 2, "alpha": 0.1}])
def test_the_command_says_the_same_of_files(
    command: Command, rendered: Path, tmp_path: Path, options: "dict[str, object]"
) -> None:
    other = ps.read_raw(rendered / "raw.dng")
    other.with_data(np.asarray(other)[::-1]).save(tmp_path / "b.dng")
    names = {"channels": "--channels", "max_rmse": "--max-rmse", "worst": "--worst", "alpha": "--alpha"}
    given = [p for key, v in options.items() for p in (names[key], ",".join(v) if isinstance(v, list) else v)]
    pairs = [(rendered / "raw.dng", tmp_path / "b.dng"), (rendered / "electrons.exr", rendered / "electrons.exr")]
    for a, b in pairs:
        expected = json.loads(command("compare", a, b, "--json", *given).stdout)
        found = ps.compare(a, b, **options)  # type: ignore[arg-type]
        assert found.report == expected


def test_arrays_are_taken_as_files_of_them_are(command: Command, rendered: Path, tmp_path: Path) -> None:
    raw = ps.read_raw(rendered / "raw.dng")
    codes = np.random.default_rng(1).integers(0, 256, (6, 7, 3)).astype(np.uint8)
    for name, array in (("codes", codes), ("numbers", np.array(raw)), ("floats", pictures()[0])):
        np.save(tmp_path / f"{name}.npy", array)
        np.save(tmp_path / f"{name}-b.npy", array[::-1])
        a, b = tmp_path / f"{name}.npy", tmp_path / f"{name}-b.npy"
        expected = json.loads(command("compare", a, b, "--json").stdout)
        found = ps.compare(array, array[::-1])
        assert list(found.channels.values()) == expected["channels"]
    assert ps.compare(raw, rendered / "raw.dng", max_rmse=0).agrees
    assert list(ps.compare(raw, raw).channels) == ["raw", "R", "G", "B"]


def test_names_of_channels_come_with_the_array(rendered: Path) -> None:
    class Named(np.ndarray):
        channels: "tuple[str, ...]"

    electrons = np.ones((2, 3, 2), np.float32).view(Named)
    electrons.channels = ("C", "M")
    assert list(ps.compare(electrons, electrons).channels) == ["C", "M"]
    assert list(ps.compare(np.ones((2, 2, 5)), np.ones((2, 2, 5))).channels) == ["0", "1", "2", "3", "4"]
    electrons.channels = ("C",)
    with pytest.raises(ps.InputError, match="2 channels"):
        ps.compare(electrons, electrons)


def test_differences_can_be_seen(command: Command, tmp_path: Path) -> None:
    a, b = pictures()
    picture = ps.compare(a, b).picture()
    assert picture.image.dtype == np.uint8 and picture.image.shape[2] == 3 and picture.range > 0
    assert ps.compare(a, b).picture(range=2).range == 2
    with pytest.raises(ps.InputError):
        ps.compare(a, b).picture(range=-1)
    again = pickle.loads(pickle.dumps(ps.compare(a, b)))
    assert again.report == ps.compare(a, b).report


def test_untested_channels_are_told_in_arguments() -> None:
    a, b = pictures()
    [untested] = ps.compare(a, b, variance_a=1).untested
    assert "variance_b=" in untested["help"] and "--" not in untested["help"]


A, B = pictures()


@pytest.mark.parametrize(
    ("a", "b", "options", "complaint"),
    [
        (A, B[:-1], {}, "has 30 × 20 pixels"),
        (A, B[..., 0], {}, "no channel in common"),
        (A, "missing.exr", {}, "missing.exr"),
        (A, None, {}, "b: expected an array"),
        (A, np.zeros((20, 30), complex), {}, "b: expected real numbers"),
        (A, np.zeros((20, 30, 3), object), {}, "b: expected an array"),
        (A, np.zeros((2, 2, 2, 2)), {}, "b: expected an array"),
        (np.zeros((0, 3)), B, {}, "empty"),
        (A, B, {"variance_a": -1}, "variance_a: expected a number"),
        (A, B, {"variance_a": float("nan")}, "variance_a: expected a number"),
        (A, B, {"variance_b": np.ones((3, 3))}, "variance_b: expected shape"),
        (A, B, {"samples_a": 1}, "samples_a"),
        (A, B, {"samples_a": 4}, "second moments"),
        (A, B, {"samples_a": 4, "variance_a": 1}, "samples_a"),
        (A, B, {"alpha": 0}, "alpha"),
        (A, B, {"alpha": float("nan")}, "alpha"),
        (A, B, {"max_rmse": -1}, "max_rmse"),
        (A, B, {"worst": -1}, "worst"),
        (A, B, {"channels": ["Q"]}, "no channel"),
        (A, B, {"channels": []}, "no channel"),
        (A, B, {"channels": "R"}, "channels"),
        (A, B, {"peak": 0}, "peak"),
    ],
)
def test_what_cannot_be_compared(a: object, b: object, options: "dict[str, object]", complaint: str) -> None:
    with pytest.raises(ps.Error, match=complaint):
        ps.compare(a, b, **options)  # type: ignore[arg-type]


def test_pixels_that_are_no_numbers_differ() -> None:
    a, b = A.copy(), B
    a[3, 4, 1] = np.nan
    found = ps.compare(a, b)
    assert found.agrees is False and found.channels["G"]["non_finite"] == 1


def test_strides_and_protection_do_not_matter() -> None:
    expected = ps.compare(A, B).report
    protected = A.copy()
    protected.flags.writeable = False
    wide = np.zeros((40, 60, 6), np.float32)
    wide[::2, ::2, ::2] = A
    for same in (np.asfortranarray(A), protected, wide[::2, ::2, ::2], A.astype(np.float64), A[::-1][::-1]):
        assert ps.compare(same, B).report == expected
