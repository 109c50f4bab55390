"""Contacts and distances of two meshes, as trimesh wants them."""

from __future__ import annotations

from collections.abc import Hashable
from types import SimpleNamespace
from typing import Any, NamedTuple

import numpy as np
from trimesh.collision import ContactData, DistanceData

from ._surfaces import Floats, box, box_gaps, closest_points, vertex_distance
from ._trimesh_objects import Object


class Meeting(NamedTuple):
    """One contact of two objects, the first one of `order` first."""

    a: Object
    b: Object
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

    def nearest(self, distance: float) -> Nearest:
        names = self.a.name, self.b.name
        data = distance_data(names, distance, self.points, self.faces)
        return Nearest(distance, self.a, self.b, data)


class Nearest(NamedTuple):
    """The pair with the least distance, the left object first."""

    distance: float
    a: Object
    b: Object
    data: DistanceData


def distance_data(
    names: tuple[Hashable, Hashable], distance: float, points: Any, faces: tuple[int, int]
) -> DistanceData:
    result = SimpleNamespace(b1=faces[0], b2=faces[1], nearest_points=points, min_distance=distance)
    return DistanceData(names, result)  # type: ignore[no-untyped-call]


def pairs_by_gap(
    left: list[Object], right: list[Object] | None
) -> list[tuple[float, Object, Object]]:
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


def upper_bound(pairs: list[tuple[float, Object, Object]]) -> float:
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


def surface_distance(a: Object, b: Object, bound: float) -> Nearest | None:
    """The distance of two surfaces that are apart, if it is not more than the bound."""
    ours, theirs = a.triangles(), b.triangles()
    boxes, other_boxes = box(ours, axis=1), box(theirs, axis=1)
    from_all = box_gaps(boxes, box(b.points())[None])[:, 0]
    best: Nearest | None = None
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
            data = distance_data((a.name, b.name), bound, (points[k], other_points[k]), faces)
            best = Nearest(bound, a, b, data)
    return best
