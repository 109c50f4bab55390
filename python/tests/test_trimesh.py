"""pierce.trimesh against trimesh's own manager: its own tests, and random places."""

import os
import subprocess
import sys
import tarfile
from pathlib import Path

import numpy as np
import pytest
from conftest import box, torus

trimesh = pytest.importorskip("trimesh", reason="trimesh is not installed")
from pierce.trimesh import (  # noqa: E402
    CollisionManager,
    ContactData,
    DistanceData,
    scene_to_collision,
)

CUBE = trimesh.Trimesh(*box(), process=False)
TORUS = trimesh.Trimesh(*torus(), process=False)
SQUARE = trimesh.Trimesh(
    [[-5, -5, 0], [5, -5, 0], [5, 5, 0], [-5, 5, 0]], [[0, 1, 2], [0, 2, 3]], process=False
)


def at(x, y=0.0, z=0.0):
    return trimesh.transformations.translation_matrix([x, y, z])


def manager_of(**places):
    manager = CollisionManager()
    for name, x in places.items():
        manager.add_object(name, CUBE, at(x))
    return manager


def random_place(rng, size):
    place = trimesh.transformations.random_rotation_matrix(rng.random(3))
    place[:3, 3] = rng.uniform(-size, size, 3)
    return place


def test_single_collides_with_the_object_in_the_same_place():
    manager = manager_of(cube0=0, cube1=5)
    assert manager.in_collision_single(CUBE) is True
    hit, names, data = manager.in_collision_single(CUBE, at(5), return_names=True, return_data=True)
    assert hit is True and names == {"cube1"} and data
    for contact in data:
        assert isinstance(contact, ContactData) and contact.names == {"cube1", "__external"}
    hit, names, data = manager.in_collision_single(
        CUBE, at(-5), return_names=True, return_data=True
    )
    assert hit is False and names == set() and data == []


def test_internal_follows_added_moved_and_removed_objects():
    manager = manager_of(cube0=0, cube1=5)
    assert manager.in_collision_internal() is False
    manager.add_object("cube2", CUBE, at(5))
    assert manager.in_collision_internal(return_names=True) == (True, {("cube1", "cube2")})
    manager.set_transform("cube2", at(-5))
    assert manager.in_collision_internal() is False
    manager.set_transform("cube2", at(5))
    assert manager.in_collision_internal() is True
    manager.remove_object("cube2")
    assert manager.in_collision_internal() is False


def test_names_are_in_alphabetical_order_whatever_was_added_first():
    manager = manager_of(z=0, a=0.5)
    assert manager.in_collision_internal(return_names=True) == (True, {("a", "z")})
    assert manager.min_distance_internal(return_names=True)[1] == ("a", "z")


def test_other_manager():
    manager, other = manager_of(cube0=0, cube1=5), manager_of(cube0=-5)
    assert manager.in_collision_other(other) is False
    other.add_object("cube3", CUBE, at(5))
    assert manager.in_collision_other(other) is True
    hit, names = manager.in_collision_other(other, return_names=True)
    assert hit is True and names == {("cube1", "cube3")}
    assert other.in_collision_other(manager, return_names=True)[1] == {("cube3", "cube1")}
    assert manager.in_collision_other(manager, return_names=True)[1] == {
        ("cube0", "cube0"),
        ("cube1", "cube1"),
    }


def test_objects_of_a_query_leave_nothing_behind():
    manager = manager_of(cube0=0)
    manager.in_collision_single(CUBE, at(0.5))
    manager.min_distance_single(TORUS, at(4))
    assert manager.in_collision_internal() is False
    manager.add_object("cube1", CUBE, at(1.2))  # within the margin of the query before
    assert manager.in_collision_internal(True, True) == (False, set(), [])


def test_a_name_is_replaced():
    manager = manager_of(cube0=0)
    manager.add_object("cube0", CUBE, at(9))
    assert manager.in_collision_single(CUBE) is False
    assert manager.in_collision_single(CUBE, at(9)) is True


def test_errors():
    manager = manager_of(cube0=0)
    for call in (manager.remove_object, manager.min_distance_internal):
        with pytest.raises(ValueError, match="none not in collision manager!"):
            call("none")
    with pytest.raises(ValueError, match="none not in collision manager!"):
        manager.set_transform("none", np.eye(4))
    with pytest.raises(ValueError, match=r"transform must be \(4,4\)!"):
        manager.add_object("cube1", CUBE, np.eye(3))
    for bad in (np.diag([2, 2, 2, 1]), np.diag([-1, 1, 1, 1])):
        with pytest.raises(ValueError, match="transform must be rigid"):
            manager.in_collision_single(CUBE, bad)


@pytest.mark.parametrize("mesh", [CUBE, SQUARE])
def test_what_is_refused_changes_nothing(mesh):
    manager = manager_of(cube0=0)
    manager.add_object("other", mesh, at(0.6, 0.1, 0.2))
    before = manager.in_collision_internal(return_names=True)
    assert before == (True, {("cube0", "other")})
    torn = at(0)
    torn[3, 3] = 2
    for bad in (at(np.nan), at(np.inf), at(1e300), at(0) * np.nan, torn):
        for refused in (
            lambda bad=bad: manager.add_object("other", mesh, bad),
            lambda bad=bad: manager.add_object("new", mesh, bad),
            lambda bad=bad: manager.set_transform("other", bad),
            lambda bad=bad: manager.in_collision_single(mesh, bad),
        ):
            with pytest.raises(ValueError, match="transform must be"):
                refused()
    flat = trimesh.Trimesh(np.eye(3), np.zeros((0, 3), int), process=False)
    with pytest.raises(ValueError, match="no triangles"):
        manager.add_object("other", flat)
    with pytest.raises(TypeError, match="unhashable"):
        manager.add_object(["other"], mesh)
    assert manager.in_collision_internal(return_names=True) == before
    manager.set_transform("other", at(9))
    assert manager.in_collision_internal() is False
    assert manager.min_distance_internal(return_names=True)[1] == ("cube0", "other")


def test_rounded_transforms_are_rigid():
    rng = np.random.default_rng(4)
    manager = manager_of(cube0=0)
    for _ in range(20):
        place = random_place(rng, 0.2)
        place[:3, :3] *= 1 + 9e-6 * rng.choice([-1, 1], (3, 1))
        manager.add_object("cube1", CUBE, place)
        manager.set_transform("cube0", place)
        assert manager.in_collision_internal() is True


def test_contact_data_is_between_the_surfaces_and_points_from_the_first_to_the_second():
    manager = manager_of(a=0)
    hit, data = manager.in_collision_single(CUBE, at(0.9, 0.2, 0.3), return_data=True)
    assert hit is True
    deepest = max(data, key=lambda contact: contact.depth)
    sign = 1 if list(deepest._inds) == ["a", "__external"] else -1
    assert deepest.depth == pytest.approx(0.1, abs=1e-6)
    np.testing.assert_allclose(deepest.normal, [sign, 0, 0], atol=1e-6)
    assert 0.4 - 1e-6 <= deepest.point[0] <= 0.5 + 1e-6
    for contact in data:
        assert contact.point.shape == (3,) and contact.depth >= 0
        for name, x in (("a", 0), ("__external", 0.9)):
            corners = CUBE.triangles[contact.index(name)] + [x, 0, 0]
            assert corners[:, 0].min() - 0.1 <= contact.point[0] <= corners[:, 0].max() + 0.1


def test_concave_meshes_do_not_collide_with_what_is_in_their_hole():
    manager = CollisionManager()
    manager.add_object("ring", TORUS)
    ball = trimesh.creation.icosphere(radius=0.5)
    assert manager.in_collision_single(ball) is False
    assert manager.in_collision_single(ball, at(0.2)) is True
    assert manager.in_collision_single(TORUS, at(1)) is True


def test_a_mesh_that_is_changed_in_place_is_seen_as_it_is():
    manager, mesh = manager_of(a=0), CUBE.copy()
    assert manager.in_collision_single(mesh) is True
    mesh.apply_translation([3, 0, 0])
    assert manager.in_collision_single(mesh) is False
    mesh.invert()
    assert manager.in_collision_single(mesh, at(-3)) is True


def test_single_distances():
    manager = manager_of(cube1=5)
    assert manager.min_distance_single(CUBE) == pytest.approx(4)
    assert manager.min_distance_single(CUBE, at(5.75)) == pytest.approx(-0.25)
    assert manager.min_distance_single(CUBE, return_name=True)[1] == "cube1"
    manager.add_object("cube2", CUBE, at(-5))
    for x, nearest in ((2, "cube1"), (-2, "cube2")):
        distance, name = manager.min_distance_single(CUBE, at(x), return_name=True)
        assert distance == pytest.approx(2) and name == nearest


def test_internal_distances():
    manager = manager_of(cube1=5, cube2=-5)
    assert manager.min_distance_internal() == pytest.approx(9)
    distance, names = manager.min_distance_internal(return_names=True)
    assert distance == pytest.approx(9) and names == ("cube1", "cube2")
    manager.add_object("cube3", CUBE, at(2))
    distance, names = manager.min_distance_internal(return_names=True)
    assert distance == pytest.approx(2) and names == ("cube1", "cube3")
    manager.set_transform("cube3", at(-2))
    distance, names = manager.min_distance_internal(return_names=True)
    assert distance == pytest.approx(2) and names == ("cube2", "cube3")
    distance, names = manager.min_distance_internal(name="cube1", return_names=True)
    assert distance == pytest.approx(6) and names == ("cube1", "cube3")


def test_other_distances():
    manager, other = manager_of(cube0=0, cube1=5), manager_of(cube4=-5)
    for expected, name in ((4, "cube4"), (1, "cube5")):
        distance, names, data = manager.min_distance_other(
            other, return_names=True, return_data=True
        )
        assert distance == pytest.approx(expected) and names == ("cube0", name)
        assert isinstance(data, DistanceData) and data.distance == distance
        assert np.linalg.norm(data.point(names[0]) - data.point(names[1])) == pytest.approx(
            expected
        )
        other.add_object("cube5", CUBE, at(-2))


def test_distance_of_nothing_is_the_largest_number():
    manager = CollisionManager()
    largest = sys.float_info.max
    assert manager.min_distance_single(CUBE, return_name=True) == (largest, None)
    assert manager.min_distance_internal() == largest
    manager.add_object("alone", CUBE)
    assert manager.min_distance_internal(return_names=True, return_data=True) == (
        largest,
        None,
        None,
    )
    assert manager.min_distance_internal("alone") == largest


def test_touching_solids_are_at_distance_0_and_do_not_collide():
    manager = manager_of(a=0)
    assert manager.min_distance_single(CUBE, at(1)) == pytest.approx(0, abs=1e-6)
    assert manager.in_collision_single(CUBE, at(1)) is False


def test_every_pair_is_named():
    probe = trimesh.creation.cylinder(radius=1, height=20)
    manager = CollisionManager()
    names = {f"probe {k}" for k in range(700)}
    for k, name in enumerate(names):
        manager.add_object(name, probe, at(0.04 * k - 14))
    hit, found = manager.in_collision_single(
        trimesh.creation.box(extents=[100, 100, 100]), at(0, 0, 55), return_names=True
    )
    assert hit is True and found == names


def test_scenes():
    rng = np.random.default_rng(1)
    balls = [trimesh.creation.icosphere(subdivisions=1, radius=r) for r in rng.random(40)]
    scene = trimesh.Scene()
    for ball in balls:
        scene.add_geometry(ball, transform=random_place(rng, 4))
    manager, objects = scene_to_collision(scene)
    assert set(objects) == set(scene.graph.nodes_geometry)
    hit, names = manager.in_collision_internal(return_names=True)
    assert isinstance(hit, bool)
    centres = {node: scene.graph[node][0][:3, 3] for node in objects}
    radii = {
        node: scene.geometry[scene.graph[node][1]].bounding_sphere.primitive.radius
        for node in objects
    }
    for a in objects:
        for b in objects:
            gap = np.linalg.norm(centres[a] - centres[b]) - radii[a] - radii[b]
            if a < b and gap < -0.1 * min(radii[a], radii[b]):
                assert (a, b) in names
            if a < b and gap > 0:
                assert (a, b) not in names


def test_surfaces_collide_where_they_go_through_others():
    manager = CollisionManager()
    manager.add_object("square", SQUARE)
    ball = trimesh.creation.icosphere(radius=0.4)
    for z, hit in ((0.13, True), (-0.3, True), (0.5, False)):
        assert manager.in_collision_single(ball, at(2, 1, z)) is hit
    turned = trimesh.transformations.rotation_matrix(1.2, [1, 0.2, 0.1])
    assert manager.in_collision_single(SQUARE, turned) is True
    assert manager.in_collision_single(SQUARE, at(0, 0, 0.5)) is False
    assert manager.in_collision_single(trimesh.creation.box([20, 20, 20])) is False
    manager.add_object("cube", CUBE, at(1))
    manager.add_object("high", CUBE, at(1, 0, 0.9))
    assert manager.in_collision_internal(return_names=True) == (
        True,
        {("cube", "square"), ("cube", "high")},
    )


def test_faces_are_those_of_the_mesh_as_it_was_given():
    box = trimesh.creation.box((1, 1, 1))
    doubled = trimesh.Trimesh(
        box.vertices, np.vstack([box.faces[:1], box.faces]), process=False
    )  # the solid leaves one of the two out, the surface has both
    for face in range(len(doubled.faces)):
        corners = doubled.vertices[doubled.faces[face]]
        middle, out = corners.mean(axis=0), doubled.face_normals[face]
        side = 0.05 * (corners[1] - corners[0])
        tip = trimesh.Trimesh(
            [middle - 0.05 * out, middle + 0.2 * out + side, middle + 0.2 * out - side],
            [[0, 1, 2]],
            process=False,
        )
        manager = CollisionManager()
        manager.add_object("box", doubled)
        hit, contacts = manager.in_collision_single(tip, return_data=True)
        assert hit
        allowed = {0, 1} if face < 2 else {face}
        assert {contact.index("box") for contact in contacts} <= allowed


def test_solids_whose_vertices_are_apart_have_the_faces_of_joined_ones():
    box = trimesh.creation.box((1, 1, 1))
    apart = trimesh.Trimesh(
        box.vertices[box.faces].reshape(-1, 3), np.arange(36).reshape(-1, 3), process=False
    )
    other = trimesh.creation.torus(1, 0.3)
    place = np.eye(4)
    place[:3, 3] = [0.9, 0.45, 0.2]
    found = []
    for mesh in (box, apart):
        manager = CollisionManager()
        manager.add_object("box", mesh)
        _, contacts = manager.in_collision_single(other, place, return_data=True)
        found.append(len(contacts))
        assert min(contact.index("box") for contact in contacts) >= 0
    assert found[0] == found[1] > 0


def test_distances_of_surfaces():
    manager = CollisionManager()
    manager.add_object("square", SQUARE)
    assert manager.min_distance_single(CUBE, at(1, 1, 2)) == pytest.approx(1.5)
    assert manager.min_distance_single(SQUARE, at(2, 1, -3)) == pytest.approx(3)
    assert manager.min_distance_single(CUBE) == 0.0


@pytest.mark.parametrize("mesh", [CUBE, SQUARE])
def test_a_vertex_without_faces_is_no_place(mesh):
    stray = trimesh.Trimesh([*mesh.vertices, [7.5, 0, 0]], mesh.faces, process=False)
    manager = CollisionManager()
    manager.add_object("stray", stray)
    manager.add_object("other", CUBE, at(0, 0, 9))
    expected = CollisionManager()
    expected.add_object("stray", mesh)
    expected.add_object("other", CUBE, at(0, 0, 9))
    for place in (at(8), at(2, 1, 7)):
        assert manager.min_distance_single(CUBE, place, return_name=True) == (
            expected.min_distance_single(CUBE, place, return_name=True)
        )
    assert manager.min_distance_internal() == expected.min_distance_internal()
    found, reference = (
        each.in_collision_single(CUBE, at(0.9, 0.1, 0.2), return_data=True)
        for each in (manager, expected)
    )
    assert found[0] == reference[0] and len(found[1]) == len(reference[1])


def test_distances_do_not_depend_on_the_unit():
    rng = np.random.default_rng(int(os.environ.get("PIERCE_TEST_SEED", 8)))
    for _ in range(20):
        place = random_place(rng, 2) @ at(0, 0, 2)
        found = []
        for unit in (1.0, 2.0**-13):
            square, cube = (mesh.copy().apply_scale(unit) for mesh in (SQUARE, CUBE))
            there = place.copy()
            there[:3, 3] *= unit
            manager = CollisionManager()
            manager.add_object("square", square)
            found.append(manager.min_distance_single(cube, there) / unit)
        assert found[0] == pytest.approx(found[1], rel=1e-9)


@pytest.mark.parametrize("kind", ["torus", "box", "square"])
def test_random_distances_are_those_of_fcl(kind):
    pytest.importorskip("fcl", reason="python-fcl is not installed")
    rng = np.random.default_rng(int(os.environ.get("PIERCE_TEST_SEED", 7)))
    mesh = {"torus": TORUS, "box": CUBE, "square": SQUARE}[kind]
    ours, theirs = CollisionManager(), trimesh.collision.CollisionManager()
    for name in ("a", "b", "c"):
        place = random_place(rng, 3)
        for manager in (ours, theirs):
            manager.add_object(name, TORUS if name == "a" else mesh, place)
    apart = 0
    for _ in range(30):
        place = random_place(rng, 12)
        expected, name = theirs.min_distance_single(mesh, place, return_name=True)
        distance, found, data = ours.min_distance_single(
            mesh, place, return_name=True, return_data=True
        )
        if expected <= 0:
            continue
        apart += 1
        assert distance == pytest.approx(expected, rel=1e-5, abs=1e-5)
        assert found == name
        points = data.point(found), data.point("__external")
        assert np.linalg.norm(points[0] - points[1]) == pytest.approx(distance, abs=1e-5)
        assert ours.in_collision_single(mesh, place) is False
    assert apart > 5


def test_two_convex_meshes_have_the_contact_that_fcl_has():
    pytest.importorskip("fcl", reason="python-fcl is not installed")
    rng = np.random.default_rng(int(os.environ.get("PIERCE_TEST_SEED", 7)))
    shapes = [CUBE, trimesh.creation.icosphere(1), trimesh.creation.cone(0.6, 1.2, sections=9)]
    compared = 0
    for k in range(40):
        first, second = shapes[k % 3], shapes[k % 2]
        place = random_place(rng, 0.8)
        found = {}
        for manager in (CollisionManager(), trimesh.collision.CollisionManager()):
            manager.add_object("a", first)
            hit, data = manager.in_collision_single(second, place, return_data=True)
            found[isinstance(manager, CollisionManager)] = data
            assert len(data) == int(hit)
        if not (found[True] and found[False]):
            assert not found[True]
            continue
        ours, theirs = found[True][0], found[False][0]
        compared += 1
        # FCL's way is not always the shortest one.
        assert ours.depth <= theirs.depth * (1 + 1e-4) + 1e-6
        if ours.depth > theirs.depth * (1 - 1e-4):
            assert abs(ours.normal @ theirs.normal) > 0.99
        apart = trimesh.transformations.translation_matrix(ours.normal * (ours.depth + 1e-5))
        manager = CollisionManager()
        manager.add_object("a", first)
        assert manager.in_collision_single(second, apart @ place) is False
        # The point is half way between the surfaces, which are as far apart as it is deep.
        for mesh, turn, way in ((first, np.eye(4), 0.5), (second, place, -0.5)):
            point = ours.point + way * ours.depth * ours.normal
            local = trimesh.transform_points([point], np.linalg.inv(turn))
            assert trimesh.proximity.closest_point(mesh, local)[1][0] < 1e-4
        assert ours.index("a") >= 0
    assert compared > 15


@pytest.mark.parametrize("mesh", [CUBE, TORUS])
def test_normals_point_from_the_manager_to_the_other_mesh(mesh):
    manager = CollisionManager()
    manager.add_object("gone", mesh, at(50))
    manager.add_object("stays", mesh)
    # The other mesh takes the place in the world that this one leaves.
    manager.remove_object("gone")
    _, data = manager.in_collision_single(mesh, at(0, 0, 0.7), return_data=True)
    assert data
    deepest = max(data, key=lambda contact: contact.depth)
    assert deepest.normal[2] > 0.9


RUN = """
import sys, types, pathlib, unittest
sys.modules.setdefault("fcl", types.ModuleType("fcl"))
sys.path.insert(0, str(pathlib.Path(sys.argv[1]).parent))
import trimesh.collision
from pierce.trimesh import CollisionManager
trimesh.collision.CollisionManager = CollisionManager
file = pathlib.Path(sys.argv[1])
tests = types.ModuleType("tests")
exec(compile(file.read_text(), str(file), "exec"), tests.__dict__)
suite = unittest.defaultTestLoader.loadTestsFromModule(tests)
done = unittest.TextTestRunner().run(suite)
sys.exit(not (done.wasSuccessful() and done.testsRun >= 5 and not done.skipped))
"""
# The source package has trimesh's tests without what they share and without meshes.
GENERIC = """
import logging, unittest
import numpy as np
import trimesh

log = logging.getLogger("trimesh")


random = np.random.default_rng(0).random
CORNERS = np.array([
    [-1, -1, 1], [-1, 1, 1], [-1, -1, -1], [-1, 1, -1],
    [1, -1, 1], [1, -1, -1], [1, 1, 1], [1, 1, -1]])
FACES = [
    [0, 1, 2], [2, 1, 3], [4, 0, 5], [5, 0, 2], [6, 4, 7], [7, 4, 5],
    [1, 6, 3], [3, 6, 7], [4, 6, 0], [0, 6, 1], [7, 5, 3], [3, 5, 2]]


def get_mesh(name):
    if name == "unit_cube.STL":
        return trimesh.Trimesh(CORNERS / 2, FACES, process=False)
    assert name == "cycloidal.3DXML"
    scene = trimesh.Scene()
    for k in range(12):
        part = trimesh.creation.annulus(1, 2, 0.5, sections=24)
        scene.add_geometry(part, transform=trimesh.transformations.translation_matrix(
            [0.3 * k, 0.1 * k, 0.4 * k]))
    return scene
"""


@pytest.fixture
def collision_tests(tmp_path):
    """trimesh's own tests of collisions, those of the version that is installed, from PyPI.

    PIERCE_TRIMESH_TESTS names them in a folder of trimesh's repository, where its meshes are, too.
    """
    if "PIERCE_TRIMESH_TESTS" in os.environ:
        return Path(os.environ["PIERCE_TRIMESH_TESTS"])
    wanted = f"trimesh=={trimesh.__version__}"
    pip = [sys.executable, "-m", "pip", "--disable-pip-version-check"]
    fetch = ["download", "--no-deps", "--no-binary", "trimesh", wanted, "-d", str(tmp_path)]
    if subprocess.run([*pip, *fetch], check=False, capture_output=True).returncode:
        pytest.skip("PyPI cannot be reached")
    with tarfile.open(next(tmp_path.glob("*.tar.gz"))) as archive:
        archive.extractall(tmp_path, filter="data")
    tests = next(tmp_path.glob("trimesh-*/tests"))
    (tests / "generic.py").write_text(GENERIC)
    return tests / "test_collision.py"


def test_what_trimesh_tests(collision_tests):
    pytest.importorskip("lxml", reason="lxml is not installed")
    done = subprocess.run(
        [sys.executable, "-c", RUN, str(collision_tests)],
        check=False,
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stderr
