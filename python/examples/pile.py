"""A pile of tori: what each coverage costs, and what it does not see.

Bullet lets tori fall and the motion is recorded. Then three settings get the same frames:
`vertices` looks at vertices only, `overlaps` also at edges of pairs whose vertices find no depth,
`complete` at all edges.
The error is measured without the settings: World.parting tries how far a pair has to move until
it is apart. A pair that has no contact is wrong by all of that.

    python pile.py [folder for the picture]
"""

import matplotlib.pyplot as plt
import numpy as np
import pierce
from _plot import BLUE, GREEN, GREY, ORANGE, SKY, draw_mesh, placed, save, set_box

COVERAGES = {"vertices": BLUE, "overlaps": ORANGE, "complete": GREEN}

recording = pierce.simulate("tori", count=40, seconds=3.0, threads=1)
frames = np.arange(recording.frame_count)
seconds = frames * recording.dt


def pairs_of(contacts):
    """Numbers of the bodies that are in contact, a set of (a, b)."""
    return set(zip(contacts.a.tolist(), contacts.b.tolist()))


milliseconds, found = {}, {}
for coverage in COVERAGES:
    replay = pierce.Replay(recording, threads=1, coverage=coverage)
    found[coverage] = [pairs_of(replay.step(frame)) for frame in frames]
    replay = pierce.Replay(recording, threads=1, coverage=coverage)
    milliseconds[coverage] = np.empty(len(frames))
    for frame in frames:
        replay.step(frame)
        milliseconds[coverage][frame] = replay.world.stats.milliseconds


def near_pairs(world):
    """Handles of the pairs whose boxes overlap, a list of (a, b)."""
    boxes = world.body_boxes()
    lower, upper = (np.array([getattr(box, side) for box in boxes]) for side in ("lower", "upper"))
    overlap = (lower[:, None] <= upper).all(2) & (lower <= upper[:, None]).all(2)
    return [(boxes[a].body, boxes[b].body) for a, b in np.argwhere(np.triu(overlap, 1))]


# The truth, in every fourth frame.
sampled = frames[::4]
missed = {coverage: np.zeros(len(sampled)) for coverage in COVERAGES}
judge = pierce.Replay(recording, threads=1)
overlapping = 0
for place, frame in enumerate(sampled):
    judge.step(frame)
    for a, b in near_pairs(judge.world):
        parting = judge.world.parting(a, b)
        overlapping += parting is not None
        for coverage in COVERAGES:
            if parting and (int(a), int(b)) not in found[coverage][frame]:
                missed[coverage][place] = max(missed[coverage][place], parting.depth)

print(
    f"{overlapping} overlapping pairs in {len(sampled)} frames; largest overlap not seen: "
    + ", ".join(f"{name} {missed[name].max():.3g} m" for name in COVERAGES)
)
checked = pierce.validate(recording, ["embree", "reference"], every=45, threads=1)
print(
    "a loop over all triangles finds "
    + ("the same" if checked.differing_frames == 0 else "other")
    + " contacts as Embree in "
    f"{checked.frames} frames"
)

figure = plt.figure(figsize=(11, 5), layout="constrained")
grid = figure.add_gridspec(2, 2, width_ratios=(1, 1.1))
scene = figure.add_subplot(grid[:, 0], projection="3d")
shown = []
for body, name in enumerate(recording.body_names):
    if name.startswith("torus"):
        vertices, triangles = recording.mesh(body)
        shown.append(placed(vertices, recording.motion(body)[-1]))
        draw_mesh(scene, shown[-1], triangles, (SKY, GREY)[body % 2])
set_box(scene, *shown, zoom=0.85)
scene.set_title(f"{len(shown)} tori after {seconds[-1]:.1f} s")

time = figure.add_subplot(grid[0, 1])
error = figure.add_subplot(grid[1, 1], sharex=time)
for place, (name, color) in enumerate(COVERAGES.items()):
    # The first step makes the trees.
    typical = np.median(np.lib.stride_tricks.sliding_window_view(milliseconds[name][1:], 9), 1)
    time.plot(seconds[5:-4], typical, color=color, label=name)
    error.plot(
        seconds[sampled],
        1e3 * missed[name],
        color=color,
        label=name,
        linewidth=1,
        marker="osx"[place],
        markersize=(3, 6, 4)[place],
        markerfacecolor="none",
    )
time.set(ylabel="time of a step [ms]", title="time, one thread (median of 9 frames)")
error.set(xlabel="simulated time [s]", ylabel="overlap [mm]", title="largest overlap not seen")
time.legend()
error.legend()
save(figure, "pile")
