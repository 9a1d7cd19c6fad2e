"""Light is traced once and exposed often; what comes out is what the command writes."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import photosite as ps
from conftest import Command

#: Keys of three captures: a mosaic with all that is written; an automatic exposure of a sensor without colours; a moving
#: camera behind a distorting lens, before a CCD.
CAPTURES: "dict[str, dict[str, Any]]" = {
    "mosaic": {
        "sensor.preset": "generic-cmos-color",
        "output.irradiance": {"bands_nm": [400, 700, 50]},
        "output.ideal": True,
    },
    "mono-auto": {"sensor.preset": "sony-imx249-mono", "exposure.auto": True, "exposure.max_time_s": 0.5},
    "moving": {
        "camera.motion.velocity_m_per_s": [0.5, 0, 0],
        "lens.distortion": {"model": "brown-conrady", "k": [-0.2, 0.05, 0.0], "p": [0.0, 0.0]},
        "lens.focal_length_mm": 4.0,
    },
}
#: What is written of each besides.
OUTPUT: "dict[str, Any]" = {
    "output.raw": ["dng", "npy"],
    "output.truth": ["depth", "normal", "flow"],
    "output.truth_formats": ["exr", "npy"],
    "output.noise": ["prnu_e", "read_noise_e"],
    "output.noise_formats": ["exr", "npy"],
}


def assignments(keys: "dict[str, Any]") -> "list[str]":
    """As the command takes them."""
    return [part for key, value in keys.items() for part in ("--set", f"{key}={toml(value)}")]


def toml(value: Any) -> str:
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{key} = {toml(item)}" for key, item in value.items()) + " }"
    return json.dumps(value)


@pytest.fixture(params=list(CAPTURES))
def both(
    request: pytest.FixtureRequest, room: Path, tmp_path: Path, command: Command
) -> "tuple[ps.Shot, Path, Path]":
    """A shot, the folder that it is saved to, and that of the command."""
    keys = {**CAPTURES[request.param], **OUTPUT}
    command("render", room, "--quiet", "-o", tmp_path / "command", *assignments(keys))
    shot = ps.trace(ps.load(room, set=keys)).expose()
    shot.save(tmp_path / "python")
    return shot, tmp_path / "python", tmp_path / "command"


def test_files_have_the_bytes_of_the_command(both: "tuple[ps.Shot, Path, Path]") -> None:
    _, python, command = both
    names = sorted(path.name for path in command.iterdir())
    assert sorted(path.name for path in python.iterdir()) == names and "electrons.exr" in names
    for name in names:
        if name != "capture.json":
            assert (python / name).read_bytes() == (command / name).read_bytes(), name


def test_reports_say_the_same_but_for_times(both: "tuple[ps.Shot, Path, Path]") -> None:
    shot, python, command = both
    reports = [json.loads((folder / "capture.json").read_text()) for folder in (python, command)]
    for report in [*reports, shot.report]:
        for key in ("timings", "paths_per_s", "overrides"):
            report.pop(key, None)
    assert reports[0] == reports[1]
    # In memory there are no files, and paths are relative to other folders.
    for key in set(reports[1]) - {"files", "sums", "input", "capture", "fingerprint"}:
        assert shot.report[key] == reports[1][key], key


def test_arrays_hold_what_the_files_of_the_command_hold(both: "tuple[ps.Shot, Path, Path]") -> None:
    shot, _, command = both
    assert np.array_equal(np.asarray(shot.raw), np.load(command / "raw.npy"))
    assert np.array_equal(shot.truth["depth"], np.load(command / "truth-depth.npy"))
    for layer in ("normal", "flow"):
        assert np.array_equal(shot.truth[layer], np.load(command / f"truth-{layer}.npy")), layer
    for name in ("prnu_e", "read_noise_e"):
        assert np.array_equal(shot.noise[name], np.load(command / f"noise-{name}.npy")), name
    report = json.loads((command / "capture.json").read_text())
    assert np.array_equal(shot.camera.K, report["camera"]["camera_matrix"])
    assert shot.time_s == report["exposure"]["time_s"] and shot.gain_db == report["exposure"]["gain_db"]
    assert np.allclose(shot.camera.R @ shot.camera.position_m + shot.camera.t, 0)


def test_noise_maps_sum_to_the_raw_image(room: Path) -> None:
    shot = ps.render(room)
    gain = shot.report["sensor"]["system_gain_dn_per_e"]
    parts = {"e-": 0.0, "DN": 0.0, "": 0.0}
    for name, unit in shot.noise.units.items():
        parts[unit] = parts[unit] + shot.noise[name].astype(np.float64)
    total = shot.report["sensor"]["black_level_dn"] + gain * parts["e-"] + parts["DN"]
    # Single precision holds a signal of 4096 DN to some 1e-4 DN in each of 40 maps.
    assert np.abs(total - np.asarray(shot.raw)).max() < 0.02


def test_exposures_are_those_that_the_command_makes_of_the_whole_capture(
    room: Path, tmp_path: Path, command: Command
) -> None:
    light = ps.trace(room)
    changes = {"exposure.time_s": 0.004, "exposure.gain_db": 6.0, "sensor.noise.read_noise_e": 9.0}
    command("render", room, "--quiet", "-o", tmp_path / "one", *assignments({**changes, "output.raw": ["npy"]}))
    shot = light.expose(time_s=0.004, gain_db=6, set={"sensor.noise.read_noise_e": 9.0})
    assert np.array_equal(np.asarray(shot.raw), np.load(tmp_path / "one" / "raw.npy"))
    assert np.allclose(shot.electrons, 0.004 * light.electrons_per_s, rtol=1e-6)
    assert np.allclose(shot.variance, 0.004**2 * light.variance, rtol=1e-6)


def test_frames_are_those_of_the_command(room: Path, tmp_path: Path, command: Command) -> None:
    keys = {"exposure.frames": 3, "output.raw": ["npy"]}
    command("render", room, "--quiet", "-o", tmp_path / "series", *assignments(keys))
    light = ps.trace(ps.load(room, set={"exposure.frames": 3}))
    shots = light.expose(frames=3)
    for i, shot in enumerate(shots):
        assert shot.frame == i
        assert np.array_equal(np.asarray(shot.raw), np.load(tmp_path / "series" / f"raw-{i:04d}.npy"))
    assert not np.array_equal(np.asarray(shots[0].raw), np.asarray(shots[1].raw))
    assert np.array_equal(shots[0].noise["prnu_gain"], shots[2].noise["prnu_gain"])
    report = shots[2].save(tmp_path / "last")
    assert report["exposure"]["frame"] == 2 and report["exposure"]["frames"] == 1 and "fingerprint" not in report
    assert np.array_equal(np.asarray(ps.read_raw(tmp_path / "last" / "raw.dng")), np.asarray(shots[2].raw))


def test_another_sensor_sees_the_irradiance(room: Path, tmp_path: Path, command: Command) -> None:
    keys = {"output.irradiance": {"bands_nm": [380, 780, 20]}}
    command("render", room, "--quiet", "-o", tmp_path / "light", *assignments(keys))
    other = {"sensor.preset": "sony-imx249-mono", "output.raw": ["npy"]}
    command("expose", tmp_path / "light", "--quiet", "-o", tmp_path / "mono", *assignments(other))
    mono = np.load(tmp_path / "mono" / "raw.npy")
    light = ps.trace(ps.load(room, set=keys))
    assert light.irradiance.shape == (48, 64, 20) and np.allclose(light.wavelengths_nm, np.arange(390, 780, 20))
    with pytest.warns(ps.PhotositeWarning, match="lies outside"):
        shot = light.expose(set={"sensor.preset": "sony-imx249-mono"})
    assert shot.channels == ("Y",)
    assert np.array_equal(np.asarray(shot.raw), mono)
    with pytest.raises(ps.InputError, match="not known for this light"):
        shot.variance
    with pytest.warns(ps.PhotositeWarning):
        assert np.array_equal(np.asarray(ps.expose(tmp_path / "light", set=other).raw), mono)


@pytest.mark.parametrize("threads", [1, 2])
def test_light_does_not_depend_on_threads(room: Path, threads: int) -> None:
    assert ps.trace(room, threads=threads).electrons_per_s.tobytes() == ps.trace(room).electrons_per_s.tobytes()


def test_two_python_threads_at_once(room: Path) -> None:
    expected = [np.asarray(ps.render(room, seed=seed).raw).tobytes() for seed in range(4)]
    found: "dict[int, bytes]" = {}

    def make(seed: int) -> None:
        found[seed] = np.asarray(ps.render(room, seed=seed).raw).tobytes()

    threads = [threading.Thread(target=make, args=(seed,)) for seed in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert [found[seed] for seed in range(4)] == expected


def test_the_lock_is_free_while_light_is_traced(room: Path) -> None:
    seen = []
    light = threading.Thread(target=lambda: seen.append(ps.trace(room, samples=3000)))
    light.start()
    counted = 0
    while light.is_alive():
        counted += 1
        time.sleep(0.001)
    assert seen and counted > 3


def test_progress_is_told_and_its_errors_stop_the_work(room: Path) -> None:
    told: "list[tuple[int, int]]" = []
    ps.trace(room, samples=2000, progress=lambda done, all: told.append((done, all)))
    assert told == sorted(told) and told[-1] == (64 * 48 * 2000,) * 2

    def refuse(done: int, all: int) -> None:
        raise RuntimeError("enough")

    with pytest.raises(RuntimeError, match="enough"):
        ps.trace(room, samples=2_000_000, progress=refuse)


ENDLESS = """
import photosite as ps, sys
print("begun", flush=True)
try:
    ps.trace({room!r}, samples=2_000_000_000, checkpoint={place!r}, progress=False)
except KeyboardInterrupt as stopped:
    print("stopped:", stopped, flush=True)
"""


@pytest.mark.skipif(sys.platform == "win32", reason="no signals")
def test_ctrl_c_leaves_a_checkpoint_from_which_the_same_call_goes_on(
    room: Path, tmp_path: Path, command: Command
) -> None:
    place = tmp_path / "place"
    code = ENDLESS.format(room=str(room), place=str(place))
    process = subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True)
    assert process.stdout is not None and process.stdout.readline() == "begun\n"
    while not place.exists():
        time.sleep(0.01)
    time.sleep(0.3)
    process.send_signal(signal.SIGINT)
    out, _ = process.communicate(timeout=60)
    assert out.startswith("stopped: run the same command again, and it continues from") and process.returncode == 0
    assert list(place.glob("checkpoint*"))

    # What was kept is what was traced: a short render of the same samples goes on, and gives what one at a stretch does.
    whole = ps.trace(room, samples=40)
    seen: "list[int]" = []

    def stop(done: int, all: int) -> None:
        seen.append(done)
        raise KeyboardInterrupt

    other = tmp_path / "other"
    big = ps.load(room, set={"render.samples_per_pixel": 20_000, "output.checkpoint_interval_s": 0.01})
    with pytest.raises(KeyboardInterrupt):
        ps.trace(big, checkpoint=other, progress=stop)
    assert list(other.glob("checkpoint*"))
    resumed = ps.trace(big, checkpoint=other)
    assert not other.exists() or not list(other.iterdir())
    assert resumed.electrons_per_s.tobytes() == ps.trace(big).electrons_per_s.tobytes()
    assert whole.paths == 40 * 64 * 48


def test_folders_are_filled_as_by_the_command(room: Path, tmp_path: Path, command: Command) -> None:
    keys = {"exposure.frames": 2}
    command("render", room, "--quiet", "-o", tmp_path / "command", *assignments(keys))
    report = ps.render_into(ps.load(room, set=keys), tmp_path / "python")
    names = sorted(path.name for path in (tmp_path / "command").iterdir())
    assert sorted(path.name for path in (tmp_path / "python").iterdir()) == names
    for name in names:
        if name != "capture.json":
            assert (tmp_path / "python" / name).read_bytes() == (tmp_path / "command" / name).read_bytes(), name
    # The same again is there already; another one is refused.
    before = (tmp_path / "python" / "capture.json").read_bytes()
    assert ps.render_into(ps.load(room, set=keys), tmp_path / "command")["files"] == report["files"]
    with pytest.raises(ps.InputError, match="earlier render") as error:
        ps.render_into(ps.load(room), tmp_path / "python")
    assert "overwrite=True" in str(error.value.help)
    assert (tmp_path / "python" / "capture.json").read_bytes() == before


def test_devices_are_named_and_chosen(room: Path) -> None:
    found = ps.devices()
    assert found[0]["device"] == "cpu" and all(row["device"].startswith("gpu:") for row in found[1:])
    named = ps.trace(room, device="cpu")
    assert named.electrons_per_s.tobytes() == ps.trace(room).electrons_per_s.tobytes()
    with pytest.raises(ps.InputError, match="write cpu, gpu, auto") as error:
        ps.trace(room, device="cuda")
    assert error.value.key == "device"
    with pytest.raises(ps.ResourceError, match="nobody's card"):
        ps.trace(room, device="gpu:nobody's card")


def test_graphics_cards_see_what_the_processor_sees(room: Path, tmp_path: Path) -> None:
    cards = [row["device"] for row in ps.devices() if row["device"] != "cpu" and row["refusal"] is None]
    if not cards:
        pytest.skip("no graphics card, and no software that stands for one")
    light, card = ps.trace(room), ps.trace(room, device=cards[0])
    expected, seen = light.electrons_per_s, card.electrons_per_s
    # Paths are the same but for rounding, which sends few of them another way.
    assert abs(seen.mean() / expected.mean() - 1) < 1e-3
    assert np.quantile(np.abs(seen - expected), 0.99) < 1e-3 * expected.mean()
    report = ps.render_into(room, tmp_path / "card", device=cards[0])
    assert report["render"]["device"]
    with pytest.raises(ps.InputError, match="earlier render"):
        ps.render_into(room, tmp_path / "card")


def test_graphics_cards_expose_as_the_processor_does(room: Path, tmp_path: Path) -> None:
    light = ps.trace(room)
    with pytest.raises(ps.InputError, match="write cpu, gpu, auto") as error:
        light.expose(device="cuda")
    assert error.value.key == "device"
    cards = [row["device"] for row in ps.devices() if row["device"] != "cpu" and row["refusal"] is None]
    if not cards:
        pytest.skip("no graphics card, and no software that stands for one")
    expected, seen = (light.expose(frames=2, seed=3, device=device) for device in ("cpu", cards[0]))
    for ours, theirs in zip(expected, seen):
        # Some in ten millions differ, and these are thousands.
        assert np.count_nonzero(np.asarray(ours.raw) != np.asarray(theirs.raw)) <= 1
        assert ours.report["exposure"].get("device") is None and theirs.report["exposure"]["device"]
    # What a card lacks, the processor does.
    with pytest.warns(ps.PhotositeWarning, match="the processor exposes: exposure.binning"):
        binned = light.expose(set={"exposure.binning": [2, 2]}, device=cards[0])
    assert "device" not in binned.report["exposure"]


def test_series_that_move_say_that_light_is_of_the_first_picture(room: Path) -> None:
    capture = ps.load(room, set={"camera.motion.velocity_m_per_s": [0.5, 0, 0], "exposure.frames": 4})
    with pytest.warns(ps.PhotositeWarning, match="first of 4 images") as warned:
        ps.trace(capture)
    assert warned[0].filename == __file__


KEYS = {"exposure.time_s": 0.001, "output.raw": ["npy"]}


@pytest.mark.parametrize(
    "keys",
    [{"exposure.frames": 3, "exposure.gain_control": {}}, {"exposure.bracket_ev": [-1, 0, 1]}],
    ids=["gain control", "bracket"],
)
def test_frames_of_a_series_are_those_of_folders(room: Path, tmp_path: Path, keys: "dict[str, Any]") -> None:
    capture = ps.load(room, set={**KEYS, **keys})
    ps.render_into(capture, tmp_path / "out")
    files = [np.load(tmp_path / f"out/raw-{frame:04d}.npy") for frame in range(3)]
    shots = ps.trace(capture).expose(frames=3)
    for raw, shot in zip(files, shots):
        np.testing.assert_array_equal(shot.raw, raw)
    np.testing.assert_array_equal(ps.expose(tmp_path / "out").raw, files[0])
    assert len({(shot.gain_db, shot.time_s) for shot in shots}) == 3


def test_brackets_have_no_more_frames_than_times(room: Path) -> None:
    light = ps.trace(ps.load(room, set={"exposure.bracket_ev": [-1, 0, 1]}))
    with pytest.raises(ps.InputError, match="there is no frame 3"):
        light.expose(frames=4)
