"""Where the bodies of a recording are in a frame, and its contacts."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sized
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ._core import Contacts, InputError, Motion, Recording, Replay
from ._poses import rotations_of
from .files import Triangles, Vertices


def contacts_of(recording: Recording, **options: Any) -> Iterator[Contacts]:
    """The contacts of each frame. `options` are those of `Replay`: backend, threads, settings."""
    replay = Replay(recording, **options)
    for frame in range(len(replay)):
        yield replay.step(frame)


def per_frame(recording: Recording, contacts: Iterable[Contacts]) -> Iterator[Contacts]:
    """The contacts of each frame. Raises InputError once it is known that some are missing."""
    if isinstance(contacts, Sized):
        _check_count(recording, len(contacts))
    return _checked(recording, contacts)


def _checked(recording: Recording, contacts: Iterable[Contacts]) -> Iterator[Contacts]:
    count = 0
    for found in islice(contacts, recording.frame_count):
        yield found
        count += 1
    _check_count(recording, count)


def _check_count(recording: Recording, count: int) -> None:
    if count < recording.frame_count:
        raise InputError(
            f"there are contacts of {count} frames only, and the recording has "
            f"{recording.frame_count}"
        )


def check_writable(recording: Recording, path: Path, ending: str) -> None:
    """Raises InputError unless there is something to write, and a file may have this name."""
    if not recording.body_names:
        raise InputError("the recording has no bodies")
    if path.suffix.lower() != ending:
        raise InputError(f"'{path}': expected a name that ends in {ending}")
    if path.is_dir():
        raise InputError(f"'{path}' is a folder")


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
