"""Images that rows hand to photosite, written without it, and those that it wrote, read without it."""

import struct

import numpy


def write_exr(path, picture, aspect=1.0):
    """Linear light, (rows, columns) or (rows, columns, R G B), as an uncompressed OpenEXR file."""
    rows, columns = picture.shape[:2]
    planes = {"Y": picture} if picture.ndim == 2 else dict(zip("RGB", numpy.moveaxis(picture, 2, 0)))
    planes = {name: planes[name].astype("<f4") for name in sorted(planes)}
    channels = b"".join(name.encode() + b"\0" + struct.pack("<iiii", 2, 0, 1, 1) for name in planes) + b"\0"
    window = struct.pack("<iiii", 0, 0, columns - 1, rows - 1)
    header = struct.pack("<ii", 20000630, 2)
    for name, kind, value in [
        ("channels", "chlist", channels),
        ("compression", "compression", b"\0"),
        ("dataWindow", "box2i", window),
        ("displayWindow", "box2i", window),
        ("lineOrder", "lineOrder", b"\0"),
        ("pixelAspectRatio", "float", struct.pack("<f", aspect)),
        ("screenWindowCenter", "v2f", struct.pack("<ff", 0, 0)),
        ("screenWindowWidth", "float", struct.pack("<f", 1)),
    ]:
        header += f"{name}\0{kind}\0".encode() + struct.pack("<i", len(value)) + value
    header += b"\0"
    length = 8 + 4 * columns * len(planes)
    first = len(header) + 8 * rows
    table = struct.pack(f"<{rows}Q", *(first + y * length for y in range(rows)))
    lines = (
        struct.pack("<ii", y, length - 8) + b"".join(plane[y].tobytes() for plane in planes.values())
        for y in range(rows)
    )
    path.write_bytes(header + table + b"".join(lines))
    return path


def develop(tool, picture, *settings, output="out.npy"):
    """Develops an image with changes `key=value` of the table [develop]; gives what NumPy reads of it."""
    path = tool.scratch / output
    changes = [part for setting in settings for part in ("--set", f"develop.{setting}")]
    tool.run("develop", picture, "-o", path, "--force", "--quiet", *changes)
    return numpy.load(path) if path.suffix == ".npy" else path


def largest(a, b):
    """The largest difference of two arrays."""
    return float(numpy.abs(numpy.asarray(a, float) - numpy.asarray(b, float)).max())
