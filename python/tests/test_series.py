"""pierce.series: positions are those of the files, frame by frame."""

import json
import math

import numpy as np
import pierce
import pytest
from conftest import box, torus
from pierce import series
from test_files import grid, write_glb, write_text

FRAMES = 12


def sway(vertices, seed=0):
    """Positions of all frames, float32 (frames, n, 3)."""
    moves = np.random.default_rng(seed).normal(size=(FRAMES, *vertices.shape)) / 50
    return (vertices + moves.cumsum(0)).astype(np.float32)


def write_frames(folder, kind, positions, triangles, meshio):
    """Names of the files, in the order of frames; numbers have no leading zeros."""
    names = [f"frame_{frame}.{kind}" for frame in range(len(positions))]
    for name, points in zip(names, positions):
        if kind == "obj":
            write_text(folder / name, points, triangles)
        elif kind == "glb":
            write_glb(folder / name, [(points, triangles)], [(0, np.eye(4), [])])
        else:
            meshio.write(folder / name, meshio.Mesh(points, [("triangle", triangles.astype(int))]))
    return names


def check(read, positions, triangles):
    assert len(read) == len(positions)
    np.testing.assert_array_equal(read.triangles, triangles)
    np.testing.assert_array_equal([points for _, points in read], positions)


@pytest.mark.parametrize("kind", ["vtu", "vtk", "obj", "glb"])
def test_numbered_files(kind, tmp_path):
    meshio = pytest.importorskip("meshio", reason="meshio is not installed")
    pytest.importorskip("trimesh", reason="trimesh is not installed")
    vertices, triangles = torus()
    positions = sway(vertices)
    names = write_frames(tmp_path, kind, positions, triangles, meshio)
    check(series.read_series(tmp_path / f"frame_*.{kind}"), positions, triangles)
    last = series.read_series([tmp_path / name for name in names[::-1]])
    check(last, positions[::-1], triangles)
    assert last.seconds.tolist() == list(range(FRAMES))


def test_decimal_numbers_are_sorted_as_such(tmp_path):
    vertices, triangles = torus()
    heights = {"d_0.5": 2, "d_0.25": 1, "d_0.125": 0, "d_10": 4, "d_9.75": 3}
    for name, height in heights.items():
        points = vertices + np.array([0, 0, height])
        lines = [f"v {x} {y} {z}" for x, y, z in points]
        lines += ["f " + " ".join(str(v + 1) for v in t) for t in triangles]
        (tmp_path / f"{name}.obj").write_text("\n".join(lines))
    read = series.read_series(tmp_path / "d_*.obj")
    lowest = [float(points[:, 2].min()) for _, points in read]
    assert np.diff(lowest).tolist() == pytest.approx([1, 1, 1, 1])


def test_names_of_alike_numbers_are_sorted(tmp_path, monkeypatch):
    vertices, triangles = torus()
    names = ["calm", "wave", "storm_1", "breeze_1", "air_2", "zephyr"]
    for name in names:
        write_text(tmp_path / f"{name}.obj", vertices, triangles)
    expected = ["calm", "wave", "zephyr", "breeze_1", "storm_1", "air_2"]
    for order in (names, names[::-1]):
        found = [tmp_path / f"{name}.obj" for name in order]
        monkeypatch.setattr(type(tmp_path), "glob", lambda _, __, found=found: iter(found))
        assert [path.stem for path in series._matching(tmp_path / "*.obj")] == expected


@pytest.mark.parametrize("kind", ["pvd", "vtu.series"])
def test_lists_of_paraview(kind, tmp_path):
    meshio = pytest.importorskip("meshio", reason="meshio is not installed")
    vertices, triangles = torus()
    positions = sway(vertices)
    names = write_frames(tmp_path, "vtu", positions, triangles, meshio)
    seconds = [0.25 * frame for frame in range(FRAMES)]
    path = tmp_path / f"run.{kind}"
    if kind == "pvd":
        rows = [f'<DataSet timestep="{s}" file="{name}"/>' for s, name in zip(seconds, names)]
        path.write_text(
            f'<VTKFile type="Collection"><Collection>{"".join(rows)}</Collection></VTKFile>'
        )
    else:
        listed = [{"name": name, "time": s} for s, name in zip(seconds, names)]
        path.write_text(json.dumps({"file-series-version": "1.0", "files": listed}))
    read = series.read_series(path)
    check(read, positions, triangles)
    assert read.seconds.tolist() == seconds
    recording = read.recording(name="cloth")
    assert recording.dt == 0.25 and recording.body_names == ["cloth"]
    np.testing.assert_array_equal(recording.motion(0), positions)
    recording.write(str(tmp_path / "recording"))
    again = pierce.Recording.read(str(tmp_path / "recording"))
    np.testing.assert_array_equal(again.motion(0), positions)
    np.testing.assert_array_equal(again.mesh(0)[1], triangles)


@pytest.mark.parametrize("kind", ["pc2", "mdd"])
def test_caches_of_points(kind, tmp_path):
    vertices, triangles = torus()
    positions = sway(vertices)
    count = len(vertices)
    write_text(tmp_path / "cloth.obj", vertices, triangles)
    if kind == "pc2":
        head = b"POINTCACHE2\0" + np.array([1, count], "<i4").tobytes()
        head += np.array([0, 1], "<f4").tobytes() + np.array([FRAMES], "<i4").tobytes()
        data = head + positions.astype("<f4").tobytes()
    else:
        head = np.array([FRAMES, count], ">i4").tobytes()
        data = head + (np.arange(FRAMES) / 24).astype(">f4").tobytes()
        data += positions.astype(">f4").tobytes()
    (tmp_path / f"cloth.{kind}").write_bytes(data)
    read = series.read_series(tmp_path / f"cloth.{kind}")
    check(read, positions, triangles)
    assert read.recording().dt == pytest.approx(1 if kind == "pc2" else 1 / 24)
    (tmp_path / f"cloth.{kind}").write_bytes(data[:-5])
    with pytest.raises(pierce.InputError, match=f"cloth.{kind}"):
        series.read_series(tmp_path / f"cloth.{kind}")
    write_text(tmp_path / "cloth.obj", *box())
    (tmp_path / f"cloth.{kind}").write_bytes(data)
    with pytest.raises(pierce.InputError, match=r"has 300 points, and .* has 8 vertices"):
        series.read_series(tmp_path / f"cloth.{kind}")


@pytest.mark.parametrize("kind", ["pc2", "mdd"])
@pytest.mark.parametrize("frames,count", [(-1, 8), (0, 8), (2, 0), (2, -1), (-1, -1)])
def test_caches_of_no_frames_or_points(kind, frames, count, tmp_path):
    write_text(tmp_path / "box.obj", *box())
    points = np.zeros((2, 8, 3))
    if kind == "pc2":
        data = b"POINTCACHE2\0" + np.array([1, count], "<i4").tobytes()
        data += np.array([0, 1], "<f4").tobytes() + np.array([frames], "<i4").tobytes()
        data += points.astype("<f4").tobytes()
    else:
        data = np.array([frames, count], ">i4").tobytes() + np.zeros(2, ">f4").tobytes()
        data += points.astype(">f4").tobytes()
    (tmp_path / f"box.{kind}").write_bytes(data)
    with pytest.raises(pierce.InputError, match=f"box.{kind}'.* {frames} frames of {count} points"):
        series.read_series(tmp_path / f"box.{kind}")


def test_volumes_move_by_their_surface(tmp_path):
    meshio = pytest.importorskip("meshio", reason="meshio is not installed")
    points, cells = grid(3)
    positions = sway(points)
    for frame, each in enumerate(positions):
        meshio.write(tmp_path / f"v{frame}.vtu", meshio.Mesh(each, [("hexahedron", cells)]))
    read = series.read_series(tmp_path / "v*.vtu")
    outside = ((points == 0) | (points == 3)).any(1)
    check(read, positions[:, outside], read.triangles)
    assert pierce.check_mesh(read.mesh).closed


def test_welding_is_that_of_the_first_frame(tmp_path):
    pytest.importorskip("trimesh", reason="trimesh is not installed")
    vertices, triangles = torus()
    positions = sway(vertices)
    for frame, points in enumerate(positions):
        loose = points[triangles].reshape(-1, 3)
        corners = np.arange(len(loose), dtype=np.uint32).reshape(-1, 3)
        write_text(tmp_path / f"f{frame}.obj", loose, corners)
    read = series.read_series(tmp_path / "f*.obj", weld=True)
    assert len(read.mesh[0]) == len(vertices) and pierce.check_mesh(read.mesh).closed
    for (_, points), expected in zip(read, positions):
        np.testing.assert_array_equal(points[read.triangles], expected[triangles])


def test_what_is_refused(tmp_path):
    write_text(tmp_path / "a0.obj", *torus())
    write_text(tmp_path / "a1.obj", *box())
    with pytest.raises(pierce.InputError, match=r"a1\.obj' has other triangles than .*a0\.obj"):
        list(series.read_series(tmp_path / "a*.obj"))
    with pytest.raises(pierce.InputError, match="no file matches"):
        series.read_series(tmp_path / "b*.obj")
    with pytest.raises(pierce.InputError, match="a series needs a file"):
        series.read_series([])
    with pytest.raises(ValueError, match="not at equal steps of time"):
        series.read_series([tmp_path / "a0.obj"]).recording()
    twice = '<DataSet timestep="0" file="a0.obj"/>' * 2
    (tmp_path / "two.pvd").write_text(f"<VTKFile><Collection>{twice}</Collection></VTKFile>")
    with pytest.raises(pierce.InputError, match="several files for a time"):
        series.read_series(tmp_path / "two.pvd")
    (tmp_path / "bad.pvd").write_text("nothing")
    with pytest.raises(pierce.InputError, match=r"bad\.pvd"):
        series.read_series(tmp_path / "bad.pvd")
    for name in (5, None, ["a0.obj"]):
        listed = {"files": [{"name": name, "time": 0}]}
        (tmp_path / "bad.series").write_text(json.dumps(listed))
        with pytest.raises(pierce.InputError, match=r"bad\.series.* name is no text"):
            series.read_series(tmp_path / "bad.series")
    listed = {"files": [{"name": "a0.obj", "time": math.nan}]}
    (tmp_path / "bad.series").write_text(json.dumps(listed))
    with pytest.raises(pierce.InputError, match=r"bad\.series.*not finite"):
        series.read_series(tmp_path / "bad.series")
    (tmp_path / "alone.pc2").write_bytes(b"")
    with pytest.raises(pierce.InputError, match="there is no mesh"):
        series.read_series(tmp_path / "alone.pc2")
