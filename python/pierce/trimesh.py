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
  `index()` is the face there, also of convex meshes; -1 where a hole of a solid was closed.
* Transforms have to be rigid: a scale or a mirror is applied to the mesh, not to its place.

Lengths are in the unit of the meshes.
"""

from __future__ import annotations

import copy
import sys
from collections.abc import Hashable, Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np
import trimesh
from numpy.typing import ArrayLike
from trimesh.collision import ContactData, DistanceData

from ._trimesh_meetings import Nearest, pairs_by_gap, surface_distance, upper_bound
from ._trimesh_objects import Object, rigid_transform
from ._trimesh_worlds import Bodies, Sheets, Solids, deepest_of_pairs

__all__ = ["CollisionManager", "ContactData", "DistanceData", "scene_to_collision"]

EXTERNAL = "__external"
"""The name of a mesh that is not in the manager, as trimesh has it."""


class CollisionManager:
    """Meshes under names, and questions about which of them collide or how far they are apart.

    `backend` and `threads` are those of `pierce.World`.
    """

    def __init__(self, backend: str = "auto", threads: int = 0) -> None:
        self._options: dict[str, Any] = {"backend": backend, "threads": threads}
        self._solids = Solids(self._options)
        self._objects: dict[Hashable, Object] = {}

    def add_object(
        self, name: Hashable, mesh: trimesh.Trimesh, transform: ArrayLike | None = None
    ) -> object:
        """Adds a mesh, in place of the one that has had the name.

        `transform`: rigid, (4, 4), the identity by default.
        Returns what stands for the object, for comparisons only.
        """
        added = Object(name, mesh, transform)
        replaced = name in self._objects
        self._solids.add(added)  # If this raises, the old object stays.
        if replaced:
            self.remove_object(name)
        self._objects[name] = added
        return added

    def remove_object(self, name: Hashable) -> None:
        """Removes an object. Raises ValueError if there is none of that name."""
        self._solids.remove(self._object(name))
        self._solids.forget_meshes()
        del self._objects[name]

    def set_transform(self, name: Hashable, transform: ArrayLike) -> None:
        """Moves an object: `transform` is rigid, (4, 4). Raises ValueError for unknown names."""
        self._solids.move(self._object(name), rigid_transform(transform))

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
        guests = [Object(EXTERNAL, mesh, transform)]
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
        nearest = self._closest(self._own(), [Object(EXTERNAL, mesh, transform)])
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

    def _own(self) -> list[Object]:
        return list(self._objects.values())

    def _object(self, name: Hashable) -> Object:
        if name not in self._objects:
            raise ValueError(f"{name} not in collision manager!")
        return self._objects[name]

    @contextmanager
    def _layers(self, left: list[Object], right: list[Object] | None) -> Iterator[list[Bodies]]:
        """The worlds in which all of these objects are, while a question is answered."""
        everyone = left + (right or [])
        guests = [each for each in right or [] if each not in self._solids.bodies]
        layers: list[Bodies] = [self._solids]
        try:
            for each in guests:
                self._solids.add(each)
            if not all(each.shape.is_solid for each in everyone):
                layers.append(Sheets(self._options))
                for each in everyone:
                    layers[-1].add(each)
            yield layers
        finally:
            for each in guests:
                self._solids.remove(each)
            self._solids.forget_meshes(guests)

    def _collide(
        self, left: list[Object], right: list[Object] | None, all_contacts: bool
    ) -> tuple[list[tuple[Object, Object]], list[ContactData]]:
        """The pairs that collide, the left object first, and their contacts if asked for."""
        pairs: list[tuple[Object, Object]] = []
        data: list[ContactData] = []
        order = _places(left, right)
        with self._layers(left, right) as layers:
            for layer in layers:
                contacts = layer.detect(left, right, 0.0)
                deepest = [layer.meeting(contacts, i, order) for i in deepest_of_pairs(contacts)]
                pairs += [(meeting.a, meeting.b) for meeting in deepest]
                if all_contacts:
                    data += [layer.part(each).contact_data() for each in deepest if each.is_convex]
                    every = (layer.meeting(contacts, i, order) for i in range(len(contacts)))
                    data += [each.contact_data() for each in every if not each.is_convex]
        return pairs, data

    def _closest(self, left: list[Object], right: list[Object] | None) -> Nearest | None:
        """The pair with the least distance; None if there are no pairs."""
        order = _places(left, right)
        with self._layers(left, right) as layers:
            overlaps = []
            for layer in layers:
                contacts = layer.detect(left, right, 0.0)
                for i in deepest_of_pairs(contacts):
                    meeting = layer.meeting(contacts, i, order)
                    overlaps.append(meeting.nearest(0.0 - layer.depth(meeting)))
            if overlaps:
                return min(overlaps, key=lambda overlap: overlap.distance)
            pairs = pairs_by_gap(left, right)
            bound = upper_bound(pairs)
            contacts = self._solids.detect(left, right, bound)
            best: Nearest | None = None
            if len(contacts):
                row = int(np.argmin(contacts.distance))
                meeting = self._solids.meeting(contacts, row, order)
                bound = meeting.distance
                best = meeting.nearest(bound)
            for gap, a, b in pairs:
                if gap <= bound and not (a.shape.is_solid and b.shape.is_solid):
                    found = surface_distance(a, b, bound)
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


def _places(left: list[Object], right: list[Object] | None) -> dict[Object, int]:
    """The place of each object: left ones first, then in the order in which they were added."""
    return {each: place for place, each in reversed([*enumerate(left + (right or []))])}


def _sorted_names(a: Object, b: Object) -> tuple[Any, ...]:
    names: list[Any] = [a.name, b.name]
    return tuple(sorted(names))


def _measured(nearest: Nearest | None, names: tuple[bool, Any], return_data: bool) -> Any:
    distance = nearest.distance if nearest else sys.float_info.max
    return _select(distance, names, (return_data, nearest and nearest.data))


def _select(value: Any, *more: tuple[bool, Any]) -> Any:
    """The value, or a tuple of it and of what is asked for."""
    asked = [each for wanted, each in more if wanted]
    return (value, *asked) if asked else value
