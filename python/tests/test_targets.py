"""Calibration targets and projection, beside the command."""

from __future__ import annotations

import json
import pickle
from pathlib import Path

import numpy as np
import photosite as ps
import pytest
from conftest import CORNELL_BOX, Command


@pytest.mark.parametrize("kind", sorted(ps.Targets.kinds()))
def test_files_are_the_commands(command: Command, tmp_path: Path, kind: str) -> None:
    target = ps.Targets(kind)
    for extension in ("json", "svg", "toml", "obj"):
        (tmp_path / "a").mkdir(exist_ok=True)
        (tmp_path / "b").mkdir(exist_ok=True)
        target.save(tmp_path / "a" / f"t.{extension}")
        command("target", kind, "-o", tmp_path / "b" / f"t.{extension}", "-q")
    for file in (tmp_path / "b").iterdir():
        assert (tmp_path / "a" / file.name).read_bytes() == file.read_bytes(), file.name
    facts = json.loads((tmp_path / "b" / "t.json").read_text())
    xy = np.array([point["xy_mm"] for point in facts["points"]]).reshape(-1, 2)
    assert target.points_m.shape == (len(xy), 3) and np.allclose(target.points_m[:, :2] * 1e3, xy, atol=1e-6)
    assert (target.points_m[:, 2] == 0).all() and len(target.ids) == len(xy)
    assert [marker.id for marker in target.markers] == [marker["id"] for marker in facts["markers"]]
    assert target.keys == facts["target"]


def test_points_of_a_chessboard_are_those_of_opencv() -> None:
    board = ps.Targets("chessboard", squares=[10, 7], square_mm=25)
    expected = np.zeros((9 * 6, 3))
    expected[:, :2] = np.mgrid[0:9, 0:6].T.reshape(-1, 2) * 0.025
    assert np.allclose(board.points_m, expected, atol=1e-12)
    assert not board.points_m.flags.writeable and "chessboard" in repr(board)
    again = pickle.loads(pickle.dumps(board))
    assert again.keys == board.keys


def test_corners_of_a_charuco_board_are_those_of_opencv() -> None:
    cv2 = pytest.importorskip("cv2")
    board = ps.Targets("charuco", squares=[8, 6], square_mm=30, marker_mm=22, dictionary="DICT_5X5_100")
    dictionary = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_5X5_100)
    theirs = cv2.aruco.CharucoBoard((8, 6), 0.030, 0.022, dictionary)
    assert np.allclose(board.points_m, theirs.getChessboardCorners(), atol=1e-6)
    assert np.allclose([marker.corners_m for marker in board.markers], theirs.getObjPoints(), atol=1e-6)


@pytest.mark.parametrize(
    ("kind", "keys", "complaint"),
    [
        ("chessbord", {}, "no target 'chessbord'"),
        (None, {}, "no target None"),
        ("chessboard", {"sqares": [4, 4]}, "unknown key"),
        ("chessboard", {"squares": [1, 1]}, "squares"),
        ("chessboard", {"square_mm": -1}, "square_mm"),
        ("chessboard", {"square_mm": float("nan")}, "square_mm"),
        ("chessboard", {"squares": "many"}, "squares"),
        ("chessboard", {"squares": object()}, "squares"),
    ],
)
def test_targets_that_there_are_not(kind: object, keys: "dict[str, object]", complaint: str) -> None:
    with pytest.raises(ps.InputError, match=complaint):
        ps.Targets(kind, **keys)  # type: ignore[arg-type]


def test_places_that_cannot_be_written_to(tmp_path: Path) -> None:
    for path in (tmp_path / "t.doc", tmp_path / "t", tmp_path / "missing" / "t.svg"):
        with pytest.raises(ps.Error):
            ps.Targets("flat").save(path)


# Projection


def fisheye() -> ps.Capture:
    keys = {"type": "pinhole", "focal_length_mm": 4, "f_number": 4, "focus_distance_m": "infinity"}
    return ps.load(CORNELL_BOX, set={f"lens.{key}": value for key, value in keys.items()})


def points() -> "np.ndarray":
    return np.random.default_rng(3).uniform(-2, 2, (50, 3))


@pytest.mark.parametrize("camera_space", [False, True])
def test_the_command_projects_likewise(command: Command, tmp_path: Path, camera_space: bool) -> None:
    capture = ps.load(CORNELL_BOX)
    np.savetxt(tmp_path / "points.csv", points(), "%.17g", ",")
    options = ["--camera-space"] if camera_space else []
    said = command("project", CORNELL_BOX, "--points", tmp_path / "points.csv", *options).stdout
    expected = np.array([[float(x) for x in line.split(",")] for line in said.splitlines()])
    found = ps.project(capture, points(), camera_space=camera_space)
    assert found.shape == (50, 2) and np.array_equal(found, expected, equal_nan=True)
    assert np.isnan(found).any() and not np.isnan(found).all()
    np.savetxt(tmp_path / "pixels.csv", found[~np.isnan(found[:, 0])], "%.17g", ",")
    said = command("project", CORNELL_BOX, "--points", tmp_path / "pixels.csv", "--inverse", *options).stdout
    expected = np.array([[float(x) for x in line.split(",")] for line in said.splitlines()])
    directions = ps.unproject(capture, found[~np.isnan(found[:, 0])], camera_space=camera_space)
    assert np.array_equal(directions, expected, equal_nan=True)


def test_there_and_back() -> None:
    capture = ps.load(CORNELL_BOX)
    pixels = np.random.default_rng(4).uniform(20, 200, (40, 2))
    directions = ps.unproject(capture, pixels, camera_space=True)
    assert np.allclose(np.linalg.norm(directions, axis=1), 1)
    assert np.allclose(ps.project(capture, directions * 3, camera_space=True), pixels, atol=1e-6)
    one = ps.unproject(capture, pixels[0], camera_space=True)
    assert one.shape == (3,) and np.array_equal(one, directions[0])
    assert ps.project(capture, np.empty((0, 3))).shape == (0, 2)
    assert np.isnan(ps.project(capture, [np.nan, 0, 0])).all()


def test_it_is_the_pinhole_of_the_report() -> None:
    capture = ps.load(CORNELL_BOX, set={"sensor.resolution_px": [32, 24], "render.samples_per_pixel": 1})
    camera = ps.render(capture).camera
    assert camera.distortion.any() == False  # noqa: E712
    inside = points() * 0.3
    image = (camera.R @ inside.T).T + camera.t
    expected = (camera.K @ image.T).T
    found = ps.project(capture, inside)
    seen = ~np.isnan(found[:, 0])
    assert seen.any() and np.allclose(found[seen], (expected[:, :2] / expected[:, 2:])[seen], atol=1e-6)


@pytest.mark.parametrize(
    "wrong", [None, "points", np.zeros((4, 2)), np.zeros((4, 4, 3)), np.zeros((4, 3), complex), [[1, 2], [3]], 3.0]
)
def test_points_that_are_none(wrong: object) -> None:
    with pytest.raises(ps.InputError, match="points"):
        ps.project(CORNELL_BOX, wrong)  # type: ignore[arg-type]


def test_strides_do_not_matter() -> None:
    capture = ps.load(CORNELL_BOX)
    expected = ps.project(capture, points())
    for same in (np.asfortranarray(points()), np.repeat(points(), 2, axis=0)[::2], points().tolist()):
        assert np.array_equal(ps.project(capture, same), expected, equal_nan=True)


def test_a_bare_sensor_sees_no_points() -> None:
    with pytest.raises(ps.InputError, match="bare sensor"):
        ps.project(ps.load(CORNELL_BOX, set={"lens.type": "none"}), points())


def test_what_is_no_capture() -> None:
    with pytest.raises(ps.InputError):
        ps.project(3, points())  # type: ignore[arg-type]
