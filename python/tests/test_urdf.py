"""URDF: joints that follow others, packages, sizes, and files that are malformed."""

import time
from xml.etree import ElementTree

import numpy as np
import pierce
import pytest
from conftest import box, torus
from pierce import robots
from test_files import write_stl, write_text
from test_robots import check_threads, write_urdf

pytest.importorskip("trimesh", reason="trimesh is not installed")

BOX = '<collision><geometry><box size="1 1 1"/></geometry></collision>'


def link(name, shapes=BOX):
    return f'<link name="{name}">{shapes}</link>'


def joint(name, parent, child, kind="revolute", more=""):
    return (
        f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>'
        f'<axis xyz="0 0 1"/>{more}</joint>'
    )


def read(folder, *parts, **options):
    path = folder / "robot.urdf"
    path.write_text(f'<robot name="r">{"".join(parts)}</robot>')
    return robots.read_robot(path, **options)


def angles(robot, values):
    """Turns of the shapes around z."""
    poses = robot.poses(values)
    return 2 * np.arctan2(poses[:, 5], poses[:, 6])


def test_prefixes_need_not_be_declared(tmp_path):
    shape = '<collision><geometry><box size="1 2 3"/></geometry></collision>'
    robot = read(tmp_path, link("base", shape), '<drake:joint drake:acceleration="2.5"/>')
    assert len(robot.shapes) == 1


def test_boxes_are_told_apart_by_all_digits(tmp_path):
    shapes = "".join(
        f'<collision><geometry><box size="{size} 1 1"/></geometry></collision>'
        for size in (1.001, 1.002, 1.001)
    )
    with np.printoptions(precision=2):
        robot = read(tmp_path, link("base", shapes))
    sizes = [np.ptp(robot.meshes[shape.mesh].vertices[:, 0]) for shape in robot.shapes]
    assert sizes == pytest.approx([1.001, 1.002, 1.001]) and len(robot.meshes) == 2


def test_joints_that_follow_others(tmp_path):
    joints = {
        "floats": ("floating", ""),
        "plane": ("planar", ""),
        "third": ("revolute", '<mimic joint="second" multiplier="3" offset="-1"/>'),
        "second": ("continuous", '<mimic joint="first" multiplier="2" offset=".5"/>'),
        "first": ("revolute", ""),
        "free": ("revolute", ""),
        "still": ("revolute", '<mimic joint="floats" multiplier="2" offset=".25"/>'),
        "weld": ("fixed", ""),
        "welded": ("revolute", '<mimic joint="weld" offset=".5"/>'),
    }
    parts = [link("base", "")]
    for name, (kind, more) in joints.items():
        parts += [link(f"of {name}"), joint(name, "base", f"of {name}", kind, more)]
    robot = read(tmp_path, *parts)
    assert list(robot.joints) == ["first", "free"] and len(robot.rest) == 2
    assert robot.notes == (
        "does not move: floating joint 'floats'",
        "does not move: planar joint 'plane'",
    )
    expected = [0, 0, 3 * 1.1 - 1, 1.1, 0.3, -0.7, 0.25, 0, 0.5]
    for values in ({"first": 0.3, "free": -0.7}, [0.3, -0.7]):
        np.testing.assert_allclose(angles(robot, values), expected, atol=1e-12)
    with pytest.raises(KeyError, match="no joint 'floats'"):
        robot.poses({"floats": 1})


def test_axes_of_any_length(tmp_path):
    parts = [link("base", ""), link("a"), link("b")]
    parts.append(joint("turn", "base", "a").replace("0 0 1", "0 0 5"))
    parts.append(joint("slide", "base", "b", "prismatic").replace("0 0 1", "0 3 4"))
    robot = read(tmp_path, *parts)
    assert angles(robot, [0.5, 2])[0] == pytest.approx(0.5)
    np.testing.assert_allclose(robot.poses([0.5, 2])[1, :3], [0, 1.2, 1.6])


def test_long_chains(tmp_path):
    count = 600
    parts = [link("l0")]
    for k in range(count):
        origin = '<origin xyz="1 0 0"/>'
        parts += [link(f"l{k + 1}"), joint(f"j{k}", f"l{k}", f"l{k + 1}", more=origin)]
    begin = time.monotonic()
    robot = read(tmp_path, *parts)
    turns = np.random.default_rng(0).uniform(-0.1, 0.1, count)
    poses = robot.poses(turns)
    assert time.monotonic() - begin < 30
    sums = np.cumsum([0.0, *turns])
    steps = np.stack([np.cos(sums[:-1]), np.sin(sums[:-1])], 1)
    np.testing.assert_allclose(poses[1:, :2], np.cumsum(steps, 0), atol=1e-9)
    assert robot.meets.sum() == (count + 1) ** 2 - (count + 1) - 2 * count


def test_values_that_are_not_finite(tmp_path):
    robot = read(tmp_path, link("base"), link("a"), joint("turn", "base", "a"))
    world = pierce.World("bvh", 1)
    bodies = robot.add_to(world)
    for values in ({"turn": np.nan}, [np.inf]):
        with pytest.raises(pierce.InputError, match=r"'r': .* \['turn'\] are not finite"):
            bodies.set(values)
    with pytest.raises(ValueError, match=r"joint 'turn' has 1 values, got shape \(2,\)"):
        bodies.set({"turn": [1, 2]})
    for base, what in (([np.nan, 0, 0, 0, 0, 0, 1], "not finite"), (np.zeros(7), "no rotation")):
        with pytest.raises(ValueError, match=what):
            bodies.set([0], base)


def test_threads_share_a_robot(tmp_path):
    check_threads(robots.read_robot(write_urdf(tmp_path)))


def test_packages(tmp_path):
    folder = tmp_path / "work" / "urdf"
    folder.mkdir(parents=True)
    mesh = '<collision><geometry><mesh filename="package://{}/ring.stl"/></geometry></collision>'

    def file_of(package, **options):
        return read(folder, link("base", mesh.format(package)), **options).meshes[0].file

    for place in (folder, folder.parent):
        write_stl(place / "ring.stl", *torus())
    for package in ("other", "ring.stl"):
        with pytest.raises(pierce.InputError, match=rf"cannot find 'package://{package}/ring.stl'"):
            file_of(package)
    assert file_of("work") == folder.parent / "ring.stl"
    (tmp_path / "other").mkdir()
    write_stl(tmp_path / "other" / "ring.stl", *torus())
    assert file_of("other") == tmp_path / "other" / "ring.stl"
    (folder.parent / "package.xml").write_text("<package><name>said</name></package>")
    assert file_of("said") == folder.parent / "ring.stl"
    assert file_of("said", packages={"said": folder}) == folder / "ring.stl"
    with pytest.raises(pierce.InputError, match="cannot find"):
        file_of("work", packages={"work": tmp_path})


def test_one_mesh_at_two_scales(tmp_path):
    write_text(tmp_path / "box.obj", *box())
    mesh = '<collision><geometry><mesh filename="box.obj"{}/></geometry></collision>'
    scales = ("", ' scale="2"', ' scale="1 2 3"', ' scale="1 1 1"')
    robot = read(tmp_path, link("base", "".join(map(mesh.format, scales))))
    sizes = [np.ptp(robot.meshes[shape.mesh].vertices, axis=0) for shape in robot.shapes]
    np.testing.assert_allclose(sizes, [[1, 1, 1], [2, 2, 2], [1, 2, 3], [1, 1, 1]])
    assert len(robot.meshes) == 3


@pytest.mark.parametrize("end", range(0, 100, 3))
def test_files_cut_short(end, tmp_path):
    path = write_urdf(tmp_path)
    text = path.read_text()
    path.write_text(text[: len(text) * end // 100])
    with pytest.raises(pierce.InputError, match=r"cannot read '.*arm\.urdf'"):
        robots.read_robot(path)


MALFORMED = (
    ('<robot name="arm">', '<sdf name="arm">', "expected <robot>, got <sdf>"),
    ('link name="base"', "link", "a <link> has no name"),
    ('link name="upper"', 'link name="base"', "two links 'base'"),
    ('joint name="spin"', "joint", "a <joint> has no name"),
    ('joint name="turn"', 'joint name="spin"', "two joints 'spin'"),
    ('type="continuous"', 'type="springy"', "joint 'spin': there is no type 'springy'"),
    ('<parent link="upper"/>', "", "joint 'spin': a <parent> has no link"),
    ('<child link="lower"/>', "<child/>", "joint 'spin': a <child> has no link"),
    ('<child link="upper"/>', '<child link="tool"/>', "two joints lead to link 'tool'"),
    (
        '<parent link="base"/><child link="slider"/>',
        '<parent link="b"/><child link="slider"/>',
        "joint 'slide': there is no link 'b'",
    ),
    (
        '<parent link="base"/><child link="upper"/>',
        '<parent link="tool"/><child link="upper"/>',
        r"the joints \['spin', 'turn', 'weld'\] go in rings",
    ),
    ('<axis xyz="1 0 0"/>', '<axis xyz="0 0 0"/>', "joint 'spin': the axis has no direction"),
    (
        'xyz="0 .6 .8"',
        'xyz="0 nan .8"',
        "joint 'turn': xyz of <axis>: expected 3 numbers, got '0 nan .8'",
    ),
    ('rpy="0 0 1"', 'rpy="0 0"', "joint 'spin': rpy of <origin>: expected 3 numbers, got '0 0'"),
    (
        'xyz=".1 .2 .3"',
        'xyz=".1 .2 down"',
        "link 'upper', collision 'ring': xyz of <origin>: expected 3 numbers",
    ),
    ('<box size="1 2 3"/>', "<box/>", "link 'base', collision 'base/0': a <box> has no size"),
    ('<geometry><box size="1 2 3"/></geometry>', "<geometry/>", "'base/0': it has no geometry"),
    ('box size=".1 .1 .1"', 'box size=".1 -.1 .1"', "'tool/0': the size of a <box> is not"),
    ('sphere radius=".4"', 'sphere radius="0"', "'lower/0': the size of a <sphere> is not"),
    (
        'cylinder radius=".2" length="1"',
        'cylinder radius=".2" length="inf"',
        "'upper/1': length of <cylinder>: expected a number, got 'inf'",
    ),
    ('scale="1 2 .5"', 'scale="1 0 .5"', "the scale of a <mesh> is 0"),
    ('filename="ring.stl" ', "", "a <mesh> has no filename"),
    ('"ring.stl"', '"none.stl"', "cannot find 'none.stl' of "),
    (
        '<axis xyz="0 1 0"/>',
        '<mimic joint="none"/>',
        "joint 'slide' mimics 'none', which is not there",
    ),
)


@pytest.mark.parametrize("old,new,what", MALFORMED)
def test_malformed_files_are_refused(old, new, what, tmp_path):
    path = write_urdf(tmp_path)
    text = path.read_text()
    assert old in text
    text = text.replace(old, new)
    path.write_text(text.replace("</robot>", "</sdf>") if "<sdf" in text else text)
    with pytest.raises(pierce.InputError, match=f"arm.urdf'.*{what}|{what}.*arm.urdf'"):
        robots.read_robot(path)


def test_joints_that_mimic_themselves(tmp_path):
    parts = [link("base"), link("a"), link("b"), link("c")]
    for name, leader in (("a", "b"), ("b", "c"), ("c", "b")):
        parts.append(joint(name, "base", name, more=f'<mimic joint="{leader}"/>'))
    with pytest.raises(pierce.InputError, match=r"robot\.urdf'.* mimics itself"):
        read(tmp_path, *parts)


def test_several_roots_and_no_link(tmp_path):
    with pytest.raises(pierce.InputError, match=r"these are: \['a', 'b'\]"):
        read(tmp_path, link("a"), link("b"))
    with pytest.raises(pierce.InputError, match=r"these are: \[\]"):
        read(tmp_path)


def test_shapes_of_other_kinds_are_left_out(tmp_path):
    capsule = '<collision name="c"><geometry><capsule radius="1"/></geometry></collision>'
    with pytest.warns(UserWarning, match="left out: a shape that is no mesh, box, .*'c'"):
        robot = read(tmp_path, link("base", capsule + BOX))
    assert [shape.name for shape in robot.shapes] == ["base/1"]


def test_whatever_is_missing_is_an_input_error(tmp_path):
    path = write_urdf(tmp_path)
    whole = path.read_text()
    refused = 0
    for mend in ("drop", "nonsense", "empty"):
        for place, element in enumerate(ElementTree.fromstring(whole).iter()):
            for name in element.attrib:
                root = ElementTree.fromstring(whole)
                changed = list(root.iter())[place]
                if mend == "drop":
                    del changed.attrib[name]
                else:
                    changed.set(name, "x y" if mend == "nonsense" else "")
                path.write_bytes(ElementTree.tostring(root))
                try:
                    robots.read_robot(path, "all").poses()
                except pierce.InputError as error:
                    refused += 1
                    assert "arm.urdf" in str(error)
    assert refused > 100


class Watched:
    """A world that knows which meshes it was given, and has no room for some excluded pairs."""

    def __init__(self, world):
        self.world, self.meshes = world, []

    def __getattr__(self, name):
        return getattr(self.world, name)

    def add_mesh(self, *arguments, **options):
        self.meshes.append(self.world.add_mesh(*arguments, **options))
        return self.meshes[-1]

    def exclude(self, a, b):
        if self.world.plan.excluded_pairs == 2:
            raise KeyboardInterrupt
        self.world.exclude(a, b)


def test_what_add_to_refuses_leaves_nothing_behind(tmp_path):
    robot = robots.read_robot(write_urdf(tmp_path))
    world = pierce.World("bvh", 1)
    watched = Watched(world)
    for options, error in (
        ({"inside": "nowhere"}, ValueError),
        ({"values": {"turn": np.nan}}, ValueError),
        ({"values": {"elbow": 1}}, KeyError),
        ({"base": [0, 0, 0]}, ValueError),
        ({"chain": -1}, TypeError),
        ({"chain": "x"}, TypeError),
        ({"colour": "red"}, TypeError),
        ({}, KeyboardInterrupt),
    ):
        with pytest.raises(error):
            robot.add_to(watched, **options)
        plan = world.plan
        assert (plan.rigid_bodies, plan.excluded_pairs) == (0, 0), options
    assert len(watched.meshes) == len(robot.meshes)
    for mesh in watched.meshes:
        with pytest.raises(pierce.InputError):
            world.mesh(mesh)
    robot.add_to(world)
    assert world.plan.rigid_bodies == len(robot.shapes)
