"""Judges the layouts for training programs by the packages that those use: webdataset, datasets, mcap with ROS 2's messages,
rosbags; Nerfstudio by its documented conventions and OpenCV. Every array must be that of the data set's own files, and every
pose and lens must put the corners of a target where capture.json has them. Shards that two processes write together must have
the bytes of those that one writes.

Usage: trainers.py PHOTOSITE, with Python that has photosite[train]
"""

import io
import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path

os.environ.update(HF_DATASETS_OFFLINE="1", HF_HUB_OFFLINE="1")

import cv2
import datasets
import numpy as np
import webdataset
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory
from PIL import Image
from rosbags.highlevel import AnyReader

SIZE = (64, 48)
# Both sides calculate in double precision, from numbers that are written with all digits.
PIXELS = 1e-6
POSES = 1e-6
LAYERS = {"depth": np.float32, "instance": np.uint32, "normal": np.float32, "position": np.float32, "uv": np.float32}

CAPTURE = """
[scene]
environment = { illuminant = "D65", illuminance_lux = 500 }
[[targets]]
type = "chessboard"
name = "board"
squares = [6, 5]
square_mm = 60
position_m = [0.1, 0.05, -0.1]
look_at_m = [0.2, 0.3, 2]
[camera]
position_m = [0, 0, 1.2]
look_at_m = [0, 0, 0]
[lens]
type = "pinhole"
f_number = 4
focus_distance_m = "infinity"
intrinsics = { fx = 60.5, fy = 61, cx = 32.5, cy = 23.25 }
[sensor]
preset = "generic-cmos-color"
resolution_px = [64, 48]
[exposure]
time_s = 0.004
[render]
samples_per_pixel = 1
max_depth = 2
[output]
electrons = false
raw = ["dng", "npy"]
truth = ["depth", "instance", "normal", "position", "uv"]
truth_formats = ["exr", "npy"]
"""
RIG = """
capture = "capture.toml"
frames = 5
[[cameras]]
name = "left"
[[cameras]]
name = "right-2"
position_m = [0.12, 0.01, -0.02]
look_at_m = [0.05, 0, -1]
up = [0.05, 1, 0]
"""
ALONE = 'capture = "capture.toml"\nframes = 5\n'
MOVING = """
[poses.trajectory]
frame_rate_hz = 10
poses = [
  { time_s = 0, position_m = [-0.1, 0, 1.2], look_at_m = [0, 0, 0] },
  { time_s = 1, position_m = [0.5, 0.3, 1.4], look_at_m = [0.3, 0.1, 0], up = [0.3, 1, 0] },
]
"""
RANDOM = """
[poses.random]
look_at_m = [0, 0, -0.1]
distance_m = [0.9, 1.3]
tilt_deg = [0, 60]
"""
LISTED = """
[poses]
list = [
  { position_m = [0, 1.2, 0.4], look_at_m = [0, 0, 0] },
  { position_m = [1.2, -0.3, 0.3], look_at_m = [0, 0, 0], up = [0, 0, 1] },
]
"""
OPENCV = "lens.distortion={ model = 'brown-conrady', k = [-0.1, 0.02, 0.003], p = [1e-3, -2e-3] }"
RATIONAL = "lens.distortion={ model = 'brown-conrady', k = [-0.1, 0.02, 0.003, 0.05, 0.01, 0.002], p = [1e-3, -2e-3] }"
FISHEYE = "lens.distortion={ model = 'kannala-brandt', k = [0.05, 0.01, -0.002, 0.0004] }"
ROLLING = "sensor.shutter={ kind = 'rolling', row_time_us = 800 }"
MONO = "sensor.preset=sony-imx249-mono"
TRAIN = (sys.executable, "-m", "photosite.train")


def run(*command, status=0):
    done = subprocess.run([str(part) for part in command], capture_output=True, text=True)
    if done.returncode != status:
        sys.exit(f"{command}: {done.returncode}: {done.stderr}")
    return done.stderr


def same(what, found, wanted):
    found, wanted = np.asarray(found), np.asarray(wanted)
    if found.dtype != wanted.dtype or not np.array_equal(found, wanted, equal_nan=found.dtype.kind == "f"):
        sys.exit(f"{what}: {found.dtype}{found.shape} differs from {wanted.dtype}{wanted.shape}")


def close(what, found, wanted, limit):
    error = np.abs(np.asarray(found, float) - np.asarray(wanted, float)).max()
    if not error <= limit:
        sys.exit(f"{what}: off by {error}, which is more than {limit}")
    return error


class Set:
    """A data set with what its own files say."""

    def __init__(self, photosite, folder, name, text, *overrides):
        self.photosite, self.folder = photosite, folder / name
        self.toml = folder / f"{name}.toml"
        self.toml.write_text(text)
        self.overrides = [word for override in overrides for word in ("--set", override)]
        run(photosite, "dataset", self.toml, "-o", self.folder, "--quiet", *self.overrides)
        lines = [json.loads(line) for line in (self.folder / "manifest.jsonl").read_text().splitlines()]
        self.lines = {(line["camera"], line["frame"]): line for line in lines}
        self.reports = {key: json.loads(self.path(*key, "capture.json").read_text()) for key in self.lines}
        # Half of what is judged would be judged of nothing.
        depths = [np.load(self.path(*key, "truth-depth.npy")) for key in self.lines]
        assert any(np.isinf(depth).any() for depth in depths) and any(np.isfinite(depth).any() for depth in depths)

    def path(self, camera, frame, name):
        return self.folder / camera / f"{frame:06}" / name

    def image(self, *key):
        return np.asarray(Image.open(self.path(*key, "image.png")))

    def raw(self, *key):
        return np.load(self.path(*key, "raw.npy"))

    def truth(self, layer, *key):
        array = np.load(self.path(*key, f"truth-{layer}.npy"))
        assert array.dtype == LAYERS[layer]
        return array

    def pose(self, *key):
        camera = self.reports[key]["camera"]
        return np.array(camera["rotation"]), np.array(camera["translation_m"])

    def corners(self, *key):
        target = self.reports[key]["targets"][0]
        return np.array(target["points_world_m"]), np.array(target["points_px"], float)

    def layout(self, kind, *arguments):
        out = self.folder.with_name(f"{self.folder.name}-{kind}")
        return out, run(self.photosite, "layout", self.folder, "--format", kind, "-o", out, *arguments)

    def shards(self, kind, *arguments):
        out = self.folder.with_name(f"{self.folder.name}-{kind}")
        return out, run(*TRAIN, kind, self.folder, "-o", out, *arguments)


def project(points, rotation, translation, matrix, model, coefficients):
    rotation, _ = cv2.Rodrigues(np.ascontiguousarray(rotation, float))
    points, translation = np.ascontiguousarray(points, float).reshape(-1, 1, 3), np.array(translation, float).reshape(3, 1)
    if model in ("equidistant", "OPENCV_FISHEYE", "kannala-brandt"):
        found, _ = cv2.fisheye.projectPoints(points, rotation, translation, matrix, np.asarray(coefficients, float))
    else:
        found, _ = cv2.projectPoints(points, rotation, translation, matrix, np.asarray(coefficients, float))
    return found.reshape(-1, 2)


def is_skewed(made):
    return any(report["camera"]["motion"] and report["camera"]["motion"]["row_time_s"] for report in made.reports.values())


def webdataset_shards(made):
    out, _ = made.shards("webdataset", "--shard-frames", "2")
    paths = sorted(out.glob("*.tar"))
    assert [path.name for path in paths] == [f"shard-{i:06}.tar" for i in range(3)]
    samples = list(webdataset.WebDataset([str(path) for path in paths], shardshuffle=False).decode("rgb8"))
    assert [sample["__key__"] for sample in samples] == [f"{camera}-{frame:06}" for camera, frame in made.lines]
    for key, sample in zip(made.lines, samples):
        image = made.image(*key)
        same("webdataset: image", sample["png"], image if image.ndim == 3 else np.stack([image] * 3, axis=-1))
        same("webdataset: raw", sample["raw.npy"], made.raw(*key))
        for layer in LAYERS:
            same(f"webdataset: {layer}", sample[f"{layer}.npy"], made.truth(layer, *key))
        assert sample["json"] == made.reports[key]
        facts, camera = sample["camera.json"], made.reports[key]["camera"]
        assert (facts["camera"], facts["frame"]) == key and facts["time_s"] == made.lines[key]["time_s"]
        assert facts["projection"] == camera["projection"] and facts["distortion"] == camera["distortion"]
        assert facts["seed"] == made.reports[key]["seed"]
        close("webdataset: matrix", facts["camera_matrix"], camera["camera_matrix"], PIXELS)
        close("webdataset: rotation", facts["rotation"], camera["rotation"], POSES)
        close("webdataset: translation", facts["translation_m"], camera["translation_m"], POSES)
    index = json.loads((out / "index.json").read_text())
    assert index["__kind__"] == "wids-shard-index-v1" and index["wids_version"] == 1
    per_frame = len(made.lines) // 5
    listed = [(shard["url"], shard["nsamples"], shard["filesize"]) for shard in index["shardlist"]]
    assert listed == [(p.name, n * per_frame, p.stat().st_size) for p, n in zip(paths, (2, 2, 1))]
    return len(samples)


def parquet(made):
    out, warned = made.shards("parquet", "--shard-frames", "3")
    assert "without normal, position, uv" in warned
    with tempfile.TemporaryDirectory() as cache:
        files = str(out / "part-*.parquet")
        table = datasets.load_dataset("parquet", data_files=files, split="train", cache_dir=cache)
        stream = list(datasets.load_dataset("parquet", data_files=files, split="train", cache_dir=cache, streaming=True))
        folder = datasets.load_dataset(str(out), split="train", cache_dir=cache)
        assert len(table) == len(stream) == len(folder) == len(made.lines)
        for (key, line), row, streamed in zip(made.lines.items(), table, stream):
            camera = made.reports[key]["camera"]
            assert (row["camera"], row["frame"], row["time_s"]) == (*key, line["time_s"])
            assert row["seed"] == made.reports[key]["seed"] and row["projection"] == camera["projection"]
            same("datasets: image", row["image"], made.image(*key))
            same("datasets: raw", row["raw"], made.raw(*key))
            same("datasets: instance", row["instance"], made.truth("instance", *key).astype(np.uint16))
            depth, codes = made.truth("depth", *key).astype(float), np.asarray(row["depth"])
            assert codes.dtype == np.uint16 and np.array_equal(codes == 0, ~np.isfinite(depth))
            found = codes * row["depth_unit_m"]
            # Half a step, and the last bit of 32-bit floats.
            close("datasets: depth", found[codes > 0], depth[codes > 0], 0.5 * row["depth_unit_m"] + 1e-6)
            close("datasets: matrix", row["camera_matrix"], np.ravel(camera["camera_matrix"]), PIXELS)
            close("datasets: rotation", row["rotation"], np.ravel(camera["rotation"]), POSES)
            close("datasets: translation", row["translation_m"], camera["translation_m"], POSES)
            assert row["distortion"] == camera["distortion"]
            assert json.loads(row["capture"]) == made.reports[key]
            same("datasets: streamed", streamed["raw"], row["raw"])
            assert streamed["rotation"] == row["rotation"]


ROS_TYPES = {"32FC1": np.float32, "32FC2": np.float32, "32FC3": np.float32, "32SC1": np.int32, "mono16": np.uint16}


def ros_array(message):
    """The numbers of an Image."""
    kind = ROS_TYPES.get(message.encoding, np.uint16)
    assert message.encoding in ROS_TYPES or message.encoding.startswith("bayer_")
    data = np.frombuffer(bytes(message.data), kind)
    channels = len(data) // (message.width * message.height)
    assert message.step == message.width * channels * data.itemsize and not message.is_bigendian
    shape = (message.height, message.width, channels)
    return data.reshape(shape[:2] if channels == 1 else shape)


def matrix_of(transform):
    """A Transform as a matrix: R = (w² − v·v)·1 + 2·v·vᵀ + 2·w·[v]ₓ."""
    q, t = transform.rotation, transform.translation
    v = np.array([q.x, q.y, q.z])
    cross = np.array([[0, -v[2], v[1]], [v[2], 0, -v[0]], [-v[1], v[0], 0]])
    matrix = np.eye(4)
    matrix[:3, :3] = (q.w**2 - v @ v) * np.eye(3) + 2 * np.outer(v, v) + 2 * q.w * cross
    matrix[:3, 3] = t.x, t.y, t.z
    return matrix


def decoded_by_mcap(paths):
    for path in paths:
        with path.open("rb") as file:
            reader = make_reader(file, decoder_factories=[DecoderFactory()])
            assert reader.get_header().profile == "ros2"
            for _, channel, message, decoded in reader.iter_decoded_messages():
                yield channel.topic, message.log_time, decoded


def decoded_by_rosbags(paths):
    for path in paths:
        with AnyReader([path]) as bag:
            for connection, time, data in bag.messages():
                yield connection.topic, time, bag.deserialize(data, connection.msgtype)


def mcap_files(made, model, encoding):
    out, warned = made.shards("mcap", "--shard-frames", "2")
    paths = sorted(out.glob("*.mcap"))
    assert len(paths) == 3
    for decode in (decoded_by_mcap, decoded_by_rosbags):
        found, placed = {}, {}
        for topic, time, message in decode(paths):
            if topic == "/tf_static":
                (static,) = message.transforms
                assert (static.header.frame_id, static.child_frame_id) == ("map", "world")
                # y up becomes z up.
                close("mcap: world in map", matrix_of(static.transform)[:3, :3] @ [0, 1, 0], [0, 0, 1], POSES)
            elif topic == "/tf":
                (moved,) = message.transforms
                assert moved.header.frame_id == "world"
                placed[moved.child_frame_id, time] = matrix_of(moved.transform)
            else:
                assert message.header.stamp.sec * 10**9 + message.header.stamp.nanosec == time
                found[topic, time] = message
        times = sorted({time for _, time in found})
        assert len(times) == 5
        for camera, frame in made.lines:
            key, name, time = (camera, frame), camera.replace("-", "_"), times[frame]
            rotation, translation = made.pose(*key)
            in_camera = np.linalg.inv(placed[f"{name}_optical", time])
            close("mcap: rotation", in_camera[:3, :3], rotation, POSES)
            close("mcap: translation", in_camera[:3, 3], translation, POSES)
            image = found[f"/{name}/image/compressed", time]
            assert image.format == "png" and image.header.frame_id == f"{name}_optical"
            same("mcap: image", Image.open(io.BytesIO(bytes(image.data))), made.image(*key))
            raw = found[f"/{name}/image_raw", time]
            assert raw.encoding == encoding
            same("mcap: raw", ros_array(raw), made.raw(*key))
            for layer, kind in LAYERS.items():
                wanted = made.truth(layer, *key)
                same(f"mcap: {layer}", ros_array(found[f"/{name}/truth/{layer}", time]), wanted if kind == np.float32 else wanted.astype(np.int32))
            if model is None:
                assert f"there is no /{name}/camera_info" in warned and (f"/{name}/camera_info", time) not in found
                continue
            info = found[f"/{name}/camera_info", time]
            assert (info.width, info.height, info.distortion_model) == (*SIZE, model)
            fields = {field.lower(): np.array(getattr(info, field)) for field in dir(info) if field.lower() in ("d", "k", "r", "p")}
            assert len(fields["d"]) == {"plumb_bob": 5, "rational_polynomial": 8, "equidistant": 4}[model]
            assert np.array_equal(fields["r"].reshape(3, 3), np.eye(3))
            assert np.array_equal(fields["p"].reshape(3, 4)[:, :3], fields["k"].reshape(3, 3))
            if not is_skewed(made):
                world, pixels = made.corners(*key)
                seen = project(world, in_camera[:3, :3], in_camera[:3, 3], fields["k"].reshape(3, 3), model, fields["d"])
                close("mcap: corners", seen, pixels, PIXELS)


GL = np.diag([1.0, -1, -1, 1])


def between(start, end, part):
    """The pose on the way from one to another: the centre straight, the rotation about one axis."""
    turn, _ = cv2.Rodrigues(start[:3, :3].T @ end[:3, :3])
    pose = np.eye(4)
    pose[:3, :3] = start[:3, :3] @ cv2.Rodrigues(turn * part)[0]
    pose[:3, 3] = start[:3, 3] + (end[:3, 3] - start[:3, 3]) * part
    return pose


def nerfstudio(made):
    out, warned = made.layout("nerfstudio")
    data = json.loads((out / "transforms.json").read_text())
    # World → the file's world, whose z points up.
    applied = np.vstack([data["applied_transform"], [0, 0, 0, 1]])
    close("nerfstudio: up", applied[:3, :3] @ [0, 1, 0], [0, 0, 1], 0)
    close("nerfstudio: a rotation", np.linalg.det(applied), 1, 1e-15)
    assert len(data["frames"]) == len(made.lines)
    shutter = data.get("rolling_shutter")
    assert (shutter is not None) == is_skewed(made) and not warned.strip().startswith("warning")
    errors = []
    for key, frame in zip(made.lines, data["frames"]):
        camera, number = key
        assert frame["file_path"] == f"images/{camera}-{number:06}.png"
        assert (out / frame["file_path"]).read_bytes() == made.path(*key, "image.png").read_bytes()
        depth, mm = made.truth("depth", *key), np.load(out / frame["depth_file_path"])
        assert mm.dtype == np.float32 and np.array_equal(mm == 0, ~np.isfinite(depth))
        assert np.allclose(mm[mm > 0], depth[mm > 0] * 1000, rtol=1e-6, atol=0)
        to_world = np.array(frame["transform_matrix"])
        rotation, translation = made.pose(*key)
        from_world = GL @ np.linalg.inv(to_world) @ applied
        close("nerfstudio: rotation", from_world[:3, :3], rotation, POSES)
        close("nerfstudio: translation", from_world[:3, 3], translation, POSES)
        lens = data if "fl_x" in data else frame
        assert (lens["w"], lens["h"]) == SIZE and not ("fl_x" in data and "fl_x" in frame)
        # Integer coordinates are corners of pixels.
        matrix = np.array([[lens["fl_x"], 0, lens["cx"]], [0, lens["fl_y"], lens["cy"]], [0, 0, 1]])
        model = data["camera_model"]
        names = {"OPENCV": ("k1", "k2", "p1", "p2", "k3"), "OPENCV_FISHEYE": ("k1", "k2", "k3", "k4")}[model]
        coefficients = [lens.get(name, 0.0) for name in names]
        world, pixels = made.corners(*key)
        for point, pixel in zip(world, pixels):
            pose = to_world
            if shutter:
                # instant-ngp: the part of the way at u, v from 0 to 1 and in the middle of the exposure.
                a, b, c, d = shutter
                part = a + c * (pixel[1] + 0.5) / SIZE[1] + 0.5 * d
                assert b == 0
                pose = between(np.array(frame["transform_matrix_start"]), np.array(frame["transform_matrix_end"]), part)
                assert frame["shutter_type"] == "ROLLING_TOP_TO_BOTTOM"
            seen_from = GL @ np.linalg.inv(pose) @ applied
            seen = project(point, seen_from[:3, :3], seen_from[:3, 3], matrix, model, coefficients)[0]
            errors.append(np.abs(seen - 0.5 - pixel).max())
    worst = close("nerfstudio: corners", errors, 0, PIXELS)
    if shutter:
        frame, report = data["frames"][0], made.reports[next(iter(made.lines))]
        motion = report["camera"]["motion"]
        part = motion["exposure_s"] / (motion["row_time_s"] * (SIZE[1] - 1))
        close("nerfstudio: exposure", shutter[3], part, 1e-12)
        moved = np.array(frame["transform_matrix_end"])[:3, 3] - np.array(frame["transform_matrix_start"])[:3, 3]
        first, last = motion["poses"][0], motion["poses"][-1]
        velocity = (np.array(last["position_m"]) - first["position_m"]) / (last["time_s"] - first["time_s"])
        close("nerfstudio: way of the rows", moved, applied[:3, :3] @ velocity * motion["row_time_s"] * (SIZE[1] - 1), POSES)
    print(f"nerfstudio {made.folder.name}: corners to {worst:.1e} px")


def bytes_of(folder):
    return {path.name: path.read_bytes() for path in folder.iterdir()}


def together(made):
    """Two processes write the shards of a set; one writes those of the same set; a lost one is written again."""
    for kind in ("webdataset", "parquet", "mcap"):
        folders = [made.folder.with_name(f"{name}-{kind}") for name in ("together", "alone")]
        command = [sys.executable, "-m", "photosite.train", kind, made.folder, "--shard-frames", "2", "-o"]
        workers = [subprocess.Popen([str(word) for word in (*command, folders[0])]) for _ in range(2)]
        assert [worker.wait(timeout=120) for worker in workers] == [0, 0]
        run(*command, folders[1])
        wanted = bytes_of(folders[1])
        assert bytes_of(folders[0]) == wanted, f"{kind}: not the same bytes"
        assert len(wanted) == (5 if kind == "webdataset" else 4)
        lost = sorted(folders[0].iterdir())[-1]
        lost.unlink()
        run(*command, folders[0])
        assert bytes_of(folders[0]) == wanted


def main():
    datasets.disable_progress_bars()
    photosite = Path(sys.argv[1]).resolve()
    with tempfile.TemporaryDirectory() as scratch:
        scratch = Path(scratch)
        (scratch / "capture.toml").write_text(CAPTURE)
        sets = [
            (Set(photosite, scratch, "moving", RIG + MOVING, OPENCV), "plumb_bob", "bayer_rggb16", True),
            (Set(photosite, scratch, "rolling", ALONE + MOVING, OPENCV, ROLLING, "exposure.time_s=0.01"), "plumb_bob", "bayer_rggb16", True),
            (Set(photosite, scratch, "fisheye", RIG + RANDOM, FISHEYE, MONO), "equidistant", "mono16", True),
            (Set(photosite, scratch, "pinhole", RIG + LISTED, "sensor.cfa=GBRG"), "plumb_bob", "bayer_gbrg16", True),
            (Set(photosite, scratch, "rational", ALONE + LISTED, RATIONAL, MONO), "rational_polynomial", "mono16", False),
            (Set(photosite, scratch, "classical", ALONE + RANDOM, "lens.projection=equisolid"), None, "bayer_rggb16", False),
        ]
        for made, model, encoding, is_known in sets:
            count = webdataset_shards(made)
            parquet(made)
            mcap_files(made, model, encoding)
            if is_known:
                nerfstudio(made)
            else:
                out = made.folder.with_name("refused")
                stderr = run(photosite, "layout", made.folder, "--format", "nerfstudio", "-o", out, status=1)
                assert "Nerfstudio" in stderr and not out.exists()
            print(f"{made.folder.name}: {count} images by webdataset, datasets, mcap, rosbags")
        together(sets[0][0])
        print("together: the same bytes by two processes as by one")


main()
