"""Worlds, bodies and their contacts: the same as in C++, by names and by values."""

import copy
import gc
import pickle
import re
import subprocess
import sys
import threading
import time
import weakref
from pathlib import Path

import numpy as np
import pierce
import pytest
from conftest import box, torus

SOURCE = Path(__file__).parents[2]

# Members of World in C++ that Python has under another name, or not at all, and why.
ELSEWHERE = {
    "keep_contacts": "contacts",  # every list of contacts in Python outlasts its step
    "share_mesh": "mesh",  # a mesh in Python outlasts its world
    "set_device_positions": "set_positions",  # arrays say where they are
    "set_device_motion": "set_motion",
    "set_device_poses": "set_poses",
}


def test_every_member_of_world_is_here():
    header = (SOURCE / "src/core/include/pierce/world.hpp").read_text()
    body = header[header.index("class World {") : header.index("private:")]
    body = re.sub(r"///.*", "", body)
    names = set(re.findall(r"\b([a-z_]+)\((?=[^;]*;)", body)) - {"detect_"}
    assert {"detect", "add_mesh", "set_pair_filter", "probe"} <= names
    missing = {n for n in names if not hasattr(pierce.World, ELSEWHERE.get(n, n))}
    assert missing == set()


@pytest.mark.parametrize(
    "header, struct, python",
    [
        ("settings", "Settings", pierce.Settings),
        ("body", "Collision", pierce.Collision),
        ("filter", "Filter", pierce.Filter),
        ("step_stats", "StepStats", pierce.StepStats),
        ("explain", "Explanation", pierce.Explanation),
        ("parting", "Parting", pierce.Parting),
        ("overlap", "Overlap", pierce.Overlap),
        ("overlap", "ContactPatch", pierce.ContactPatch),
        ("impact_contact", "ImpactContact", pierce.ImpactContact),
        ("mesh", "MeshTraits", pierce.MeshTraits),
        ("inside", "MeshInside", pierce.MeshInside),
        ("contact", "Contact", pierce.Contacts),
        ("world", "RayHit", pierce.RayHit),
        ("world", "ProbeContact", pierce.ProbeContact),
        ("world", "WorldOffsets", pierce.WorldOffsets),
    ],
)
def test_every_field_is_here(header, struct, python):
    text = (SOURCE / f"src/core/include/pierce/{header}.hpp").read_text()
    start = re.search(rf"struct (alignas\(16\) )?{struct} {{", text).start()
    body = re.sub(r"//.*", "", text[start : text.index("\n};", start)])
    body = body.split("PIERCE_HD")[0]
    fields = re.findall(r"^    (?!return|friend)[\w:<>, ]+? (\w+(?:\[\d\])?(?: = [^;,]+)?"
                        r"(?:, \w+(?: = [^;,]+)?)*)(?:{})?;", body, re.M)  # fmt: skip
    names = {re.match(r"\w+", f).group() for line in fields for f in line.split(", ")}
    names = {n for n in names if not n.startswith("padding")}
    assert len(names) >= 2
    assert {n for n in names if not hasattr(python, n)} == set()


def test_every_class_and_function_has_a_description():
    for name in dir(pierce):
        thing = getattr(pierce, name)
        if not name.startswith("_") and (callable(thing) or isinstance(thing, type)):
            assert thing.__doc__, name


def test_contacts_are_views_of_one_list(two_tori):
    world, rigid, soft, _ = two_tori
    contacts = world.detect()
    assert len(contacts) == world.stats.contacts > 50
    records = contacts.records
    assert records.dtype == pierce.contact_dtype and len(records) == len(contacts)
    for field in pierce.Contacts.fields:
        column = getattr(contacts, field)
        assert np.shares_memory(column, records), field
        assert not column.flags.writeable
        np.testing.assert_array_equal(column, records[field])
    assert set(contacts.a) == {int(rigid)} and set(contacts.b) == {int(soft)}
    assert pierce.BodyId(int(contacts.b[0])) == soft
    along = ((contacts.point_b - contacts.point_a) * contacts.normal).sum(1)
    np.testing.assert_allclose(along, contacts.distance, atol=1e-12)
    np.testing.assert_array_equal(contacts.depth, np.maximum(-contacts.distance, 0))
    assert (
        np.from_dlpack(contacts.distance).__array_interface__["data"]
        == (contacts.distance.__array_interface__["data"])
    )
    assert "contacts" in repr(contacts)


def test_contacts_outlast_steps_and_worlds(two_tori):
    world, rigid, soft, positions = two_tori
    lists = []
    for step in range(8):
        world.set_pose(rigid, [0.02 * step, 0, 0, 0, 0, 0, 1])
        contacts = world.detect()
        lists.append((contacts.normal, contacts.normal.copy(), contacts, contacts.hash))
        if step == 5:
            world.detect()
            world.detect()
    del world, contacts, two_tori
    gc.collect()
    for view, copied, contacts, hash_then in lists:
        np.testing.assert_array_equal(view, copied)
        assert contacts.hash == hash_then


def test_same_contacts_on_every_backend(two_tori):
    world, *_ = two_tori
    expected = world.detect()
    saved = world.save()
    for backend in ("embree", "bvh", "reference"):
        other = pierce.World.restore(saved, backend)
        assert other.detect().hash == expected.hash, backend
        shared = pierce.World.restore(saved, backend, parts=2)
        assert shared.detect().hash == expected.hash, backend
        assert shared.backend.startswith("2 parts; "), shared.backend


def test_settings_by_name():
    world = pierce.World("reference", coverage="vertices", reproject=False, margin=0.1)
    assert world.plan.settings.coverage == pierce.Coverage.vertices
    settings = pierce.Settings(temporal="paper", full_every=3)
    assert pierce.World("reference", settings=settings).plan.settings.full_every == 3
    assert settings == pierce.Settings(temporal=pierce.Temporal.paper, full_every=3)
    with pytest.raises(ValueError, match="coverage: expected one of vertices, complete, overlaps"):
        pierce.World(coverage="some")
    with pytest.raises(TypeError, match="Settings has no field 'covrage'; it has"):
        pierce.World(covrage="complete")
    with pytest.raises(TypeError, match=r"Settings\.margin cannot be 'wide'"):
        pierce.World(margin="wide")
    with pytest.raises(TypeError, match=r"Collision\.sheet cannot be None"):
        pierce.Collision(sheet=None)
    with pytest.raises(pierce.InputError, match="there are: automatic, embree"):
        pierce.World("cpu")


def test_a_field_called_self():
    collision = pierce.Collision(self_="on", margin=0.5)
    assert collision.self == pierce.SelfCollision.on and collision.margin == 0.5
    collision.self = "off"
    assert collision == pierce.Collision(margin=0.5)


def test_handles_compare_with_anything():
    assert pierce.BodyId(1) != None and not pierce.BodyId(1) == "a"  # noqa: E711
    assert pierce.BodyId(1) == pierce.BodyId(1) != pierce.BodyId(2) > pierce.BodyId(1)


def test_parts_of_a_list(two_tori):
    world, rigid, soft, _ = two_tori
    other = world.add_rigid_body(world.mesh_of(rigid), [0, 0.9, 0.1, 0, 0, 0, 1])
    contacts = world.detect()
    pairs = {(a, b) for a, b in zip(contacts.a, contacts.b)}
    assert len(pairs) == 3
    parts = [contacts.of_pair(pierce.BodyId(int(a)), pierce.BodyId(int(b))) for a, b in pairs]
    assert sum(len(part) for part in parts) == len(contacts)
    for part, (a, b) in zip(parts, pairs):
        assert (part.a == a).all() and (part.b == b).all()
        assert np.shares_memory(part.normal, contacts.normal)
        np.testing.assert_array_equal(
            part.distance, contacts.distance[(contacts.a == a) & (contacts.b == b)]
        )
    assert len(contacts.of_pair(soft, rigid)) == len(contacts.of_pair(rigid, soft)) > 0
    alone = contacts[3:10]
    assert len(alone) == 7
    np.testing.assert_array_equal(alone.point_a, contacts.point_a[3:10])
    np.testing.assert_array_equal(contacts[-1].normal, contacts.normal[-1:])
    with pytest.raises(IndexError):
        contacts[len(contacts)]
    with pytest.raises(ValueError, match="step of 1"):
        contacts[::2]
    world.remove_body(other)


def test_values_are_copied_and_pickled(two_tori):
    world, rigid, soft, _ = two_tori
    world.detect()
    mesh = world.mesh_of(rigid)
    settings = pierce.Settings(margin=0.25, coverage="complete")
    collision = pierce.Collision(self_="on", margin=0.5)
    for value in (rigid, soft, mesh, pierce.BodyId(), settings, collision, pierce.Filter(world=3)):
        for other in (copy.copy(value), copy.deepcopy(value), pickle.loads(pickle.dumps(value))):
            assert other == value and type(other) is type(value)
    other = copy.deepcopy({"settings": settings})["settings"]
    other.margin = 1
    assert settings.margin == 0.25
    assert copy.copy(world.stats).pairs == world.stats.pairs == 1


def test_texts_for_people(two_tori):
    world, rigid, soft, _ = two_tori
    world.detect()
    assert "1 rigid, 1 deforming" in repr(world)
    assert repr(rigid) == "BodyId(0)" and repr(pierce.BodyId()) == "BodyId()"
    assert "coverage=" in repr(pierce.Settings())
    assert pierce.Settings()._repr_html_().startswith("<table>")
    assert "Plan(" in repr(world.plan) and "pairs=1" in repr(world.stats)
    inside = int(world.contacts.vertex[0])
    source = rigid if world.contacts.source[0] == 0 else soft
    other = soft if source == rigid else rigid
    explanation = world.explain(source, other, inside)
    assert explanation.reason == pierce.Reason.contact and explanation.contact is not None
    assert len(explanation.text) > 10


def test_questions(two_tori):
    world, rigid, soft, _ = two_tori
    contacts = world.detect()
    parting = world.parting(rigid, soft)
    assert parting.depth >= contacts.depth.max() - 1e-5
    overlap = world.overlap(rigid, soft)
    assert overlap.volume > 0 and overlap.patches[0].area > 0
    places, weights = contacts.reduce(8)
    assert len(places) <= 8 and (weights > 0).all()
    deep = contacts.depth > np.median(contacts.depth)
    for among in (deep, np.flatnonzero(deep), np.flatnonzero(deep)[:7].tolist()):
        places, _ = contacts.reduce(6, among)
        assert 0 < len(places) <= 6 and deep[places].all()
    with pytest.raises(IndexError):
        contacts.reduce(6, [len(contacts)])
    began, stayed, ended = world.detect().changes(contacts)
    assert len(began) == len(ended) == 0 and len(stayed) == len(contacts)
    hits = world.cast_rays((0, 0, 5), [[0, 1, 0], [1, 0, -5], [0, 0, 1]])
    assert hits[0] is None and hits[1].body in (rigid, soft) and hits[2] is None
    touched = world.probe([[1, 0, 0.3]], [[0, 0, 1]], 0.5)
    assert touched[0].distance < 0
    assert world.impacts() == []
    assert len(world.body_boxes()) == 2
    world.set_pose(rigid, [0, 0, 5, 0, 0, 0, 1])
    ahead = world.impacts_ahead(pierce.ids([rigid]), np.float64([[0, 0, -5, 0, 0, 0, 1]]), 3)
    assert len(world.impacts_ahead([rigid], [[0, 0, -5, 0, 0, 0, 1]], 3)) == 3
    assert len(ahead) == 3 and 0 < ahead[0].time < 0.5
    along = np.dot(np.subtract(ahead[0].start_b, ahead[0].start_a), ahead[0].normal)
    assert along == pytest.approx(ahead[0].gap, rel=1e-6)
    with pytest.raises(ValueError, match="a pose for each body"):
        world.impacts_ahead([rigid], [])


def test_many_worlds():
    world = pierce.World("embree", 1)
    mesh = world.add_mesh(box())
    for z in (0.0, 0.95):
        body = world.add_rigid_body(mesh, [0, 0, z, 0, 0, 0, 1])
        world.set_filter(body, pierce.Filter(world=0))
    world.replicate(0, 9)
    world.set_world_active(4, False)
    world.detect()
    offsets = world.world_offsets()
    counts = np.diff(offsets.solids)
    assert offsets.worlds == list(range(10))
    assert (counts == [counts[0] if w != 4 else 0 for w in range(10)]).all() and counts[0] > 0


def test_pair_filter(two_tori):
    world, rigid, soft, _ = two_tori
    asked = []
    world.set_pair_filter(lambda a, b: asked.append((a, b)))  # None is no
    assert len(world.detect()) == 0 and asked == [(rigid, soft)]

    def fail(a, b):
        raise KeyError("mine")

    world.set_pair_filter(fail)
    with pytest.raises(KeyError, match="mine"):
        world.detect()
    with pytest.raises(KeyError, match="mine"):
        world.explain(rigid, soft, 0)
    world.set_pose(rigid, [0, 0, -5, 0, 0, 0, 1])
    world.set_motion(rigid, [0, 0, -5, 0, 0, 0, 1], [0, 0, 0, 0, 0, 0, 1])
    with pytest.raises(KeyError, match="mine"):
        world.impacts()
    world.set_pair_filter(lambda a, b: world.stats is None)
    with pytest.raises(RuntimeError, match="own pair filter"):
        world.detect()
    world.set_pair_filter(None)
    assert len(world.detect()) > 0
    with pytest.raises(TypeError, match="function of two bodies"):
        world.set_pair_filter(5)


def test_a_filter_that_holds_its_world_is_collected():
    class Holder:
        def __init__(self):
            self.world = pierce.World("reference")
            self.world.set_pair_filter(self.wants)

        def wants(self, a, b):
            return True

    gone = weakref.ref(Holder())
    gc.collect()
    assert gone() is None


def test_two_worlds_in_two_threads():
    vertices, triangles = torus(around=40, across=20)
    results = {}

    def run(name):
        world = pierce.World("embree", 1)
        mesh = world.add_mesh((vertices, triangles))
        world.add_fixed_body(mesh)
        body = world.add_rigid_body(mesh)
        hashes = []
        for step in range(60):
            world.set_pose(body, [0.9, 0.01 * step, 0.1, 0, 0, 0, 1])
            hashes.append(world.detect().hash)
        results[name] = hashes

    threads = [threading.Thread(target=run, args=(k,)) for k in range(2)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert results[0] == results[1] and len(set(results[0])) > 30


def test_one_world_in_two_threads_is_refused():
    world = pierce.World("reference", coverage="complete")
    mesh = world.add_mesh(torus())
    world.add_fixed_body(mesh)
    body = world.add_rigid_body(mesh, [0.9, 0, 0.1, 0, 0, 0, 1])
    refused, over = [], threading.Event()

    def disturb():
        while not over.is_set():
            try:
                world.set_pose(body, [0.9, 0, 0.1, 0, 0, 0, 1])
            except RuntimeError as error:
                refused.append(str(error))

    thread = threading.Thread(target=disturb)
    thread.start()
    interval = sys.getswitchinterval()
    sys.setswitchinterval(1e-5)
    for _ in range(20):
        try:
            world.detect()
        except RuntimeError as error:
            refused.append(str(error))
    over.set()
    thread.join()
    sys.setswitchinterval(interval)
    assert refused and all("another thread" in text for text in refused)


def test_the_interpreter_ends_while_a_thread_takes_steps():
    program = """
import threading, time, pierce

def run():
    world = pierce.World("reference", coverage="complete")
    corners = ([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]],
               [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])
    mesh = world.add_mesh(corners)
    for _ in range(30):
        world.add_rigid_body(mesh)
    world.detect()
    stepped.set()
    while True:
        world.detect()

stepped = threading.Event()
threading.Thread(target=run, daemon=True).start()
stepped.wait()
time.sleep(0.1)
"""
    for _ in range(3):
        run = subprocess.run(
            [sys.executable, "-c", program], capture_output=True, text=True, timeout=120
        )
        assert (run.returncode, run.stderr) == (0, "")


def test_long_questions_do_not_hold_other_threads_up():
    world = pierce.World("reference")
    mesh = world.add_mesh(torus(around=80, across=60))
    a, b = world.add_fixed_body(mesh), world.add_rigid_body(mesh, [0.9, 0, 0.1, 0, 0, 0, 1])
    world.detect()
    ticks, over = [], threading.Event()

    def tick():
        while not over.is_set():
            ticks.append(time.perf_counter())
            time.sleep(0.001)

    thread = threading.Thread(target=tick)
    thread.start()
    begin = time.perf_counter()
    assert world.overlap(a, b) is not None
    end = time.perf_counter()
    over.set()
    thread.join()
    assert sum(begin < tick < end for tick in ticks) > 2


def test_a_progress_callback_is_counted_as_often_as_it_is_kept():
    calls = []

    def progress(what, share):
        calls.append((what, share))

    before = sys.getrefcount(progress)
    meshes = [None] * 4

    def make(k):
        for _ in range(30):
            meshes[k] = pierce.Mesh.make(torus(), progress=progress, threads=2)

    threads = [threading.Thread(target=make, args=(k,)) for k in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    meshes.clear()
    gc.collect()
    assert sys.getrefcount(progress) == before


def test_a_progress_callback_may_hold_its_mesh():
    class Asset:
        def __init__(self, add):
            self.mesh = pierce.Mesh.make(torus(), progress=self.show)
            self.world = pierce.World("reference")
            if add:
                self.world.add_mesh(self.mesh)

        def show(self, what, share):
            pass

    class Slots:
        """An object without weak references."""

        __slots__ = ("mesh", "seen")

        def __init__(self):
            self.seen = []
            self.mesh = pierce.Mesh.make(torus(), progress=self)

        def __call__(self, what, share):
            self.seen.append(share)

    class Mark:
        pass

    gone = [weakref.ref(Asset(add)) for add in (False, True)]
    slots = Slots()
    slots.seen = Mark()
    gone.append(weakref.ref(slots.seen))
    del slots
    gc.collect()
    assert [each() for each in gone] == [None, None, None]
    script = """
import numpy as np, pierce
points = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], np.float32)
faces = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]], np.uint32)
mesh = pierce.Mesh.make((points, faces), progress=lambda what, share: None)
world = pierce.World("reference")
world.add_rigid_body(world.add_mesh(mesh))
world.detect()
"""
    ended = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True)
    assert ended.returncode == 0 and ended.stderr == ""


def test_what_a_progress_callback_raises_is_told(monkeypatch):
    told = []
    monkeypatch.setattr(sys, "unraisablehook", lambda about: told.append(about.exc_type))

    def progress(what, share):
        raise ReferenceError("mine")

    pierce.Mesh.make(torus(around=900, across=400), progress=progress, threads=1)
    if not told:
        pytest.skip("this machine makes the mesh before there is anything to tell")
    assert set(told) == {ReferenceError}


def test_a_removed_mesh_is_let_go():
    world = pierce.World("reference")
    mesh = pierce.Mesh.make(torus())
    before = sys.getrefcount(mesh)
    ids = [world.add_mesh(mesh) for _ in range(5)]
    assert sys.getrefcount(mesh) == before + 5
    for each in ids:
        world.remove_mesh(each)
    assert sys.getrefcount(mesh) == before


@pytest.mark.parametrize("ask", [lambda w: w.plan, repr, lambda w: w.detect(), lambda w: w.save()])
def test_measuring_meshes_tells_how_far_it_is(ask):
    """Python must be free to run, or the callback waits for it for ever."""
    calls = []
    world = pierce.World("embree", 2)
    mesh = world.add_mesh(
        torus(around=500, across=300), threads=2, progress=lambda what, share: calls.append(what)
    )
    world.add_deforming_body(mesh)
    world.add_rigid_body(mesh, [99, 0, 0, 0, 0, 0, 1])
    calls.clear()
    ask(world)
    if not calls:
        pytest.skip("this machine measures the mesh before there is anything to tell")


def test_a_mesh_that_is_made_takes_no_options():
    world = pierce.World("reference")
    mesh = pierce.Mesh.make(torus())
    first = world.add_mesh(mesh)
    for option in ({"before": first}, {"inside": "none"}, {"cache": "folder"}):
        with pytest.raises(ValueError, match="made already"):
            world.add_mesh(mesh, **option)


def test_a_mesh_comes_from_another_one_by_handle_or_object():
    vertices, triangles = torus()
    torn = (vertices, triangles[:-1])
    hashes = []
    for by_handle in (True, False):
        world = pierce.World("bvh", threads=1)
        first = world.add_mesh((vertices, triangles))
        before = first if by_handle else world.mesh(first)
        body = world.add_deforming_body(world.add_mesh(torn, before=before))
        world.add_rigid_body(first, [0.5, 0.1, 0, 0, 0, 0, 1])
        contacts = world.detect()
        assert len(contacts) > 0
        hashes.append([world.vertex_positions(body).tobytes(), contacts.distance.tobytes()])
    assert hashes[0] == hashes[1]


def test_what_has_a_wrong_type_is_refused():
    world = pierce.World("reference")
    world.add_fixed_body(world.add_mesh(torus()))
    contacts = world.detect()
    with pytest.raises(TypeError, match="number or a slice"):
        contacts["a"]
    with pytest.raises(TypeError, match="number or a slice"):
        contacts[1.5]
    with pytest.raises(IndexError):
        contacts[10**30]
    for call in (
        lambda: pierce.World(settings=5),
        lambda: world.add_mesh(torus(), before=5),
        lambda: world.set_stream("x"),
        lambda: pierce.Recording(0.1, [(1, torus())], []),
    ):
        with pytest.raises(TypeError):
            call()


def test_values_that_change_have_no_hash():
    for value in (pierce.Settings(), pierce.Filter(), pierce.Collision()):
        assert value == type(value)()
        with pytest.raises(TypeError, match="unhashable"):
            hash(value)


def test_meshes_of_others():
    vertices, triangles = torus()

    class Faces:  # as trimesh has them
        pass

    faces = Faces()
    faces.vertices, faces.faces = vertices.astype(np.float64), triangles.astype(np.int64)

    class Cells:  # as meshio has them
        pass

    cells = Cells()
    cells.points, cells.cells_dict = vertices, {"triangle": triangles}
    made = pierce.Mesh.make((vertices, triangles), "torus", inside="closed")
    for mesh in (faces, cells, made, (vertices.tolist(), triangles.tolist())):
        world = pierce.World("reference")
        kept = world.mesh(world.add_mesh(mesh))
        np.testing.assert_array_equal(kept.vertices, vertices)
        np.testing.assert_array_equal(kept.triangles, triangles)
    assert made.traits.closed and made.inside.exists
    assert pierce.check_mesh(made).sound
    (_, fixed), places, done = pierce.fix_mesh((vertices, triangles[1:]))
    assert len(fixed) == len(triangles) and done.holes == 1
    closed = pierce.Mesh.make((vertices, triangles[1:]))
    assert closed.given_triangle(0) == 0
    for beyond in (len(closed.triangles), 2**31):
        with pytest.raises(pierce.InputError, match="has no triangle"):
            closed.given_triangle(beyond)


def test_a_mesh_stays_when_its_world_removes_it():
    vertices, triangles = torus()
    world, other = pierce.World("reference"), pierce.World("reference")
    number = world.add_mesh((vertices, triangles), "ring")
    mesh = world.mesh(number)
    bodies = [other.add_rigid_body(other.add_mesh(mesh)) for _ in range(2)]
    assert len(other.detect()) > 0
    view = mesh.vertices
    world.remove_mesh(number)
    gc.collect()
    junk = [np.full_like(vertices, 7) for _ in range(100)]
    np.testing.assert_array_equal(view, vertices)
    assert mesh.name == "ring" and len(junk) == 100
    other.set_pose(bodies[1], [0.1, 0, 0, 0, 0, 0, 1])
    assert len(other.detect()) > 0


def test_a_pair_of_solids_and_sheets(two_tori):
    world, _, _, positions = two_tori
    sheet = world.add_deforming_body(
        world.mesh_of(two_tori[2]), positions + np.float32([0.2, 0, 0])
    )
    other = world.add_deforming_body(
        world.mesh_of(two_tori[2]), positions + np.float32([0.4, 0, 0])
    )
    world.set_collision(sheet, pierce.Collision(sheet=True, thickness=0.05))
    contacts = world.detect()
    for body in (two_tori[1], two_tori[2], other):
        a, b = sorted((body, sheet))
        of_pair = (contacts.a == int(a)) & (contacts.b == int(b))
        part = contacts.of_pair(body, sheet)
        assert of_pair.sum() == len(part) > 0
        np.testing.assert_array_equal(part.distance, contacts.distance[of_pair])
        np.testing.assert_array_equal(part.of_sheet, contacts.of_sheet[of_pair])


def test_a_progress_callback_may_hold_its_world():
    class Simulation:
        def __init__(self):
            self.world = pierce.World("reference")
            self.world.add_mesh(torus(), progress=self.tell)

        def tell(self, what, share):
            self.told = what, share

    simulations = [weakref.ref(Simulation()) for _ in range(3)]
    gc.collect()
    assert [simulation() for simulation in simulations] == [None] * 3


def test_callbacks_that_end_may_look_for_garbage():
    class Callback:
        def __call__(self, what, share):
            pass

        def __del__(self):
            gc.collect()

    world = pierce.World("reference")
    meshes = [world.add_mesh(torus(), progress=Callback()) for _ in range(3)]
    for mesh in meshes[:2]:
        world.remove_mesh(mesh)
    world.add_mesh(torus(), progress=Callback())


def test_a_mesh_that_worlds_share_stays():
    made = pierce.Mesh.make(torus())
    world = pierce.World("reference")
    mesh = world.add_mesh(made)
    del made
    gc.collect()
    assert len(world.mesh(mesh).vertices) == 300
    vertices = world.mesh(mesh).vertices
    del world
    gc.collect()
    assert np.isfinite(vertices).all()
