"""pierce.viewers: what reaches the viewers is where the world is."""

import socket
import sys

import numpy as np
import pierce
import pytest
from conftest import box, torus
from pierce import viewers

POSE = np.array([0.9, 0.1, -0.2, 0.5, -0.5, 0.5, 0.5])


class Recorded(viewers.Viewer):
    """Keeps what it is given."""

    def __init__(self, world, **options):
        super().__init__(world, **options)
        self.meshes, self.places, self.made, self.contacts = {}, {}, [], None

    def _set_mesh(self, name, vertices, triangles):
        self.meshes[name] = vertices, triangles
        self.made.append(name)

    def _set_place(self, name, rotation, translation):
        self.places[name] = rotation, translation

    def _remove_body(self, name):
        del self.meshes[name]

    def _set_contacts(self, points, arrows, colors, depth, radius):
        self.contacts = points, arrows, colors, depth, radius

    def _remove_contacts(self):
        self.contacts = None


def test_places_are_those_of_the_world(two_tori):
    world, rigid, soft, positions = two_tori
    plate = (
        np.float32([[0, 0, 0], [2, 0, 0], [2, 1, 0], [0, 1, 0]]),
        np.uint32([[0, 1, 2], [0, 2, 3]]),
    )
    flat = world.add_rigid_body(world.add_mesh(plate, inside="none"), [0, 0, 9, 0, 0, 0, 1])
    viewer = Recorded(world, names={soft: "soft"})
    for pose in ([0, 0, 0, 0, 0, 0, 1], POSE):
        for body in (rigid, flat):
            world.set_pose(body, pose)
        world.detect()
        viewer.log(0)
        for body in (rigid, flat):
            rotation, translation = viewer.places[f"body {body.index}"]
            rest = world.mesh(world.mesh_of(body)).vertices
            now = world.vertex_positions(body)
            np.testing.assert_allclose(rest @ rotation.T + translation, now, atol=1e-5)
    np.testing.assert_array_equal(viewer.meshes["soft"][0], positions)
    assert viewer.made.count("body 0") == 1 and viewer.made.count("soft") == 2


def test_contacts_are_points_and_arrows(two_tori):
    world, *_ = two_tori
    contacts = world.detect()
    viewer = Recorded(world, arrow_scale=3)
    viewer.log(0)
    points, arrows, colors, depth, radius = viewer.contacts
    assert len(points) == len(contacts) > 0 and radius > 0
    np.testing.assert_allclose(points, (contacts.point_a + contacts.point_b) / 2)
    np.testing.assert_allclose(np.linalg.norm(arrows, axis=1), 3 * depth, atol=1e-12)
    assert colors.dtype == np.uint8
    assert tuple(colors[depth.argmax()]) == (254, 232, 56)


def test_worlds_bodies_and_meshes_come_and_go():
    world = pierce.World("embree", 1)
    mesh = world.add_mesh(box())
    body = world.add_rigid_body(mesh)
    world.set_filter(body, pierce.Filter(world=3))
    other = world.add_rigid_body(mesh, [5, 0, 0, 0, 0, 0, 1])
    viewer = Recorded(world)
    world.detect()
    viewer.log(0)
    assert set(viewer.meshes) == {"body 0", "body 1"} and viewer.contacts is None
    world.remove_body(other)
    world.set_mesh(body, world.add_mesh(torus()))
    world.detect()
    viewer.log(1)
    assert set(viewer.meshes) == {"body 0"}
    assert len(viewer.meshes["body 0"][0]) == len(torus()[0])


@pytest.mark.filterwarnings("error")
def test_bodies_that_are_nowhere_are_not_shown():
    world = pierce.World("embree", 1)
    vertices, triangles = box()
    mesh = world.add_mesh((vertices, triangles))
    rigid, soft = world.add_rigid_body(mesh), world.add_deforming_body(mesh)
    viewer = Recorded(world, names={rigid: "rigid", soft: "soft"})
    good, nowhere = [0, 0, 0, 0, 0, 0, 1], [0, 0, 0, 0, 0, 0, 0]
    for pose in (good, nowhere, good, [np.nan] * 7, [0, 0, 0, 1e-200, 0, 0, 0]):
        world.set_pose(rigid, pose)
        world.detect()
        viewer.log(0)
        assert set(viewer.meshes) == ({"rigid", "soft"} if pose == good else {"soft"})
    for positions in (vertices * np.float32(np.nan), vertices):
        world.set_positions(soft, positions)
        world.detect()
        viewer.log(0)
        assert ("soft" in viewer.meshes) == (positions is vertices)
    world.set_pose(rigid, [1e30, 0, 0, 0, 0, 0, 1])
    world.detect()
    viewer.log(0)
    assert set(viewer.meshes) == {"soft"}
    world.set_pose(rigid, good)
    world.set_filter(rigid, pierce.Filter(world=1))
    for active in (True, False):
        world.set_world_active(1, active)
        world.detect()
        viewer.log(0)
        assert ("rigid" in viewer.meshes) == active
    world.remove_body(rigid)
    world.detect()
    viewer.log(0)
    assert set(viewer.meshes) == {"soft"}


def test_two_bodies_of_one_name():
    world = pierce.World("embree", 1)
    mesh = world.add_mesh(box())
    first, second, third = (world.add_rigid_body(mesh, [x, 0, 0, 0, 0, 0, 1]) for x in (0, 2, 4))
    viewer = Recorded(world, names={first: "a", second: "a", third: "body 5"})
    world.detect()
    viewer.log(0)
    assert set(viewer.meshes) == {"a", "a 1", "body 5"}
    world.remove_body(first)
    world.detect()
    viewer.log(1)
    assert set(viewer.meshes) == {"a 1", "body 5"}
    world.remove_body(second)
    world.detect()
    viewer.log(2)
    assert set(viewer.meshes) == {"body 5"}


def run(viewer, world, soft, positions):
    """Three steps: contacts, none, and contacts again; then a body goes."""
    for step, away in enumerate((0, 9, 0)):
        world.set_positions(soft, positions + np.float32([0, 0, away]))
        contacts = world.detect()
        assert (len(contacts) > 0) == (away == 0)
        viewer.log(step, step / 60)
    world.remove_body(soft)
    world.detect()
    viewer.log(3, 3 / 60)


def test_rerun(two_tori, tmp_path):
    rerun = pytest.importorskip("rerun", reason="rerun-sdk is not installed")
    world, _, soft, positions = two_tori
    recording = rerun.RecordingStream("test")
    recording.save(tmp_path / "run.rrd")
    run(viewers.Rerun(world, recording, names={soft: "a soft torus"}), world, soft, positions)
    recording.flush()
    recording.disconnect()
    assert (tmp_path / "run.rrd").stat().st_size > 10_000


def test_rerun_without_a_recording(two_tori):
    pytest.importorskip("rerun", reason="rerun-sdk is not installed")
    with pytest.raises(ValueError, match="no current recording"):
        viewers.Rerun(two_tori[0])


def test_polyscope(two_tori, tmp_path, monkeypatch):
    polyscope = pytest.importorskip("polyscope", reason="polyscope is not installed")
    monkeypatch.chdir(tmp_path)  # it writes its settings there
    polyscope.init("openGL_mock")
    world, rigid, soft, positions = two_tori
    viewer = viewers.Polyscope(world)
    world.set_pose(rigid, POSE)
    world.detect()
    viewer.log(0)
    shown = polyscope.get_surface_mesh("body 0").get_transform()
    np.testing.assert_allclose(shown[:3, 3], POSE[:3], atol=1e-6)
    assert polyscope.has_point_cloud("contacts") == (len(world.contacts) > 0)
    world.set_pose(rigid, [0, 0, 0, 0, 0, 0, 1])
    run(viewer, world, soft, positions)
    polyscope.frame_tick()
    assert not polyscope.has_surface_mesh("body 1") and not polyscope.has_point_cloud("contacts")


def test_polyscope_shows_the_triangles_of_another_mesh(tmp_path, monkeypatch):
    polyscope = pytest.importorskip("polyscope", reason="polyscope is not installed")
    monkeypatch.chdir(tmp_path)
    polyscope.init("openGL_mock")
    made, register = [], polyscope.register_surface_mesh

    def watched(name, vertices, triangles, **options):
        made.append((name, np.array(triangles)))
        return register(name, vertices, triangles, **options)

    monkeypatch.setattr(polyscope, "register_surface_mesh", watched)
    world = pierce.World("embree", 1)
    vertices, triangles = box()
    order = np.array([7, 1, 2, 3, 4, 5, 6, 0])
    mesh = world.add_mesh((vertices, triangles))
    other = world.add_mesh((vertices[order], order[triangles].astype(np.uint32)))
    rigid, soft = world.add_rigid_body(mesh), world.add_deforming_body(mesh)
    viewer = viewers.Polyscope(world, names={rigid: "rigid", soft: "soft"})
    for step in range(2):
        world.detect()
        viewer.log(step)
    assert [name for name, _ in made] == ["rigid", "soft"]
    world.set_mesh(rigid, other)
    world.set_mesh(soft, other, vertices[order])
    world.detect()
    viewer.log(2)
    assert [name for name, _ in made] == ["rigid", "soft"] * 2
    for _, shown in made[2:]:
        np.testing.assert_array_equal(shown, world.mesh(other).triangles)


def free_port():
    with socket.socket() as listener:
        listener.bind(("127.0.0.1", 0))
        return listener.getsockname()[1]


def test_viser(two_tori):
    viser = pytest.importorskip("viser", reason="viser is not installed")
    world, rigid, soft, positions = two_tori
    server = viser.ViserServer(host="127.0.0.1", port=free_port(), verbose=False)
    try:
        viewer = viewers.Viser(world, server)
        world.set_pose(rigid, POSE)
        world.detect()
        viewer.log(0)
        shown = viewer._handles["/bodies/body 0"]
        np.testing.assert_allclose(shown.position, POSE[:3], atol=1e-6)
        np.testing.assert_allclose(np.abs(shown.wxyz), 0.5, atol=1e-6)
        world.set_pose(rigid, [0, 0, 0, 0, 0, 0, 1])
        serializer = server.get_scene_serializer()
        run(viewer, world, soft, positions)
        assert len(serializer.serialize()) > 1000
        assert set(viewer._handles) == {"/bodies/body 0"}
    finally:
        server.stop()


def test_viser_shows_bodies_whose_names_are_paths(two_tori):
    viser = pytest.importorskip("viser", reason="viser is not installed")
    world, rigid, soft, _ = two_tori
    server = viser.ViserServer(host="127.0.0.1", port=free_port(), verbose=False)
    try:
        viewer = viewers.Viser(world, server, names={soft: "arm", rigid: "arm/hand"})
        world.set_pose(rigid, POSE)
        world.detect()
        viewer.log(0)
        assert len(viewer._handles) > 2
        assert not any(path.startswith("/bodies/arm/") for path in viewer._handles)
        world.remove_body(soft)
        world.detect()
        viewer.log(1)
        (hand,) = viewer._handles.values()
        np.testing.assert_allclose(hand.position, POSE[:3], atol=1e-6)
    finally:
        server.stop()


@pytest.mark.parametrize(
    "viewer,module,package",
    [
        ("Rerun", "rerun", "rerun-sdk"),
        ("Polyscope", "polyscope", "polyscope"),
        ("Viser", "viser", "viser"),
    ],
)
def test_missing_packages_are_named(viewer, module, package, monkeypatch):
    monkeypatch.setitem(sys.modules, module, None)
    with pytest.raises(ImportError, match=f"pip install {package}"):
        getattr(viewers, viewer)(pierce.World("embree", 1))
