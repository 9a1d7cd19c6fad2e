"""Data sets: a capture again and again, from other poses, under other conditions."""

from __future__ import annotations

import json
import os
import shutil
import tempfile
import weakref
from collections.abc import Iterable, Iterator, Mapping, Sequence
from functools import cached_property
from pathlib import Path as FilePath
from typing import Any, Optional, Union, cast, overload

import numpy as np
import numpy.typing as npt

from . import _photosite
from ._arguments import Path, assignments, invalid, path_of
from ._camera import Camera
from ._engines.run import EngineRun, Request, run
from ._errors import InputError
from ._manifest import Manifest
from ._progress import Progress, listener
from ._raw import Raw, read_raw
from ._shot import TRUTH_UNITS, Layers, noise_unit

__all__ = ["Dataset", "Frame", "FramePicture"]

#: The extensions of raw files, those of files that state most first.
_RAW_FILES = _photosite.raw_endings()


class FramePicture:
    """The image of one camera in a frame: what its folder holds, read when it is asked for.

    Attributes:
        camera_name: the name of the camera.
        frame: the number of the frame.
        folder: where its files are.
    """

    def __init__(self, folder: FilePath, camera_name: str, frame: int, owner: object = None) -> None:
        self.folder, self.camera_name, self.frame = folder, camera_name, frame
        # A temporary folder is there as long as somebody may read from it.
        self._owner = owner

    @cached_property
    def report(self) -> "dict[str, Any]":
        """``capture.json`` as a dictionary."""
        report: "dict[str, Any]" = json.loads((self.folder / "capture.json").read_bytes())
        return report

    @property
    def files(self) -> "tuple[FilePath, ...]":
        """Its files, without the report."""
        return tuple(self.folder / name for name in self.report["files"])

    @cached_property
    def raws(self) -> "tuple[Raw, ...]":
        """All raw images, of a bracket or a burst in their order."""
        for extension in _RAW_FILES:
            found = sorted(file for file in self.files if file.name.startswith("raw") and file.suffix == f".{extension}")
            if found:
                return tuple(read_raw(file) for file in found)
        raise self._missing("raw files", 'output.raw = ["dng"]')

    @property
    def raw(self) -> Raw:
        """The raw image; of several the first."""
        return self.raws[0]

    @cached_property
    def image(self) -> "npt.NDArray[Any]":
        """The developed image: (H, W, 3) uint8, or uint16 of 16 bits; (H, W) of grey."""
        return _photosite.read_codes(os.fspath(self._file("image.png", "output.image = true")))

    @cached_property
    def _electrons(self) -> "dict[str, npt.NDArray[np.float32]]":
        return _photosite.read_exr_arrays(os.fspath(self._file("electrons.exr", "output.electrons = true")))

    @property
    def channels(self) -> "tuple[str, ...]":
        """Names of the channels of ``electrons`` and ``variance``."""
        names = [name for name in self._electrons if not name.startswith("variance.")]
        first = ["R", "G", "B"]
        return tuple(sorted(names, key=lambda name: first.index(name) if name in first else len(first)))

    @cached_property
    def electrons(self) -> "npt.NDArray[np.float32]":
        """Mean photo-electrons, (H, W, C) float32, e⁻, without the sensor's noise."""
        return np.stack([self._electrons[name] for name in self.channels], axis=-1)

    @cached_property
    def variance(self) -> "npt.NDArray[np.float32]":
        """Variance that Monte Carlo noise leaves in them, (H, W, C) float32, (e⁻)²."""
        return np.stack([self._electrons[f"variance.{name}"] for name in self.channels], axis=-1)

    @cached_property
    def truth(self) -> Layers:
        """Ground truth by the names of its layers, with ``truth.units``: ``depth`` (H, W) float32 in m, ``normal``
        (H, W, 3) and so on, as :attr:`Shot.truth` has them. Empty where none was asked for."""
        arrays = self._arrays("truth", 'output.truth_formats = ["exr"]')
        return Layers(arrays.__getitem__, {name: TRUTH_UNITS.get(name, "") for name in arrays})

    @cached_property
    def noise(self) -> Layers:
        """What each effect of the sensor has added, by its name, with ``noise.units``: ``prnu_e`` (H, W) float32 in e⁻.
        Empty where none was asked for."""
        arrays = self._arrays("noise", 'output.noise_formats = ["exr"]')
        return Layers(arrays.__getitem__, {name: noise_unit(name) for name in arrays})

    @property
    def camera(self) -> Camera:
        """Pose and intrinsics."""
        return Camera.of_report(self.report["camera"])

    def _arrays(self, stem: str, wanted: str) -> "dict[str, npt.NDArray[np.float32]]":
        names = {file.name for file in self.files}
        if f"{stem}.exr" in names:
            return _photosite.read_exr_arrays(os.fspath(self.folder / f"{stem}.exr"))
        arrays = sorted(name for name in names if name.startswith(f"{stem}-") and name.endswith(".npy"))
        if arrays:
            found = {name[len(stem) + 1 : -4]: np.load(self.folder / name) for name in arrays}
            return {name: np.asarray(array, np.float32) for name, array in found.items()}
        if any(name.startswith(stem) for name in names):
            raise self._missing(f"{stem}.exr", wanted)
        return {}

    def _file(self, name: str, wanted: str) -> FilePath:
        path = self.folder / name
        if path in self.files:
            return path
        several = sorted(file for file in self.files if file.name.startswith(path.stem) and file.suffix == path.suffix)
        if not several:
            raise self._missing(name, wanted)
        return several[0]

    def _missing(self, what: str, wanted: str) -> InputError:
        reason = f"the images of this data set have no {what}"
        help = f"ask for it in its capture file: {wanted}"
        return InputError(f"{self.folder}: {reason}", file=self.folder, reason=reason, help=help)

    def __reduce__(self) -> Any:
        return FramePicture, (self.folder, self.camera_name, self.frame)

    def __repr__(self) -> str:
        return f"<FramePicture {self.camera_name}/{self.frame:06}>"


class Frame(Mapping[str, FramePicture]):
    """A frame of a data set: the images of its cameras by their names.

    Attributes:
        number: its number.
    """

    def __init__(self, folder: FilePath, cameras: "tuple[str, ...]", number: int, owner: object = None) -> None:
        self.number = number
        self._folder, self._cameras = folder, cameras
        self._pictures = {name: FramePicture(folder / name / f"{number:06}", name, number, owner) for name in cameras}

    def __getitem__(self, camera: str) -> FramePicture:
        return self._pictures[camera]

    def __iter__(self) -> Iterator[str]:
        return iter(self._pictures)

    def __len__(self) -> int:
        return len(self._pictures)

    def __reduce__(self) -> Any:
        return Frame, (self._folder, self._cameras, self.number)

    def __repr__(self) -> str:
        return f"<Frame {self.number} of {', '.join(self._pictures)}>"


class Dataset(Sequence[Frame]):
    """The frames of a data set file, rendered when they are asked for, unless they are there.

    ``len(dataset)``, ``dataset[7]``, ``dataset[:4]``, ``for frame in dataset``. Frame i has the bytes of the command's
    frame i. Several processes, and the command, can fill one folder together: each image is made by one of them.

    Args:
        path: a data set file (``.toml``).
        output: the folder of the data set, as ``photosite dataset -o`` fills it: what is there is read, what is missing
            is rendered and stays. Without, a temporary folder that is there as long as the data set and its frames are.
        set: keys of the capture to change in all frames: ``{"render.samples_per_pixel": 16}``.
        threads: threads to render with; without, all cores.
        device: what traces the light, as for :func:`trace`; images of different devices make different data sets. Workers of
            :meth:`run` trace on the processor.

    Raises:
        InputError: a file, a key or a value that cannot be used.
        FileError: the file cannot be read.
        ResourceError: a device that is not there.
    """

    def __init__(
        self,
        path: Path,
        /,
        *,
        output: Optional[Path] = None,
        set: Optional[Mapping[str, Any]] = None,
        threads: Optional[int] = None,
        device: str = "cpu",
    ) -> None:
        if threads is not None and threads < 1:
            raise invalid("threads", f"expected at least 1, got {threads}")
        # Worker processes may work in another folder.
        typed = path_of("path", path)
        self._path: str = os.path.abspath(typed)
        self._overrides = assignments({} if set is None else set)
        self._threads = threads
        self._device = device
        self._read: "Optional[_photosite.Dataset]" = _photosite.Dataset.read(typed, self._overrides, device)
        self._cameras = tuple(self._compiled.cameras())
        self._fingerprint: str = self._compiled.fingerprint()
        self._owner: "Optional[_TemporaryFolder]" = None
        if output is None:
            self._owner = _TemporaryFolder()
            self._folder = FilePath(self._owner.path)
        else:
            self._folder = FilePath(os.path.abspath(output))
        self._keeps = output is not None
        self._manifest = Manifest(os.fspath(self._folder))
        self._numbers: "Sequence[int]" = range(self._compiled.frame_count())

    @property
    def _compiled(self) -> "_photosite.Dataset":
        # Another process reads the files only where it has to make an image.
        if self._read is None:
            self._read = _photosite.Dataset.read(self._path, self._overrides, self._device)
        return self._read

    @property
    def cameras(self) -> "tuple[str, ...]":
        """The names of the cameras."""
        return self._cameras

    @property
    def folder(self) -> FilePath:
        """Where its images are."""
        return self._folder

    @property
    def numbers(self) -> "tuple[int, ...]":
        """The numbers of its frames, of a slice those of the whole."""
        return tuple(self._numbers)

    def __len__(self) -> int:
        return len(self._numbers)

    @overload
    def __getitem__(self, index: int) -> Frame: ...

    @overload
    def __getitem__(self, index: slice) -> "Dataset": ...

    def __getitem__(self, index: "Union[int, slice]") -> "Union[Frame, Dataset]":
        if isinstance(index, slice):
            return self._part(self._numbers[index])
        number = self._numbers[index]
        if not self._manifest.lists(number, self._cameras, self._fingerprint):
            self._compiled.render(os.fspath(self._folder), [number], self._threads, None)
        return Frame(self._folder, self.cameras, number, self._owner)

    def __iter__(self) -> Iterator[Frame]:
        for index in range(len(self)):
            yield self[index]

    def select(self, frames: Iterable[int]) -> "Dataset":
        """The frames at these places, as a data set of its own over the same folder."""
        return self._part([self._numbers[index] for index in frames])

    def render(
        self,
        *,
        threads: Optional[int] = None,
        progress: Progress = None,
    ) -> int:
        """Renders all frames that are missing, and writes manifest, calibration files and README if they have a folder.

        Args:
            threads: threads to use; without, those of the data set.
            progress: False for no bar, True for one, None for one in terminals and notebooks, or a function that is
                called with how many images are done, and of how many.

        Returns:
            How many images were made by this process; others may make some meanwhile.

        Raises:
            KeyboardInterrupt: Ctrl-C; images that are done stay, one that is under way leaves a checkpoint.
        """
        told = listener(progress, "render", "pictures")
        made = self._compiled.render(os.fspath(self._folder), list(self._numbers), threads or self._threads, told)
        if self._keeps:
            self.write_index()
        return made

    def run(
        self,
        output: Optional[Path] = None,
        *,
        workers: Optional[int] = None,
        threads: Optional[int] = None,
        frames: Optional[Iterable[int]] = None,
        split: str = "frames",
        retries: int = 3,
        keep_going: bool = False,
        progress: Progress = None,
    ) -> EngineRun:
        """Renders the frames that are missing on several processes of this machine, and writes manifest, calibration
        files and README.

        Tasks are as many frames as take about 25 s at the pace seen so far. Frames of a worker that dies go to another
        one; those that it had finished stay. A run that was killed, driver and all, continues when it is called again. The
        result has the bytes of ``photosite dataset``, which several machines run beside each other on one folder.

        Args:
            output: the folder to write to; without, that of the data set.
            workers: tasks under way at once, at most; without, as many as there are cores.
            threads: threads of each worker; without, those of the data set, else the worker's share of the cores.
            frames: numbers of frames to make; without, all of this data set.
            split: "frames", or "samples" where images are few and large: tasks are then samples of one frame, and
                take disk for as many films, at most 16 or so an image, until it is whole.
            retries: further tries of what fails for a reason that may pass, such as a full disk, and of frames whose
                worker dies.
            keep_going: whether frames that cannot be made are in the result, rather than in an error at the end.
            progress: False for no bar, True for one, None for one in terminals and notebooks, or a function that is
                called with how many frames, or samples of them, are done, and of how many.

        Raises:
            Error: frames that could not be made, when the others are done; a reason that does not pass.
            InputError: the folder holds another data set; an argument that cannot be used.
            KeyboardInterrupt: Ctrl-C ends the workers; what is done stays.
        """
        if output is None and not self._keeps:
            raise invalid("output", "a data set in a temporary folder needs a permanent place", 'run("out")')
        if self._device != "cpu":
            raise invalid("device", "workers trace on the processor", "leave device out, or ask for its frames one by one")
        numbers = list(self._numbers)
        if frames is not None:
            wanted = set(frames)
            unknown = sorted(wanted - set(numbers))
            if unknown:
                raise invalid("frames", f"there is no frame {unknown[0]}", f"there are {len(numbers)} frames")
            numbers = [number for number in numbers if number in wanted]
        for name, value, least in (("workers", workers, 1), ("threads", threads, 1), ("retries", retries, 0)):
            if value is not None and value < least:
                raise invalid(name, f"expected at least {least}, got {value}")
        place = os.fspath(self._folder) if output is None else path_of("output", output)
        if "://" in place:
            raise invalid("output", f"{place!r} is a URL", "give a folder, and copy it to the store when the run is over")
        request = Request(
            path=self._path,
            overrides=self._overrides,
            output=os.path.abspath(place),
            frames=numbers,
            workers=workers,
            threads=threads or self._threads,
            split=split,
            retries=retries,
            keep_going=keep_going,
        )
        return run(self._compiled, request, listener(progress, "render", split))

    def write_index(self) -> int:
        """Writes ``manifest.jsonl``, calibration files and ``README.md``, as the command does at its end.

        Returns:
            How many images exist.
        """
        present, _, _ = self._compiled.write_index(os.fspath(self._folder))
        return present

    def _part(self, numbers: "Sequence[int]") -> "Dataset":
        part = object.__new__(Dataset)
        part.__dict__.update(self.__dict__)
        part._numbers = numbers
        return part

    def __reduce__(self) -> Any:
        return _unpickle, (
            self._path,
            self._overrides,
            self._device,
            self._threads,
            os.fspath(self._folder),
            self._keeps,
            tuple(self._numbers),
            self._cameras,
            self._fingerprint,
        )

    def __repr__(self) -> str:
        return f"<Dataset {self._path}: {len(self)} frames of {', '.join(self.cameras)} in {self._folder}>"


def _unpickle(
    path: str,
    overrides: "list[str]",
    device: str,
    threads: Optional[int],
    folder: str,
    keeps: bool,
    numbers: "tuple[int, ...]",
    cameras: "tuple[str, ...]",
    fingerprint: str,
) -> Dataset:
    """The same data set in another process, which leaves a temporary folder to the one that made it."""
    dataset = object.__new__(Dataset)
    parts = {
        "_path": path,
        "_overrides": overrides,
        "_device": device,
        "_threads": threads,
        "_read": None,
        "_cameras": cameras,
        "_fingerprint": fingerprint,
        "_manifest": Manifest(folder),
        "_keeps": keeps,
        "_owner": None,
        "_folder": FilePath(folder),
        "_numbers": cast("Sequence[int]", numbers),
    }
    dataset.__dict__.update(parts)
    return dataset


class _TemporaryFolder:
    """A folder that goes with what holds on to it."""

    def __init__(self) -> None:
        self.path = tempfile.mkdtemp(prefix="photosite-dataset-")
        weakref.finalize(self, _remove, self.path, os.getpid())


def _remove(folder: str, owner: int) -> None:
    # A forked child ends before its parent has done with the folder.
    if os.getpid() == owner:
        shutil.rmtree(folder, ignore_errors=True)
