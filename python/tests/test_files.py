"""pierce.files: triangles are those of the file, in its order, by parsers written here."""

import base64
import json
import struct
import sys
from contextlib import nullcontext

import numpy as np
import pierce
import pytest
from conftest import box, torus
from pierce import files
from pierce._poses import matrix_of


def soup(random, vertices=40, triangles=90):
    """Random triangles, some without three different vertices, some doubled, and no order."""
    points = random.normal(size=(vertices, 3)).astype(np.float32)
    points[random.integers(vertices, size=6)] = points[0]
    points[1] = -0.0
    corners = random.integers(vertices, size=(triangles, 3)).astype(np.uint32)
    corners[5] = corners[4]
    corners[7] = 3
    return points, corners


def corners_of(part):
    return part.vertices[part.triangles]


def write_stl(path, vertices, triangles):
    rows = np.zeros(len(triangles), [("n", "<f4", 3), ("v", "<f4", (3, 3)), ("a", "<u2")])
    rows["v"] = vertices[triangles]
    path.write_bytes(b"solid of nothing".ljust(80) + struct.pack("<I", len(rows)) + rows.tobytes())


def write_stl_text(path, solids):
    lines = []
    for name, (vertices, triangles) in solids.items():
        lines.append(f"solid {name}")
        for triangle in vertices[triangles]:
            lines += ["facet normal 0 0 0", "outer loop"]
            lines += [f"vertex {x!r} {y!r} {z!r}" for x, y, z in triangle.tolist()]
            lines += ["endloop", "endfacet"]
        lines.append(f"endsolid {name}")
    path.write_text("\n".join(lines))


def write_ply(path, vertices, triangles):
    header = (
        f"ply\nformat binary_little_endian 1.0\nelement vertex {len(vertices)}\n"
        "property float x\nproperty float y\nproperty float z\n"
        f"element face {len(triangles)}\nproperty list uchar int vertex_indices\nend_header\n"
    )
    faces = np.zeros(len(triangles), [("n", "u1"), ("v", "<i4", 3)])
    faces["n"], faces["v"] = 3, triangles
    path.write_bytes(header.encode() + vertices.astype("<f4").tobytes() + faces.tobytes())


def write_text(path, vertices, triangles):
    """OBJ or OFF, by the name."""
    points = [f"{x!r} {y!r} {z!r}" for x, y, z in vertices.tolist()]
    if path.suffix == ".off":
        lines = ["OFF", f"{len(points)} {len(triangles)} 0", *points]
        lines += [f"3 {a} {b} {c}" for a, b, c in triangles.tolist()]
    else:
        lines = [f"v {point}" for point in points]
        lines += [f"f {a} {b} {c}" for a, b, c in (triangles + np.uint32(1)).tolist()]
    path.write_text("\n".join(lines) + "\n")


def write_glb(path, meshes, nodes):
    """Meshes (vertices, triangles), and nodes (mesh, matrix, children)."""
    blob, views, accessors, described = b"", [], [], []
    for vertices, triangles in meshes:
        ends = {"min": vertices.min(0).tolist(), "max": vertices.max(0).tolist()}
        for data, kind, shape, more in (
            (vertices, 5126, "VEC3", ends),
            (triangles.ravel(), 5125, "SCALAR", {}),
        ):
            view = {"buffer": 0, "byteOffset": len(blob), "byteLength": data.nbytes}
            views.append(view)
            described.append(
                {"bufferView": len(views) - 1, "componentType": kind, "type": shape}
                | {"count": len(data)}
                | more
            )
            blob += data.tobytes()
    accessors = described
    document = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [
            {"mesh": mesh, "matrix": matrix.T.ravel().tolist()}
            | ({"children": children} if children else {})
            for mesh, matrix, children in nodes
        ],
        "meshes": [
            {"primitives": [{"attributes": {"POSITION": 2 * i}, "indices": 2 * i + 1}]}
            for i in range(len(meshes))
        ],
        "buffers": [{"byteLength": len(blob)}],
        "bufferViews": views,
        "accessors": accessors,
    }
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    chunks = struct.pack("<I4s", len(text), b"JSON") + text
    chunks += struct.pack("<I4s", len(blob), b"BIN\0") + blob
    path.write_bytes(b"glTF" + struct.pack("<II", 2, 12 + len(chunks)) + chunks)


@pytest.mark.parametrize("kind", ["obj", "off", "ply", "stl", "text.stl"])
@pytest.mark.parametrize("seed", range(4))
def test_triangles_are_those_of_the_file(kind, seed, tmp_path):
    vertices, triangles = soup(np.random.default_rng(seed))
    path = tmp_path / f"soup.{kind}"
    if kind == "stl":
        write_stl(path, vertices, triangles)
    elif kind == "text.stl":
        write_stl_text(path, {"a": (vertices, triangles)})
    else:
        {"ply": write_ply}.get(kind, write_text)(path, vertices, triangles)
    (part,) = files.read_parts(path)
    np.testing.assert_array_equal(corners_of(part), vertices[triangles])
    if "stl" in kind:
        assert len(part.vertices) == 3 * len(triangles)
    else:
        np.testing.assert_array_equal(part.triangles, triangles)
        np.testing.assert_array_equal(part.vertices, vertices)
    (welded,) = files.read_parts(path, weld=True)
    np.testing.assert_array_equal(corners_of(welded), vertices[triangles])
    distinct = {tuple(point) for point in (welded.vertices + 0).tolist()}
    assert len(distinct) == len(welded.vertices)


@pytest.mark.parametrize("seed", range(4))
def test_nodes_of_gltf(seed, tmp_path):
    random = np.random.default_rng(seed)
    meshes = [soup(random), soup(random, 30, 50)]
    matrices = []
    for scale in (1, 1, 2.5, -1):
        turn = np.linalg.qr(random.normal(size=(3, 3)))[0]
        matrix = np.eye(4)
        matrix[:3, :3] = turn * np.sign(np.linalg.det(turn)) * scale
        matrix[:3, 3] = random.normal(size=3)
        matrices.append(matrix)
    root, child, large, mirrored = matrices
    nodes = [(0, root, [1, 2, 3]), (1, child, []), (1, large, []), (0, mirrored, [])]
    write_glb(tmp_path / "scene.glb", meshes, nodes)
    parts = files.read_parts(tmp_path / "scene.glb")
    expected = {0: (0, root), 1: (1, root @ child), 2: (1, root @ large), 3: (0, root @ mirrored)}
    assert len(parts) == 4
    for place, (mesh, matrix) in expected.items():
        vertices, triangles = meshes[mesh]
        world = (vertices @ matrix[:3, :3].T + matrix[:3, 3])[triangles]
        if place == 3:
            world = world[:, [0, 2, 1]]
        found = [part for part in parts if is_at(part, world)]
        assert len(found) == 1
        if place < 2:
            np.testing.assert_array_equal(found[0].vertices, vertices)
            np.testing.assert_array_equal(found[0].triangles, triangles)


def is_at(part, world):
    if len(part.triangles) != len(world):
        return False
    matrix = matrix_of(part.pose)
    now = corners_of(part) @ matrix[:3, :3].T + matrix[:3, 3]
    return np.abs(now - world).max() < 1e-5


@pytest.mark.parametrize("extra", [[], [1], [0]], ids=["triangles", "lines", "points"])
@pytest.mark.parametrize("materials", [0, 1, 2])
@pytest.mark.parametrize("twice", [False, True])
def test_primitives_of_gltf(twice, materials, extra, tmp_path):
    """A mesh of two primitives, with a material each or without, is one part, of one name."""
    points, triangles = box()
    halves = np.split(np.asarray(triangles, "<u4"), 2)
    blobs = [np.asarray(points, "<f4").tobytes(), *(half.tobytes() for half in halves)]
    starts = np.cumsum([0, *(len(blob) for blob in blobs)]).tolist()
    data = base64.b64encode(b"".join(blobs)).decode()
    corners = [{"componentType": 5125, "count": half.size, "type": "SCALAR"} for half in halves]
    lower, upper = np.min(points, 0).tolist(), np.max(points, 0).tolist()
    place = {"componentType": 5126, "count": 8, "type": "VEC3", "min": lower, "max": upper}
    primitives = [{"attributes": {"POSITION": 0}, "indices": k + 1} for k in range(2)]
    for k in range(materials):
        primitives[k]["material"] = k
    primitives[:0] = [{"attributes": {"POSITION": 0}, "indices": 1, "mode": m} for m in extra]
    document = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0, 1] if twice else [0]}],
        "nodes": [{"mesh": 0, "name": "cube"}, {"mesh": 0, "translation": [5, 0, 0]}],
        "meshes": [{"primitives": primitives}],
        "materials": [{}, {}],
        "buffers": [{"byteLength": starts[-1], "uri": f"data:;base64,{data}"}],
        "bufferViews": [
            {"buffer": 0, "byteOffset": start, "byteLength": len(blob)}
            for start, blob in zip(starts, blobs)
        ],
        "accessors": [{"bufferView": k, **each} for k, each in enumerate([place, *corners])],
    }
    (tmp_path / "cube.gltf").write_text(json.dumps(document))
    with pytest.warns(UserWarning, match="left out") if extra else nullcontext():
        parts = files.read_parts(tmp_path / "cube.gltf", weld=True)
    assert len(parts) == 1 + twice
    for part in parts:
        assert pierce.Mesh.make(part.mesh).traits.closed
        assert len(part.triangles) == 12
    assert [part.pose[0] for part in parts if part.name == "cube"] == [0]
    assert sorted(part.pose[0] for part in parts) == [0, 5][: 1 + twice]


def test_a_node_that_is_named_like_a_primitive_keeps_its_place(tmp_path):
    """trimesh leaves line loops out, so that the hand's mesh has one primitive."""
    points = np.asarray([[0, 0, 0], [1, 0, 0], [0, 1, 0]], "<f4")
    blobs = [points.tobytes(), np.arange(3, dtype="<u4").tobytes()]
    triangle = {"attributes": {"POSITION": 0}, "indices": 1}
    place = {"componentType": 5126, "count": 3, "type": "VEC3", "min": [0] * 3, "max": [1, 1, 0]}
    document = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [
            {"mesh": 0, "name": "arm", "children": [1]},
            {"mesh": 1, "name": "arm_hand", "translation": [5, 0, 0]},
        ],
        "meshes": [{"primitives": [triangle]}, {"primitives": [triangle, {**triangle, "mode": 2}]}],
        "buffers": [
            {
                "byteLength": sum(map(len, blobs)),
                "uri": "data:;base64," + base64.b64encode(b"".join(blobs)).decode(),
            }
        ],
        "bufferViews": [
            {"buffer": 0, "byteLength": 36},
            {"buffer": 0, "byteOffset": 36, "byteLength": 12},
        ],
        "accessors": [
            {**place, "bufferView": 0},
            {"bufferView": 1, "componentType": 5125, "count": 3, "type": "SCALAR"},
        ],
    }
    (tmp_path / "arm.gltf").write_text(json.dumps(document))
    parts = files.read_parts(tmp_path / "arm.gltf")
    assert [(part.name, part.pose[0]) for part in parts] == [("arm", 0), ("arm_hand", 5)]


def test_groups_of_an_obj_file(tmp_path):
    lines = ["v 0 0 0", "v 1 0 0", "v 1 1 0", "v 0 1 0", "v 0 0 1", "f 1 2 3 4"]
    lines += ["o arm", "f 1 2 5 # a face", "g left", "f 2/7 3/8 5/9", "o leg", "f -1 -2 -3"]
    lines += ["o arm", "f 3 4 5", "g left", "f 4//1 1//1 5//1", "g empty"]
    (tmp_path / "robot.obj").write_text("\n".join(lines))
    (whole,) = files.read_parts(tmp_path / "robot.obj")
    assert len(whole.triangles) == 7 and whole.name == "robot"
    parts = files.read_parts(tmp_path / "robot.obj", groups=True)
    assert [part.name for part in parts] == ["robot", "arm", "arm/left", "leg"]
    assert [len(part.vertices) for part in parts] == [4, 5, 5, 3]
    rows = [[0, 1], [2, 5], [3, 6], [4]]
    for part, own in zip(parts, rows):
        np.testing.assert_array_equal(corners_of(part), corners_of(whole)[own])


def test_solids_of_a_text_stl(tmp_path):
    solids = {"one": box(), "other": torus()}
    write_stl_text(tmp_path / "two.stl", solids)
    parts = files.read_parts(tmp_path / "two.stl", groups=True)
    assert [part.name for part in parts] == ["one", "other"]
    (whole,) = files.read_parts(tmp_path / "two.stl")
    both = np.concatenate([vertices[triangles] for vertices, triangles in solids.values()])
    np.testing.assert_array_equal(corners_of(whole), both)
    np.testing.assert_array_equal(np.concatenate([corners_of(part) for part in parts]), both)


def test_welding_closes_an_stl_solid(tmp_path):
    write_stl(tmp_path / "torus.stl", *torus())
    (loose,) = files.read_parts(tmp_path / "torus.stl")
    (welded,) = files.read_parts(tmp_path / "torus.stl", weld=True)
    assert pierce.check_mesh(welded.mesh).closed and not pierce.check_mesh(loose.mesh).closed
    assert len(welded.vertices) == len(torus()[0])


@pytest.mark.parametrize("kind", ["vtk", "vtu", "msh"])
def test_surfaces_by_meshio(kind, tmp_path):
    meshio = pytest.importorskip("meshio", reason="meshio is not installed")
    vertices, triangles = soup(np.random.default_rng(3))
    path = tmp_path / f"soup.{kind}"
    mesh = meshio.Mesh(vertices, [("triangle", triangles.astype(int))])
    meshio.write(path, mesh, "gmsh" if kind == "msh" else None)
    (part,) = files.read_parts(path)
    np.testing.assert_array_equal(part.triangles, triangles)
    np.testing.assert_array_equal(part.vertices, vertices)


def grid(size):
    """Cells of a cube: points (n, 3), hexahedra (m, 8)."""
    numbers = np.arange((size + 1) ** 3).reshape((size + 1,) * 3)
    points = np.argwhere(numbers >= 0).astype(float)
    corners = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)]
    corners += [(x, y, 1) for x, y, _ in corners]
    cells = [numbers[i : size + i, j : size + j, k : size + k].ravel() for i, j, k in corners]
    return points, np.stack(cells, 1)


@pytest.mark.parametrize("cells", ["hexahedron", "tetra"])
def test_volumes_are_read_as_their_surface(cells, tmp_path):
    meshio = pytest.importorskip("meshio", reason="meshio is not installed")
    points, hexahedra = grid(3)
    blocks = hexahedra
    if cells == "tetra":
        fans = [[0, 1, 2, 6], [0, 2, 3, 6], [0, 3, 7, 6], [0, 7, 4, 6], [0, 4, 5, 6], [0, 5, 1, 6]]
        blocks = hexahedra[:, fans].reshape(-1, 4)
    meshio.write(tmp_path / "cube.vtu", meshio.Mesh(points, [(cells, blocks)]))
    (part,) = files.read_parts(tmp_path / "cube.vtu")
    report = pierce.check_mesh(part.mesh)
    assert len(part.triangles) == 6 * 9 * 2 and len(part.vertices) == 4**3 - 2**3
    assert report.closed and report.traits.volume == pytest.approx(27)


def test_polygons_are_fans_in_their_order(tmp_path):
    meshio = pytest.importorskip("meshio", reason="meshio is not installed")
    points = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1.0]])
    cells = [("quad", [[0, 1, 2, 3], [3, 2, 1, 4]]), ("line", [[0, 1]]), ("triangle", [[0, 1, 4]])]
    meshio.write(tmp_path / "mixed.vtu", meshio.Mesh(points, cells))
    (part,) = files.read_parts(tmp_path / "mixed.vtu")
    expected = [[0, 1, 2], [0, 2, 3], [3, 2, 1], [3, 1, 4], [0, 1, 4]]
    np.testing.assert_array_equal(part.triangles, expected)


def test_what_trimesh_misreads(tmp_path):
    pytest.importorskip("trimesh", reason="trimesh is not installed")
    for name, described in {
        "quantized": {"extensionsUsed": ["KHR_mesh_quantization"]},
        "sparse": {"accessors": [{"sparse": {}}]},
        "fans": {"meshes": [{"primitives": [{"mode": 6}]}]},
    }.items():
        document = {"asset": {"version": "2.0"}} | described
        (tmp_path / f"{name}.gltf").write_text(json.dumps(document))
        with pytest.raises(pierce.InputError, match=f"{name}.*misreads"):
            files.read_parts(tmp_path / f"{name}.gltf")


@pytest.mark.parametrize("kind", ["gltf", "glb"])
def test_gltf_that_requires_what_is_unknown(kind, tmp_path):
    pytest.importorskip("trimesh", reason="trimesh is not installed")
    path = tmp_path / f"scene.{kind}"
    write_glb(tmp_path / "scene.glb", [box()], [(0, np.eye(4), [])])
    whole = (tmp_path / "scene.glb").read_bytes()
    length = struct.unpack("<I", whole[12:16])[0]
    document, rest = json.loads(whole[20 : 20 + length]), whole[20 + length :]

    def require(*names):
        described = document | {"extensionsUsed": names, "extensionsRequired": names}
        if kind == "gltf":
            data = base64.b64encode(rest[8:]).decode()
            described["buffers"] = [
                document["buffers"][0] | {"uri": f"data:application/octet-stream;base64,{data}"}
            ]
            path.write_text(json.dumps(described))
            return
        text = json.dumps(described).encode()
        text += b" " * (-len(text) % 4)
        chunks = struct.pack("<I4s", len(text), b"JSON") + text + rest
        path.write_bytes(b"glTF" + struct.pack("<II", 2, 12 + len(chunks)) + chunks)

    require("KHR_materials_unlit", "KHR_texture_transform", "KHR_lights_punctual")
    assert len(files.read_parts(path)[0].triangles) == 12
    for name in ("KHR_draco_mesh_compression", "EXT_meshopt_compression", "ACME_anything"):
        require("KHR_materials_unlit", name)
        with pytest.raises(pierce.InputError, match=f"scene.{kind}': it requires {name}, which"):
            files.read_parts(path)


def test_what_cannot_be_read(tmp_path, monkeypatch):
    with pytest.raises(pierce.InputError, match=r"cannot open '.*nothing\.stl'"):
        files.read_parts(tmp_path / "nothing.stl")
    for name in ("bad.stl", "bad.glb", "bad.obj", "bad.vtu", "bad.nothing"):
        (tmp_path / name).write_text("neither this nor that")
        with pytest.raises(pierce.InputError, match=name):
            files.read_parts(tmp_path / name)
    (tmp_path / "far.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n")
    for weld in (False, True):
        with pytest.raises(pierce.InputError, match=r"far\.obj.*not there"):
            files.read_parts(tmp_path / "far.obj", weld=weld)
    (tmp_path / "latin.obj").write_bytes(b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 \xe9\n")
    with pytest.raises(pierce.InputError, match=r"latin\.obj"):
        pierce.read_mesh(tmp_path / "latin.obj")
    meshio = pytest.importorskip("meshio", reason="meshio is not installed")
    curved = meshio.Mesh(np.eye(6, 3), [("triangle6", [[0, 1, 2, 3, 4, 5]])])
    meshio.write(tmp_path / "curved.vtu", curved)
    with pytest.raises(pierce.InputError, match=r"curved\.vtu.*triangle6"):
        files.read_parts(tmp_path / "curved.vtu")


@pytest.mark.parametrize(
    "name,package", [("a.stl", "trimesh"), ("a.glb", "trimesh"), ("a.vtu", "meshio")]
)
def test_missing_packages_are_named(name, package, tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, package, None)
    (tmp_path / name).write_text("")
    with pytest.raises(ImportError, match=f"pip install {package}"):
        files.read_parts(tmp_path / name)
