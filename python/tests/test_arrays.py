"""Arrays of any shape, type, order and life: they are read as they are, or refused in words."""

import ctypes

import numpy as np
import pierce
import pytest
from conftest import torus


def refused(kind, text, call, *arguments):
    with pytest.raises(kind, match=text):
        call(*arguments)


def test_positions(two_tori):
    world, _, soft, positions = two_tori
    expected = world.detect().hash
    wide = np.zeros((300, 4), np.float32)
    for array, kind, text in [
        (positions[:, :2], ValueError, r"positions: expected shape \(n, 3\), got float32"),
        (positions.ravel(), ValueError, r"got float32 of shape \(900,\)"),
        (positions.astype(np.float64), TypeError, "expected float32 .*got float64"),
        (positions.astype(np.int32), TypeError, "got int32"),
        (wide[:, :3], ValueError, "C order"),
        (np.asfortranarray(positions), ValueError, "C order"),
        (positions[::-1], ValueError, "C order"),
        (positions[:-1], pierce.InputError, "300 vertices, got 299"),
        (np.empty((0, 3), np.float32), pierce.InputError, "got 0"),
        ("positions", TypeError, "expected an array"),
        (None, TypeError, "expected an array"),
        (positions.tolist(), TypeError, "expected an array"),
        (np.array([object()] * 3), TypeError, "expected an array|expected float32"),
    ]:
        refused(kind, text, world.set_positions, soft, array)
    assert world.detect().hash == expected
    world.set_positions(soft, np.full((300, 3), np.nan, np.float32))
    assert len(world.detect()) == 0 and world.stats.excluded_bodies == 1


def test_poses(two_tori):
    world, rigid, soft, _ = two_tori
    pose = np.array([[0, 0, 0.1, 0, 0, 0, 1]])
    for array in (pose, pose.astype(np.float32)):
        world.set_poses([rigid], array)
        world.set_poses(pierce.ids([rigid]), array)
    refused(ValueError, "1 bodies need as many poses, got 2", world.set_poses, [rigid],
            np.repeat(pose, 2, 0))  # fmt: skip
    refused(TypeError, "poses: expected float32 or float64", world.set_poses, [rigid],
            pose.astype(np.int64))  # fmt: skip
    refused(ValueError, r"shape \(n, 7\)", world.set_poses, [rigid], pose[:, :6])
    refused(pierce.InputError, "deforms", world.set_poses, [soft], pose)
    refused(TypeError, "bodies: expected BodyId, got str", world.set_poses, ["a"], pose)
    refused(TypeError, "bodies: expected uint64", world.set_poses, np.array([1]), pose)
    refused(pierce.InputError, "handle", world.set_poses, np.array([77], np.uint64), pose)
    refused(ValueError, "seven numbers", world.set_pose, rigid, [1, 2, 3])
    world.set_pose(rigid, np.eye(4))
    for wrong in (np.diag([1, 1, 2, 1]), np.diag([1, 1, -1, 1]), np.ones((4, 4)), np.eye(4) * 2):
        refused(ValueError, "scales, shears or mirrors", world.set_pose, rigid, wrong)


def test_a_matrix_is_the_pose_it_says(two_tori):
    world, rigid, _, _ = two_tori
    random = np.random.default_rng(5)
    for _ in range(50):
        q = random.normal(size=4)
        q /= np.linalg.norm(q)
        x, y, z, w = q
        matrix = np.eye(4)
        matrix[:3, :3] = [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
        matrix[:3, 3] = random.normal(size=3)
        world.set_pose(rigid, [*matrix[:3, 3], *q])
        expected = world.vertex_position(rigid, 7)
        world.set_pose(rigid, matrix)
        np.testing.assert_allclose(world.vertex_position(rigid, 7), expected, atol=1e-12)
        np.testing.assert_array_equal(
            world.vertex_positions(rigid)[7], world.vertex_position(rigid, 7)
        )


def test_positions_are_copied(two_tori):
    world, _, soft, positions = two_tori
    expected = world.detect().hash
    positions[:] = 0  # the caller's array is the caller's
    positions.resize((3, 3), refcheck=False)
    del positions
    assert world.detect().hash == expected


class OnDevice:
    """An array that says it is in the memory of a CUDA device."""

    def __init__(self, shape, typestr="<f4", strides=None):
        self.__cuda_array_interface__ = {
            "shape": shape, "typestr": typestr, "data": (4096, False), "version": 3,
            "strides": strides,
        }  # fmt: skip


def test_arrays_of_a_device_need_a_world_there(two_tori):
    world, rigid, soft, _ = two_tori
    expected = world.detect().hash
    refused(pierce.InputError, "device", world.set_positions, soft, OnDevice((300, 3)))
    refused(pierce.InputError, "device", world.set_poses, [rigid], OnDevice((1, 7)))
    refused(ValueError, "300 vertices, got 299", world.set_positions, soft, OnDevice((299, 3)))
    refused(ValueError, "C order", world.set_positions, soft, OnDevice((300, 3), strides=(24, 4)))
    refused(TypeError, "CUDA arrays of '<i4'", world.set_positions, soft, OnDevice((300, 3), "<i4"))
    refused(pierce.InputError, "device", world.set_stream, 4096)
    refused(pierce.InputError, "device", world.device_contacts)
    assert world.detect().hash == expected


@pytest.mark.parametrize(
    "mesh, kind, text",
    [
        (([[0, 0, 0]], [[0, 0, 0.5]]), TypeError, "whole numbers"),
        (([[0, 0, 0]], [0, 0, 0]), ValueError, r"triangles: expected shape \(n, 3\)"),
        (([[0, 0]], [[0, 0, 0]]), ValueError, r"vertices: expected shape \(n, 3\)"),
        (([[0, 0, 0]], [[0, 0, -1]]), pierce.InputError, "vertex"),
        (([[0, 0, 0]], [[0, 0, 2**40]]), pierce.InputError, "vertex"),
        (([[0, 0, np.nan]], [[0, 0, 0]]), pierce.InputError, "finite"),
        (np.zeros((3, 3)), TypeError, "mesh: expected a Mesh"),
    ],
)
def test_meshes(mesh, kind, text):
    refused(kind, text, pierce.World("reference").add_mesh, mesh)


def test_handles_of_what_was_removed(two_tori):
    world, rigid, soft, _ = two_tori
    world.remove_body(soft)
    for call in (world.remove_body, world.mesh_of, world.collision_of):
        refused(pierce.InputError, "body", call, soft)
    refused(pierce.InputError, "null", world.mesh_of, pierce.BodyId())


def test_arrays_of_ctypes(two_tori):
    """They leave the strides of their buffer out."""
    world, rigid, soft, positions = two_tori
    expected = world.detect().hash
    points = (ctypes.c_float * 3 * 300).from_buffer_copy(positions.tobytes())
    pose = (ctypes.c_double * 7 * 1)((0, 0, 0, 0, 0, 0, 1))
    before = world.pose_of(rigid)
    world.set_positions(soft, points)
    world.set_motion(soft, points, points)
    handle = int(pierce.ids([rigid])[0])
    world.set_poses((ctypes.c_uint64 * 1)(handle), pose)
    assert world.pose_of(rigid).position == (0, 0, 0)
    world.set_pose(rigid, before)
    world.set_positions(soft, points)
    assert world.detect().hash == expected
    refused(ValueError, "got float32 of shape", world.set_positions, soft, (ctypes.c_float * 900)())
    refused(TypeError, "positions: expected", world.set_positions, soft, (ctypes.c_void_p * 5)())


def test_arrays_of_other_packages(two_tori):
    world, _, soft, positions = two_tori
    expected = world.detect().hash
    for name in ("torch", "warp", "jax"):
        try:
            package = __import__(name)
        except ImportError:
            continue
        if name == "torch":
            array = package.from_numpy(positions.copy())
        elif name == "warp":
            array = package.array(positions, dtype=package.vec3, device="cpu")
        else:
            array = package.device_put(positions, package.devices("cpu")[0])
        world.set_positions(soft, array)
        assert world.detect().hash == expected, name


@pytest.mark.parametrize(
    "field, value", [("data", ()), ("strides", ()), ("strides", (13, 4)), ("strides", (12, 3))]
)
def test_a_cuda_array_that_is_described_wrongly_is_refused(field, value):
    class Described:
        __cuda_array_interface__ = {  # noqa: RUF012
            "typestr": "<f4",
            "shape": (4, 3),
            "data": (4096, False),
            "version": 3,
            field: value,
        }

    world = pierce.World("reference")
    body = world.add_deforming_body(world.add_mesh(torus()))
    with pytest.raises(ValueError, match=f"has a wrong '{field}'"):
        world.set_positions(body, Described())
