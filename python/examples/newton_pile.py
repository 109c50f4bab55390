"""Newton's XPBD solver lets rings fall into a pile, on Pierce's contacts of their true triangles.

    python newton_pile.py [folder]

Writes newton_pile.png into the folder, and prints how near the rings come to each
other and how their kinetic energy goes down.
"""

import math

import matplotlib.pyplot as plt
import newton
import numpy as np
import warp as wp
from _plot import BLUE, GREEN, GREY, ORANGE, RED, SKY, draw_mesh, placed, save, set_box, torus
from pierce.newton import CollisionPipeline

STEPS_PER_SECOND = 480
SECONDS = 2.0
RINGS = 5
MARGIN = 0.005  # [m] of each surface: contacts hold two rings twice this far apart

vertices, triangles = torus(0.3, 0.1, around=24, across=12)


def build():
    """Rings over the ground, each turned and shifted a little against the one below."""
    builder = newton.ModelBuilder()
    mesh = newton.Mesh(vertices, triangles.flatten().astype(np.int32))
    look = newton.ModelBuilder.ShapeConfig(density=500.0, mu=0.6, margin=MARGIN, gap=0.005)
    for k in range(RINGS):
        turn = wp.quat_rpy(0.25 * math.sin(2 * k), 0.3 * math.cos(3 * k), 0.0)
        place = wp.vec3(0.12 * math.cos(2.4 * k), 0.12 * math.sin(2.4 * k), 0.25 + 0.45 * k)
        body = builder.add_body(xform=wp.transform(place, turn))
        builder.add_shape_mesh(body, mesh=mesh, cfg=look)
    builder.add_ground_plane(cfg=look)
    return builder.finalize(device="cpu")


def kinetic_energy(model, state):
    """[J] of all bodies."""
    velocity = state.body_qd.numpy()
    rotation = [wp.quat_to_matrix(wp.quat(*q)) for q in state.body_q.numpy()[:, 3:]]
    turning = np.einsum("nji,nj->ni", np.array(rotation).reshape(-1, 3, 3), velocity[:, 3:])
    energy = model.body_mass.numpy() * (velocity[:, :3] ** 2).sum(1)
    energy += np.einsum("ni,nij,nj->n", turning, model.body_inertia.numpy(), turning)
    return energy.sum() / 2


def main():
    wp.config.log_level = wp.LOG_ERROR
    model = build()
    pipeline = CollisionPipeline(model)
    contacts = pipeline.contacts()
    solver = newton.solvers.SolverXPBD(model, iterations=8)
    state, following, control = model.state(), model.state(), model.control()
    times, energies, gaps, counts = [], [], [], []
    for step in range(int(SECONDS * STEPS_PER_SECOND)):
        state.clear_forces()
        pipeline.collide(state, contacts)
        gaps.append(pipeline.world.contacts.distance.min(initial=2 * MARGIN))
        counts.append(contacts.rigid_contact_count.numpy()[0])
        times.append(step / STEPS_PER_SECOND)
        energies.append(kinetic_energy(model, state))
        solver.step(state, following, control, contacts, 1 / STEPS_PER_SECOND)
        state, following = following, state

    print(f"kinetic energy: {max(energies):.1f} J at most, {energies[-1]:.2f} J at the end")
    print(
        f"rings overlap by {1000 * max(0, -min(gaps)):.2f} mm at most; they are "
        f"{1000 * min(gaps):.2f} mm apart at least, of {2000 * MARGIN:.0f} mm"
    )
    print(f"contacts: {max(counts)} at most")

    figure = plt.figure(figsize=(10, 4.5))
    axes = figure.add_subplot(1, 2, 1, projection="3d")
    rings = [placed(vertices, pose) for pose in state.body_q.numpy()]
    for ring, color in zip(rings, [BLUE, ORANGE, GREEN, SKY, GREY], strict=True):
        draw_mesh(axes, ring, triangles, color)
    set_box(axes, *rings)
    axes.view_init(35, -60)
    curves = figure.add_subplot(1, 2, 2)
    curves.plot(times, energies, color=BLUE)
    curves.set(xlabel="time [s]", ylabel="kinetic energy [J]")
    apart = curves.twinx()
    apart.plot(times, 1000 * np.array(gaps), color=RED, linewidth=0.8)
    apart.set(ylim=(0, 2500 * MARGIN))
    apart.set_ylabel("least gap between two rings [mm]", color=RED)
    figure.tight_layout(w_pad=4)
    save(figure, "newton_pile")


main()
