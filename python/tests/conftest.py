"""What the tests share: shapes, and a world with two bodies that overlap."""

import numpy as np
import pierce
import pytest


def torus(major=1.0, minor=0.4, around=25, across=12):
    """A torus around z: vertices float32 (n, 3), triangles uint32 (m, 3), outward."""
    u, v = np.meshgrid(np.arange(around), np.arange(across), indexing="ij")
    a, b = 2 * np.pi * u / around, 2 * np.pi * v / across
    r = major + minor * np.cos(b)
    vertices = np.stack([r * np.cos(a), r * np.sin(a), minor * np.sin(b)], -1)
    here, right = u * across + v, (u + 1) % around * across + v
    up, both = u * across + (v + 1) % across, (u + 1) % around * across + (v + 1) % across
    triangles = np.concatenate(
        [
            np.stack([here, right, both], -1).reshape(-1, 3),
            np.stack([here, both, up], -1).reshape(-1, 3),
        ]
    )
    return vertices.reshape(-1, 3).astype(np.float32), triangles.astype(np.uint32)


def box(half=0.5):
    """A cube around the origin."""
    corners = np.array([[x, y, z] for z in (-1, 1) for y in (-1, 1) for x in (-1, 1)]) * half
    triangles = [
        [0, 2, 3], [0, 3, 1], [4, 5, 7], [4, 7, 6], [0, 1, 5], [0, 5, 4],
        [2, 6, 7], [2, 7, 3], [0, 4, 6], [0, 6, 2], [1, 3, 7], [1, 7, 5],
    ]  # fmt: skip
    return corners.astype(np.float32), np.array(triangles, np.uint32)


@pytest.fixture
def two_tori():
    """(world, rigid body, deforming body, the latter's positions): they overlap."""
    world = pierce.World("embree", 1, coverage="complete")
    vertices, triangles = torus()
    mesh = world.add_mesh((vertices, triangles), "torus")
    rigid, soft = world.add_rigid_body(mesh), world.add_deforming_body(mesh)
    positions = np.ascontiguousarray(vertices + np.float32([0.9, 0, 0.2]))
    world.set_positions(soft, positions)
    return world, rigid, soft, positions
