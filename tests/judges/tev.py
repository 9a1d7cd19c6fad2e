#!/usr/bin/env python3
"""Compares what `photosite render --tev` sends with what tev's own Python package sends of the same pictures.

    tev.py PHOTOSITE

A listener stands in for tev. Each message that comes is read, and made again by `tevclient`: the bytes must be equal. What
the messages show in the end must be the picture as `photosite develop` makes it of the raw file, and `electrons.exr`, as
OpenEXR reads them.

Needs: tevclient, OpenEXR, numpy.
"""

import socket
import struct
import subprocess
import sys
import tempfile
import threading
from pathlib import Path

import numpy as np
import OpenEXR
from tevclient import packet

CAPTURE = Path(__file__).resolve().parents[2] / "scenes/cornell-box/capture.toml"
CREATE, UPDATE = 4, 6


class Message:
    """What is left of a message."""

    def __init__(self, data):
        self.data, self.at = data, 0

    def numbers(self, code, count=1):
        values = struct.unpack_from(f"<{count}{code}", self.data, self.at)
        self.at += struct.calcsize(f"<{count}{code}")
        return list(values)

    def name(self):
        end = self.data.index(0, self.at)
        text = self.data[self.at : end].decode()
        self.at = end + 1
        return text


def listen(server, messages):
    connection, _ = server.accept()
    with connection, connection.makefile("rb") as stream:
        while head := stream.read(4):
            (length,) = struct.unpack("<I", head)
            messages.append(head + stream.read(length - 4))


def judge(message, images):
    """Takes a message into the images, and returns what tevclient makes of the same picture."""
    m = Message(message)
    _, kind, selected = m.numbers("I") + m.numbers("B", 2)
    name = m.name()
    if kind == CREATE:
        width, height, count = m.numbers("I", 3)
        channels = [m.name() for _ in range(count)]
        images[name] = channels, np.zeros((height, width, count), np.float32), []
        return packet.create_image(name, width, height, channels, bool(selected))
    assert kind == UPDATE, kind
    (count,) = m.numbers("I")
    channels = [m.name() for _ in range(count)]
    x, y, width, height = m.numbers("I", 4)
    m.numbers("Q", 2 * count)
    tile = np.frombuffer(message, "<f4", offset=m.at).reshape(height, width, count)
    known, picture, updates = images[name]
    assert channels == known, channels
    picture[y : y + height, x : x + width] = tile
    updates.append(y)
    return packet.update_image(name, tile, channels, x, y, bool(selected))


def planes(path, channels):
    with OpenEXR.File(str(path), separate_channels=True) as file:
        return np.stack([file.channels()[name].pixels for name in channels], axis=2)


def main(photosite):
    with tempfile.TemporaryDirectory() as folder, socket.create_server(("127.0.0.1", 0)) as server:
        messages, out = [], Path(folder) / "out"
        listener = threading.Thread(target=listen, args=(server, messages), daemon=True)
        listener.start()
        address = f"127.0.0.1:{server.getsockname()[1]}"
        render = [photosite, "render", CAPTURE, "-o", out, "--tev", address, "--spp", "64"]
        log = subprocess.run(render, check=True, capture_output=True, text=True).stderr
        assert "tev" not in log, log
        listener.join(timeout=10)
        assert not listener.is_alive(), "the connection is still open"
        subprocess.run([photosite, "develop", out / "raw.dng", "-o", out / "developed.exr", "--quiet"], check=True)

        images = {}
        for message in messages:
            assert message == bytes(judge(message, images)), message[:100]
        assert list(images) == ["out/image", "out/electrons"], list(images)
        for name, file in ("out/image", "developed.exr"), ("out/electrons", "electrons.exr"):
            channels, shown, updates = images[name]
            np.testing.assert_array_equal(shown, planes(out / file, channels), name)
            times = updates.count(0)
            assert times > 1, f"{name} was sent {times} times"
            print(f"{name}: {shown.shape}, sent {times} times, at last as {file}")
        print(f"{len(messages)} messages, byte for byte those of tevclient")


if __name__ == "__main__":
    main(sys.argv[1])
