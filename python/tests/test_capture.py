"""Captures come from files and from dictionaries, with arrays in the place of files."""

from __future__ import annotations

import gc
import os
import pickle
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import photosite as ps
from conftest import ROOM_OBJ

FLOOR = {"positions": [[-1, 0, -1], [1, 0, -1], [1, 0, 1], [-1, 0, 1]], "triangles": [[0, 3, 2], [0, 2, 1]]}
WALL = {"positions": [[-1, 0, -1], [1, 0, -1], [1, 1, -1], [-1, 1, -1]], "triangles": [[0, 1, 2], [0, 2, 3]]}


def values(**scene: Any) -> "dict[str, Any]":
    """The room of the capture file as a dictionary."""
    return {
        "scene": {"environment": {"illuminant": "D65", "illuminance_lux": 500}, **scene},
        "camera": {"position_m": [0, 0.5, 3], "look_at_m": [0, 0.5, 0]},
        "sensor": {"resolution_px": [64, 48]},
        "exposure": {"time_s": 0.01},
        "render": {"samples_per_pixel": 4, "seed": 7},
    }


def arrays(mesh: "dict[str, Any]", **more: Any) -> "dict[str, Any]":
    return {"positions": np.array(mesh["positions"], np.float32), "triangles": np.array(mesh["triangles"]), **more}


def raw(capture: Any) -> Any:
    return np.asarray(ps.render(capture).raw)


def test_a_dictionary_is_a_capture_file(room: Path) -> None:
    of_dictionary = values(geometry=[room.parent / "room.obj"])
    assert np.array_equal(raw(of_dictionary), raw(room))
    of_dictionary["exposure"] = {"time_s": np.float64(0.01)}
    of_dictionary["camera"]["position_m"] = np.array([0, 0.5, 3])
    assert np.array_equal(raw(of_dictionary), raw(room))


def test_changes_are_laid_over_it(room: Path) -> None:
    one = ps.load(room, set={"exposure.time_s": 0.02, "lens": {"f_number": 4}})
    two = ps.load(room).set({"exposure.time_s": 0.02}).set({"lens.f_number": 4})
    assert one.values == two.values and one.values["lens"]["f_number"] == 4
    assert np.array_equal(raw(one), raw(two))


def test_meshes_are_arrays(room: Path) -> None:
    with_arrays = values(geometry=[arrays(FLOOR), arrays(WALL)])
    depth = ps.trace(with_arrays).truth["depth"]
    assert np.allclose(depth, ps.trace(room).truth["depth"], rtol=1e-6)
    # Any memory layout will do.
    mesh = arrays(WALL)
    mesh["positions"] = np.asfortranarray(np.repeat(mesh["positions"], 2, axis=0)[::2].astype(np.float64))
    mesh["positions"].flags.writeable = False
    assert np.array_equal(ps.trace(values(geometry=[arrays(FLOOR), mesh])).truth["depth"], depth)


def test_spectra_textures_and_environments_are_arrays(tmp_path: Path) -> None:
    table = np.array([[400, 0.1], [500, 0.2], [700, 0.9]])
    (tmp_path / "red.csv").write_text("400,0.1\n500,0.2\n700,0.9\n")
    codes = np.random.default_rng(1).integers(0, 255, (4, 4, 3), np.uint8)
    (tmp_path / "codes.ppm").write_bytes(b"P6 4 4 255\n" + codes.tobytes())
    sky = np.ones((8, 16, 3), np.float32) * [0.2, 0.5, 1.0]
    uvs = np.array([[0, 1], [1, 1], [1, 0], [0, 0]])
    geometry = [arrays(FLOOR, material="floor"), arrays(WALL, material="wall", uvs=uvs)]

    def capture(reflectance: Any, texture: Any) -> "dict[str, Any]":
        made = values(geometry=geometry, environment={"image": sky, "nit_per_unit": 1000})
        made["materials"] = {
            "floor": {"type": "diffuse", "reflectance": {"file": reflectance}},
            "wall": {"type": "diffuse", "reflectance": {"texture": texture}},
        }
        return made

    of_files = capture(str(tmp_path / "red.csv"), str(tmp_path / "codes.ppm"))
    assert np.array_equal(raw(capture(table, codes)), raw(of_files))
    red, _, blue = ps.trace(of_files).electrons_per_s[40, 32]
    assert red > 0 and blue > 0


def test_captures_can_be_pickled(room: Path, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.chdir(room.parent)
    for capture in (ps.load("capture.toml", set={"exposure.time_s": 0.02}), ps.load(values(geometry=[arrays(WALL)]))):
        text = pickle.dumps(capture)
        expected = raw(capture)
        (tmp_path / "elsewhere").mkdir(exist_ok=True)
        monkeypatch.chdir(tmp_path / "elsewhere")
        assert np.array_equal(raw(pickle.loads(text)), expected)
        # A capture goes on being the same where relative paths would lead elsewhere.
        assert capture.set({"exposure.gain_db": 0}).resolution_px == (64, 48)
        monkeypatch.chdir(room.parent)


def test_files_of_arrays_go_with_their_capture(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    capture = ps.load(values(geometry=[arrays(WALL)]))
    [folder] = tmp_path.iterdir()
    if hasattr(os, "fork"):
        child = os.fork()
        if child == 0:
            del capture
            gc.collect()
            os._exit(0)
        os.waitpid(child, 0)
        assert folder.exists()
    shot = ps.render(capture)
    del capture
    gc.collect()
    assert folder.exists() and shot.truth["depth"].shape == (48, 64)
    del shot
    gc.collect()
    assert not folder.exists()


def test_errors_name_file_line_and_key(room: Path) -> None:
    room.write_text(room.read_text().replace("time_s = 0.01", "time_s = -3"))
    with pytest.raises(ps.InputError) as caught:
        ps.load(room)
    error = caught.value
    assert (error.file, error.line, error.key) == (str(room), 11, "exposure.time_s")
    assert "above 0" in error.reason and error.help and str(error).startswith(f"{room}:11: exposure.time_s: ")
    assert isinstance(error, ValueError)
    if sys.version_info >= (3, 11):
        assert error.__notes__ == [f"help: {error.help}"]
    again = pickle.loads(pickle.dumps(error))
    assert type(again) is ps.InputError and str(again) == str(error) and again.line == 11 and again.help == error.help
    with pytest.raises(FileNotFoundError) as missing:
        ps.load(room.parent / "nowhere.toml")
    assert isinstance(missing.value, ps.FileError) and missing.value.file == str(room.parent / "nowhere.toml")
    again = pickle.loads(pickle.dumps(missing.value))
    assert isinstance(again, FileNotFoundError) and again.errno == missing.value.errno


def test_the_text_is_that_of_the_command(room: Path) -> None:
    room.write_text(room.read_text().replace("[camera]", "[camra]"))
    done = subprocess.run(
        [sys.executable, "-m", "photosite", "--log-json", "info", str(room)], capture_output=True, text=True, check=False
    )
    with pytest.raises(ps.InputError) as error:
        ps.load(room)
    import json

    said = json.loads(done.stderr.splitlines()[-1])
    assert said["message"] == str(error.value) and said["help"] == error.value.help and said["line"] == error.value.line


@pytest.mark.parametrize(
    ("part", "meant"),
    [
        ("faces", "triangles"),
        ("indices", "triangles"),
        ("vertices", "positions"),
        ("uv", "uvs"),
        ("normal", "normals"),
        ("triangle", "triangles"),
    ],
)
def test_other_names_of_a_mesh_name_ours(part: str, meant: str) -> None:
    mesh = {key: value for key, value in WALL.items() if key != meant}
    with pytest.raises(ps.InputError) as error:
        ps.load(values(geometry=[{**mesh, part: [[0, 1, 2]]}]))
    assert error.value.key == f"scene.geometry[0].{part}" and f"did you mean '{meant}'" in str(error.value)


@pytest.mark.parametrize(
    ("source", "key"),
    [
        (3, "source"),
        (None, "source"),
        ({"scen": {}}, "scen"),
        ({1: {}}, "capture"),
        ({"exposure": {"time_s": None}}, "exposure.time_s"),
        ({"exposure": {"time_s": float("inf")}}, "exposure.time_s"),
        ({"exposure": {"time_s": object()}}, "exposure.time_s"),
        ({"exposure": {"time_s": "0.1"}}, "exposure.time_s"),
        (values(geometry=[{"positions": [[0, 0, 0]]}]), "scene.geometry[0].triangles"),
        (values(geometry=[{**WALL, "colour": 1}]), "scene.geometry[0].colour"),
        (values(geometry=[{**WALL, "positions": [[0, 0]]}]), "scene.geometry[0].positions"),
        (values(geometry=[{**WALL, "positions": "xyz"}]), "scene.geometry[0].positions"),
        (values(geometry=[{**WALL, "positions": np.full((4, 3), np.nan)}]), "scene.geometry[0].positions"),
        (values(geometry=[{**WALL, "triangles": [[0, 1, 4]]}]), "scene.geometry[0].triangles"),
        (values(geometry=[{**WALL, "triangles": [[0.5, 1, 2]]}]), "scene.geometry[0].triangles"),
        (values(geometry=[{**WALL, "uvs": [[0, 0]]}]), "scene.geometry[0].uvs"),
        (values(geometry=[WALL], environment={"image": np.ones((4, 8))}), "scene.environment.image"),
        (values(geometry=[WALL], environment={"image": np.ones((4, 8, 3), complex)}), "scene.environment.image"),
    ],
    ids=lambda value: None if isinstance(value, dict) else str(value),
)
def test_what_is_no_capture_is_refused(source: Any, key: str) -> None:
    with pytest.raises(ps.InputError) as error:
        ps.load(source)
    assert error.value.key == key and error.value.file == "<python>"


def test_a_scene_is_kept_until_a_change_touches_it(room: Path) -> None:
    capture = ps.load(room)
    shutil.rmtree(room.parent)
    longer = capture.set({"exposure.time_s": 0.02})
    assert np.asarray(ps.render(longer).raw).shape == (48, 64)
    with pytest.raises(ps.Error):
        capture.set({"scene.variant": "another"})


def test_scene_files_stand_for_captures(room: Path) -> None:
    (room.parent / "wall.obj").write_text(ROOM_OBJ)
    capture = ps.load(room.parent / "wall.obj", set={"sensor.resolution_px": [32, 24]})
    assert ps.trace(capture, samples=1).camera.K[0, 0] > 0


def test_layers_are_in_the_frames_of_objects(room: Path) -> None:
    objects = [
        {"file": str(room.parent / "room.obj"), "position_m": [0.1, 0, -0.2], "scale": 0.5, "rotation_deg": [0, 30, 0]}
    ]
    truth = ps.trace(ps.load(room, set={"scene.geometry": [], "scene.objects": objects}), samples=1).truth
    seen = np.isfinite(truth["depth"])
    assert seen.any()
    own, world, nocs = truth["object-position"][seen], truth["position"][seen], truth["nocs"][seen]
    sine, cosine = np.sin(np.pi / 6), np.cos(np.pi / 6)
    turn = np.array([[cosine, 0, sine], [0, 1, 0], [-sine, 0, cosine]])
    assert np.allclose(world, own @ turn.T + [0.1, 0, -0.2], atol=1e-5)
    steps = np.diff(own, axis=0)
    moved = np.abs(steps) > 1e-2
    ratios = np.diff(nocs, axis=0)[moved] / steps[moved]
    assert np.allclose(ratios, ratios[0], rtol=1e-3)
    assert ((nocs > -1e-5) & (nocs < 1 + 1e-5)).all()
