#include "world.hpp"

#include <nanobind/stl/map.h>

#include <optional>
#include <sstream>
#include <string>

#include "arrays.hpp"
#include "contacts.hpp"
#include "mesh.hpp"
#include "pierce/error.hpp"
#include "records.hpp"
#include "scenes/detect/method.hpp"

namespace pierce::python {

void KeptArrays::keep(std::span<const BodyId> bodies, nb::object array) {
    std::uint32_t slot = 0;
    if (array.is_valid()) {
        while (slot < slots_.size() && slots_[slot].bodies > 0) ++slot;
        if (slot == slots_.size()) slots_.emplace_back();
        slots_[slot].array = std::move(array);
        ++slot;
    } else if (slot_of_.empty()) {
        return;
    }
    for (const BodyId body : bodies) {
        if (body.index >= slot_of_.size()) slot_of_.resize(body.index + 1, 0);
        const std::uint32_t last = slot_of_[body.index];
        slot_of_[body.index] = slot;
        if (slot > 0) ++slots_[slot - 1].bodies;
        if (last > 0 && --slots_[last - 1].bodies == 0) slots_[last - 1].array.reset();
    }
}

bool PyWorld::wants(BodyId a, BodyId b) {
    const nb::gil_scoped_acquire gil;
    try {
        const int answer = PyObject_IsTrue(nb::object(filter(a, b)).ptr());
        if (answer < 0) throw nb::python_error();
        return answer == 1;
    } catch (...) {
        if (failure == nullptr) failure = std::current_exception();
        return false;
    }
}

namespace {

void make_world(PyWorld* self, const std::string& backend, int threads, nb::object settings,
                const nb::kwargs& fields) {
    nb::object all = nb::cast(settings.is_none() ? Settings{} : nb::cast<Settings>(settings));
    set_fields(all, fields);
    scenes::RaySettings rays;
    rays.backend = backend == "auto" ? "automatic" : backend;
    rays.threads = threads;
    std::unique_ptr<Backend> made = scenes::make_backend(rays);
    const bool on_device = made->runs_on_device();
    new (self)
        PyWorld(std::make_shared<World>(std::move(made), nb::cast<Settings>(all)), on_device);
}

/// The address of a stream: a number, or what PyTorch, CuPy, Warp and the CUDA protocol call it.
void* stream_address(nb::handle stream) {
    if (stream.is_none()) return nullptr;
    nb::object number = nb::borrow(stream);
    for (const char* name : {"cuda_stream", "ptr"})
        if (nb::hasattr(stream, name)) number = stream.attr(name);
    if (nb::hasattr(stream, "__cuda_stream__")) number = stream.attr("__cuda_stream__")()[1];
    // NOLINTNEXTLINE(performance-no-int-to-ptr): streams are addresses
    return reinterpret_cast<void*>(nb::cast<std::uintptr_t>(number));
}

void set_positions(PyWorld& self, nb::handle bodies, nb::handle positions) {
    const std::vector<BodyId> ids = bodies_of(bodies);
    const Rows rows = rows_of(array_of(positions, "positions"), 3, "positions", false);
    const Use world(self);
    if (!rows.on_device) {
        world->set_positions(ids, rows.vectors());
        self.places.keep(ids, {});
        self.starts.keep(ids, {});
        return;
    }
    std::size_t vertices = 0;
    for (const BodyId body : ids) vertices += world->mesh(world->mesh_of(body)).positions().size();
    if (vertices != rows.count)
        throw nb::value_error(("positions: these bodies have " + std::to_string(vertices) +
                               " vertices, got " + std::to_string(rows.count) + " rows")
                                  .c_str());
    world->set_device_positions(ids, static_cast<const Vec3f*>(rows.data));
    self.places.keep(ids, nb::borrow(positions));
    self.starts.keep(ids, {});
}

void set_poses(PyWorld& self, nb::handle bodies, nb::handle poses) {
    const std::vector<BodyId> ids = bodies_of(bodies);
    const Rows rows = rows_of(array_of(poses, "poses"), 7, "poses", true);
    if (rows.count != ids.size())
        throw nb::value_error((std::to_string(ids.size()) + " bodies need as many poses, got " +
                               std::to_string(rows.count))
                                  .c_str());
    const Use world(self);
    if (rows.on_device && rows.doubles)
        world->set_device_poses(ids, static_cast<const double*>(rows.data));
    else if (rows.on_device)
        world->set_device_poses(ids, static_cast<const float*>(rows.data));
    else if (rows.doubles)
        world->set_poses(ids, rows.numbers<double>(7));
    else
        world->set_poses(ids, rows.numbers<float>(7));
    self.places.keep(ids, rows.on_device ? nb::borrow(poses) : nb::object());
}

void set_motion(PyWorld& self, BodyId body, nb::handle start, nb::handle end) {
    const Use world(self);
    if (world->motion_of(body) != Motion::deforming)
        return world->set_motion(body, pose_of(start), pose_of(end));
    const Rows from = rows_of(array_of(start, "start"), 3, "start", false),
               to = rows_of(array_of(end, "end"), 3, "end", false);
    if (from.on_device != to.on_device)
        throw nb::value_error("start and end: expected both on the host, or both on the device");
    if (!from.on_device) {
        world->set_motion(body, from.vectors(), to.vectors());
    } else {
        const std::size_t vertices = world->mesh(world->mesh_of(body)).positions().size();
        if (from.count != vertices || to.count != vertices)
            throw nb::value_error(("start and end: this body has " + std::to_string(vertices) +
                                   " vertices, got " + std::to_string(from.count) + " and " +
                                   std::to_string(to.count) + " rows")
                                      .c_str());
        world->set_device_motion(body, static_cast<const Vec3f*>(from.data),
                                 static_cast<const Vec3f*>(to.data));
    }
    self.places.keep({&body, 1}, to.on_device ? nb::borrow(end) : nb::object());
    self.starts.keep({&body, 1}, from.on_device ? nb::borrow(start) : nb::object());
}

MeshId add_mesh(PyWorld& self, nb::handle mesh, const std::string& name, nb::handle inside,
                nb::handle before, const std::string& cache, std::uint32_t threads,
                nb::handle progress) {
    if (nb::isinstance<Mesh>(mesh)) {
        // The Python object lives as long as some world has its mesh.
        const nb::object owner = nb::borrow(mesh);
        auto* kept = new nb::object(owner);
        const std::shared_ptr<const Mesh> shared(&nb::cast<const Mesh&>(mesh), [kept](const Mesh*) {
            const nb::gil_scoped_acquire gil;
            delete kept;
        });
        return Use(self)->add_mesh(shared);
    }
    MeshData data = mesh_data_of(mesh);
    MeshOptions options = mesh_options(inside, cache, threads, progress);
    const Use world(self);
    const std::optional<MeshId> last = before.is_none() ? std::nullopt
                                                        : std::optional(nb::cast<MeshId>(before));
    const nb::gil_scoped_release release;
    return last ? world->add_mesh(name, std::move(data), *last, std::move(options))
                : world->add_mesh(name, std::move(data), std::move(options));
}

void set_pair_filter(PyWorld& self, nb::object filter) {
    const Use world(self);
    if (filter.is_none())
        world->set_pair_filter({});
    else
        world->set_pair_filter([&self](BodyId a, BodyId b) { return self.wants(a, b); });
    self.filter = filter.is_none() ? nb::object() : std::move(filter);
}

// A filter, such as a method of an object that has the world, may hold the world: the garbage
// collector has to see that.
int visit_world(PyObject* self, visitproc visit, void* arg) {
    Py_VISIT(Py_TYPE(self));
    if (!nb::inst_ready(self)) return 0;
    const PyWorld* world = nb::inst_ptr<PyWorld>(self);
    Py_VISIT(world->filter.ptr());
    Py_VISIT(world->stream.ptr());
    return 0;
}
int clear_world(PyObject* self) {
    PyWorld* world = nb::inst_ptr<PyWorld>(self);
    if (world->filter.is_valid()) world->world->set_pair_filter({});
    world->filter.reset();
    world->stream.reset();
    return 0;
}
PyType_Slot world_slots[] = {{Py_tp_traverse, reinterpret_cast<void*>(visit_world)},
                             {Py_tp_clear, reinterpret_cast<void*>(clear_world)},
                             {0, nullptr}};

std::vector<std::optional<RayHit>> cast_rays(PyWorld& self, Vec3d origin, nb::handle directions) {
    const nb::object numpy = nb::module_::import_("numpy");
    const nb::object numbers = numpy.attr("ascontiguousarray")(directions, numpy.attr("float64"));
    const Rows rows = rows_of(array_of(numbers, "directions"), 3, "directions", true);
    static_assert(sizeof(Vec3d) == 3 * sizeof(double));
    return Use(self)->cast_rays(origin, {static_cast<const Vec3d*>(rows.data), rows.count});
}

std::vector<std::optional<ProbeContact>> probe(PyWorld& self, nb::handle points, nb::handle normals,
                                               double radius, nb::handle others) {
    const nb::object numpy = nb::module_::import_("numpy");
    const nb::object f64 = numpy.attr("float64");
    const nb::object at = numpy.attr("ascontiguousarray")(points, f64),
                     out = numpy.attr("ascontiguousarray")(normals, f64);
    const Rows places = rows_of(array_of(at, "points"), 3, "points", true),
               ways = rows_of(array_of(out, "normals"), 3, "normals", true);
    const std::vector<BodyId> bodies = others.is_none() ? std::vector<BodyId>() : bodies_of(others);
    return Use(self)->probe({static_cast<const Vec3d*>(places.data), places.count},
                            {static_cast<const Vec3d*>(ways.data), ways.count}, radius, bodies);
}

nb::object contacts_now(nb::handle_t<PyWorld> self) {
    PyWorld& w = nb::cast<PyWorld&>(self);
    if (w.on_device && w.steps > 0) return nb::cast(Contacts(nb::borrow(self), w.steps));
    return nb::cast(Contacts(Use(w)->keep_contacts()));
}

nb::object contact_of(const Explanation& e) {
    if (!e.contact) return nb::none();
    const auto copy = std::make_shared<Contact>(*e.contact);
    return nb::cast(Contacts({std::shared_ptr<const Contact>(copy), 1}));
}

void bind_bodies(nb::class_<PyWorld>& c) {
    c.def("add_mesh", add_mesh, nb::arg("mesh"), nb::arg("name") = "mesh",
          nb::arg("inside") = "automatic", nb::arg("before") = nb::none(), nb::arg("cache") = "",
          nb::arg("threads") = 0, nb::arg("progress") = nb::none(),
          "Checks and keeps a mesh: a Mesh, which worlds share, a trimesh or meshio mesh, or a "
          "pair (vertices (n, 3), triangles (m, 3)). `before`: the mesh that it was before it was "
          "cut, torn or grown. Raises InputError.")
        .def(
            "remove_mesh", [](PyWorld& w, MeshId mesh) { Use(w)->remove_mesh(mesh); },
            nb::arg("mesh"), "Raises InputError while a body uses the mesh.")
        .def(
            "mesh", [](PyWorld& w, MeshId mesh) -> const Mesh& { return Use(w)->mesh(mesh); },
            nb::arg("mesh"), nb::rv_policy::reference_internal, "The mesh of a handle.")
        .def(
            "add_fixed_body",
            [](PyWorld& w, MeshId mesh, nb::handle pose) {
                const Pose place = pose.is_none() ? Pose{} : pose_of(pose);
                return Use(w)->add_fixed_body(mesh, place);
            },
            nb::arg("mesh"), nb::arg("pose") = nb::none(),
            "Adds a body that does not move. `pose`: seven numbers (position, quaternion x y z w), "
            "a 4 x 4 matrix or a Pose.")
        .def(
            "add_rigid_body",
            [](PyWorld& w, MeshId mesh, nb::handle pose) {
                const Pose place = pose.is_none() ? Pose{} : pose_of(pose);
                return Use(w)->add_rigid_body(mesh, place);
            },
            nb::arg("mesh"), nb::arg("pose") = nb::none(), "Adds a body that moves by its pose.")
        .def(
            "add_deforming_body",
            [](PyWorld& w, MeshId mesh, nb::handle positions) {
                const std::vector<Vec3f> at = positions.is_none()
                                                  ? std::vector<Vec3f>()
                                                  : positions_of(positions, "positions");
                return Use(w)->add_deforming_body(mesh, at);
            },
            nb::arg("mesh"), nb::arg("positions") = nb::none(),
            "Adds a body whose vertices are given in world space; they start at the rest "
            "positions.")
        .def(
            "remove_body", [](PyWorld& w, BodyId body) { Use(w)->remove_body(body); },
            nb::arg("body"), "The handle never becomes valid again.")
        .def(
            "mesh_of", [](PyWorld& w, BodyId body) { return Use(w)->mesh_of(body); },
            nb::arg("body"), "The handle of a body's mesh.")
        .def(
            "motion_of", [](PyWorld& w, BodyId body) { return Use(w)->motion_of(body); },
            nb::arg("body"), "How a body moves.")
        .def(
            "vertex_position",
            [](PyWorld& w, BodyId body, std::uint32_t v) {
                return Use(w)->vertex_position(body, v);
            },
            nb::arg("body"), nb::arg("vertex"), "[length] where a vertex is now, world space.")
        .def(
            "set_collision",
            [](PyWorld& w, BodyId body, const Collision& collision) {
                Use(w)->set_collision(body, collision);
            },
            nb::arg("body"), nb::arg("collision"),
            "Sets what the body is in contact with besides solids that it overlaps.")
        .def(
            "collision_of", [](PyWorld& w, BodyId body) { return Use(w)->collision_of(body); },
            nb::arg("body"), "A copy.");
}

void bind_filters(nb::class_<PyWorld>& c) {
    c.def(
         "set_filter",
         [](PyWorld& w, BodyId body, const Filter& filter) { Use(w)->set_filter(body, filter); },
         nb::arg("body"), nb::arg("filter"), "Sets which other bodies the body meets.")
        .def(
            "filter_of", [](PyWorld& w, BodyId body) { return Use(w)->filter_of(body); },
            nb::arg("body"), "A copy.")
        .def(
            "exclude", [](PyWorld& w, BodyId a, BodyId b) { Use(w)->exclude(a, b); }, nb::arg("a"),
            nb::arg("b"), "Leaves out a pair until include().")
        .def(
            "include", [](PyWorld& w, BodyId a, BodyId b) { Use(w)->include(a, b); }, nb::arg("a"),
            nb::arg("b"), "Takes a pair in again.")
        .def("set_pair_filter", set_pair_filter, nb::arg("filter").none(),
             nb::sig("def set_pair_filter(self, filter: collections.abc.Callable[[BodyId, BodyId], "
                     "object] | None) -> None"),
             "Asks filter(a, b) once a step for every pair whose boxes overlap; None asks nothing. "
             "What it raises is raised by detect(), and the pair is left out. Not on a device.")
        .def(
            "worlds", [](PyWorld& w) { return Use(w)->worlds(); },
            "The worlds that bodies are in, sorted, without all_worlds.")
        .def(
            "bodies_of", [](PyWorld& w, std::int32_t world) { return Use(w)->bodies_of(world); },
            nb::arg("world"), "The bodies of a world.")
        .def(
            "replicate",
            [](PyWorld& w, std::int32_t world, std::uint32_t count) {
                return Use(w)->replicate(world, count);
            },
            nb::arg("world"), nb::arg("count"),
            "Copies the bodies of a world into `count` new ones; returns the first one's number.")
        .def(
            "copy_places",
            [](PyWorld& w, std::int32_t from, std::int32_t to) { Use(w)->copy_places(from, to); },
            nb::arg("source"), nb::arg("target"),
            "Puts the bodies of a world where those of another one are: a reset.")
        .def(
            "remove_world", [](PyWorld& w, std::int32_t world) { Use(w)->remove_world(world); },
            nb::arg("world"), "Removes its bodies.")
        .def(
            "set_world_active",
            [](PyWorld& w, std::int32_t world, bool active) {
                Use(w)->set_world_active(world, active);
            },
            nb::arg("world"), nb::arg("active"), "Leaves a world out of steps, or takes it in.")
        .def(
            "world_offsets", [](PyWorld& w) { return Use(w)->world_offsets(); },
            "Which of the last step's contacts are of which world.");
}

void bind_places(nb::class_<PyWorld>& c) {
    c.def(
         "set_pose",
         [](PyWorld& w, BodyId body, nb::handle pose) {
             const Pose place = pose_of(pose);
             Use(w)->set_pose(body, place);
             w.places.keep({&body, 1}, {});
         },
         nb::arg("body"), nb::arg("pose"),
         "Moves a fixed or rigid body: seven numbers (position, quaternion x y z w), a 4 x 4 "
         "matrix or a Pose.")
        .def("set_poses", set_poses, nb::arg("bodies"), nb::arg("poses").none(),
             "Moves many: float32 or float64 (n, 7) in C order, on the host, or on the device, "
             "where steps read them until others are set. `bodies`: handles, or ids().")
        .def("set_positions", set_positions, nb::arg("bodies"), nb::arg("positions").none(),
             "Moves the vertices of a deforming body, or of many that follow each other: float32 "
             "(n, 3) in C order, on the host, or on the device, where steps read them until others "
             "are set.")
        .def("set_motion", set_motion, nb::arg("body"), nb::arg("start"), nb::arg("end"),
             "Sets where a body is, and where it was when the step began: two poses, or two arrays "
             "of positions.")
        .def(
            "set_stream",
            [](PyWorld& w, nb::object stream) {
                Use(w)->set_stream(stream_address(stream));
                w.stream = std::move(stream);
            },
            nb::arg("stream").none(),
            "Names the CUDA stream on which places are written and contacts read: an address, or "
            "a stream of PyTorch, CuPy or Warp; None: none.")
        .def(
            "set_mesh",
            [](PyWorld& w, BodyId body, MeshId mesh, nb::handle positions) {
                if (positions.is_none()) return Use(w)->set_mesh(body, mesh);
                const Rows rows = rows_of(array_of(positions, "positions"), 3, "positions", false);
                if (rows.on_device) throw nb::value_error("positions: expected them on the host");
                Use(w)->set_mesh(body, mesh, rows.vectors());
            },
            nb::arg("body"), nb::arg("mesh"), nb::arg("positions") = nb::none(),
            "Gives a body another mesh; a deforming one needs positions, float32 (n, 3).")
        .def(
            "forget_sides", [](PyWorld& w) { Use(w)->forget_sides(); },
            "The next step assumes that no sheet is through anything as it begins.");
}

void bind_steps(nb::class_<PyWorld>& c) {
    c.def("detect", detect, nb::sig("def detect(self) -> Contacts"),
          "Runs one step: finds all contacts of the bodies where they are now. Other threads run "
          "meanwhile.")
        .def_prop_ro("contacts", contacts_now, nb::sig("def contacts(self) -> Contacts"),
                     "Those of the last step.")
        .def(
            "device_contacts",
            [](nb::handle_t<PyWorld> self) {
                const Use world(nb::cast<PyWorld&>(self));
                const DeviceContacts found = world->device_contacts();
                return nb::make_tuple(DeviceList{found.solids, nb::borrow(self)},
                                      DeviceList{found.sheets, nb::borrow(self)});
            },
            nb::sig("def device_contacts(self) -> tuple[DeviceContactList, DeviceContactList]"),
            "The last step's contacts in device memory, of solids and of sheets, without waiting.")
        .def_prop_ro(
            "stats", [](PyWorld& w) { return Use(w)->stats(); }, "Of the last step, a copy.")
        .def_prop_ro(
            "plan", [](PyWorld& w) { return Use(w)->plan(); },
            "Which stages steps run, and which rules do not apply, a copy.")
        .def_prop_ro(
            "backend", [](PyWorld& w) { return Use(w)->backend(); }, "For people.")
        .def_prop_ro(
            "on_device", [](PyWorld& w) { return w.on_device; }, "Steps run on a GPU.")
        .def(
            "body_boxes", [](PyWorld& w) { return Use(w)->body_boxes(); },
            "The boxes of all bodies that took part in the last step.")
        .def(
            "save",
            [](PyWorld& w) {
                std::ostringstream out(std::ios::binary);
                Use(w)->save(out);
                const std::string bytes = out.str();
                return nb::bytes(bytes.data(), bytes.size());
            },
            "The world as bytes, without contacts.")
        .def_static(
            "restore",
            [](nb::bytes saved, const std::string& backend, int threads) {
                scenes::RaySettings rays;
                rays.backend = backend == "auto" ? "automatic" : backend;
                rays.threads = threads;
                std::unique_ptr<Backend> made = scenes::make_backend(rays);
                const bool on_device = made->runs_on_device();
                std::istringstream in(std::string(saved.c_str(), saved.size()), std::ios::binary);
                return std::make_shared<PyWorld>(
                    std::make_shared<World>(World::restore(in, std::move(made))), on_device);
            },
            nb::arg("saved"), nb::arg("backend") = "auto", nb::arg("threads") = 0,
            "Makes a world from what save() has returned. Handles stay valid.");
}

void bind_questions(nb::class_<PyWorld>& c) {
    c.def(
         "explain",
         [](PyWorld& w, BodyId body, BodyId other, std::uint32_t vertex) {
             return Use(w)->explain(body, other, vertex);
         },
         nb::arg("body"), nb::arg("other"), nb::arg("vertex"),
         "Says why a vertex has a contact with another body after the last step, or none.")
        .def(
            "parting", [](PyWorld& w, BodyId a, BodyId b) { return Use(w)->parting(a, b); },
            nb::arg("a"), nb::arg("b"),
            "How far b has to move, and where to, until it does not overlap a; None if it does "
            "not.")
        .def(
            "overlap",
            [](PyWorld& w, BodyId a, BodyId b, double same_direction) {
                return Use(w)->overlap(a, b, same_direction);
            },
            nb::arg("a"), nb::arg("b"), nb::arg("same_direction") = 0.9,
            "What two solids have in common: volume, areas, patches; None if they have no volume "
            "in common.")
        .def(
            "impacts", [](PyWorld& w) { return Use(w)->impacts(); },
            "The first meeting of every pair of solids that are apart as the step begins.")
        .def("cast_rays", cast_rays, nb::arg("origin"), nb::arg("directions"),
             "The first body along each line of sight, as RayHit or None.")
        .def("probe", probe, nb::arg("points"), nb::arg("normals"), nb::arg("radius"),
             nb::arg("others") = nb::none(),
             "What touches the points of a sensor, as ProbeContact or None.");
}

template <class Tag>
void bind_handle(nb::module_& module, const char* name, const char* doc) {
    using Handle = Id<Tag>;
    const auto number = [](const Handle& id) {
        return std::uint64_t{id.generation} << 32 | id.index;
    };
    nb::class_<Handle>(module, name, doc)
        .def(
            "__init__",
            [](Handle* self, std::uint64_t given) {
                new (self) Handle{static_cast<std::uint32_t>(given),
                                  static_cast<std::uint32_t>(given >> 32)};
            },
            nb::arg("number") = 0)
        .def_prop_ro(
            "index", [](const Handle& id) { return id.index; }, "Its slot in the world.")
        .def_prop_ro(
            "generation", [](const Handle& id) { return id.generation; }, "0: null.")
        .def("__int__", number)
        .def("__index__", number)
        .def("__bool__", [](const Handle& id) { return static_cast<bool>(id); })
        .def("__hash__", number)
        .def(
            "__eq__", [](const Handle& a, const Handle& b) { return a == b; }, nb::is_operator(),
            nb::arg("other"), nb::sig("def __eq__(self, other: object, /) -> bool"))
        .def(
            "__lt__", [](const Handle& a, const Handle& b) { return a < b; }, nb::arg("other"))
        .def("__repr__", [name](const Handle& id) {
            return std::string(name) + "(" + std::to_string(id.index) +
                   (id.generation > 1 ? ", generation " + std::to_string(id.generation) : "") + ")";
        });
}

}  // namespace

nb::object detect(nb::handle_t<PyWorld> self) {
    PyWorld& w = nb::cast<PyWorld&>(self);
    const Use world(w);
    {
        const nb::gil_scoped_release release;
        world->detect();
    }
    if (w.failure != nullptr) std::rethrow_exception(std::exchange(w.failure, nullptr));
    ++w.steps;
    if (w.on_device) return nb::cast(Contacts(nb::borrow(self), w.steps));
    return nb::cast(Contacts(world->keep_contacts()));
}

void bind_world(nb::module_& module) {
    bind_handle<BodyTag>(module, "BodyId",
                         "A handle of a body; as a number, index + generation * "
                         "2**32.");
    bind_handle<MeshTag>(module, "MeshId", "A handle of a mesh.");
    Record<Explanation>(module, "Explanation", "Why a vertex has a contact, or none.")
        .ro("reason", &Explanation::reason, "Reason")
        .ro("distance", &Explanation::distance, "[length] from the other body, as far as known")
        .ro("t", &Explanation::t, "[length] where the ray first crosses the other body")
        .ro("own_exit", &Explanation::own_exit, "[length] where the ray leaves its own body")
        .ro("triangle", &Explanation::triangle, "of the other body, at `t`")
        .ro("certificate", &Explanation::certificate, "if the step remembers")
        .get("contact", contact_of, "Contacts of one, or None",
             "def contact(self) -> Contacts | None")
        .get(
            "text", [](const Explanation& e) { return e.text(); }, "one or two sentences");
    nb::class_<PyWorld> c(
        module, "World", nb::type_slots(world_slots),
        "Bodies and their contacts. Methods have the names of the C++ class, whose pages say more. "
        "One thread uses a world at a time; worlds in different threads run side by side.");
    c.def(
         "__init__", make_world, nb::arg("backend") = "auto", nb::arg("threads") = 0,
         nb::arg("settings") = nb::none(), nb::arg("fields"),
         nb::sig("def __init__(self, backend: str = 'auto', threads: int = 0, settings: Settings | "
                 "None = None, **fields: object) -> None"),
         "`backend`: auto, embree, cuda, bvh or reference; `threads`: 0 is one per processor; "
         "`settings`: Settings, or their fields by name.")
        .def("__repr__", [](PyWorld& w) {
            const Use world(w);
            const Plan& plan = world->plan();
            return "<World on " + world->backend() + ": " + std::to_string(plan.fixed_bodies) +
                   " fixed, " + std::to_string(plan.rigid_bodies) + " rigid, " +
                   std::to_string(plan.deforming_bodies) + " deforming bodies>";
        });
    bind_bodies(c);
    bind_filters(c);
    bind_places(c);
    bind_steps(c);
    bind_questions(c);
}

}  // namespace pierce::python
