"""Draws the chart of an exported material with Cycles. Prints linear Rec.709 as JSON.

arguments: script of the export, name of its material, samples[, path of an OSL shader and of its table, its range]
A parallel view of 24 patches in a row, tilted by each of the seven angles, in front of black, under a white world. The
thickness goes up from left to right by u, v: the map that the export lays over v is read at the middle of its texels.
"""

import json
import math
import sys
import tempfile
from pathlib import Path

import bpy

script, name, samples = sys.argv[1], sys.argv[2], int(sys.argv[3])
ANGLES = [0.0, 15.0, 30.0, 45.0, 60.0, 75.0, 85.0]
ROWS = 256  # of the ramp

bpy.ops.wm.read_factory_settings(use_empty=True)
if script.endswith(".py"):
    exec(compile(Path(script).read_text(), script, "exec"), {"__file__": script, "__name__": "__main__"})
scene = bpy.context.scene


def osl_material() -> bpy.types.Material:
    """A surface that glows in what the OSL shader says. The sockets are made by hand: bpy lacks the module oslquery."""
    import _cycles

    table, low, high = sys.argv[4], float(sys.argv[5]), float(sys.argv[6])
    with tempfile.TemporaryDirectory() as folder:
        compiled = str(Path(folder) / "film.oso")
        assert _cycles.osl_compile(script, compiled), "oslc refuses the shader"
        bytecode = Path(compiled).read_text()
    scene.cycles.shading_system = True
    made = bpy.data.materials.new(name)
    made.use_nodes = True
    tree = made.node_tree
    tree.nodes.clear()
    node = tree.nodes.new("ShaderNodeScript")
    node.mode = "EXTERNAL"
    node.bytecode, node.bytecode_hash = bytecode, "1"
    node.inputs.new("NodeSocketString", "lut_file").default_value = table
    node.inputs.new("NodeSocketFloat", "thickness_nm")
    node.outputs.new("NodeSocketColor", "xyz")
    # v of the ramp back to the share of the range.
    uv = tree.nodes.new("ShaderNodeUVMap")
    parts = tree.nodes.new("ShaderNodeSeparateXYZ")
    tree.links.new(uv.outputs[0], parts.inputs[0])
    value = parts.outputs[1]
    for operation, number in (
        ("MULTIPLY_ADD", (-ROWS, ROWS - 0.5)),
        ("MULTIPLY_ADD", ((high - low) / (ROWS - 1), low)),
    ):
        math_node = tree.nodes.new("ShaderNodeMath")
        math_node.operation = operation
        tree.links.new(value, math_node.inputs[0])
        math_node.inputs[1].default_value, math_node.inputs[2].default_value = number
        value = math_node.outputs[0]
    tree.links.new(value, node.inputs["thickness_nm"])
    glow = tree.nodes.new("ShaderNodeEmission")
    tree.links.new(node.outputs["xyz"], glow.inputs["Color"])
    tree.links.new(glow.outputs[0], tree.nodes.new("ShaderNodeOutputMaterial").inputs[0])
    return made


material = osl_material() if script.endswith(".osl") else bpy.data.materials[name]

world = bpy.data.worlds.new("white")
scene.world = world
world.use_nodes = True
world.node_tree.nodes["Background"].inputs[0].default_value = (1.0, 1.0, 1.0, 1.0)

black = bpy.data.materials.new("black")
black.use_nodes = True
black.node_tree.nodes.clear()
nothing = black.node_tree.nodes.new("ShaderNodeEmission")
nothing.inputs["Strength"].default_value = 0.0
out = black.node_tree.nodes.new("ShaderNodeOutputMaterial")
black.node_tree.links.new(nothing.outputs[0], out.inputs[0])


def row(depth: float, patches: bool, half: float) -> bpy.types.Object:
    """24 patches one unit wide each, in the plane z = depth."""
    vertices, faces, uv = [], [], []
    for i in range(24):
        left, right = i - 12.0, i - 11.0
        faces.append(tuple(range(len(vertices), len(vertices) + 4)))
        vertices += [(left, -half, depth), (right, -half, depth), (right, half, depth), (left, half, depth)]
        uv += [(0.5, 1.0 - (0.5 + (ROWS - 1) * i / 23.0) / ROWS)] * 4
    mesh = bpy.data.meshes.new("row")
    mesh.from_pydata(vertices, [], faces)
    layer = mesh.uv_layers.new(name="uv")
    for loop, place in zip(layer.data, uv, strict=True):
        loop.uv = place
    mesh.materials.append(material if patches else black)
    row_object = bpy.data.objects.new("row", mesh)
    scene.collection.objects.link(row_object)
    return row_object


camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
scene.collection.objects.link(camera)
camera.data.type = "ORTHO"
camera.data.ortho_scale = 24.0
camera.location = (0.0, 0.0, 500.0)
camera.data.clip_end = 2000.0
scene.camera = camera

scene.render.engine = "CYCLES"
scene.cycles.device = "CPU"
scene.cycles.samples = samples
scene.cycles.use_denoising = False
scene.cycles.use_adaptive_sampling = False
scene.cycles.pixel_filter_type = "BOX"
scene.cycles.transparent_max_bounces = 4
scene.cycles.max_bounces = 4
scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = 24, 2, 100
scene.view_settings.view_transform = "Raw"
scene.render.image_settings.file_format = "OPEN_EXR"
scene.render.image_settings.color_depth = "32"

strip, back = row(0.0, True, 60.0), row(-0.5, False, 200.0)
rows = []
with tempfile.TemporaryDirectory() as folder:
    for angle in ANGLES:
        strip.rotation_euler = back.rotation_euler = (math.radians(angle), 0.0, 0.0)
        scene.render.filepath = str(Path(folder) / "row.exr")
        bpy.ops.render.render(write_still=True)
        image = bpy.data.images.load(scene.render.filepath)
        image.colorspace_settings.name = "Non-Color"
        pixels = list(image.pixels)
        bpy.data.images.remove(image)
        rows.append([[sum(pixels[4 * (y * 24 + x) + c] for y in range(2)) / 2 for c in range(3)] for x in range(24)])
kinds = [node.bl_idname for node in material.node_tree.nodes]
print()
print(json.dumps({"version": bpy.app.version_string, "rgb": rows, "nodes": kinds}))
