"""pierce.gltf: played back by numbers of the file alone, bodies are where the recording is."""

import sys

import numpy as np
import pierce
import pytest
from conftest import box, torus
from pierce import files, gltf
from pierce._frames import surface
from pierce._poses import matrix_of
from test_paraview import OPTIONS, made

pygltflib = pytest.importorskip("pygltflib", reason="pygltflib is not installed")

WIDTH = {"SCALAR": 1, "VEC3": 3, "VEC4": 4}


class Player:
    """A file, and where its nodes are at a time."""

    def __init__(self, path):
        self.file = pygltflib.GLTF2().load(str(path))
        self.blob = self.file.binary_blob()
        self.names = {node.name: place for place, node in enumerate(self.file.nodes)}

    def array(self, accessor):
        about = self.file.accessors[accessor]
        view = self.file.bufferViews[about.bufferView]
        kind = {5125: "<u4", 5126: "<f4"}[about.componentType]
        count = about.count * WIDTH[about.type]
        values = np.frombuffer(self.blob, kind, count, view.byteOffset)
        values = values.reshape(about.count, -1)
        assert values.min(0).tolist() == about.min and values.max(0).tolist() == about.max
        return values

    def value(self, node, path, time):
        """What a track says at a time, None if there is none."""
        animation = self.file.animations[0]
        for channel in animation.channels:
            if (channel.target.node, channel.target.path) == (node, path):
                sampler = animation.samplers[channel.sampler]
                times = self.array(sampler.input)[:, 0]
                values = self.array(sampler.output).reshape(len(times), -1).astype(float)
                if sampler.interpolation == "STEP":
                    return values[np.searchsorted(times, time + 1e-6) - 1]
                return np.array([np.interp(time, times, column) for column in values.T])
        return None

    def positions(self, name, time):
        """World positions of a node's first primitive, and its triangles."""
        place = self.names[name]
        node = self.file.nodes[place]
        primitive = self.file.meshes[node.mesh].primitives[0]
        points = self.array(primitive.attributes.POSITION).astype(float)
        weights = self.value(place, "weights", time)
        for weight, target in zip([] if weights is None else weights, primitive.targets or []):
            points = points + weight * self.array(target["POSITION"])
        moved = {
            path: self.value(place, path, time) for path in ("translation", "rotation", "scale")
        }
        for path, value in moved.items():
            moved[path] = value if value is not None else getattr(node, path)
        if moved["scale"] is not None:
            points = points * moved["scale"]
        if moved["rotation"] is not None:
            pose = [*(moved["translation"]), *moved["rotation"]]
            points = points @ matrix_of(pose)[:3, :3].T + pose[:3]
        triangles = primitive.indices
        return points, None if triangles is None else self.array(triangles).reshape(-1, 3)


@pytest.mark.parametrize("seed", range(3))
def test_bodies_are_where_the_recording_is(seed, tmp_path):
    recording, _ = made(seed)
    gltf.write_animation(tmp_path / "run.glb", recording)
    player = Player(tmp_path / "run.glb")
    for frame in range(recording.frame_count):
        for body, name in enumerate(recording.body_names):
            points, triangles = player.positions(name, frame * recording.dt)
            expected, corners = surface(recording, body, frame)
            np.testing.assert_allclose(points, expected, atol=2e-6)
            np.testing.assert_array_equal(triangles, corners)


def test_rotations_take_the_short_way(tmp_path):
    turn = np.linspace(0, 4 * np.pi, 40)
    poses = np.zeros((40, 7), np.float32)
    poses[:, 5], poses[:, 6] = np.sin(turn / 2), np.cos(turn / 2)
    poses[::3, 3:] *= -2
    recording = pierce.Recording(0.1, [("box", box())], [("a", 0, "rigid", poses)])
    gltf.write_animation(tmp_path / "run.glb", recording)
    player = Player(tmp_path / "run.glb")
    animation = player.file.animations[0]
    turns = player.array(animation.samplers[1].output)
    assert (np.einsum("ij,ij->i", turns[1:], turns[:-1]) > 0.9).all()
    np.testing.assert_allclose(np.linalg.norm(turns, axis=1), 1, atol=1e-6)


def test_bodies_share_a_mesh_and_trimesh_reads_it(tmp_path):
    pytest.importorskip("trimesh", reason="trimesh is not installed")
    pose = np.float32([[0, 0, 1, 0, 0, 0, 1]])
    recording = pierce.Recording(
        0.1, [("box", box())], [(name, 0, "fixed", pose) for name in ("one", "two")]
    )
    for up, top in (("z", [0, 1, 0]), ("y", [0, 0, 1])):
        gltf.write_animation(tmp_path / "run.glb", recording, up=up)
        file = Player(tmp_path / "run.glb").file
        assert len(file.meshes) == 1 and not file.animations
        parts = files.read_parts(tmp_path / "run.glb")
        assert sorted(part.name for part in parts) == ["one", "two"]
        for part in parts:
            np.testing.assert_array_equal(part.triangles, box()[1])
            np.testing.assert_allclose(part.pose[:3], top, atol=1e-6)


def test_contacts_are_shown_in_their_frame(tmp_path):
    recording, _ = made()
    kept = list(gltf.replay(recording, **OPTIONS))
    gltf.write_animation(tmp_path / "run.glb", recording, kept)
    player = Player(tmp_path / "run.glb")
    assert sum(map(len, kept)) > 100
    for frame, contacts in enumerate(kept):
        if not len(contacts):
            assert f"contacts {frame}" not in player.names
            continue
        for other in range(len(kept)):
            points, _ = player.positions(f"contacts {frame}", other * recording.dt)
            middle = (contacts.point_a + contacts.point_b) / 2
            np.testing.assert_allclose(points, middle * (other == frame), atol=1e-6)
        node = player.file.nodes[player.names[f"contacts {frame}"]]
        marks, lines = player.file.meshes[node.mesh].primitives
        assert (marks.mode, lines.mode) == (0, 1)
        ends = player.array(lines.attributes.POSITION).reshape(-1, 2, 3)
        arrows = contacts.normal * contacts.depth[:, None]
        np.testing.assert_allclose(ends[:, 1] - ends[:, 0], arrows, atol=1e-6)


def test_frames_without_a_place_have_no_key(tmp_path):
    poses = np.zeros((5, 7), np.float32)
    poses[:, 0], poses[:, 6] = range(5), 1
    poses[2] = np.nan
    soft = np.stack([torus()[0] + np.float32(k) for k in range(5)])
    soft[3, 7] = np.inf
    recording = pierce.Recording(
        0.1,
        [("box", box()), ("torus", torus())],
        [("a", 0, "rigid", poses), ("soft", 1, "deforming", soft)],
    )
    gltf.write_animation(tmp_path / "run.glb", recording)
    player = Player(tmp_path / "run.glb")
    for frame, offset in ((1, 1), (2, 2), (4, 4)):
        points, _ = player.positions("a", frame * 0.1)
        np.testing.assert_allclose(points, box()[0] + [offset, 0, 0], atol=1e-5)
    for frame in (0, 2, 3, 4):
        points, _ = player.positions("soft", frame * 0.1)
        np.testing.assert_allclose(points, torus()[0] + np.float32(frame), atol=1e-5)


def test_what_is_refused(tmp_path, monkeypatch):
    recording, _ = made()
    with pytest.raises(ValueError, match="expected y or z"):
        gltf.write_animation(tmp_path / "run.glb", recording, up="x")
    with pytest.raises(pierce.InputError, match=r"ends in \.glb"):
        gltf.write_animation(tmp_path / "run.gltf", recording)
    (tmp_path / "folder.glb").mkdir()
    with pytest.raises(pierce.InputError, match="is a folder"):
        gltf.write_animation(tmp_path / "folder.glb", recording)
    kept = list(gltf.replay(recording, **OPTIONS))[:3]
    for contacts in (kept, iter(kept), []):
        with pytest.raises(pierce.InputError, match=r"of [03] frames only"):
            gltf.write_animation(tmp_path / "run.glb", recording, contacts)
    with pytest.raises(pierce.InputError, match="has no bodies"):
        gltf.write_animation(tmp_path / "run.glb", pierce.Recording(0.1, [], []))
    away = np.full((2, *torus()[0].shape), np.nan, np.float32)
    nowhere = pierce.Recording(0.1, [("torus", torus())], [("soft", 0, "deforming", away)])
    with pytest.raises(pierce.InputError, match="no body with a place"):
        gltf.write_animation(tmp_path / "run.glb", nowhere)
    assert not (tmp_path / "run.glb").exists()
    changed = torn(tmp_path / "torn")
    with pytest.raises(pierce.InputError, match="'cloth' has another mesh from frame 1 on"):
        gltf.write_animation(tmp_path / "run.glb", changed)
    monkeypatch.setitem(sys.modules, "pygltflib", None)
    with pytest.raises(ImportError, match="pip install pygltflib"):
        gltf.write_animation(tmp_path / "run.glb", recording)


def torn(folder):
    """A recording of a body whose mesh changes, written by hand."""
    folder.mkdir()
    (folder / "whole.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nf 1 2 3\nf 2 4 3\n")
    (folder / "half.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    square = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0]]
    np.save(folder / "body_0.npy", np.float32(square + square[:3]))
    (folder / "scene.json").write_text(
        '{"format": "pierce-recording", "version": 2, "dt": 0.1, "meshes": ['
        '{"name": "whole", "file": "whole.obj"}, {"name": "half", "file": "half.obj"}],'
        '"bodies": [{"name": "cloth", "mesh": "whole", "motion": "deforming",'
        '"positions": "body_0.npy", "changes": [{"frame": 1, "mesh": "half"}]}]}'
    )
    return pierce.Recording.read(str(folder))
