"""A sensor alone makes of anybody's light what its parameters say."""

from __future__ import annotations

import pickle
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import photosite as ps

NM = np.arange(400.0, 701.0, 20.0)
#: h·c in J·nm, of the exact values of h and c (CODATA 2018).
HC = 6.62607015e-34 * 299_792_458 * 1e9


def cube(rows: int = 24, columns: int = 32) -> Any:
    """Irradiance that differs from pixel to pixel and band to band, W·m⁻²·nm⁻¹."""
    generator = np.random.default_rng(3)
    return generator.uniform(1e-4, 1e-3, (rows, columns, len(NM))).astype(np.float32)


def integral_of_bands(wavelengths: Any, values: Any) -> Any:
    """∫ over each band of a table that is linear in between: NumPy's trapezoids on all of its corners."""
    edges = np.concatenate([[NM[0] - 10], (NM[1:] + NM[:-1]) / 2, [NM[-1] + 10]])
    inside = np.union1d(wavelengths, edges)
    at = np.interp(inside, wavelengths, values, left=0, right=0)
    steps = np.concatenate([[0], np.cumsum(np.diff(inside) * (at[1:] + at[:-1]) / 2)])
    return np.diff(np.interp(edges, inside, steps))


@pytest.mark.parametrize("name", ["sony-imx249-color", "sony-imx249-mono", "generic-cmos-color"])
def test_mean_electrons_are_light_times_quantum_efficiency(name: str) -> None:
    sensor, light = ps.Sensor(name), cube()
    shot = sensor.expose(light, wavelengths_nm=NM, time_s=0.01, illuminant="D65")
    assert shot.electrons.shape == (24, 32, len(sensor.channels)) and shot.channels == sensor.channels
    for i, (channel, (wavelengths, values)) in enumerate(sensor.responses().items()):
        expected = 0.01 * light.astype(np.float64) @ integral_of_bands(wavelengths, values)
        assert np.allclose(shot.electrons[:, :, i], expected, rtol=1e-6), channel


def test_responses_are_quantum_efficiencies_of_a_pixel() -> None:
    sensor = ps.Sensor("sony-imx249-mono")
    area = np.prod(sensor.pixel_pitch_um) * 1e-12
    wavelengths, values = sensor.responses()["Y"]
    efficiency = values * HC / wavelengths / area
    assert 0.3 < efficiency.max() < 1 and 400 < wavelengths[efficiency.argmax()] < 700


def test_frames_give_back_the_parameters_of_the_sensor() -> None:
    """EMVA 1288, sections 6 and 8: K of the photon transfer of pairs, the temporal noise and DSNU of the dark."""
    sensor = ps.Sensor("sony-imx249-mono")
    flat = np.full((120, 160, len(NM)), 4e-5, np.float32)
    means, variances = [], []
    for time_s in (0.0005, 0.001, 0.002, 0.004):
        a, b = (np.asarray(s.raw, np.float64) for s in sensor.expose(flat, wavelengths_nm=NM, time_s=time_s, frames=2, illuminant="D65"))
        means.append((a + b).mean() / 2)
        variances.append(np.var(a - b) / 2)
    slope = np.polyfit(means, variances, 1)[0]
    shot = sensor.expose(flat, wavelengths_nm=NM, time_s=0.001, illuminant="D65")
    gain = shot.report["sensor"]["system_gain_dn_per_e"]
    # The variance of a variance of n numbers is 2/n of its square: 1 % of each of 4 points.
    assert abs(slope / gain - 1) < 0.03
    dark = sensor.expose(np.zeros_like(flat), wavelengths_nm=NM, time_s=1e-4, frames=2, illuminant="D65")
    a, b = (np.asarray(s.raw, np.float64) for s in dark)
    read_noise = np.sqrt(np.var(a - b) / 2 - 1 / 12) / gain
    assert abs(read_noise / shot.report["sensor"]["read_noise_e"] - 1) < 0.05


def test_numbers_have_the_unit_that_is_said() -> None:
    sensor = ps.Sensor("sony-imx249-color")
    electrons = np.full((8, 12, 3), [100.0, 200.0, 300.0], np.float32)
    assert np.array_equal(sensor.expose(electrons, unit="electrons", time_s=0.01, illuminant="D65").electrons, electrons)
    half = sensor.expose(electrons, unit="electrons", one=0.5, time_s=0.01, illuminant="D65").electrons
    assert np.array_equal(half, electrons / 2)
    white = sensor.expose(np.ones((8, 12, 3)), unit="lux", one=100.0, time_s=0.01).electrons
    assert np.allclose(sensor.expose(np.ones((8, 12, 3)), unit="lux", one=200.0, time_s=0.01).electrons, 2 * white)
    # D65 of 100 lx, by its spectrum: the same irradiance in narrow bands.
    watts = np.full((8, 12), 1e-2, np.float32)
    at_550 = sensor.expose(watts, unit="irradiance", wavelength_nm=550, time_s=0.01, illuminant="D65").electrons[0, 0]
    expected = [0.01 * 1e-2 * np.interp(550, *sensor.responses()[name]) for name in sensor.channels]
    assert np.allclose(at_550, expected, rtol=1e-6)


def test_arrays_of_any_layout_are_taken() -> None:
    sensor, light = ps.Sensor("sony-imx249-mono"), cube()
    expected = np.asarray(sensor.expose(light, wavelengths_nm=NM, time_s=0.01, illuminant="D65").raw)
    read_only = light.copy()
    read_only.flags.writeable = False
    strided = np.repeat(light, 2, axis=1)[:, ::2]
    turned = np.ascontiguousarray(light[::-1])[::-1]
    for other in (read_only, strided, turned, np.asfortranarray(light), light.astype(np.float64), light.tolist()):
        raw = np.asarray(sensor.expose(other, wavelengths_nm=NM, time_s=0.01, illuminant="D65").raw)
        assert np.array_equal(raw, expected)


def test_sensors_can_be_pickled_and_changed(tmp_path: Path) -> None:
    sensor = ps.Sensor("sony-imx249-mono", set={"noise.read_noise_e": 50.0, "serial": 7})
    again = pickle.loads(pickle.dumps(sensor))
    assert again.values == sensor.values and sensor.values["noise"]["read_noise_e"] == 50
    dark = np.zeros((32, 32, len(NM)), np.float32)
    one, two = (np.asarray(s.expose(dark, wavelengths_nm=NM, time_s=0.01, illuminant="D65").raw) for s in (sensor, again))
    assert np.array_equal(one, two)
    quiet = ps.Sensor("sony-imx249-mono").expose(dark, wavelengths_nm=NM, time_s=0.01, illuminant="D65")
    assert one.std() > 3 * np.asarray(quiet.raw).std()


def test_shots_of_arrays_can_be_saved(tmp_path: Path) -> None:
    sensor = ps.Sensor("sony-imx249-color")
    shots = sensor.expose(cube(), wavelengths_nm=NM, time_s=0.01, frames=3, illuminant="D65")
    report = shots[2].save(tmp_path / "out")
    assert report["exposure"]["frame"] == 2
    assert np.array_equal(np.asarray(ps.read_raw(tmp_path / "out" / "raw.dng")), np.asarray(shots[2].raw))
    assert shots[0].noise["prnu_gain"].shape == (24, 32)
    with pytest.raises(ps.InputError, match="does not come from a scene"):
        shots[0].truth["depth"]
    with pytest.raises(ps.InputError, match="does not come from a scene"):
        shots[0].camera


def test_what_is_assumed_and_left_out_is_said() -> None:
    sensor, light = ps.Sensor("sony-imx249-color"), cube()
    with pytest.warns(ps.PhotositeWarning, match="white balance is that of D65"):
        sensor.expose(light, wavelengths_nm=NM, time_s=0.01)
    light[3, 4, 0] = -1e-9
    with pytest.warns(ps.PhotositeWarning, match="1 pixel values below 0"):
        sensor.expose(light, wavelengths_nm=NM, time_s=0.01, illuminant="D65")


@pytest.mark.parametrize(
    ("light", "arguments", "key"),
    [
        (np.ones((4, 4, 16), complex), {"wavelengths_nm": NM}, "light"),
        (np.ones((4, 4), np.float32), {"wavelengths_nm": NM}, "light"),
        (np.ones((4, 4, 3), np.float32), {"wavelengths_nm": NM}, "wavelengths_nm"),
        (np.ones((0, 4, 16), np.float32), {"wavelengths_nm": NM}, "light"),
        (np.ones((4, 4, 16), object), {"wavelengths_nm": NM}, "light"),
        ("light", {"wavelengths_nm": NM}, "light"),
        (np.ones((4, 4, 16), np.float32), {"wavelengths_nm": NM[::-1]}, "wavelengths_nm"),
        (np.ones((4, 4, 16), np.float32), {"wavelengths_nm": NM * np.nan}, "wavelengths_nm"),
        (np.ones((4, 4, 16), np.float32), {"wavelengths_nm": NM, "unit": "lux"}, "unit"),
        (np.ones((4, 4, 16), np.float32), {}, "unit"),
        (np.ones((4, 4, 3), np.float32), {"unit": "candles"}, "unit"),
        (np.ones((4, 4, 2), np.float32), {"unit": "electrons"}, "light"),
        (np.ones((4, 4, 3), np.float32), {"unit": "electrons", "one": -1}, ""),
        (np.ones((4, 4), np.float32), {"unit": "irradiance"}, "unit"),
        (np.ones((4, 4, 16), np.float32), {"wavelengths_nm": NM, "illuminant": "candle"}, "illuminant"),
        (np.ones((4, 4, 16), np.float32), {"wavelengths_nm": NM, "time_s": -1}, "exposure.time_s"),
        (np.ones((4, 4, 16), np.float32), {"wavelengths_nm": NM, "frames": 0}, "frames"),
        (np.full((4, 4, 16), np.nan, np.float32), {"wavelengths_nm": NM}, ""),
        (np.full((4, 4, 16), np.inf, np.float32), {"wavelengths_nm": NM}, ""),
    ],
    ids=lambda value: f"{value.dtype}-{value.shape}" if isinstance(value, np.ndarray) else None,
)
def test_what_is_no_light_is_refused(light: Any, arguments: "dict[str, Any]", key: str) -> None:
    sensor = ps.Sensor("sony-imx249-color")
    with pytest.raises(ps.InputError) as error:
        sensor.expose(light, **{"time_s": 0.01, "illuminant": "D65", **arguments})
    assert error.value.key == key


@pytest.mark.parametrize("name", ["no-such-sensor", "nowhere.toml", 3])
def test_sensors_that_are_not_known_are_refused(name: Any) -> None:
    with pytest.raises(ps.Error):
        ps.Sensor(name)
    with pytest.raises(ps.InputError):
        ps.Sensor("sony-imx249-mono", set={"noise.reed_noise_e": 3})
