"""Recordings as animated glTF (`.glb`), for Blender, three.js and model viewers.

recording = pierce.Recording.read("pile")
pierce.gltf.write_animation("pile.glb", recording, pierce.gltf.replay(recording))
"""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ._core import Contacts, InputError, Recording
from ._frames import check_writable, deforms, per_frame
from ._frames import contacts_of as replay
from ._needs import need

__all__ = ["replay", "write_animation"]

_FLOAT, _UNSIGNED = 5126, 5125
_POINTS, _LINES = 0, 1
_VERTICES, _INDICES = 34962, 34963
_TURN = {"y": [0.0, 0.0, 0.0, 1.0], "z": [-(0.5**0.5), 0.0, 0.0, 0.5**0.5]}
_COLORS = {"body": [0.75, 0.75, 0.75, 1.0], "contact": [0.84, 0.37, 0.0, 1.0]}


def write_animation(
    path: str | Path,
    recording: Recording,
    contacts: Iterable[Contacts] | None = None,
    up: str = "z",
) -> None:
    """Writes the bodies of a recording as nodes that move, and contacts.

    path: ends in `.glb`.
    contacts: those of each frame, as `replay()` finds them: points half way between their two
        points, and lines along their normals, as long as they are deep; None: none.
    up: "z" or "y", the axis of the recording that points up; glTF's is y, and the nodes are
        children of one that turns them.

    A rigid body has a track of translations and one of rotations, with a key for each frame.
    A deforming body has a morph target for each frame; a track of weights goes from one to the
    next, so the file has all positions, and between two frames vertices go straight.
    Frames in which a body's place is not finite have no key in its tracks.
    The contacts of a frame are a node of their own, whose scale is 0 in all other frames.
    pygltflib writes the file.

    Raises InputError for a body whose mesh changes, which glTF cannot say, for contacts of too few
    frames, for a name that no file may have, and for a recording without bodies.
    """
    if up not in _TURN:
        raise ValueError(f"up: expected y or z, got '{up}'")
    path = Path(path)
    check_writable(recording, path, ".glb")
    writer = _Writer(need("pygltflib", "pygltflib", "writing glTF"), recording, up)
    steps = () if contacts is None else per_frame(recording, contacts)
    for body, name in enumerate(recording.body_names):
        if deforms(recording, body):
            writer.add_deforming(body, name)
        else:
            writer.add_rigid(body, name)
    for frame, found in enumerate(steps):
        if len(found):
            writer.add_contacts(frame, found)
    writer.save(path)


class _Writer:
    """Collects arrays, nodes and tracks."""

    def __init__(self, lib: Any, recording: Recording, up: str) -> None:
        self._lib, self._recording = lib, recording
        self._blob = bytearray()
        self._meshes: dict[tuple[bytes, bytes], int] = {}
        root = lib.Node(name="recording", rotation=_TURN[up], children=[])
        self._file = lib.GLTF2(
            asset=lib.Asset(version="2.0", generator="pierce"),
            scene=0,
            scenes=[lib.Scene(nodes=[0])],
            nodes=[root],
            animations=[lib.Animation(name="recording")],
            materials=[
                lib.Material(
                    name=name,
                    doubleSided=True,
                    pbrMetallicRoughness=lib.PbrMetallicRoughness(
                        baseColorFactor=color, metallicFactor=0.0
                    ),
                )
                for name, color in _COLORS.items()
            ],
        )

    def add_rigid(self, body: int, name: str) -> None:
        poses = np.asarray(self._recording.motion(body), np.float64)
        usable = np.isfinite(poses).all(1) & poses[:, 3:].any(1)
        frames = np.flatnonzero(usable)
        poses = poses[frames]
        rest, triangles = self._recording.mesh(body)
        mesh = self._shared(name, rest, triangles)
        if not len(frames):
            return
        turns = _near(poses[:, 3:] / np.linalg.norm(poses[:, 3:], axis=1, keepdims=True))
        node = self._node(name, mesh)
        self._file.nodes[node].translation = poses[0, :3].tolist()
        self._file.nodes[node].rotation = turns[0].tolist()
        if len(frames) > 1:
            times = self._times(frames)
            self._track(node, "translation", times, self._array(poses[:, :3], "VEC3"))
            self._track(node, "rotation", times, self._array(turns, "VEC4"))

    def add_deforming(self, body: int, name: str) -> None:
        recording = self._recording
        rest, triangles = recording.mesh(body)
        positions = []
        for frame in range(recording.frame_count):
            if not np.array_equal(recording.mesh(body, frame)[1], triangles):
                raise InputError(
                    f"body '{name}' has another mesh from frame {frame} on: "
                    "glTF has no mesh that changes"
                )
            positions.append(np.asarray(recording.positions(body, frame), np.float32))
        frames = [k for k, each in enumerate(positions) if np.isfinite(each).all()]
        if not frames:
            return
        base = positions[frames[0]]
        moves = [positions[frame] - base for frame in frames[1:]]
        mesh = self._mesh(name, base, triangles)
        targets = [{"POSITION": self._array(move, "VEC3", _VERTICES)} for move in moves]
        self._file.meshes[mesh].primitives[0].targets = targets or None
        self._file.meshes[mesh].weights = [0.0] * len(targets) or None
        node = self._node(name, mesh)
        if targets:
            weights = np.eye(len(frames), dtype=np.float32)[:, 1:]
            times = self._times(np.array(frames))
            self._track(node, "weights", times, self._array(weights.ravel(), "SCALAR"))

    def add_contacts(self, frame: int, contacts: Contacts) -> None:
        records = contacts.records
        middle = (records["point_a"] + records["point_b"]) / 2
        ends = middle + records["normal"] * np.asarray(contacts.depth)[:, None]
        lines = np.stack([middle, ends], 1).reshape(-1, 3)
        primitives = [
            self._primitive(points, mode) for points, mode in ((middle, _POINTS), (lines, _LINES))
        ]
        node = self._node(f"contacts {frame}", self._add_mesh(f"contacts {frame}", primitives))
        last = self._recording.frame_count - 1
        keys = sorted({0, frame, min(frame + 1, last)})
        scales = [[float(key == frame)] * 3 for key in keys]
        self._file.nodes[node].scale = scales[0]
        if last:
            times, values = self._times(np.array(keys)), self._array(np.array(scales), "VEC3")
            self._track(node, "scale", times, values, "STEP")

    def save(self, path: Path) -> None:
        file = self._file
        if not file.animations[0].channels:
            file.animations = []
        if not self._blob:  # glTF has no empty buffers
            raise InputError("the recording has no body with a place")
        file.buffers = [self._lib.Buffer(byteLength=len(self._blob))]
        file.set_binary_blob(bytes(self._blob))
        file.save_binary(str(path))

    def _shared(self, name: str, vertices: NDArray[Any], triangles: NDArray[Any]) -> int:
        """The mesh, once for all bodies that have it."""
        key = vertices.tobytes(), triangles.tobytes()
        if key not in self._meshes:
            self._meshes[key] = self._mesh(name, vertices, triangles)
        return self._meshes[key]

    def _mesh(self, name: str, vertices: NDArray[Any], triangles: NDArray[Any]) -> int:
        primitive = self._lib.Primitive(
            attributes=self._lib.Attributes(POSITION=self._array(vertices, "VEC3", _VERTICES)),
            indices=self._array(triangles.ravel().astype(np.uint32), "SCALAR", _INDICES),
            material=0,
        )
        return self._add_mesh(name, [primitive])

    def _primitive(self, points: NDArray[Any], mode: int) -> Any:
        position = self._array(points, "VEC3", _VERTICES)
        attributes = self._lib.Attributes(POSITION=position)
        return self._lib.Primitive(attributes=attributes, mode=mode, material=1)

    def _add_mesh(self, name: str, primitives: list[Any]) -> int:
        self._file.meshes.append(self._lib.Mesh(name=name, primitives=primitives))
        return len(self._file.meshes) - 1

    def _node(self, name: str, mesh: int) -> int:
        self._file.nodes.append(self._lib.Node(name=name, mesh=mesh))
        node = len(self._file.nodes) - 1
        self._file.nodes[0].children.append(node)
        return node

    def _times(self, frames: NDArray[Any]) -> int:
        return self._array(frames * self._recording.dt, "SCALAR")

    def _track(
        self, node: int, what: str, times: int, values: int, between: str = "LINEAR"
    ) -> None:
        lib, animation = self._lib, self._file.animations[0]
        animation.samplers.append(
            lib.AnimationSampler(input=times, output=values, interpolation=between)
        )
        target = lib.AnimationChannelTarget(node=node, path=what)
        sampler = len(animation.samplers) - 1
        animation.channels.append(lib.AnimationChannel(sampler=sampler, target=target))

    def _array(self, values: NDArray[Any], shape: str, target: int | None = None) -> int:
        """Appends an array, float32 unless it is of uint32; returns its accessor."""
        kind = _UNSIGNED if values.dtype == np.uint32 else _FLOAT
        array = np.ascontiguousarray(values, np.uint32 if kind == _UNSIGNED else np.float32)
        view = self._lib.BufferView(
            buffer=0, byteOffset=len(self._blob), byteLength=array.nbytes, target=target
        )
        self._file.bufferViews.append(view)
        self._blob += array.tobytes()
        ends = array.reshape(len(array), -1)
        self._file.accessors.append(
            self._lib.Accessor(
                bufferView=len(self._file.bufferViews) - 1,
                componentType=kind,
                count=len(array),
                type=shape,
                min=ends.min(0).tolist(),
                max=ends.max(0).tolist(),
            )
        )
        return len(self._file.accessors) - 1


def _near(turns: NDArray[np.float64]) -> NDArray[np.float64]:
    """The same rotations by quaternions each of which is on the side of the one before."""
    flips = np.einsum("ij,ij->i", turns[1:], turns[:-1]) < 0
    signs = np.concatenate([[1.0], np.cumprod(np.where(flips, -1.0, 1.0))])
    return np.asarray(turns * signs[:, None])
