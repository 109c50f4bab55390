"""64 worlds in one: each has a box of rings, and one step finds the contacts of all.

A small world is built once and replicated. Bodies of different worlds never meet. Poses come from
one NumPy array, and world_offsets() says which contacts are of which world.

    python many_worlds.py [folder for the picture]
"""

import time

import matplotlib.pyplot as plt
import numpy as np
import pierce
from _plot import BLUE, GREY, ORANGE, SKY, draw_mesh, placed, save, set_box, torus

WORLDS, RINGS = 64, 6
vertices, triangles = torus(0.5, 0.18, 24, 12)
plate = np.float32([[-1.6, -1.6, 0], [1.6, -1.6, 0], [1.6, 1.6, 0], [-1.6, 1.6, 0]])
slab = np.concatenate([plate - np.float32([0, 0, 0.2]), plate])
sides = np.uint32(
    [
        [0, 2, 1],
        [0, 3, 2],
        [4, 5, 6],
        [4, 6, 7],
        [0, 1, 5],
        [0, 5, 4],
        [1, 2, 6],
        [1, 6, 5],
        [2, 3, 7],
        [2, 7, 6],
        [3, 0, 4],
        [3, 4, 7],
    ]
)

world = pierce.World(threads=1)
ground = world.add_mesh((slab, sides), "ground")
ring = world.add_mesh((vertices, triangles), "ring")
for body in [world.add_fixed_body(ground)] + [world.add_rigid_body(ring) for _ in range(RINGS)]:
    world.set_filter(body, pierce.Filter(world=0))
world.replicate(0, WORLDS - 1)

# Every ring of every world gets its own pose: position, quaternion x, y, z, w.
random = np.random.default_rng(7)
rings = np.concatenate([pierce.ids(world.bodies_of(number)[1:]) for number in world.worlds()])
poses = np.empty((WORLDS, RINGS, 7), np.float32)
poses[..., :2] = random.uniform(-1, 1, (WORLDS, RINGS, 2))
poses[..., 2] = random.uniform(0.15, 1.2, (WORLDS, RINGS))
poses[..., 3:] = random.normal(size=(WORLDS, RINGS, 4))
poses[..., 3:] /= np.linalg.norm(poses[..., 3:], axis=2, keepdims=True)

world.set_poses(rings, poses.reshape(-1, 7))
world.detect()  # the first step makes the trees
poses[..., 2] -= 0.01
world.set_poses(rings, poses.reshape(-1, 7))
begin = time.perf_counter()
contacts = world.detect()
milliseconds = 1e3 * (time.perf_counter() - begin)

offsets = world.world_offsets()
count = np.diff(offsets.solids)
depth = [
    contacts.depth[begin:end].max(initial=0)
    for begin, end in zip(offsets.solids, offsets.solids[1:])
]
print(
    f"{WORLDS} worlds of {RINGS} rings: {len(contacts)} contacts in {milliseconds:.1f} ms, "
    f"{count.min()} to {count.max()} a world"
)
print(f"world {np.argmax(depth)} has the deepest contact, {max(depth):.3f} m")

figure = plt.figure(figsize=(13, 4.2))
grid = figure.add_gridspec(1, 3, width_ratios=(1, 1.1, 1.1), wspace=0.25)
for column, number in enumerate((int(count.argmin()), int(count.argmax()))):
    scene = figure.add_subplot(grid[column + 1], projection="3d")
    shown = [placed(vertices, pose) for pose in poses[number]]
    for place, each in enumerate(shown):
        draw_mesh(scene, each, triangles, (BLUE, SKY, ORANGE)[place % 3])
    draw_mesh(scene, slab, sides, GREY, alpha=0.12)
    set_box(scene, slab, *shown, zoom=0.9)
    scene.set_title(f"world {offsets.worlds[number]}: {count[number]} contacts")
axes = figure.add_subplot(grid[0])
axes.hist(count, bins=16, color=BLUE, edgecolor="white")
axes.set(xlabel="contacts in a world", ylabel="worlds", title=f"{WORLDS} worlds, one step")
save(figure, "many_worlds")
