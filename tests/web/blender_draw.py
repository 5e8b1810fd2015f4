# SPDX-License-Identifier: Apache-2.0
"""blender -b -P blender_draw.py -- FOLDER: opens each mesh of FOLDER/files.json in Blender and draws it, unlit, from the cameras of
FOLDER/shots.json: {name, eye, target, fovY, width, height}. FOLDER/blender/LABEL-NAME.rgba: 4 bytes a pixel over white, top row first;
LABEL.txt instead where Blender cannot open the file: why."""
import json
import math
import pathlib
import sys

import bpy
import mathutils
import numpy as np

if not hasattr(np, "bool"):
    np.bool = bool  # Debian 12's add-on for glTF still uses it; its NumPy has it no more
folder = pathlib.Path(sys.argv[sys.argv.index("--") + 1])
out = folder / "blender"
out.mkdir(exist_ok=True)
# glTF is y up, Blender z up: (x, y, z) becomes (x, -z, y).
turned = lambda p: mathutils.Vector((p[0], -p[2], p[1]))


def draw(shot, path):
    scene = bpy.context.scene
    camera = scene.camera or bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    if scene.camera is None:
        scene.collection.objects.link(camera)
        scene.camera = camera
    camera.data.sensor_fit, camera.data.angle = "VERTICAL", shot["fovY"]
    camera.data.clip_start = 0.05
    eye, target = turned(shot["eye"]), turned(shot["target"])
    camera.location, camera.rotation_euler = eye, (target - eye).to_track_quat("-Z", "Y").to_euler()
    scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = shot["width"], shot["height"], 100
    scene.render.engine, scene.cycles.samples, scene.cycles.use_denoising = "CYCLES", 8, False
    scene.cycles.max_bounces = 0
    scene.view_settings.view_transform, scene.render.film_transparent = "Standard", True
    scene.render.image_settings.file_format, scene.render.image_settings.color_mode = "PNG", "RGBA"
    scene.render.filepath = str(path.with_suffix(".png"))
    bpy.ops.render.render(write_still=True)
    picture = bpy.data.images.load(scene.render.filepath)
    picture.colorspace_settings.name = "Raw"
    rgba = np.array(picture.pixels[:], np.float32).reshape(shot["height"], shot["width"], 4)[::-1]
    bpy.data.images.remove(picture)
    alpha = rgba[..., 3:]
    rgb = rgba[..., :3] * alpha + 1 - alpha
    pixels = np.concatenate([rgb, np.ones_like(alpha)], axis=2)
    path.write_bytes((pixels * 255 + 0.5).astype(np.uint8).tobytes())


for file in json.loads((folder / "files.json").read_text()):
    if file["kind"] != "mesh":
        continue
    bpy.ops.wm.read_factory_settings(use_empty=True)
    try:
        bpy.ops.import_scene.gltf(filepath=str(folder / file["name"]))
    except Exception as error:  # whatever an add-on raises is an answer
        (out / f"{file['label']}.txt").write_text(str(error))
        continue
    for armature in bpy.data.armatures:
        armature.pose_position = "REST"
    for shot in json.loads((folder / "shots.json").read_text()):
        draw(shot, out / f"{file['label']}-{shot['name']}.rgba")
