"""Data sets for PyTorch, in real worker processes."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import photosite as ps
import pytest
from conftest import contents

torch = pytest.importorskip("torch")

import torch.utils.data  # noqa: E402

import photosite.torch as pt  # noqa: E402


def number(frame: ps.Frame) -> "tuple[int, int]":
    """A frame's number, and the process that has made its sample."""
    assert frame["left"].raw.shape == (30, 40)
    return frame.number, os.getpid()


def test_samples_are_tensors_of_the_arrays(file: Path) -> None:  # noqa: F811
    dataset = ps.Dataset(file)
    sample = pt.FrameDataset(dataset)[1]
    picture = dataset[1]["left"]
    assert sample["frame"] == 1 and set(sample) == {"frame", "left", "right"}
    left = sample["left"]
    assert left["raw"].dtype == torch.int32 and np.array_equal(left["raw"].numpy(), np.asarray(picture.raw))
    assert left["image"].dtype == torch.uint8 and np.array_equal(left["image"].numpy(), picture.image)
    assert left["depth"].dtype == torch.float32 and np.array_equal(left["depth"].numpy(), picture.truth["depth"])
    assert np.array_equal(left["K"].numpy(), picture.camera.K)
    left["raw"][0, 0] += 1
    assert left["raw"][0, 0] == picture.raw[0, 0] + 1, "it is the sample's own"


def test_raw_images_become_tensors(file: Path) -> None:  # noqa: F811
    raw = ps.Dataset(file)[0]["left"].raw
    shared = torch.from_dlpack(raw)
    assert shared.dtype == torch.uint16 and np.array_equal(shared.numpy(), np.asarray(raw))


@pytest.mark.parametrize("method", ["fork", "spawn"])
@pytest.mark.parametrize("kind", [pt.FrameDataset, pt.FrameIterableDataset])
def test_two_workers_see_each_frame_once(file: Path, tmp_path: Path, method: str, kind: type) -> None:  # noqa: F811
    dataset = ps.Dataset(file, output=tmp_path / "ours", threads=1)
    dataset[0]  # threads of this process are there when it forks
    frames = kind(dataset, transform=number)
    loader = torch.utils.data.DataLoader(
        frames, batch_size=None, num_workers=2, multiprocessing_context=method, timeout=120
    )
    for _ in range(2):
        seen = list(loader)
        assert sorted(int(n) for n, _ in seen) == [0, 1, 2, 3, 4]
        workers = {int(process) for _, process in seen}
        assert len(workers) == 2 and os.getpid() not in workers
    alone = ps.Dataset(file, output=tmp_path / "alone")
    alone.render(progress=False)
    dataset.write_index()
    assert contents(tmp_path / "ours") == contents(tmp_path / "alone")


def test_ranks_and_workers_share_the_frames(file: Path, tmp_path: Path) -> None:  # noqa: F811
    dataset = ps.Dataset(file, output=tmp_path / "out")
    seen: "list[int]" = []
    for rank in range(2):
        frames = pt.FrameIterableDataset(dataset, transform=number, rank=rank, world_size=2)
        loader = torch.utils.data.DataLoader(frames, batch_size=None, num_workers=2, multiprocessing_context="fork")
        seen += [int(n) for n, _ in loader]
    assert sorted(seen) == [0, 1, 2, 3, 4]


def test_a_process_group_says_the_rank(file: Path, tmp_path: Path) -> None:  # noqa: F811
    program = f"""
import sys
import photosite as ps, photosite.torch as pt, torch.distributed as dist
rank = int(sys.argv[1])
dist.init_process_group("gloo", init_method="file://{tmp_path / "meeting"}", rank=rank, world_size=2)
frames = pt.FrameIterableDataset(ps.Dataset({str(file)!r}, output={str(tmp_path / "out")!r}, threads=1))
print(*[sample["frame"] for sample in frames])
dist.destroy_process_group()
"""
    ranks = [
        subprocess.Popen([sys.executable, "-c", program, str(rank)], stdout=subprocess.PIPE, text=True)
        for rank in range(2)
    ]
    said = [rank.communicate(timeout=120)[0].split() for rank in ranks]
    assert said == [["0", "2", "4"], ["1", "3"]]


def test_torchrun_says_the_rank(file: Path, monkeypatch: pytest.MonkeyPatch) -> None:  # noqa: F811
    monkeypatch.setenv("RANK", "1")
    monkeypatch.setenv("WORLD_SIZE", "3")
    frames = pt.FrameIterableDataset(ps.Dataset(file), transform=number)
    assert [n for n, _ in frames] == [1, 4]


def test_samplers_take_frames_in_any_order(file: Path) -> None:  # noqa: F811
    frames = pt.FrameDataset(ps.Dataset(file), transform=number)
    loader = torch.utils.data.DataLoader(frames, batch_size=None, shuffle=True)
    assert len(frames) == 5 and sorted(int(n) for n, _ in loader) == [0, 1, 2, 3, 4]


def test_ranks_that_there_are_not(file: Path) -> None:  # noqa: F811
    dataset = ps.Dataset(file)
    for options in ({"rank": 0}, {"world_size": 2}, {"rank": 2, "world_size": 2}, {"rank": -1, "world_size": 2}):
        with pytest.raises(ValueError):
            pt.FrameIterableDataset(dataset, **options)  # type: ignore[arg-type]
