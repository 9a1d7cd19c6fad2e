"""MCAP files of ROS 2 messages, as ``ros2 bag`` and Foxglove read them.

``CAMERA_optical`` has x right, y down, z forward (REP 103). ``world`` is that of glTF, whose y points up, so that poses are
those of the reports; ``map`` is the same turned so that z does, as ROS has it. Stamps are the middle of the exposure of the
middle row.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from .. import __version__
from .._errors import InputError
from ._samples import Sample
from ._shards import left_out, package

#: Those who join late get the last message of ``/tf_static``.
_STATIC_QOS = """- history: 1
  depth: 1
  reliability: 1
  durability: 1
  deadline:
    sec: 9223372036
    nsec: 854775807
  lifespan:
    sec: 9223372036
    nsec: 854775807
  liveliness: 1
  liveliness_lease_duration:
    sec: 9223372036
    nsec: 854775807
  avoid_ros_namespace_conventions: false
"""

#: What ROS calls the values of a raw image, by its colour filter array.
_ENCODINGS = {
    "mono": "mono16",
    "RGGB": "bayer_rggb16",
    "BGGR": "bayer_bggr16",
    "GBRG": "bayer_gbrg16",
    "GRBG": "bayer_grbg16",
    "full:RGB": "rgb16",
}


class Mcap:
    """``part-000000.mcap`` …"""

    name = "mcap"
    affixes = ("part-", ".mcap")

    def check(self, cameras: "Sequence[str]") -> None:
        """Refuses cameras whose topics would be the same; needs mcap and rosbags."""
        package("mcap.writer")
        package("rosbags.typesys")
        names: "dict[str, str]" = {}
        for camera in cameras:
            other = names.setdefault(_topic_name(camera), camera)
            if other != camera:
                reason = f"the cameras {other} and {camera} would both be /{_topic_name(camera)} in ROS"
                help = "give one of them another name, of letters, digits and _, or choose another format"
                raise InputError(reason, reason=reason, help=help)

    def write(self, path: Path, samples: "Sequence[Sample]") -> None:
        """Writes a file."""
        writer_module, ros = package("mcap.writer"), _Messages()
        with path.open("wb") as file:
            writer = writer_module.Writer(file, compression=writer_module.CompressionType.NONE)
            writer.start(profile="ros2", library=f"photosite {__version__}")
            schemas: "dict[str, int]" = {}
            channels: "dict[str, int]" = {}
            for sample in samples:
                stamp_ns = int(sample.facts["stamp_ns"])
                messages = list(ros.of(sample))
                if not channels:
                    messages.insert(0, ("/tf_static", ros.transform(stamp_ns, "map", "world", ([0.0, 0.0, 0.0], _UPRIGHT))))
                for topic, message in messages:
                    kind: str = message.__msgtype__
                    if kind not in schemas:
                        schemas[kind] = writer.register_schema(kind, "ros2msg", ros.definition(kind))
                    if topic not in channels:
                        about = {"offered_qos_profiles": _STATIC_QOS} if topic == "/tf_static" else {}
                        channels[topic] = writer.register_channel(topic, "cdr", schemas[kind], about)
                    data = ros.cdr(message)
                    writer.add_message(channels[topic], stamp_ns, data, stamp_ns, sequence=sample.frame)
            writer.finish()

    def finish(self, folder: Path, shards: "Sequence[Path]") -> None:
        """Writes nothing: each file says itself what it holds."""


#: A quarter turn about x, as x, y, z, w: it leads from z up to y up.
_UPRIGHT = [0.5**0.5, 0.0, 0.0, 0.5**0.5]


class _Messages:
    """Messages of ROS 2, by the types of rosbags."""

    def __init__(self) -> None:
        typesys = package("rosbags.typesys")
        self._store = typesys.get_typestore(typesys.Stores.ROS2_HUMBLE)

    def definition(self, kind: str) -> bytes:
        """The definition of a type with all that it depends on."""
        text: str = self._store.generate_msgdef(kind, ros_version=2)[0]
        return text.encode()

    def cdr(self, message: Any) -> bytes:
        """A message as bytes."""
        return bytes(self._store.serialize_cdr(message, message.__msgtype__))

    def of(self, sample: Sample) -> "Iterator[tuple[str, Any]]":
        """The messages of an image with their topics."""
        name, facts, raw = _topic_name(sample.camera), sample.facts, sample.raw
        stamp_ns, frame_id = int(facts["stamp_ns"]), f"{name}_optical"
        header = self._header(stamp_ns, frame_id)
        if facts["ros"]["reason"] is None:
            yield f"/{name}/camera_info", self._camera_info(header, facts)
        else:
            left_out(f"there is no /{name}/camera_info: {facts['ros']['reason']}")
        if raw is not None:
            encoding = _ENCODINGS.get(raw.active_cfa)
            if encoding is None:
                left_out(f"there is no /{name}/image_raw: ROS has no name for the filters {raw.active_cfa}")
            else:
                yield f"/{name}/image_raw", self._image(header, encoding, raw.active)
        if sample.image is not None:
            data = np.frombuffer(sample.image, np.uint8)
            yield f"/{name}/image/compressed", self._make("sensor_msgs/msg/CompressedImage", header, "png", data)
        for layer, values in sample.truth.items():
            channels = 1 if values.ndim == 2 else values.shape[2]
            if values.dtype == np.uint32:
                image = self._image(header, "32SC1", values.astype(np.int32))
            else:
                image = self._image(header, f"32FC{channels}", values)
            yield f"/{name}/truth/{_ros_name(layer)}", image
        pose = (facts["in_world"]["translation_m"], facts["in_world"]["quaternion_xyzw"])
        yield "/tf", self.transform(stamp_ns, "world", frame_id, pose)

    def transform(self, stamp_ns: int, parent: str, child: str, pose: "tuple[list[float], list[float]]") -> Any:
        """Where a frame stands in another: its place, m, and its turn as x, y, z, w."""
        place = self._make("geometry_msgs/msg/Vector3", *pose[0])
        turn = self._make("geometry_msgs/msg/Quaternion", *pose[1])
        transform = self._make("geometry_msgs/msg/Transform", place, turn)
        stamped = self._make("geometry_msgs/msg/TransformStamped", self._header(stamp_ns, parent), child, transform)
        return self._make("tf2_msgs/msg/TFMessage", [stamped])

    def _make(self, kind: str, *fields: Any) -> Any:
        return self._store.types[kind](*fields)

    def _header(self, stamp_ns: int, frame_id: str) -> Any:
        stamp = self._make("builtin_interfaces/msg/Time", *divmod(stamp_ns, 10**9))
        return self._make("std_msgs/msg/Header", stamp, frame_id)

    def _image(self, header: Any, encoding: str, values: "npt.NDArray[Any]") -> Any:
        rows, columns = values.shape[:2]
        # Little-endian, row by row.
        data = np.ascontiguousarray(values.astype(values.dtype.newbyteorder("<"))).view(np.uint8).ravel()
        return self._make("sensor_msgs/msg/Image", header, rows, columns, encoding, 0, data.size // rows, data)

    def _camera_info(self, header: Any, facts: "dict[str, Any]") -> Any:
        """The camera on its own: rectification is the identity, and the projection matrix that of the camera."""
        columns, rows = facts["resolution_px"]
        matrix = np.array(facts["camera_matrix"], np.float64)
        projection = np.hstack([matrix, np.zeros((3, 1))])
        model, coefficients = facts["ros"]["model"], np.array(facts["distortion"], np.float64)
        everything = self._make("sensor_msgs/msg/RegionOfInterest", 0, 0, 0, 0, False)
        values = (coefficients, matrix.ravel(), np.eye(3).ravel(), projection.ravel())
        return self._make("sensor_msgs/msg/CameraInfo", header, rows, columns, model, *values, 0, 0, everything)


def _ros_name(name: str) -> str:
    """A name as topics have it: letters, digits and underscores only."""
    return re.sub("[^0-9A-Za-z]", "_", name)


def _topic_name(camera: str) -> str:
    """A camera's name as topics have it, which begin with a letter."""
    name = _ros_name(camera)
    return name if re.match("[A-Za-z]", name) else f"camera_{name}"
