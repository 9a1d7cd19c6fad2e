#!/usr/bin/env python3
"""Writes the geometry and the images that scenes of the suite share, beside this script. Units are metres.

    stage.obj     a floor (material "floor"), a wall behind it ("wall"), a lamp above that faces down ("lamp")
    balls.obj     two balls of radius 0.5 side by side on the floor ("left", "right"), without normals
    uv-ball.obj   one ball of radius 0.5 with normals and UVs ("ball")
    block.obj     a block in the middle of the floor ("block")
    panels.obj    three panels side by side ("panel-1" to "panel-3") and a floor ("tiles"), with UVs from -0.6 to 1.8;
                  panels.mtl gives the second one holes
    lamps.obj     eighty small lamps over the floor that face down ("lamps"), and one more ("bright")
    heap.gltf     two hundred instances of a ball of 5120 triangles ("heap")
    nested.obj    two balls ("left", "right"), each with a ball of radius 0.3 inside it ("left-core", "right-core")
    wedge.obj     a square tower with an edge towards −z, around the suite's camera: the right side at that edge
                  is "ground", all others are "polished"
    panels.gltf   the panels and the floor with texture transforms and wrap modes of their own
    mirrored.gltf a panel ("bumpy") and its mirror image, a panel with holes by its second UVs ("masked"), a floor
                  ("tiles") and a lamp above that faces down ("lamp")
    line-*.csv    responses at one wavelength, 1 nm wide
    venice.hdr    no work of this script: its header says where it is from
    colours.png   8 × 8 texels, the corners of the RGB cube among them; holes.png, a mask, and mask.png with one in its
                  alpha, of 16 bits; bumps.png, a normal map
"""

import base64
import math
import random
import struct
import sys
import zlib
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parents[2] / "scenes"))
from gltf_file import GltfFile, one_line_each  # noqa: E402


def icosphere(levels):
    """Vertices on the unit sphere and triangles, counter-clockwise from outside."""
    g = (1 + 5**0.5) / 2
    points = [(-1, g, 0), (1, g, 0), (-1, -g, 0), (1, -g, 0), (0, -1, g), (0, 1, g)]
    points += [(0, -1, -g), (0, 1, -g), (g, 0, -1), (g, 0, 1), (-g, 0, -1), (-g, 0, 1)]
    faces = [(0, 11, 5), (0, 5, 1), (0, 1, 7), (0, 7, 10), (0, 10, 11), (1, 5, 9), (5, 11, 4), (11, 10, 2)]
    faces += [(10, 7, 6), (7, 1, 8), (3, 9, 4), (3, 4, 2), (3, 2, 6), (3, 6, 8), (3, 8, 9), (4, 9, 5)]
    faces += [(2, 4, 11), (6, 2, 10), (8, 6, 7), (9, 8, 1)]

    def unit(p):
        length = math.hypot(*p)
        return tuple(c / length for c in p)

    points = [unit(p) for p in points]
    for _ in range(levels):
        middles, finer = {}, []

        def middle(a, b):
            key = (min(a, b), max(a, b))
            if key not in middles:
                middles[key] = len(points)
                points.append(unit(tuple((x + y) / 2 for x, y in zip(points[a], points[b]))))
            return middles[key]

        for a, b, c in faces:
            ab, bc, ca = middle(a, b), middle(b, c), middle(c, a)
            finer += [(a, ab, ca), (b, bc, ab), (c, ca, bc), (ab, bc, ca)]
        faces = finer
    return points, faces


class Obj:
    """Lines of an OBJ file."""

    def __init__(self):
        self.lines, self.vertices = [], 0

    def add(self, material, points, faces):
        self.lines.append(f"usemtl {material}")
        self.lines += ["v " + " ".join(f"{c:.6f}" for c in p) for p in points]
        self.lines += ["f " + " ".join(str(i + 1 + self.vertices) for i in f) for f in faces]
        self.vertices += len(points)

    def write(self, name):
        (HERE / name).write_text("# Written by make.py.\n" + "\n".join(self.lines) + "\n", encoding="utf-8")


def quad(*corners):
    return corners, [(0, 1, 2, 3)]


def write_png(name, rows, bits=8):
    """Rows of RGB or RGBA."""

    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    data = b"".join(b"\0" + b"".join(c.to_bytes(bits // 8) for pixel in row for c in pixel) for row in rows)
    header = struct.pack(">IIBBBBB", len(rows[0]), len(rows), bits, {3: 2, 4: 6}[len(rows[0][0])], 0, 0, 0)
    png = b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(data, 9)) + chunk(b"IEND", b"")
    (HERE / name).write_bytes(png)


def pictures():
    dice = random.Random(3)
    corners = [(r, g, b) for r in (0, 255) for g in (0, 255) for b in (0, 255)]
    others = [tuple(dice.randrange(256) for _ in range(3)) for _ in range(48)]
    texels = corners * 2 + others
    dice.shuffle(texels)
    write_png("colours.png", [texels[8 * j : 8 * j + 8] for j in range(8)])
    write_png("holes.png", [[(dice.choice((0, 90, 255)),) * 3 for _ in range(8)] for _ in range(8)])

    def bump(i, j):
        x, y = 0.2 * math.sin(2 * math.pi * i / 16), 0.2 * math.cos(2 * math.pi * (i + 2 * j) / 16)
        z = math.sqrt(1 - x * x - y * y)
        return tuple(round(127.5 * (c + 1)) for c in (x, y, z))

    opacities = [[dice.choice((0, 90, 160, 255)) * 257 for _ in range(8)] for _ in range(8)]
    write_png("mask.png", [[(51400, 30840, 15420, alpha) for alpha in row] for row in opacities], bits=16)
    write_png("bumps.png", [[bump(i, j) for i in range(16)] for j in range(16)])


def textured(name, quads):
    """An OBJ file of quads (material, corners, UVs)."""
    lines = ["# Written by make.py.", "mtllib panels.mtl"]
    for n, (material, corners, uvs) in enumerate(quads):
        lines.append(f"usemtl {material}")
        lines += ["v " + " ".join(f"{c:.6f}" for c in p) for p in corners]
        lines += [f"vt {u:.6f} {v:.6f}" for u, v in uvs]
        lines.append("f " + " ".join(f"{4 * n + k}/{4 * n + k}" for k in (1, 2, 3, 4)))
    (HERE / name).write_text("\n".join(lines) + "\n", encoding="utf-8")


def panels():
    low, high = -0.6, 1.8
    uvs = ((low, low), (high, low), (high, high), (low, high))
    quads = [("tiles", ((-2, 0, 2), (2, 0, 2), (2, 0, -2), (-2, 0, -2)), uvs)]
    for n, x in enumerate((-1.1, 0.0, 1.1)):
        corners = ((x - 0.5, 0.1, 0.0), (x + 0.5, 0.1, 0.0), (x + 0.5, 1.4, -0.3), (x - 0.5, 1.4, -0.3))
        quads.append((f"panel-{n + 1}", corners, uvs))
    textured("panels.obj", quads)
    materials = ["# Written by make.py."]
    for name in ("tiles", "panel-1", "panel-2", "panel-3"):
        materials += [f"newmtl {name}", "Kd 0.6 0.5 0.4"]
        if name == "panel-2":
            materials.append("map_d holes.png")
    (HERE / "panels.mtl").write_text("\n".join(materials) + "\n", encoding="utf-8")


def transformed():
    """panels.gltf: what panels.obj shows, each panel with another KHR_texture_transform and other wrap modes."""
    low, high = -0.6, 1.8
    repeat, mirror, clamp, nearest = 10497, 33648, 33071, 9728
    quads = [("tiles", ((-2, 0, 2), (2, 0, 2), (2, 0, -2), (-2, 0, -2)), repeat, (0.1, 0.7), -0.3, (2.0, 1.4))]
    for name, x, wrap, offset, rotation, scale in (
        ("panel-1", -1.1, repeat, (0.35, -0.2), 0.5, (1.3, 0.8)),
        ("panel-2", 0.0, mirror, (-0.15, 0.4), -0.9, (0.7, 1.2)),
        ("panel-3", 1.1, clamp, (0.3, 0.1), 2.1, (0.6, 0.9)),
    ):
        corners = ((x - 0.5, 0.1, 0.0), (x + 0.5, 0.1, 0.0), (x + 0.5, 1.4, -0.3), (x - 0.5, 1.4, -0.3))
        quads.append((name, corners, wrap, offset, rotation, scale))
    # v points down in glTF.
    uvs = struct.pack("<8f", low, high, high, high, high, low, low, low)
    indices = struct.pack("<6H", 0, 1, 2, 0, 2, 3)
    data = indices + uvs + b"".join(struct.pack("<12f", *sum(q[1], ())) for q in quads)
    views = [(0, 12), (12, 32)] + [(44 + 48 * n, 48) for n in range(len(quads))]
    accessors = [{"bufferView": 0, "componentType": 5123, "count": 6, "type": "SCALAR"}]
    accessors.append({"bufferView": 1, "componentType": 5126, "count": 4, "type": "VEC2"})
    for n, (_, corners, *_) in enumerate(quads):
        bounds = {"min": [min(axis) for axis in zip(*corners)], "max": [max(axis) for axis in zip(*corners)]}
        accessors.append({"bufferView": n + 2, "componentType": 5126, "count": 4, "type": "VEC3"} | bounds)

    def material(n, name, offset, rotation, scale):
        transform = {"offset": offset, "rotation": rotation, "scale": scale}
        texture = {"index": n, "extensions": {"KHR_texture_transform": transform}}
        pbr = {"baseColorTexture": texture, "metallicFactor": 0.0, "roughnessFactor": 0.6}
        return {"name": name, "doubleSided": True, "pbrMetallicRoughness": pbr}

    document = {
        "asset": {"version": "2.0", "generator": "make.py"},
        "extensionsUsed": ["KHR_texture_transform"],
        "scene": 0,
        "scenes": [{"nodes": list(range(len(quads)))}],
        "nodes": [{"name": q[0], "mesh": n} for n, q in enumerate(quads)],
        "meshes": [
            {"primitives": [{"attributes": {"POSITION": n + 2, "TEXCOORD_0": 1}, "indices": 0, "material": n}]}
            for n in range(len(quads))
        ],
        "materials": [material(n, q[0], *q[3:]) for n, q in enumerate(quads)],
        "textures": [{"source": 0, "sampler": n} for n in range(len(quads))],
        "samplers": [{"magFilter": nearest, "minFilter": nearest, "wrapS": q[2], "wrapT": q[2]} for q in quads],
        "images": [{"uri": "colours.png"}],
        "accessors": accessors,
        "bufferViews": [{"buffer": 0, "byteOffset": offset, "byteLength": length} for offset, length in views],
        "buffers": [{
            "uri": "data:application/octet-stream;base64," + base64.b64encode(data).decode(), "byteLength": len(data)
        }],
    }
    (HERE / "panels.gltf").write_text(one_line_each(document) + "\n", encoding="utf-8")


def mirrored():
    panel = ((-0.5, 0.1, 0.0), (0.5, 0.1, 0.0), (0.5, 1.4, -0.3), (-0.5, 1.4, -0.3))
    floor = ((-2, 0, 2), (2, 0, 2), (2, 0, -2), (-2, 0, -2))
    lamp = ((-0.6, 2.4, -0.6), (0.6, 2.4, -0.6), (0.6, 2.4, 0.6), (-0.6, 2.4, 0.6))
    # v points down in glTF.
    uvs = [(-0.6, 1.8, 1.8, 1.8, 1.8, -0.6, -0.6, -0.6), (0.2, 0.9, 1.1, 0.7, 0.8, 0.1, 0.0, 0.3)]
    arrays = [struct.pack("<6H", 0, 1, 2, 0, 2, 3), *(struct.pack("<8f", *pairs) for pairs in uvs)]
    arrays += [struct.pack("<12f", *sum(corners, ())) for corners in (panel, floor, lamp)]
    accessors = [{"componentType": 5123, "count": 6, "type": "SCALAR"}]
    accessors += [{"componentType": 5126, "count": 4, "type": "VEC2"} for _ in uvs]
    for corners in (panel, floor, lamp):
        bounds = {"min": [min(axis) for axis in zip(*corners)], "max": [max(axis) for axis in zip(*corners)]}
        accessors.append({"componentType": 5126, "count": 4, "type": "VEC3"} | bounds)
    offsets = [sum(map(len, arrays[:n])) for n in range(len(arrays))]
    data = b"".join(arrays)

    def mesh(positions, material):
        attributes = {"POSITION": positions, "TEXCOORD_0": 1, "TEXCOORD_1": 2}
        return {"primitives": [{"attributes": attributes, "indices": 0, "material": material}]}

    second = {"texCoord": 1, "extensions": {"KHR_texture_transform": {"rotation": 0.4, "scale": [1.5, 0.9]}}}
    factors = {"baseColorFactor": [0.9, 0.7, 0.8, 1.0], "metallicFactor": 0.0, "roughnessFactor": 0.6}
    masked = {
        "name": "masked",
        "alphaMode": "MASK",
        "normalTexture": {"index": 1, "scale": 0.5} | second,
        "pbrMetallicRoughness": {"baseColorTexture": {"index": 0} | second} | factors,
    }
    document = {
        "asset": {"version": "2.0", "generator": "make.py"},
        "extensionsUsed": ["KHR_texture_transform"],
        "scene": 0,
        "scenes": [{"nodes": [0, 1, 2, 3, 4]}],
        "nodes": [
            {"name": "bumpy", "mesh": 0, "translation": [-1.1, 0, 0]},
            {"name": "mirrored", "mesh": 0, "scale": [-1, 1, 1]},
            {"name": "masked", "mesh": 1, "translation": [1.1, 0, 0]},
            {"name": "tiles", "mesh": 2},
            {"name": "lamp", "mesh": 3},
        ],
        "meshes": [mesh(3, 0), mesh(3, 1), mesh(4, 2), mesh(5, 3)],
        "materials": [{"name": "bumpy"}, masked, {"name": "tiles"}, {"name": "lamp"}],
        "textures": [{"source": 0, "sampler": 0}, {"source": 1, "sampler": 1}],
        "samplers": [{"magFilter": 9728, "minFilter": 9728, "wrapS": 33648, "wrapT": 33648}, {"magFilter": 9729}],
        "images": [{"uri": "mask.png"}, {"uri": "bumps.png"}],
        "accessors": [{"bufferView": n} | accessor for n, accessor in enumerate(accessors)],
        "bufferViews": [{"buffer": 0, "byteOffset": o, "byteLength": len(a)} for o, a in zip(offsets, arrays)],
        "buffers": [{
            "uri": "data:application/octet-stream;base64," + base64.b64encode(data).decode(), "byteLength": len(data)
        }],
    }
    (HERE / "mirrored.gltf").write_text(one_line_each(document) + "\n", encoding="utf-8")


def lamps():
    obj, dice = Obj(), random.Random(5)
    for n in range(81):
        x, z, y, half = dice.uniform(-1.8, 1.8), dice.uniform(-1.8, 1.0), dice.uniform(0.3, 2.2), 0.03
        if n == 0:
            # Out of the image: its own pixels would outweigh all others.
            y, z = 2.4, 0.8
        corners = ((x - half, y, z - half), (x + half, y, z - half), (x + half, y, z + half), (x - half, y, z + half))
        obj.add("bright" if n == 0 else "lamps", *quad(*corners))
    obj.write("lamps.obj")


def heap():
    file, dice = GltfFile(), random.Random(7)
    file.material("heap", (0.5, 0.5, 0.5))
    points, faces = icosphere(4)
    file.shape("ball", points, points, faces)
    for n in range(200):
        place = dice.uniform(-1.5, 1.5), dice.uniform(0.1, 1.5), dice.uniform(-1.8, 0.8)
        file.place(f"ball {n}", "ball", "heap", place, dice.uniform(0.05, 0.2))
    file.write(HERE / "heap.gltf")


def main():
    pictures()
    panels()
    transformed()
    mirrored()
    lamps()
    heap()
    stage = Obj()
    stage.add("floor", *quad((-2, 0, 2), (2, 0, 2), (2, 0, -2), (-2, 0, -2)))
    stage.add("wall", *quad((-2, 0, -2), (2, 0, -2), (2, 3, -2), (-2, 3, -2)))
    stage.add("lamp", *quad((-1.5, 2.5, -1.5), (1.5, 2.5, -1.5), (1.5, 2.5, 1.5), (-1.5, 2.5, 1.5)))
    stage.write("stage.obj")

    balls = Obj()
    points, faces = icosphere(3)
    for name, x in (("left", -0.6), ("right", 0.6)):
        balls.add(name, [(0.5 * a + x, 0.5 * b + 0.5, 0.5 * c) for a, b, c in points], faces)
    balls.write("balls.obj")

    rows, columns = 16, 32
    lines = ["# Written by make.py.", "usemtl ball"]
    for j in range(rows + 1):
        for i in range(columns + 1):
            t, p = math.pi * j / rows, 2 * math.pi * i / columns
            n = math.sin(t) * math.cos(p), math.cos(t), -math.sin(t) * math.sin(p)
            lines.append("v " + " ".join(f"{0.5 * c + o:.6f}" for c, o in zip(n, (0, 0.5, 0))))
            lines.append("vn " + " ".join(f"{c:.6f}" for c in n))
            lines.append(f"vt {i / columns:.6f} {1 - j / rows:.6f}")
    for j in range(rows):
        for i in range(columns):
            a, b = j * (columns + 1) + i + 1, (j + 1) * (columns + 1) + i + 1
            corners = ([a, b, b + 1] if j < rows - 1 else [], [a, b + 1, a + 1] if j > 0 else [])
            for triangle in corners if j < rows - 1 else ([a, b + 1, a + 1],):
                if triangle:
                    lines.append("f " + " ".join(f"{k}/{k}/{k}" for k in triangle))
    (HERE / "uv-ball.obj").write_text("\n".join(lines) + "\n", encoding="utf-8")

    nested = Obj()
    for name, x in (("left", -0.6), ("right", 0.6)):
        for part, radius in (("", 0.5), ("-core", 0.3)):
            ball = [(radius * a + x, radius * b + 0.5, radius * c) for a, b, c in points]
            nested.add(name + part, ball, faces)
    nested.write("nested.obj")

    wedge = Obj()
    # Corners around the camera at (0, 1.2, 3.6), the first one ahead, then to the right.
    around = [(0.0, 2.6), (1.0, 3.6), (0.0, 4.6), (-1.0, 3.6)]
    for name, (a, b) in zip(("ground", "polished", "polished", "polished"), zip(around, around[1:] + around[:1])):
        low, high = [[(x, y, z) for x, z in (a, b)] for y in (0.2, 2.2)]
        wedge.add(name, *quad(low[1], low[0], high[0], high[1]))
    for y, order in ((0.2, 1), (2.2, -1)):
        wedge.add("polished", *quad(*[(x, y, z) for x, z in around[::order]]))
    wedge.write("wedge.obj")

    for nm in (450, 540, 620):
        text = f"# A response to {nm} nm alone. Written by make.py.\nwavelength_nm,value\n"
        (HERE / f"line-{nm}.csv").write_text(text + f"{nm - 1},0\n{nm},0.5\n{nm + 1},0\n", encoding="utf-8")

    block = Obj()
    (x0, x1), (y0, y1), (z0, z1) = (-0.3, 0.3), (0.0, 1.0), (-0.3, 0.3)
    block.add("block", *quad((x0, y0, z1), (x1, y0, z1), (x1, y1, z1), (x0, y1, z1)))
    block.add("block", *quad((x1, y0, z0), (x0, y0, z0), (x0, y1, z0), (x1, y1, z0)))
    block.add("block", *quad((x1, y0, z1), (x1, y0, z0), (x1, y1, z0), (x1, y1, z1)))
    block.add("block", *quad((x0, y0, z0), (x0, y0, z1), (x0, y1, z1), (x0, y1, z0)))
    block.add("block", *quad((x0, y1, z1), (x1, y1, z1), (x1, y1, z0), (x0, y1, z0)))
    block.write("block.obj")


if __name__ == "__main__":
    main()
