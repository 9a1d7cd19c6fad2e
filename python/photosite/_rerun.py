"""Recordings of data sets for the Rerun viewer."""

from __future__ import annotations

import importlib
import json
import os
import tempfile
import warnings
from collections.abc import Iterator
from pathlib import Path as FilePath
from typing import Any, Optional, Union

import numpy as np

from ._arguments import Path, invalid, path_of
from ._camera import Camera
from ._dataset import Dataset, Frame, FramePicture
from ._errors import Error, FileError, InputError, PhotositeWarning

__all__ = ["to_rerun"]

#: What a lens may bend the image without a warning, px.
_NEGLIGIBLE_PX = 0.5


def to_rerun(dataset: Union[Dataset, Path], path: Path, /) -> None:
    """Writes a data set as a recording (``.rrd``) for the Rerun viewer; needs ``pip install rerun-sdk``.

    Poses are at ``world/CAMERA``, with the pinhole, the developed image, depth, and numbers of instances and materials
    at ``world/CAMERA/image`` and below it; raw numbers at ``raw/CAMERA``. The timelines are ``frame`` and, along a
    trajectory, ``time``. Other layers of truth are left out. Recordings hold the time of their writing: two of one data
    set differ in their bytes.

    Args:
        dataset: a data set, whose missing frames are rendered, or the folder that the command has filled.
        path: the file to write; an older one is replaced when the new one is complete.

    Raises:
        Error: rerun-sdk is not installed.
        InputError: the folder does not contain a data set.
        FileError: a file cannot be read or written.
    """
    rerun = _rerun()
    target = FilePath(path_of("path", path))
    if target.suffix != ".rrd":
        raise invalid("path", f"expected the name of an .rrd file, got {target.name!r}")
    folder, frames = _frames(dataset)
    times = _times(folder)
    try:
        handle, name = tempfile.mkstemp(prefix=f".{target.name}.", suffix=".partial", dir=target.parent)
    except OSError as reason:
        raise FileError(f"{target}: cannot write: {reason}", file=target, reason=str(reason)) from reason
    os.close(handle)
    try:
        recording = rerun.RecordingStream("photosite")
        recording.save(name)
        recording.log("world", rerun.ViewCoordinates.RIGHT_HAND_Y_UP, static=True)
        warned: "set[str]" = set()
        for frame in frames:
            for camera, picture in frame.items():
                recording.set_time("frame", sequence=frame.number)
                if (time_s := times.get((camera, frame.number))) is not None:
                    recording.set_time("time", duration=time_s)
                _log(rerun, recording, camera, picture)
                if camera not in warned and (bent := _bent(picture.camera)):
                    warned.add(camera)
                    warnings.warn(f"Rerun knows only pinholes: {bent} of {camera}", PhotositeWarning, stacklevel=2)
        recording.flush()
        recording.disconnect()
        # Temporary files are private.
        os.chmod(name, 0o644)
        os.replace(name, target)
    except BaseException:
        if os.path.exists(name):
            os.remove(name)
        raise


def _rerun() -> Any:
    try:
        return importlib.import_module("rerun")
    except ImportError as reason:
        message = "recordings for Rerun need its package, which is not installed"
        raise Error(message, help="pip install rerun-sdk") from reason


def _frames(dataset: Union[Dataset, Path]) -> "tuple[FilePath, Iterator[Frame]]":
    if isinstance(dataset, Dataset):
        dataset.render(progress=False)
        # It has the frames' times.
        dataset.write_index()
        return dataset.folder, iter(dataset)
    folder = FilePath(path_of("dataset", dataset))
    if not (folder / "manifest.jsonl").is_file():
        reason = "holds no manifest.jsonl"
        help = "give the folder that photosite dataset has made, or a photosite.Dataset"
        raise InputError(f"{folder}: {reason}", file=folder, reason=reason, help=help)
    pictures: "dict[int, list[str]]" = {}
    for line in _manifest(folder):
        pictures.setdefault(line["frame"], []).append(line["camera"])
    return folder, (Frame(folder, tuple(cameras), number) for number, cameras in sorted(pictures.items()))


def _manifest(folder: FilePath) -> "list[dict[str, Any]]":
    path = folder / "manifest.jsonl"
    return [json.loads(line) for line in path.read_text().splitlines()] if path.is_file() else []


def _times(folder: FilePath) -> "dict[tuple[str, int], Optional[float]]":
    return {(line["camera"], line["frame"]): line["time_s"] for line in _manifest(folder)}


def _log(rerun: Any, recording: Any, name: str, picture: FramePicture) -> None:
    camera, files = picture.camera, {file.name for file in picture.files}
    at = f"world/{name}"
    recording.log(at, rerun.Transform3D(translation=-camera.R.T @ camera.t, mat3x3=camera.R.T))
    pinhole = rerun.Pinhole(
        image_from_camera=camera.K, resolution=camera.resolution_px, camera_xyz=rerun.ViewCoordinates.RDF
    )
    recording.log(f"{at}/image", pinhole)
    if "image.png" in files:
        codes = picture.image
        if codes.dtype == np.uint8:
            contents = (picture.folder / "image.png").read_bytes()
            recording.log(f"{at}/image", rerun.EncodedImage(contents=contents, media_type="image/png"))
        else:
            recording.log(f"{at}/image", rerun.Image(codes, color_model="RGB" if codes.ndim == 3 else "L"))
    truth = picture.truth if any(file.startswith("truth") for file in files) else {}
    if "depth" in truth:
        recording.log(f"{at}/image/depth", rerun.DepthImage(truth["depth"], meter=1.0))
    for layer in ("instance", "material"):
        if layer in truth:
            numbers = truth[layer]
            kind = np.uint16 if numbers.max() <= np.iinfo(np.uint16).max else np.uint32
            recording.log(f"{at}/image/{layer}", rerun.SegmentationImage(numbers.astype(kind)))
    if any(file.startswith("raw") for file in files):
        numbers = np.asarray(picture.raw)
        if numbers.ndim == 2:
            recording.log(f"raw/{name}", rerun.Image(numbers, color_model="L"))


def _bent(camera: Camera) -> Optional[str]:
    """What is not that of a pinhole, if there is something that can be seen."""
    if camera.projection == "perspective":
        return None
    if camera.projection != "brown-conrady":
        return f"the image does not follow the {camera.projection} lens"
    coefficients = np.zeros(12)
    coefficients[: len(camera.distortion)] = camera.distortion
    k1, k2, p1, p2, k3, k4, k5, k6, s1, s2, s3, s4 = coefficients
    columns, rows = camera.resolution_px
    # Lines through the border and the middle.
    u, v = np.meshgrid(np.linspace(-0.5, columns - 0.5, 33), np.linspace(-0.5, rows - 0.5, 33))
    x, y = (u - camera.K[0, 2]) / camera.K[0, 0], (v - camera.K[1, 2]) / camera.K[1, 1]
    r2 = x * x + y * y
    radial = (1 + r2 * (k1 + r2 * (k2 + r2 * k3))) / (1 + r2 * (k4 + r2 * (k5 + r2 * k6)))
    across = x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x) + s1 * r2 + s2 * r2 * r2 - x
    down = y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y + s3 * r2 + s4 * r2 * r2 - y
    px = float(np.hypot(across * camera.K[0, 0], down * camera.K[1, 1]).max())
    return f"the image does not follow the distortion, which is up to {px:.1f} px," if px > _NEGLIGIBLE_PX else None
