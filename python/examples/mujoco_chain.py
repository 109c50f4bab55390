"""A chain of rings in MuJoCo, which convex hulls cannot hold.

MuJoCo takes the hull of a mesh, so a ring is a full disc, and linked rings overlap from the
start. pierce.mujoco takes over the contacts between meshes, and the chain hangs and swings.

    python mujoco_chain.py [folder for the picture]
"""

import time

import matplotlib.pyplot as plt
import mujoco
import numpy as np
from _plot import BLUE, ORANGE, RED, draw_mesh, save, set_box, torus
from pierce.mujoco import MeshContacts

LINKS, SECONDS = 6, 2.5
vertices, triangles = torus(0.3, 0.09, 28, 14)


def numbers(values):
    return " ".join(f"{value:.9g}" for value in np.ravel(values))


links = "".join(
    f'<body pos="0 0 {-0.4 * link}" euler="{"90 0 0" if link % 2 else "0 90 0"}">'
    f'{"<freejoint/>" if link else ""}<geom type="mesh" mesh="ring" density="1000"/></body>'
    for link in range(LINKS)
)
model = mujoco.MjModel.from_xml_string(f"""
<mujoco>
  <option timestep="0.002" integrator="implicitfast"/>
  <size memory="20M"/>
  <asset><mesh name="ring" inertia="exact" vertex="{numbers(vertices)}"
    face="{numbers(triangles)}"/></asset>
  <worldbody>{links}<geom type="plane" size="3 3 .1" pos="0 0 -3"/></worldbody>
</mujoco>""")


def simulate(step):
    """Data after the last step, and how far [m] the last link has come in every step."""
    data, ways = mujoco.MjData(model), []
    start = data.qpos[-7:-4].copy()
    data.qvel[-6] = 1.5  # the last link starts sideways
    while data.time < SECONDS:
        step(model, data)
        ways.append(np.linalg.norm(data.qpos[-7:-4] - start))
    return data, np.array(ways)


hulls, hull_ways = simulate(mujoco.mj_step)
with MeshContacts(model) as contacts:
    begin = time.perf_counter()
    held, ways = simulate(contacts.step)
    milliseconds = 1e3 * (time.perf_counter() - begin) / len(ways)
    print(
        f"true rings: the last link swings by up to {ways.max():.2f} m, {held.ncon} contacts, "
        f"{milliseconds:.2f} ms a step"
    )
print(f"convex hulls: the last link flies {hull_ways.max():.2f} m")


def draw(axes, data, title):
    mesh, shown = slice(0, model.mesh_vertnum[0]), []
    for geom in np.flatnonzero(model.geom_type == mujoco.mjtGeom.mjGEOM_MESH):
        turn = data.geom_xmat[geom].reshape(3, 3)
        shown.append(model.mesh_vert[mesh] @ turn.T + data.geom_xpos[geom])
        draw_mesh(axes, shown[-1], model.mesh_face, (BLUE, ORANGE)[geom % 2])
    set_box(axes, [[-1.2, -1.2, -3.0], [1.2, 1.2, 0.4]], *shown, zoom=0.9)
    axes.set_title(title)


figure = plt.figure(figsize=(13, 4.6))
grid = figure.add_gridspec(1, 3, wspace=0.3)
axes = figure.add_subplot(grid[0])
seconds = model.opt.timestep * np.arange(1, len(ways) + 1)
axes.plot(seconds, hull_ways, color=RED, linestyle="--", label="convex hulls")
axes.plot(seconds, ways, color=BLUE, label="true rings")
axes.set(xlabel="time [s]", ylabel="way of the last link [m]")
axes.legend()
draw(figure.add_subplot(grid[1], projection="3d"), held, f"true rings after {SECONDS} s")
draw(figure.add_subplot(grid[2], projection="3d"), hulls, f"convex hulls after {SECONDS} s")
save(figure, "mujoco_chain")
