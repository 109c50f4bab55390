"""Robots of URDF files."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from . import _shapes
from ._poses import matrix_of, split
from ._urdf_file import STIFF, UrdfJoint, UrdfShape, read_urdf_file
from ._urdf_joints import UrdfKinematics, moving_joints, tree_of
from ._urdf_meshes import find_mesh
from .files import Triangles, Vertices, placed, read_parts
from .robots import Robot, RobotMesh, RobotShape

Floats = NDArray[np.float64]


def read_urdf(
    path: Path, shapes: str, packages: Mapping[str, str | Path]
) -> tuple[Robot, list[str]]:
    """The robot, and what was left out of it."""
    file = read_urdf_file(path, shapes)
    tree = tree_of(file, path)
    names = moving_joints(file.joints)
    reader = _Reader(path, packages)
    for link, given in file.links.items():
        for shape in given:
            reader.add(link, shape)
    links = [shape.link for shape in reader.shapes]
    stiff = [
        f"does not move: {joint.kind} joint '{joint.name}'"
        for joint in file.joints
        if joint.kind in STIFF
    ]
    robot = Robot(
        name=file.name,
        meshes=tuple(reader.meshes),
        shapes=tuple(reader.shapes),
        joints={name: slice(place, place + 1) for place, name in enumerate(names)},
        rest=np.zeros(len(names)),
        meets=_meets(list(file.links), tree, links),
        notes=(*(f"left out: {what}" for what in reader.left_out), *stiff),
        kinematics=UrdfKinematics(path, tree, names, links, reader.offsets),
    )
    return robot, reader.left_out


class _Reader:
    """Makes meshes and shapes of collisions and visuals."""

    def __init__(self, path: Path, packages: Mapping[str, str | Path]) -> None:
        self._path, self._packages = path, packages
        self._known: dict[tuple[str, str, tuple[float, ...]], list[tuple[int, Floats]]] = {}
        self.meshes: list[RobotMesh] = []
        self.shapes: list[RobotShape] = []
        self.offsets: list[Floats] = []
        self.left_out: list[str] = []

    def add(self, link: str, given: UrdfShape) -> None:
        if given.kind not in ("mesh", *_SIMPLE):
            self.left_out.append(
                f"a shape that is no mesh, box, sphere or cylinder, '{given.name}'"
            )
            return
        key = given.kind, given.file, given.size
        if key not in self._known:
            self._known[key] = [(self._keep(mesh), offset) for mesh, offset in self._made(given)]
        for place, offset in self._known[key]:
            self.shapes.append(RobotShape(given.name, link, place))
            self.offsets.append(given.origin @ offset)

    def _keep(self, mesh: RobotMesh) -> int:
        self.meshes.append(mesh)
        return len(self.meshes) - 1

    def _made(self, given: UrdfShape) -> Iterator[tuple[RobotMesh, Floats]]:
        """Meshes, and where they are in the shape's frame."""
        if given.kind != "mesh":
            yield RobotMesh(given.kind, *_SIMPLE[given.kind](given.size)), np.eye(4)
            return
        path = find_mesh(given.file, self._path, self._packages)
        scale = np.diag([*given.size, 1.0])
        for part in read_parts(path, weld=True):
            rigid, stretch = split(scale @ matrix_of(part.pose))
            yield RobotMesh(part.name, *placed(*part.mesh, stretch), path), rigid


def _sphere(size: Sequence[float]) -> tuple[Vertices, Triangles]:
    return _shapes.ellipsoid(size[0])


def _cylinder(size: Sequence[float]) -> tuple[Vertices, Triangles]:
    return _shapes.cylinder(*size)


_SIMPLE = {"box": _shapes.box, "sphere": _sphere, "cylinder": _cylinder}


def _meets(every: list[str], tree: Sequence[UrdfJoint], links: list[str]) -> NDArray[np.bool_]:
    """Shapes may meet unless their links are the same one, fixed to each other, or neighbours."""
    group = {link: place for place, link in enumerate(every)}
    for joint in tree:
        if joint.kind == "fixed":
            group[joint.child] = group[joint.parent]
    near = np.eye(len(every), dtype=bool)
    for joint in tree:
        a, b = group[joint.parent], group[joint.child]
        near[a, b] = near[b, a] = True
    own = np.array([group[link] for link in links], np.int64)
    return ~near[own[:, None], own]
