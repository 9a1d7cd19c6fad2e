"""Recordings for Rerun, read by its own reader."""

import warnings

import numpy as np
import photosite as ps
import pytest

CAPTURE = """
[scene]
environment = { illuminant = "D65", illuminance_lux = 500 }
[[targets]]
type = "chessboard"
name = "board"
squares = [6, 5]
square_mm = 40
position_m = [0, 0, 0]
look_at_m = [0.2, 0.3, 2]
[camera]
position_m = [0, 0, 1.2]
look_at_m = [0, 0, 0]
[lens]
type = "pinhole"
f_number = 4
focus_distance_m = "infinity"
intrinsics = { fx = 40.5, fy = 41, cx = 15.5, cy = 11.25 }
[sensor]
preset = "generic-cmos-color"
resolution_px = [32, 24]
[exposure]
time_s = 0.004
[render]
samples_per_pixel = 1
max_depth = 1
[output]
electrons = false
truth = ["depth", "instance"]
"""
SET = """
capture = "capture.toml"
frames = 3
[[cameras]]
name = "left"
[[cameras]]
name = "right"
position_m = [0.12, 0.01, -0.02]
[poses.trajectory]
frame_rate_hz = 10
poses = [
  { time_s = 0, position_m = [-0.1, 0, 1.2], look_at_m = [0, 0, 0] },
  { time_s = 1, position_m = [0.3, 0.2, 1.2], look_at_m = [0.1, 0, 0], up = [0.2, 1, 0] },
]
"""
DISTORTION = {"lens.distortion": {"model": "brown-conrady", "k": [-0.3, 0, 0], "p": [0, 0]}}


@pytest.fixture
def dataset(tmp_path):
    (tmp_path / "capture.toml").write_text(CAPTURE)
    (tmp_path / "set.toml").write_text(SET)
    made = ps.Dataset(tmp_path / "set.toml", output=tmp_path / "set")
    made.render(progress=False)
    return made


def columns(path):
    """Of each entity and component, the values by the numbers of the frames, and the times."""
    found, times = {}, {}
    for chunk in pytest.importorskip("rerun.chunk").RrdReader(path).stream():
        batch = chunk.to_record_batch()
        names = batch.schema.names
        if "frame" not in names:
            continue
        frames = batch.column("frame").to_pylist()
        if "time" in names:
            times.update(zip(frames, (t.total_seconds() for t in batch.column("time").to_pylist())))
        for name in names:
            if ":" in name:
                values = batch.column(name).to_pylist()
                found.setdefault((str(chunk.entity_path), name), {}).update(
                    (frame, value) for frame, value in zip(frames, values) if value is not None
                )
    return found, times


def array(found, entity, component, frame, dtype, shape):
    return np.array(found[entity, component][frame][0], np.uint8).view(dtype).reshape(shape)


def test_recordings_hold_the_arrays_and_the_poses(dataset, tmp_path):
    pytest.importorskip("rerun")
    path = tmp_path / "set.rrd"
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        ps.to_rerun(dataset.folder, path)
    found, times = columns(path)
    assert times == pytest.approx({0: 0.0, 1: 0.1, 2: 0.2})
    for frame in dataset:
        for name, picture in frame.items():
            camera, number = picture.camera, frame.number
            at, image = f"/world/{name}", f"/world/{name}/image"
            (translation,) = found[at, "Transform3D:translation"][number]
            (columns_of_matrix,) = found[at, "Transform3D:mat3x3"][number]
            # Column by column; 32-bit floats.
            assert np.allclose(np.reshape(columns_of_matrix, (3, 3)).T, camera.R.T, atol=1e-7)
            assert np.allclose(translation, -camera.R.T @ camera.t, atol=1e-6)
            (matrix,) = found[image, "Pinhole:image_from_camera"][number]
            assert np.allclose(np.reshape(matrix, (3, 3)).T, camera.K, atol=1e-5)
            png = bytes(found[image, "EncodedImage:blob"][number][0])
            assert png == (picture.folder / "image.png").read_bytes()
            depth = array(found, f"{image}/depth", "DepthImage:buffer", number, np.float32, (24, 32))
            assert np.isinf(depth).any() and np.array_equal(depth, picture.truth["depth"])
            instance = array(found, f"{image}/instance", "SegmentationImage:buffer", number, np.uint16, (24, 32))
            assert instance.any() and np.array_equal(instance, picture.truth["instance"])
            raw = array(found, f"/raw/{name}", "Image:buffer", number, np.uint16, (24, 32))
            assert np.array_equal(raw, np.asarray(picture.raw))
    assert [entry.name for entry in tmp_path.iterdir() if "rrd" in entry.name] == ["set.rrd"]


def test_a_dataset_is_recorded_as_its_folder_is(dataset, tmp_path):
    pytest.importorskip("rerun")
    ps.to_rerun(dataset, tmp_path / "a.rrd")
    ps.to_rerun(dataset[1:2], tmp_path / "b.rrd")
    assert {len(values) for values in columns(tmp_path / "a.rrd")[0].values()} == {3}
    assert {tuple(values) for values in columns(tmp_path / "b.rrd")[0].values()} == {(1,)}


def test_what_rerun_does_not_know_is_said(dataset, tmp_path):
    pytest.importorskip("rerun")
    bent = ps.Dataset(tmp_path / "set.toml", output=tmp_path / "bent", set=DISTORTION)[:1]
    with pytest.warns(ps.PhotositeWarning, match=r"up to \d+\.\d px") as said:
        ps.to_rerun(bent, tmp_path / "bent.rrd")
    assert len(said) == 2


def test_wrong_usage_says_what_to_give(tmp_path):
    pytest.importorskip("rerun")
    with pytest.raises(ps.InputError, match="manifest.jsonl"):
        ps.to_rerun(tmp_path, tmp_path / "a.rrd")
    with pytest.raises(ps.InputError, match=".rrd"):
        ps.to_rerun(tmp_path, tmp_path / "a.bin")


def test_without_the_package_the_error_names_it(tmp_path, monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "rerun", None)
    with pytest.raises(ps.Error, match="not installed") as refused:
        ps.to_rerun(tmp_path, tmp_path / "a.rrd")
    assert refused.value.help == "pip install rerun-sdk"
