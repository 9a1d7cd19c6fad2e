"""A small writer of glTF 2.0: indexed triangle meshes, instanced by nodes. Shared by the make.py of the scenes.

Geometry goes to a `.bin` beside the `.gltf`; each mesh is written once, however many materials and places it has. Metres,
+Y up, counter-clockwise faces. Needs Python only.
"""

import json
import math
import struct

FLOAT, UNSIGNED_SHORT, UNSIGNED_INT = 5126, 5123, 5125
ARRAY_BUFFER, ELEMENT_ARRAY_BUFFER = 34962, 34963


class GltfFile:
    """Collects materials, shapes and nodes, then writes them."""

    def __init__(self):
        self.binary = bytearray()
        self.views, self.accessors, self.materials, self.meshes, self.nodes = [], [], [], [], []
        self.material_index, self.shapes, self.mesh_index = {}, {}, {}

    def material(self, name, colour=(0.8, 0.8, 0.8), metallic=0.0, roughness=1.0, emission=None, luminance_nit=None):
        """Adds a metallic-roughness material of linear sRGB. An emission colour of (1, 1, 1) has the given luminance."""
        pbr = {"baseColorFactor": [*colour, 1.0], "metallicFactor": metallic, "roughnessFactor": roughness}
        entry = {"name": name, "pbrMetallicRoughness": pbr}
        if emission is not None:
            entry["emissiveFactor"] = list(emission)
            entry["extensions"] = {"KHR_materials_emissive_strength": {"emissiveStrength": luminance_nit}}
        self.material_index[name] = len(self.materials)
        self.materials.append(entry)

    def shape(self, name, positions, normals, triangles):
        """Adds geometry that nodes can place. `normals` may be `positions` itself, as for a unit sphere, or None."""
        wide = len(positions) > 65535
        flat = [index for triangle in triangles for index in triangle]
        indices = self._accessor(
            struct.pack(f"<{len(flat)}{'I' if wide else 'H'}", *flat),
            ELEMENT_ARRAY_BUFFER,
            {"componentType": UNSIGNED_INT if wide else UNSIGNED_SHORT, "count": len(flat), "type": "SCALAR"},
        )
        attributes = {"POSITION": self._vectors(positions)}
        if normals is positions:
            attributes["NORMAL"] = attributes["POSITION"]
        elif normals is not None:
            attributes["NORMAL"] = self._vectors(normals)
        self.shapes[name] = {"attributes": attributes, "indices": indices}

    def place(self, name, shape, material, translation=None, scale=None):
        """Adds a node with a shape in a material, scaled evenly or by axis, then moved."""
        key = (shape, material)
        if key not in self.mesh_index:
            self.mesh_index[key] = len(self.meshes)
            primitive = {**self.shapes[shape], "material": self.material_index[material]}
            self.meshes.append({"name": f"{material} {shape}", "primitives": [primitive]})
        node = {"name": name, "mesh": self.mesh_index[key]}
        if translation is not None:
            node["translation"] = [round(value, 6) for value in translation]
        if scale is not None:
            node["scale"] = list(scale) if isinstance(scale, (tuple, list)) else [scale] * 3
        self.nodes.append(node)

    def write(self, path):
        """Writes `path` and the `.bin` of the same name."""
        binary = path.with_suffix(".bin")
        document = {
            "asset": {"version": "2.0", "generator": "make.py of this folder"},
            "scene": 0,
            "scenes": [{"nodes": list(range(len(self.nodes)))}],
            "nodes": self.nodes,
            "meshes": self.meshes,
            "materials": self.materials,
            "accessors": self.accessors,
            "bufferViews": self.views,
            "buffers": [{"uri": binary.name, "byteLength": len(self.binary)}],
        }
        if any("extensions" in material for material in self.materials):
            document["extensionsUsed"] = ["KHR_materials_emissive_strength"]
        binary.write_bytes(self.binary)
        path.write_text(one_line_each(document) + "\n", encoding="utf-8")

    def _vectors(self, vectors):
        # What the file says of its bounds must hold for its single-precision values.
        packed = struct.pack(f"<{3 * len(vectors)}f", *(value for vector in vectors for value in vector))
        stored = list(struct.iter_unpack("<3f", packed))
        bounds = {name: [pick(axis) for axis in zip(*stored)] for name, pick in (("min", min), ("max", max))}
        return self._accessor(
            packed, ARRAY_BUFFER, {"componentType": FLOAT, "count": len(vectors), "type": "VEC3", **bounds}
        )

    def _accessor(self, data, target, accessor):
        self.binary.extend(b"\0" * (-len(self.binary) % 4))
        view = {"buffer": 0, "byteOffset": len(self.binary), "byteLength": len(data), "target": target}
        self.binary.extend(data)
        self.views.append(view)
        self.accessors.append({"bufferView": len(self.views) - 1, **accessor})
        return len(self.accessors) - 1


def one_line_each(document):
    """JSON with one element of each list a line, which reads and diffs well."""
    parts = []
    for key, value in document.items():
        if isinstance(value, list) and value and isinstance(value[0], dict):
            rows = ",\n".join("    " + json.dumps(row) for row in value)
            parts.append(f'  "{key}": [\n{rows}\n  ]')
        else:
            parts.append(f'  "{key}": {json.dumps(value)}')
    return "{\n" + ",\n".join(parts) + "\n}"


def sphere(frequency):
    """A unit sphere: each of an icosahedron's 20 faces cut into frequency² triangles. Positions, triangles."""
    golden = (1 + math.sqrt(5)) / 2
    corners = []
    for a, b in ((-1, golden), (1, golden), (-1, -golden), (1, -golden)):
        corners += [(a, b, 0), (0, a, b), (b, 0, a)]
    edge = 2.0
    faces = []
    for i in range(12):
        for j in range(i + 1, 12):
            for k in range(j + 1, 12):
                near = all(abs(math.dist(corners[p], corners[q]) - edge) < 1e-9 for p, q in ((i, j), (j, k), (i, k)))
                if near:
                    normal = cross(minus(corners[j], corners[i]), minus(corners[k], corners[i]))
                    outwards = sum(n * c for n, c in zip(normal, corners[i])) > 0
                    faces.append((i, j, k) if outwards else (i, k, j))
    positions, index, triangles = [], {}, []

    def vertex(point):
        key = tuple(round(value, 7) for value in unit(point))
        if key not in index:
            index[key] = len(positions)
            positions.append(unit(point))
        return index[key]

    for a, b, c in (tuple(corners[i] for i in face) for face in faces):
        def at(i, j):
            k = frequency - i - j
            return vertex(tuple((k * x + i * y + j * z) / frequency for x, y, z in zip(a, b, c)))

        for i in range(frequency):
            for j in range(frequency - i):
                triangles.append((at(i, j), at(i + 1, j), at(i, j + 1)))
                if i + j < frequency - 1:
                    triangles.append((at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)))
    return positions, triangles


def lathe(profile, segments):
    """A solid of revolution about +Y. `profile` is a list of runs of (radius, height, normal's radius, normal's height)
    from the top down; normals are shared within a run and break between runs. Positions, normals, triangles."""
    positions, normals, triangles = [], [], []
    for run in profile:
        first = len(positions)
        for radius, height, normal_radius, normal_height in run:
            for s in range(segments):
                angle = 2 * math.pi * s / segments
                positions.append((radius * math.sin(angle), height, radius * math.cos(angle)))
                normals.append(unit((normal_radius * math.sin(angle), normal_height, normal_radius * math.cos(angle))))
        for ring in range(len(run) - 1):
            for s in range(segments):
                a, b = first + ring * segments + s, first + ring * segments + (s + 1) % segments
                c, d = a + segments, b + segments
                # A ring of radius 0 is a point: one of the two triangles would have no area.
                if run[ring + 1][0] > 0:
                    triangles.append((a, c, d))
                if run[ring][0] > 0:
                    triangles.append((a, d, b))
    return positions, normals, triangles


def minus(a, b):
    """a − b."""
    return tuple(x - y for x, y in zip(a, b))


def cross(a, b):
    """a × b."""
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def unit(vector):
    """The vector at length 1."""
    length = math.hypot(*vector)
    return tuple(value / length for value in vector)
