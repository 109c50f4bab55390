"""Worlds in which objects of a collision manager are bodies: solids in one, surfaces in another."""

from __future__ import annotations

import copy
from collections.abc import Iterable
from typing import Any

import numpy as np

from . import _core
from ._surfaces import Floats
from ._trimesh_meetings import Meeting
from ._trimesh_objects import Object, Shape


class Bodies:
    """A world in which each object has one body."""

    def __init__(self, settings: dict[str, Any]) -> None:
        self.world = _core.World(**settings)
        self.bodies: dict[Object, _core.BodyId] = {}
        self.objects: dict[int, Object] = {}
        self._meshes: dict[Shape, _core.MeshId] = {}

    def add(self, added: Object) -> None:
        if added.shape not in self._meshes:
            self._meshes[added.shape] = self.world.add_mesh(self._mesh(added.shape))
        body = self._body(added, self._meshes[added.shape])
        self.bodies[added] = body
        self.objects[int(body)] = added

    def remove(self, removed: Object) -> None:
        body = self.bodies.pop(removed, None)
        if body is not None:
            del self.objects[int(body)]
            self.world.remove_body(body)

    def forget_meshes(self, but: Iterable[Object] = ()) -> None:
        """Removes the meshes of no body, except those of some objects."""
        used = {each.shape for each in (*self.bodies, *but)}
        for shape in self._meshes.keys() - used:
            self.world.remove_mesh(self._meshes.pop(shape))

    def detect(
        self, left: list[Object], right: list[Object] | None, reach: float
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

    def meeting(self, contacts: _core.Contacts, row: int, order: dict[Object, int]) -> Meeting:
        """One contact of a list."""
        c, i = contacts, row
        a, b = self.objects[int(c.a[i])], self.objects[int(c.b[i])]
        normal, points = c.normal[i].copy(), (c.point_a[i].copy(), c.point_b[i].copy())
        from_a = bool(c.source[i] == _core.Side.a)
        source, target = (a, b) if from_a else (b, a)
        face = source.shape.face_at(int(c.vertex[i]), int(c.edge_end[i]))
        given = self._mesh(target.shape).given_triangle(int(c.triangle[i]))
        faces = face, -1 if given == _core.no_triangle else given
        if not from_a:
            faces = faces[::-1]
        if order[a] > order[b]:
            a, b, normal, points, faces = b, a, -normal, points[::-1], faces[::-1]
        return Meeting(a, b, points, faces, normal, float(c.distance[i]))

    def depth(self, meeting: Meeting) -> float:
        """How far a pair that collides has to move until it is apart."""
        raise NotImplementedError

    def part(self, meeting: Meeting) -> Meeting:
        """The one contact of two convex objects: how far and which way they are apart."""
        raise NotImplementedError

    def _mesh(self, shape: Shape) -> _core.Mesh:
        raise NotImplementedError

    def _body(self, added: Object, mesh: _core.MeshId) -> _core.BodyId:
        raise NotImplementedError

    def _filter(self, each: Object, own: int, others: int) -> _core.Filter:
        raise NotImplementedError

    def _collision(self, reach: float) -> _core.Collision:
        raise NotImplementedError


class Solids(Bodies):
    """The meshes that have an inside."""

    def __init__(self, options: dict[str, Any]) -> None:
        super().__init__({"coverage": "complete", **options})
        self._options = options

    def add(self, added: Object) -> None:
        if added.shape.is_solid:
            super().add(added)

    def move(self, moved: Object, transform: Floats) -> None:
        if moved in self.bodies:
            self.world.set_pose(self.bodies[moved], transform)
        moved.transform = transform

    def depth(self, meeting: Meeting) -> float:
        parting = self._parting(meeting)
        return parting.depth if parting else meeting.depth

    def part(self, meeting: Meeting) -> Meeting:
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
        touching = Solids(self._options)
        touching.add(meeting.a)
        touching.add(parted)
        contacts = touching.detect([meeting.a], [parted], 2 * gap)
        if len(contacts):
            nearest = int(np.argmin(contacts.distance))
            touch = touching.meeting(contacts, nearest, {meeting.a: 0, parted: 1})
            points = touch.points[0], touch.points[1] - way
            meeting = meeting._replace(points=points, faces=touch.faces)
        return meeting._replace(normal=direction, distance=-parting.depth)

    def _parting(self, meeting: Meeting) -> _core.Parting | None:
        """The shortest way known of the second object out of the first one."""
        a, b = self.bodies[meeting.a], self.bodies[meeting.b]
        found: _core.Parting | None = self.world.parting(a, b)
        return found

    def _mesh(self, shape: Shape) -> _core.Mesh:
        return shape.solid

    def _body(self, added: Object, mesh: _core.MeshId) -> _core.BodyId:
        return self.world.add_rigid_body(mesh, added.transform)

    def _filter(self, each: Object, own: int, others: int) -> _core.Filter:
        return _core.Filter(groups=own, meets=others)

    def _collision(self, reach: float) -> _core.Collision:
        return _core.Collision(margin=reach)


class Sheets(Bodies):
    """The surfaces of all meshes, of which those without an inside meet all others."""

    def depth(self, meeting: Meeting) -> float:
        return 0.0

    def part(self, meeting: Meeting) -> Meeting:
        return meeting

    def _mesh(self, shape: Shape) -> _core.Mesh:
        return shape.sheet

    def _body(self, added: Object, mesh: _core.MeshId) -> _core.BodyId:
        return self.world.add_deforming_body(mesh, added.points().astype(np.float32))

    def _filter(self, each: Object, own: int, others: int) -> _core.Filter:
        """Surfaces of solids are two groups higher, and do not meet each other."""
        if each.shape.is_solid:
            return _core.Filter(groups=own << 2, meets=others)
        return _core.Filter(groups=own, meets=others | others << 2)

    def _collision(self, reach: float) -> _core.Collision:
        return _core.Collision(sheet=True, thickness=reach)


def deepest_of_pairs(contacts: _core.Contacts) -> list[int]:
    """The places of each pair's deepest contact."""
    order = np.lexsort((contacts.distance, contacts.b, contacts.a))
    pairs = np.stack([contacts.a, contacts.b], axis=1)[order]
    first = np.ones(len(order), dtype=bool)
    first[1:] = (pairs[1:] != pairs[:-1]).any(axis=1)
    places: list[int] = order[first].tolist()
    return places
