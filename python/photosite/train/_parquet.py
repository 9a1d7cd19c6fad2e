"""Parquet files of Hugging Face ``datasets``: a row for each image, with images as PNG. The file's key ``huggingface`` says
which columns are images."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any, Optional

import numpy as np
import numpy.typing as npt

from ._samples import Sample, grey_png
from ._shards import left_out, package

#: A group of rows ends when it has so many bytes.
_GROUP_BYTES = 100 << 20
#: The largest value of 16 bits.
_LARGEST = 65_535

#: The columns in their order: what ``datasets`` makes of them.
_COLUMNS = {
    "camera": "string",
    "frame": "int32",
    "time_s": "float64",
    "stamp_ns": "int64",
    "seed": "uint64",
    "image": "Image",
    "raw": "Image",
    "colour_filter_array": "string",
    "depth": "Image",
    "depth_unit_m": "float64",
    "instance": "Image",
    "projection": "string",
    "camera_matrix": "Sequence",
    "distortion": "Sequence",
    "rotation": "Sequence",
    "translation_m": "Sequence",
    "capture": "string",
}


class Parquet:
    """``part-000000.parquet`` …"""

    name = "parquet"
    affixes = ("part-", ".parquet")

    def check(self, cameras: "Sequence[str]") -> None:
        """Takes all cameras, and needs pyarrow."""
        package("pyarrow.parquet")

    def write(self, path: Path, samples: "Sequence[Sample]") -> None:
        """Writes a file."""
        pyarrow, parquet = package("pyarrow"), package("pyarrow.parquet")
        schema = _schema(pyarrow)
        with parquet.ParquetWriter(path, schema, compression="none", use_dictionary=False, write_statistics=False) as file:
            rows: "list[dict[str, Any]]" = []
            size = 0
            for sample in samples:
                rows.append(_row(sample))
                size += sum(len(cell["bytes"]) for cell in rows[-1].values() if isinstance(cell, dict))
                if size >= _GROUP_BYTES:
                    file.write_table(pyarrow.Table.from_pylist(rows, schema))
                    rows, size = [], 0
            if rows:
                file.write_table(pyarrow.Table.from_pylist(rows, schema))

    def finish(self, folder: Path, shards: "Sequence[Path]") -> None:
        """Writes nothing: a folder of Parquet files is a data set of its own."""


def _schema(pyarrow: Any) -> Any:
    image = pyarrow.struct([("bytes", pyarrow.binary()), ("path", pyarrow.string())])
    types: "dict[str, Any]" = {"Image": image, "Sequence": pyarrow.list_(pyarrow.float64())}
    fields = [(name, types.get(kind) or pyarrow.type_for_alias(kind)) for name, kind in _COLUMNS.items()]
    features: "dict[str, Any]" = {name: {"dtype": kind, "_type": "Value"} for name, kind in _COLUMNS.items()}
    for name, kind in _COLUMNS.items():
        if kind == "Image":
            features[name] = {"_type": "Image"}
        elif kind == "Sequence":
            features[name] = {"feature": {"dtype": "float64", "_type": "Value"}, "_type": "Sequence"}
    return pyarrow.schema(fields, metadata={"huggingface": json.dumps({"info": {"features": features}})})


def _row(sample: Sample) -> "dict[str, Any]":
    facts, raw, truth = sample.facts, sample.raw, dict(sample.truth)
    row = {name: facts[name] for name in ("camera", "frame", "time_s", "stamp_ns", "seed", "projection")}
    row.update({name: facts[name] for name in ("distortion", "translation_m")})
    row.update({name: np.ravel(facts[name]).tolist() for name in ("camera_matrix", "rotation")})
    row["capture"] = sample.report.decode()
    row["image"] = _image(sample.image)
    row["raw"] = row["colour_filter_array"] = None
    if raw is not None and raw.ndim == 2:
        row["raw"], row["colour_filter_array"] = _image(grey_png(raw.active)), raw.active_cfa
    elif raw is not None:
        left_out("Parquet files hold raw images of one value per pixel, and are without those of all channels at every pixel")
    depth, unit = _depth(truth.pop("depth", None))
    row["depth"], row["depth_unit_m"] = _image(depth), unit
    instance: "Optional[npt.NDArray[Any]]" = truth.pop("instance", None)
    if instance is not None and instance.max(initial=0) > _LARGEST:
        left_out(f"Parquet files hold instances up to {_LARGEST}, and are without those of images that have more")
        instance = None
    row["instance"] = _image(None if instance is None else grey_png(instance.astype(np.uint16)))
    if truth:
        left_out(f"Parquet files hold depth and instance, and are without {', '.join(truth)}, which webdataset holds")
    return row


def _image(png: Optional[bytes]) -> "Optional[dict[str, Any]]":
    return None if png is None else {"bytes": png, "path": None}


def _depth(depth: "Optional[npt.NDArray[np.float32]]") -> "tuple[Optional[bytes], Optional[float]]":
    """Depth in whole steps, of which 0 is nothing, and the step, m: 0.1 mm or the smallest power of ten times that which
    16 bits can hold."""
    if depth is None:
        return None, None
    is_there = np.isfinite(depth)
    largest = float(depth[is_there].max(initial=0))
    power = 0
    while round(largest / _step_m(power)) > _LARGEST:
        power += 1
    step_m = _step_m(power)
    steps = np.rint(np.where(is_there, depth, 0).astype(np.float64) / step_m)
    # What is there is never nothing.
    return grey_png(np.where(is_there, np.maximum(steps, 1), 0).astype(np.uint16)), step_m


def _step_m(power: int) -> float:
    """10^power times 0.1 mm, as the number that is written so."""
    return 10.0**power / 10_000
