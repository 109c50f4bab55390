"""Where the links of a URDF file are."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ._core import InputError
from ._urdf_file import MOVING, UrdfFile, UrdfJoint

Floats = NDArray[np.float64]


def tree_of(file: UrdfFile, path: Path) -> list[UrdfJoint]:
    """The joints, each after the one that leads to its parent.

    Raises InputError unless links and joints are one tree.
    """

    def refused(what: str) -> InputError:
        return InputError(f"cannot read '{path}': {what}")

    below: dict[str, list[UrdfJoint]] = {link: [] for link in file.links}
    held: set[str] = set()
    for joint in file.joints:
        for link in (joint.parent, joint.child):
            if link not in below:
                raise refused(f"joint '{joint.name}': there is no link '{link}'")
        if joint.child in held:
            raise refused(f"two joints lead to link '{joint.child}'")
        held.add(joint.child)
        below[joint.parent].append(joint)
    roots = [link for link in file.links if link not in held]
    if len(roots) != 1:
        raise refused(f"one link has to be the root of all, but these are: {roots}")
    tree = list(below[roots[0]])
    for joint in tree:
        tree += below[joint.child]
    if len(tree) != len(file.joints):
        rings = {joint.name for joint in file.joints} - {joint.name for joint in tree}
        raise refused(f"the joints {sorted(rings)} go in rings")
    return tree


def moving_joints(joints: Iterable[UrdfJoint]) -> list[str]:
    """The joints that have values of their own, by name."""
    return [joint.name for joint in joints if joint.kind in MOVING and joint.mimic is None]


class UrdfKinematics:
    """From values of joints to where meshes are. Threads may share it."""

    def __init__(
        self,
        path: Path,
        tree: Sequence[UrdfJoint],
        names: Sequence[str],
        links: Sequence[str],
        offsets: Sequence[Floats],
    ) -> None:
        """`names`: of the joints that values are for; `links`, `offsets`: of the meshes."""
        followed = _followed(path, tree, names)
        self._sources = np.array([source for source, _, _ in followed], np.int64)
        self._factors = np.array([factor for _, factor, _ in followed])
        self._constants = np.array([constant for _, _, constant in followed])
        self._origins = np.array([joint.origin for joint in tree]).reshape(-1, 4, 4)
        slides = np.array([joint.kind == "prismatic" for joint in tree], bool)
        axes = np.array([joint.axis for joint in tree]).reshape(-1, 3)
        self._slides = axes * slides[:, None]
        # Rotations by Rodrigues: 1 + sin K + (1 - cos) K K, where K crosses with the axis.
        self._crosses = np.cross(np.eye(3), (axes * ~slides[:, None])[:, None]).reshape(-1, 3, 3)
        places = {link: place for place, link in enumerate(joint.child for joint in tree)}
        self._parents = [places.get(joint.parent, -1) for joint in tree]
        self._links = np.array([places.get(link, -1) for link in links], np.int64)
        self._offsets = np.array(offsets).reshape(-1, 4, 4)

    def __call__(self, values: Floats) -> Floats:
        now = np.append(values, 0.0)[self._sources] * self._factors + self._constants
        moves = np.tile(np.eye(4), (len(now), 1, 1))
        sines, cosines = np.sin(now)[:, None, None], np.cos(now)[:, None, None]
        moves[:, :3, :3] += sines * self._crosses + (1 - cosines) * self._crosses @ self._crosses
        moves[:, :3, 3] = self._slides * now[:, None]
        steps = self._origins @ moves
        # The last one is the root's.
        of_links = np.tile(np.eye(4), (len(now) + 1, 1, 1))
        for place, parent in enumerate(self._parents):
            of_links[place] = of_links[parent] @ steps[place]
        return np.asarray(of_links[self._links] @ self._offsets)


def _followed(
    path: Path, tree: Sequence[UrdfJoint], names: Sequence[str]
) -> list[tuple[int, float, float]]:
    """For each joint the place of the value that it follows, a factor and a constant.

    The place behind all values is that of a zero: joints at rest.
    """
    places = {name: place for place, name in enumerate(names)}
    joints = {joint.name: joint for joint in tree}
    known: dict[str, tuple[int, float, float]] = {}
    for joint in tree:
        chain = [joint]
        while chain[-1].name not in known:
            last = chain[-1]
            if last.kind not in MOVING or last.mimic is None:
                known[last.name] = places.get(last.name, len(names)), 1.0, 0.0
            elif last.mimic[0] not in joints:
                raise InputError(
                    f"cannot read '{path}': joint '{last.name}' mimics '{last.mimic[0]}', "
                    "which is not there"
                )
            elif len(chain) > len(tree):
                raise InputError(f"cannot read '{path}': joint '{joint.name}' mimics itself")
            else:
                chain.append(joints[last.mimic[0]])
        for follower in reversed(chain[:-1]):
            assert follower.mimic is not None
            leader, multiplier, offset = follower.mimic
            source, factor, constant = known[leader]
            known[follower.name] = source, multiplier * factor, multiplier * constant + offset
    return [known[joint.name] for joint in tree]
