"""Sensors fitted to images, beside the command and what the images were made of."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import photosite as ps
import pytest
from conftest import Command


@pytest.fixture(scope="module")
def images(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("fit") / "set"
    made_of = {"serial": 7, "noise.row_noise_e": 3}
    ps.emva1288("sony-imx249-mono", output=folder, set=made_of, steps=12, spatial=8, size_px=(64, 64))
    return folder


def test_a_twin_is_fitted_and_takes_the_same_images(images: Path, tmp_path: Path) -> None:
    fit = ps.fit(images, pixel_pitch_um=5.86)
    # 64² pixels, some twenty images of which count: errors stand beside.
    for key, truth in {"adc.conversion_gain_dn_per_e": 0.1245, "noise.read_noise_e": 6.3, "noise.row_noise_e": 3}.items():
        found = fit.parameters[key]
        assert abs(found.value - truth) < 4 * found.standard_error < 0.15 * truth, key
    assert {"figure", "reason"} == set(fit.left_out[0])
    fit.save(tmp_path / "twin.toml")
    twin = ps.Sensor(tmp_path / "twin.toml")
    assert twin.pixel_pitch_um == (5.86, 5.86)
    [channel] = ps.emva1288(twin, like=images, seed=1)
    [original] = ps.emva1288_report(images)
    assert channel.measured.system_gain_dn_per_e == pytest.approx(original.measured.system_gain_dn_per_e, rel=0.1)


def test_the_command_fits_the_same(images: Path, command: Command, tmp_path: Path) -> None:
    printed = json.loads(command("fit", images, "-o", tmp_path / "sensor.toml", "--json").stdout)
    fit = ps.fit(str(images))
    assert fit.report == printed
    assert fit.sensor_file == (tmp_path / "sensor.toml").read_text(encoding="utf-8")


def test_maps_are_of_this_very_camera(images: Path, tmp_path: Path) -> None:
    fit = ps.fit(images, maps=True)
    assert fit.prnu_map is not None and fit.dsnu_map_e is not None
    assert fit.prnu_map.mean() == pytest.approx(1, abs=1e-4) and fit.prnu_map.shape == (64, 64)
    # Deviations vary as the figures of the fit say, but for what eight images tell of single pixels.
    assert fit.prnu_map.std() == pytest.approx(fit.parameters["noise.prnu_percent"].value / 100, rel=0.1)
    fit.save(tmp_path / "twin.toml")
    assert 'prnu_map = { file = "twin.prnu.npy" }' in (tmp_path / "twin.toml").read_text(encoding="utf-8")
    ps.emva1288(tmp_path / "twin.toml", like=images, output=tmp_path / "again", seed=1)
    again = ps.fit(tmp_path / "again", maps=True).prnu_map
    assert again is not None and np.corrcoef(again.ravel(), fit.prnu_map.ravel())[0, 1] > 0.5
    assert ps.fit(images).prnu_map is None


def test_what_cannot_be_fitted_is_said(tmp_path: Path) -> None:
    with pytest.raises(ps.InputError, match="has no images"):
        ps.fit(tmp_path)
    with pytest.raises(ps.InputError, match="system_gain_dn_per_e"):
        ps.fit(tmp_path, system_gain_dn_per_e=0)


def test_a_mosaic_that_numpy_has_made_is_fitted(tmp_path: Path) -> None:
    """A camera of another hand: filters, shading, noise of pixels and rows, in DNG files that state their exposures."""
    random = np.random.default_rng(3)
    height, width, gain = 160, 240, 0.25
    dsnu = random.normal(0, 2, (height, width))
    prnu = random.normal(1, 0.008, (height, width))
    efficiency = np.tile([[0.6, 1.0], [1.0, 0.7]], (height // 2, width // 2))
    y, x = np.mgrid[-1 : 1 : height * 1j, -1 : 1 : width * 1j]
    shading = 1 - 0.1 * (x**2 + y**2)

    def take(name: str, rate: float, time_s: float) -> None:
        light = rate * time_s * efficiency * prnu * shading
        electrons = random.poisson(light + 5 * time_s) + random.normal(0, 4, light.shape)
        electrons += dsnu + random.normal(0, 1, (height, 1))
        numbers = np.clip(np.rint(gain * np.minimum(electrons, 15_000) + 64), 0, 4095).astype(np.uint16)
        levels = {"black_level_dn": 64, "white_level_dn": 4095}
        raw = ps.Raw.from_array(numbers, cfa="RGGB", exposure_time_s=time_s, iso=100, pixel_pitch_um=4, **levels)
        raw.save(tmp_path / f"{name}.dng")

    for i in range(10):
        take(f"dark_short_{i}", 0, 0.01)
        take(f"dark_long_{i}", 0, 4)
    for time_s in (0.01, 0.02, 0.04, 0.08, 0.16, 0.4):
        for i in range(16 if time_s == 0.08 else 4):
            take(f"flat_{time_s}s_{i}", 90_000, time_s)
    fit = ps.fit(tmp_path)
    truth = {
        "adc.conversion_gain_dn_per_e": gain,
        "adc.black_level_dn": 64,
        "noise.read_noise_e": 4,
        "noise.row_noise_e": 1,
        "noise.dark_current_e_per_s": 5,
        "noise.dsnu_e": 2,
        "noise.prnu_percent": 0.8,
        "charge.full_well_e": 15_000,
    }
    for key, value in truth.items():
        found = fit.parameters[key]
        assert abs(found.value - value) < 4 * found.standard_error < 0.15 * value, (key, found)
    shaded = [n["reason"] for n in fit.left_out if n["figure"] == "shading"]
    assert len(shaded) == 1 and "vary smoothly by 2" in shaded[0], fit.left_out
    assert any("ISO 100" in note for note in fit.notes)
    fit.save(tmp_path / "twin.toml")
    twin = ps.Sensor(tmp_path / "twin.toml")
    # In the light of the flats, relative to the greenest.
    quantum_efficiencies = [float(line.split()[2]) for line in fit.sensor_file.splitlines() if line.startswith("quantum")]
    assert quantum_efficiencies == pytest.approx([0.6, 1.0, 0.7], rel=0.01)
    assert twin.pixel_pitch_um == (4.0, 4.0)
