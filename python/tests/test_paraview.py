"""pierce.paraview: what is read back is the recording and its contacts."""

import sys
from xml.etree import ElementTree

import numpy as np
import pierce
import pytest
from conftest import box, torus
from pierce import paraview, series

meshio = pytest.importorskip("meshio", reason="meshio is not installed")

OPTIONS = {"backend": "embree", "threads": 1}


def made(seed=0, frames=8):
    """A recording of a fixed, a rigid and a deforming body, and positions of all frames."""
    random = np.random.default_rng(seed)
    poses = np.zeros((frames, 7), np.float32)
    poses[:, :3] = random.normal(size=(frames, 3)) / 3
    poses[:, 3:] = random.normal(size=(frames, 4))
    vertices, _ = torus()
    soft = vertices + (random.normal(size=(frames, 1, 3)) / 3).astype(np.float32)
    ground = np.float32([[0, 0, -0.5, 0, 0, 0, 1]])
    recording = pierce.Recording(
        0.125,
        [("box", box(0.8)), ("torus", torus())],
        [
            ("ground", 0, "fixed", ground),
            ("torus, rigid", 1, "rigid", poses),
            ("soft", 1, "deforming", soft),
        ],
    )
    return recording, soft


@pytest.mark.parametrize("seed", range(3))
def test_positions_are_those_of_the_world(seed, tmp_path):
    recording, soft = made(seed)
    paraview.write_series(tmp_path / "run.pvd", recording)
    replay = pierce.Replay(recording, **OPTIONS)
    counts = [len(recording.mesh(body)[0]) for body in range(3)]
    bodies = replay.world.bodies_of(pierce.all_worlds)
    for frame in range(len(replay)):
        mesh = meshio.read(tmp_path / "run" / f"bodies_{frame:06d}.vtu")
        points = np.split(mesh.points, np.cumsum(counts)[:-1])
        assert mesh.points.dtype == np.float32
        replay.step(frame)
        for body, now in zip(bodies, points):
            there = [replay.world.vertex_position(body, v) for v in range(len(now))]
            np.testing.assert_allclose(now, there, rtol=3e-7, atol=3e-7)
        np.testing.assert_array_equal(points[2], soft[frame])
        triangles = mesh.cells_dict["triangle"]
        owner = mesh.cell_data["body"][0]
        for body, start in enumerate(np.cumsum([0, *counts[:-1]])):
            expected = recording.mesh(body)[1].astype(int) + start
            np.testing.assert_array_equal(triangles[owner == body], expected)


def test_contacts_are_points_with_all_fields(tmp_path):
    recording, _ = made()
    kept = list(paraview.replay(recording, **OPTIONS))
    paraview.write_series(tmp_path / "run.pvd", recording, kept)
    assert sum(map(len, kept)) > 100
    for frame, contacts in enumerate(kept):
        if not len(contacts):
            continue
        mesh = meshio.read(tmp_path / "run" / f"contacts_{frame:06d}.vtu")
        middle = (contacts.point_a + contacts.point_b) / 2
        np.testing.assert_array_equal(mesh.points, middle)
        for name in ("normal", "depth", "distance", "found", "vertex", "triangle", "point_a"):
            np.testing.assert_array_equal(mesh.point_data[name], getattr(contacts, name), name)
        np.testing.assert_array_equal(mesh.point_data["body_b"], contacts.b & 0xFFFFFFFF)
    rows = [entry.attrib for entry in ElementTree.parse(tmp_path / "run.pvd").iter("DataSet")]
    assert len(rows) == 2 * len(kept)
    assert [float(row["timestep"]) for row in rows[::2]] == [0.125 * k for k in range(len(kept))]
    assert all((tmp_path / row["file"]).is_file() for row in rows)
    names = (tmp_path / "run" / "bodies.csv").read_text()
    assert names == 'body,name\n0,ground\n1,"torus, rigid"\n2,soft\n'


def test_frames_without_contacts_have_files(tmp_path):
    far = np.float32([[9, 0, 0, 0, 0, 0, 1]])
    near = np.float32([[0, 0, 0, 0, 0, 0, 1]])
    recording = pierce.Recording(
        0.1, [("box", box())], [("a", 0, "fixed", near), ("b", 0, "rigid", np.repeat(far, 2, 0))]
    )
    paraview.write_series(tmp_path / "run.pvd", recording, paraview.replay(recording, **OPTIONS))
    text = (tmp_path / "run" / "contacts_000001.vtu").read_text()
    assert 'NumberOfPoints="0"' in text and 'Name="normal"' in text


def test_bodies_without_a_place_are_left_out(tmp_path):
    poses = np.float32([[0, 0, 0, 0, 0, 0, 1], [np.nan, 0, 0, 0, 0, 0, 1]])
    recording = pierce.Recording(0.1, [("box", box())], [("a", 0, "rigid", poses)])
    paraview.write_series(tmp_path / "run.pvd", recording)
    text = (tmp_path / "run" / "bodies_000001.vtu").read_text()
    assert 'NumberOfCells="0"' in text


def test_a_series_comes_back(tmp_path):
    vertices, triangles = torus()
    soft = vertices + np.linspace(0, 1, 5, dtype=np.float32)[:, None, None]
    recording = pierce.Recording(
        0.5, [("torus", (vertices, triangles))], [("soft", 0, "deforming", soft)]
    )
    paraview.write_series(tmp_path / "run.pvd", recording)
    again = series.read_series(tmp_path / "run.pvd").recording()
    assert again.dt == 0.5
    np.testing.assert_array_equal(again.motion(0), soft)
    np.testing.assert_array_equal(again.mesh(0)[1], triangles)


def test_what_is_refused_before_anything_is_written(tmp_path):
    (tmp_path / "run.pvd").mkdir()
    for name, what in (("run.pvd", "is a folder"), ("run", r"ends in \.pvd")):
        with pytest.raises(pierce.InputError, match=what):
            paraview.write_series(tmp_path / name, made()[0])
    with pytest.raises(pierce.InputError, match="has no bodies"):
        paraview.write_series(tmp_path / "none.pvd", pierce.Recording(0.1, [], []))
    assert [path.name for path in tmp_path.rglob("*")] == ["run.pvd"]


def test_contacts_of_too_few_frames(tmp_path):
    recording, _ = made(frames=4)
    kept = list(paraview.replay(recording, **OPTIONS))[:3]
    for contacts in (kept, iter(kept)):
        with pytest.raises(pierce.InputError, match="of 3 frames only, and the recording has 4"):
            paraview.write_series(tmp_path / "run.pvd", recording, contacts)
    with pytest.raises(pierce.InputError, match="of 3 frames only"):
        paraview.write_series(tmp_path / "other.pvd", recording, kept)
    assert not list(tmp_path.glob("other*/*.vtu"))


def test_missing_packages_are_named(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "meshio", None)
    with pytest.raises(ImportError, match="pip install meshio"):
        paraview.write_series(tmp_path / "run.pvd", made()[0])
