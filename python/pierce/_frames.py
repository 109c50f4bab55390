"""Where the bodies of a recording are in a frame, and its contacts."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ._core import Contacts, Motion, Recording, Replay
from ._poses import rotations_of
from .files import Triangles, Vertices


def contacts_of(recording: Recording, **options: Any) -> Iterator[Contacts]:
    """The contacts of each frame. `options` are those of `Replay`: backend, threads, settings."""
    replay = Replay(recording, **options)
    for frame in range(len(replay)):
        yield replay.step(frame)


def deforms(recording: Recording, body: int) -> bool:
    """The body's vertices are given, and not its pose."""
    return recording.motion_kind(body) == Motion.deforming


def pose(recording: Recording, body: int, frame: int) -> NDArray[np.float64]:
    """Where a rigid or fixed body is, float64 (7,)."""
    poses = recording.motion(body)
    return np.asarray(poses[min(frame, len(poses) - 1)], np.float64)


def surface(recording: Recording, body: int, frame: int) -> tuple[Vertices, Triangles] | None:
    """World positions and triangles; None if the place is not finite, as in a replay."""
    rest, triangles = recording.mesh(body, frame)
    if deforms(recording, body):
        now = np.asarray(recording.positions(body, frame))
    else:
        place = pose(recording, body, frame)
        if not np.isfinite(place).all() or not place[3:].any():
            return None
        turned = rest.astype(np.float64) @ rotations_of(place[None, 3:])[0].T
        now = (turned + place[:3]).astype(np.float32)
    return (now, triangles) if np.isfinite(now).all() else None
