"""Shows the bodies of a world and its contacts in Rerun, Polyscope or Viser.

    viewer = pierce.viewers.Rerun(world, recording)  # or Polyscope(world), Viser(world, server)
    for step in range(100):
        ...  # set poses and positions
        world.detect()
        viewer.log(step, step / 60)

A contact is a point in the middle of its two points, and an arrow along its normal.
Points and arrows have a colour by depth, from dark blue to yellow, which the colour-blind can
tell apart.
"""

from __future__ import annotations

from collections.abc import Mapping
from importlib import import_module
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ._bodies import bodies_of
from ._core import BodyId, Contacts, InputError, MeshId, Motion, World
from ._poses import rotations_of

Floats = NDArray[np.float64]

# The colour map cividis, at equal distances.
_CIVIDIS = np.array(
    [[0, 34, 78], [53, 69, 108], [102, 105, 112], [148, 142, 119], [200, 184, 102], [254, 232, 56]],
    np.float64,
)
_BODY = (190, 190, 190)


class Viewer:
    """What the three viewers have in common.

    world: its bodies and contacts are shown; bodies may come, go and change their meshes.
        Bodies whose places are not finite, or have no rotation, are not shown: the world leaves
        them out, too.
    names: of bodies; the others are called "body" and their index.
        A body whose name another one has already is called by both, name and index.
    arrow_scale: length of an arrow / depth of its contact.
    point_radius: [length] of points; None: 1 % of the size of a usual body.
    deepest: [length] the depth that is yellow; None: the largest one so far.
    """

    def __init__(
        self,
        world: World,
        names: Mapping[BodyId, str] | None = None,
        arrow_scale: float = 1.0,
        point_radius: float | None = None,
        deepest: float | None = None,
    ) -> None:
        self.world = world
        self.names = dict(names or {})
        self.arrow_scale = arrow_scale
        self.point_radius = point_radius
        self.deepest = deepest
        self._largest = 0.0
        self._shown: dict[BodyId, MeshId] = {}
        self._names_of: dict[BodyId, str] = {}
        self._taken: set[str] = set()

    def log(
        self, step: int, seconds: float | None = None, contacts: Contacts | None = None
    ) -> None:
        """Shows the world as it is now.

        seconds: [s] simulated time; None: unknown.
        contacts: those to show; None: all of the last step.
        """
        self._set_time(step, seconds)
        bodies = self._bodies()
        for body in self._shown.keys() - set(bodies):
            self._hide(body)
        for body in bodies:
            self._log_body(body)
        self._log_contacts(self.world.contacts if contacts is None else contacts)

    def _bodies(self) -> list[BodyId]:
        """Those of the last step, or all if it is not known which took part."""
        try:
            return [box.body for box in self.world.body_boxes()]
        except InputError:
            return bodies_of(self.world)

    def _name(self, body: BodyId) -> str:
        if body not in self._names_of:
            name = self.names.get(body, f"body {body.index}")
            while name in self._taken:
                name = f"{name} {body.index}"
            self._names_of[body] = name
            self._taken.add(name)
        return self._names_of[body]

    def _hide(self, body: BodyId) -> None:
        if body in self._shown:
            name = self._names_of.pop(body)
            self._taken.remove(name)
            self._remove_body(name)
            del self._shown[body]

    def _log_body(self, body: BodyId) -> None:
        mesh = self.world.mesh_of(body)
        triangles: Any = self.world.mesh(mesh).triangles
        if self.world.motion_of(body) == Motion.deforming:
            vertices = self.world.vertex_positions(body).astype(np.float32)
            if not np.isfinite(vertices).all():
                self._hide(body)
                return
            self._set_mesh(self._name(body), vertices, triangles)
        else:
            pose = self.world.pose_of(body)
            position, quaternion = np.array(pose.position), np.array(pose.rotation)
            if not np.isfinite(position).all() or not 0 < quaternion @ quaternion < np.inf:
                self._hide(body)
                return
            name = self._name(body)
            if body not in self._shown or self._shown[body] != mesh:
                self._set_mesh(name, np.asarray(self.world.mesh(mesh).vertices), triangles)
            self._set_place(name, rotations_of(quaternion[None])[0], position)
        self._shown[body] = mesh

    def _log_contacts(self, contacts: Any) -> None:
        if len(contacts) == 0:
            self._remove_contacts()
            return
        depth = contacts.depth
        self._largest = max(self._largest, float(depth.max()))
        share = depth / max(self.deepest or self._largest, 1e-30)
        scale = np.linspace(0, 1, len(_CIVIDIS))
        colors = np.column_stack([np.interp(share, scale, channel) for channel in _CIVIDIS.T])
        points = (contacts.point_a + contacts.point_b) / 2
        arrows = contacts.normal * (depth * self.arrow_scale)[:, None]
        self._set_contacts(points, arrows, colors.astype(np.uint8), depth, self._radius())

    def _radius(self) -> float:
        """[length] of points."""
        if self.point_radius is None:
            sizes = [
                np.ptp(np.asarray(self.world.mesh(mesh).vertices), axis=0).max()
                for mesh in self._shown.values()
            ]
            self.point_radius = 0.01 * float(np.median(sizes))
        return self.point_radius

    def _set_time(self, step: int, seconds: float | None) -> None:
        """Viewers without time lines show the present only."""

    def _set_mesh(self, name: str, vertices: NDArray[Any], triangles: NDArray[Any]) -> None:
        raise NotImplementedError

    def _set_place(self, name: str, rotation: Floats, translation: Floats) -> None:
        raise NotImplementedError

    def _remove_body(self, name: str) -> None:
        raise NotImplementedError

    def _set_contacts(
        self,
        points: Floats,
        arrows: Floats,
        colors: NDArray[np.uint8],
        depth: Floats,
        radius: float,
    ) -> None:
        raise NotImplementedError

    def _remove_contacts(self) -> None:
        raise NotImplementedError


class Rerun(Viewer):
    """Logs into a `rerun.RecordingStream`; None: the one that is current.

    Bodies are at `root`/bodies, contacts at `root`/contacts; time lines are step and sim_time.
    The number of contacts and the largest depth are plots at `root`/plots.
    """

    def __init__(
        self, world: World, recording: Any = None, root: str = "pierce", **options: Any
    ) -> None:
        super().__init__(world, **options)
        self._rr = _need("rerun", "rerun-sdk")
        self.recording = recording or self._rr.get_data_recording()
        if self.recording is None:
            raise ValueError("there is no current recording: give one, or call rerun.init() first")
        self.root = root

    def _log(self, path: tuple[str, ...], *what: Any) -> None:
        self.recording.log([self.root, *path], *what)

    def _set_time(self, step: int, seconds: float | None) -> None:
        self.recording.set_time("step", sequence=step)
        if seconds is not None:
            self.recording.set_time("sim_time", duration=seconds)

    def _set_mesh(self, name: str, vertices: NDArray[Any], triangles: NDArray[Any]) -> None:
        self._log(
            ("bodies", name),
            self._rr.Mesh3D(
                vertex_positions=vertices, triangle_indices=triangles, albedo_factor=_BODY
            ),
        )

    def _set_place(self, name: str, rotation: Floats, translation: Floats) -> None:
        self._log(("bodies", name), self._rr.Transform3D(mat3x3=rotation, translation=translation))

    def _remove_body(self, name: str) -> None:
        self._log(("bodies", name), self._rr.Clear(recursive=True))

    def _set_contacts(
        self,
        points: Floats,
        arrows: Floats,
        colors: NDArray[np.uint8],
        depth: Floats,
        radius: float,
    ) -> None:
        self._log(("contacts", "points"), self._rr.Points3D(points, radii=radius, colors=colors))
        self._log(
            ("contacts", "normals"),
            self._rr.Arrows3D(origins=points, vectors=arrows, radii=radius / 3, colors=colors),
        )
        self._plot(len(points), float(depth.max()))

    def _remove_contacts(self) -> None:
        self._log(("contacts",), self._rr.Clear(recursive=True))
        self._plot(0, 0.0)

    def _plot(self, count: int, depth: float) -> None:
        self._log(("plots", "contacts"), self._rr.Scalars(count))
        self._log(("plots", "largest depth"), self._rr.Scalars(depth))


class Polyscope(Viewer):
    """Shows the world in Polyscope's window; call polyscope.frame_tick() or show() after log().

    Polyscope is initialized if it is not yet, with transparency "pretty": contacts are inside of
    bodies. Arrows have one colour.
    """

    def __init__(self, world: World, **options: Any) -> None:
        super().__init__(world, **options)
        self._ps = _need("polyscope", "polyscope")
        if not self._ps.is_initialized():
            self._ps.init()
            self._ps.set_transparency_mode("pretty")
        self._triangles: dict[str, NDArray[Any]] = {}

    def _set_mesh(self, name: str, vertices: NDArray[Any], triangles: NDArray[Any]) -> None:
        if self._ps.has_surface_mesh(name):
            mesh = self._ps.get_surface_mesh(name)
            same = np.array_equal(self._triangles.get(name, ()), triangles)
            if same and mesh.n_vertices() == len(vertices):
                mesh.update_vertex_positions(vertices)
                return
        self._ps.register_surface_mesh(
            name, vertices, triangles, transparency=0.3, color=tuple(part / 255 for part in _BODY)
        )
        self._triangles[name] = triangles

    def _set_place(self, name: str, rotation: Floats, translation: Floats) -> None:
        place = np.eye(4)
        place[:3, :3], place[:3, 3] = rotation, translation
        self._ps.get_surface_mesh(name).set_transform(place)

    def _remove_body(self, name: str) -> None:
        self._ps.remove_surface_mesh(name)

    def _set_contacts(
        self,
        points: Floats,
        arrows: Floats,
        colors: NDArray[np.uint8],
        depth: Floats,
        radius: float,
    ) -> None:
        cloud = self._ps.register_point_cloud("contacts", points)
        cloud.set_radius(radius, relative=False)
        cloud.add_scalar_quantity("depth", depth)
        cloud.add_color_quantity("color", colors / 255, enabled=True)
        cloud.add_vector_quantity(
            "normal",
            arrows,
            enabled=True,
            vectortype="ambient",
            radius=radius / 3,
            color=(0.84, 0.37, 0.0),
        )

    def _remove_contacts(self) -> None:
        self._ps.remove_point_cloud("contacts", error_if_absent=False)


class Viser(Viewer):
    """Shows the world on a `viser.ViserServer`; None: a new one, which is `server`."""

    def __init__(self, world: World, server: Any = None, **options: Any) -> None:
        super().__init__(world, **options)
        self._viser = _need("viser", "viser")
        self.server = server or self._viser.ViserServer()
        self._handles: dict[str, Any] = {}

    def _set_mesh(self, name: str, vertices: NDArray[Any], triangles: NDArray[Any]) -> None:
        path = self._path(name)
        self._handles[path] = self.server.scene.add_mesh_simple(
            path, vertices, triangles, color=_BODY, opacity=0.6
        )

    def _set_place(self, name: str, rotation: Floats, translation: Floats) -> None:
        body = self._handles[self._path(name)]
        body.wxyz = self._viser.transforms.SO3.from_matrix(rotation).wxyz
        body.position = translation

    def _remove_body(self, name: str) -> None:
        self._handles.pop(self._path(name)).remove()

    @staticmethod
    def _path(name: str) -> str:
        # A slash would make the body a part of another one, which moves with it.
        return "/bodies/" + name.replace("/", "\N{DIVISION SLASH}")

    def _set_contacts(
        self,
        points: Floats,
        arrows: Floats,
        colors: NDArray[np.uint8],
        depth: Floats,
        radius: float,
    ) -> None:
        scene = self.server.scene
        self._handles["/contacts/points"] = scene.add_point_cloud(
            "/contacts/points",
            points,
            colors=colors,
            point_size=2 * radius,
            precision="float32",
            point_shape="circle",
        )
        self._handles["/contacts/normals"] = scene.add_arrows(
            "/contacts/normals",
            np.stack([points, points + arrows], 1),
            colors=colors,
            shaft_radius=radius / 3,
            head_radius=radius,
            head_length=2 * radius,
        )

    def _remove_contacts(self) -> None:
        for path in ("/contacts/points", "/contacts/normals"):
            if path in self._handles:
                self._handles.pop(path).remove()


def _need(module: str, package: str) -> Any:
    try:
        return import_module(module)
    except ImportError as error:
        raise ImportError(f"this viewer needs {module}: pip install {package}") from error
