"""Judges the readers of PLY and STL by trimesh and plyfile, which write files of every kind and read them again: triangles,
positions, normals, UV and colours that photosite reads must be theirs, and the boxes of `photosite info` too.

Usage: meshes.py PHOTOSITE LIST_MESHES
"""

import json
import struct
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
import trimesh
from plyfile import PlyData, PlyElement
from trimesh.exchange import ply as trimesh_ply

# Linear values of colours are computed in single precision, by a power: some steps of the last place.
COLOURS = 1e-6
# Unit vectors are rounded to single precision, after sums in double precision.
NORMALS = 2e-7

PHOTOSITE, LIST_MESHES = sys.argv[1:]
folder = Path(tempfile.mkdtemp(prefix="meshes-"))
random = np.random.default_rng(35)
judged = 0


def listed(path, normals="flat"):
    """What photosite reads."""
    out = subprocess.run([LIST_MESHES, normals, str(path)], check=True, capture_output=True, text=True).stdout
    file = json.loads(out)[0]
    for mesh in file["meshes"]:
        for key, width in (("positions", 3), ("normals", 3), ("colours", 4)):
            mesh[key] = np.array(mesh[key], np.float32).reshape(-1, width)
        mesh["uvs"] = [np.array(uvs, np.float32) for uvs in mesh["uvs"]]
        mesh["triangles"] = np.array(mesh["triangles"]).reshape(-1, 3)
    return file


def bits(values):
    """Single precision as integers: what is equal is so to the last bit. Zeros of both signs are one."""
    return (np.ascontiguousarray(values, np.float32) + np.float32(0)).view(np.uint32)


def same_bits(name, found, expected):
    assert found.shape == expected.shape, f"{name}: {found.shape}, not {expected.shape}"
    assert np.array_equal(bits(found), bits(expected)), f"{name}: differs by up to {np.abs(found - expected).max()}"


def linear(encoded):
    """sRGB (IEC 61966-2-1), decoded in double precision."""
    encoded = np.asarray(encoded, float)
    return np.where(encoded <= 0.04045, encoded / 12.92, ((encoded + 0.055) / 1.055) ** 2.4)


def judge(path, corners, normals=None, uvs=None, colours=None, warnings=0):
    """Compares corners of triangles, (n, 3, 3), and what they have, in the order of the file."""
    global judged
    file = listed(path)
    assert len(file["warnings"]) == warnings, f"{path.name}: {file['warnings']}"
    meshes = file["meshes"]
    same_bits(f"{path.name}: positions", np.concatenate([m["positions"][m["triangles"]] for m in meshes]), corners)
    (mesh,) = meshes if normals is not None or uvs is not None or colours is not None else (meshes[0],)
    at = mesh["triangles"]
    if normals is None:
        assert mesh["normals"].size == 0, f"{path.name}: normals"
    else:
        unit = normals / np.linalg.norm(normals.astype(float), axis=2, keepdims=True)
        np.testing.assert_allclose(mesh["normals"][at], unit, rtol=0, atol=NORMALS, err_msg=path.name)
    if uvs is None:
        assert mesh["uvs"] == [], f"{path.name}: UV"
    else:
        # From the top of images, where PLY counts from the bottom.
        same_bits(f"{path.name}: UV", mesh["uvs"][0][at], np.stack([uvs[..., 0], np.float32(1) - uvs[..., 1]], axis=-1))
    if colours is None:
        assert mesh["colours"].size == 0, f"{path.name}: colours"
    else:
        np.testing.assert_allclose(mesh["colours"][at], colours, rtol=0, atol=COLOURS, err_msg=path.name)
    judge_box(path, np.concatenate(corners) if isinstance(corners, list) else corners)
    judged += 1


def judge_box(path, corners):
    facts = json.loads(subprocess.run([PHOTOSITE, "info", str(path), "--json"], check=True, capture_output=True).stdout)
    corners = corners.reshape(-1, 3)
    if path.suffix == ".stl":
        # STL files stand upright, z up, where scenes have y up. Entries of that rotation are off by rounding.
        corners = np.stack([corners[:, 0], corners[:, 2], -corners[:, 1]], axis=-1)
    low, high = corners.min(axis=0).astype(float), corners.max(axis=0).astype(float)
    rounded = 4 * np.finfo(float).eps * np.abs(corners).max() if path.suffix == ".stl" else 0
    for key, expected in (("min_m", low), ("max_m", high), ("size_m", high - low)):
        np.testing.assert_allclose(facts["bounding_box"][key], expected, rtol=0, atol=rounded, err_msg=f"{path.name}: {key}")
    assert facts["geometry"] == [{"file": path.name, "unit_m": 1.0, "unit_from": "assumed"}], facts["geometry"]


def judge_smooth(path, mesh):
    """Normals of vertices by trimesh, weighted by angles as ours."""
    found = listed(path, "smooth")["meshes"][0]
    expected = trimesh.geometry.weighted_vertex_normals(
        len(mesh.vertices), mesh.faces, mesh.face_normals, mesh.face_angles
    )
    # Both sum in double precision; trimesh normalises by sums of its own.
    np.testing.assert_allclose(
        found["normals"][found["triangles"]], expected[mesh.faces], rtol=0, atol=1e-5, err_msg=path.name
    )


def shapes():
    """Meshes of trimesh's own, and one of random numbers of all magnitudes."""
    ball = trimesh.creation.icosphere(subdivisions=2, radius=0.3)
    torus = trimesh.creation.torus(0.4, 0.1)
    torus.apply_transform(trimesh.transformations.random_rotation_matrix(random.random(3)))
    vertices = random.standard_normal((200, 3)) * 10.0 ** random.uniform(-6, 1, (200, 1))
    faces = np.array([random.permutation(200)[:3] for _ in range(300)])
    faces = np.concatenate([faces, np.arange(198).reshape(-1, 3)])
    yield "ball", ball
    yield "torus", torus
    yield "dust", trimesh.Trimesh(vertices, faces, process=False)


def write(path, mesh, **how):
    path.write_bytes(trimesh_ply.export_ply(mesh, **how))


def by_trimesh():
    """Files that trimesh writes, and what it reads of them itself."""
    for name, mesh in shapes():
        for encoding in ("ascii", "binary"):
            for with_normals in (False, True):
                for with_colours in (False, True):
                    written = mesh.copy()
                    count = len(mesh.vertices)
                    if with_colours:
                        written.visual = trimesh.visual.ColorVisuals(
                            written, vertex_colors=random.integers(1, 256, (count, 4), dtype=np.uint8)
                        )
                    path = folder / f"{name}-{encoding}-{with_normals:d}{with_colours:d}.ply"
                    write(path, written, encoding=encoding, vertex_normal=with_normals)
                    read = trimesh.load_mesh(path, process=False)
                    faces = read.faces
                    normals = colours = None
                    if with_normals:
                        data = PlyData.read(path)["vertex"]
                        normals = np.stack([data[n] for n in ("nx", "ny", "nz")], axis=1)[faces].astype(np.float32)
                    if with_colours:
                        codes = read.visual.vertex_colors[faces] / 255.0
                        colours = np.concatenate([linear(codes[..., :3]), codes[..., 3:]], axis=-1)
                    judge(path, read.vertices.astype(np.float32)[faces], normals, None, colours)
                    if not with_normals and name != "dust":
                        judge_smooth(path, read)
        for kind, how in (("ascii", {"file_type": "stl_ascii"}), ("binary", {"file_type": "stl"})):
            path = folder / f"{name}-{kind}.stl"
            data = mesh.export(**how)
            path.write_bytes(data.encode() if isinstance(data, str) else data)
            read = trimesh.load_mesh(path, process=False)
            judge(path, read.vertices.astype(np.float32)[read.faces])
            vertices = listed(path)["meshes"][0]["positions"]
            assert len(np.unique(bits(vertices), axis=0)) == len(vertices), "corners at a place are one vertex"
    # Several solids, whose names have blanks; trimesh reads them as a scene.
    first, second = trimesh.creation.box((1, 2, 3)), trimesh.creation.cone(1, 2)
    texts = [
        mesh.export(file_type="stl_ascii").replace("solid ", f"solid {name}", 1)
        for mesh, name in ((first, "the box"), (second, "the  cone "))
    ]
    path = folder / "two.stl"
    path.write_text("\n".join(texts))
    names = [mesh["name"] for mesh in listed(path)["meshes"]]
    assert names == ["the box", "the  cone"], names
    judge(path, np.concatenate([m.vertices.astype(np.float32)[m.faces] for m in (first, second)]))
    # A binary file that begins as text does.
    data = bytearray(second.export(file_type="stl"))
    data[:80] = b"solid made by a program that begins like this".ljust(80)
    path = folder / "solid.stl"
    path.write_bytes(data)
    read = trimesh.load_mesh(path, process=False)
    judge(path, read.vertices.astype(np.float32)[read.faces])


TYPES = {"i1": "char", "u1": "uchar", "i2": "short", "u2": "ushort", "i4": "int", "u4": "uint", "f4": "float", "f8": "double"}


def by_plyfile():
    """Files that plyfile writes: every type, order of bytes, name of UV and colours, and lists of every length."""
    count = 40
    for form in ({"text": True}, {"byte_order": "<"}, {"byte_order": ">"}):
        for i, kind in enumerate(TYPES):
            rows = np.zeros(count, [(axis, kind) for axis in "xyz"] + [("quality", "f4")])
            whole = kind[0] != "f"
            for axis in "xyz":
                rows[axis] = random.integers(0, 100, count) if whole else random.standard_normal(count)
            rows["quality"] = np.nan
            names = [("u", "v"), ("s", "t"), ("texture_u", "texture_v"), ("s0", "t0")][i % 4]
            colour_kind = ("u1", "u2", "f4", "f8")[i % 4]
            white = {"u1": 255, "u2": 65535}.get(colour_kind, 1)
            uvs = random.random((count, 2)).astype("f4")
            codes = random.random((count, 4)) * white if white == 1 else random.integers(1, white + 1, (count, 4))
            more = [(n, colour_kind) for n in ("red", "green", "blue", "alpha")] + [(n, "f4") for n in names]
            more += [(n, "f8") for n in ("nx", "ny", "nz")]
            normals = random.standard_normal((count, 3))
            vertex = np.zeros(count, rows.dtype.descr + more)
            for name in rows.dtype.names:
                vertex[name] = rows[name]
            for j, name in enumerate(("red", "green", "blue", "alpha")):
                vertex[name] = codes[:, j]
            for j, name in enumerate(names):
                vertex[name] = uvs[:, j]
            for j, name in enumerate(("nx", "ny", "nz")):
                vertex[name] = normals[:, j]
            index_kind, length_kind = ("i1", "u1", "i2", "u2", "i4", "u4", "i4", "u4")[i], ("u1", "i4", "u2", "i1")[i % 4]
            face = np.zeros(30, [("flags", "u2"), ("vertex_indices", object), ("extra", object)])
            for row in face:
                row["vertex_indices"] = random.permutation(count)[:3].astype(index_kind)
                row["extra"] = random.random(random.integers(0, 5))
            elements = [
                PlyElement.describe(np.zeros(3, [("a", "i4"), ("b", "u1")]), "camera"),
                PlyElement.describe(vertex, "vertex"),
                PlyElement.describe(
                    face,
                    "face",
                    val_types={"vertex_indices": index_kind, "extra": "f8"},
                    len_types={"vertex_indices": length_kind, "extra": "u1"},
                ),
            ]
            path = folder / f"types-{kind}-{form.get('byte_order', 't').replace('<', 'l').replace('>', 'b')}.ply"
            PlyData(elements, comments=["by plyfile"], obj_info=["none"], **form).write(path)
            data = PlyData.read(path)
            at = np.array(list(data["face"]["vertex_indices"]), int)
            read = data["vertex"]
            of = lambda names: np.stack([read[name] for name in names], axis=1)
            channels = of(("red", "green", "blue", "alpha")) / white
            colours = np.concatenate([linear(channels[:, :3]) if white > 1 else channels[:, :3], channels[:, 3:]], axis=1)
            # Triangles without area are left out: there are none unless coordinates are whole.
            corners = of("xyz").astype(np.float32)[at]
            edges = corners.astype(float)
            area = np.linalg.norm(np.cross(edges[:, 1] - edges[:, 0], edges[:, 2] - edges[:, 0]), axis=1)
            kept = area > 0
            assert kept.all() or whole
            judge(
                path,
                corners[kept],
                of(("nx", "ny", "nz")).astype(np.float32)[at][kept],
                of(names).astype(np.float32)[at][kept],
                colours[at][kept],
                warnings=int(not kept.all()),
            )


def polygons():
    """Quads and larger polygons: the same surface as trimesh's, whatever the diagonals."""
    for corners in (4, 5, 8, 30):
        for form in ({"text": True}, {"byte_order": "<"}, {"byte_order": ">"}):
            angle = np.arange(corners) * 2 * np.pi / corners
            # A star, whose inner corners are concave, in a tilted plane.
            radius = np.where(np.arange(corners) % 2, 0.5, 1.0) if corners > 4 and corners % 2 == 0 else np.ones(corners)
            flat = np.stack([radius * np.cos(angle), radius * np.sin(angle), np.zeros(corners)], axis=1)
            turn = trimesh.transformations.random_rotation_matrix(random.random(3))[:3, :3]
            points = (flat @ turn.T).astype("f4")
            vertex = np.array([tuple(p) for p in points], [(axis, "f4") for axis in "xyz"])
            face = np.zeros(1, [("vertex_index", object)])
            face[0]["vertex_index"] = np.arange(corners, dtype="i4")
            path = folder / f"polygon-{corners}-{form.get('byte_order', 't').replace('<', 'l').replace('>', 'b')}.ply"
            PlyData(
                [PlyElement.describe(vertex, "vertex"), PlyElement.describe(face, "face", len_types={"vertex_index": "u2"})],
                **form,
            ).write(path)
            (mesh,) = listed(path)["meshes"]
            same_bits(path.name, mesh["positions"], points)
            assert len(mesh["triangles"]) == corners - 2
            edges = mesh["positions"].astype(float)[mesh["triangles"]]
            vectors = np.cross(edges[:, 1] - edges[:, 0], edges[:, 2] - edges[:, 0]) / 2
            x, y = (flat[:, 0], flat[:, 1])
            area = 0.5 * abs(np.dot(x, np.roll(y, -1)) - np.dot(y, np.roll(x, -1)))
            # All turn alike, and their areas add up to that of the polygon: they cover it once.
            assert (vectors @ turn[:, 2] > 0).all()
            np.testing.assert_allclose(np.linalg.norm(vectors, axis=1).sum(), area, rtol=1e-6)
            if corners == 4:
                # trimesh cuts quads, too: from the first corner on.
                read = trimesh.load_mesh(path, process=False)
                assert sorted(map(sorted, read.faces)) == sorted(map(sorted, mesh["triangles"]))
            global judged
            judged += 1


def textured():
    """UV of the corners of faces with an image, as MeshLab writes them: trimesh reads both."""
    from PIL import Image

    mesh = trimesh.creation.icosphere(subdivisions=1)
    faces = mesh.faces
    uvs = random.random((len(faces), 6)).astype("f4")
    vertex = np.array([tuple(p) for p in mesh.vertices.astype("f4")], [(axis, "f4") for axis in "xyz"])
    face = np.zeros(len(faces), [("vertex_indices", "i4", (3,)), ("texcoord", "f4", (6,))])
    face["vertex_indices"], face["texcoord"] = faces, uvs
    Image.new("RGB", (5, 3), (10, 20, 30)).save(folder / "texture.png")
    path = folder / "textured.ply"
    elements = [PlyElement.describe(vertex, "vertex"), PlyElement.describe(face, "face")]
    PlyData(elements, byte_order="<", comments=["VCGLIB generated", "TextureFile texture.png"]).write(path)
    read = trimesh.load_mesh(path, process=False)
    assert listed(path)["pictures"] == [[5, 3]] and read.visual.material.image.size == (5, 3)
    theirs = read.visual.uv.astype(np.float32)[read.faces]
    assert np.array_equal(theirs, uvs.reshape(-1, 3, 2)), "trimesh has the UV of the file"
    judge(path, read.vertices.astype(np.float32)[read.faces], None, theirs)


def hostile():
    """Headers that announce what no byte backs: refused at once, in little memory."""
    vertex = "element vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
    head = "ply\nformat binary_little_endian 1.0\n"
    body = struct.pack("<9f", 0, 0, 0, 1, 0, 0, 0, 1, 0)
    face = "element face {}\nproperty list {} int vertex_indices\n"
    cases = {
        "vertices.ply": (head + vertex.replace("3\n", "4000000000\n", 1) + face.format(1, "uchar"), body),
        "faces.ply": (head + vertex + face.format(2**62, "uchar"), body),
        "nothing.ply": (head + f"element odd {2**63}\n" + vertex + face.format(1, "uchar"), body),
        "list.ply": (head + vertex + face.format(1, "uint"), body + struct.pack("<I", 2**32 - 1)),
        "marks.ply": (head + vertex + "property list uint uchar marks\n" + face.format(1, "uchar"), body + b"\xff" * 40),
    }
    for name, (header, values) in cases.items():
        (folder / name).write_bytes(header.encode() + b"end_header\n" + values)
    (folder / "facets.stl").write_bytes(b"x" * 80 + struct.pack("<I", 2**32 - 1) + bytes(50))
    for name in [*cases, "facets.stl"]:
        limited = f"ulimit -v 4000000; exec '{PHOTOSITE}' info '{folder / name}'"
        run = subprocess.run(["bash", "-c", limited], capture_output=True, text=True, timeout=60)
        assert run.returncode == 1 and name in run.stderr and "panic" not in run.stderr, (name, run.returncode, run.stderr)


by_trimesh()
by_plyfile()
polygons()
textured()
hostile()
print(f"{judged} files are read as trimesh and plyfile read them, and what no byte backs is refused")
