"""Renders a scene of the comparison in LuxCore: `python luxcore_program.py FOLDER OUT.npy SAMPLES SEED THREADS`.

Its engine is BIDIRCPU, bidirectional path tracing. Settings are LuxCore's own but for those that change the image that is
estimated, and the number of samples: no filter, and for the path from the camera and that from the lamp half of the scene's
segments each. Both are joined by one more, so that some of its light goes further than that of other programs. Its images lie
one row lower than theirs. OUT.json gets the wall and processor seconds from the start of the session to its end.
"""

import array
import json
import os
import sys
import time
from pathlib import Path

import numpy as np
import pyluxcore


def words(values):
    return " ".join(repr(float(value)) for value in values)


def mesh(scene, name, arrays):
    """Defines a mesh."""
    normals, uvs = arrays.get("normals"), arrays.get("uvs")
    scene.DefineMesh(
        name,
        [tuple(point) for point in arrays["positions"].tolist()],
        [tuple(corners) for corners in arrays["triangles"].tolist()],
        None if normals is None else [tuple(normal) for normal in normals.tolist()],
        None if uvs is None else [tuple(uv) for uv in uvs.tolist()],
        None,
        None,
    )


def material(name, described, folder):
    """Lines of a material, with its textures."""
    key = f"scene.materials.{name}"
    if described["kind"] == "dielectric":
        return [f"{key}.type = glass", f"{key}.kr = 1 1 1", f"{key}.kt = 1 1 1", f"{key}.interiorior = {described['index']}"]
    if described["kind"] == "metallic-roughness":
        colour, rough, metallic = words(described["rgb"]), described["roughness"], described["metallic"]
        lines = []
        if "colour_texture" in described:
            for texture, file, gamma, channel in (
                ("colour", described["colour_texture"], 2.2, "default"),
                ("rough", described["metal_texture"], 1.0, "green"),
                ("metallic", described["metal_texture"], 1.0, "blue"),
            ):
                own = f"scene.textures.{name}-{texture}"
                lines += [f"{own}.type = imagemap", f'{own}.file = "{folder / file}"', f"{own}.gamma = {gamma}", f"{own}.channel = {channel}"]
            colour, rough, metallic = (f"{name}-{texture}" for texture in ("colour", "rough", "metallic"))
        values = [f"{key}.basecolor = {colour}", f"{key}.roughness = {rough}", f"{key}.metallic = {metallic}", f"{key}.specular = 0.5"]
        return [*lines, f"{key}.type = disney", *values]
    lines = [f"{key}.type = matte", f"{key}.kd = {words(described['rgb'])}"]
    if described["radiance"]:
        lines.append(f"{key}.emission = {words(described['radiance'])}")
    return lines


def surround(environment, folder):
    """Lines of the world's light. The middle of an image is towards −z, its right towards +x."""
    key = "scene.lights.around"
    if environment and "image" in environment:
        image = [f"{key}.type = infinite", f'{key}.file = "{folder / environment["image"]}"', f"{key}.gamma = 1"]
        # LuxCore's images have z up, and are seen from outside.
        turn = [[0, -1, 0, 0], [0, 0, 1, 0], [1, 0, 0, 0], [0, 0, 0, 1]]
        columns = [turn[row][column] for column in range(4) for row in range(4)]
        return [*image, f"{key}.transformation = {words(columns)}", f"{key}.gain = {words([environment['scale']] * 3)}"]
    if environment:
        return [f"{key}.type = constantinfinite", f"{key}.color = {words(environment['radiance'])}"]
    return []


def view(described):
    """Lines of the camera."""
    key = "scene.camera"
    aperture = described["aperture_radius_m"]
    return [
        f"{key}.type = perspective",
        f"{key}.lookat.orig = {words(described['eye'])}",
        f"{key}.lookat.target = {words(described['target'])}",
        f"{key}.up = 0 1 0",
        f"{key}.fieldofview = {described['field_of_view_deg']}",
        f"{key}.lensradius = {aperture}",
        f"{key}.focaldistance = {described['focus_m']}",
        f"{key}.autofocus.enable = 0",
        f"{key}.cliphither = 0.001",
    ]


def configuration(described, samples, seed, threads):
    """Lines of the engine and the film."""
    depth, size = described["max_depth"] // 2, described["size"]
    lines = [
        "renderengine.type = BIDIRCPU",
        f"renderengine.seed = {seed + 1}",
        f"path.maxdepth = {depth}",
        f"light.maxdepth = {depth}",
        f"film.width = {size}",
        f"film.height = {size}",
        "film.filter.type = NONE",
        "film.imagepipelines.0.0.type = NOP",
        f"batch.haltspp = {samples}",
    ]
    return lines + ([f"native.threads.count = {threads}"] if threads else [])


def properties(lines):
    parsed = pyluxcore.Properties()
    parsed.SetFromString("\n".join(lines))
    return parsed


def main():
    folder, out, samples, seed, threads = sys.argv[1:]
    folder = Path(folder)
    described = json.loads((folder / "scene.json").read_text(encoding="utf-8"))
    arrays = np.load(folder / "scene.npz")
    pyluxcore.Init()
    pyluxcore.SetLogHandler(lambda message: None)
    scene = pyluxcore.Scene()
    scene.Parse(properties(view(described) + surround(described["environment"], folder)))
    for name, entry in described["materials"].items():
        scene.Parse(properties(material(name, entry, folder)))
    for i, entry in enumerate(described["meshes"]):
        mesh(scene, f"mesh-{i}", {name: arrays[f"{i}-{name}"] for name in entry["arrays"]})
        key = f"scene.objects.object-{i}"
        scene.Parse(properties([f"{key}.shape = mesh-{i}", f"{key}.material = {entry['material']}"]))
    config = pyluxcore.RenderConfig(properties(configuration(described, int(samples), int(seed), int(threads))), scene)
    session = pyluxcore.RenderSession(config)
    wall, busy = time.perf_counter(), time.process_time()
    session.Start()
    # Samples are counted, and the session ends, when statistics are asked for.
    while not session.HasDone():
        time.sleep(0.02)
        session.UpdateStats()
    session.Stop()
    seconds = time.perf_counter() - wall, time.process_time() - busy
    film = session.GetFilm()
    pixels = array.array("f", bytes(4 * 3 * film.GetWidth() * film.GetHeight()))
    film.GetOutputFloat(pyluxcore.FilmOutputType.RGB_IMAGEPIPELINE, pixels, 0)
    # LuxCore's rows go up.
    np.save(out, np.array(pixels).reshape(film.GetHeight(), film.GetWidth(), 3)[::-1])
    Path(out).with_suffix(".json").write_text(json.dumps({"wall_s": seconds[0], "busy_s": seconds[1]}), encoding="utf-8")
    # Some of LuxCore's threads outlive its session, and crash when Python ends.
    sys.stdout.flush()
    os._exit(0)


if __name__ == "__main__":
    main()
