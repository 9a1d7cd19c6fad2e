"""EMVA 1288, beside the command and what a sensor's model says of itself."""

from __future__ import annotations

import json
from pathlib import Path

import photosite as ps
import pytest
from conftest import Command

SMALL = {"steps": 12, "spatial": 16, "size_px": (96, 96)}


@pytest.fixture(scope="module")
def report() -> ps.Emva1288Report:
    return ps.emva1288("sony-imx249-mono", **SMALL)  # type: ignore[arg-type]


def test_a_model_shows_its_figures(report: ps.Emva1288Report) -> None:
    [channel] = report
    measured, expected = channel.measured, channel.expected
    assert expected is not None and len(report) == 1 and report[0] is channel
    # 96² pixels of 12 exposures; K is known to some √(2/(12·96²)).
    assert measured.system_gain_dn_per_e == pytest.approx(expected.system_gain_dn_per_e, rel=0.02)
    assert measured.quantum_efficiency == pytest.approx(expected.quantum_efficiency, rel=0.02)
    assert measured.dark_noise_e == pytest.approx(expected.dark_noise_e, rel=0.05)
    assert measured.dsnu_e.total == pytest.approx(expected.dsnu_e.total, rel=0.1)
    assert measured.prnu_percent.total == pytest.approx(expected.prnu_percent.total, rel=0.1)
    assert "Channel Y" in channel.title and "<svg" in report.html and report._repr_html_() == report.html


def test_the_command_measures_the_same(command: Command, tmp_path: Path) -> None:
    size = ["--size", "96x96", "--steps", 12, "--spatial", 16]
    command("emva1288", "sony-imx249-mono", "-o", tmp_path / "theirs", "-q", *size, "--set", "noise.read_noise_e=9")
    expected = json.loads(command("emva1288-report", tmp_path / "theirs", "--json").stdout)
    keys = {"noise.read_noise_e": 9}
    ours = ps.emva1288("sony-imx249-mono", output=tmp_path / "ours", set=keys, **SMALL)  # type: ignore[arg-type]
    names = {p.relative_to(tmp_path / "theirs") for p in (tmp_path / "theirs").rglob("*.t*")}
    assert len(names) > 20
    for name in names:
        assert (tmp_path / "ours" / name).read_bytes() == (tmp_path / "theirs" / name).read_bytes()
    again = ps.emva1288_report(tmp_path / "theirs")
    assert again.channels == ours.channels
    assert again[0].measured.dark_noise_e == expected[0]["measured"]["dark_noise_e"]
    assert again[0].measured.dsnu_e.row == expected[0]["measured"]["dsnu_e"]["row"]
    descriptor = ps.emva1288_report(next((tmp_path / "theirs").rglob("emva1288.txt")))
    assert descriptor[0].expected is None and descriptor[0].measured == again[0].measured
    with pytest.raises(ps.InputError, match="already contains image sets"):
        ps.emva1288("sony-imx249-mono", output=tmp_path / "ours", **SMALL)  # type: ignore[arg-type]


def test_a_sensor_object_does(report: ps.Emva1288Report) -> None:
    sensor = ps.Sensor("sony-imx249-mono")
    assert ps.emva1288(sensor, **SMALL).channels == report.channels  # type: ignore[arg-type]
    noisy = ps.Sensor("sony-imx249-mono", set={"noise.read_noise_e": 30})
    assert ps.emva1288(noisy, **SMALL)[0].measured.dark_noise_e == pytest.approx(30, rel=0.05)  # type: ignore[arg-type]


def test_sweeps_and_progress() -> None:
    told = []
    report = ps.emva1288(
        "sony-imx249-mono",
        sweep_nm=[450, 550],
        temperatures_c=[25, 45],
        steps=5,
        spatial=3,
        size_px=(16, 16),
        progress=lambda done, all: told.append((done, all)),
    )
    assert [light["wavelength_nm"] for light in report[0].wavelengths] == [450, 550]
    assert [place["temperature_c"] for place in report[0].temperatures] == [25, 45]
    assert told[-1][0] == told[-1][1] > 20


@pytest.mark.parametrize(
    ("sensor", "options", "complaint"),
    [
        ("sony-imx1", {}, "no sensor"),
        ("missing.toml", {}, "missing.toml"),
        ("sony-imx249-mono", {"steps": 4}, "steps"),
        ("sony-imx249-mono", {"spatial": 2}, "spatial"),
        ("sony-imx249-mono", {"wavelength_nm": 200}, "wavelength_nm"),
        ("sony-imx249-mono", {"wavelength_nm": float("nan")}, "wavelength_nm"),
        ("sony-imx249-mono", {"saturation_time_s": -1}, "saturation_time_s"),
        ("sony-imx249-mono", {"seed": -1}, "seed"),
        ("sony-imx249-mono", {"channels": ["Q"]}, "no channel"),
        ("sony-imx249-mono", {"size_px": (100_000, 4)}, "100000"),
        ("sony-imx249-mono", {"size_px": (4,)}, "size_px"),
        ("sony-imx249-mono", {"set": {"noise.red_noise_e": 1}}, "red_noise_e"),
    ],
)
def test_what_cannot_be_taken(sensor: str, options: "dict[str, object]", complaint: str) -> None:
    with pytest.raises(ps.Error, match=complaint):
        ps.emva1288(sensor, **options)  # type: ignore[arg-type]


def test_folders_without_image_sets(tmp_path: Path) -> None:
    (tmp_path / "wrong.txt").write_text("n 12\n")
    for path in (tmp_path, tmp_path / "missing", tmp_path / "wrong.txt"):
        with pytest.raises(ps.Error):
            ps.emva1288_report(path)
