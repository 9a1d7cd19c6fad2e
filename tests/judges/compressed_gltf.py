#!/usr/bin/env python3
"""Packs a glTF file in every way that is in use, by the tools that people use, and compares what photosite sees.

    compressed_gltf.py target/release/photosite FOLDER

The scene is a wavy patch with an image on it. FOLDER gets the packed files and the renders. Positions and UVs of the truth
must be those of the plain file within what the bits that are kept allow; the image must have the same levels. Exit status 0
where all is well, 1 otherwise. Needs: npm, and pip install -r requirements-compressed.txt.
"""

import json
import math
import struct
import subprocess
import sys
import zlib
from pathlib import Path

import alktx2
import numpy
import OpenEXR

TOOLS = ["@gltf-transform/cli@4.5.1", "gltfpack@1.3.0"]
SIDE, PICTURE = 40, 64
RESOLUTION = (160, 120)
complaints = []


def png(pixels):
    height, width, channels = pixels.shape
    chunk = lambda kind, data: struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
    rows = b"".join(b"\0" + row.tobytes() for row in pixels)
    header = struct.pack(">IIBBBBB", width, height, 8, {3: 2, 4: 6}[channels], 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b"")


def colours():
    y, x = numpy.mgrid[:PICTURE, :PICTURE] / PICTURE
    rgb = [0.5 + 0.3 * numpy.sin(6 * x), 0.4 + 0.3 * numpy.cos(5 * y), 0.3 + 0.4 * x * y, numpy.ones_like(x)]
    return (255 * numpy.stack(rgb, axis=-1)).round().astype(numpy.uint8)


def write_plain(folder):
    """A wavy patch of 2 m by 2 m with UVs, an image, and a camera above it."""
    at = numpy.linspace(-1, 1, SIDE)
    x, z = [grid.ravel() for grid in numpy.meshgrid(at, at)]
    slope_x, slope_z = 0.6 * numpy.cos(3 * x) * numpy.cos(2 * z), -0.4 * numpy.sin(3 * x) * numpy.sin(2 * z)
    positions = numpy.stack([x, 0.2 * numpy.sin(3 * x) * numpy.cos(2 * z), z], axis=1)
    normals = numpy.stack([-slope_x, numpy.ones_like(x), -slope_z], axis=1)
    normals /= numpy.linalg.norm(normals, axis=1, keepdims=True)
    uvs = numpy.stack([(x + 1) / 2, (z + 1) / 2], axis=1)
    i, j = [grid.ravel() for grid in numpy.meshgrid(numpy.arange(SIDE - 1), numpy.arange(SIDE - 1))]
    a = j * SIDE + i
    triangles = numpy.concatenate([numpy.stack(c, axis=1) for c in ((a, a + SIDE, a + 1), (a + 1, a + SIDE, a + SIDE + 1))])
    parts = [(positions, 5126, "VEC3"), (normals, 5126, "VEC3"), (uvs, 5126, "VEC2"), (triangles, 5123, "SCALAR")]
    binary, views, accessors = b"", [], []
    for values, component, kind in parts:
        data = values.astype("<f4" if component == 5126 else "<u2").tobytes()
        views.append({"buffer": 0, "byteOffset": len(binary), "byteLength": len(data)})
        count = values.size if kind == "SCALAR" else len(values)
        accessors.append({"bufferView": len(views) - 1, "componentType": component, "type": kind, "count": count})
        binary += data + b"\0" * (-len(data) % 4)
    bounds = positions.astype("<f4")
    accessors[0] |= {"min": bounds.min(axis=0).tolist(), "max": bounds.max(axis=0).tolist()}
    (folder / "plain.bin").write_bytes(binary)
    (folder / "colours.png").write_bytes(png(colours()))
    half = math.pi / 8
    document = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0, 1]}],
        "nodes": [
            {"name": "patch", "mesh": 0},
            # Looks down at 45 degrees.
            {"name": "camera", "camera": 0, "translation": [0, 2, 2], "rotation": [-math.sin(half), 0, 0, math.cos(half)]},
        ],
        "cameras": [{"type": "perspective", "perspective": {"yfov": 0.7, "znear": 0.1}}],
        "meshes": [{"name": "patch", "primitives": [
            {"attributes": {"POSITION": 0, "NORMAL": 1, "TEXCOORD_0": 2}, "indices": 3, "material": 0}]}],
        "materials": [{"name": "paint", "pbrMetallicRoughness": {"baseColorTexture": {"index": 0}, "metallicFactor": 0}}],
        "textures": [{"source": 0}],
        "images": [{"uri": "colours.png"}],
        "buffers": [{"uri": "plain.bin", "byteLength": len(binary)}],
        "bufferViews": views,
        "accessors": accessors,
    }
    (folder / "plain.gltf").write_text(json.dumps(document))
    return document


def write_pictures(folder, document):
    """The same with its image as KTX2, which Basis Universal makes."""
    pixels = colours()
    for name, words in {
        "etc1s": {"codec": "etc1s", "quality": 100},
        "uastc": {"codec": "uastc"},
        "uastc-zstd": {"codec": "uastc", "zstd_supercompression_level": 10, "mipmaps": True},
    }.items():
        packed = alktx2.encode_raw_rgba_to_ktx2(pixels.tobytes(), PICTURE, PICTURE, False, **words)
        (folder / f"{name}.ktx2").write_bytes(packed)
        texture = {"extensions": {"KHR_texture_basisu": {"source": 0}}}
        used = {name: ["KHR_texture_basisu"] for name in ("extensionsUsed", "extensionsRequired")}
        images = [{"uri": f"{name}.ktx2", "mimeType": "image/ktx2"}]
        (folder / f"{name}.gltf").write_text(json.dumps({**document, **used, "textures": [texture], "images": images}))
        yield f"{name}.gltf"


def write_geometry(folder):
    subprocess.run(["npm", "install", "--silent", "--no-fund", "--no-audit", *TOOLS], cwd=folder, check=True)
    tools = folder / "node_modules/.bin"
    for name, words in {
        "draco": ["gltf-transform", "draco", "plain.gltf", "draco.glb"],
        "draco-sequential": ["gltf-transform", "draco", "plain.gltf", "draco-sequential.glb", "--method", "sequential"],
        "meshopt": ["gltf-transform", "meshopt", "plain.gltf", "meshopt.glb"],
        "gltfpack": ["gltfpack", "-i", "plain.gltf", "-o", "gltfpack.glb", "-cc", "-kn"],
        "gltfpack-khr": ["gltfpack", "-i", "plain.gltf", "-o", "gltfpack-khr.glb", "-cz", "-kn", "-ce", "khr"],
        "gltfpack-fallback": ["gltfpack", "-i", "plain.gltf", "-o", "gltfpack-fallback.glb", "-cf", "-kn"],
    }.items():
        subprocess.run([tools / words[0], *words[1:]], cwd=folder, check=True, stdout=subprocess.DEVNULL)
        yield f"{name}.glb"


def render(photosite, folder, name):
    (folder / f"{name}.toml").write_text(
        f"""[scene]
geometry = ["{name}"]
environment = {{ illuminant = "D65", illuminance_lux = 500 }}
[camera]
gltf_camera = "camera"
[sensor]
resolution_px = [{RESOLUTION[0]}, {RESOLUTION[1]}]
[render]
samples_per_pixel = 64
[exposure]
time_s = 0.01
[output]
electrons = true
truth = ["position", "uv"]
"""
    )
    output = folder / f"render-{name}"
    subprocess.run([photosite, "render", folder / f"{name}.toml", "-o", output, "--quiet", "--force"], check=True)
    report = json.loads((output / "capture.json").read_text())
    unexpected = [warning for warning in report["warnings"] if "extension" in warning or "accessors" in warning]
    if unexpected:
        complaints.append(f"{name}: {unexpected}")
    return channels(output / "truth.exr"), channels(output / "electrons.exr")


def channels(path):
    with OpenEXR.File(str(path), separate_channels=True) as file:
        return {name: channel.pixels.astype(float) for name, channel in file.parts[0].channels.items()}


def compare(name, plain, packed, position_step, uv_step, uv_scale=1.0):
    (truth, light), (packed_truth, packed_light) = plain, packed
    for prefix, step, scale in (("position", position_step, 1.0), ("uv", uv_step, uv_scale)):
        layers = [layer for layer in truth if layer.startswith(prefix)]
        if not layers:
            complaints.append(f"{name}: there is no truth {prefix}")
        for layer in layers:
            difference = numpy.abs(truth[layer] - scale * packed_truth[layer])
            far = int((difference > step).sum() + (numpy.isnan(truth[layer]) != numpy.isnan(packed_truth[layer])).sum())
            worst = numpy.nanquantile(difference, 0.98)
            print(f"{name}: {layer} differs by {worst:.1e} at most in 98 % of all pixels, by more than {step:.1e} in {far}")
            # At the edge of the patch a few rays may miss it.
            if far > sum(RESOLUTION) / 10:
                complaints.append(f"{name}: {layer} differs by more than {step} in {far} pixels")
    for channel in (channel for channel in light if not channel.startswith("variance")):
        ratio = packed_light[channel].mean() / light[channel].mean()
        print(f"{name}: {channel} has {ratio:.4f} of the electrons")
        # ETC1S is lossy by design: a hundredth of the mean.
        if abs(ratio - 1) > 0.01:
            complaints.append(f"{name}: {channel} has {ratio} of the electrons")


def main():
    photosite, folder = Path(sys.argv[1]).resolve(), Path(sys.argv[2]).resolve()
    folder.mkdir(parents=True, exist_ok=True)
    document = write_plain(folder)
    plain = render(photosite, folder, "plain.gltf")
    for name in write_pictures(folder, document):
        compare(name, plain, render(photosite, folder, name), 1e-6, 1e-6)
    for name in write_geometry(folder):
        # 2 m are cut into 2^14 steps, UVs into 2^12. What a ray meets moves along the surface by as much as it does up,
        # seen at 45 degrees, and up by a step; four of these leave room for that.
        # The truth has UVs as the mesh has them; gltfpack's take 12 of 16 bits, which a transform of the texture undoes.
        uv_scale = 65535 / 4095 if name.startswith("gltfpack") else 1.0
        compare(name, plain, render(photosite, folder, name), 4 * 2 / 2**14, 4 / 2**12, uv_scale)
    for complaint in complaints:
        print(f"judge: {complaint}", file=sys.stderr)
    sys.exit(1 if complaints else 0)


if __name__ == "__main__":
    main()
