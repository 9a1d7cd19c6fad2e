"""A place in an object store, as fsspec names it: `s3://bucket/set`, `gs://…`, `file://…`.

Stores know neither locks nor names that change. A worker renders a frame into a folder of its own and uploads it whole,
the reports of its pictures last, so that a picture is there when its report is. Two workers that make the same frame
upload the same bytes.
"""

from __future__ import annotations

import json
import os
import posixpath
import tempfile
from functools import partial
from pathlib import Path
from typing import Any, Callable, TypeVar

from .. import _photosite
from .._errors import Error, InputError, make
from .installed import needed
from .output import failures_of, fingerprint_in, told
from .task import Failure, Job, Task

__all__ = ["Store"]

_REPORT = "capture.json"
_IDENTITY = "dataset.json"
_MANIFEST = "manifest.jsonl"
_Result = TypeVar("_Result")


class Store:
    """A place for a data set in a store."""

    def __init__(self, url: str) -> None:
        self.url = url.rstrip("/")
        protocol = url.split("://", 1)[0]
        if protocol == "memory":
            reason = "no other process can see what is in the memory of this one"
            help = "give a folder, or a store such as s3://bucket/set"
            raise InputError(f"output: {reason}", file="<python>", key="output", reason=reason, help=help)
        fsspec = needed("fsspec", "fsspec", "output", url)
        try:
            # Stores have no folders; a disk that stands for one needs them.
            options = {"auto_mkdir": True} if protocol in ("file", "local") else {}
            self._files, self._root = fsspec.url_to_fs(self.url, **options)
        except (ImportError, ValueError) as refused:
            reason = f"{url!r} is not a store that fsspec can open here: {refused}"
            help = "install the package that it names, on all machines"
            raise InputError(f"output: {reason}", file="<python>", key="output", reason=reason, help=help) from None

    def claim(self, dataset: "_photosite.Dataset") -> str:
        with tempfile.TemporaryDirectory(prefix="photosite-") as folder:
            is_claimed = self._tried("read", lambda: self._files.exists(self._at(_IDENTITY)))
            if is_claimed:
                self._tried("read", lambda: self._files.get_file(self._at(_IDENTITY), os.path.join(folder, _IDENTITY)))
            elif self._listed(""):
                reason = "is not empty and does not contain a data set"
                help = "choose another place, as pictures of two data sets must not be mixed"
                raise InputError(f"{self.url} {reason}", file=self.url, reason=reason, help=help)
            self._claim_scratch(dataset, folder)
            if not is_claimed:
                self._upload(os.path.join(folder, _IDENTITY), _IDENTITY)
            return fingerprint_in(folder)

    def missing(self, dataset: "_photosite.Dataset", frames: "list[int]") -> "list[int]":
        present = {camera: self._reports(camera) for camera in dataset.cameras()}
        return [frame for frame in frames if not all(_name(frame) in names for names in present.values())]

    def make(self, dataset: "_photosite.Dataset", job: Job, task: Task) -> "tuple[list[Failure], list[str]]":
        failures: "list[Failure]" = []
        warnings: "list[str]" = []
        for frame in task.frames:
            # A worker that was given up may have made it.
            pictures = [f"{camera}/{_name(frame)}" for camera in dataset.cameras()]
            if all(self._has(f"{picture}/{_REPORT}") for picture in pictures):
                continue
            try:
                with tempfile.TemporaryDirectory(prefix="photosite-") as folder:
                    failed, warned = dataset.make(folder, [frame], job.threads)
                    self._check(fingerprint_in(folder), job)
                    self._upload_pictures(Path(folder), pictures)
            except Error as error:
                if not error.is_temporary:
                    raise
                failures.append(Failure(frame, str(error), True))
                continue
            failures += failures_of(failed)
            warnings += warned
        return failures, warnings

    def finish(self, dataset: "_photosite.Dataset") -> "list[str]":
        with tempfile.TemporaryDirectory(prefix="photosite-") as folder:
            reports = [
                f"{camera}/{picture}/{_REPORT}" for camera in dataset.cameras() for picture in self._reports(camera)
            ]
            # The manifest vouches for the reports that it knew.
            names = [_IDENTITY, *reports, *([_MANIFEST] if self._has(_MANIFEST) else [])]
            local = [os.path.join(folder, name) for name in names]
            for path in {os.path.dirname(path) for path in local}:
                os.makedirs(path, exist_ok=True)
            self._tried("read", lambda: self._files.get([self._at(name) for name in names], local))
            present, left_out, warnings = dataset.write_index_of_reports(folder)
            if present < len(reports):
                self._drop_damaged(folder, reports)
            known = {_IDENTITY, *reports}
            for file in sorted(Path(folder).rglob("*")):
                name = file.relative_to(folder).as_posix()
                if file.is_file() and name not in known and not file.name.startswith("."):
                    self._upload(str(file), name)
            return told(left_out, warnings)

    def _claim_scratch(self, dataset: "_photosite.Dataset", folder: str) -> None:
        """Holds the identity in a folder against the data set's; messages name the store."""
        try:
            dataset.claim(folder)
        except InputError as error:
            kind, message, parts = error.__reduce__()[1]
            parts["reason"] = parts["reason"].replace(folder, self.url)
            raise make(kind, message.replace(folder, self.url), **parts) from None

    def _check(self, fingerprint: str, job: Job) -> None:
        """Refuses pictures of other files than the driver's. In a folder `dataset.json` says which these are."""
        if fingerprint != job.fingerprint:
            reason = f"{job.path}, or a file that it names, is not the same here as where the run was started"
            raise InputError(reason, file=job.path, reason=reason, help="give all machines the same files")

    def _upload_pictures(self, folder: Path, pictures: "list[str]") -> None:
        made = [folder / picture for picture in pictures if (folder / picture).exists()]
        files = [path for picture in made for path in sorted(picture.iterdir())]
        for path in sorted(files, key=lambda path: path.name == _REPORT):
            self._upload(str(path), path.relative_to(folder).as_posix())

    def _drop_damaged(self, folder: str, reports: "list[str]") -> None:
        """Takes away reports that were cut off where a store is none, as of file://."""
        for name in reports:
            try:
                json.loads(Path(folder, name).read_bytes())
            except ValueError:
                self._tried("remove from", partial(self._files.rm_file, self._at(name)))
        reason = "some reports are damaged, and were removed"
        help = "call run again, which makes their pictures"
        raise Error(f"{self.url}: {reason}", file=self.url, reason=reason, help=help, is_temporary=True)

    def _reports(self, camera: str) -> "list[str]":
        """Numbers of a camera's pictures that are there, as their folders are named."""
        paths = (path.rsplit("/", 2) for path in self._listed(camera))
        return sorted(parts[1] for parts in paths if len(parts) == 3 and parts[2] == _REPORT and parts[1].isdigit())

    def _listed(self, name: str) -> "list[str]":
        # Stores keep what they have listed.
        self._files.invalidate_cache()
        files: "list[str]" = self._tried("list", lambda: self._files.find(self._at(name)))
        return files

    def _has(self, name: str) -> bool:
        self._files.invalidate_cache()
        return bool(self._tried("read", lambda: self._files.exists(self._at(name))))

    def _upload(self, path: str, name: str) -> None:
        self._tried("write to", lambda: self._files.put_file(path, self._at(name)))

    def _at(self, name: str) -> str:
        return posixpath.join(self._root, name) if name else str(self._root)

    def _tried(self, what: str, do: "Callable[[], _Result]") -> Any:
        """Does something with the store; what it says of itself becomes an error that another try may cure, unless it
        is about who may do so."""
        try:
            return do()
        except Exception as refused:  # noqa: BLE001 - each store has its own
            is_final = isinstance(refused, (PermissionError, ImportError))
            reason = f"cannot {what} the store: {refused or type(refused).__name__}"
            help = "check that the bucket exists, and that all machines may read from and write to it"
            raise Error(f"{self.url}: {reason}", file=self.url, reason=reason, help=help, is_temporary=not is_final) from None


def _name(frame: int) -> str:
    return f"{frame:06}"
