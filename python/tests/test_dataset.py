"""Data sets, beside the command."""

from __future__ import annotations

import gc
import json
import multiprocessing
import os
import pickle
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path
from typing import Any

import numpy as np
import photosite as ps
import pytest
from conftest import Command, contents

def test_frames_are_the_commands(command: Command, file: Path, tmp_path: Path) -> None:
    command("dataset", file, "-o", tmp_path / "theirs", "-q")
    dataset = ps.Dataset(file, output=tmp_path / "ours")
    assert len(dataset) == 5 and dataset.cameras == ("left", "right")
    assert not (tmp_path / "ours").exists(), "nothing is made before it is asked for"
    third = dataset[2]
    assert third.number == 2 and sorted(p.parent.name for p in (tmp_path / "ours").rglob("raw.dng")) == ["000002"] * 2
    for frame in dataset:
        assert list(frame) == ["left", "right"] and len(frame) == 2
        for name, picture in frame.items():
            theirs = tmp_path / "theirs" / name / f"{frame.number:06}"
            assert contents(picture.folder) == contents(theirs)
            assert np.array_equal(np.asarray(picture.raw), np.asarray(ps.read_raw(theirs / "raw.dng")))
            assert picture.report == json.loads((theirs / "capture.json").read_text())
    assert dataset.render() == 0, "all are there"
    assert contents(tmp_path / "ours") == contents(tmp_path / "theirs")


def test_a_data_set_is_made_on_the_device_that_is_asked_for(file: Path, tmp_path: Path) -> None:
    with pytest.raises(ps.InputError, match="write cpu, gpu, auto") as error:
        ps.Dataset(file, device="cuda")
    assert error.value.key == "device"
    cards = [row["device"] for row in ps.devices() if row["device"] != "cpu" and row["refusal"] is None]
    if not cards:
        pytest.skip("no graphics card, and no software that stands for one")
    dataset = ps.Dataset(file, output=tmp_path / "card", device=cards[0])
    name = dataset[0]["left"].report["render"]["device"]
    elsewhere = pickle.loads(pickle.dumps(dataset))
    assert name and elsewhere[1]["left"].report["render"]["device"] == name
    # Its images are those of a device, and so is the data set.
    with pytest.raises(ps.InputError):
        ps.Dataset(file, output=tmp_path / "card").render()
    with pytest.raises(ps.InputError, match="workers trace on the processor") as error:
        dataset.run()
    assert error.value.key == "device"


def test_what_the_command_has_made_is_read(command: Command, file: Path, tmp_path: Path) -> None:
    command("dataset", file, "-o", tmp_path / "out", "-q", "--frames", "0..3")
    times = {path: path.stat().st_mtime_ns for path in (tmp_path / "out").rglob("capture.json")}
    dataset = ps.Dataset(file, output=tmp_path / "out")
    assert len(list(dataset)) == 5
    assert all(path.stat().st_mtime_ns == time for path, time in times.items())
    assert dataset.write_index() == 10


def test_pictures_hold_what_the_capture_asks_for(file: Path) -> None:
    dataset = ps.Dataset(file)
    picture = dataset[0]["left"]
    assert picture.image.shape == (30, 40, 3) and picture.image.dtype == np.uint8
    assert picture.electrons.shape == picture.variance.shape == (30, 40, 3) and picture.channels == ("R", "G", "B")
    assert set(picture.truth) == {"depth", "normal", "instance"} and picture.truth.units["depth"] == "m"
    assert picture.truth["depth"].shape == (30, 40) and picture.truth["normal"].shape == (30, 40, 3)
    assert set(picture.noise) == {"prnu_e"} and picture.noise.units == {"prnu_e": "e-"}
    camera = picture.camera
    assert camera.K.shape == (3, 3) and np.allclose(camera.R @ camera.R.T, np.eye(3))
    # The board lies where its points are stated to be: a second way to depth.
    [board] = picture.report["targets"]
    world = np.array(board["points_world_m"])
    inside = world @ camera.R.T + camera.t
    for point, pixel, visible in zip(inside, board["points_px"], board["points_visible"]):
        if visible:
            column, row = (round(x) for x in pixel)
            assert picture.truth["depth"][row, column] == pytest.approx(point[2], abs=0.02)


def test_npy_files_of_truth_are_read_likewise(file: Path) -> None:
    exr = ps.Dataset(file)[1]["right"]
    npy = ps.Dataset(file, set={"output.truth_formats": ["npy"], "output.noise_formats": ["npy"]})[1]["right"]
    assert not any(path.name == "truth.exr" for path in npy.files)
    for name in exr.truth:
        assert np.array_equal(npy.truth[name], exr.truth[name], equal_nan=True), name
    assert np.array_equal(npy.noise["prnu_e"], exr.noise["prnu_e"])
    png = ps.Dataset(file, set={"output.truth_formats": ["png"]})[1]["right"]
    with pytest.raises(ps.InputError, match="no truth.exr"):
        png.truth
    less = ps.Dataset(file, set={"output.electrons": False, "output.truth": []})[1]["right"]
    with pytest.raises(ps.InputError, match="no electrons.exr") as caught:
        less.electrons
    assert caught.value.help and "output.electrons" in caught.value.help
    assert len(less.truth) == 0


def test_slices_and_negative_numbers(file: Path) -> None:
    dataset = ps.Dataset(file)
    assert dataset[-1].number == 4 and dataset[1:4].numbers == (1, 2, 3) and dataset[::-2].numbers == (4, 2, 0)
    assert dataset[1:4][-1].number == 3 and dataset.select([3, 0])[0].number == 3
    assert [frame.number for frame in dataset[3:]] == [3, 4]
    for wrong in (5, -6):
        with pytest.raises(IndexError):
            dataset[wrong]
    with pytest.raises(TypeError):
        dataset["left"]  # type: ignore[call-overload]
    with pytest.raises(KeyError):
        dataset[0]["middle"]


def test_temporary_folders_go_with_the_data_set(file: Path) -> None:
    dataset = ps.Dataset(file)
    part, folder = dataset[:1], dataset.folder
    frame = part[0]
    del dataset
    gc.collect()
    assert folder.exists()
    del part
    gc.collect()
    assert frame["left"].image.shape == (30, 40, 3)
    del frame
    gc.collect()
    assert not folder.exists()


def test_data_sets_and_frames_can_be_pickled(file: Path) -> None:
    dataset = ps.Dataset(file, set={"render.samples_per_pixel": 1})
    frame = dataset[1:][0]
    again = pickle.loads(pickle.dumps(dataset[1:]))
    assert again.numbers == (1, 2, 3, 4) and again.folder == dataset.folder
    assert np.array_equal(np.asarray(again[0]["left"].raw), np.asarray(frame["left"].raw))
    assert pickle.loads(pickle.dumps(frame))["left"].raw == frame["left"].raw
    del again
    gc.collect()
    assert dataset.folder.exists()


def work(dataset: ps.Dataset, start: int, results: "multiprocessing.Queue[int]") -> None:
    results.put(len([dataset[(start + i) % len(dataset)] for i in range(len(dataset))]))


@pytest.mark.parametrize("method", ["fork", "spawn"])
def test_processes_fill_a_folder_together(command: Command, file: Path, tmp_path: Path, method: str) -> None:
    dataset = ps.Dataset(file, output=tmp_path / "ours", threads=1)
    dataset[0]  # threads of this process are there when it forks
    context: Any = multiprocessing.get_context(method)
    results = context.Queue()
    workers = [context.Process(target=work, args=(dataset, start, results)) for start in (0, 3)]
    for worker in workers:
        worker.start()
    assert [results.get(timeout=120) for _ in workers] == [5, 5]
    for worker in workers:
        worker.join(60)
        assert worker.exitcode == 0
    dataset.write_index()
    command("dataset", file, "-o", tmp_path / "theirs", "-q")
    assert contents(tmp_path / "ours") == contents(tmp_path / "theirs")


def test_progress_is_told_and_may_stop_it(file: Path, tmp_path: Path) -> None:
    told: "list[tuple[int, int]]" = []
    dataset = ps.Dataset(file, output=tmp_path / "out", set={"render.samples_per_pixel": 256})

    def watch(done: int, all: int) -> None:
        told.append((done, all))
        if done >= 2:
            raise RuntimeError("enough")

    with pytest.raises(RuntimeError, match="enough"):
        dataset.render(progress=watch)
    assert told[0][1] == 10
    done = len(list((tmp_path / "out").rglob("capture.json")))
    assert 2 <= done < 10
    assert dataset.render(progress=False) == 10 - done


@pytest.mark.skipif(os.name == "nt", reason="sends SIGINT")
def test_control_c_leaves_what_is_done(file: Path, tmp_path: Path) -> None:
    keys = {"render.samples_per_pixel": 20_000, "sensor.resolution_px": [80, 60]}
    program = f"""
import photosite as ps
dataset = ps.Dataset({str(file)!r}, output={str(tmp_path / "out")!r}, set={keys!r})
print("ready", flush=True)
try:
    dataset.render(progress=False)
except KeyboardInterrupt:
    print("stopped", flush=True)
"""
    process = subprocess.Popen([sys.executable, "-c", program], stdout=subprocess.PIPE, text=True)
    assert process.stdout is not None and process.stdout.readline() == "ready\n"
    time.sleep(1.0)
    process.send_signal(signal.SIGINT)
    begun = time.monotonic()
    assert process.stdout.readline() == "stopped\n"
    assert time.monotonic() - begun < 5.0
    process.wait(30)


def test_threads_share_a_data_set(file: Path, tmp_path: Path) -> None:
    dataset = ps.Dataset(file, output=tmp_path / "out")
    failed: "list[BaseException]" = []

    def run() -> None:
        try:
            assert len(list(dataset)) == 5
        except BaseException as error:  # noqa: BLE001
            failed.append(error)

    threads = [threading.Thread(target=run) for _ in range(2)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert not failed


@pytest.mark.parametrize(
    ("text", "complaint"),
    [
        ("", "capture"),
        ("capture = 'none.toml'\nframes = 1", "none.toml"),
        ("capture = 'board.toml'\nframe = 1", "unknown key"),
        ("capture = 'board.toml'\nframes = -1", "frames"),
        ("not toml", "set.toml"),
    ],
)
def test_files_that_are_no_data_sets(file: Path, text: str, complaint: str) -> None:
    file.write_text(text)
    with pytest.raises(ps.Error, match=complaint):
        ps.Dataset(file)


def test_what_cannot_be_used(file: Path, tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError):
        ps.Dataset(tmp_path / "missing.toml")
    with pytest.raises(ps.InputError, match="sample_per_pixel"):
        ps.Dataset(file, set={"render.sample_per_pixel": 1})[0]
    with pytest.raises(ps.InputError, match="threads"):
        ps.Dataset(file, threads=0)
    (tmp_path / "full").mkdir()
    (tmp_path / "full/other.txt").write_text("")
    with pytest.raises(ps.InputError, match="is not empty"):
        ps.Dataset(file, output=tmp_path / "full")[0]
    ps.Dataset(file, output=tmp_path / "out")[0]
    with pytest.raises(ps.InputError, match="another data set"):
        ps.Dataset(file, output=tmp_path / "out", set={"render.samples_per_pixel": 3})[0]
    broken = ps.Dataset(file, output=tmp_path / "out")[0]
    (broken["left"].folder / "electrons.exr").write_bytes(b"broken")
    with pytest.raises(ps.InputError, match="electrons.exr"):
        broken["left"].electrons
    again = ps.Dataset(file, output=tmp_path / "out")
    with pytest.warns(ps.PhotositeWarning, match="made again"):
        assert again[0]["left"].electrons.shape == (30, 40, 3)


def test_listed_frames_are_opened_without_the_file(file: Path, tmp_path: Path) -> None:
    dataset = ps.Dataset(file, output=tmp_path / "out")
    dataset.render(progress=False)
    other = pickle.loads(pickle.dumps(dataset))
    kept = file.read_text()
    file.unlink()
    for _ in range(2):
        assert [frame.number for frame in other] == [0, 1, 2, 3, 4], "nothing is planned, nothing is read"
    begun = time.process_time()
    for _ in range(20):
        assert other[3]["right"].raw.shape == (30, 40)
    # The file of a raw image is read within a few ms.
    assert (time.process_time() - begun) / 20 < 0.01
    # What is damaged is made again, and so is what another data set has listed.
    file.write_text(kept)
    raw = tmp_path / "out/left/000002/raw.dng"
    whole = raw.read_bytes()
    raw.write_bytes(whole[:-1])
    assert np.asarray(other[2]["left"].raw).shape == (30, 40) and raw.read_bytes() == whole
    changed = ps.Dataset(file, output=tmp_path / "out", set={"render.seed": 99})
    with pytest.raises(ps.InputError, match="another|other|differ"):
        changed[0]


def test_layers_go_to_another_process(file: Path) -> None:
    truth = ps.Dataset(file)[0]["left"].truth
    again = pickle.loads(pickle.dumps(truth))
    assert dict(again.units) == dict(truth.units)
    assert all(np.array_equal(again[name], truth[name], equal_nan=True) for name in truth)
