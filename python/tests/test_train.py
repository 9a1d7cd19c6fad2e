"""Shards for training programs: what tar files hold, how large shards are, and which folders are refused. The judge
``tests/judges/trainers.py`` reads all formats by the packages that they are for."""

import io
import json
import tarfile
from pathlib import Path

import numpy as np
import photosite as ps
import pytest
from conftest import Command
from photosite import _photosite, train
from photosite.train._samples import grey_png
from photosite.train._shards import frames_within

SET = """
capture = "capture.toml"
frames = 5
[poses.random]
look_at_m = [0, 0.5, 0]
distance_m = [2, 3]
"""


@pytest.fixture
def folder(command: Command, room: Path) -> Path:
    """A finished data set of five frames."""
    (room.parent / "set.toml").write_text(SET)
    changes = ("--set", "output.truth=['depth','instance']", "--set", "render.samples_per_pixel=1")
    command("dataset", room.parent / "set.toml", "-o", room.parent / "out", "--quiet", *changes)
    return room.parent / "out"


def test_tar_files_hold_what_the_frames_hold(folder: Path) -> None:
    shards = folder.with_name("shards")
    assert train.webdataset(folder, shards, shard_frames=2) == 3
    index = json.loads((shards / "index.json").read_text())
    assert [shard["nsamples"] for shard in index["shardlist"]] == [2, 2, 1]
    picture = ps.FramePicture(folder / "camera/000003", "camera", 3)
    with tarfile.open(shards / "shard-000001.tar") as tar:
        names = [name for name in tar.getnames() if name.startswith("camera-000003.")]
        assert names == [f"camera-000003.{field}" for field in FIELDS]
        content = {name.split(".", 1)[1]: (tar.extractfile(name) or io.BytesIO()).read() for name in names}
    assert content["png"] == (picture.folder / "image.png").read_bytes()
    assert content["json"] == (picture.folder / "capture.json").read_bytes()
    raw = np.load(io.BytesIO(content["raw.npy"]))
    assert raw.dtype == np.uint16 and np.array_equal(raw, picture.raw.active)
    instance = np.load(io.BytesIO(content["instance.npy"]))
    assert instance.dtype == np.uint32 and np.array_equal(instance, picture.truth["instance"])
    facts = json.loads(content["camera.json"])
    assert np.allclose(facts["rotation"], picture.camera.R, atol=1e-12)
    # What is there is not written again, and what is lost is.
    assert train.webdataset(folder, shards) == 0
    (shards / "shard-000002.tar").unlink()
    assert train.webdataset(folder, shards) == 1


FIELDS = ("png", "raw.npy", "depth.npy", "instance.npy", "camera.json", "json")


def test_folders_of_other_shards_are_refused(folder: Path, command: Command) -> None:
    shards = folder.with_name("shards")
    train.webdataset(folder, shards, shard_frames=2)
    with pytest.raises(ps.InputError, match="has shards of 2 frames, and not of 3"):
        train.webdataset(folder, shards, shard_frames=3)
    with pytest.raises(ps.InputError, match="at most None MiB, and not of 9"):
        train.webdataset(folder, shards, shard_mb=9)
    with pytest.raises(ps.InputError, match="is not empty and has no layout.json"):
        train.webdataset(folder, folder)
    with pytest.raises(ps.InputError, match="expected at least 1, got 0"):
        train.webdataset(folder, folder.with_name("new"), shard_frames=0)
    other = folder.with_name("other")
    changes = ("--set", "exposure.time_s=0.002", "--set", "render.samples_per_pixel=1")
    command("dataset", folder.parent / "set.toml", "-o", other, "--quiet", *changes)
    with pytest.raises(ps.InputError, match="has shards of another fingerprint"):
        train.webdataset(other, shards)
    (shards / "layout.json").write_text("{}")
    with pytest.raises(ps.InputError, match="is damaged"):
        train.webdataset(folder, shards)


def test_sets_that_are_not_whole_are_refused(folder: Path) -> None:
    (folder / "manifest.jsonl").write_text("".join((folder / "manifest.jsonl").read_text().splitlines(True)[:3]))
    with pytest.raises(ps.InputError, match="3 of 5 images exist"):
        train.webdataset(folder, folder.with_name("shards"))


def test_shards_have_round_counts_of_frames_below_their_limit() -> None:
    assert frames_within(256, 3 << 20) == 70
    assert frames_within(256, 3_200_000) == 70
    assert frames_within(1, 100 << 20) == 1
    assert frames_within(1 << 10, 1) == 900_000_000


def test_grey_png_files_come_back_as_they_are(tmp_path: Path) -> None:
    values = np.arange(6, dtype=np.uint16).reshape(2, 3) * 13_000
    (tmp_path / "grey.png").write_bytes(grey_png(values))
    assert np.array_equal(_photosite.read_codes(str(tmp_path / "grey.png")), values)
