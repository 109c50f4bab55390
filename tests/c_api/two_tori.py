"""Two tori through the C API, with Python's standard library alone: two_tori.py LIBRARY

Checks the contact list against what Python reads of it by itself: the count, the layout, the hash.
Prints nothing if all is well."""

import ctypes
import math
import struct
import sys
from ctypes import POINTER, byref, c_double, c_float, c_int32, c_size_t, c_uint8, c_uint16, c_uint32, c_uint64, sizeof


class Contact(ctypes.Structure):
    _fields_ = [
        ("a", c_uint64), ("b", c_uint64),
        ("source", c_uint8), ("grazing", c_uint8), ("found", c_uint8), ("reprojected", c_uint8),
        ("of_sheet", c_uint8), ("unknown_side", c_uint8), ("padding_a", c_uint16),
        ("vertex", c_uint32), ("edge_end", c_uint32), ("edge", c_uint32), ("chord", c_uint32),
        ("other_edge", c_uint32), ("triangle", c_uint32), ("age", c_uint32), ("padding_b", c_uint32),
        ("along", c_double), ("time", c_double), ("distance", c_double),
        ("barycentric", c_double * 3), ("point_a", c_double * 3), ("point_b", c_double * 3),
        ("normal", c_double * 3), ("face_normal", c_double * 3), ("padding_c", c_double)]


class ContactList(ctypes.Structure):
    _fields_ = [("contacts", POINTER(Contact)), ("count", c_size_t), ("stride", c_size_t)]


class Settings(ctypes.Structure):
    _fields_ = [
        ("struct_size", c_size_t),
        ("open_body_range", c_double), ("margin", c_double), ("prediction_distance", c_double),
        ("walk_threshold", c_double), ("coverage", c_uint32), ("temporal", c_uint32),
        ("full_every", c_uint32), ("reproject", c_uint32), ("may_rest", c_uint32), ("predict", c_uint32)]


class BackendOptions(ctypes.Structure):
    _fields_ = [
        ("struct_size", c_size_t), ("kind", c_uint32), ("threads", c_int32), ("tree_builder", c_uint32),
        ("rebuild", c_uint32), ("stage_by_stage", c_uint32), ("parts", c_uint32),
        ("host_share", c_double)]


library = ctypes.CDLL(sys.argv[1])
library.pierce_last_error.restype = ctypes.c_char_p
library.pierce_version.restype = ctypes.c_char_p
library.pierce_destroy_world.restype = None


def works(status):
    assert status == 0, library.pierce_last_error().decode()


def torus(around=24, across=12):
    """Positions and triangles of a torus around the z axis, with radii 1 and 0.4."""
    positions, triangles = [], []
    for i in range(around):
        for k in range(across):
            u, v = 2 * math.pi * i / around, 2 * math.pi * k / across
            positions += [(1 + 0.4 * math.cos(v)) * math.cos(u), (1 + 0.4 * math.cos(v)) * math.sin(u),
                          0.4 * math.sin(v)]
            j, l = (i + 1) % around, (k + 1) % across
            a, b, c, d = i * across + k, j * across + k, j * across + l, i * across + l
            triangles += [a, b, c, a, c, d]
    return (c_float * len(positions))(*positions), (c_uint32 * len(triangles))(*triangles)


def feature(c):
    """pierce_contact_feature() once more: names a contact within its pair."""
    is_edge, near, tangled = c.edge_end != 0xffffffff, c.found == 4, c.found == 7
    near_edges = not c.of_sheet and is_edge and near
    if tangled:
        other = c.triangle
    elif c.of_sheet:
        other = c.other_edge if is_edge else c.triangle
    else:
        other = c.other_edge if near_edges else c.chord
    item = c.edge if is_edge else c.vertex
    return item << 34 | other << 4 | (tangled or near_edges) << 3 | c.of_sheet << 2 | is_edge << 1 | c.source


def bits(number):
    return struct.unpack("<Q", struct.pack("<d", number + 0.0))[0]


def hash_of(contacts):
    """pierce_contact_hash() once more: 64-bit FNV-1a over the bits of every field but two."""
    value = 0xcbf29ce484222325
    for c in contacts:
        numbers = [(c.a & 0xffffffff) << 32 | c.b & 0xffffffff, c.a >> 32 << 32 | c.b >> 32,
                   c.of_sheet << 4 | c.unknown_side << 3 | c.reprojected << 2 | c.grazing << 1 | c.source,
                   c.vertex << 32 | c.edge_end, c.edge << 32 | c.chord, c.other_edge << 32 | c.triangle,
                   bits(c.along), bits(c.time)]
        for vector in (c.barycentric, c.point_a, c.point_b, c.normal, c.face_normal):
            numbers += [bits(x) for x in vector]
        for number in numbers + [bits(c.distance)]:
            for byte in struct.pack("<Q", number & 0xffffffffffffffff):
                value = (value ^ byte) * 0x100000001b3 & 0xffffffffffffffff
    return value


def contacts_on(kind):
    """The contacts of the two tori on a backend, the hash that the library has of them, and copies."""
    settings, options = Settings(), BackendOptions()
    works(library.pierce_default_settings(byref(settings), c_size_t(sizeof(settings))))
    works(library.pierce_default_backend_options(byref(options), c_size_t(sizeof(options))))
    assert settings.struct_size == sizeof(Settings) and settings.coverage == 2 and settings.reproject == 1
    options.kind = kind
    world, mesh, below, above = ctypes.c_void_p(), c_uint64(), c_uint64(), c_uint64()
    works(library.pierce_create_world(byref(settings), byref(options), byref(world)))
    positions, triangles = torus()
    works(library.pierce_add_mesh(world, b"torus", positions, c_size_t(len(positions) // 3), triangles,
                                  c_size_t(len(triangles) // 3), None, byref(mesh)))
    works(library.pierce_add_fixed_body(world, mesh, None, byref(below)))
    pose = (c_double * 7)(0.3, 0.1, 0.5, 0.1, 0.2, 0.05, 1)
    works(library.pierce_add_rigid_body(world, mesh, pose, byref(above)))
    works(library.pierce_detect(world))
    found = ContactList()
    works(library.pierce_contacts(world, byref(found)))
    assert found.stride == sizeof(Contact) == 208
    value = c_uint64()
    works(library.pierce_contact_hash(byref(found), byref(value)))
    copies = [Contact.from_buffer_copy(found.contacts[i]) for i in range(found.count)]
    for c in copies:
        assert (c.a, c.b) == (below.value, above.value)
        own = c_uint64()
        works(library.pierce_contact_feature(byref(c), byref(own)))
        assert own.value == feature(c)
        assert abs(sum((q - p) * n for p, q, n in zip(c.point_a, c.point_b, c.normal)) - c.distance) < 1e-6
    # A number whose body was removed is an error, and the world goes on.
    works(library.pierce_remove_body(world, above))
    assert library.pierce_set_pose(world, above, pose) == 1
    assert b"was removed" in library.pierce_last_error()
    works(library.pierce_detect(world))
    works(library.pierce_contacts(world, byref(found)))
    assert found.count == 0
    library.pierce_destroy_world(world)
    return copies, value.value


def sizes_are_the_librarys():
    """The library refuses a struct that is smaller than its own, and takes one of the same size."""
    for name, struct_type in ("settings", Settings), ("backend_options", BackendOptions):
        fill = getattr(library, "pierce_default_" + name)
        room = ctypes.create_string_buffer(sizeof(struct_type))
        works(fill(room, c_size_t(sizeof(struct_type))))
        assert fill(room, c_size_t(sizeof(struct_type) - 1)) == 1


sizes_are_the_librarys()
contacts, library_hash = contacts_on(kind=0)
assert len(contacts) > 10
assert hash_of(contacts) == library_hash
of_reference, reference_hash = contacts_on(kind=1)
assert len(of_reference) == len(contacts) and reference_hash == library_hash
assert hash_of(contacts[1:]) != library_hash
