"""Positions from NumPy, PyTorch, Warp or CuPy, and contacts that are never copied.

A deforming torus gets its vertices from whatever package is installed, through DLPack. Contacts
are views of Pierce's records, and other packages can share that memory.

    python arrays.py [folder for the picture]
"""

import importlib.util

import matplotlib.pyplot as plt
import numpy as np
import pierce
from _plot import BLUE, ORANGE, draw_contacts, draw_mesh, save, set_box, torus

vertices, triangles = torus()
positions = vertices + np.float32([1.1, 0, 0.35])
positions[:, 2] += 0.3 * np.sin(2 * positions[:, 0])

world = pierce.World()
mesh = world.add_mesh((vertices, triangles), "torus")
world.add_rigid_body(mesh)
soft = world.add_deforming_body(mesh)

# One array for each package that is here, all of the same numbers.
arrays = {"NumPy": positions}
if importlib.util.find_spec("torch"):
    import torch

    arrays["PyTorch"] = torch.from_numpy(positions)
if importlib.util.find_spec("warp"):
    import warp

    warp.config.log_level = warp.LOG_ERROR
    arrays["Warp"] = warp.array(positions, dtype=warp.vec3, device="cpu")
if world.on_device and importlib.util.find_spec("cupy"):
    import cupy

    arrays["CuPy"] = cupy.asarray(positions)

hashes = set()
for array in arrays.values():
    world.set_positions(soft, array)
    contacts = world.detect()
    hashes.add(contacts.hash)
print(
    f"{len(contacts)} contacts from {', '.join(arrays)}: "
    + ("the same from all" if len(hashes) == 1 else "they differ")
)

# Columns of the records: a stride of one record, no memory of their own.
distance = contacts.distance
shared = [np.shares_memory(distance, contacts.records), not distance.flags.owndata]
if "PyTorch" in arrays:
    shared.append(torch.from_dlpack(distance).data_ptr() == distance.ctypes.data)
print(
    f"distance: {distance.dtype} {distance.shape}, stride {distance.strides[0]} bytes; "
    + ("no copy was made" if all(shared) else "it was copied")
)

figure = plt.figure(figsize=(7.5, 5))
axes = figure.add_subplot(projection="3d")
draw_mesh(axes, vertices, triangles, BLUE, alpha=0.2)
draw_mesh(axes, positions, triangles, ORANGE, alpha=0.2)
draw_contacts(axes, contacts.point_a, contacts.depth)
set_box(axes, vertices, positions)
axes.set_title(f"{len(contacts)} contacts, positions from {', '.join(arrays)}")
save(figure, "arrays")
