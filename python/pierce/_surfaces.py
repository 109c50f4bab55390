"""Distances of triangles, points and boxes, many at once with NumPy."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from trimesh.triangles import closest_point

Floats = NDArray[np.float64]


def vertex_distance(ours: Floats, theirs: Floats) -> float:
    """The distance of two vertices that are near each other, mostly the nearest ones."""
    point, best = theirs.mean(axis=0), np.inf
    while True:
        ours, theirs = theirs, ours
        lengths = np.linalg.norm(theirs - point, axis=1)
        nearest = int(np.argmin(lengths))
        point = theirs[nearest]
        if lengths[nearest] >= best:
            return best
        best = float(lengths[nearest])


def closest_points(s: Floats, t: Floats) -> tuple[Floats, Floats]:
    """Where triangles that are apart, (n, 3, 3) each, are closest to each other."""
    candidates = [(s[:, k], _closest_on_triangles(t, s[:, k])) for k in range(3)]
    candidates += [(_closest_on_triangles(s, t[:, k]), t[:, k]) for k in range(3)]
    for k in range(3):
        for m in range(3):
            first = s[:, k], s[:, (k + 1) % 3]
            candidates.append(_closest_on_segments(*first, t[:, m], t[:, (m + 1) % 3]))
    ours, theirs = (np.array(points) for points in zip(*candidates, strict=True))
    best = np.argmin(np.linalg.norm(ours - theirs, axis=2), axis=0)
    each = np.arange(len(s))
    return ours[best, each], theirs[best, each]


def _closest_on_triangles(triangles: Floats, points: Floats) -> Floats:
    """The points of triangles, (n, 3, 3), that are closest to points, (n, 3).

    trimesh decides with absolute lengths, so it is asked for triangles of the size one.
    """
    origin = triangles[:, 0]
    size = np.abs(triangles - origin[:, None]).max(axis=(1, 2))[:, None]
    size[size == 0] = 1
    ones, at = (triangles - origin[:, None]) / size[:, None], (points - origin) / size
    found: Floats = origin + size * closest_point(ones, at)  # type: ignore[no-untyped-call]
    return found


def _closest_on_segments(
    p: Floats, p_end: Floats, q: Floats, q_end: Floats
) -> tuple[Floats, Floats]:
    """Points of two segments, (n, 3), that are closest where both are within their segments."""
    d, e, r = p_end - p, q_end - q, p - q
    dd, ee, de = (np.einsum("ni,ni->n", *two) for two in ((d, d), (e, e), (d, e)))
    dr, er = (np.einsum("ni,ni->n", *two) for two in ((d, r), (e, r)))
    tiny = np.finfo(np.float64).tiny
    along = np.clip((de * er - dr * ee) / np.maximum(dd * ee - de * de, tiny), 0, 1)
    other = np.clip((de * along + er) / np.maximum(ee, tiny), 0, 1)
    return p + along[:, None] * d, q + other[:, None] * e


def box(points: Floats, axis: int = 0) -> Floats:
    """Lower and upper corners along an axis: (..., 2, 3)."""
    return np.stack([points.min(axis=axis), points.max(axis=axis)], axis=-2)


def box_gaps(ours: Floats, theirs: Floats) -> Floats:
    """How far boxes, (n, 2, 3) and (m, 2, 3), are apart: (n, m)."""
    gaps = np.maximum(ours[:, None, 0] - theirs[:, 1], theirs[:, 0] - ours[:, None, 1])
    lengths: Floats = np.linalg.norm(np.maximum(gaps, 0.0), axis=2)
    return lengths
