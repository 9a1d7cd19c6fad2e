"""Writes the glTF files of this folder, one for each feature that photosite reads: a ball on a floor under a lamp.

Run it again after changing it: python3 tests/gltf/make.py. All files share shapes.bin and pixels.png. Needs Python only.
"""

import json
import math
import struct
import zlib
from pathlib import Path

HERE = Path(__file__).parent
FLOAT, BYTE, USHORT, UBYTE = 5126, 5120, 5123, 5121


class Data:
    """The binary data that all files share."""

    def __init__(self):
        self.bytes, self.views, self.accessors, self.index = bytearray(), [], [], {}

    def view(self, data, target=None, stride=None):
        self.bytes += b"\0" * (-len(self.bytes) % 4)
        view = {"buffer": 0, "byteOffset": len(self.bytes), "byteLength": len(data)}
        if target:
            view["target"] = target
        if stride:
            view["byteStride"] = stride
        self.bytes += data
        self.views.append(view)
        return len(self.views) - 1

    def add(self, name, rows, kind="VEC3", component=FLOAT, target=34962, normalized=False, stride=None, extra=None):
        letter = {FLOAT: "f", BYTE: "b", USHORT: "H", UBYTE: "B"}[component]
        rows = [row if isinstance(row, (list, tuple)) else [row] for row in rows]
        packed = [struct.pack(f"<{len(row)}{letter}", *row) for row in rows]
        if stride:
            packed = [row.ljust(stride, b"\0") for row in packed]
        accessor = {"bufferView": self.view(b"".join(packed), target, stride)}
        accessor |= {"componentType": component, "count": len(rows), "type": kind}
        if normalized:
            accessor["normalized"] = True
        if name.startswith("position") or name == "time":
            accessor |= {
                "min": [min(column) for column in zip(*rows)],
                "max": [max(column) for column in zip(*rows)],
            }
        self.accessors.append(accessor | (extra or {}))
        self.index[name] = len(self.accessors) - 1


def f32(x):
    return struct.unpack("<f", struct.pack("<f", x))[0]


def sphere(bands=10):
    positions, uvs, triangles = [], [], []
    for band in range(bands + 1):
        for sector in range(2 * bands + 1):
            theta, phi = math.pi * band / bands, math.pi * sector / bands
            uvs.append((sector / (2 * bands), band / bands))
            positions.append(tuple(map(f32, (math.sin(theta) * math.cos(phi), math.cos(theta), -math.sin(theta) * math.sin(phi)))))
    row = 2 * bands + 1
    for band in range(bands):
        for sector in range(2 * bands):
            a, b = band * row + sector, (band + 1) * row + sector
            if band > 0:
                triangles += [a, b, a + 1]
            if band < bands - 1:
                triangles += [a + 1, b, b + 1]
    return positions, uvs, triangles


def png(width, height, pixels):
    """A PNG of 8-bit RGBA."""
    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
    rows = b"".join(b"\0" + bytes(value for x in range(width) for value in pixels(x, y)) for y in range(height))
    header = struct.pack(">IIBBBBB", width, height, 8, 6, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(rows, 9)) + chunk(b"IEND", b"")


data = Data()
positions, uvs, triangles = sphere()
count = len(positions)
data.add("position", positions)
data.add("normal", positions)
data.add("uv", uvs, "VEC2")
data.add("indices", triangles, "SCALAR", USHORT, 34963)
data.add("position floor", [(-3, 0, -3), (-3, 0, 3), (3, 0, 3), (3, 0, -3)])
data.add("normal floor", [(0, 1, 0)] * 4)
data.add("uv floor", [(0, 0), (0, 1), (1, 1), (1, 0)], "VEC2")
data.add("indices floor", [0, 1, 2, 0, 2, 3], "SCALAR", USHORT, 34963)
data.add("second uv", [(4 * u, 4 * v) for u, v in uvs], "VEC2")
data.add("colour", [(0.5 + 0.5 * x, 0.5 + 0.5 * y, 0.5 + 0.5 * z, 1.0) for x, y, z in positions], "VEC4")
data.add("tangent", [(math.sin(2 * math.pi * u) * -1, 0, -math.cos(2 * math.pi * u), 1) for u, _ in uvs], "VEC4")
data.add("position quantised", [[round(127 * c) for c in p] for p in positions], "VEC3", BYTE, normalized=True, stride=4)
data.add("position morph", [(0, 0.6 * max(y, 0.0), 0) for _, y, _ in positions])
data.add("joints", [(0, 1, 0, 0)] * count, "VEC4", UBYTE)
first = [f32(0.5 - 0.45 * y) for _, y, _ in positions]
data.add("weights", [(weight, 1 - weight, 0, 0) for weight in first], "VEC4")
identity = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]
data.add("binds", [identity, identity], "MAT4", target=None)
data.add("translations", [(-1, 0, 0), (0, 0.3, 0), (1, 0, 0)], target=None)
data.add("scales", [(0.4, 0.4, 0.4), (0.3, 0.6, 0.3), (0.4, 0.4, 0.4)], target=None)
data.add("strip", [0, 1, 3, 2], "SCALAR", USHORT, 34963)
# A sphere whose top is pushed in, as deviations from the sphere.
top = [i for i, (_, y, _) in enumerate(positions) if y > 0.8]
indices = data.view(struct.pack(f"<{len(top)}H", *top))
values = data.view(b"".join(struct.pack("<3f", positions[i][0], f32(positions[i][1] - 0.8), positions[i][2]) for i in top))
sparse = {"count": len(top), "indices": {"bufferView": indices, "componentType": USHORT}, "values": {"bufferView": values}}
moved = [(x, f32(y - 0.8), z) if y > 0.8 else (x, y, z) for x, y, z in positions]
bounds = {"min": [min(c) for c in zip(*moved)], "max": [max(c) for c in zip(*moved)]}
data.accessors.append(data.accessors[data.index["position"]] | bounds | {"sparse": sparse})
data.index["position sparse"] = len(data.accessors) - 1


def write(name, material=None, ball=None, extensions=(), nodes=None, document=None, picture=False):
    """One file. `material` is that of the ball, `ball` changes its primitive, `nodes` are in place of its node."""
    extensions = set(extensions)
    material = {"name": "ball"} | (material or {"pbrMetallicRoughness": {"metallicFactor": 0.0, "roughnessFactor": 0.5}})
    extensions |= set(material.get("extensions", {}))
    primitive = {"attributes": {"POSITION": "position", "NORMAL": "normal"}, "indices": "indices", "material": 0}
    if picture:
        primitive["attributes"]["TEXCOORD_0"] = "uv"
    primitive |= ball or {}
    nodes = nodes or [{"name": "ball", "mesh": 0, "translation": [0, 1, 0]}]
    floor = {"POSITION": "position floor", "NORMAL": "normal floor", "TEXCOORD_0": "uv floor"}
    floor = {"attributes": floor, "indices": "indices floor"}
    paint = {"baseColorFactor": [0.6, 0.3, 0.2, 1], "metallicFactor": 0, "roughnessFactor": 0.9}
    meshes = [
        {"name": "ball", "primitives": [primitive]},
        {"name": "floor", "primitives": [floor | {"material": 1}]},
        {"name": "lamp", "primitives": [floor | {"material": 2}]},
    ]
    lamp = {"name": "lamp", "emissiveFactor": [1, 1, 1], "pbrMetallicRoughness": {"baseColorFactor": [0, 0, 0, 1]}}
    lamp["extensions"] = {"KHR_materials_emissive_strength": {"emissiveStrength": 2000}}
    turned = {"name": "lamp", "mesh": 2, "translation": [1, 5, 1], "rotation": [1, 0, 0, 0], "scale": [0.3, 1, 0.3]}
    file = {
        "asset": {"version": "2.0", "generator": "make.py of this folder"},
        "scene": 0,
        "materials": [material, {"name": "floor", "pbrMetallicRoughness": paint}, lamp],
        "meshes": meshes,
        "nodes": nodes + [{"name": "floor", "mesh": 1}, turned],
    }
    if picture:
        file |= {"images": [{"uri": "pixels.png"}], "textures": [{"source": 0, "sampler": 0}]}
        file["samplers"] = [{"magFilter": 9728, "minFilter": 9728}]
    file |= document or {}
    roots = set(range(len(file["nodes"]))) - {child for node in file["nodes"] for child in node.get("children", [])}
    file["scenes"] = [{"nodes": sorted(roots)}]
    used = sorted(extensions | {"KHR_materials_emissive_strength"})
    file["extensionsUsed"] = used
    required = [name for name in used if name in ("KHR_mesh_quantization",)]
    if required:
        file["extensionsRequired"] = required

    # Only the data that this file uses, in its own order.
    accessors, views, seen_accessors, seen_views = [], [], {}, {}

    def view_of(i):
        if i not in seen_views:
            seen_views[i] = len(views)
            views.append(data.views[i])
        return seen_views[i]

    def accessor_of(name):
        if name not in seen_accessors:
            accessor = json.loads(json.dumps(data.accessors[data.index[name]]))
            accessor["bufferView"] = view_of(accessor["bufferView"])
            for part in ("indices", "values") if "sparse" in accessor else ():
                accessor["sparse"][part]["bufferView"] = view_of(accessor["sparse"][part]["bufferView"])
            seen_accessors[name] = len(accessors)
            accessors.append(accessor)
        return seen_accessors[name]

    def resolve(value):
        if isinstance(value, dict):
            return {key: resolve(item) for key, item in value.items()}
        if isinstance(value, list):
            return [resolve(item) for item in value]
        return value

    def named(table):
        return {key: accessor_of(name) if isinstance(name, str) else name for key, name in table.items()}

    for mesh in file["meshes"]:
        mesh["primitives"] = [dict(p) for p in mesh["primitives"]]
        for p in mesh["primitives"]:
            p["attributes"] = named(p["attributes"])
            if "targets" in p:
                p["targets"] = [named(target) for target in p["targets"]]
            if isinstance(p.get("indices"), str):
                p["indices"] = accessor_of(p["indices"])
    for animation in file.get("animations", []):
        animation["samplers"] = [named(sampler) for sampler in animation["samplers"]]
    for skin in file.get("skins", []):
        skin["inverseBindMatrices"] = accessor_of(skin["inverseBindMatrices"])
    for node in file["nodes"]:
        for extension in node.get("extensions", {}).values():
            extension["attributes"] = named(extension["attributes"])
    file |= {"accessors": accessors, "bufferViews": views}
    file["buffers"] = [{"uri": "shapes.bin", "byteLength": len(data.bytes)}]
    (HERE / f"{name}.gltf").write_text(json.dumps(file, indent=1) + "\n")


def pbr(colour=(0.8, 0.8, 0.8, 1), metallic=0.0, roughness=0.5, **more):
    return {"baseColorFactor": list(colour), "metallicFactor": metallic, "roughnessFactor": roughness} | more


def with_extension(name, table, base=None, **more):
    extensions = {f"KHR_materials_{name}": table} | more.pop("extensions", {})
    return {"pbrMetallicRoughness": base or pbr(), "extensions": extensions} | more


volume = {"thicknessFactor": 1, "attenuationColor": [0.2, 0.7, 0.3], "attenuationDistance": 1}
clear = {"KHR_materials_transmission": {"transmissionFactor": 1}}
write("plain")
write("metal", {"pbrMetallicRoughness": pbr((0.9, 0.6, 0.3, 1), 1.0, 0.3)})
write("ior", with_extension("ior", {"ior": 2.4}, pbr((0.1, 0.1, 0.1, 1), roughness=0.2)))
write("specular", with_extension("specular", {"specularFactor": 0.7, "specularColorFactor": [1, 0.2, 0.1]}, pbr((0, 0, 0, 1))))
write("transmission", with_extension("transmission", {"transmissionFactor": 0.8}, pbr((0.9, 0.5, 0.5, 1), roughness=0.2)))
write("volume", with_extension("volume", volume, pbr((1, 1, 1, 1), roughness=0), extensions=clear))
dispersion = {"KHR_materials_volume": volume, "KHR_materials_ior": {"ior": 1.7}} | clear
write("dispersion", with_extension("dispersion", {"dispersion": 1.0}, pbr((1, 1, 1, 1), roughness=0.2), extensions=dispersion))
write("clearcoat", with_extension("clearcoat", {"clearcoatFactor": 1, "clearcoatRoughnessFactor": 0.1}, pbr((0.8, 0.1, 0.1, 1))))
write("sheen", with_extension("sheen", {"sheenColorFactor": [0.2, 0.4, 0.9], "sheenRoughnessFactor": 0.5}, pbr((0.1, 0.1, 0.1, 1))))
grooves = {"anisotropyStrength": 0.8, "anisotropyRotation": 0.5}
attributes = {"POSITION": "position", "NORMAL": "normal", "TEXCOORD_0": "uv", "TANGENT": "tangent"}
write("anisotropy", with_extension("anisotropy", grooves, pbr(metallic=1, roughness=0.3)), {"attributes": attributes})
film = {"iridescenceFactor": 1, "iridescenceIor": 1.4, "iridescenceThicknessMaximum": 450}
write("iridescence", with_extension("iridescence", film, pbr((0.1, 0.1, 0.1, 1), metallic=1, roughness=0.2)))
leaf = {"diffuseTransmissionFactor": 0.6, "diffuseTransmissionColorFactor": [0.3, 0.9, 0.2]}
write("diffuse-transmission", with_extension("diffuse_transmission", leaf))
write("emissive-strength", with_extension("emissive_strength", {"emissiveStrength": 300}, emissiveFactor=[1, 0.5, 0.1]))
write("unlit", with_extension("unlit", {}, pbr((0.2, 0.6, 0.9, 1))))
glossy = {"diffuseFactor": [0.5, 0.1, 0.1, 1], "specularFactor": [0.3, 0.3, 0.5], "glossinessFactor": 0.7}
write("specular-glossiness", with_extension("pbrSpecularGlossiness", glossy))
texture = {"baseColorTexture": {"index": 0}}
write("texture", {"pbrMetallicRoughness": pbr(**texture)}, picture=True)
moved = {"index": 0, "extensions": {"KHR_texture_transform": {"scale": [3, 2], "offset": [0.1, 0.2], "rotation": 0.4}}}
write("texture-transform", {"pbrMetallicRoughness": pbr(baseColorTexture=moved)}, extensions=["KHR_texture_transform"], picture=True)
two = {"attributes": {"POSITION": "position", "NORMAL": "normal", "TEXCOORD_0": "uv", "TEXCOORD_1": "second uv"}}
second = {"pbrMetallicRoughness": pbr(**texture), "emissiveTexture": {"index": 0, "texCoord": 1}, "emissiveFactor": [1, 1, 1]}
second["extensions"] = {"KHR_materials_emissive_strength": {"emissiveStrength": 60}}
write("two-uv-sets", second, two, picture=True)
write("alpha-mask", {"pbrMetallicRoughness": pbr(**texture), "alphaMode": "MASK", "doubleSided": True}, picture=True)
write("alpha-blend", {"pbrMetallicRoughness": pbr((0.8, 0.8, 0.2, 0.4)), "alphaMode": "BLEND", "doubleSided": True})
write("vertex-colours", None, {"attributes": {"POSITION": "position", "NORMAL": "normal", "COLOR_0": "colour"}})
write("sparse-accessor", None, {"attributes": {"POSITION": "position sparse"}})
quantised = {"attributes": {"POSITION": "position quantised", "NORMAL": "normal"}}
write("quantised", None, quantised, ["KHR_mesh_quantization"])
gpu = {"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": "translations", "SCALE": "scales"}}}
node = {"name": "balls", "mesh": 0, "translation": [0, 0.6, 0], "extensions": gpu}
write("instancing", nodes=[node], extensions=["EXT_mesh_gpu_instancing"])
node = {"name": "ball", "mesh": 0, "translation": [0, 1, 0], "weights": [0.8]}
write("morph-target", None, {"targets": [{"POSITION": "position morph"}]}, nodes=[node])
skinned = {"attributes": {"POSITION": "position", "NORMAL": "normal", "JOINTS_0": "joints", "WEIGHTS_0": "weights"}}
bones = [
    {"name": "ball", "mesh": 0, "skin": 0},
    {"name": "hip", "translation": [0, 1, 0], "children": [2]},
    {"name": "head", "translation": [0.4, 0.2, 0], "scale": [0.7, 1.2, 0.7]},
]
write("skin", None, skinned, nodes=bones, document={"skins": [{"joints": [1, 2], "inverseBindMatrices": "binds"}]})
upright = [{"name": "screen", "mesh": 0, "translation": [0, 1, 0], "rotation": [0.707107, 0, 0, 0.707107], "scale": [0.3] * 3}]
flat = {"POSITION": "position floor", "NORMAL": "normal floor"}
write("strip", None, {"attributes": flat, "indices": "strip", "mode": 5}, nodes=upright)
variants = {"variants": [{"name": "night"}, {"name": "day"}]}
mapping = {"KHR_materials_variants": {"mappings": [{"variants": [0], "material": 1}, {"variants": [1], "material": 2}]}}
document = {"extensions": {"KHR_materials_variants": variants}}
write("variants", None, {"extensions": mapping}, ["KHR_materials_variants"], document=document)



def animation(*channels):
    """An animation "move" of channels (node, path, output)."""
    samplers = [{"input": "time", "output": output} for _, _, output in channels]
    targets = [{"node": node, "path": path} for node, path, _ in channels]
    channels = [{"sampler": i, "target": target} for i, target in enumerate(targets)]
    return {"animations": [{"name": "move", "samplers": samplers, "channels": channels}]}


data.add("time", [0, 1], "SCALAR", target=None)
data.add("way", [(-0.8, 1, 0), (0.8, 1, 0)], target=None)
data.add("growth", [(0.4, 1, 1), (1, 0.4, 1)], target=None)
data.add("turn", [(0, 0, 0, 1), (0, 0, math.sqrt(0.5), math.sqrt(0.5))], "VEC4", target=None)
data.add("amount", [0, 1], "SCALAR", target=None)
moving = animation((0, "translation", "way"), (0, "scale", "growth"), (0, "rotation", "turn"))
write("animation-node", document=moving)
node = {"name": "ball", "mesh": 0, "translation": [0, 1, 0], "weights": [0.8]}
morph = {"targets": [{"POSITION": "position morph"}]}
write("animation-morph", None, morph, nodes=[node], document=animation((0, "weights", "amount")))
skin = {"skins": [{"joints": [1, 2], "inverseBindMatrices": "binds"}]}
write("animation-skin", None, skinned, nodes=bones, document=skin | animation((2, "rotation", "turn")))

(HERE / "shapes.bin").write_bytes(data.bytes)
checks = lambda x, y: (230, 80, 40, 255) if (x + y) % 2 else (40, 120, 220, 60)
(HERE / "pixels.png").write_bytes(png(8, 4, checks))
