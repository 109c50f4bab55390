"""pierce.newton against Newton's own pipeline, conventions and filters; and on a GPU, if any."""

import itertools
from types import SimpleNamespace

import numpy as np
import pierce
import pytest
from conftest import box, torus

newton = pytest.importorskip("newton", reason="Newton is not installed")
import pierce.newton as adapter  # noqa: E402
import warp as wp  # noqa: E402

pytestmark = pytest.mark.filterwarnings("ignore::newton.NewtonWarning")

Look = newton.ModelBuilder.ShapeConfig


def mesh_of(shape, **options):
    vertices, triangles = shape
    return newton.Mesh(vertices, triangles.flatten().astype(np.int32), **options)


BOX, RING = mesh_of(box(0.25)), mesh_of(torus(0.3, 0.1))


def place(position=(0, 0, 0), axis=(0, 0, 1), angle=0.0):
    return wp.transform(wp.vec3(*position), wp.quat_from_axis_angle(wp.vec3(*axis), angle))


def add(builder, position, look, shape="mesh", angle=0.0, mesh=BOX, xform=None, scale=(1, 1, 1)):
    body = builder.add_body(xform=place(position, (0.6, 0, 0.8), angle))
    if shape == "mesh":
        return builder.add_shape_mesh(body, mesh=mesh, cfg=look, xform=xform, scale=scale)
    if shape == "hull":
        return builder.add_shape_convex_hull(body, mesh=mesh, cfg=look, scale=scale)
    if shape == "sphere":
        return builder.add_shape_sphere(body, radius=0.25, cfg=look)
    return builder.add_shape_box(body, hx=0.25, hy=0.25, hz=0.25, cfg=look)


def made(builder, device="cpu"):
    return builder.finalize(device=device)


def rows_of(contacts):
    """Arrays of a contact list by their names, without 'rigid_contact_'."""
    count = int(contacts.rigid_contact_count.numpy()[0])
    names = (
        "shape0",
        "shape1",
        "point0",
        "point1",
        "offset0",
        "offset1",
        "normal",
        "margin0",
        "margin1",
    )
    return {name: getattr(contacts, f"rigid_contact_{name}").numpy()[:count] for name in names}


def pairs_in(contacts):
    rows = rows_of(contacts)
    return {tuple(sorted(pair)) for pair in zip(rows["shape0"].tolist(), rows["shape1"].tolist())}


def turned(pose, points, inverse=False):
    """Points, (n, 3), turned and moved by a pose of seven numbers, or back."""
    matrix = np.array(wp.quat_to_matrix(wp.quat(*map(float, pose[3:])))).reshape(3, 3)
    return (points - pose[:3]) @ matrix if inverse else points @ matrix.T + pose[:3]


def simulated(model, pipeline, seconds, rate=480, iterations=4, watch=None):
    solver = newton.solvers.SolverXPBD(model, iterations=iterations)
    contacts, control = pipeline.contacts(), model.control()
    state, following = model.state(), model.state()
    for _ in range(int(seconds * rate)):
        state.clear_forces()
        pipeline.collide(state, contacts)
        if watch:
            watch(state)
        solver.step(state, following, control, contacts, 1 / rate)
        state, following = following, state
    return state


def two_rings(height=1.0, device="cpu"):
    """Overlapping rings over the ground, turned on their bodies; the second one is scaled."""
    builder = newton.ModelBuilder()
    add(
        builder,
        (0, 0, height),
        Look(margin=0.01, gap=0.02),
        mesh=RING,
        angle=0.3,
        xform=place((0.1, 0, 0.2), (1, 0, 0), 0.5),
    )
    add(
        builder,
        (0.3, 0.1, height + 0.15),
        Look(margin=0.004, gap=0.01),
        mesh=RING,
        angle=-0.4,
        scale=(1.2, 0.9, 1.0),
    )
    builder.add_ground_plane()
    return made(builder, device)


def collided(model, backend="embree", **options):
    pipeline = adapter.CollisionPipeline(model, backend, threads=1, **options)
    state, contacts = model.state(), pipeline.contacts()
    pipeline.collide(state, contacts)
    return pipeline, state, contacts


def test_conventions():
    model = two_rings()
    pipeline, state, contacts = collided(model)
    found, rows = pipeline.world.contacts, rows_of(contacts)
    kept = found.distance <= 0.01 + 0.02 + 0.004 + 0.01
    assert 10 < kept.sum() < len(found) and kept.sum() == len(rows["normal"])
    poses = state.body_q.numpy()
    for side, mine, sign in ((0, found.point_a, 1), (1, found.point_b, -1)):
        assert (rows[f"shape{side}"] == side).all()
        margin = model.shape_margin.numpy()[side]
        np.testing.assert_allclose(turned(poses[side], rows[f"point{side}"]), mine[kept], atol=2e-6)
        np.testing.assert_allclose(rows[f"margin{side}"], margin)
        np.testing.assert_allclose(
            turned(poses[side], rows[f"offset{side}"]) - poses[side][:3],
            sign * margin * found.normal[kept],
            atol=2e-6,
        )
    np.testing.assert_allclose(rows["normal"], found.normal[kept], atol=1e-6)

    distance = wp.zeros(contacts.rigid_contact_max, dtype=float, device="cpu")
    newton.eval_rigid_contact_kinematics(model, state, contacts, out_distance=distance)
    np.testing.assert_allclose(
        distance.numpy()[: len(rows["normal"])], found.distance[kept] - 0.014, atol=3e-6
    )


def test_points_are_on_the_surfaces_of_the_placed_meshes():
    model = two_rings()
    pipeline, state, contacts = collided(model)
    rows, poses = rows_of(contacts), state.body_q.numpy()
    for side in (0, 1):
        local = turned(model.shape_transform.numpy()[side], rows[f"point{side}"], inverse=True)
        corners = (RING.vertices * model.shape_scale.numpy()[side])[RING.indices.reshape(-1, 3)]
        world = turned(poses[side], rows[f"point{side}"])
        assert np.abs(world[:, 2] - 1).max() < 0.7
        for point in local:
            normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
            normals /= np.linalg.norm(normals, axis=1, keepdims=True)
            heights = np.abs(((point - corners[:, 0]) * normals).sum(1))
            near = np.linalg.norm(corners.mean(1) - point, axis=1) < 0.15
            assert heights[near].min() < 1e-5


def test_generation_goes_up():
    pipeline, state, contacts = collided(two_rings())
    before = int(contacts.contact_generation.numpy()[0])
    pipeline.collide(state, contacts)
    assert int(contacts.contact_generation.numpy()[0]) > before


class LikeADevice:
    """A world on the host that takes poses and gives contacts as one on a device does."""

    def __init__(self, world):
        self.world, self.detect = world, world.detect

    def set_poses(self, bodies, poses):
        assert isinstance(poses, wp.array)
        self.world.set_poses(bodies, poses)

    def device_contacts(self):
        found, room = self.world.contacts, len(self.world.contacts) + 5

        def padded(values, kind=np.float32):
            column = np.full((room, *values.shape[1:]), 77, kind)
            column[: len(found)] = values
            return column

        return SimpleNamespace(
            room=room,
            count=np.array([len(found)], np.uint32),
            body_a=padded(found.a & 0xFFFFFFFF, np.uint32),
            body_b=padded(found.b & 0xFFFFFFFF, np.uint32),
            distance=padded(found.distance),
            point_a=padded(found.point_a),
            point_b=padded(found.point_b),
            normal=padded(found.normal),
        ), None


def test_contacts_of_a_device_are_written_after_newtons():
    model = two_rings(height=0.05)
    pipeline, state, contacts = collided(model)
    expected = rows_of(contacts)
    newtons = len(rows_of(contacts)["normal"]) - sum(
        pair == (0, 1) for pair in zip(expected["shape0"], expected["shape1"], strict=True)
    )
    assert 0 < newtons < len(expected["normal"])
    pipeline.world, pipeline._stays = LikeADevice(pipeline.world), True
    again = pipeline.contacts()
    pipeline.collide(state, again)
    for name, values in rows_of(again).items():
        np.testing.assert_array_equal(values, expected[name])


@pytest.mark.skipif(
    not (pierce.cuda_can_run() and wp.is_cuda_available()), reason="there is no GPU for both"
)
def test_contacts_on_a_gpu_are_those_of_the_host():
    expected = rows_of(collided(two_rings(height=0.05))[2])
    model = two_rings(height=0.05, device="cuda:0")
    pipeline, _, contacts = collided(model, "cuda")
    assert pipeline._stays and pipeline.world.on_device
    found = rows_of(contacts)
    assert len(found["normal"]) == len(expected["normal"]) > 20
    orders = [
        np.lexsort((*rows["point0"].T.round(5), rows["shape1"], rows["shape0"]))
        for rows in (found, expected)
    ]
    for name, values in expected.items():
        np.testing.assert_allclose(found[name][orders[0]], values[orders[1]], atol=1e-5)
    model = two_rings(height=0.3, device="cuda:0")
    pipeline = adapter.CollisionPipeline(model, "cuda")
    heights = simulated(model, pipeline, 1.0).body_q.numpy()[:, 2]
    assert (heights > 0).all() and (heights < 0.6).all()


def test_nothing_is_dropped_in_silence():
    model = two_rings()
    with pytest.raises(RuntimeError, match=r"\d+ contacts, but rigid_contact_max is 5"):
        collided(model, rigid_contact_max=5)
    model.rigid_contact_max = 6
    with pytest.raises(RuntimeError, match="rigid_contact_max is 6"):
        collided(model)


def test_fewer_contacts_of_a_pair():
    _, _, all_of_them = collided(two_rings())
    _, _, few = collided(two_rings(), most_per_pair=6)
    assert 0 < len(rows_of(few)["normal"]) <= 6 < len(rows_of(all_of_them)["normal"])


def test_too_few_contacts_of_a_pair_are_refused():
    with pytest.raises(ValueError, match="most_per_pair must be at least 6, got 5"):
        adapter.CollisionPipeline(two_rings(), "embree", most_per_pair=5)


def test_contacts_have_the_surface_velocities_that_newton_gives_them():
    """Boxes and balls on a belt, which is turned, stretched, and slower at one end."""
    builder = newton.ModelBuilder()
    look = Look(margin=0.002, gap=0.01)
    belt = mesh_of(box(0.5), enable_surface_velocity=True)
    turned_belt = place((0, 0, 0.1), (0, 0, 1), 0.5)
    body = builder.add_body(xform=place((0, 0, 0), (0, 0, 1), 0.3), is_kinematic=True)
    builder.add_shape_mesh(body, mesh=belt, cfg=look, xform=turned_belt, scale=(2, 1, 1))
    balls = [builder.add_body(xform=place((x, 0, 0.649))) for x in (-0.5, 0.5)]
    for ball in balls:
        builder.add_shape_sphere(ball, radius=0.05, cfg=look)
    for x, z, angle in ((-0.2, 0.853, 0.1), (0.3, 0.853, 0.8), (0.3, 1.355, 0.4)):
        body = builder.add_body(xform=place((x, 0, z), angle=angle))
        builder.add_shape_mesh(body, mesh=BOX, cfg=look)
    model = made(builder)
    corners = box(0.5)[0]
    belt.mesh.velocities.assign(np.float32([1, 0, 0]) * (1 + corners[:, :1]))
    pipeline, state, contacts = collided(model)

    def check():
        rows, poses = rows_of(contacts), state.body_q.numpy()
        found = contacts.rigid_contact_surface_velocity.numpy()[: len(rows["normal"])]
        expected = np.zeros_like(found)
        for i, pair in enumerate(zip(rows["shape0"], rows["shape1"], strict=True)):
            for side, sign in ((0, -1), (1, 1)):
                if pair[side] == 0:
                    local = turned(turned_belt, rows[f"point{side}"][i], inverse=True)
                    velocity = np.array([2 * (1 + local[0] / 2), 0, 0])
                    there = turned(turned_belt, velocity) - turned_belt[:3]
                    expected[i] += sign * (turned(poses[0], there) - poses[0][:3])
        np.testing.assert_allclose(found, expected, atol=1e-5)
        return pairs_in(contacts)

    assert check() >= {(0, 1), (0, 2), (0, 3), (0, 4), (4, 5)}
    away = state.body_q.numpy()
    away[balls, 2] = 9
    state.body_q.assign(away)
    pipeline.collide(state, contacts)
    assert check() >= {(0, 3), (0, 4), (4, 5)}
    assert not {(0, 1), (0, 2)} & pairs_in(contacts)


def test_contacts_have_no_stiffness_of_contacts_that_are_gone():
    model = two_rings()
    pipeline = adapter.CollisionPipeline(model, "embree", threads=1)
    contacts = newton.Contacts(1000, 0, per_contact_shape_properties=True, device="cpu")
    columns = [
        getattr(contacts, f"rigid_contact_{k}") for k in ("stiffness", "damping", "friction")
    ]
    for column in columns:
        column.fill_(7.0)
    pipeline.collide(model.state(), contacts)
    assert len(rows_of(contacts)["normal"]) > 10
    for column in columns:
        assert not column.numpy().any()


def test_contact_matching_takes_all_of_pierces_contacts_for_new_ones():
    model = two_rings(height=0.05)
    pipeline, state, contacts = collided(model, contact_matching="latest")
    pipeline.collide(state, contacts)
    rows = rows_of(contacts)
    matched = contacts.rigid_contact_match_index.numpy()[: len(rows["normal"])]
    of_pierce = (rows["shape0"] == 0) & (rows["shape1"] == 1)
    assert of_pierce.any() and (matched[of_pierce] == -1).all() and (matched[~of_pierce] >= 0).all()


def test_pairs_of_static_and_kinematic_shapes_are_left_out_if_asked_for():
    builder = newton.ModelBuilder()
    look = Look(margin=0.002, gap=0.01)
    builder.add_shape_mesh(-1, mesh=BOX, cfg=look)
    for k, position in enumerate(((0, 0, 0.4), (0, 0.4, 0.4), (0.1, 0.2, 0.2))):
        body = builder.add_body(xform=place(position), is_kinematic=k < 2)
        builder.add_shape_mesh(body, mesh=BOX, cfg=look)
    model = made(builder)
    with_last = {(0, 3), (1, 3), (2, 3)}
    assert pairs_in(collided(model)[2]) == with_last | {(0, 1), (0, 2), (1, 2)}
    assert pairs_in(collided(model, include_static_kinematic_pairs=False)[2]) == with_last


def test_pairs_are_those_of_the_model():
    """Shapes of all kinds in one place: groups, worlds, filter pairs, flags, bodies, the ground."""
    rng = np.random.default_rng(3)
    builder = newton.ModelBuilder()
    kinds = ("mesh", "box", "hull", "mesh", "sphere")
    looks = [Look(gap=0.0, collision_group=group) for group in (1, 1, 2, -1, -2, 0)]
    looks += [Look(gap=0.0, has_shape_collision=False)]

    def fill(into):
        for k, look in enumerate(looks):
            add(into, rng.uniform(-0.02, 0.02, 3), look, kinds[k % len(kinds)], rng.uniform(0.1, 1))

    fill(builder)
    builder.add_shape_mesh(body=-1, mesh=BOX, cfg=looks[0], xform=place((0.03, 0, 0)))
    builder.add_shape_mesh(body=-1, mesh=BOX, cfg=looks[0], xform=place((0.01, 0, 0)))
    builder.add_shape_box(body=0, hx=0.2, hy=0.2, hz=0.2, cfg=looks[0])
    builder.add_shape_collision_filter_pair(0, 1)
    for _ in range(2):
        one = newton.ModelBuilder()
        fill(one)
        builder.add_world(one)
    builder.add_ground_plane(cfg=looks[0])
    model = made(builder)
    allowed = {tuple(sorted(pair)) for pair in model.shape_contact_pairs.numpy().tolist()}
    fixed = {shape for shape, body in enumerate(model.shape_body.numpy()) if body < 0}
    taken = {shape for shape, kind in enumerate(model.shape_type.numpy()) if kind in adapter.TAKEN}
    pipeline, _, contacts = collided(model, rigid_contact_max=20000)
    of_pierce = {pair for pair in allowed if set(pair) <= taken and not set(pair) <= fixed}
    slots = pipeline._shape_of.numpy()
    found = pipeline.world.contacts
    met = {
        tuple(sorted(pair))
        for pair in zip(slots[found.a & 0xFFFFFFFF].tolist(), slots[found.b & 0xFFFFFFFF].tolist())
    }
    assert met == of_pierce and len(met) > 20
    both_not = {pair for pair in itertools.combinations(range(model.shape_count), 2)} - allowed
    assert not pairs_in(contacts) & both_not
    ground = model.shape_count - 1
    assert {pair for pair in pairs_in(contacts) if ground in pair}
    assert met <= pairs_in(contacts)


@pytest.mark.parametrize("scale", [(1.0, 1.0, 1.0), (1.0, -1.0, 1.0)])
def test_scaled_and_mirrored_meshes_are_solid(scale):
    builder = newton.ModelBuilder()
    look = Look(gap=0.0)
    add(builder, (0, 0, 0), look, mesh=RING, scale=scale)
    add(builder, (0, 0.3, 0.02), look, mesh=BOX, scale=(0.2, 0.2, 0.2))
    pipeline, _, contacts = collided(made(builder))
    assert pairs_in(contacts) == {(0, 1)}
    assert pipeline.world.contacts.distance.min() < -0.02


def test_a_hull_has_all_vertices_of_its_mesh():
    """Newton's own one is made of 64 of them, unless a mesh says otherwise."""
    steps = np.arange(500)
    height, turn = 1 - (2 * steps + 1) / 500, np.pi * (1 + np.sqrt(5)) * steps
    ring = np.sqrt(1 - height**2)
    ball = np.stack([ring * np.cos(turn), ring * np.sin(turn), height], axis=1)
    mesh = mesh_of((ball.astype(np.float32), np.array([[0, 1, 2]])), compute_inertia=False)
    for way in ball[:40]:
        builder = newton.ModelBuilder()
        add(builder, (0, 0, 0), Look(gap=0.0), shape="hull", mesh=mesh)
        add(builder, tuple(1.98 * way), Look(gap=0.0), shape="hull", mesh=mesh)
        found = collided(made(builder))[0].world.contacts
        assert -0.021 < found.distance.min() < -0.01


def test_boxes_rest_where_newton_lets_them_rest():
    builder = newton.ModelBuilder()
    look = Look(density=1000.0, mu=0.5, margin=0.01, gap=0.01)
    for k, shape in enumerate(("mesh", "box", "hull")):
        body = builder.add_body(xform=place((0.02 * k, 0, 0.3 + 0.55 * k), angle=0.3 * k))
        if shape == "mesh":
            builder.add_shape_mesh(body, mesh=BOX, cfg=look)
        elif shape == "box":
            builder.add_shape_box(body, hx=0.25, hy=0.25, hz=0.25, cfg=look)
        else:
            builder.add_shape_convex_hull(body, mesh=BOX, cfg=look)
    builder.add_ground_plane(cfg=Look(mu=0.5))
    model = made(builder)
    heights = [
        simulated(model, pipeline, 1.0, iterations=8).body_q.numpy()[:, 2]
        for pipeline in (
            adapter.CollisionPipeline(model, "embree", threads=1),
            newton.CollisionPipeline(model, broad_phase="nxn"),
        )
    ]
    np.testing.assert_allclose(heights[0], [0.26, 0.78, 1.3], atol=2e-3)
    np.testing.assert_allclose(heights[0], heights[1], atol=2e-3)


def test_a_linked_ring_hangs_in_the_other_one():
    builder = newton.ModelBuilder()
    look = Look(density=500.0, margin=0.005, gap=0.005)
    builder.add_shape_mesh(
        body=-1, mesh=RING, cfg=look, xform=place((0, 0, 1), (1, 0, 0), np.pi / 2)
    )
    body = builder.add_body(xform=place((0, 0, 0.65), (0, 1, 0), np.pi / 2))
    builder.add_shape_mesh(body, mesh=RING, cfg=look)
    model = made(builder)
    pipeline = adapter.CollisionPipeline(model, "embree", threads=1)
    deepest = []
    state = simulated(
        model,
        pipeline,
        1.0,
        watch=lambda _: deepest.append(pipeline.world.contacts.depth.max(initial=0.0)),
    )
    assert max(deepest) < 1e-3
    # The tubes of round rings would rest on each other at 1 - 0.3 + 2 * 0.1 - 0.3 - 2 * 0.005.
    # The corners of these ones are on the round ones.
    assert 0.59 < state.body_q.numpy()[0, 2] < 0.63
    assert np.abs(state.body_qd.numpy()[0, 2]) < 0.05


def test_models_without_meshes_are_left_to_newton():
    builder = newton.ModelBuilder()
    add(builder, (0, 0, 0.24), Look(), "sphere")
    builder.add_ground_plane()
    _, _, contacts = collided(made(builder))
    assert pairs_in(contacts) == {(0, 1)}
