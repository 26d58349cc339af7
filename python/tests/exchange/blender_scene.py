"""Draws a mesh with an exported material under a map of light in Cycles: `blender_scene.py QUESTION.json`.

The question names: script and name of the material, mesh (.npz: positions, normals, uv, triangles; y upwards), environment
(.exr, latitude-longitude as a scene has it), camera (position, target, fov_deg), size, samples, out (.npy, linear Rec.709).
"""

import json
import math
import sys
import tempfile
from pathlib import Path

import bpy
import numpy as np

asked = json.loads(Path(sys.argv[1]).read_text())
bpy.ops.wm.read_factory_settings(use_empty=True)
exec(
    compile(Path(asked["script"]).read_text(), asked["script"], "exec"),
    {"__file__": asked["script"], "__name__": "__main__"},
)
scene = bpy.context.scene


def upright(points):
    """y upwards to z upwards."""
    return np.stack([points[..., 0], -points[..., 2], points[..., 1]], axis=-1)


with np.load(asked["mesh"]) as file:
    positions, normals, uv, triangles = (file[key] for key in ("positions", "normals", "uv", "triangles"))
mesh = bpy.data.meshes.new("shape")
mesh.from_pydata(upright(positions).tolist(), [], triangles.tolist())
layer = mesh.uv_layers.new(name="uv")
for loop, corner in zip(layer.data, triangles.ravel(), strict=True):
    loop.uv = uv[corner]
mesh.normals_split_custom_set_from_vertices(upright(normals).tolist())
mesh.materials.append(bpy.data.materials[asked["name"]])
scene.collection.objects.link(bpy.data.objects.new("shape", mesh))

world = bpy.data.worlds.new("light")
scene.world = world
world.use_nodes = True
tree = world.node_tree
picture = tree.nodes.new("ShaderNodeTexEnvironment")
picture.image = bpy.data.images.load(asked["environment"])
picture.image.colorspace_settings.name = "Non-Color"
place, turn = tree.nodes.new("ShaderNodeTexCoord"), tree.nodes.new("ShaderNodeMapping")
turn.vector_type = "POINT"
# Blender's middle column is +x, a scene's is -z, which is +y here.
turn.inputs["Rotation"].default_value = (0.0, 0.0, -0.5 * math.pi)
tree.links.new(place.outputs["Generated"], turn.inputs["Vector"])
tree.links.new(turn.outputs["Vector"], picture.inputs["Vector"])
tree.links.new(picture.outputs["Color"], tree.nodes["Background"].inputs["Color"])

eye, target = (upright(np.array(asked["camera"][key])) for key in ("position", "target"))
camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
scene.collection.objects.link(camera)
camera.location = eye.tolist()
from mathutils import Vector  # noqa: E402

camera.rotation_euler = Vector((target - eye).tolist()).to_track_quat("-Z", "Y").to_euler()
camera.data.sensor_fit = "VERTICAL"
camera.data.angle_y = math.radians(asked["camera"]["fov_deg"])
scene.camera = camera

scene.render.engine = "CYCLES"
scene.cycles.device = "CPU"
scene.cycles.samples = asked["samples"]
scene.cycles.use_denoising = False
scene.cycles.use_adaptive_sampling = False
scene.cycles.pixel_filter_type = "BOX"
scene.render.resolution_x = scene.render.resolution_y = asked["size"]
scene.render.resolution_percentage = 100
scene.view_settings.view_transform = "Raw"
scene.render.image_settings.file_format = "OPEN_EXR"
scene.render.image_settings.color_depth = "32"
with tempfile.TemporaryDirectory() as folder:
    scene.render.filepath = str(Path(folder) / "picture.exr")
    bpy.ops.render.render(write_still=True)
    image = bpy.data.images.load(scene.render.filepath)
    image.colorspace_settings.name = "Non-Color"
    pixels = np.array(image.pixels[:], dtype=np.float32).reshape(asked["size"], asked["size"], -1)
    np.save(asked["out"], pixels[::-1, :, :3])
print()
print(json.dumps({"version": bpy.app.version_string}))
