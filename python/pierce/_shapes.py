"""Triangles of the simple shapes of robots, by trimesh. Axes are z, and middles are at 0."""

from typing import Any

import numpy as np

from ._needs import need
from .files import Triangles, Vertices

SECTIONS = 48
"""Sides around a cylinder or capsule, whose vertices lie on the round surface."""


def box(size: Any) -> tuple[Vertices, Triangles]:
    """[length] `size`: x, y, z."""
    return _arrays(_creation().box(extents=np.asarray(size, float)))


def ellipsoid(radii: Any) -> tuple[Vertices, Triangles]:
    """[length] `radii`: three, or one of a sphere; 1280 triangles."""
    ball = _creation().icosphere(subdivisions=3)
    ball.apply_scale(np.broadcast_to(np.asarray(radii, float), 3))
    return _arrays(ball)


def cylinder(radius: float, length: float) -> tuple[Vertices, Triangles]:
    """[length] both."""
    return _arrays(_creation().cylinder(radius=radius, height=length, sections=SECTIONS))


def capsule(radius: float, length: float) -> tuple[Vertices, Triangles]:
    """[length] both; `length` is that of the straight part."""
    shape = _creation().capsule(height=length, radius=radius, count=[SECTIONS // 2, SECTIONS])
    shape.apply_translation([0, 0, -shape.bounds[:, 2].mean()])
    return _arrays(shape)


def _creation() -> Any:
    return need("trimesh.creation", "trimesh", "a robot's simple shapes")


def _arrays(mesh: Any) -> tuple[Vertices, Triangles]:
    return mesh.vertices.astype(np.float32), mesh.faces.astype(np.uint32)
