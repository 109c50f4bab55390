"""Writes contacts into the arrays of a Newton `Contacts`, on the model's device."""

from typing import Any, no_type_check

import warp as wp

__all__ = ["append", "place_shapes", "write_surface_velocities"]


def append(
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


def write_surface_velocities(
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
def place_shapes(
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
