"""Data sets in the files that training programs read: WebDataset, Hugging Face ``datasets``, MCAP of ROS 2.

Each file, a *shard*, holds the images of a fixed range of frames. ``pip install "photosite[train]"`` brings the packages
that write them; ``python -m photosite.train webdataset SET -o SHARDS`` does the same as the functions here.

>>> from photosite import train
>>> train.webdataset("stereo", "shards", shard_frames=100)  # doctest: +SKIP
12
"""

from __future__ import annotations

from typing import Optional

from .._arguments import Path
from ._mcap import Mcap
from ._parquet import Parquet
from ._shards import write_shards
from ._webdataset import WebDataset

__all__ = ["mcap", "parquet", "webdataset"]


def webdataset(dataset: Path, output: Path, /, *, shard_mb: Optional[int] = None, shard_frames: Optional[int] = None) -> int:
    """Writes ``shard-000000.tar`` … for `WebDataset <https://github.com/webdataset/webdataset>`_, and ``index.json`` in the
    form of its module ``wids``.

    A sample is an image: ``CAMERA-000007.png``, ``.raw.npy`` (uint16, without masked borders), ``.depth.npy`` and the
    other layers of ground truth (float32; ``instance`` and ``material`` uint32), ``.camera.json`` with pose and camera
    matrix in OpenCV's conventions, ``.json`` with ``capture.json``.

    Args:
        dataset: a folder that ``photosite dataset`` has filled to the end.
        output: a new folder, or one with some of these shards, of which the missing ones are written.
        shard_mb: bytes of a shard, MiB; the number of frames follows from the first one, with a tenth left free.
            Without, 256.
        shard_frames: frames of a shard, however large they are.

    Returns:
        How many shards were written.

    Raises:
        InputError: a data set that is not whole, or whose images show things in other places than ground truth has
            them; a folder of another data set or of another size.
        FileError: a file cannot be read or written.
    """
    return write_shards(WebDataset(), dataset, output, shard_mb, shard_frames)


def parquet(dataset: Path, output: Path, /, *, shard_mb: Optional[int] = None, shard_frames: Optional[int] = None) -> int:
    """Writes ``part-000000.parquet`` … for Hugging Face ``datasets``, with a row for each image.

    ``image``, ``raw``, ``depth`` and ``instance`` are features of the kind Image; the last three are 16-bit PNG. Depth is
    in steps of ``depth_unit_m``, 0 where nothing is. What the format has no place for is left out with a warning.

    Args:
        dataset, output, shard_mb, shard_frames: as of :func:`webdataset`.

    Returns:
        How many shards were written.

    Raises:
        Error: pyarrow is not installed.
        InputError, FileError: as of :func:`webdataset`.
    """
    return write_shards(Parquet(), dataset, output, shard_mb, shard_frames)


def mcap(dataset: Path, output: Path, /, *, shard_mb: Optional[int] = None, shard_frames: Optional[int] = None) -> int:
    """Writes ``part-000000.mcap`` … with messages of ROS 2, for ``ros2 bag``, Foxglove and Rerun.

    Topics are ``/CAMERA/camera_info``, ``/CAMERA/image_raw``, ``/CAMERA/image/compressed``, ``/CAMERA/truth/LAYER``,
    ``/tf`` (``CAMERA_optical`` in ``world``, whose y points up) and ``/tf_static`` (``world`` in ``map``, whose z does).
    What ROS has no name for is left out with a warning.

    Args:
        dataset, output, shard_mb, shard_frames: as of :func:`webdataset`.

    Returns:
        How many shards were written.

    Raises:
        Error: mcap or rosbags is not installed.
        InputError, FileError: as of :func:`webdataset`; cameras whose topics would be the same.
    """
    return write_shards(Mcap(), dataset, output, shard_mb, shard_frames)
