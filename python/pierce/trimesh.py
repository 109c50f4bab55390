"""Collisions and distances of trimesh meshes: trimesh's collision manager on Pierce.

`CollisionManager` has the methods, arguments and results of
`trimesh.collision.CollisionManager` and needs no FCL:

    import pierce.trimesh
    manager = pierce.trimesh.CollisionManager()
    manager.add_object("ball", trimesh.creation.icosphere())
    hit, names = manager.in_collision_single(other, transform, return_names=True)

What differs from FCL:

* A closed mesh is a solid, convex or not.
  Two solids are in collision if they have some volume in common, also if one lies within the
  other, or both are in the same place.
  Solids that only touch are not in collision; their distance is 0.
* A mesh with small holes is a solid, too: `pierce.check_mesh(mesh).inside` says what is done.
* A mesh without an inside, such as a sheet or a half of a ball, is its surface alone.
  It is in collision where its surface meets another surface, and not if it is within a solid as
  a whole.
  That takes a world of its own for each question, and distances of such meshes are computed with
  NumPy: both are slower than for solids.
* The distance of two solids that overlap is negative, whether they are convex or not: a
  translation of that length takes them apart.
  It is the shortest one in the common cases, and never less than that (`World.parting`).
  It is 0 if one of the two has no inside.
  Of several pairs that overlap, the one that has to move furthest counts.
* Two convex meshes have one contact, as with FCL: its depth is the shortest way on which they come
  apart (`World.parting`; of more than some 3,400 triangles each, a way that parts them), its normal
  the direction of that, and its point is half way between the two points that touch afterwards.
* Other pairs have all contacts of Pierce (`Contacts`): `depth` is that of a point, and `point` is
  half way between the two surfaces.
* `normal` points from the object of the manager to the other mesh or the other manager's object,
  within a manager from the object added first to the other one.
  `index()` is the face there, also of convex meshes.
* Transforms have to be rigid: a scale or a mirror is applied to the mesh, not to its place.

Lengths are in the unit of the meshes.
"""

from __future__ import annotations

import copy
import sys
import weakref
from collections.abc import Hashable, Iterable, Iterator
from contextlib import contextmanager
from types import SimpleNamespace
from typing import Any, ClassVar, NamedTuple

import numpy as np
import trimesh
from numpy.typing import ArrayLike, NDArray
from trimesh.collision import ContactData, DistanceData

from . import _core
from ._surfaces import Floats, box, box_gaps, closest_points, vertex_distance

__all__ = ["CollisionManager", "ContactData", "DistanceData", "scene_to_collision"]

EXTERNAL = "__external"
"""The name of a mesh that is not in the manager, as trimesh has it."""


class CollisionManager:
    """Meshes under names, and questions about which of them collide or how far they are apart.

    `backend` and `threads` are those of `pierce.World`.
    """

    def __init__(self, backend: str = "auto", threads: int = 0) -> None:
        self._options: dict[str, Any] = {"backend": backend, "threads": threads}
        self._solids = _Solids(self._options)
        self._objects: dict[Hashable, _Object] = {}

    def add_object(
        self, name: Hashable, mesh: trimesh.Trimesh, transform: ArrayLike | None = None
    ) -> object:
        """Adds a mesh, in place of the one that has had the name.

        `transform`: rigid, (4, 4), the identity by default.
        Returns what stands for the object, for comparisons only.
        """
        added = _Object(name, mesh, transform)
        if name in self._objects:
            self.remove_object(name)
        self._objects[name] = added
        self._solids.add(added)
        return added

    def remove_object(self, name: Hashable) -> None:
        """Removes an object. Raises ValueError if there is none of that name."""
        self._solids.remove(self._object(name))
        self._solids.forget_meshes()
        del self._objects[name]

    def set_transform(self, name: Hashable, transform: ArrayLike) -> None:
        """Moves an object: `transform` is rigid, (4, 4). Raises ValueError for unknown names."""
        moved = self._object(name)
        moved.transform = _rigid(transform)
        self._solids.move(moved)

    def in_collision_single(
        self,
        mesh: trimesh.Trimesh,
        transform: ArrayLike | None = None,
        return_names: bool = False,
        return_data: bool = False,
    ) -> Any:
        """Says whether a mesh that is not in the manager collides with any object.

        Returns a bool, and if asked for, the set of the objects' names and a list of ContactData,
        in which the mesh has the name "__external".
        """
        guests = [_Object(EXTERNAL, mesh, transform)]
        pairs, data = self._collide(self._own(), guests, return_data)
        names = {a.name for a, _ in pairs}
        return _select(bool(pairs), (return_names, names), (return_data, data))

    def in_collision_internal(self, return_names: bool = False, return_data: bool = False) -> Any:
        """Says whether any two objects collide.

        Returns a bool, and if asked for, the set of pairs of names, each in alphabetical order,
        and a list of ContactData.
        """
        pairs, data = self._collide(self._own(), None, return_data)
        names = {_sorted_names(a, b) for a, b in pairs}
        return _select(bool(pairs), (return_names, names), (return_data, data))

    def in_collision_other(
        self,
        other_manager: CollisionManager,
        return_names: bool = False,
        return_data: bool = False,
    ) -> Any:
        """Says whether any object collides with any object of another manager.

        Returns a bool, and if asked for, the set of pairs (name here, name there) and a list of
        ContactData.
        """
        guests = [copy.copy(each) for each in other_manager._own()]
        pairs, data = self._collide(self._own(), guests, return_data)
        names = {(a.name, b.name) for a, b in pairs}
        return _select(bool(pairs), (return_names, names), (return_data, data))

    def min_distance_single(
        self,
        mesh: trimesh.Trimesh,
        transform: ArrayLike | None = None,
        return_name: bool = False,
        return_data: bool = False,
    ) -> Any:
        """Measures how far a mesh that is not in the manager is from the nearest object.

        Returns the distance, and if asked for, the object's name and DistanceData.
        If there is no object, the distance is `sys.float_info.max`, and the rest is None.
        """
        nearest = self._closest(self._own(), [_Object(EXTERNAL, mesh, transform)])
        name = nearest and nearest.a.name
        return _measured(nearest, (return_name, name), return_data)

    def min_distance_internal(
        self, name: Hashable | None = None, return_names: bool = False, return_data: bool = False
    ) -> Any:
        """Measures the distance of the two nearest objects, or of one object and the rest.

        Returns the distance, and if asked for, the two names in alphabetical order and
        DistanceData.
        If there are no two objects, the distance is `sys.float_info.max`, and the rest is None.
        """
        if name is None:
            nearest = self._closest(self._own(), None)
        else:
            one = self._object(name)
            nearest = self._closest([one], [each for each in self._own() if each is not one])
        names = nearest and _sorted_names(nearest.a, nearest.b)
        return _measured(nearest, (return_names, names), return_data)

    def min_distance_other(
        self,
        other_manager: CollisionManager,
        return_names: bool = False,
        return_data: bool = False,
    ) -> Any:
        """Measures the distance of the two nearest objects, one of each manager.

        Returns the distance, and if asked for, (name here, name there) and DistanceData.
        If a manager is empty, the distance is `sys.float_info.max`, and the rest is None.
        """
        guests = [copy.copy(each) for each in other_manager._own()]
        nearest = self._closest(self._own(), guests)
        names = nearest and (nearest.a.name, nearest.b.name)
        return _measured(nearest, (return_names, names), return_data)

    def _own(self) -> list[_Object]:
        return list(self._objects.values())

    def _object(self, name: Hashable) -> _Object:
        if name not in self._objects:
            raise ValueError(f"{name} not in collision manager!")
        return self._objects[name]

    @contextmanager
    def _layers(self, left: list[_Object], right: list[_Object] | None) -> Iterator[list[_Bodies]]:
        """The worlds in which all of these objects are, while a question is answered."""
        everyone = left + (right or [])
        guests = [each for each in right or [] if each not in self._solids.bodies]
        layers: list[_Bodies] = [self._solids]
        try:
            for each in guests:
                self._solids.add(each)
            if not all(each.shape.is_solid for each in everyone):
                layers.append(_Sheets(self._options))
                for each in everyone:
                    layers[-1].add(each)
            yield layers
        finally:
            for each in guests:
                self._solids.remove(each)
            self._solids.forget_meshes(guests)

    def _collide(
        self, left: list[_Object], right: list[_Object] | None, all_contacts: bool
    ) -> tuple[list[tuple[_Object, _Object]], list[ContactData]]:
        """The pairs that collide, the left object first, and their contacts if asked for."""
        pairs: list[tuple[_Object, _Object]] = []
        data: list[ContactData] = []
        order = _places(left, right)
        with self._layers(left, right) as layers:
            for layer in layers:
                contacts = layer.detect(left, right, 0.0)
                deepest = [layer.meeting(contacts, i, order) for i in _deepest_of_pairs(contacts)]
                pairs += [(meeting.a, meeting.b) for meeting in deepest]
                if all_contacts:
                    data += [layer.part(each).contact_data() for each in deepest if each.is_convex]
                    every = (layer.meeting(contacts, i, order) for i in range(len(contacts)))
                    data += [each.contact_data() for each in every if not each.is_convex]
        return pairs, data

    def _closest(self, left: list[_Object], right: list[_Object] | None) -> _Nearest | None:
        """The pair with the least distance; None if there are no pairs."""
        order = _places(left, right)
        with self._layers(left, right) as layers:
            overlaps = []
            for layer in layers:
                contacts = layer.detect(left, right, 0.0)
                for i in _deepest_of_pairs(contacts):
                    meeting = layer.meeting(contacts, i, order)
                    overlaps.append(meeting.nearest(0.0 - layer.depth(meeting)))
            if overlaps:
                return min(overlaps, key=lambda overlap: overlap.distance)
            pairs = _pairs_by_gap(left, right)
            bound = _upper_bound(pairs)
            contacts = self._solids.detect(left, right, bound)
            best: _Nearest | None = None
            if len(contacts):
                row = int(np.argmin(contacts.distance))
                meeting = self._solids.meeting(contacts, row, order)
                bound = meeting.distance
                best = meeting.nearest(bound)
            for gap, a, b in pairs:
                if gap <= bound and not (a.shape.is_solid and b.shape.is_solid):
                    found = _surface_distance(a, b, bound)
                    if found and (best is None or found.distance < best.distance):
                        best, bound = found, found.distance
            return best


def scene_to_collision(
    scene: trimesh.Scene, backend: str = "auto", threads: int = 0
) -> tuple[CollisionManager, dict[Hashable, object]]:
    """Makes a manager of a scene's meshes: (manager, {node: object})."""
    manager = CollisionManager(backend, threads)
    objects = {}
    for node in scene.graph.nodes_geometry:
        transform, geometry = scene.graph[node]
        objects[node] = manager.add_object(node, scene.geometry[geometry], transform)
    return manager, objects


class _Shape:
    """What Pierce has made of one mesh, which managers share."""

    _known: ClassVar[dict[int, tuple[weakref.ref[trimesh.Trimesh], int, _Shape]]] = {}

    @classmethod
    def of(cls, mesh: trimesh.Trimesh) -> _Shape:
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
        self.vertices = np.array(mesh.vertices, dtype=np.float64)
        self.faces = np.array(mesh.faces, dtype=np.int64)
        self._data = self.vertices.astype(np.float32), self.faces.astype(np.uint32)
        self.solid = _core.Mesh.make(self._data)
        if self.solid.inside.exists and self.solid.traits.volume < 0:
            self.solid = _core.Mesh.make(self._data, inside="winding")
        self._sheet: _core.Mesh | None = None
        self._is_convex = bool(mesh.is_convex)
        corners = self.faces[:, [0, 1, 2, 0, 1, 2]], self.faces[:, [0, 1, 2, 1, 2, 0]]
        keys = self._keys(*corners).ravel()
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

    def face(self, triangle: int) -> int:
        """The face of a triangle that a contact names; -1 if it closes a hole."""
        given = self.solid.given_triangle(triangle)
        return -1 if given == _core.no_triangle else given

    def face_at(self, vertex: int, edge_end: int) -> int:
        """A face that has the vertex or, if it has an end, the edge."""
        end = vertex if edge_end == _core.no_vertex else edge_end
        key = self._keys(np.array(vertex), np.array(end))
        place = int(np.searchsorted(self._edge_keys, key))
        found = place < len(self._edge_keys) and self._edge_keys[place] == key
        return int(self._edge_faces[place]) if found else -1

    def _keys(self, v: NDArray[Any], w: NDArray[Any]) -> NDArray[np.int64]:
        keys: NDArray[np.int64] = np.minimum(v, w) * len(self.vertices) + np.maximum(v, w)
        return keys


class _Object:
    """A mesh in a place."""

    def __init__(self, name: Hashable, mesh: trimesh.Trimesh, transform: ArrayLike | None) -> None:
        self.name = name
        self.shape = _Shape.of(mesh)
        self.transform = _rigid(np.eye(4) if transform is None else transform)

    def points(self) -> Floats:
        """World positions of the vertices, (n, 3)."""
        return self.shape.vertices @ self.transform[:3, :3].T + self.transform[:3, 3]

    def triangles(self) -> Floats:
        """World positions of the corners of all faces, (m, 3, 3)."""
        return self.points()[self.shape.faces]


class _Bodies:
    """A world in which each object has one body."""

    def __init__(self, settings: dict[str, Any]) -> None:
        self.world = _core.World(**settings)
        self.bodies: dict[_Object, _core.BodyId] = {}
        self.objects: dict[int, _Object] = {}
        self._meshes: dict[_Shape, _core.MeshId] = {}

    def add(self, added: _Object) -> None:
        if added.shape not in self._meshes:
            self._meshes[added.shape] = self.world.add_mesh(self._mesh(added.shape))
        body = self._body(added, self._meshes[added.shape])
        self.bodies[added] = body
        self.objects[int(body)] = added

    def remove(self, removed: _Object) -> None:
        body = self.bodies.pop(removed, None)
        if body is not None:
            del self.objects[int(body)]
            self.world.remove_body(body)

    def forget_meshes(self, but: Iterable[_Object] = ()) -> None:
        """Removes the meshes of no body, except those of some objects."""
        used = {each.shape for each in (*self.bodies, *but)}
        for shape in self._meshes.keys() - used:
            self.world.remove_mesh(self._meshes.pop(shape))

    def detect(
        self, left: list[_Object], right: list[_Object] | None, reach: float
    ) -> _core.Contacts:
        """Contacts of the left objects with the right ones, or if None, with each other.

        `reach`: how far apart objects have contacts, too.
        """
        sides = [(left, 1, 1)] if right is None else [(left, 1, 2), (right, 2, 1)]
        for objects, own, others in sides:
            for each in objects:
                if each in self.bodies:
                    body = self.bodies[each]
                    self.world.set_filter(body, self._filter(each, own, others))
                    self.world.set_collision(body, self._collision(reach))
        found: _core.Contacts = self.world.detect()
        return found

    def meeting(self, contacts: _core.Contacts, row: int, order: dict[_Object, int]) -> _Meeting:
        """One contact of a list."""
        c, i = contacts, row
        a, b = self.objects[int(c.a[i])], self.objects[int(c.b[i])]
        normal, points = c.normal[i].copy(), (c.point_a[i].copy(), c.point_b[i].copy())
        from_a = bool(c.source[i] == _core.Side.a)
        source, target = (a, b) if from_a else (b, a)
        face = source.shape.face_at(int(c.vertex[i]), int(c.edge_end[i]))
        faces = face, target.shape.face(int(c.triangle[i]))
        if not from_a:
            faces = faces[::-1]
        if order[a] > order[b]:
            a, b, normal, points, faces = b, a, -normal, points[::-1], faces[::-1]
        return _Meeting(a, b, points, faces, normal, float(c.distance[i]))

    def depth(self, meeting: _Meeting) -> float:
        """How far a pair that collides has to move until it is apart."""
        raise NotImplementedError

    def part(self, meeting: _Meeting) -> _Meeting:
        """The one contact of two convex objects: how far and which way they are apart."""
        raise NotImplementedError

    def _mesh(self, shape: _Shape) -> _core.Mesh:
        raise NotImplementedError

    def _body(self, added: _Object, mesh: _core.MeshId) -> _core.BodyId:
        raise NotImplementedError

    def _filter(self, each: _Object, own: int, others: int) -> _core.Filter:
        raise NotImplementedError

    def _collision(self, reach: float) -> _core.Collision:
        raise NotImplementedError


class _Solids(_Bodies):
    """The meshes that have an inside."""

    def __init__(self, options: dict[str, Any]) -> None:
        super().__init__({"coverage": "complete", **options})
        self._options = options

    def add(self, added: _Object) -> None:
        if added.shape.is_solid:
            super().add(added)

    def move(self, moved: _Object) -> None:
        if moved in self.bodies:
            self.world.set_pose(self.bodies[moved], moved.transform)

    def depth(self, meeting: _Meeting) -> float:
        parting = self._parting(meeting)
        return parting.depth if parting else meeting.depth

    def part(self, meeting: _Meeting) -> _Meeting:
        parting = self._parting(meeting)
        if parting is None:
            return meeting
        direction = np.array(parting.direction)
        # What only touches is neither near nor in contact.
        gap = 1e-5 * max(np.ptp(each.points(), axis=0).max() for each in (meeting.a, meeting.b))
        way = (parting.depth + gap) * direction
        parted = copy.copy(meeting.b)
        parted.transform = parted.transform.copy()
        parted.transform[:3, 3] += way
        touching = _Solids(self._options)
        touching.add(meeting.a)
        touching.add(parted)
        contacts = touching.detect([meeting.a], [parted], 2 * gap)
        if len(contacts):
            nearest = int(np.argmin(contacts.distance))
            touch = touching.meeting(contacts, nearest, {meeting.a: 0, parted: 1})
            points = touch.points[0], touch.points[1] - way
            meeting = meeting._replace(points=points, faces=touch.faces)
        return meeting._replace(normal=direction, distance=-parting.depth)

    def _parting(self, meeting: _Meeting) -> _core.Parting | None:
        """The shortest way known of the second object out of the first one."""
        a, b = self.bodies[meeting.a], self.bodies[meeting.b]
        found: _core.Parting | None = self.world.parting(a, b)
        return found

    def _mesh(self, shape: _Shape) -> _core.Mesh:
        return shape.solid

    def _body(self, added: _Object, mesh: _core.MeshId) -> _core.BodyId:
        return self.world.add_rigid_body(mesh, added.transform)

    def _filter(self, each: _Object, own: int, others: int) -> _core.Filter:
        return _core.Filter(groups=own, meets=others)

    def _collision(self, reach: float) -> _core.Collision:
        return _core.Collision(margin=reach)


class _Sheets(_Bodies):
    """The surfaces of all meshes, of which those without an inside meet all others."""

    def depth(self, meeting: _Meeting) -> float:
        return 0.0

    def part(self, meeting: _Meeting) -> _Meeting:
        return meeting

    def _mesh(self, shape: _Shape) -> _core.Mesh:
        return shape.sheet

    def _body(self, added: _Object, mesh: _core.MeshId) -> _core.BodyId:
        return self.world.add_deforming_body(mesh, added.points().astype(np.float32))

    def _filter(self, each: _Object, own: int, others: int) -> _core.Filter:
        """Surfaces of solids are two groups higher, and do not meet each other."""
        if each.shape.is_solid:
            return _core.Filter(groups=own << 2, meets=others)
        return _core.Filter(groups=own, meets=others | others << 2)

    def _collision(self, reach: float) -> _core.Collision:
        return _core.Collision(sheet=True, thickness=reach)


class _Meeting(NamedTuple):
    """One contact of two objects, the first one of `order` first."""

    a: _Object
    b: _Object
    points: tuple[Floats, Floats]
    faces: tuple[int, int]
    normal: Floats
    distance: float

    @property
    def is_convex(self) -> bool:
        return self.a.shape.is_convex and self.b.shape.is_convex

    @property
    def depth(self) -> float:
        return max(-self.distance, 0.0)

    def contact_data(self) -> ContactData:
        contact = SimpleNamespace(
            b1=self.faces[0],
            b2=self.faces[1],
            normal=self.normal,
            pos=(self.points[0] + self.points[1]) / 2,
            penetration_depth=self.depth,
        )
        return ContactData((self.a.name, self.b.name), contact)  # type: ignore[no-untyped-call]

    def nearest(self, distance: float) -> _Nearest:
        names = self.a.name, self.b.name
        data = _distance_data(names, distance, self.points, self.faces)
        return _Nearest(distance, self.a, self.b, data)


class _Nearest(NamedTuple):
    """The pair with the least distance, the left object first."""

    distance: float
    a: _Object
    b: _Object
    data: DistanceData


def _distance_data(
    names: tuple[Hashable, Hashable], distance: float, points: Any, faces: tuple[int, int]
) -> DistanceData:
    result = SimpleNamespace(b1=faces[0], b2=faces[1], nearest_points=points, min_distance=distance)
    return DistanceData(names, result)  # type: ignore[no-untyped-call]


def _deepest_of_pairs(contacts: _core.Contacts) -> list[int]:
    """The places of each pair's deepest contact."""
    order = np.lexsort((contacts.distance, contacts.b, contacts.a))
    pairs = np.stack([contacts.a, contacts.b], axis=1)[order]
    first = np.ones(len(order), dtype=bool)
    first[1:] = (pairs[1:] != pairs[:-1]).any(axis=1)
    places: list[int] = order[first].tolist()
    return places


def _places(left: list[_Object], right: list[_Object] | None) -> dict[_Object, int]:
    """The place of each object: left ones first, then in the order in which they were added."""
    return {each: place for place, each in reversed([*enumerate(left + (right or []))])}


def _pairs_by_gap(
    left: list[_Object], right: list[_Object] | None
) -> list[tuple[float, _Object, _Object]]:
    """All pairs, with the gap between their boxes, the smallest first."""
    others = left if right is None else right
    if not left or not others:
        return []
    boxes, other_boxes = (np.array([box(each.points()) for each in e]) for e in (left, others))
    gaps = box_gaps(boxes, other_boxes)
    if right is None:
        gaps[np.tril_indices(len(left))] = np.inf
    order = np.argsort(gaps, axis=None)[: np.isfinite(gaps).sum()]
    places = zip(*np.unravel_index(order, gaps.shape), strict=True)
    return [(float(gaps[i, j]), left[i], others[j]) for i, j in places]


def _upper_bound(pairs: list[tuple[float, _Object, _Object]]) -> float:
    """A length that is not less than the least distance of pairs that are apart.

    It is the distance of two vertices, plus what float32 rounds off.
    """
    bound, extent = np.inf, 0.0
    for gap, a, b in pairs:
        if gap >= bound:
            break
        ours, theirs = a.points(), b.points()
        bound = min(bound, vertex_distance(ours, theirs))
        extent = max(extent, np.abs(ours).max(), np.abs(theirs).max())
    return float(bound + 4e-7 * (extent + bound)) if pairs else 0.0


def _surface_distance(a: _Object, b: _Object, bound: float) -> _Nearest | None:
    """The distance of two surfaces that are apart, if it is not more than the bound."""
    ours, theirs = a.triangles(), b.triangles()
    boxes, other_boxes = box(ours, axis=1), box(theirs, axis=1)
    from_all = box_gaps(boxes, box(b.points())[None])[:, 0]
    best: _Nearest | None = None
    rows_at_once = max(1, 2**20 // len(theirs))
    order = np.argsort(from_all)
    for start in range(0, len(order), rows_at_once):
        rows = order[start : start + rows_at_once]
        i, j = np.nonzero(box_gaps(boxes[rows], other_boxes) <= bound)
        if len(i) == 0:
            continue
        points, other_points = closest_points(ours[rows[i]], theirs[j])
        lengths = np.linalg.norm(points - other_points, axis=1)
        k = int(np.argmin(lengths))
        if lengths[k] <= bound:
            bound = float(lengths[k])
            faces = int(rows[i[k]]), int(j[k])
            data = _distance_data((a.name, b.name), bound, (points[k], other_points[k]), faces)
            best = _Nearest(bound, a, b, data)
    return best


def _rigid(transform: ArrayLike) -> Floats:
    """A copy of a transform as (4, 4). Raises ValueError if it is not rigid."""
    matrix = np.array(transform, dtype=np.float64)
    if matrix.shape != (4, 4):
        raise ValueError("transform must be (4,4)!")
    turn = matrix[:3, :3]
    if not np.allclose(turn @ turn.T, np.eye(3), atol=1e-5) or np.linalg.det(turn) < 0:
        raise ValueError("transform must be rigid: use mesh.apply_transform() for other ones")
    return matrix


def _sorted_names(a: _Object, b: _Object) -> tuple[Any, ...]:
    names: list[Any] = [a.name, b.name]
    return tuple(sorted(names))


def _measured(nearest: _Nearest | None, names: tuple[bool, Any], return_data: bool) -> Any:
    distance = nearest.distance if nearest else sys.float_info.max
    return _select(distance, names, (return_data, nearest and nearest.data))


def _select(value: Any, *more: tuple[bool, Any]) -> Any:
    """The value, or a tuple of it and of what is asked for."""
    asked = [each for wanted, each in more if wanted]
    return (value, *asked) if asked else value
