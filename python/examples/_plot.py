"""What the examples' pictures share."""

import sys
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.colors import to_rgb
from mpl_toolkits.mplot3d.art3d import Poly3DCollection

# Okabe and Ito's colours, which the colour-blind can tell apart.
BLUE, ORANGE, GREEN, RED, SKY, GREY = (
    "#0072B2",
    "#E69F00",
    "#009E73",
    "#D55E00",
    "#56B4E9",
    "#999999",
)
DEPTHS = "cividis_r"
LIGHT = np.array([0.4, -0.5, 0.77])


def torus(major=1.0, minor=0.4, around=36, across=18):
    """A torus around z: vertices float32 (n, 3), triangles uint32 (m, 3), outward."""
    u, v = np.meshgrid(np.arange(around), np.arange(across), indexing="ij")
    a, b = 2 * np.pi * u / around, 2 * np.pi * v / across
    r = major + minor * np.cos(b)
    vertices = np.stack([r * np.cos(a), r * np.sin(a), minor * np.sin(b)], -1)
    here, right = u * across + v, (u + 1) % around * across + v
    up, both = u * across + (v + 1) % across, (u + 1) % around * across + (v + 1) % across
    triangles = [
        np.stack(three, -1).reshape(-1, 3) for three in ((here, right, both), (here, both, up))
    ]
    return vertices.reshape(-1, 3).astype(np.float32), np.concatenate(triangles).astype(np.uint32)


def placed(vertices, pose):
    """Vertices (n, 3) at a pose: position, quaternion x, y, z, w."""
    position, axis, w = np.array(pose[:3]), np.array(pose[3:6]), pose[6]
    across = 2 * np.cross(axis, vertices)
    return vertices + w * across + np.cross(axis, across) + position


def draw_mesh(axes, vertices, triangles, color, alpha=1.0, around=None, radius=np.inf):
    """A mesh, lit from above; the part of it that is in a ball."""
    corners = np.asarray(vertices)[np.asarray(triangles)]
    if around is not None:
        corners = corners[np.linalg.norm(corners.mean(1) - around, axis=1) < radius]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-30)
    light = 0.62 + 0.38 * np.clip(normals @ LIGHT, -1, 1)
    colors = np.column_stack([light[:, None] * to_rgb(color), np.full(len(light), alpha)])
    axes.add_collection3d(Poly3DCollection(corners, facecolors=colors, edgecolors="none"))


def draw_contacts(axes, points, depth, normals=None, length=1.0, size=14, label="depth [m]"):
    """Contact points coloured by depth, with arrows, the longest of the given length."""
    if normals is not None:
        arrows = normals * (length * depth / depth.max())[:, None]
        axes.quiver(*points.T, *arrows.T, color=RED, linewidth=1.0, arrow_length_ratio=0.25)
    drawn = axes.scatter(
        *points.T,
        c=depth,
        cmap=DEPTHS,
        s=size,
        depthshade=False,
        edgecolors="black",
        linewidths=0.3,
    )
    axes.figure.colorbar(drawn, ax=axes, shrink=0.6, pad=0.16, label=label)


def set_box(axes, *points, zoom=1.0):
    """Equal scales around all points, and names of the axes."""
    everything = np.concatenate([np.reshape(part, (-1, 3)) for part in points])
    lower, upper = everything.min(0), everything.max(0)
    axes.set(
        xlim=(lower[0], upper[0]),
        ylim=(lower[1], upper[1]),
        zlim=(lower[2], upper[2]),
        xlabel="x [m]",
        ylabel="y [m]",
        zlabel="z [m]",
    )
    axes.set_box_aspect(np.maximum(upper - lower, 1e-9), zoom=zoom)
    axes.locator_params(nbins=4)


def save(figure, name):
    """Writes the picture into the folder that is the first argument."""
    folder = Path(sys.argv[1] if len(sys.argv) > 1 else ".")
    folder.mkdir(parents=True, exist_ok=True)
    figure.savefig(folder / f"{name}.png", dpi=150, bbox_inches="tight")
    plt.close(figure)
    print(f"picture: {folder / name}.png")
