"""Keeps where the bodies of a world are, frame by frame."""

from __future__ import annotations

import warnings
from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from ._bodies import bodies_of
from ._core import BodyId, MeshId, Motion, Recording, World


class Recorder:
    """Makes a Recording of a world whose bodies stay the same.

    world: its bodies when the recorder is made are recorded, in the order of their handles.
    dt: [s] from frame to frame.
    names: of bodies; the others have their mesh's.

    A recording has poses in float32, and the collisions, filters and excluded pairs that there
    are when `recording()` is called. It cannot know of a pair filter, or of worlds that are not
    active: in a replay, their bodies meet.
    """

    def __init__(
        self, world: World, dt: float = 1 / 60, names: Mapping[BodyId, str] | None = None
    ) -> None:
        self.world = world
        self.dt = dt
        self.names = dict(names or {})
        self.bodies = sorted(bodies_of(world))
        self._meshes = [world.mesh_of(body) for body in self.bodies]
        self._frames: list[list[NDArray[np.float32]]] = [[] for _ in self.bodies]

    def add(self) -> None:
        """Keeps where all bodies are now, as the next frame. Raises ValueError if a body has
        another mesh than at first."""
        if [self.world.mesh_of(body) for body in self.bodies] != self._meshes:
            raise ValueError("a body has another mesh than when the recorder was made")
        for body, frames in zip(self.bodies, self._frames, strict=True):
            frames.append(np.asarray(self._place(body), np.float32))

    def recording(self) -> Recording:
        """The frames that were added; write() puts it into a folder.

        Warns of bodies that were added since the recorder was made, which are left out.
        Raises ValueError if there are none.
        """
        if not self._frames or not self._frames[0]:
            raise ValueError("nothing was recorded: there is no frame, or no body")
        added = len(set(bodies_of(self.world)) - set(self.bodies))
        if added:
            warnings.warn(
                f"{added} bodies were added later, and are not in the recording: a replay may have "
                "other contacts",
                stacklevel=2,
            )
        numbers: dict[MeshId, int] = {}
        for mesh in self._meshes:
            numbers.setdefault(mesh, len(numbers))
        meshes = [(self.world.mesh(mesh).name, self.world.mesh(mesh)) for mesh in numbers]
        bodies = [
            (
                self._name(body),
                numbers[mesh],
                self.world.motion_of(body),
                np.stack(frames),
                self.world.collision_of(body),
                self.world.filter_of(body),
            )
            for body, mesh, frames in zip(self.bodies, self._meshes, self._frames, strict=True)
        ]
        places = {body: place for place, body in enumerate(self.bodies)}
        excluded = [
            (places[a], places[b])
            for a, b in self.world.excluded_pairs
            if a in places and b in places
        ]
        return Recording(self.dt, meshes, bodies, excluded)

    def _place(self, body: BodyId) -> list[float] | NDArray[np.float64]:
        """Seven numbers of a pose, or float64 (n, 3)."""
        if self.world.motion_of(body) == Motion.deforming:
            return self.world.vertex_positions(body)
        pose = self.world.pose_of(body)
        return [*pose.position, *pose.rotation]

    def _name(self, body: BodyId) -> str:
        return self.names.get(body, self.world.mesh(self.world.mesh_of(body)).name)

    def __repr__(self) -> str:
        frames = len(self._frames[0]) if self._frames else 0
        return f"Recorder({len(self.bodies)} bodies, {frames} frames)"
