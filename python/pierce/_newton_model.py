"""What Pierce reads of a Newton model: its shapes, and which pairs of them meet."""

from typing import Any

import newton
import numpy as np
from numpy.typing import NDArray

from . import _core


def pairs_of(model: Any) -> NDArray[np.int64]:
    """The pairs of shapes that may meet, (n, 2)."""
    pairs = model.shape_contact_pairs
    if pairs is None or len(pairs) == 0:
        return np.empty((0, 2), dtype=np.int64)
    return np.asarray(pairs.numpy(), dtype=np.int64).reshape(-1, 2)


def is_held(model: Any) -> NDArray[np.bool_]:
    """Which shapes are static or of a kinematic body, (n,)."""
    body = model.shape_body.numpy()
    held: NDArray[np.bool_] = body < 0
    if model.body_count:
        held |= model.body_flags.numpy()[body] & int(newton.BodyFlags.KINEMATIC) != 0
    return held


def conveys(model: Any) -> list[bool]:
    """Which shapes are meshes with surface velocities, (n,)."""
    return [
        kind == newton.GeoType.MESH and source.enable_surface_velocity
        for kind, source in zip(model.shape_type.numpy(), model.shape_source, strict=True)
    ]


def add_bodies(world: _core.World, model: Any, shapes: NDArray[np.int64]) -> list[_core.BodyId]:
    """One body for each shape: in a new world, their slots are 0, 1, 2, ..."""
    types, scales = model.shape_type.numpy(), model.shape_scale.numpy()
    body_of, places = model.shape_body.numpy(), model.shape_transform.numpy()
    worlds = model.shape_world.numpy()
    meshes: dict[Any, _core.MeshId] = {}
    bodies = []
    for shape in shapes.tolist():
        kind, scale, source = types[shape], scales[shape], model.shape_source[shape]
        key = (kind, scale.tobytes(), id(source))
        if key not in meshes:
            meshes[key] = world.add_mesh(mesh_data(kind, scale, source), f"shape {shape}")
        if body_of[shape] < 0:
            body = world.add_fixed_body(meshes[key], places[shape])
        else:
            body = world.add_rigid_body(meshes[key])
        world.set_filter(body, _core.Filter(world=int(worlds[shape])))
        bodies.append(body)
    return bodies


def mesh_data(
    kind: int, scale: NDArray[np.float32], source: Any
) -> tuple[NDArray[np.float32], NDArray[np.uint32]]:
    """Vertices in the frame of a shape, (n, 3), and outward triangles, (m, 3)."""
    if kind == newton.GeoType.BOX:
        source = newton.Mesh.create_box(1.0, duplicate_vertices=False)
    elif kind == newton.GeoType.CONVEX_MESH:
        # To leave out vertices makes a hull smaller, so Newton's default limit does not count.
        limit = source.maxhullvert
        whole = newton.Mesh(
            source.vertices,
            source.indices,
            compute_inertia=False,
            maxhullvert=0 if limit == newton.Mesh.MAX_HULL_VERTICES else limit,
        )
        source = whole.compute_convex_hull()
    triangles = np.asarray(source.indices, dtype=np.uint32).reshape(-1, 3)
    if np.prod(scale) < 0:
        triangles = np.ascontiguousarray(triangles[:, ::-1])
    return np.asarray(source.vertices, dtype=np.float32) * scale, triangles


def exclude_others(
    world: _core.World,
    model: Any,
    shapes: NDArray[np.int64],
    bodies: list[_core.BodyId],
    pairs: NDArray[np.int64],
) -> None:
    """Excludes all pairs of shapes, of worlds that meet, that are not among the given ones."""
    worlds = model.shape_world.numpy()[shapes]
    shared = np.flatnonzero(worlds < 0)
    places = np.searchsorted(shapes, pairs)
    allowed = np.unique(places.min(axis=1) * len(shapes) + places.max(axis=1))
    by_world = np.argsort(worlds, kind="stable")
    for own in np.split(by_world, np.flatnonzero(np.diff(worlds[by_world])) + 1):
        first, second = (own[k] for k in np.triu_indices(len(own), 1))
        if len(own) and worlds[own[0]] >= 0:
            first = np.concatenate([first, np.repeat(shared, len(own))])
            second = np.concatenate([second, np.tile(own, len(shared))])
        keys = np.minimum(first, second) * len(shapes) + np.maximum(first, second)
        at = np.searchsorted(allowed, keys)
        is_allowed = np.append(allowed, -1)[at] == keys
        for key in keys[~is_allowed].tolist():
            world.exclude(bodies[key // len(shapes)], bodies[key % len(shapes)])
