"""Reading and writing of glTF 2.0 as far as the comparison's scenes go."""

import json
import struct
import zlib

import numpy as np

from .meshes import Mesh

FLOAT, UNSIGNED_SHORT, UNSIGNED_INT = 5126, 5123, 5125
WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3}
TYPES = {FLOAT: "<f4", UNSIGNED_SHORT: "<u2", UNSIGNED_INT: "<u4"}


def png(image):
    """Bytes of a PNG file of h × w × 3 bytes."""

    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    height, width, _ = image.shape
    rows = b"".join(b"\0" + row.tobytes() for row in image)
    header = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b"")


class Glb:
    """Collects meshes and textured materials, then writes them as binary glTF."""

    def __init__(self):
        self.chunks, self.views, self.accessors, self.images = [], [], [], []

    def view(self, data):
        self.views.append({"buffer": 0, "byteOffset": sum(map(len, self.chunks)), "byteLength": len(data)})
        self.chunks.append(data)
        return len(self.views) - 1

    def accessor(self, array, component, kind, **bounds):
        view = self.view(array.tobytes())
        self.accessors.append({"bufferView": view, "componentType": component, "count": len(array), "type": kind, **bounds})
        return len(self.accessors) - 1

    def texture(self, image):
        data = png(image)
        self.images.append({"bufferView": self.view(data + b"\0" * (-len(data) % 4)), "mimeType": "image/png"})
        return {"index": len(self.images) - 1}

    def mesh(self, mesh, material):
        positions = mesh.positions.astype("<f4")
        bounds = {"min": positions.min(axis=0).tolist(), "max": positions.max(axis=0).tolist()}
        attributes = {"POSITION": self.accessor(positions, FLOAT, "VEC3", **bounds)}
        if mesh.normals is not None:
            attributes["NORMAL"] = self.accessor(mesh.normals.astype("<f4"), FLOAT, "VEC3")
        if mesh.uvs is not None:
            attributes["TEXCOORD_0"] = self.accessor(mesh.uvs.astype("<f4"), FLOAT, "VEC2")
        indices = self.accessor(mesh.triangles.astype("<u4").reshape(-1), UNSIGNED_INT, "SCALAR")
        return {"primitives": [{"attributes": attributes, "indices": indices, "material": material}]}

    def material(self, name, described):
        """A material, of which the capture file says more unless it has textures."""
        if described is None or described.colour_texture is None:
            return {"name": name}
        colour, metal = self.texture(described.colour_texture), self.texture(described.metal_texture)
        return {"name": name, "pbrMetallicRoughness": {"baseColorTexture": colour, "metallicRoughnessTexture": metal}}

    def write(self, path, meshes, materials):
        names = list(dict.fromkeys(mesh.material for mesh in meshes))
        entries = [self.mesh(mesh, names.index(mesh.material)) for mesh in meshes]
        described = {material.name: material for material in materials}
        document = {
            "asset": {"version": "2.0"},
            "scene": 0,
            "scenes": [{"nodes": list(range(len(entries)))}],
            "nodes": [{"mesh": i} for i in range(len(entries))],
            "meshes": entries,
            "materials": [self.material(name, described.get(name)) for name in names],
            "accessors": self.accessors,
            "bufferViews": self.views,
            "buffers": [{"byteLength": sum(map(len, self.chunks))}],
        }
        if self.images:
            document["images"] = self.images
            document["textures"] = [{"source": i} for i in range(len(self.images))]
        text = json.dumps(document).encode()
        text += b" " * (-len(text) % 4)
        size = sum(map(len, self.chunks))
        with path.open("wb") as file:
            file.write(struct.pack("<4sII", b"glTF", 2, 12 + 8 + len(text) + 8 + size))
            file.write(struct.pack("<I4s", len(text), b"JSON") + text + struct.pack("<I4s", size, b"BIN\0"))
            file.writelines(self.chunks)


def read_gltf(path):
    """Meshes of a glTF file of this repository, whose nodes are moved and scaled, and the materials that it states."""
    document = json.loads(path.read_text(encoding="utf-8"))
    data = (path.parent / document["buffers"][0]["uri"]).read_bytes()

    def array(index):
        accessor = document["accessors"][index]
        width = WIDTHS[accessor["type"]]
        start = document["bufferViews"][accessor["bufferView"]]["byteOffset"]
        values = np.frombuffer(data, TYPES[accessor["componentType"]], accessor["count"] * width, start)
        return values.reshape(-1, width) if width > 1 else values

    meshes = []
    for node in document["nodes"]:
        primitive = document["meshes"][node["mesh"]]["primitives"][0]
        scale, move = np.array(node.get("scale", (1, 1, 1))), np.array(node.get("translation", (0, 0, 0)))
        normal = primitive["attributes"].get("NORMAL")
        meshes.append(Mesh(
            document["materials"][primitive["material"]]["name"],
            array(primitive["attributes"]["POSITION"]) * scale + move,
            array(primitive["indices"]).astype(np.int64).reshape(-1, 3),
            None if normal is None else array(normal).astype(np.float64),
        ))
    return meshes, document["materials"]
