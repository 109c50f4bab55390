"""Arrays in the memory of a CUDA device: read where they are, and contacts read there."""

import gc

import numpy as np
import pierce
import pytest
from conftest import torus

pytestmark = pytest.mark.skipif(not pierce.cuda_can_run(), reason="there is no CUDA here")


def packages():
    """Packages with arrays on the device, as (name, function that puts an array there)."""
    found = []
    try:
        import torch

        found.append(("torch", lambda a: torch.from_numpy(a).cuda()))
    except ImportError:
        pass
    try:
        import cupy

        found.append(("cupy", cupy.asarray))
    except ImportError:
        pass
    return found


class Described:
    """An array that says where it is by __cuda_array_interface__ alone."""

    def __init__(self, array):
        self.kept = array
        self.__cuda_array_interface__ = array.__cuda_array_interface__


def tori(backend, count=6):
    """(world, handles, rest positions) of deforming tori in a row that overlap."""
    world = pierce.World(backend)
    vertices, triangles = torus()
    mesh = world.add_mesh((vertices, triangles))
    bodies = [world.add_deforming_body(mesh) for _ in range(count)]
    places = np.concatenate([vertices + np.float32([0.9 * k, 0, 0.2 * k]) for k in range(count)])
    return world, bodies, np.ascontiguousarray(places)


@pytest.mark.parametrize("name, there", packages())
def test_positions_on_the_device(name, there):
    host, in_host, places = tori("embree")
    world, bodies, _ = tori("cuda")
    assert world.on_device
    for step in range(5):
        moved = places + np.float32([0, 0.01 * step, 0])
        host.set_positions(in_host, moved)
        array = there(moved)
        world.set_positions(bodies, Described(array) if step == 4 else array)
        del array  # the world keeps it
        gc.collect()
        waste = there(np.full_like(moved, 7))
        assert world.detect().hash == host.detect().hash, (name, step)
        assert world.detect().hash == host.contacts.hash
        del waste


@pytest.mark.parametrize("name, there", packages())
@pytest.mark.parametrize("kind", [np.float32, np.float64])
def test_poses_on_the_device(name, there, kind):
    random = np.random.default_rng(3)
    worlds = [pierce.World("embree"), pierce.World("cuda")]
    handles = []
    for world in worlds:
        mesh = world.add_mesh(torus())
        handles.append(pierce.ids([world.add_rigid_body(mesh) for _ in range(8)]))
    for _ in range(4):
        poses = random.uniform(-1, 1, (8, 7)).astype(kind)
        worlds[0].set_poses(handles[0], poses)
        worlds[1].set_poses(handles[1], there(poses))
        assert len(worlds[0].detect()) > 50
        assert worlds[1].detect().hash == worlds[0].contacts.hash


def test_contacts_on_the_device():
    torch = pytest.importorskip("torch")
    world, bodies, places = tori("cuda")
    stream = torch.cuda.Stream()
    world.set_stream(stream)
    with torch.cuda.stream(stream):
        array = torch.from_numpy(places).cuda()
        world.set_positions(bodies, array)
        contacts = world.detect()
        solids, sheets = world.device_contacts()
        count = int(torch.from_dlpack(solids.count)[0])
        columns = {k: torch.from_dlpack(getattr(solids, k))[:count].cpu().numpy()
                   for k in ("distance", "point_a", "point_b", "normal", "feature")}  # fmt: skip
    assert count == len(contacts) > 100
    np.testing.assert_array_equal(columns["feature"], contacts.feature)
    for name in ("distance", "point_a", "point_b", "normal"):
        np.testing.assert_array_equal(columns[name], getattr(contacts, name).astype(np.float32))
    world.set_stream(None)


def test_contacts_on_the_device_without_a_stream():
    torch = pytest.importorskip("torch")
    world, bodies, places = tori("cuda")
    world.set_positions(bodies, places)
    for _ in range(5):
        contacts = world.detect()
        solids, _ = world.device_contacts()
        assert int(torch.from_dlpack(solids.count)[0]) == len(contacts) > 100
        assert solids.world_begins is None
    world.set_positions(bodies, places + np.float32([0.1, 0, 0]))
    world.detect()
    with pytest.raises(RuntimeError, match="earlier step"):
        solids.count  # noqa: B018


def test_contacts_come_when_they_are_asked_for():
    world, bodies, places = tori("cuda")
    world.set_positions(bodies, places)
    early, late = world.detect(), world.contacts
    normal, copy = early.normal, early.normal.copy()
    world.set_positions(bodies, places + np.float32([0.1, 0, 0]))
    assert len(world.detect()) > 100
    np.testing.assert_array_equal(normal, copy)
    with pytest.raises(RuntimeError, match="earlier step on a device"):
        late.normal  # noqa: B018


def test_lists_that_do_not_fit():
    world, bodies, places = tori("cuda", 2)
    for _, there in packages():
        with pytest.raises(ValueError, match="600 vertices, got 599"):
            world.set_positions(bodies, there(places[:-1]))
        with pytest.raises(TypeError, match="float64"):
            world.set_positions(bodies, there(places.astype(np.float64)))
