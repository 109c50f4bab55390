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

from typing import Any

import numpy as np

from . import _core

try:
    import newton
    import warp as wp

    from . import _newton_kernels, _newton_model
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

        pairs = _newton_model.pairs_of(model)
        taken = np.isin(model.shape_type.numpy(), TAKEN)[pairs].all(axis=1)
        self._newton = newton.CollisionPipeline(
            model,
            broad_phase="explicit",
            shape_pairs_filtered=wp.array(pairs[~taken], dtype=wp.vec2i, device=model.device),
            rigid_contact_max=rigid_contact_max,
            **newton_options,
        )
        if not newton_options.get("include_static_kinematic_pairs", True):
            taken &= ~_newton_model.is_held(model)[pairs].all(axis=1)
        shapes = np.unique(pairs[taken])
        bodies = _newton_model.add_bodies(self.world, model, shapes)
        _newton_model.exclude_others(self.world, model, shapes, bodies, pairs[taken])
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
        self._conveys: Any = wp.array(_newton_model.conveys(model), dtype=bool, device=device)
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
                _newton_kernels.append(
                    self.model, state, columns, self._shape_of, self._reach, self._start, contacts
                )
                if contacts.rigid_contact_surface_velocity is not None:
                    _newton_kernels.write_surface_velocities(
                        self.model,
                        state,
                        self._conveys,
                        self._start,
                        len(columns[1]),
                        contacts,
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
            _newton_kernels.place_shapes,
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
