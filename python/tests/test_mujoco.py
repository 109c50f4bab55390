"""pierce.mujoco against MuJoCo's own steps, filters and contact parameters."""

import itertools

import numpy as np
import pytest
from conftest import box, torus

mujoco = pytest.importorskip("mujoco", reason="MuJoCo is not installed")
from pierce.mujoco import MeshContacts  # noqa: E402

INTEGRATORS = ("Euler", "implicit", "implicitfast")


def mesh_xml(name, vertices, triangles):
    numbers = " ".join(f"{x:.9g}" for x in np.ravel(vertices))
    return (
        f'<mesh name="{name}" inertia="exact" vertex="{numbers}" '
        f'face="{" ".join(map(str, np.ravel(triangles)))}"/>'
    )


CUBE = mesh_xml("cube", *box())
SMALL = mesh_xml("small", *box(0.3))


def model_of(bodies, option="", rest="", meshes=""):
    return mujoco.MjModel.from_xml_string(
        f"<mujoco><option {option}/><asset>{CUBE}{SMALL}{meshes}</asset>"
        f"<worldbody>{bodies}</worldbody>{rest}</mujoco>"
    )


def chain(option="", rest=""):
    """Two linked rings; the first one is held."""
    return model_of(
        '<body pos="0 0 1"><geom name="held" type="mesh" mesh="ring" euler="90 0 0"/></body>'
        '<body pos="0 0 .65" euler="0 90 0"><freejoint/>'
        '<geom name="free" type="mesh" mesh="ring" density="500"/></body>',
        option,
        rest,
        mesh_xml("ring", *torus(0.3, 0.1)),
    )


def overlapping_cubes(first="", second="", option="", rest="", height=0.79):
    """A small cube on a large one, 0.8 apart where they touch."""
    return model_of(
        f'<geom name="a" type="mesh" mesh="cube" {first}/>'
        f'<body pos="0 0 {height}"><freejoint/>'
        f'<geom name="b" type="mesh" mesh="small" {second}/></body>',
        option,
        rest,
    )


def geom_pairs(data):
    return {tuple(sorted(pair)) for pair in data.contact.geom[: data.ncon].tolist()}


@pytest.mark.parametrize("integrator", INTEGRATORS)
@pytest.mark.parametrize("cone", ("pyramidal", "elliptic"))
def test_step_is_mj_step_where_nothing_is_added(integrator, cone):
    model = model_of(
        '<geom name="floor" type="plane" size="5 5 .1"/>'
        '<body pos="0 0 .7" euler="10 20 0"><freejoint/><geom type="mesh" mesh="cube"/></body>'
        '<body pos="3 0 1"><joint name="j" axis="0 1 0" damping=".1"/><geom type="mesh" '
        'mesh="cube"/><geom type="sphere" size=".2" pos="0 0 .6"/></body>',
        f'integrator="{integrator}" cone="{cone}"><flag energy="enable" fwdinv="enable"/></option'
        "><option",
        '<actuator><motor joint="j"/></actuator><sensor><jointpos joint="j"/></sensor>',
    )
    one, other = mujoco.MjData(model), mujoco.MjData(model)
    one.ctrl[:] = other.ctrl[:] = 0.5
    with MeshContacts(model) as contacts:
        for _ in range(200):
            contacts.step(model, one)
            mujoco.mj_step(model, other)
    assert one.ncon > 0
    for field in (
        "qpos",
        "qvel",
        "qacc",
        "sensordata",
        "energy",
        "qfrc_constraint",
        "time",
        "solver_fwdinv",
    ):
        np.testing.assert_array_equal(getattr(one, field), getattr(other, field), field)


@pytest.mark.parametrize("energy", ("disable", "enable"))
@pytest.mark.parametrize("sensors", ("", "<e_kinetic/>", "<e_potential/>"))
def test_energy_is_that_of_mj_step(energy, sensors):
    model = model_of(
        '<body pos="0 0 3"><freejoint/><geom type="mesh" mesh="cube"/></body>'
        '<body pos="3 0 3"><freejoint/><geom type="mesh" mesh="cube"/></body>',
        f'><flag energy="{energy}"/></option><option',
        f"<sensor>{sensors}</sensor>",
    )
    one, other = mujoco.MjData(model), mujoco.MjData(model)
    one.energy[:] = other.energy[:] = 5, 6
    with MeshContacts(model) as contacts:
        for _ in range(3):
            contacts.step(model, one)
            mujoco.mj_step(model, other)
            np.testing.assert_array_equal(one.energy, other.energy)
            np.testing.assert_array_equal(one.sensordata, other.sensordata)


def test_linked_rings_hang():
    model = chain('timestep="0.002" integrator="implicitfast"')
    data = mujoco.MjData(model)
    with MeshContacts(model) as contacts:
        for _ in range(1500):
            contacts.step(model, data)
    assert data.qpos[2] == pytest.approx(0.6, abs=0.02)
    assert np.abs(data.qvel).max() < 0.05
    held = sum(contact_force(model, data, i)[2] for i in range(data.ncon))
    assert held == pytest.approx(model.body_mass[-1] * 9.81, rel=0.05)


def contact_force(model, data, i):
    """World force on the second geom."""
    force = np.zeros(6)
    mujoco.mj_contactForce(model, data, i, force)
    return data.contact.frame[i].reshape(3, 3).T @ force[:3]


GEOMS = (
    {},
    {"priority": 1, "friction": ".1 .02 .003"},
    {"solmix": 3, "solref": ".05 .8", "solimp": ".8 .9 .01 .4 3", "condim": 6},
    {"solref": "-100 -3", "condim": 1, "friction": "0 0 0"},
    {"solmix": 0},
    {"margin": 0.01, "gap": 0.02, "condim": 4, "adhesion": 2},
)


@pytest.mark.parametrize("first,second", list(itertools.combinations_with_replacement(GEOMS, 2)))
def test_parameters_are_mixed_as_by_mujoco(first, second):
    if not hasattr(mujoco.MjModel, "geom_adhesion"):
        first.pop("adhesion", 0), second.pop("adhesion", 0)
    model = overlapping_cubes(
        *(" ".join(f'{k}="{v}"' for k, v in geom.items()) for geom in (first, second))
    )
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    own = data.contact
    assert data.ncon > 0
    with MeshContacts(model) as contacts:
        added = mujoco.MjData(model)
        contacts.forward(model, added)
    assert added.ncon > 0
    names = [
        "dim",
        "friction",
        "solref",
        "solimp",
        "includemargin",
        "solreffriction",
        "geom",
        "geom1",
        "geom2",
        "flex",
        "elem",
        "vert",
    ]
    for name in names + ["adhesion"] * ("adhesion" in first or "adhesion" in second):
        for row in getattr(added.contact, name):
            np.testing.assert_allclose(row, getattr(own, name)[0], rtol=1e-14, err_msg=name)
    np.testing.assert_allclose(added.contact.frame[:, :3], [[0, 0, 1]] * added.ncon, atol=1e-6)
    np.testing.assert_allclose(added.contact.dist.min(), own.dist.min(), atol=1e-6)
    frames = added.contact.frame.reshape(-1, 3, 3)
    np.testing.assert_allclose(
        frames @ frames.transpose(0, 2, 1), [np.eye(3)] * added.ncon, atol=1e-12
    )
    np.testing.assert_allclose(np.linalg.det(frames), 1)


@pytest.mark.parametrize(
    "height,listed,active", [(0.82, True, True), (0.845, True, False), (0.87, False, False)]
)
def test_margin_and_gap(height, listed, active):
    model = overlapping_cubes('margin=".02" gap=".01"', 'margin=".01" gap=".02"', height=height)
    own, data = mujoco.MjData(model), mujoco.MjData(model)
    mujoco.mj_forward(model, own)
    with MeshContacts(model) as contacts:
        contacts.forward(model, data)
    for each in (own, data):
        assert (each.ncon > 0, each.nefc > 0) == (listed, active)


def test_margin_argument():
    model = overlapping_cubes(height=0.82)
    data = mujoco.MjData(model)
    for margin, found in ((0.01, False), (0.03, True)):
        with MeshContacts(model, margin=margin) as contacts:
            contacts.forward(model, data)
            assert (data.ncon > 0) == found
    assert set(data.contact.includemargin) == {0.03}


def crowd(seed, option=""):
    """Overlapping spheres and cubes in a tree of bodies, with random masks and excluded pairs."""
    random = np.random.default_rng(seed)
    masks = ((1, 1), (2, 1), (1, 2), (4, 3), (0, 5), (6, 0))
    names = iter(f"b{i}" for i in range(99))
    listed = []

    def geom():
        contype, conaffinity = masks[random.integers(len(masks))]
        shape = random.choice(['type="mesh" mesh="cube"', 'type="sphere" size=".5"'])
        place = " ".join(map(str, random.uniform(-0.1, 0.1, 3)))
        return f'<geom {shape} pos="{place}" contype="{contype}" conaffinity="{conaffinity}"/>'

    def body(depth):
        name = next(names)
        listed.append(name)
        joint = random.choice(["", '<joint axis="0 0 1"/>', "<freejoint/>" if depth == 0 else ""])
        mocap = 'mocap="true"' if depth == 0 and not joint and random.random() < 0.7 else ""
        children = "".join(body(depth + 1) for _ in range(random.integers(3))) if depth < 2 else ""
        return (
            f'<body name="{name}" {mocap}>{joint}<geom size=".1" contype="0" conaffinity="0"/>'
            f"{geom()}{geom()}{children}</body>"
        )

    bodies = geom() + "".join(body(0) for _ in range(3))
    excluded = [random.choice(listed, 2, replace=False) for _ in range(3)]
    rest = "".join(f'<exclude body1="{a}" body2="{b}"/>' for a, b in excluded)
    return model_of(bodies, option, f"<contact>{rest}</contact><size memory='50M'/>")


@pytest.mark.parametrize("seed", range(40))
def test_the_same_pairs_meet(seed):
    flag = "><flag filterparent='disable'/></option><option" if seed % 3 == 0 else ""
    model = crowd(seed, flag)
    mesh = model.geom_type == mujoco.mjtGeom.mjGEOM_MESH
    before = [getattr(model, name).copy() for name in MASKS]
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    pairs = geom_pairs(data)
    between = {(a, b) for a, b in pairs if mesh[a] and mesh[b]}
    if not between:
        with pytest.raises(ValueError, match="no two of these mesh geoms"):
            MeshContacts(model)
        return
    with MeshContacts(model, most_per_pair=6) as contacts:
        mujoco.mj_forward(model, data)
        assert geom_pairs(data) == pairs - between
        contacts.forward(model, data)
        assert geom_pairs(data) == pairs
    for name, values in zip(MASKS, before):
        np.testing.assert_array_equal(getattr(model, name), values, name)


MASKS = ("geom_contype", "geom_conaffinity", "body_contype", "body_conaffinity", "flex_conaffinity")


def test_flexes_keep_their_contacts():
    model = model_of(
        '<geom type="mesh" mesh="cube"/>'
        '<body pos="0 0 .79"><freejoint/><geom type="mesh" mesh="small"/></body>'
        '<flexcomp type="grid" count="4 4 1" spacing=".2 .2 .2" pos="0 0 1.1" radius=".05" '
        'name="cloth" dim="2" mass="1"><contact contype="2" conaffinity="1"/></flexcomp>'
    )
    own, data = mujoco.MjData(model), mujoco.MjData(model)
    mujoco.mj_forward(model, own)
    of_flex = own.contact.flex.max(1) >= 0
    assert of_flex.any()
    with MeshContacts(model) as contacts:
        contacts.forward(model, data)
    kept = data.contact.flex.max(1) >= 0
    for name in ("dist", "geom", "elem", "vert"):
        np.testing.assert_array_equal(
            getattr(data.contact, name)[kept], getattr(own.contact, name)[of_flex]
        )
    assert (~kept).any()


def test_only_the_named_geoms_are_taken():
    model = model_of(
        "".join(
            f'<body pos="0 0 {0.9 * i}"><freejoint/>'
            f'<geom name="g{i}" type="mesh" mesh="cube"/></body>'
            for i in range(3)
        )
    )
    data = mujoco.MjData(model)
    with MeshContacts(model, ["g0", 1]) as contacts:
        mujoco.mj_forward(model, data)
        assert geom_pairs(data) == {(1, 2)}
        contacts.forward(model, data)
        assert geom_pairs(data) == {(0, 1), (1, 2)}
        assert set(map(tuple, contacts.geom_pairs(contacts.contacts))) == {(0, 1)}


def test_reduced_contacts():
    model = chain()
    data = mujoco.MjData(model)
    data.qpos[2] -= 0.1
    counts = []
    for most in (None, 10):
        with MeshContacts(model, most_per_pair=most) as contacts:
            contacts.forward(model, data)
            counts.append(data.ncon)
    assert counts[0] > 10 >= counts[1] >= 6


def test_reduction_keeps_active_contacts():
    model = chain()
    model.geom_margin[0], model.geom_gap[0] = 0.06, 0.2
    data = mujoco.MjData(model)
    counts = {}
    for most in (None, 40, 6):
        with MeshContacts(model, most_per_pair=most) as contacts:
            contacts.forward(model, data)
            counts[most] = data.ncon, np.count_nonzero(data.contact.exclude == 0)
    assert counts[None][0] > 40 > counts[None][1] > 6
    assert counts[40] == (40, counts[None][1])
    assert counts[6] == (6, 6)


def test_disabled_contacts():
    model = overlapping_cubes(option='><flag contact="disable"/></option><option')
    data = mujoco.MjData(model)
    with MeshContacts(model) as contacts:
        contacts.step(model, data)
    assert data.ncon == 0


def many_bits():
    """31 bits of contype in use by others, and a cube."""
    return overlapping_cubes(
        rest="".join(
            f'<worldbody><geom size=".1" contype="{1 << bit}"/></worldbody>' for bit in range(31)
        )
    )


@pytest.mark.parametrize(
    "model,message",
    [
        (lambda: overlapping_cubes(option='integrator="RK4"'), "RK4"),
        (lambda: overlapping_cubes(option='><flag sleep="enable"/></option><option'), "sleeping"),
        (
            lambda: overlapping_cubes(option='><flag override="enable"/></option><option'),
            "override",
        ),
        (
            lambda: overlapping_cubes(rest='<contact><pair geom1="a" geom2="b"/></contact>'),
            "<pair>",
        ),
        (lambda: overlapping_cubes('surfacevel="1 0 0 0 0 0"'), "surfacevel"),
        (lambda: overlapping_cubes('contype="0"', 'contype="0"'), "no two"),
        (many_bits, "bits of contype"),
    ],
)
def test_what_is_refused(model, message):
    try:
        made = model()
    except ValueError as error:
        pytest.skip(f"not in this MuJoCo: {error}")
    before = [getattr(made, name).copy() for name in MASKS]
    with pytest.raises(ValueError, match=message):
        MeshContacts(made)
    for name, values in zip(MASKS, before):
        np.testing.assert_array_equal(getattr(made, name), values, name)


@pytest.mark.parametrize(
    "options,message",
    [
        ({"most_per_pair": 5}, "most_per_pair must be at least 6, got 5"),
        ({"margin": float("nan")}, "margins and gaps must be finite"),
        ({"margin": float("inf")}, "margins and gaps must be finite"),
    ],
)
def test_options_that_are_refused(options, message):
    model = overlapping_cubes()
    with pytest.raises(ValueError, match=message):
        MeshContacts(model, **options)
    MeshContacts(model).release()


def test_a_model_has_one_adapter_at_a_time():
    model = model_of(
        "".join(
            f'<body pos="{2 * (i // 2)} 0 {0.79 * (i % 2)}"><freejoint/>'
            f'<geom type="mesh" mesh="{("cube", "small")[i % 2]}"/></body>'
            for i in range(4)
        )
    )
    before = [getattr(model, name).copy() for name in MASKS]
    first = MeshContacts(model, [0, 1])
    with pytest.raises(ValueError, match=r"release\(\) it first"):
        MeshContacts(model, [2, 3])
    first.release()
    second = MeshContacts(model, [2, 3])
    first.release()
    data = mujoco.MjData(model)
    second.forward(model, data)
    assert set(map(tuple, second.geom_pairs(second.contacts))) == {(2, 3)}
    assert geom_pairs(data) == {(0, 1), (2, 3)}
    second.release()
    for name, values in zip(MASKS, before):
        np.testing.assert_array_equal(getattr(model, name), values, name)


def test_what_is_refused_later():
    model = overlapping_cubes()
    data = mujoco.MjData(model)
    contacts = MeshContacts(model)
    for call in (contacts.step, contacts.forward, contacts.add):
        with pytest.raises(ValueError, match="not the model"):
            call(overlapping_cubes(), data)
    model.opt.integrator = mujoco.mjtIntegrator.mjINT_RK4
    with pytest.raises(ValueError, match="RK4"):
        contacts.step(model, data)
    contacts.release()
    for call in (contacts.step, contacts.forward, contacts.add):
        with pytest.raises(ValueError, match="released"):
            call(model, data)
    with pytest.raises(ValueError, match="not a mesh"):
        MeshContacts(model_of('<geom name="ball" size="1"/>'), ["ball"])


def test_constraints_that_do_not_fit():
    model = chain(rest='<size memory="20K"/>')
    data = mujoco.MjData(model)
    data.qpos[2] -= 0.1
    with MeshContacts(model, most_per_pair=None) as contacts:
        with pytest.raises(MemoryError, match="arena"):
            contacts.step(model, data)


def test_contacts_that_do_not_fit():
    model = chain(rest='<size memory="100K"/>')
    data = mujoco.MjData(model)
    data.qpos[2] -= 0.1
    with MeshContacts(model) as contacts:
        contacts.forward(model, data)
        with pytest.raises(MemoryError, match="have no room"):
            for _ in range(100):
                contacts.add(model, data)


def test_the_adapter_sees_changed_parameters():
    model = overlapping_cubes()
    data = mujoco.MjData(model)
    with MeshContacts(model) as contacts:
        model.geom_friction[:, 0] = 0.25
        contacts.forward(model, data)
    assert set(data.contact.friction[:, 0]) == {0.25}
