"""Contacts between the true triangles of MuJoCo's mesh geoms.

MuJoCo takes the convex hull of a mesh, so linked rings fly apart and a bolt never enters a nut.
`MeshContacts` takes over the contacts between mesh geoms and leaves all others to MuJoCo:

    contacts = pierce.mujoco.MeshContacts(model)
    while data.time < 1:
        contacts.step(model, data)  # instead of mujoco.mj_step(model, data)
"""

from __future__ import annotations

from collections.abc import Iterable
from types import TracebackType
from typing import Any
from weakref import WeakSet

import numpy as np
from numpy.typing import NDArray

from ._core import Collision, Contacts, Filter, World, least_reduced

try:
    import mujoco as mj  # type: ignore[import-untyped]
except ImportError as error:
    raise ImportError("pierce.mujoco needs MuJoCo: pip install mujoco") from error

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

_MASKS = (
    "geom_contype",
    "geom_conaffinity",
    "body_contype",
    "body_conaffinity",
    "flex_conaffinity",
)
_REFUSED = {
    "mjENBL_OVERRIDE": "contact override",
    "mjENBL_SLEEP": "sleeping",
    "mjENBL_IPC": "IPC",
    "mjENBL_SPECULATIVE": "speculative contacts",
}


_alive: WeakSet[MeshContacts] = WeakSet()
"""Those that have changed the masks of their models."""


class MeshContacts:
    """Finds contacts between mesh geoms and gives them to MuJoCo.

    model: its masks are changed until `release()`, see below.
    geoms: names or ids of mesh geoms; None: all that can have contacts.
    margin: [length] contacts begin at this distance; None: margin and gap of the geoms, as in
        MuJoCo. Both are read once, here.
    most_per_pair: more contacts of a pair are reduced to so many, at least six, which can have
        the same total force and torque; None: all are kept.
    backend: of the `World` that finds the contacts.

    Which pairs meet is what the model says when this is made: contype and conaffinity, excluded
    bodies, bodies welded together, parents and children, and bodies that cannot move by themselves,
    as static ones and mocap bodies.
    Priority, solmix, friction, condim, solref, solimp and adhesion are mixed as MuJoCo does, at
    every step.

    A model has one MeshContacts at a time: `step()` knows of no others, and each restores the masks
    that it has found.

    MuJoCo's own contacts of these pairs are off, also in mj_step, until `release()` or the end
    of a `with` block.
    For that, each taken geom gets a contype of one bit that is free, and no conaffinity.
    The other geoms and flexes that it meets get that bit in their conaffinity.
    So a mesh geom keeps its contacts with the floor and with all else.
    Nothing but `geom_contype`, `geom_conaffinity`, `body_contype`, `body_conaffinity` and
    `flex_conaffinity` is written, and `release()` restores all five.

    ValueError is raised for what is not supported: the integrators RK4 and discrete, sleeping,
    IPC, speculative contacts, contact override, an implicit metric of flexes or tendons,
    surface velocities of taken geoms, and a <pair> of two taken geoms.
    """

    def __init__(
        self,
        model: mj.MjModel,
        geoms: Iterable[int | str] | None = None,
        margin: float | None = None,
        most_per_pair: int | None = 24,
        backend: str = "auto",
    ) -> None:
        if any(other.model is model for other in _alive):
            raise ValueError("another MeshContacts has geoms of this model: release() it first")
        if most_per_pair is not None and most_per_pair < least_reduced:
            raise ValueError(f"most_per_pair must be at least {least_reduced}, got {most_per_pair}")
        self.model: mj.MjModel = model
        self.geoms = _mesh_geoms(model, geoms)
        self.most_per_pair = most_per_pair
        _check_options(model)
        _check_geoms(model, self.geoms)
        meets = _meeting_pairs(model, self.geoms)
        if not meets.any():
            raise ValueError(
                "no two of these mesh geoms may have contacts with each other; "
                "perhaps a MeshContacts that was not released has them"
            )

        if margin is None:
            self._margin = model.geom_margin[self.geoms].copy()
            self._gap = model.geom_gap[self.geoms].copy()
        else:
            self._margin = np.full(len(self.geoms), margin / 2)
            self._gap = np.zeros(len(self.geoms))
        if not np.isfinite([self._margin, self._gap]).all():
            raise ValueError("margins and gaps must be finite")
        self.world = World(backend=backend)
        self._bodies = self._add_bodies(meets)
        self.contacts: Contacts = self.world.detect()  # type: ignore[assignment]

        self._before = {name: getattr(model, name).copy() for name in _MASKS}
        _switch_off(model, self.geoms)
        _alive.add(self)

    def _add_bodies(self, meets: NDArray[np.bool_]) -> NDArray[np.uint64]:
        model, meshes, bodies = self.model, {}, []
        welded = model.body_weldid[model.geom_bodyid[self.geoms]]
        for place, geom in enumerate(self.geoms):
            mesh = int(model.geom_dataid[geom])
            if mesh not in meshes:
                meshes[mesh] = self.world.add_mesh(_mesh(model, mesh), model.mesh(mesh).name)
            body = self.world.add_rigid_body(meshes[mesh])
            self.world.set_filter(body, Filter(chain=int(welded[place]) + 1))
            # Pierce takes the larger margin of a pair, MuJoCo the sum.
            reach = 2 * max(0.0, float(self._margin[place] + self._gap[place]))
            self.world.set_collision(body, Collision(margin=reach))
            bodies.append(body)
        for a, b in np.argwhere(np.triu(~meets & (welded[:, None] != welded), 1)):
            self.world.exclude(bodies[a], bodies[b])
        return np.array([int(body) for body in bodies], np.uint64)

    def detect(self, data: mj.MjData) -> Contacts:
        """Finds the contacts where `data.geom_xpos` and `data.geom_xmat` have the geoms.

        The result, also kept as `contacts`, has all of them: nothing is reduced.
        `geom_pairs()` says which geoms they are of.
        """
        poses = np.empty((len(self.geoms), 7))
        poses[:, :3] = data.geom_xpos[self.geoms]
        turn = np.empty(4)
        for pose, matrix in zip(poses, data.geom_xmat[self.geoms]):
            mj.mju_mat2Quat(turn, matrix)
            pose[3:] = turn[[1, 2, 3, 0]]  # MuJoCo has w first
        self.world.set_poses(self._bodies, poses)
        self.contacts = self.world.detect()  # type: ignore[assignment]
        return self.contacts

    def geom_pairs(self, contacts: Contacts) -> Ints:
        """Ids of the two geoms of each contact, int64 (n, 2)."""
        return self.geoms[self._places(contacts)]

    def add(self, model: mj.MjModel, data: mj.MjData) -> int:
        """Finds the contacts and appends them to `data.contact`; returns how many.

        It is called between mj_collision and mj_makeConstraint, as `forward()` does.
        Raises MemoryError if the arena of `data` is too small for all of them.
        """
        self._check(model)
        off = mj.mjtDisableBit.mjDSBL_CONSTRAINT | mj.mjtDisableBit.mjDSBL_CONTACT
        if model.opt.disableflags & off:
            return 0
        contacts = self.detect(data)
        places = self._places(contacts)
        distance = np.asarray(contacts.distance)
        margin = self._margin[places].sum(1)
        chosen = np.flatnonzero(distance < margin + self._gap[places].sum(1))
        if self.most_per_pair is not None:
            chosen = self._reduce(contacts, chosen, distance < margin)
        if len(chosen) == 0:
            return 0

        first = _append(model, data, len(chosen))
        fields = data.contact
        fields.dist[first:] = distance[chosen]
        fields.includemargin[first:] = margin[chosen]
        fields.exclude[first:] = distance[chosen] >= margin[chosen]
        fields.pos[first:] = (
            np.asarray(contacts.point_a)[chosen] + np.asarray(contacts.point_b)[chosen]
        ) / 2
        fields.frame[first:] = _frames(np.asarray(contacts.normal)[chosen])
        pairs = self.geoms[places[chosen]]
        fields.geom[first:] = pairs
        fields.geom1[first:], fields.geom2[first:] = pairs.T
        for name, values in _mixed(model, *pairs.T).items():
            getattr(fields, name)[first:] = values
        return len(chosen)

    def _reduce(self, contacts: Contacts, listed: Ints, active: NDArray[np.bool_]) -> Ints:
        """At most `most_per_pair` of the listed contacts of each pair.

        Active ones come first, of these the ones that reduce() picks, then the deepest.
        """
        picked = np.zeros(len(contacts), bool)
        picked[contacts.reduce(self.most_per_pair or 0)[0]] = True
        a, b = self._places(contacts)[listed].T
        order = np.lexsort(
            (np.asarray(contacts.distance)[listed], ~picked[listed], ~active[listed], b, a)
        )
        pair = (a * len(self.geoms) + b)[order]
        rank = np.arange(len(pair)) - np.searchsorted(pair, pair)
        return np.sort(listed[order[rank < self.most_per_pair]])

    def forward(self, model: mj.MjModel, data: mj.MjData) -> None:
        """mj_forward with these contacts; bitwise equal to it where there are none."""
        self._check(model)
        full = _overflows(data)
        data.flg_energypos = 0
        mj.mj_fwdKinematics(model, data)
        mj.mj_makeM(model, data)
        mj.mj_factorM(model, data)
        mj.mj_collision(model, data)
        self.add(model, data)
        mj.mj_makeConstraint(model, data)
        if _overflows(data) != full:
            raise MemoryError(_TOO_SMALL)
        mj.mj_island(model, data)
        mj.mj_projectConstraint(model, data)
        mj.mj_transmission(model, data)
        energy = model.opt.enableflags & mj.mjtEnableBit.mjENBL_ENERGY
        mj.mj_sensorPos(model, data)
        if energy:
            mj.mj_energyPos(model, data)
        elif not data.flg_energypos:
            data.energy[:] = 0
        mj.mj_fwdVelocity(model, data)
        mj.mj_sensorVel(model, data)
        if energy:
            mj.mj_energyVel(model, data)
        control = mj.get_mjcb_control()
        if control and not model.opt.disableflags & mj.mjtDisableBit.mjDSBL_ACTUATION:
            control(model, data)
        mj.mj_fwdActuation(model, data)
        mj.mj_fwdAcceleration(model, data)
        mj.mj_fwdConstraint(model, data)
        data.flg_rnepost = 0
        mj.mj_sensorAcc(model, data)

    def step(self, model: mj.MjModel, data: mj.MjData) -> None:
        """mj_step with these contacts; bitwise equal to it where there are none.

        Raises MemoryError if contacts or their constraints do not fit into the arena of `data`,
        which is then in the middle of a step.
        """
        self._check(model)
        mj.mj_checkPos(model, data)
        mj.mj_checkVel(model, data)
        self.forward(model, data)
        mj.mj_checkAcc(model, data)
        if model.opt.enableflags & mj.mjtEnableBit.mjENBL_FWDINV:
            mj.mj_compareFwdInv(model, data)
        if model.opt.integrator == mj.mjtIntegrator.mjINT_EULER:
            mj.mj_Euler(model, data)
        else:
            mj.mj_implicit(model, data)

    def release(self) -> None:
        """Gives the pairs back to MuJoCo: the model's masks are as before. May be repeated."""
        for name, values in self._before.items():
            getattr(self.model, name)[:] = values
        self._before = {}
        _alive.discard(self)

    def __enter__(self) -> MeshContacts:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.release()

    def _places(self, contacts: Contacts) -> Ints:
        """Places in `geoms` of each contact's two bodies, int64 (n, 2)."""
        handles = np.column_stack([np.asarray(contacts.a), np.asarray(contacts.b)])
        return np.searchsorted(self._bodies, handles)

    def _check(self, model: mj.MjModel) -> None:
        if model is not self.model:
            raise ValueError("this is not the model that MeshContacts was made for")
        if not self._before:
            raise ValueError("MeshContacts has been released")
        _check_options(model)


_TOO_SMALL = (
    "the arena of MjData is too small for all contacts and their constraints; "
    'give it more, such as <size memory="100M"/>, or fewer contacts by most_per_pair'
)


def _overflows(data: mj.MjData) -> int:
    return sum(
        data.warning[kind].number
        for kind in (mj.mjtWarning.mjWARN_CONTACTFULL, mj.mjtWarning.mjWARN_CNSTRFULL)
    )


def _check_options(model: mj.MjModel) -> None:
    allowed = (
        mj.mjtIntegrator.mjINT_EULER,
        mj.mjtIntegrator.mjINT_IMPLICIT,
        mj.mjtIntegrator.mjINT_IMPLICITFAST,
    )
    if model.opt.integrator not in allowed:
        name = mj.mjtIntegrator(model.opt.integrator).name.removeprefix("mjINT_")
        raise ValueError(
            f"MeshContacts cannot add contacts within a step of the integrator "
            f"{name}: use Euler, implicit or implicitfast"
        )
    for bit, name in _REFUSED.items():
        if model.opt.enableflags & getattr(mj.mjtEnableBit, bit, 0):
            raise ValueError(f"MeshContacts does not support {name}: switch that flag off")


def _mesh_geoms(model: mj.MjModel, geoms: Iterable[int | str] | None) -> Ints:
    """Sorted ids of the geoms to take, int64 (n,)."""
    mesh = np.asarray(model.geom_type) == mj.mjtGeom.mjGEOM_MESH
    if geoms is None:
        return np.flatnonzero(mesh & ((model.geom_contype != 0) | (model.geom_conaffinity != 0)))
    ids = np.unique([model.geom(geom).id for geom in geoms]).astype(np.int64)
    for geom in ids[~mesh[ids]]:
        raise ValueError(f"geom {_name(model, geom)} is not a mesh")
    return ids


def _name(model: mj.MjModel, geom: int) -> str:
    return f"{int(geom)} '{model.geom(int(geom)).name}'"


def _check_geoms(model: mj.MjModel, geoms: Ints) -> None:
    for a, b in zip(model.pair_geom1, model.pair_geom2):
        if a in geoms and b in geoms:
            raise ValueError(
                f"geoms {_name(model, a)} and {_name(model, b)} are a <pair>, which "
                "MuJoCo does not switch off: remove it, or leave out a geom"
            )
    if hasattr(model, "geom_surfacevel") and model.geom_surfacevel[geoms].any():
        raise ValueError("MeshContacts does not support surfacevel of mesh geoms")
    data = mj.MjData(model)
    mj.mj_forward(model, data)
    if getattr(data, "efm_active", 0):
        raise ValueError(
            "MeshContacts does not support the implicit metric of flexes or tendons "
            "(MjData.efm_active)"
        )


def _mesh(model: mj.MjModel, mesh: int) -> tuple[NDArray[np.float32], NDArray[np.int32]]:
    """The compiled mesh, in the frame of its geoms: vertices (n, 3) and triangles (m, 3)."""
    vertices = model.mesh_vert[model.mesh_vertadr[mesh] :][: model.mesh_vertnum[mesh]]
    triangles = model.mesh_face[model.mesh_faceadr[mesh] :][: model.mesh_facenum[mesh]]
    return vertices.copy(), triangles.copy()


def _by_masks(
    contype_a: Any, conaffinity_a: Any, contype_b: Any, conaffinity_b: Any
) -> NDArray[np.bool_]:
    """Which a meet which b by their masks, bool (a, b)."""
    both = (contype_a[:, None] & conaffinity_b) | (conaffinity_a[:, None] & contype_b)
    return np.asarray(both != 0)


def _meeting_pairs(model: mj.MjModel, geoms: Ints) -> NDArray[np.bool_]:
    """Which geoms MuJoCo lets meet, bool (n, n)."""
    contype, conaffinity = model.geom_contype[geoms], model.geom_conaffinity[geoms]
    meets: NDArray[np.bool_] = _by_masks(contype, conaffinity, contype, conaffinity)
    body = model.geom_bodyid[geoms]
    welded = model.body_weldid[body]
    meets &= welded[:, None] != welded
    held = model.body_dofnum[welded] == 0
    meets &= ~(held[:, None] & held)
    if not model.opt.disableflags & mj.mjtDisableBit.mjDSBL_FILTERPARENT:
        parent = model.body_weldid[model.body_parentid[welded]]
        child = (welded[:, None] == parent) | (parent[:, None] == welded)
        meets &= ~child | (welded[:, None] == 0) | (welded == 0)
    signature = (np.minimum(body[:, None], body) << 16) + np.maximum(body[:, None], body)
    return meets & ~np.isin(signature, model.exclude_signature)


def _switch_off(model: mj.MjModel, geoms: Ints) -> None:
    """Changes the masks so that these geoms do not meet each other; all else stays.

    Geoms that meet the same others share a bit.
    A bit is free if it is in no other contype, for then nothing but these geoms can tell who
    has it in conaffinity.
    """
    taken = np.zeros(model.ngeom, bool)
    taken[geoms] = True
    contype = np.concatenate([model.geom_contype[~taken], model.flex_contype])
    conaffinity = np.concatenate([model.geom_conaffinity[~taken], model.flex_conaffinity])
    meets = _by_masks(
        model.geom_contype[geoms], model.geom_conaffinity[geoms], contype, conaffinity
    )
    kinds, kind_of = np.unique(meets, axis=0, return_inverse=True)
    used = np.bitwise_or.reduce(contype, initial=0)
    free = [1 << bit for bit in range(31) if not used >> bit & 1]
    bits = np.zeros(len(kinds), contype.dtype)
    some = np.flatnonzero(kinds.any(1))
    if len(some) > len(free):
        raise ValueError(
            f"the mesh geoms meet {len(some)} different sets of other geoms, and "
            f"only {len(free)} bits of contype are free: use fewer bits in the "
            "model, or take fewer geoms"
        )
    bits[some] = free[: len(some)]
    for kind, bit in zip(kinds, bits):
        conaffinity = np.where(kind, conaffinity | bit, conaffinity & ~bit)

    model.geom_contype[geoms] = bits[kind_of.ravel()]
    model.geom_conaffinity[geoms] = 0
    others = np.count_nonzero(~taken)
    model.geom_conaffinity[~taken] = conaffinity[:others]
    model.flex_conaffinity[:] = conaffinity[others:]
    for name in ("contype", "conaffinity"):
        of_body = getattr(model, f"body_{name}")
        of_body[:] = 0
        np.bitwise_or.at(of_body, model.geom_bodyid, getattr(model, f"geom_{name}"))


def _append(model: mj.MjModel, data: mj.MjData, count: int) -> int:
    """Makes room for contacts; returns the place of the first one."""
    first = int(data.ncon)
    blank = mj.MjContact()
    blank.flex = blank.elem = blank.vert = [-1, -1]
    blank.efc_address = -1
    for done in range(count):
        if mj.mj_addContact(model, data, blank):
            raise MemoryError(
                f"{count - done} of {count} contacts between meshes have no room: {_TOO_SMALL}"
            )
    return first


def _frames(normal: Floats) -> Floats:
    """Normal and two tangents, right-handed, float64 (n, 9)."""
    tangent = np.where(np.abs(normal[:, 1:2]) < 0.5, [[0.0, 1.0, 0.0]], [[0.0, 0.0, 1.0]])
    tangent = tangent - (tangent * normal).sum(1, keepdims=True) * normal
    tangent /= np.linalg.norm(tangent, axis=1, keepdims=True)
    return np.hstack([normal, tangent, np.cross(normal, tangent)])


def _mixed(model: mj.MjModel, a: Ints, b: Ints) -> dict[str, NDArray[Any]]:
    """Parameters of contacts between geoms a (n,) and b (n,), mixed as MuJoCo does."""
    priority_a, priority_b = model.geom_priority[a], model.geom_priority[b]

    def choose(name: str, mixed: NDArray[Any]) -> NDArray[Any]:
        values = getattr(model, name)
        above, below = priority_a > priority_b, priority_a < priority_b
        shape = (-1,) + (1,) * (mixed.ndim - 1)
        return np.where(
            above.reshape(shape), values[a], np.where(below.reshape(shape), values[b], mixed)
        )

    mix_a, mix_b = model.geom_solmix[a], model.geom_solmix[b]
    tiny = float(mj.mjMINVAL)
    share = np.divide(
        mix_a, mix_a + mix_b, out=np.full(len(a), 0.5), where=(mix_a >= tiny) | (mix_b >= tiny)
    )[:, None]
    ref_a, ref_b = model.geom_solref[a], model.geom_solref[b]
    standard = (ref_a[:, :1] > 0) & (ref_b[:, :1] > 0)
    solref = np.where(standard, share * ref_a + (1 - share) * ref_b, np.minimum(ref_a, ref_b))
    solimp = share * model.geom_solimp[a] + (1 - share) * model.geom_solimp[b]
    friction = choose("geom_friction", np.maximum(model.geom_friction[a], model.geom_friction[b]))
    mixed = {
        "dim": choose("geom_condim", np.maximum(model.geom_condim[a], model.geom_condim[b])),
        "friction": np.maximum(friction, mj.mjMINMU)[:, [0, 0, 1, 2, 2]],
        "solref": choose("geom_solref", solref),
        "solimp": choose("geom_solimp", solimp),
    }
    if hasattr(model, "geom_adhesion"):
        mixed["adhesion"] = choose("geom_adhesion", model.geom_adhesion[a] + model.geom_adhesion[b])
    return mixed
