# tests/export/blender.py - where Blender has the bodies of a .glb at three times, against the .csv of the same replay.
#   blender -b --factory-startup -P blender.py -- FILE.glb FILE.csv
import csv
import sys

import numpy

numpy.bool = bool       # Blender 3.4 of Debian 12 was made for an older NumPy
import bpy

glb, table = sys.argv[sys.argv.index("--") + 1:]
bpy.ops.wm.read_factory_settings(use_empty=True)
bpy.context.scene.render.fps = 60
bpy.ops.import_scene.gltf(filepath=glb)

rows = list(csv.DictReader(open(table, newline="")))
times = sorted({float(r["time"]) for r in rows})
start = times[0]
names = [r["name"] for r in rows if float(r["time"]) == start]
unique = {n for n in names if names.count(n) == 1 and n in bpy.data.objects}
checked, worst = 0, 0.0
for when in (times[0], times[len(times) // 3], times[-1]):
    frame = (when - start) * 60
    bpy.context.scene.frame_set(int(frame + 1e-6), subframe=max(0.0, min(0.999999, frame - int(frame + 1e-6))))
    for r in rows:
        if float(r["time"]) == when and r["name"] in unique:
            p = bpy.data.objects[r["name"]].matrix_world.translation          # Blender's z is up
            off = max(abs(p.x - float(r["x"])), abs(p.z - float(r["y"])), abs(-p.y - float(r["z"])))
            checked, worst = checked + 1, max(worst, off)
print("CHECKED %d places, worst %.2g m" % (checked, worst))
sys.exit(0 if checked >= 6 and worst < 1e-5 else 1)
