"""Makes the files of this folder: a curved patch, and an image, as they are and packed in every way.

The tools are those that people use: gltf-transform (which has Draco's own encoder) and gltfpack for geometry, Basis
Universal for images. What the images decode to is Basis Universal's own word, in PNG files beside them.

    npm install @gltf-transform/cli@4.5.1 gltfpack@1.3.0 meshoptimizer@1.3.0
    pip install alktx2==0.1.7
    python3 make.py path/to/node_modules/.bin
    NODE_PATH=path/to/node_modules node make_streams.cjs

plain.glb needs Python only, and is the same wherever it is made.
"""

import json
import math
import struct
import subprocess
import sys
from pathlib import Path

HERE = Path(__file__).parent
SIDE = 7  # vertices


def patch():
    """The patch z = sin(2x)·cos(3y)/5 over 0–1 m, with normals, UVs and colours."""
    positions, normals, uvs, colours = [], [], [], []
    for j in range(SIDE):
        for i in range(SIDE):
            x, y = i / (SIDE - 1), (j / (SIDE - 1)) ** 1.3
            slope_x, slope_y = 0.4 * math.cos(2 * x) * math.cos(3 * y), -0.6 * math.sin(2 * x) * math.sin(3 * y)
            length = math.sqrt(slope_x**2 + slope_y**2 + 1)
            positions += [x, y, 0.2 * math.sin(2 * x) * math.cos(3 * y)]
            normals += [-slope_x / length, -slope_y / length, 1 / length]
            uvs += [x, 1 - y]
            colours += [round(255 * x), round(255 * y), 40 * (i % 3), 255]
    triangles = []
    for j in range(SIDE - 1):
        for i in range(SIDE - 1):
            a, b = j * SIDE + i, (j + 1) * SIDE + i
            triangles += [a, a + 1, b + 1, a, b + 1, b]
    return positions, normals, uvs, colours, triangles


def write_plain(path):
    positions, normals, uvs, colours, triangles = patch()
    count = SIDE * SIDE
    parts = [
        ("POSITION", struct.pack(f"<{3 * count}f", *positions), 5126, "VEC3", count),
        ("NORMAL", struct.pack(f"<{3 * count}f", *normals), 5126, "VEC3", count),
        ("TEXCOORD_0", struct.pack(f"<{2 * count}f", *uvs), 5126, "VEC2", count),
        ("COLOR_0", struct.pack(f"<{4 * count}B", *colours), 5121, "VEC4", count),
        ("indices", struct.pack(f"<{len(triangles)}H", *triangles), 5123, "SCALAR", len(triangles)),
    ]
    binary, views, accessors = b"", [], []
    for name, data, component, kind, length in parts:
        views.append({"buffer": 0, "byteOffset": len(binary), "byteLength": len(data)})
        accessor = {"bufferView": len(views) - 1, "componentType": component, "type": kind, "count": length}
        if name == "POSITION":
            accessor["min"] = [min(positions[axis::3]) for axis in range(3)]
            accessor["max"] = [max(positions[axis::3]) for axis in range(3)]
        if name == "COLOR_0":
            accessor["normalized"] = True
        accessors.append(accessor)
        binary += data + b"\0" * (-len(data) % 4)
    document = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0, "name": "patch"}],
        "meshes": [{
            "name": "patch",
            "primitives": [{
                "attributes": {name: i for i, (name, *_) in enumerate(parts[:-1])},
                "indices": len(parts) - 1,
                "material": 0,
            }],
        }],
        # Named, for gltfpack to keep it apart.
        "materials": [{"name": "paint", "pbrMetallicRoughness": {"metallicFactor": 0.0}}],
        "buffers": [{"byteLength": len(binary)}],
        "bufferViews": views,
        "accessors": accessors,
    }
    text = json.dumps(document, separators=(",", ":")).encode()
    text += b" " * (-len(text) % 4)
    chunks = [(text, b"JSON"), (binary, b"BIN\0")]
    body = b"".join(struct.pack("<I", len(data)) + kind + data for data, kind in chunks)
    path.write_bytes(b"glTF" + struct.pack("<II", 2, 12 + len(body)) + body)


def pack_geometry(tools, plain):
    def run(name, *words):
        target = HERE / f"{name}.glb"
        words = [str({"IN": plain, "OUT": target}.get(word, word)) for word in words]
        subprocess.run([str(tools / words[0]), *words[1:]], check=True, stdout=subprocess.DEVNULL)

    run("draco", "gltf-transform", "draco", "IN", "OUT", "--method", "edgebreaker")
    run("draco-sequential", "gltf-transform", "draco", "IN", "OUT", "--method", "sequential")
    # Filters: octahedral, and exponential of what stays real; and those of the newer extension, with its version 1.
    run("meshopt", "gltf-transform", "meshopt", "IN", "OUT", "--level", "high")
    run("meshopt-gltfpack", "gltfpack", "-i", "IN", "-o", "OUT", "-cc", "-kv", "-ce", "ext", "-vn", "10")
    run("meshopt-khr", "gltfpack", "-i", "IN", "-o", "OUT", "-cz", "-kv", "-ce", "khr", "-vn", "10")
    run("meshopt-real", "gltfpack", "-i", "IN", "-o", "OUT", "-c", "-kv", "-ce", "khr", "-noq")
    run("meshopt-fallback", "gltfpack", "-i", "IN", "-o", "OUT", "-cf", "-kv", "-ce", "ext", "-vn", "10")
    # What stands in for readers that cannot unpack; it must not be missed.
    (HERE / "meshopt-fallback.fallback.bin").unlink()


def pack_pictures():
    import alktx2

    width, height = 20, 12
    picture = bytearray()
    for y in range(height):
        for x in range(width):
            picture += bytes([255 * x // width, 255 * y // height, 255 * (x + y) // (width + height), 90 + 8 * x])
    for name, words in {
        "etc1s": {"codec": "etc1s", "mipmaps": True, "force_alpha": True},
        "uastc": {"codec": "uastc", "force_alpha": True},
        "uastc-zstd": {"codec": "uastc", "mipmaps": True, "zstd_supercompression_level": 18, "force_alpha": True},
        "etc1s-linear": {"codec": "etc1s", "srgb": False, "linear": True, "check_for_alpha": False},
    }.items():
        packed = alktx2.encode_raw_rgba_to_ktx2(bytes(picture), width, height, "linear" not in name, **words)
        (HERE / f"{name}.ktx2").write_bytes(packed)
        png, _ = alktx2.decode_ktx2_to_bytes(packed)
        (HERE / f"{name}.png").write_bytes(png)


if __name__ == "__main__":
    write_plain(HERE / "plain.glb")
    pack_geometry(Path(sys.argv[1]), HERE / "plain.glb")
    pack_pictures()
