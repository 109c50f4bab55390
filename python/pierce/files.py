"""Meshes from files that people have, with the triangles that the file has.

    for part in pierce.files.read_parts("assembly.glb", weld=True):
        mesh = world.add_mesh(part.mesh, part.name)
        world.add_rigid_body(mesh, part.pose)

Triangles keep their number and their order, degenerate ones too.
Polygons are cut into fans.
Nothing is merged, unless `weld` asks for it.
"""

from __future__ import annotations

import json
import re
import warnings
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ._cells import read_cells, triangles_of
from ._core import InputError, read_mesh
from ._needs import need
from ._obj import ObjFile
from ._poses import poses_of, split

Floats = NDArray[np.float64]
Vertices = NDArray[np.float32]
Triangles = NDArray[np.uint32]

_AT_ORIGIN = np.array([0.0, 0, 0, 0, 0, 0, 1])
_OWN = (".obj", ".ply", ".off")
_OF_SCENES = (".glb", ".gltf", ".dae", ".3mf")


@dataclass(frozen=True, eq=False)
class Part:
    """One mesh of a file, and where it is.

    name: as in the file, or the file's own.
    vertices: float32 (n, 3), in the part's frame.
    triangles: uint32 (m, 3).
    pose: of the part's frame, float64 (7,): position and quaternion x y z w.
    """

    name: str
    vertices: Vertices
    triangles: Triangles
    pose: Floats

    @property
    def mesh(self) -> tuple[Vertices, Triangles]:
        """What `World.add_mesh()` takes."""
        return self.vertices, self.triangles


def read_parts(path: str | Path, groups: bool = False, weld: bool = False) -> list[Part]:
    """Reads the meshes of a file.

    groups: each object or group of an OBJ file, and each solid of an STL file in text, becomes a
        part; otherwise all of them are one.
    weld: vertices at the same position become one; see `weld()`.

    OBJ, PLY and OFF need no package.
    STL, glTF, GLB, Collada and 3MF need trimesh, and what trimesh needs for the last two.
    All but STL have a part for each mesh of each node.
    All else, such as VTK, VTU and Gmsh, needs meshio.
    Volume meshes are read as the faces around them.

    Raises InputError for a file that cannot be read or holds no triangles.
    """
    path = Path(path)
    if not path.is_file():
        raise InputError(f"cannot open '{path}'")
    kind = path.suffix.lower()
    try:
        if kind == ".obj" and groups:
            parts = _read_groups(path)
        elif kind in _OWN:
            parts = [Part(path.stem, *read_mesh(str(path)), _AT_ORIGIN)]
        elif kind == ".stl":
            parts = _read_stl(path, groups)
        elif kind in _OF_SCENES:
            parts = _read_scene(path)
        else:
            parts = [_read_cells(path)]
    except (ImportError, InputError):
        raise
    except Exception as error:  # each library has its own
        why = str(error) or type(error).__name__
        raise InputError(f"cannot read '{path}': {why}") from error
    if not any(len(part.triangles) for part in parts):
        raise InputError(f"'{path}' holds no triangles")
    for part in parts:
        if len(part.triangles) and int(part.triangles.max()) >= len(part.vertices):
            raise InputError(f"cannot read '{path}': a triangle names a vertex that is not there")
    return [_welded(part) for part in parts] if weld else parts


def weld(vertices: NDArray[Any], triangles: NDArray[Any]) -> tuple[NDArray[Any], NDArray[Any]]:
    """Joins vertices at exactly the same position: (vertices, triangles).

    A vertex is where its first one was.
    Triangles keep their number, order and corners.
    An STL file has three vertices for each triangle, and glTF has several where the shading has
    a seam, so their triangles are connected by welding only.
    """
    kept, joined = weld_places(vertices)
    return vertices[kept], joined[triangles].astype(triangles.dtype)


def weld_places(vertices: NDArray[Any]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Which vertices `weld()` keeps, and for each vertex the place of its own among them."""
    # Zeros of both signs are one position.
    _, first, place = np.unique(vertices + 0.0, axis=0, return_index=True, return_inverse=True)
    order = np.argsort(first)
    rank = np.empty_like(order)
    rank[order] = np.arange(len(order))
    return first[order], rank[place.ravel()]


def _welded(part: Part) -> Part:
    return Part(part.name, *weld(*part.mesh), part.pose)


def placed(
    vertices: NDArray[Any], triangles: NDArray[Any], stretch: Floats | None
) -> tuple[Vertices, Triangles]:
    """A stretched mesh; a mirrored one has its triangles turned, so that outside stays outside."""
    corners = np.ascontiguousarray(triangles, np.uint32)
    if stretch is None:
        return np.ascontiguousarray(vertices, np.float32), corners
    if np.linalg.det(stretch) < 0:
        corners = np.ascontiguousarray(corners[:, [0, 2, 1]])
    return (np.asarray(vertices, np.float64) @ stretch.T).astype(np.float32), corners


def _read_groups(path: Path) -> list[Part]:
    file = ObjFile(path)
    return [
        Part(name, *_used(file.vertices, file.triangles[file.group == place]), _AT_ORIGIN)
        for place, name in enumerate(file.names)
    ]


def _used(vertices: Vertices, triangles: Triangles) -> tuple[Vertices, Triangles]:
    """Without the vertices that no triangle has; the others keep their order."""
    used, place = np.unique(triangles, return_inverse=True)
    return vertices[used], place.reshape(-1, 3).astype(np.uint32)


def _read_stl(path: Path, groups: bool) -> list[Part]:
    need("trimesh", "trimesh", "reading STL")
    # The reader alone: some versions of trimesh join vertices of STL whatever they are told.
    reader = import_module("trimesh.exchange.stl")
    with open(path, "rb") as file:
        read = reader.load_stl(file)
    solids = read.get("geometry", {path.stem: read})
    parts = [
        Part(name, *placed(solid["vertices"], solid["faces"], None), _AT_ORIGIN)
        for name, solid in solids.items()
    ]
    if len(parts) == 1:
        return [Part(path.stem, *parts[0].mesh, _AT_ORIGIN)]
    if groups or not parts:
        return parts
    starts = np.cumsum([0, *(len(part.vertices) for part in parts)])
    triangles = [part.triangles + np.uint32(start) for part, start in zip(parts, starts)]
    vertices = np.concatenate([part.vertices for part in parts])
    return [Part(path.stem, vertices, np.concatenate(triangles), _AT_ORIGIN)]


_TRIANGLE_FAN = 6
_QUANTIZATION = "KHR_mesh_quantization"
_OF_LOOKS = ("materials", "texture", "lights")
"""Words of extensions of glTF that say nothing about triangles, as in `KHR_materials_unlit`."""


def _refuse_what_is_misread(path: Path) -> None:
    """Raises InputError for glTF of which trimesh makes something else."""
    content = path.read_bytes()
    if content[:4] == b"glTF":  # twelve bytes, and the length and the kind of the first chunk
        content = content[20 : 20 + int.from_bytes(content[12:16], "little")]
    described = json.loads(content)
    unknown = [
        name
        for name in described.get("extensionsRequired", [])
        if name != _QUANTIZATION and not any(f"_{word}_" in f"{name}_" for word in _OF_LOOKS)
    ]
    if unknown:
        raise InputError(
            f"cannot read '{path}': it requires {', '.join(sorted(unknown))}, which is not "
            "supported; write it without"
        )
    modes = [
        primitive.get("mode")
        for mesh in described.get("meshes", [])
        for primitive in mesh.get("primitives", [])
    ]
    for is_there, what in (
        (_QUANTIZATION in described.get("extensionsUsed", []), "quantized positions"),
        (any("sparse" in each for each in described.get("accessors", [])), "sparse accessors"),
        (_TRIANGLE_FAN in modes, "triangle fans"),
    ):
        if is_there:
            raise InputError(f"cannot read '{path}': it has {what}, which trimesh misreads")


def _node_of_primitive(scene: Any, node: str, geometry: Any) -> str:
    """The node of a mesh: trimesh makes a child of it for each primitive of a glTF mesh."""
    parent = str(scene.graph.transforms.parents.get(node))
    is_one_of_many = geometry.metadata.get("from_gltf_primitive", False)
    is_named_so = re.fullmatch(re.escape(parent) + "_[0-9a-f]{6}", node) is not None
    stays = np.array_equal(scene.graph.get(node, parent)[0], np.eye(4))
    return parent if is_one_of_many and is_named_so and stays else node


def _joined(geometries: list[Any]) -> tuple[NDArray[Any], NDArray[Any]]:
    counts = [len(geometry.vertices) for geometry in geometries]
    begins = np.concatenate([[0], np.cumsum(counts)[:-1]]).astype(np.int64)
    return (
        np.concatenate([geometry.vertices for geometry in geometries]),
        np.concatenate([g.faces + begin for g, begin in zip(geometries, begins)]),
    )


def _read_scene(path: Path) -> list[Part]:
    trimesh = need("trimesh", "trimesh", f"reading {path.suffix}")
    if path.suffix.lower() in (".gltf", ".glb"):
        _refuse_what_is_misread(path)
    scene = trimesh.load_scene(str(path), process=False)
    meshes: dict[str, tuple[Any, list[Any]]] = {}
    left_out = []
    for node in scene.graph.nodes_geometry:
        matrix, name = scene.graph[node]
        geometry = scene.geometry[name]
        if not isinstance(geometry, trimesh.Trimesh):
            left_out.append(node)
            continue
        whole = _node_of_primitive(scene, str(node), geometry)
        meshes.setdefault(whole, (matrix, []))[1].append(geometry)
    parts = []
    for node, (matrix, primitives) in meshes.items():
        rigid, stretch = split(np.asarray(matrix, np.float64))
        vertices, faces = _joined(primitives)
        parts.append(Part(node, *placed(vertices, faces, stretch), poses_of(rigid[None])[0]))
    if left_out:
        warnings.warn(f"'{path}': left out, as they have no triangles: {left_out}", stacklevel=3)
    return parts


def _read_cells(path: Path) -> Part:
    mesh = read_cells(path)
    corners, of_volume = triangles_of(mesh.cells)
    vertices, triangles = placed(mesh.points, corners, None)
    if of_volume:
        vertices, triangles = _used(vertices, triangles)
    return Part(path.stem, vertices, triangles, _AT_ORIGIN)
