"""A sheet and what Pierce says of it: near, crossing, remembered, tangled.

Bullet lets a sheet, held at its corners, catch four solids; contacts keep them apart, so all of
them are `near`. Then the same sheet stays where it was at first, and the solids fall through it:
features are `crossing` in the step in which they meet, and from then on it is `remembered` on
which side they belong. None is `tangled`, which is what nobody has seen the beginning of.

    python cloth.py [folder for the picture]
"""

import matplotlib.pyplot as plt
import numpy as np
import pierce
from _plot import BLUE, GREEN, GREY, ORANGE, RED, draw_contacts, draw_mesh, placed, save, set_box

KINDS = {"near": BLUE, "crossing": ORANGE, "remembered": GREEN, "tangled": RED}
FALL = 9.81

caught = pierce.simulate("cloth-catch", seconds=2.0, threads=1)
names = caught.body_names
sheet = names.index("sheet")
seconds = np.arange(caught.frame_count) * caught.dt
world = pierce.Replay(caught).world
collision = world.collision_of(world.bodies_of(pierce.all_worlds)[sheet])


def passed_through():
    """The recording, but with a sheet that stays, and solids that nothing holds up."""
    bodies = []
    for body, name in enumerate(names):
        motion = caught.motion(body).copy()
        if body == sheet:
            motion[:] = motion[0]
        elif name.startswith("solid"):
            motion[:] = motion[0]
            motion[:, 2] -= 0.5 * FALL * seconds**2
        bodies.append((name, body, caught.motion_kind(body), motion))
    return pierce.Recording(
        caught.dt, list(zip(names, map(caught.mesh, range(len(names))))), bodies
    )


def counts(recording):
    """How many contacts of the sheet are of each kind in each frame, and the last contacts."""
    replay = pierce.Replay(recording, threads=1)
    replay.world.set_collision(replay.world.bodies_of(pierce.all_worlds)[sheet], collision)
    of_kind = {kind: np.zeros(len(replay)) for kind in KINDS}
    for frame in range(len(replay)):
        contacts = replay.step(frame)
        found = contacts.found[contacts.of_sheet]
        for kind in KINDS:
            of_kind[kind][frame] = np.count_nonzero(found == pierce.Found[kind])
    return of_kind, contacts


kept, contacts = counts(caught)
through, _ = counts(passed_through())
titles = {"caught by the sheet": kept, "falling through the sheet": through}
for title, of_kind in titles.items():
    print(
        f"{title}, most contacts in a step: "
        + ", ".join(f"{of_kind[kind].max():.0f} {kind}" for kind in KINDS)
    )

figure = plt.figure(figsize=(12, 4.8), layout="constrained")
grid = figure.add_gridspec(2, 2, width_ratios=(1.25, 1))
scene = figure.add_subplot(grid[:, 0], projection="3d")
_, triangles = caught.mesh(sheet)
cloth = caught.positions(sheet, caught.frame_count - 1)
draw_mesh(scene, cloth, triangles, GREY, alpha=0.35)
mine = contacts.of_sheet
draw_contacts(
    scene,
    contacts.point_a[mine],
    1e3 * (collision.thickness - contacts.distance[mine]),
    label="thickness less gap [mm]",
)
solids = []
for body, name in enumerate(names):
    if name.startswith("solid"):
        vertices, of_solid = caught.mesh(body)
        solids.append(placed(vertices, caught.motion(body)[-1]))
        draw_mesh(scene, solids[-1], of_solid, ORANGE, alpha=0.12)
set_box(scene, cloth, *solids, zoom=1.1)
scene.view_init(-24, -60)
scene.set_title(f"the sheet, seen from below, after {seconds[-1]:.1f} s")

for row, (title, of_kind) in enumerate(titles.items()):
    axes = figure.add_subplot(grid[row, 1])
    for kind, color in KINDS.items():
        axes.plot(seconds, of_kind[kind], color=color, label=kind, linewidth=1.4)
    axes.set(title=title, xlim=(0, seconds[-1]), ylabel="contacts")
axes.set(xlabel="time [s]")
axes.legend(loc="upper right")
save(figure, "cloth")
