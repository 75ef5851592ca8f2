"""Draws a scan with its labels, and the shapes that the world made of it: `draw_scan.py
[OUT.png]`. Written to be read cell by cell, as a notebook.
"""

# %% The scan, and what the world holds of it.
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

import cwm
from table_scan import camera_pose, table_scan

points = table_scan()
with cwm.connect(world="draw_scan") as world:
    scan = world.ingest(points, x_world_sensor=camera_pose())
    meshes = {obj.name: obj.mesh() for obj in scan.objects}

# %% A colour for each object; what nothing explains is grey.
objects = [*scan.supports, *scan.objects]
colors = {obj.name: plt.get_cmap("tab10")(i % 10) for i, obj in enumerate(objects)}
pixel_colors = np.full((scan.labels.size, 4), (0.6, 0.6, 0.6, 1.0))
for obj in objects:
    pixel_colors[scan.mask(obj)] = colors[obj.name]
pixel_colors[~np.isfinite(points).all(axis=-1).ravel()] = (1, 1, 1, 1)

# %% On the left what the camera saw, on the right the shapes where the world has them.
figure = plt.figure(figsize=(11, 4.5))
picture = figure.add_subplot(1, 2, 1, title="labels of the scan")
picture.imshow(pixel_colors.reshape(*points.shape[:2], 4))
picture.axis("off")

room = figure.add_subplot(1, 2, 2, projection="3d", title=f"world, revision {scan.revision}")
for obj in scan.objects:
    vertices, triangles = meshes[obj.name]
    placed = vertices @ obj.pose[:3, :3].T + obj.position
    room.plot_trisurf(*placed.T, triangles=triangles, color=colors[obj.name], linewidth=0)
    room.text(*(obj.position + [0, 0, 0.12]), obj.name, ha="center")
for support in scan.supports:
    for part in support.parts:
        if isinstance(part.shape, cwm.Plate):
            outline = (
                np.array([(x, y, 0, 1) for x, y in part.shape.outline])
                @ (support.pose @ part.pose).T
            )
            room.plot(*np.vstack([outline, outline[:1]])[:, :3].T, color=colors[support.name])
room.set(xlabel="x (m)", ylabel="y (m)", zlabel="z (m)", zlim=(0, 0.4))
room.set_box_aspect((1, 1, 0.4))
room.view_init(elev=25, azim=200)

# %%
out = sys.argv[1] if len(sys.argv) > 1 else "scan.png"
figure.savefig(out, dpi=110, bbox_inches="tight")
print(f"{out}: {len(scan.supports)} supports and {len(scan.objects)} objects")
