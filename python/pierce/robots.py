"""Robots of URDF and MJCF files: their collision shapes as meshes, posed by joint values.

    robot = pierce.robots.read_robot("ur5e.xml")
    bodies = robot.add_to(world)
    bodies.set({"elbow_joint": 1.2})
    contacts = world.detect()

MJCF is read by MuJoCo, which places the links, too.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ._core import BodyId, Filter, InputError, MeshId, World
from ._poses import matrix_of, poses_of
from .files import Triangles, Vertices

Floats = NDArray[np.float64]
Values = ArrayLike | Mapping[str, Any] | None

__all__ = ["Robot", "RobotBodies", "RobotMesh", "RobotShape", "read_robot"]


@dataclass(frozen=True, eq=False)
class RobotMesh:
    """A mesh that shapes of a robot share.

    name: of the mesh, or of the kind of simple shape.
    vertices: float32 (n, 3). triangles: uint32 (m, 3).
    file: the file that it was read from; None: it was made here, or by MuJoCo.
    """

    name: str
    vertices: Vertices
    triangles: Triangles
    file: Path | None = None

    @property
    def mesh(self) -> tuple[Vertices, Triangles]:
        """What `World.add_mesh()` takes."""
        return self.vertices, self.triangles


@dataclass(frozen=True)
class RobotShape:
    """One collision shape: it becomes one body.

    name: in the file, or the link's and a number.
    link: its link, by name; in MJCF a body.
    mesh: its place in `Robot.meshes`.
    """

    name: str
    link: str
    mesh: int


@dataclass(frozen=True, eq=False)
class Robot:
    """What a robot's file says of its collision shapes.

    name: of the robot.
    meshes, shapes: see there.
    joints: where each joint's values are among all values, by name.
    rest: all values as the file has them, float64 (k,).
    meets: which shapes may meet each other, bool (n, n).
    notes: what was left out, and what is not as in the files, in sentences.
    """

    name: str
    meshes: tuple[RobotMesh, ...]
    shapes: tuple[RobotShape, ...]
    joints: dict[str, slice]
    rest: Floats
    meets: NDArray[np.bool_]
    notes: tuple[str, ...]
    kinematics: Callable[[Floats], Floats] = field(repr=False)
    """From all values to where the meshes of the shapes are, matrices (n, 4, 4)."""

    def values(self, given: Values = None) -> Floats:
        """All joint values, float64 (k,).

        given: all of them, or some by the names of joints, the others being at rest.
        Raises ValueError for a wrong number of values and for one that is not finite, KeyError
        for an unknown joint.
        """
        if given is None:
            return self.rest.copy()
        if isinstance(given, Mapping):
            every = self.rest.copy()
            for joint, value in given.items():
                if joint not in self.joints:
                    raise KeyError(f"'{self.name}' has no joint '{joint}', but {[*self.joints]}")
                own = every[self.joints[joint]]
                numbers = np.asarray(value, np.float64)
                if numbers.size != len(own):
                    raise ValueError(
                        f"joint '{joint}' has {len(own)} values, got shape {numbers.shape}"
                    )
                own[:] = numbers.ravel()
        else:
            every = np.array(given, np.float64)
            if every.shape != self.rest.shape:
                raise ValueError(
                    f"'{self.name}' has {len(self.rest)} joint values, got shape {every.shape}"
                )
        if not np.isfinite(every).all():
            wrong = [name for name, own in self.joints.items() if not np.isfinite(every[own]).all()]
            raise InputError(f"'{self.name}': the values of joints {wrong} are not finite")
        return every

    def poses(self, values: Values = None, base: ArrayLike | None = None) -> Floats:
        """Poses of the shapes' meshes, float64 (n, 7): position and quaternion x y z w.

        values: of joints, see `values()`.
        base: where the robot's frame is, seven numbers or a matrix (4, 4); None: at the origin.
        """
        matrices = self.kinematics(self.values(values))
        if base is not None:
            matrices = matrix_of(base) @ matrices
        return poses_of(matrices)

    def add_to(
        self,
        world: World,
        values: Values = None,
        base: ArrayLike | None = None,
        chain: int = 0,
        **options: Any,
    ) -> RobotBodies:
        """Adds a rigid body for each shape.

        chain: 0: the shapes that may meet by the file may meet in the world (`meets`);
            another number: no two shapes meet, as they are of this chain (`Filter.chain`), which
            must be the robot's own.
        options: of `World.add_mesh()`, such as `inside`.

        What cannot be used is refused, and then the world is as it was.
        """
        poses, filter_of_all = self.poses(values, base), Filter(chain=chain)
        meshes: dict[int, MeshId] = {}
        bodies: list[BodyId] = []
        try:
            for place in sorted({shape.mesh for shape in self.shapes}):
                mesh = self.meshes[place]
                meshes[place] = world.add_mesh(mesh.mesh, mesh.name, **options)
            for shape, pose in zip(self.shapes, poses):
                bodies.append(world.add_rigid_body(meshes[shape.mesh], pose))
            if chain:
                for body in bodies:
                    world.set_filter(body, filter_of_all)
            else:
                for a, b in np.argwhere(np.triu(~self.meets, 1)):
                    world.exclude(bodies[a], bodies[b])
        except BaseException:
            for body in bodies:
                world.remove_body(body)
            for added in meshes.values():
                world.remove_mesh(added)
            raise
        return RobotBodies(self, world, bodies)


class RobotBodies:
    """The bodies of a robot in a world, in the order of its shapes."""

    def __init__(self, robot: Robot, world: World, bodies: Iterable[BodyId]) -> None:
        self.robot = robot
        self.world = world
        self.bodies = list(bodies)
        self._ids = np.array([int(body) for body in self.bodies], np.uint64)
        self._shapes = dict(zip(self.bodies, robot.shapes))

    def set(self, values: Values = None, base: ArrayLike | None = None) -> None:
        """Moves all bodies to where joint values, and the robot's frame, have them."""
        self.world.set_poses(self._ids, self.robot.poses(values, base))

    def shape(self, body: BodyId | int) -> RobotShape | None:
        """The shape of a body, or of a handle in `Contacts.a`; None: it is not of this robot."""
        return self._shapes.get(body if isinstance(body, BodyId) else BodyId(int(body)))


def read_robot(
    path: str | Path,
    shapes: str = "collision",
    packages: Mapping[str, str | Path] | None = None,
) -> Robot:
    """Reads a robot: `.urdf` as URDF, anything else as MJCF by MuJoCo.

    shapes: "collision", "visual" or "all"; in MJCF, shapes that can be in contact are for
        collision, and the others are visual.
    packages: folders of "package://NAME/..." in URDF; others are looked for around the file, by
        the names of folders and by what `package.xml` says.

    Meshes have the triangles of their files, in their order, with vertices at the same position
    joined.
    Boxes, spheres, cylinders, capsules and ellipsoids become triangles; planes and height fields
    are left out, with a warning.
    Raises InputError for what cannot be read, with the file and what is wrong in it.
    """
    path = Path(path)
    if not path.is_file():
        raise InputError(f"cannot open '{path}'")
    if shapes not in ("collision", "visual", "all"):
        raise ValueError(f"shapes: expected collision, visual or all, got '{shapes}'")
    try:
        if path.suffix.lower() == ".urdf":
            from ._urdf import read_urdf

            robot, left_out = read_urdf(path, shapes, packages or {})
        else:
            from ._mjcf import read_mjcf

            robot, left_out = read_mjcf(path, shapes)
        _check_finite(robot)
    except (ImportError, InputError):
        raise
    except Exception as error:  # each library has its own
        raise InputError(f"cannot read '{path}': {error}") from error
    if not robot.shapes:
        warnings.warn(f"'{path}' holds no shapes of the kind '{shapes}'", stacklevel=2)
    if left_out:
        warnings.warn(f"'{path}': left out: {', '.join(left_out)}", stacklevel=2)
    return robot


def _check_finite(robot: Robot) -> None:
    for mesh in robot.meshes:
        if not np.isfinite(mesh.vertices).all():
            raise ValueError(f"mesh '{mesh.name}' has positions that are not finite")
    for shape, place in zip(robot.shapes, robot.kinematics(robot.rest)):
        if not np.isfinite(place).all():
            raise ValueError(f"shape '{shape.name}' is at no finite place")
