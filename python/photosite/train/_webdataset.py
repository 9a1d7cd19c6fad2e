"""Tar files of WebDataset: a sample is several members one after the other, with one name up to the first dot."""

from __future__ import annotations

import io
import json
import tarfile
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from ._samples import Sample


class WebDataset:
    """``shard-000000.tar`` … and ``index.json``."""

    name = "webdataset"
    affixes = ("shard-", ".tar")

    def check(self, cameras: "Sequence[str]") -> None:
        """Takes all cameras, and needs no package: tar files are Python's own."""

    def write(self, path: Path, samples: "Sequence[Sample]") -> None:
        """Writes a tar file."""
        with tarfile.open(path, "w", format=tarfile.USTAR_FORMAT) as tar:
            for sample in samples:
                for field, content in _members(sample):
                    # Neither a time nor an owner, so that a shard has the same bytes whoever writes it.
                    member = tarfile.TarInfo(f"{sample.camera}-{sample.frame:06}.{field}")
                    member.size = len(content)
                    tar.addfile(member, io.BytesIO(content))

    def finish(self, folder: Path, shards: "Sequence[Path]") -> None:
        """Writes ``index.json`` in the form of WebDataset's module ``wids``."""
        entries: "list[dict[str, Any]]" = []
        for path in shards:
            with tarfile.open(path) as tar:
                keys = {name.split(".")[0] for name in tar.getnames()}
            entries.append({"url": path.name, "nsamples": len(keys), "filesize": path.stat().st_size})
        index = {"__kind__": "wids-shard-index-v1", "wids_version": 1, "shardlist": entries}
        (folder / "index.json").write_text(json.dumps(index, indent=2) + "\n", encoding="utf-8")


def _members(sample: Sample) -> "Iterator[tuple[str, bytes]]":
    if sample.image is not None:
        yield "png", sample.image
    facts = {key: value for key, value in sample.facts.items() if key not in ("in_world", "ros")}
    raw = sample.raw
    if raw is not None:
        yield "raw.npy", _npy(raw.active)
        facts["raw"] = {
            "colour_filter_array": raw.active_cfa,
            "bits": raw.bits,
            "white_level_dn": raw.white_level_dn,
            "linearisation_dn": None if raw.linearisation is None else raw.linearisation.tolist(),
        }
    for name, layer in sample.truth.items():
        # A field ends at the next dot.
        yield f"{name.replace('.', '-')}.npy", _npy(layer)
    yield "camera.json", json.dumps(facts).encode()
    yield "json", sample.report


def _npy(array: "npt.NDArray[Any]") -> bytes:
    file = io.BytesIO()
    np.save(file, np.ascontiguousarray(array))
    return file.getvalue()
