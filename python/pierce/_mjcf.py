"""Robots of MJCF files, by MuJoCo."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from threading import Lock
from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import _shapes
from ._needs import need
from ._poses import inverse
from .files import Part, Triangles, Vertices, placed, read_parts
from .robots import Robot, RobotMesh, RobotShape

Floats = NDArray[np.float64]
_File = tuple[Path, Floats, Floats | None]

_ROUNDING = 1e-5
"""[size of a mesh] MuJoCo turns meshes into their axes of inertia, in float32."""


def read_mjcf(path: Path, shapes: str) -> tuple[Robot, list[str]]:
    """The robot, and what was left out of it."""
    mj = need("mujoco", "mujoco", "reading MJCF")
    spec = mj.MjSpec.from_file(str(path))
    model = spec.compile()
    reader = _Reader(mj, model, _files(mj, spec, path))
    geoms = [geom for geom in range(model.ngeom) if shapes in ("all", reader.purpose(geom))]
    for geom in geoms:
        reader.add(geom)
    if model.nflex or model.nskin:
        reader.left_out.append(f"{model.nflex} flexes and {model.nskin} skins")
    notes = [f"left out: {what}" for what in reader.left_out]
    notes += [f"mesh '{name}' is as MuJoCo made it, not as in a file" for name in reader.compiled]
    robot = Robot(
        name=str(spec.modelname or path.stem),
        meshes=tuple(reader.meshes),
        shapes=tuple(reader.shapes),
        joints=_joints(mj, model),
        rest=model.qpos0.copy(),
        meets=_meets(model, reader.geoms),
        notes=tuple(notes),
        kinematics=_Kinematics(mj, model, reader.geoms, reader.offsets),
    )
    return robot, reader.left_out


class _Kinematics:
    """Where meshes are, by MuJoCo. Threads may share it."""

    def __init__(self, mj: Any, model: Any, geoms: list[int], offsets: list[Floats]) -> None:
        self._mj, self._model, self._data = mj, model, mj.MjData(model)
        self._in_use = Lock()
        self._geoms = geoms
        self._offsets = np.array(offsets).reshape(-1, 4, 4)

    def __call__(self, values: Floats) -> Floats:
        matrices = np.tile(np.eye(4), (len(self._geoms), 1, 1))
        with self._in_use:
            self._data.qpos[:] = values
            self._mj.mj_kinematics(self._model, self._data)
            matrices[:, :3, :3] = self._data.geom_xmat[self._geoms].reshape(-1, 3, 3)
            matrices[:, :3, 3] = self._data.geom_xpos[self._geoms]
        return matrices @ self._offsets


class _Reader:
    """Makes meshes and shapes of geoms."""

    def __init__(self, mj: Any, model: Any, files: dict[int, _File]) -> None:
        self._mj, self._model, self._files = mj, model, files
        self._paired = {int(geom) for geom in (*model.pair_geom1, *model.pair_geom2)}
        self._known: dict[Any, tuple[int, Floats]] = {}
        self.meshes: list[RobotMesh] = []
        self.shapes: list[RobotShape] = []
        self.geoms: list[int] = []
        self.offsets: list[Floats] = []
        self.left_out: list[str] = []
        self.compiled: list[str] = []

    def purpose(self, geom: int) -> str:
        masks = self._model.geom_contype[geom] | self._model.geom_conaffinity[geom]
        return "collision" if masks or geom in self._paired else "visual"

    def add(self, geom: int) -> None:
        model, kinds = self._model, self._mj.mjtGeom
        kind, size = int(model.geom_type[geom]), tuple(map(float, model.geom_size[geom]))
        link = model.body(model.geom_bodyid[geom]).name
        name = (
            model.geom(geom).name or f"{link}/{geom - model.body_geomadr[model.geom_bodyid[geom]]}"
        )
        if kind in (kinds.mjGEOM_MESH, kinds.mjGEOM_SDF) and model.geom_dataid[geom] >= 0:
            mesh = int(model.geom_dataid[geom])
            if mesh not in self._known:
                made, offset = self._mesh(mesh)
                self._known[mesh] = self._keep(made), offset
            place, offset = self._known[mesh]
        elif kind in self._simple():
            if (kind, size) not in self._known:
                title, make = self._simple()[kind]
                self._known[kind, size] = self._keep(RobotMesh(title, *make(size))), np.eye(4)
            place, offset = self._known[kind, size]
        else:
            title = kinds(kind).name.removeprefix("mjGEOM_").lower()
            self.left_out.append(f"{title} '{name}'")
            return
        self.shapes.append(RobotShape(name, link, place))
        self.geoms.append(geom)
        self.offsets.append(offset)

    def _keep(self, mesh: RobotMesh) -> int:
        self.meshes.append(mesh)
        return len(self.meshes) - 1

    def _simple(self) -> dict[int, tuple[str, Any]]:
        kinds = self._mj.mjtGeom
        return {
            int(kinds.mjGEOM_BOX): ("box", lambda size: _shapes.box(2 * np.array(size))),
            int(kinds.mjGEOM_SPHERE): ("sphere", lambda size: _shapes.ellipsoid(size[0])),
            int(kinds.mjGEOM_ELLIPSOID): ("ellipsoid", _shapes.ellipsoid),
            int(kinds.mjGEOM_CYLINDER): (
                "cylinder",
                lambda size: _shapes.cylinder(size[0], 2 * size[1]),
            ),
            int(kinds.mjGEOM_CAPSULE): (
                "capsule",
                lambda size: _shapes.capsule(size[0], 2 * size[1]),
            ),
        }

    def _mesh(self, mesh: int) -> tuple[RobotMesh, Floats]:
        """The mesh, and where it is in the frame of its geoms.

        It is that of the file, unless MuJoCo has made other triangles of it.
        """
        model, name = self._model, self._model.mesh(mesh).name
        vertices = model.mesh_vert[model.mesh_vertadr[mesh] :][: model.mesh_vertnum[mesh]]
        triangles = model.mesh_face[model.mesh_faceadr[mesh] :][: model.mesh_facenum[mesh]]
        axes = np.eye(4)
        turn = np.empty(9)
        self._mj.mju_quat2Mat(turn, model.mesh_quat[mesh])
        axes[:3, :3], axes[:3, 3] = turn.reshape(3, 3), model.mesh_pos[mesh]
        offset = inverse(axes)
        path, frame, stretch = self._files.get(mesh, (None, np.eye(4), None))
        for part in _candidates(path):
            found = placed(part.vertices, part.triangles, stretch)
            if _agree(found, offset @ frame, vertices[triangles]):
                return RobotMesh(name, *found, path), offset @ frame
        self.compiled.append(name)
        return RobotMesh(name, vertices.copy(), triangles.astype(np.uint32)), np.eye(4)


def _agree(mesh: tuple[Vertices, Triangles], offset: Floats, corners: NDArray[Any]) -> bool:
    """The mesh has these corners (m, 3, 3), but for rounding."""
    vertices, triangles = mesh
    if len(triangles) != len(corners) or not len(corners):
        return False
    moved = (vertices @ offset[:3, :3].T + offset[:3, 3])[triangles]
    return bool(np.abs(moved - corners).max() <= _ROUNDING * np.ptp(vertices, axis=0).max())


def _candidates(path: Path | None) -> Iterator[Part]:
    """What of a file may be MuJoCo's mesh: all of it, or its first group."""
    if path is None or path.suffix.lower() not in (".obj", ".stl"):
        return
    yield from read_parts(path, weld=True)
    if path.suffix.lower() == ".obj":
        yield read_parts(path, groups=True, weld=True)[0]


def _files(mj: Any, spec: Any, path: Path) -> dict[int, _File]:
    """Files of meshes by the meshes' ids, as far as there are files."""
    folder = Path(spec.modelfiledir or path.parent) / spec.meshdir
    found = {}
    for mesh in spec.meshes:
        if mesh.file and (folder / mesh.file).is_file():
            found[int(mesh.id)] = folder / mesh.file, *_reference(mj, mesh)
    return found


def _reference(mj: Any, mesh: Any) -> tuple[Floats, Floats | None]:
    """Frame and stretch of a mesh: MuJoCo takes refpos and refquat off, then it scales."""
    numbers = np.empty(9)
    mj.mju_quat2Mat(numbers, mesh.refquat / np.linalg.norm(mesh.refquat))
    turn = numbers.reshape(3, 3)
    scale = np.diag(mesh.scale)
    frame = np.eye(4)
    frame[:3, :3], frame[:3, 3] = turn.T, -scale @ turn.T @ mesh.refpos
    if (scale == np.eye(3)).all():
        return frame, None
    uniform = (mesh.scale == mesh.scale[0]).all() or (turn == np.eye(3)).all()
    return frame, scale if uniform else turn @ scale @ turn.T


def _joints(mj: Any, model: Any) -> dict[str, slice]:
    """Where each joint's values are; "joint 3" is one without a name, unless another has it."""
    counts = {mj.mjtJoint.mjJNT_FREE: 7, mj.mjtJoint.mjJNT_BALL: 4}
    given = {model.joint(joint).name for joint in range(model.njnt)}
    joints = {}
    for joint in range(model.njnt):
        first = int(model.jnt_qposadr[joint])
        count = counts.get(mj.mjtJoint(model.jnt_type[joint]), 1)
        name = model.joint(joint).name
        if not name:
            name = f"joint {joint}"
            while name in given:
                name += "'"
        joints[name] = slice(first, first + count)
    return joints


def _meets(model: Any, geoms: list[int]) -> NDArray[np.bool_]:
    """Which shapes MuJoCo lets meet, also those of a <pair>."""
    from .mujoco import _meeting_pairs

    meets = _meeting_pairs(model, np.array(geoms, np.int64))
    places = {geom: place for place, geom in enumerate(geoms)}
    for pair in zip(model.pair_geom1, model.pair_geom2):
        a, b = (places.get(int(geom)) for geom in pair)
        if a is not None and b is not None:
            meets[a, b] = meets[b, a] = True
    return meets
