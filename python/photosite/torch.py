"""Data sets for PyTorch, which is imported with this module: ``import photosite.torch``."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from typing import Any, Optional

import numpy as np
import torch.distributed
import torch.utils.data
from torch.utils.dlpack import from_dlpack

from ._dataset import Dataset, Frame

__all__ = ["FrameDataset", "FrameIterableDataset", "tensors"]

#: Layers of ground truth that number things.
_NUMBERS = ("instance", "material")

#: Makes a sample of a frame.
Transform = Callable[[Frame], Any]


def tensors(frame: Frame) -> "dict[str, Any]":
    """A frame as tensors, for each camera a dictionary.

    Returns:
        ``{"frame": 7, "left": {"raw": …, "image": …, "depth": …}}``: ``raw`` (H, W) int32, for which PyTorch has more
        operators than for uint16; ``image`` (H, W, 3) uint8; ``electrons`` and ``variance`` (H, W, C) float32, in e⁻
        and (e⁻)², where the data set has them; the layers of ground truth by their names, float32, ``instance`` and
        ``material`` int32; ``K``, ``R``,
        ``t`` and ``distortion`` float64.
    """
    sample: "dict[str, Any]" = {"frame": frame.number}
    for name, picture in frame.items():
        arrays: "dict[str, Any]" = {"raw": np.array(picture.raw, np.int32)}
        if any(file.name == "image.png" for file in picture.files):
            arrays["image"] = picture.image
        if any(file.name == "electrons.exr" for file in picture.files):
            arrays.update(electrons=picture.electrons, variance=picture.variance)
        truth = picture.truth
        arrays.update({name: truth[name].astype(np.int32) if name in _NUMBERS else truth[name] for name in truth})
        camera = picture.camera
        arrays.update(K=camera.K, R=camera.R, t=camera.t, distortion=camera.distortion)
        sample[name] = {key: from_dlpack(array) for key, array in arrays.items()}
    return sample


class FrameDataset(torch.utils.data.Dataset[Any]):
    """The frames of a data set in any order, for a sampler: each is rendered when it is first asked for.

    With a ``DistributedSampler`` ranks get different frames; with a shuffling sampler, too, no frame is rendered twice,
    as all processes fill one folder.

    Args:
        dataset: the data set. Give it an ``output`` that all processes reach.
        transform: makes a sample of a frame.
    """

    def __init__(self, dataset: Dataset, *, transform: Transform = tensors) -> None:
        self.dataset, self.transform = dataset, transform

    def __len__(self) -> int:
        return len(self.dataset)

    def __getitem__(self, index: int) -> Any:
        return self.transform(self.dataset[index])


class FrameIterableDataset(torch.utils.data.IterableDataset[Any]):
    """The frames of a data set in their order, shared by the workers of a ``DataLoader`` and the ranks of a distributed
    run: each gets every n-th frame, and none is seen twice.

    Args:
        dataset: the data set. Give it an ``output`` that all processes reach.
        transform: makes a sample of a frame.
        rank: number of this process among those that train; without, what ``torch.distributed`` says when iteration
            begins, or else the environment variable ``RANK`` of torchrun, or 0.
        world_size: how many processes train; without, likewise.
    """

    def __init__(
        self,
        dataset: Dataset,
        *,
        transform: Transform = tensors,
        rank: Optional[int] = None,
        world_size: Optional[int] = None,
    ) -> None:
        if (rank is None) != (world_size is None):
            raise ValueError("rank and world_size belong together: give both or neither")
        if rank is not None and world_size is not None and not 0 <= rank < world_size:
            raise ValueError(f"rank: expected a number from 0 to {world_size - 1}, got {rank}")
        self.dataset, self.transform = dataset, transform
        # Workers that are spawned know nothing of the process group of their parent.
        self.rank, self.world_size = _place() if rank is None or world_size is None else (rank, world_size)

    def __iter__(self) -> Iterator[Any]:
        info = torch.utils.data.get_worker_info()
        worker, workers = (0, 1) if info is None else (info.id, info.num_workers)
        for index in range(self.rank * workers + worker, len(self.dataset), self.world_size * workers):
            yield self.transform(self.dataset[index])


def _place() -> "tuple[int, int]":
    """The number of this process among those that train, and how many these are."""
    if torch.distributed.is_available() and torch.distributed.is_initialized():
        return torch.distributed.get_rank(), torch.distributed.get_world_size()
    return int(os.environ.get("RANK", "0")), int(os.environ.get("WORLD_SIZE", "1"))
