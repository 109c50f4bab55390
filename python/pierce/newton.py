"""Contacts between the true triangles of Newton's meshes.

`CollisionPipeline` takes the place of `newton.CollisionPipeline`:

    pipeline = pierce.newton.CollisionPipeline(model)
    contacts = pipeline.contacts()
    for _ in range(steps):
        state_0.clear_forces()
        pipeline.collide(state_0, contacts)
        solver.step(state_0, state_1, control, contacts, dt)
        state_0, state_1 = state_1, state_0

Lengths are in metres, quaternions are x, y, z, w, as in Newton.
"""

from typing import Any, no_type_check

import numpy as np
from numpy.typing import NDArray

from . import _core

try:
    import newton
    import warp as wp
except ImportError as error:
    raise ImportError("pierce.newton needs Newton: pip install newton") from error

__all__ = ["CollisionPipeline"]

TAKEN = (newton.GeoType.MESH, newton.GeoType.CONVEX_MESH, newton.GeoType.BOX)
"""The types of the shapes whose pairs Pierce takes."""


class CollisionPipeline:
    """Finds the contacts of a model: Pierce's between meshes, and Newton's own of all else.

    Pierce takes the pairs in which both shapes are a mesh, a convex mesh or a box.
    A mesh is its triangles, concave or not; a convex mesh is the hull of all its vertices, unless
    its `maxhullvert` is not Newton's default.
    All other pairs, such as those with a plane, a sphere, a capsule or a height field, and all
    contacts of particles, are found by a `newton.CollisionPipeline` and are in the same list,
    before Pierce's.

    model: which shapes there are, and which pairs meet, is read once, here: types, sources,
        scales, places on bodies, flags, groups, worlds, filter pairs, margins, gaps, and which
        bodies are kinematic.
    backend, threads: of the `World` that finds the contacts.
    most_per_pair: more contacts of a pair of shapes are reduced to so many, at least six, which
        can have the same total force and torque; None: all are kept.
        Only on the host.
    gap: [m] how far apart two shapes have contacts, beyond their margins, in place of the sum of
        their gaps; for Pierce's pairs only.
        Newton's default is 0.1 for each shape, which is much for true meshes: every vertex and
        edge that is so near has contacts.
    rigid_contact_max: room for contacts, Newton's included; None: that of the model, or if it
        has none, 1000 and 200 for each shape.
    settings: `Settings` of the world.
    newton_options: further arguments of `newton.CollisionPipeline`; of these,
        `include_static_kinematic_pairs` holds for Pierce's pairs, too.
        Contact matching knows nothing of Pierce's contacts: their `rigid_contact_match_index`
        is -1, as if all were new, and contact reports do not have them.

    Give shapes a margin, such as a hundredth of their size, so that contacts push before surfaces
    overlap.
    Two boxes, one turned on the other, may overlap without a vertex of one in the other.
    Then only edges have contacts, each at the nearest ridge over it, which may be at the side.

    A mesh without an inside, see `Mesh.inside`, has contacts of its vertices with others only.

    Where both the world and the model are on a GPU, places and contacts stay there.
    Otherwise they go through host memory.
    `collide()` cannot be captured in a CUDA graph.
    """

    def __init__(
        self,
        model: Any,
        backend: str = "auto",
        *,
        threads: int = 0,
        most_per_pair: int | None = None,
        gap: float | None = None,
        rigid_contact_max: int | None = None,
        settings: _core.Settings | None = None,
        **newton_options: Any,
    ) -> None:
        self.model = model
        self.world = _core.World(backend, threads, settings)
        if most_per_pair is not None and self.world.on_device:
            raise ValueError("most_per_pair: only worlds on the host reduce contacts")
        if most_per_pair is not None and most_per_pair < _core.least_reduced:
            raise ValueError(
                f"most_per_pair must be at least {_core.least_reduced}, got {most_per_pair}"
            )
        self._most_per_pair = most_per_pair
        if rigid_contact_max is None:
            rigid_contact_max = model.rigid_contact_max
        if rigid_contact_max is None:
            rigid_contact_max = 1000 + 200 * model.shape_count

        pairs = _pairs_of(model)
        taken = np.isin(model.shape_type.numpy(), TAKEN)[pairs].all(axis=1)
        self._newton = newton.CollisionPipeline(
            model,
            broad_phase="explicit",
            shape_pairs_filtered=wp.array(pairs[~taken], dtype=wp.vec2i, device=model.device),
            rigid_contact_max=rigid_contact_max,
            **newton_options,
        )
        if not newton_options.get("include_static_kinematic_pairs", True):
            taken &= ~_is_held(model)[pairs].all(axis=1)
        shapes = np.unique(pairs[taken])
        bodies = _add_bodies(self.world, model, shapes)
        _exclude_others(self.world, model, shapes, bodies, pairs[taken])
        reach = model.shape_margin.numpy() + (model.shape_gap.numpy() if gap is None else gap / 2)
        for shape, body in zip(shapes, bodies, strict=True):
            # Pierce takes the larger margin of a pair, Newton the sum.
            margin = 2 * max(0.0, float(reach[shape]))
            self.world.set_collision(body, _core.Collision(margin=margin))

        device = model.device
        moving = model.shape_body.numpy()[shapes] >= 0
        self._bodies = np.array([int(body) for body in bodies], dtype=np.uint64)[moving]
        self._shape_of: Any = wp.array(shapes, dtype=int, device=device)
        self._moving: Any = wp.array(shapes[moving], dtype=int, device=device)
        self._poses: Any = wp.zeros(len(self._moving), dtype=wp.transform, device=device)
        self._reach: Any = wp.array(reach, dtype=float, device=device)
        self._conveys: Any = wp.array(_conveys(model), dtype=bool, device=device)
        self._start: Any = wp.zeros(1, dtype=int, device=device)
        self._stays = self.world.on_device and device.is_cuda
        if self._stays:
            self.world.set_stream(wp.get_stream(device))

    def contacts(self) -> Any:
        """Makes a `newton.Contacts` with room for `rigid_contact_max` contacts."""
        return self._newton.contacts()

    def collide(self, state: Any, contacts: Any, **newton_options: Any) -> None:
        """Finds all contacts in a state.

        state: its `body_q` says where bodies are.
        contacts: a `newton.Contacts`; what was in it before is gone.
        newton_options: further arguments of `newton.CollisionPipeline.collide`.

        Raises RuntimeError if there are more contacts than room for them.
        Of these it has to know the number, so it waits for the device.
        """
        for column in (
            contacts.rigid_contact_stiffness,
            contacts.rigid_contact_damping,
            contacts.rigid_contact_friction,
        ):
            if column is not None:
                column.zero_()  # Newton writes its rows only; with 0, the shapes decide.
        self._newton.collide(state, contacts, **newton_options)
        if len(self._shape_of):
            self._set_poses(state)
            self.world.detect()
            wp.copy(self._start, contacts.rigid_contact_count)
            columns = self._device_columns() if self._stays else self._host_columns()
            if columns:
                _append(
                    self.model, state, columns, self._shape_of, self._reach, self._start, contacts
                )
                if contacts.rigid_contact_surface_velocity is not None:
                    _write_surface_velocities(
                        self.model, state, self._conveys, self._start, len(columns[1]), contacts
                    )
        count, room = int(contacts.rigid_contact_count.numpy()[0]), contacts.rigid_contact_max
        if count > room:
            raise RuntimeError(
                f"{count} contacts, but rigid_contact_max is {room}: give the pipeline a larger "
                "one, a smaller gap, or most_per_pair"
            )

    def _set_poses(self, state: Any) -> None:
        if len(self._moving) == 0:
            return
        model = self.model
        wp.launch(
            _place_shapes,
            dim=len(self._moving),
            inputs=[self._moving, model.shape_body, model.shape_transform, state.body_q],
            outputs=[self._poses],
            device=model.device,
        )
        self.world.set_poses(self._bodies, self._poses if self._stays else self._poses.numpy())

    def _device_columns(self) -> list[Any]:
        found, _ = self.world.device_contacts()
        if found.room == 0:
            return []
        return [
            wp.from_dlpack(found.count),
            wp.from_dlpack(found.body_a),
            wp.from_dlpack(found.body_b),
            wp.from_dlpack(found.distance),
            wp.from_dlpack(found.point_a, dtype=wp.vec3),
            wp.from_dlpack(found.point_b, dtype=wp.vec3),
            wp.from_dlpack(found.normal, dtype=wp.vec3),
        ]

    def _host_columns(self) -> list[Any]:
        found = self.world.contacts
        if len(found) == 0:
            return []
        rows: Any = slice(None)
        if self._most_per_pair is not None:
            reach = self._reach.numpy()[self._shape_of.numpy()]
            both = sum(reach[(of & 0xFFFFFFFF).astype(np.intp)] for of in (found.a, found.b))
            rows, _ = found.reduce(self._most_per_pair, found.distance <= both)
        slots = [(handles[rows] & 0xFFFFFFFF).astype(np.uint32) for handles in (found.a, found.b)]
        columns = [
            (np.array([len(slots[0])], dtype=np.uint32), wp.uint32),
            (slots[0], wp.uint32),
            (slots[1], wp.uint32),
            (found.distance[rows].astype(np.float32), wp.float32),
            (found.point_a[rows].astype(np.float32), wp.vec3),
            (found.point_b[rows].astype(np.float32), wp.vec3),
            (found.normal[rows].astype(np.float32), wp.vec3),
        ]
        return [wp.array(values, dtype=kind, device=self.model.device) for values, kind in columns]


def _append(
    model: Any,
    state: Any,
    columns: list[Any],
    shape_of: Any,
    reach: Any,
    start: Any,
    contacts: Any,
) -> None:
    """Writes Pierce's contacts after Newton's.

    columns: arrays on the model's device: count, slot of body a, slot of body b, distance,
        point a, point b, normal; of the last six, `count[0]` rows are read.
    shape_of: the shape of each slot.
    reach: [m] margin and gap of each shape.
    start: how many contacts there are before.
    """
    room, device = len(columns[1]), model.device
    kept = wp.zeros(room, dtype=int, device=device)
    places = wp.zeros(room, dtype=int, device=device)
    wp.launch(
        _mark, dim=room, inputs=[*columns[:4], shape_of, reach], outputs=[kept], device=device
    )
    wp.utils.array_scan(kept, places, inclusive=True)
    wp.launch(
        _write,
        dim=room,
        inputs=[
            *columns[1:3], *columns[4:], kept, places, start, contacts.rigid_contact_max, shape_of,
            model.shape_body, model.shape_margin, state.body_q,
        ],
        outputs=[
            contacts.rigid_contact_count,
            contacts.rigid_contact_shape0, contacts.rigid_contact_shape1,
            contacts.rigid_contact_point0, contacts.rigid_contact_point1,
            contacts.rigid_contact_offset0, contacts.rigid_contact_offset1,
            contacts.rigid_contact_normal,
            contacts.rigid_contact_margin0, contacts.rigid_contact_margin1,
        ],
        device=device,
    )  # fmt: skip


def _write_surface_velocities(
    model: Any, state: Any, conveys: Any, start: Any, room: int, contacts: Any
) -> None:
    """Writes how fast the surfaces of the two shapes move at Pierce's contacts, as Newton does.

    conveys: which shapes have surface velocities.
    start: how many contacts of Newton there are.
    room: there are no more of Pierce's.
    """
    wp.launch(
        _write_velocities,
        dim=room,
        inputs=[
            start, contacts.rigid_contact_count,
            contacts.rigid_contact_shape0, contacts.rigid_contact_shape1,
            contacts.rigid_contact_point0, contacts.rigid_contact_point1,
            conveys, model.shape_body, model.shape_transform, model.shape_scale,
            model.shape_source_ptr, state.body_q,
        ],
        outputs=[contacts.rigid_contact_surface_velocity],
        device=model.device,
    )  # fmt: skip


@wp.kernel
@no_type_check
def _place_shapes(
    shapes: wp.array[int],
    shape_body: wp.array[int],
    shape_transform: wp.array[wp.transform],
    body_q: wp.array[wp.transform],
    poses: wp.array[wp.transform],
):
    """Where shapes of bodies are in the world."""
    i = wp.tid()
    shape = shapes[i]
    poses[i] = body_q[shape_body[shape]] * shape_transform[shape]


@wp.kernel
@no_type_check
def _mark(
    count: wp.array[wp.uint32],
    slot_a: wp.array[wp.uint32],
    slot_b: wp.array[wp.uint32],
    distance: wp.array[float],
    shape_of: wp.array[int],
    reach: wp.array[float],
    kept: wp.array[int],
):
    """Marks the contacts that the gaps of the two shapes allow."""
    i = wp.tid()
    if i < int(count[0]):
        shape0, shape1 = shape_of[int(slot_a[i])], shape_of[int(slot_b[i])]
        if distance[i] <= reach[shape0] + reach[shape1]:
            kept[i] = 1


@wp.kernel
@no_type_check
def _write(
    slot_a: wp.array[wp.uint32],
    slot_b: wp.array[wp.uint32],
    point_a: wp.array[wp.vec3],
    point_b: wp.array[wp.vec3],
    normal: wp.array[wp.vec3],
    kept: wp.array[int],
    places: wp.array[int],
    start: wp.array[int],
    contact_max: int,
    shape_of: wp.array[int],
    shape_body: wp.array[int],
    shape_margin: wp.array[float],
    body_q: wp.array[wp.transform],
    out_count: wp.array[int],
    out_shape0: wp.array[int],
    out_shape1: wp.array[int],
    out_point0: wp.array[wp.vec3],
    out_point1: wp.array[wp.vec3],
    out_offset0: wp.array[wp.vec3],
    out_offset1: wp.array[wp.vec3],
    out_normal: wp.array[wp.vec3],
    out_margin0: wp.array[float],
    out_margin1: wp.array[float],
):
    """Writes marked contacts in Newton's frames, and how many there are in all."""
    i = wp.tid()
    row = start[0] + places[i] - 1
    if i == len(places) - 1:
        out_count[0] = row + 1
    if kept[i] == 0 or row >= contact_max:
        return
    shape0, shape1 = shape_of[int(slot_a[i])], shape_of[int(slot_b[i])]
    margin0, margin1 = shape_margin[shape0], shape_margin[shape1]
    to_body0, to_body1 = wp.transform_identity(), wp.transform_identity()
    if shape_body[shape0] >= 0:
        to_body0 = wp.transform_inverse(body_q[shape_body[shape0]])
    if shape_body[shape1] >= 0:
        to_body1 = wp.transform_inverse(body_q[shape_body[shape1]])
    out_shape0[row] = shape0
    out_shape1[row] = shape1
    out_point0[row] = wp.transform_point(to_body0, point_a[i])
    out_point1[row] = wp.transform_point(to_body1, point_b[i])
    out_offset0[row] = wp.transform_vector(to_body0, margin0 * normal[i])
    out_offset1[row] = wp.transform_vector(to_body1, -margin1 * normal[i])
    out_normal[row] = normal[i]
    out_margin0[row] = margin0
    out_margin1[row] = margin1


@wp.func
@no_type_check
def _surface_velocity(
    shape: int,
    point: wp.vec3,
    conveys: wp.array[bool],
    shape_transform: wp.array[wp.transform],
    shape_scale: wp.array[wp.vec3],
    shape_source: wp.array[wp.uint64],
    to_world: wp.transform,
):
    """Of a shape in the world, at a point in the frame of its body."""
    velocity = wp.vec3(0.0)
    if not conveys[shape]:
        return velocity
    mesh, scale = shape_source[shape], shape_scale[shape]
    local = wp.transform_point(wp.transform_inverse(shape_transform[shape]), point)
    nearest = wp.mesh_query_point_no_sign(mesh, wp.cw_div(local, scale), 1.0e11)
    if nearest.result:
        at_rest = wp.mesh_eval_velocity(mesh, nearest.face, nearest.u, nearest.v)
        velocity = wp.transform_vector(to_world * shape_transform[shape], wp.cw_mul(at_rest, scale))
    return velocity


@wp.kernel(enable_backward=False)
@no_type_check
def _write_velocities(
    start: wp.array[int],
    count: wp.array[int],
    shape0: wp.array[int],
    shape1: wp.array[int],
    point0: wp.array[wp.vec3],
    point1: wp.array[wp.vec3],
    conveys: wp.array[bool],
    shape_body: wp.array[int],
    shape_transform: wp.array[wp.transform],
    shape_scale: wp.array[wp.vec3],
    shape_source: wp.array[wp.uint64],
    body_q: wp.array[wp.transform],
    out_velocity: wp.array[wp.vec3],
):
    """Surface velocity of shape 1 relative to shape 0, in the world, of rows from `start` on."""
    row = start[0] + wp.tid()
    if row >= count[0] or row >= len(out_velocity):
        return
    to_world0, to_world1 = wp.transform_identity(), wp.transform_identity()
    if shape_body[shape0[row]] >= 0:
        to_world0 = body_q[shape_body[shape0[row]]]
    if shape_body[shape1[row]] >= 0:
        to_world1 = body_q[shape_body[shape1[row]]]
    velocity0 = _surface_velocity(
        shape0[row], point0[row], conveys, shape_transform, shape_scale, shape_source, to_world0
    )
    velocity1 = _surface_velocity(
        shape1[row], point1[row], conveys, shape_transform, shape_scale, shape_source, to_world1
    )
    out_velocity[row] = velocity1 - velocity0


def _pairs_of(model: Any) -> NDArray[np.int64]:
    """The pairs of shapes that may meet, (n, 2)."""
    pairs = model.shape_contact_pairs
    if pairs is None or len(pairs) == 0:
        return np.empty((0, 2), dtype=np.int64)
    return np.asarray(pairs.numpy(), dtype=np.int64).reshape(-1, 2)


def _is_held(model: Any) -> NDArray[np.bool_]:
    """Which shapes are static or of a kinematic body, (n,)."""
    body = model.shape_body.numpy()
    held: NDArray[np.bool_] = body < 0
    if model.body_count:
        held |= model.body_flags.numpy()[body] & int(newton.BodyFlags.KINEMATIC) != 0
    return held


def _conveys(model: Any) -> list[bool]:
    """Which shapes are meshes with surface velocities, (n,)."""
    return [
        kind == newton.GeoType.MESH and source.enable_surface_velocity
        for kind, source in zip(model.shape_type.numpy(), model.shape_source, strict=True)
    ]


def _add_bodies(world: _core.World, model: Any, shapes: NDArray[np.int64]) -> list[_core.BodyId]:
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
            meshes[key] = world.add_mesh(_mesh_data(kind, scale, source), f"shape {shape}")
        if body_of[shape] < 0:
            body = world.add_fixed_body(meshes[key], places[shape])
        else:
            body = world.add_rigid_body(meshes[key])
        world.set_filter(body, _core.Filter(world=int(worlds[shape])))
        bodies.append(body)
    return bodies


def _mesh_data(
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


def _exclude_others(
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
