#!/usr/bin/env python3
"""FCL, Manifold, trimesh and linear programming judge placed objects: placement.py DRAWS_PROGRAM [COUNT]

DRAWS_PROGRAM is `cargo build --release -p photosite-placement --example draws`. In every draw no triangle of an object meets
one of another (FCL) and no solids share volume (Manifold), to the ground as well; objects that lie or stand are held: forces at
the points where they touch, within the cones of friction, balance the weights of all of them at once (HiGHS). The same bytes
come out twice. Ways of standing and their probabilities are trimesh's. Each check is shown to fail where an object is moved.
"""

import json
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from itertools import combinations

import fcl
import numpy as np
import trimesh
from manifold3d import Manifold, Mesh
from scipy.optimize import linprog

PROGRAM, COUNT = sys.argv[1], sys.argv[2] if len(sys.argv) > 2 else "256"
# What the project promises, m.
TOLERANCE = 1e-4
# Of the weight of the heaviest object, what forces at the contacts may leave unheld.
UNHELD = 0.002


def rotation(quaternion_wxyz):
    return trimesh.transformations.quaternion_matrix(quaternion_wxyz)[:3, :3]


class Placed:
    """An object of a draw in the world."""

    def __init__(self, shape, told, moved=(0, 0, 0)):
        turn = rotation(told["quaternion_wxyz"])
        place = lambda points: told["scale"] * (np.asarray(points) @ turn.T) + told["position_m"] + moved
        self.name, self.faces, self.is_solid = shape["name"], shape["triangles"], shape["is_solid"]
        self.vertices = place(shape["positions"])
        self.centre = place([shape["centre"]])[0]
        self.mass = shape["volume"] * told["scale"] ** 3
        self.low, self.high = self.vertices.min(axis=0), self.vertices.max(axis=0)
        self.corners = self.vertices[self.faces]
        self.edges = self.vertices[shape["edges"]]
        model = fcl.BVHModel()
        model.beginModel(len(self.vertices), len(self.faces))
        model.addSubModel(self.vertices, self.faces)
        model.endModel()
        self.fcl = fcl.CollisionObject(model, fcl.Transform())

    def is_near(self, other, margin):
        return bool((self.low - margin <= other.high).all() and (other.low - margin <= self.high).all())

    def solid(self):
        return Manifold(Mesh(vert_properties=self.vertices.astype(np.float32), tri_verts=self.faces.astype(np.uint32)))


def meet(a, b):
    """Whether triangles meet, or solids share a volume that is more than a film of a tenth of the tolerance."""
    if not a.is_near(b, 0):
        return False
    if fcl.collide(a.fcl, b.fcl, fcl.CollisionRequest(), fcl.CollisionResult()) > 0:
        return True
    if not (a.is_solid and b.is_solid):
        return False
    return (a.solid() ^ b.solid()).volume() > 1e-12


def distance(a, b):
    return fcl.distance(a.fcl, b.fcl, fcl.DistanceRequest(), fcl.DistanceResult())


def within(points, low, high, margin=TOLERANCE):
    """Which groups of points come near to a box."""
    points = points.reshape(len(points), -1, 3)
    return ((points.min(axis=1) <= high + margin) & (points.max(axis=1) >= low - margin)).all(axis=1)


def segments(p, q):
    """Closest points of all edges p and all edges q (Ericson, "Real-Time Collision Detection", 5.1.9)."""
    d1, d2 = (p[:, 1] - p[:, 0])[:, None], (q[:, 1] - q[:, 0])[None]
    r = p[:, 0][:, None] - q[:, 0][None]
    a, e, f = (d1 * d1).sum(-1), (d2 * d2).sum(-1), (d2 * r).sum(-1)
    b, c = (d1 * d2).sum(-1), (d1 * r).sum(-1)
    denominator = a * e - b * b
    with np.errstate(divide="ignore", invalid="ignore"):
        s = np.clip(np.where(denominator > 1e-9 * a * e, (b * f - c * e) / denominator, 0), 0, 1)
        t = np.clip((b * s + f) / e, 0, 1)
        s = np.clip((b * t - c) / a, 0, 1)
    return p[:, 0][:, None] + d1 * s[..., None], q[:, 0][None] + d2 * t[..., None]


def touching(a, b):
    """Points where a and b touch, and the direction in which b pushes a there."""
    found = []

    def add(on_a, on_b, normal=None):
        gaps = np.linalg.norm(on_a - on_b, axis=-1)
        for i in np.flatnonzero(gaps <= TOLERANCE):
            # Of what touches to a micrometre the face says the direction.
            direction = normal[i] if normal is not None else (on_a[i] - on_b[i]) / max(gaps[i], 1e-30)
            if normal is not None or gaps[i] > 1e-6:
                found.append((on_b[i], direction))

    for first, second, sign in [(a, b, 1), (b, a, -1)]:
        points = first.vertices[within(first.vertices, second.low, second.high)]
        faces = second.corners[within(second.corners, first.low, first.high)]
        if len(points) and len(faces):
            pairs = np.repeat(points, len(faces), axis=0), np.tile(faces, (len(points), 1, 1))
            near = trimesh.triangles.closest_point(pairs[1], pairs[0])
            normals = np.cross(pairs[1][:, 1] - pairs[1][:, 0], pairs[1][:, 2] - pairs[1][:, 0])
            lengths = np.linalg.norm(normals, axis=1)
            normals = normals / np.maximum(lengths, 1e-30)[:, None]
            apart = pairs[0] - near
            gaps = np.linalg.norm(apart, axis=1)
            facing = np.sign((normals * apart).sum(axis=1))[:, None] * normals
            is_far = gaps > 1e-6
            directions = np.where(is_far[:, None], apart / np.maximum(gaps, 1e-30)[:, None], facing)
            for i in np.flatnonzero(gaps <= TOLERANCE):
                found.append((near[i], sign * directions[i]))
    first, second = (a.edges[within(a.edges, b.low, b.high)], b.edges[within(b.edges, a.low, a.high)])
    if len(first) and len(second):
        on_a, on_b = segments(first, second)
        add(on_a.reshape(-1, 3), on_b.reshape(-1, 3))
    return thinned(found)


def thinned(found, most=60):
    """The contacts that lie farthest from each other; so many say what all of a flat patch would."""
    if len(found) <= most:
        return found
    points, directions = np.array([p for p, _ in found]), np.array([d for _, d in found])
    where = np.hstack([points / max(np.ptp(points, axis=0).max(), 1e-9), 0.5 * directions])
    chosen = [0]
    gaps = np.linalg.norm(where - where[0], axis=1)
    while len(chosen) < most and gaps.max() > 1e-6:
        chosen.append(int(gaps.argmax()))
        gaps = np.minimum(gaps, np.linalg.norm(where - where[chosen[-1]], axis=1))
    return [found[i] for i in chosen]


def unbalance(objects, fixed, ground, friction):
    """The least part of its weight that no forces at the contacts hold, of the object that is held worst."""
    contacts = []
    for i, a in enumerate(objects):
        low = a.vertices[a.vertices[:, 1] <= ground + TOLERANCE]
        contacts += [(i, None, p, d) for p, d in thinned([(p, np.array([0.0, 1.0, 0.0])) for p in low])]
        for b in fixed:
            if a.is_near(b, TOLERANCE):
                contacts += [(i, None, p, d) for p, d in touching(a, b)]
    for (i, a), (j, b) in combinations(enumerate(objects), 2):
        if a.is_near(b, TOLERANCE):
            contacts += [(i, j, p, d) for p, d in touching(a, b)]
    rows, size = 6 * len(objects), [np.linalg.norm(o.vertices - o.centre, axis=1).max() for o in objects]
    columns = []
    for i, j, point, normal in contacts:
        side = np.cross(normal, [1.0, 0, 0] if abs(normal[0]) < 0.7 else [0, 1.0, 0])
        side /= np.linalg.norm(side)
        up = np.cross(normal, side)
        for angle in np.arange(8) * np.pi / 4:
            force = normal + friction * (np.cos(angle) * side + np.sin(angle) * up)
            column = np.zeros(rows)
            for k, sign in [(i, 1), (j, -1)]:
                if k is not None:
                    o = objects[k]
                    wrench = np.concatenate([force, np.cross(point - o.centre, force) / size[k]])
                    column[6 * k : 6 * k + 6] += sign * wrench / o.mass
            columns.append(column)
    weight = np.zeros(rows)
    weight[1::6] = 1.0
    if not columns:
        return 1.0
    matrix = np.array(columns).T
    # Forces on a light object from a heavy one are large beside its weight: measured by the heaviest.
    heaviest = max(o.mass for o in objects)
    scale = np.repeat([o.mass / heaviest for o in objects], 6)
    matrix, weight = matrix * scale[:, None], weight * scale
    one = np.ones((rows, 1))
    upper = np.vstack([np.hstack([matrix, -one]), np.hstack([-matrix, -one])])
    cost = np.zeros(matrix.shape[1] + 1)
    cost[-1] = 1
    solved = linprog(cost, A_ub=upper, b_ub=np.concatenate([weight, -weight]), method="highs")
    assert solved.status == 0, solved.message
    return solved.fun


def read(text):
    told = json.loads(text)
    for shape in told["shapes"]:
        shape["positions"], shape["triangles"] = np.array(shape["positions"]), np.array(shape["triangles"])
        mesh = trimesh.Trimesh(shape["positions"], shape["triangles"], process=False)
        shape["is_solid"] = bool(mesh.is_watertight)
        if mesh.is_watertight:
            assert mesh.volume > 0, shape["name"]
            shape["centre"], shape["volume"] = mesh.center_mass, mesh.volume
        else:
            # A sheet; as thick as a foil of 10 μm.
            shape["centre"], shape["volume"] = mesh.centroid, mesh.area * 1e-5
        shape["edges"] = mesh.edges_unique
    return told


def judge_resting(shape):
    """Directions down and probabilities against trimesh's, which has them from the same paper."""
    mesh = trimesh.Trimesh(shape["positions"], shape["triangles"], process=True)
    transforms, expected = trimesh.poses.compute_stable_poses(mesh, center_mass=shape["centre"], sigma=0, n_samples=1, threshold=0)
    # Theirs stand on z = 0.
    downs = np.array([transform[:3, :3].T @ [0, 0, -1] for transform in transforms])
    worst = 0.0
    for pose in shape["resting"]:
        same = downs @ pose["down"] > 1 - 1e-6
        worst = max(worst, abs(expected[same].sum() - pose["probability"]))
    assert abs(sum(pose["probability"] for pose in shape["resting"]) - 1) < 1e-9, shape["name"]
    return worst


def judge(told):
    held = []
    worst = {}
    for number, draw in enumerate(told["draws"]):
        assert "error" not in draw, f"draw {number}: {draw}"
        shapes, ground = told["shapes"], draw["ground_height_m"]
        objects = [Placed(shapes[o["shape"]], o) for o in draw["objects"]]
        fixed = [Placed(shapes[o["shape"]], o) for o in draw["fixed"]]
        where = f"draw {number} ({draw['kind']})"
        for a in objects:
            assert a.low[1] >= ground - 1e-9, f"{where}: {a.name} is {ground - a.low[1]} m below the ground"
            assert not any(meet(a, b) for b in fixed), f"{where}: {a.name} meets what stands still"
        for a, b in combinations(objects, 2):
            assert not meet(a, b), f"{where}: {a.name} and {b.name} meet"
        if draw["kind"] == "surface":
            assert max(distance(a, fixed[0]) for a in objects) < 1e-6, f"{where}: not on the surface"
        if draw["is_held"]:
            least = unbalance(objects, fixed, ground, draw["friction"])
            worst[draw["kind"]] = max(worst.get(draw["kind"], 0), least)
            assert least < UNHELD, f"{where}: {least} of the weight is not held"
            held.append((number, draw))
    return held, worst


def judge_the_judge(told, held):
    """Moved by twice the tolerance into what is below, objects meet; lifted by as much, nothing holds them."""
    shapes = told["shapes"]
    lifted = met = 0
    for _, draw in held[:40]:
        objects = [Placed(shapes[o["shape"]], o, (0, 2 * TOLERANCE * (i == 0), 0)) for i, o in enumerate(draw["objects"])]
        fixed = [Placed(shapes[o["shape"]], o) for o in draw["fixed"]]
        lifted += unbalance(objects, fixed, draw["ground_height_m"], draw["friction"]) > UNHELD
        down = [Placed(shapes[o["shape"]], o, (0, -TOLERANCE, 0)) for o in draw["objects"][:1]][0]
        others = fixed + [Placed(shapes[o["shape"]], o) for o in draw["objects"][1:]]
        met += down.low[1] < 0 or any(meet(down, other) for other in others)
    # Where an object leans on several, lifting it may leave it held by the sides, and walls are not met by going down.
    assert min(lifted, met) > 0.7 * len(held[:40]), (lifted, met)


def main():
    # A run takes one core: two at once.
    runs = [subprocess.Popen([PROGRAM, COUNT], stdout=subprocess.PIPE, stderr=subprocess.PIPE) for _ in range(2)]
    with ThreadPoolExecutor() as threads:
        (first, times), (again, _) = threads.map(subprocess.Popen.communicate, runs)
    assert [run.returncode for run in runs] == [0, 0], times.decode()
    assert first == again, "two runs differ"
    print(times.decode(), end="")
    told = read(first)
    for shape in told["shapes"]:
        if shape["is_solid"]:
            worst = judge_resting(shape)
            # Where a lump rolls over several small faces, theirs takes another edge out of a triangle than ours out of a face.
            assert worst < (0.01 if shape["name"] == "stone" else 1e-6), f"{shape['name']}: {worst}"
    held, worst = judge(told)
    judge_the_judge(told, held)
    print(f"{len(told['draws'])} draws: no two objects meet; of the weight is not held, at most:", worst)


main()
