"""Poses, which are a position and a quaternion x y z w, and matrices (4, 4)."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

Floats = NDArray[np.float64]

_SAME = 1e-6
"""[1] A stretch that differs less from none is rounding: matrices often come from float32."""


_RIGID = 2e-5
"""[1] A matrix whose products differ less from those of axes stretches by 1e-5 at most."""


def is_rigid(matrix: Floats) -> bool:
    """True if a matrix (4, 4) turns and shifts and does nothing else, to rounding."""
    turn = matrix[:3, :3]
    is_turn = np.abs(turn.T @ turn - np.eye(3)).max() <= _RIGID and np.linalg.det(turn) > 0
    return bool(is_turn and np.abs(matrix[3] - [0, 0, 0, 1]).max() <= _RIGID)


def matrix_of(pose: ArrayLike) -> Floats:
    """The matrix (4, 4) of a pose of seven numbers, or of what is a rigid matrix already."""
    given = np.asarray(pose, np.float64)
    if not np.isfinite(given).all():
        raise ValueError("the pose is not finite")
    if given.shape == (4, 4):
        if not is_rigid(given):
            raise ValueError("the matrix stretches or mirrors: no pose does")
        return given
    if given.shape != (7,):
        raise ValueError(f"expected a pose of seven numbers or a matrix (4, 4), got {given.shape}")
    if not given[3:].any():
        raise ValueError("the pose has no rotation: its quaternion is 0")
    matrix = np.eye(4)
    matrix[:3, :3] = rotations_of(given[None, 3:])[0]
    matrix[:3, 3] = given[:3]
    return matrix


def rotations_of(quaternions: Floats) -> Floats:
    """The rotations (n, 3, 3) of quaternions x y z w (n, 4) of any length but zero."""
    x, y, z, w = (quaternions / np.linalg.norm(quaternions, axis=1, keepdims=True)).T
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ]
    return np.moveaxis(np.array(rows), 2, 0)


def poses_of(matrices: Floats) -> Floats:
    """Poses (n, 7) of rigid matrices (n, 4, 4)."""
    poses = np.empty((len(matrices), 7))
    poses[:, :3] = matrices[:, :3, 3]
    poses[:, 3:] = _quaternions_of(matrices[:, :3, :3])
    return poses


def _quaternions_of(turns: Floats) -> Floats:
    """Quaternions x y z w (n, 4) of rotations (n, 3, 3).

    Each row of four times the products of a quaternion's numbers is the quaternion, scaled by one
    of its numbers; the row of the largest one is exact to rounding.
    """
    (a, b, c), (d, e, f), (g, h, i) = np.moveaxis(turns, 0, 2)
    products = np.array(
        [
            [1 + a - e - i, b + d, c + g, h - f],
            [b + d, 1 - a + e - i, f + h, c - g],
            [c + g, f + h, 1 - a - e + i, d - b],
            [h - f, c - g, d - b, 1 + a + e + i],
        ]
    )
    largest = np.einsum("kkn->nk", products).argmax(1)
    rows = products[largest, :, np.arange(len(turns))]
    return np.asarray(rows / np.linalg.norm(rows, axis=1, keepdims=True))


def split(matrix: Floats) -> tuple[Floats, Floats | None]:
    """Takes a matrix (4, 4) apart: a rigid matrix, after a stretch (3, 3), None if there is none.

    The stretch is symmetric (polar decomposition); a mirror is part of it.
    """
    left, sizes, right = np.linalg.svd(matrix[:3, :3])
    mirrored = np.linalg.det(left @ right) < 0
    signs = np.array([1.0, 1.0, -1.0 if mirrored else 1.0])
    rigid = np.eye(4)
    rigid[:3, :3] = (left * signs) @ right
    rigid[:3, 3] = matrix[:3, 3]
    if not mirrored and np.abs(sizes - 1).max() <= _SAME:
        return rigid, None
    return rigid, np.asarray(rigid[:3, :3].T @ matrix[:3, :3])


def inverse(matrix: Floats) -> Floats:
    """The inverse of a rigid matrix (4, 4)."""
    turned = np.eye(4)
    turned[:3, :3] = matrix[:3, :3].T
    turned[:3, 3] = -matrix[:3, :3].T @ matrix[:3, 3]
    return turned
