"""Robots of URDF files, by yourdfpy."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import _shapes
from ._core import InputError
from ._needs import need
from ._poses import matrix_of, split
from .files import Triangles, Vertices, placed, read_parts
from .robots import Robot, RobotMesh, RobotShape

Floats = NDArray[np.float64]


def read_urdf(
    path: Path, shapes: str, packages: Mapping[str, str | Path]
) -> tuple[Robot, list[str]]:
    """The robot, and what was left out of it."""
    yourdfpy = need("yourdfpy", "yourdfpy", "reading URDF")
    try:
        urdf = yourdfpy.URDF.load(str(path), load_meshes=False)
    except Exception as error:
        raise InputError(f"cannot read '{path}': {error}") from error
    reader = _Reader(path, urdf, packages)
    for link in urdf.robot.links:
        collisions = [] if shapes == "visual" else link.collisions
        visuals = [] if shapes == "collision" else link.visuals
        for given in (*collisions, *visuals):
            reader.add(link.name, given)
    names = urdf.actuated_joint_names
    stiff = [
        f"does not move: {joint.type} joint '{joint.name}'"
        for joint in urdf.robot.joints
        if joint.type in ("floating", "planar")
    ]
    robot = Robot(
        name=urdf.robot.name or path.stem,
        meshes=tuple(reader.meshes),
        shapes=tuple(reader.shapes),
        joints={name: slice(place, place + 1) for place, name in enumerate(names)},
        rest=np.zeros(len(names)),
        meets=_meets(urdf.robot, [shape.link for shape in reader.shapes]),
        notes=(*(f"left out: {what}" for what in reader.left_out), *stiff),
        kinematics=_Kinematics(urdf, [shape.link for shape in reader.shapes], reader.offsets),
    )
    return robot, reader.left_out


class _Kinematics:
    """Where meshes are, by yourdfpy."""

    def __init__(self, urdf: Any, links: list[str], offsets: list[Floats]) -> None:
        self._urdf, self._links = urdf, links
        self._offsets = np.array(offsets).reshape(-1, 4, 4)

    def __call__(self, values: Floats) -> Floats:
        self._urdf.update_cfg(dict(zip(self._urdf.actuated_joint_names, values.tolist())))
        of_link = {link: self._urdf.get_transform(link) for link in set(self._links)}
        matrices = np.array([of_link[link] for link in self._links], np.float64)
        return matrices.reshape(-1, 4, 4) @ self._offsets


class _Reader:
    """Makes meshes and shapes of collisions and visuals."""

    def __init__(self, path: Path, urdf: Any, packages: Mapping[str, str | Path]) -> None:
        self._path, self._urdf, self._packages = path, urdf, packages
        self._known: dict[Any, list[tuple[int, Floats]]] = {}
        self._count: dict[str, int] = {}
        self.meshes: list[RobotMesh] = []
        self.shapes: list[RobotShape] = []
        self.offsets: list[Floats] = []
        self.left_out: list[str] = []

    def add(self, link: str, given: Any) -> None:
        number = self._count.get(link, 0)
        self._count[link] = number + 1
        name = given.name or f"{link}/{number}"
        origin = np.eye(4) if given.origin is None else np.asarray(given.origin, np.float64)
        key = _key(given.geometry)
        if key is None:
            self.left_out.append(f"a shape that is no mesh, box, sphere or cylinder, '{name}'")
            return
        if key not in self._known:
            self._known[key] = [
                (self._keep(mesh), offset) for mesh, offset in self._made(given.geometry)
            ]
        for place, offset in self._known[key]:
            self.shapes.append(RobotShape(name, link, place))
            self.offsets.append(origin @ offset)

    def _keep(self, mesh: RobotMesh) -> int:
        self.meshes.append(mesh)
        return len(self.meshes) - 1

    def _made(self, geometry: Any) -> Iterator[tuple[RobotMesh, Floats]]:
        """Meshes, and where they are in the shape's frame."""
        if geometry.mesh is None:
            yield RobotMesh(*_simple(geometry)), np.eye(4)
            return
        path = self._file(geometry.mesh.filename)
        scale = np.eye(4)
        if geometry.mesh.scale is not None:
            scale[:3, :3] = np.diag(np.broadcast_to(geometry.mesh.scale, 3))
        for part in read_parts(path, weld=True):
            rigid, stretch = split(scale @ matrix_of(part.pose))
            yield RobotMesh(part.name, *placed(*part.mesh, stretch), path), rigid

    def _file(self, name: str) -> Path:
        if name.startswith("package://"):
            package, _, rest = name.removeprefix("package://").partition("/")
            if package in self._packages:
                return Path(self._packages[package]) / rest
        found = Path(self._urdf._filename_handler(fname=name))
        if not found.is_file():
            raise InputError(f"cannot find '{name}' of '{self._path}'; `packages` may name folders")
        return found


def _key(geometry: Any) -> Any:
    """The same for equal geometries; None: of no known kind."""
    if geometry is None:
        return None
    if geometry.mesh is not None:
        return geometry.mesh.filename, str(geometry.mesh.scale)
    for kind in ("box", "sphere", "cylinder"):
        if getattr(geometry, kind) is not None:
            return kind, str(getattr(geometry, kind))
    return None


def _simple(geometry: Any) -> tuple[str, Vertices, Triangles]:
    if geometry.box is not None:
        return "box", *_shapes.box(geometry.box.size)
    if geometry.sphere is not None:
        return "sphere", *_shapes.ellipsoid(geometry.sphere.radius)
    return "cylinder", *_shapes.cylinder(geometry.cylinder.radius, geometry.cylinder.length)


def _meets(robot: Any, links: list[str]) -> NDArray[np.bool_]:
    """Shapes may meet unless their links are the same one, fixed to each other, or neighbours."""
    group = {link.name: link.name for link in robot.links}

    def root(link: str) -> str:
        while group[link] != link:
            link = group[link]
        return link

    for joint in robot.joints:
        if joint.type == "fixed":
            group[root(joint.child)] = root(joint.parent)
    roots = sorted({root(link) for link in group})
    places = {name: place for place, name in enumerate(roots)}
    near = np.eye(len(roots), dtype=bool)
    for joint in robot.joints:
        a, b = places[root(joint.parent)], places[root(joint.child)]
        near[a, b] = near[b, a] = True
    own = np.array([places[root(link)] for link in links], np.int64)
    return ~near[own[:, None], own]
