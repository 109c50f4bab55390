"""Meshes of trimesh in their places, and what Pierce has made of them."""

from __future__ import annotations

import weakref
from collections.abc import Hashable
from typing import Any, ClassVar

import numpy as np
import trimesh
from numpy.typing import ArrayLike, NDArray

from . import _core
from ._poses import is_rigid, split
from ._surfaces import Floats

_FURTHEST = 2.0**60
"""[length] Worlds leave out bodies that are further away."""


class Shape:
    """What Pierce has made of one mesh, which managers share."""

    _known: ClassVar[dict[int, tuple[weakref.ref[trimesh.Trimesh], int, Shape]]] = {}

    @classmethod
    def of(cls, mesh: trimesh.Trimesh) -> Shape:
        """The shape of a mesh, made anew only if the mesh has been changed."""
        known = cls._known.get(id(mesh))
        if known and known[0]() is mesh and known[1] == hash(mesh):
            return known[2]
        shape = cls(mesh)
        key = id(mesh)
        ref = weakref.ref(mesh, lambda _: cls._known.pop(key, None))
        cls._known[key] = ref, hash(mesh), shape
        return shape

    def __init__(self, mesh: trimesh.Trimesh) -> None:
        # Vertices without faces are no part of a body.
        used, corners = np.unique(mesh.faces, return_inverse=True)
        self.vertices: Floats = np.array(mesh.vertices, dtype=np.float64)[used]
        self.faces = corners.reshape(-1, 3)
        self._data = self.vertices.astype(np.float32), self.faces.astype(np.uint32)
        self.solid = _core.Mesh.make(self._data)
        if self.solid.inside.exists and self.solid.traits.volume < 0:
            self.solid = _core.Mesh.make(self._data, inside="winding")
        self._sheet: _core.Mesh | None = None
        if len(used) < len(mesh.vertices):
            mesh = trimesh.Trimesh(self.vertices, self.faces, process=False)
        self._is_convex = bool(mesh.is_convex)
        # Vertices at the same place are one in a solid.
        self._place = np.unique(self._data[0], axis=0, return_inverse=True)[1].ravel()
        sides = self.faces[:, [0, 1, 2, 0, 1, 2]], self.faces[:, [0, 1, 2, 1, 2, 0]]
        keys = self._keys(*sides).ravel()
        order = np.argsort(keys, kind="stable")
        self._edge_keys, self._edge_faces = keys[order], order // 6

    @property
    def is_solid(self) -> bool:
        return self.solid.inside.exists

    @property
    def is_convex(self) -> bool:
        """True for solids that trimesh calls convex."""
        return self._is_convex and self.is_solid

    @property
    def sheet(self) -> _core.Mesh:
        """The surface alone."""
        if self._sheet is None:
            self._sheet = _core.Mesh.make(self._data, inside="none")
        return self._sheet

    def face_at(self, vertex: int, edge_end: int) -> int:
        """A face that has the vertex or, if it has an end, the edge; -1 if that closes a hole."""
        end = vertex if edge_end == _core.no_vertex else edge_end
        key = self._keys(np.array(vertex), np.array(end))
        place = int(np.searchsorted(self._edge_keys, key))
        found = place < len(self._edge_keys) and self._edge_keys[place] == key
        return int(self._edge_faces[place]) if found else -1

    def _keys(self, v: NDArray[Any], w: NDArray[Any]) -> NDArray[np.int64]:
        v, w = self._place[v], self._place[w]
        keys: NDArray[np.int64] = np.minimum(v, w) * len(self.vertices) + np.maximum(v, w)
        return keys


class Object:
    """A mesh in a place."""

    def __init__(self, name: Hashable, mesh: trimesh.Trimesh, transform: ArrayLike | None) -> None:
        self.name = name
        self.shape = Shape.of(mesh)
        self.transform = rigid_transform(np.eye(4) if transform is None else transform)

    def points(self) -> Floats:
        """World positions of the vertices, (n, 3)."""
        return self.shape.vertices @ self.transform[:3, :3].T + self.transform[:3, 3]

    def triangles(self) -> Floats:
        """World positions of the corners of all faces, (m, 3, 3)."""
        return self.points()[self.shape.faces]


def rigid_transform(transform: ArrayLike) -> Floats:
    """A transform as (4, 4), without what rounding has stretched.

    Raises ValueError if it is not rigid to rounding.
    """
    matrix = np.array(transform, dtype=np.float64)
    if matrix.shape != (4, 4):
        raise ValueError("transform must be (4,4)!")
    if not np.abs(matrix).max() <= _FURTHEST:
        raise ValueError("transform must be finite and not too far away")
    if not is_rigid(matrix):
        raise ValueError("transform must be rigid: use mesh.apply_transform() for other ones")
    rigid, _ = split(matrix)
    return rigid
