"""Renders a scene of the comparison in Cycles: `python cycles_program.py FOLDER OUT.npy SAMPLES SEED THREADS [guided]`.

Blender's module bpy is under the GPL. This file is a program of its own, which a bench starts as another process and which
shares no code with photosite; nothing of Blender is linked to photosite or shipped with it.

Settings are Blender's own but for those that change the image that is estimated, and the number of samples: no clamping, no
softened reflections (`blur_glossy`), no denoising, no adaptive sampling, a box filter, and the bounces of the scene. Path
guiding is off, as it is by default, unless asked for. OUT.json gets the wall and processor seconds of the render call.
"""

import json
import sys
import time
from pathlib import Path

import bpy
import numpy as np
from mathutils import Matrix, Vector


def mesh(name, arrays):
    """A mesh of Blender with normals and UVs."""
    data = bpy.data.meshes.new(name)
    data.from_pydata(arrays["positions"].tolist(), [], arrays["triangles"].tolist())
    if "uvs" in arrays:
        corners = np.empty(len(data.loops), dtype=np.int32)
        data.loops.foreach_get("vertex_index", corners)
        uvs = arrays["uvs"][corners] * (1, -1) + (0, 1)
        data.uv_layers.new().data.foreach_set("uv", uvs.reshape(-1))
    if "normals" in arrays:
        data.shade_smooth()
        data.normals_split_custom_set_from_vertices(arrays["normals"].tolist())
    else:
        data.shade_flat()
    return data


class Nodes:
    """The nodes of a material or of the world."""

    def __init__(self, owner):
        self.tree = owner.node_tree
        self.tree.nodes.clear()

    def add(self, kind, **inputs):
        """A node, its inputs values or outputs of others."""
        node = self.tree.nodes.new(kind)
        for name, value in inputs.items():
            socket = node.inputs[int(name[1:]) if name[1:].isdigit() else name.replace("_", " ")]
            if isinstance(value, bpy.types.NodeSocket):
                self.tree.links.new(value, socket)
            else:
                socket.default_value = value
        return node

    def image(self, kind, path, colour, **inputs):
        node = self.add(kind, **inputs)
        node.image = bpy.data.images.load(str(path))
        node.image.colorspace_settings.name = "sRGB" if colour else "Non-Color"
        return node.outputs["Color"]


def material(name, described, folder):
    """A material of Blender."""
    made = bpy.data.materials.new(name)
    nodes = Nodes(made)
    rgba = (*described["rgb"], 1.0)
    if described["kind"] == "dielectric":
        shader = nodes.add("ShaderNodeBsdfGlass", Color=(1, 1, 1, 1), Roughness=0.0, IOR=described["index"])
    elif described["kind"] == "metallic-roughness":
        colour, rough, metallic = rgba, described["roughness"], described["metallic"]
        if "colour_texture" in described:
            colour = nodes.image("ShaderNodeTexImage", folder / described["colour_texture"], True)
            packed = nodes.image("ShaderNodeTexImage", folder / described["metal_texture"], False)
            split = nodes.add("ShaderNodeSeparateColor", Color=packed)
            rough, metallic = split.outputs["Green"], split.outputs["Blue"]
        shader = nodes.add("ShaderNodeBsdfPrincipled", Base_Color=colour, Roughness=rough, Metallic=metallic, IOR=1.5)
    else:
        shader = nodes.add("ShaderNodeBsdfDiffuse", Color=rgba, Roughness=0.0)
    if described["radiance"]:
        # Lamps shine from their fronts.
        behind = nodes.add("ShaderNodeNewGeometry").outputs["Backfacing"]
        front = nodes.add("ShaderNodeMath", _0=1.0, _1=behind)
        front.operation = "SUBTRACT"
        emission = nodes.add("ShaderNodeEmission", Color=(*described["radiance"], 1.0), Strength=front.outputs[0])
        shader = nodes.add("ShaderNodeAddShader", _0=shader.outputs[0], _1=emission.outputs[0])
        made.cycles.emission_sampling = "FRONT"
    nodes.add("ShaderNodeOutputMaterial", Surface=shader.outputs[0])
    return made


def surround(environment, folder):
    """The world's light. The middle of an image is towards −z, its right towards +x."""
    world = bpy.data.worlds.new("world")
    bpy.context.scene.world = world
    nodes = Nodes(world)
    colour, strength = (0, 0, 0, 1), 1.0
    if environment and "image" in environment:
        # Blender's images have their middle towards x, their right towards −y, up towards z.
        split = nodes.add("ShaderNodeSeparateXYZ", Vector=nodes.add("ShaderNodeTexCoord").outputs["Generated"])
        minus = {}
        for axis in "XZ":
            node = nodes.add("ShaderNodeMath", _0=split.outputs[axis], _1=-1.0)
            node.operation = "MULTIPLY"
            minus[axis] = node.outputs[0]
        turned = nodes.add("ShaderNodeCombineXYZ", X=minus["Z"], Y=minus["X"], Z=split.outputs["Y"])
        path = folder / environment["image"]
        colour = nodes.image("ShaderNodeTexEnvironment", path, False, Vector=turned.outputs[0])
        strength = environment["scale"]
    elif environment:
        colour = (*environment["radiance"], 1.0)
    background = nodes.add("ShaderNodeBackground", Color=colour, Strength=strength)
    nodes.add("ShaderNodeOutputWorld", Surface=background.outputs[0])


def view(described):
    """The camera."""
    data = bpy.data.cameras.new("camera")
    data.sensor_fit, data.sensor_width = "HORIZONTAL", 36.0
    data.angle = np.radians(described["field_of_view_deg"])
    data.clip_start, data.clip_end = 0.001, 1e4
    if described["aperture_radius_m"]:
        data.dof.use_dof = True
        data.dof.focus_distance = described["focus_m"]
        data.dof.aperture_fstop = data.lens / 1000 / (2 * described["aperture_radius_m"])
    camera = bpy.data.objects.new("camera", data)
    eye, target = Vector(described["eye"]), Vector(described["target"])
    back = (eye - target).normalized()
    right = Vector((0, 1, 0)).cross(back).normalized()
    turn = Matrix((right, back.cross(right), back)).transposed()
    camera.matrix_world = Matrix.Translation(eye) @ turn.to_4x4()
    bpy.context.collection.objects.link(camera)
    bpy.context.scene.camera = camera


def settings(described, samples, seed, threads, guided):
    """Blender's factory settings with the changes that are named above."""
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    scene.render.resolution_x = scene.render.resolution_y = described["size"]
    scene.render.resolution_percentage = 100
    if threads:
        scene.render.threads_mode, scene.render.threads = "FIXED", threads
    cycles = scene.cycles
    cycles.device, cycles.samples, cycles.seed = "CPU", samples, seed
    cycles.use_adaptive_sampling = cycles.use_denoising = False
    cycles.sample_clamp_direct = cycles.sample_clamp_indirect = cycles.blur_glossy = 0.0
    cycles.pixel_filter_type = "BOX"
    cycles.use_guiding = guided
    # One segment leads to the first surface, one to the lamp.
    bounces = described["max_depth"] - 2
    cycles.max_bounces = cycles.diffuse_bounces = cycles.glossy_bounces = cycles.transmission_bounces = bounces


def main():
    folder, out, samples, seed, threads, *more = sys.argv[1:]
    folder = Path(folder)
    described = json.loads((folder / "scene.json").read_text(encoding="utf-8"))
    arrays = np.load(folder / "scene.npz")
    bpy.ops.wm.read_factory_settings(use_empty=True)
    materials = {name: material(name, entry, folder) for name, entry in described["materials"].items()}
    for i, entry in enumerate(described["meshes"]):
        data = mesh(f"mesh-{i}", {name: arrays[f"{i}-{name}"] for name in entry["arrays"]})
        data.materials.append(materials[entry["material"]])
        bpy.context.collection.objects.link(bpy.data.objects.new(data.name, data))
    surround(described["environment"], folder)
    view(described)
    settings(described, int(samples), int(seed), int(threads), "guided" in more)
    image = bpy.context.scene.render.image_settings
    image.file_format, image.color_depth, image.color_mode = "OPEN_EXR", "32", "RGB"
    picture = Path(out).with_suffix(".exr")
    bpy.context.scene.render.filepath = str(picture)
    wall, busy = time.perf_counter(), time.process_time()
    bpy.ops.render.render(write_still=True)
    seconds = time.perf_counter() - wall, time.process_time() - busy
    made = bpy.data.images.load(str(picture))
    pixels = np.empty(made.size[0] * made.size[1] * made.channels, dtype=np.float32)
    made.pixels.foreach_get(pixels)
    # Blender's rows go up.
    np.save(out, pixels.reshape(made.size[1], made.size[0], -1)[::-1, :, :3])
    Path(out).with_suffix(".json").write_text(json.dumps({"wall_s": seconds[0], "busy_s": seconds[1]}), encoding="utf-8")


if __name__ == "__main__":
    main()
