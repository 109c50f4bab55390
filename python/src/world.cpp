#include "world.hpp"

#include <bit>
#include <optional>
#include <sstream>
#include <string>

#include "arrays.hpp"
#include "casters.hpp"
#include "contacts.hpp"
#include "mesh.hpp"
#include "pierce/error.hpp"
#include "records.hpp"
#include "settings.hpp"
#include "without_gil.hpp"

namespace pierce::python {

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

void PyWorld::keep(Kept& kept, std::shared_ptr<nb::object> object) {
    if (std::has_single_bit(kept.size())) let_go(kept);
    if (object != nullptr) kept.push_back(std::move(object));
}

void PyWorld::let_go(Kept& kept) {
    // What lets go of an object may run Python, which may look at the list.
    Kept now, last = std::exchange(kept, {});
    for (std::shared_ptr<nb::object>& each : last)
        if (each.use_count() > 1) now.push_back(std::move(each));
    kept = std::move(now);
}

void PyWorld::rethrow() {
    if (failure != nullptr) std::rethrow_exception(std::exchange(failure, nullptr));
}

namespace {

void make_world(PyWorld* self, const std::string& backend, int threads, nb::handle settings,
                int parts, double host_share, const nb::kwargs& fields) {
    const Settings all = settings_from(settings, fields);
    std::unique_ptr<Backend> made = backend_named(backend, threads, parts, host_share);
    const bool on_device = made->runs_on_device();
    new (self) PyWorld(std::make_shared<World>(std::move(made), all), on_device);
}

MeshId add_mesh(PyWorld& self, nb::handle mesh, const std::string& name, nb::handle inside,
                nb::handle before, const std::string& cache, std::uint32_t threads,
                nb::handle progress) {
    if (nb::isinstance<Mesh>(mesh)) {
        if (!before.is_none() || !cache.empty() ||
            choice<Inside>(inside, "inside") != Inside::automatic)
            throw nb::value_error(
                "add_mesh: a Mesh is made already; `inside`, `before` and `cache` are for others");
        // The Python object lives as long as some world has its mesh.
        const std::shared_ptr<nb::object> object = shared_object(nb::borrow(mesh));
        const Use world(self);
        const MeshId id = world->add_mesh(
            std::shared_ptr<const Mesh>(object, &nb::cast<const Mesh&>(mesh)));
        PyWorld::keep(self.meshes, object);
        return id;
    }
    MeshData data = mesh_data_of(mesh);
    std::shared_ptr<nb::object> callback;
    MeshOptions options = mesh_options(inside, cache, threads, progress, &callback);
    const Use world(self);
    PyWorld::keep(self.progress, std::move(callback));
    const Mesh* last = nullptr;
    if (nb::isinstance<Mesh>(before))
        last = &nb::cast<const Mesh&>(before);
    else if (nb::isinstance<MeshId>(before))
        last = &world->mesh(nb::cast<MeshId>(before));
    else if (!before.is_none())
        throw nb::type_error("add_mesh: `before` is a MeshId or a Mesh");
    const WithoutGil without_gil;
    return last != nullptr ? world->add_mesh(std::make_shared<const Mesh>(
                                 name, std::move(data), *last, std::move(options)))
                           : world->add_mesh(name, std::move(data), std::move(options));
}

void set_pair_filter(PyWorld& self, nb::object filter) {
    if (!filter.is_none() && PyCallable_Check(filter.ptr()) == 0)
        throw nb::type_error("set_pair_filter: expected a function of two bodies, or None");
    const Use world(self);
    if (filter.is_none())
        world->set_pair_filter({});
    else
        world->set_pair_filter([&self](BodyId a, BodyId b) { return self.wants(a, b); });
    self.filter = filter.is_none() ? nb::object() : std::move(filter);
}

// A filter or a callback, such as a method of an object that has the world, may hold the world: the
// garbage collector has to see that.
int visit_world(PyObject* self, visitproc visit, void* arg) {
    Py_VISIT(Py_TYPE(self));
    if (!nb::inst_ready(self)) return 0;
    const PyWorld* world = nb::inst_ptr<PyWorld>(self);
    Py_VISIT(world->filter.ptr());
    Py_VISIT(world->stream.ptr());
    for (const PyWorld::Kept* kept : {&world->progress, &world->meshes})
        for (const std::shared_ptr<nb::object>& object : *kept) Py_VISIT(object->ptr());
    return 0;
}
int clear_world(PyObject* self) {
    PyWorld* world = nb::inst_ptr<PyWorld>(self);
    if (world->filter.is_valid()) world->world->set_pair_filter({});
    world->filter.reset();
    world->stream.reset();
    // The world points into the meshes; what they hold themselves breaks the cycle.
    for (const std::shared_ptr<nb::object>& callback : std::exchange(world->progress, {}))
        callback->reset();
    return 0;
}
PyType_Slot world_slots[] = {{Py_tp_traverse, reinterpret_cast<void*>(visit_world)},
                             {Py_tp_clear, reinterpret_cast<void*>(clear_world)},
                             {0, nullptr}};

/// Making it may measure meshes, which tells Python how far it is.
Plan plan_now(PyWorld& w) {
    const Use world(w);
    const WithoutGil without_gil;
    return world->plan();
}

nb::object contacts_now(nb::handle_t<PyWorld> self) {
    PyWorld& w = nb::cast<PyWorld&>(self);
    if (w.on_device && w.steps > 0) return nb::cast(Contacts(nb::borrow(self), w.steps));
    return nb::cast(Contacts(Use(w)->keep_contacts()));
}

void bind_bodies(nb::class_<PyWorld>& c) {
    c.def("add_mesh", add_mesh, nb::arg("mesh"), nb::arg("name") = "mesh",
          nb::arg("inside") = "automatic", nb::arg("before") = nb::none(), nb::arg("cache") = "",
          nb::arg("threads") = 0, nb::arg("progress") = nb::none(),
          "Checks and keeps a mesh: a Mesh, which worlds share, a trimesh or meshio mesh, or a "
          "pair (vertices (n, 3), triangles (m, 3)). `before`: the mesh, by handle or as a Mesh, "
          "that it was before it was cut, torn or grown. Raises InputError.")
        .def(
            "remove_mesh",
            [](PyWorld& w, MeshId mesh) {
                Use(w)->remove_mesh(mesh);
                for (PyWorld::Kept* kept : {&w.progress, &w.meshes}) PyWorld::let_go(*kept);
            },
            nb::arg("mesh"), "Raises InputError while a body uses the mesh.")
        .def(
            "mesh", [](PyWorld& w, MeshId mesh) { return Use(w)->share_mesh(mesh); },
            nb::arg("mesh"), "The mesh of a handle; it stays when the world removes it.")
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
            "vertex_positions",
            [](PyWorld& w, BodyId body) {
                return owned_rows<double>(Use(w)->vertex_positions(body));
            },
            nb::arg("body"),
            nb::sig("def vertex_positions(self, body: BodyId) -> "
                    "numpy.typing.NDArray[numpy.float64]"),
            "[length] float64 (n, 3): where all vertices are now, world space; a copy.")
        .def(
            "pose_of", [](PyWorld& w, BodyId body) { return Use(w)->pose_of(body); },
            nb::arg("body"), "Where a fixed or rigid body is now.")
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
        .def_prop_ro(
            "excluded_pairs", [](PyWorld& w) { return Use(w)->excluded_pairs(); },
            "The pairs that exclude() has left out, each one's lower body first, sorted.")
        .def("set_pair_filter", set_pair_filter, nb::arg("filter").none(),
             nb::sig("def set_pair_filter(self, filter: collections.abc.Callable[[BodyId, BodyId], "
                     "object] | None) -> None"),
             "Asks filter(a, b) once a step for every pair whose boxes overlap; None asks nothing. "
             "What it raises is raised by the call that asks, detect(), explain() or impacts(), "
             "and the pair is left out. Not on a device.")
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

void bind_steps(nb::class_<PyWorld>& c) {
    c.def("detect", detect, nb::sig("def detect(self) -> Contacts"),
          "Runs one step: finds all contacts of the bodies where they are now. Other threads run "
          "meanwhile.")
        .def_prop_ro("contacts", contacts_now, nb::sig("def contacts(self) -> Contacts"),
                     "Those of the last step.")
        .def(
            "device_contacts",
            [](nb::handle_t<PyWorld> self, std::uint32_t part) {
                PyWorld& of = nb::cast<PyWorld&>(self);
                const Use world(of);
                const DeviceContacts found = world->device_contacts(part);
                const auto listed = [&](const DeviceContactList& list) {
                    return DeviceList{.list = list,
                                      .device = found.device,
                                      .worlds = world->plan().worlds,
                                      .world = nb::borrow(self),
                                      .step = of.steps};
                };
                return nb::make_tuple(listed(found.solids), listed(found.sheets));
            },
            nb::arg("part") = 0,
            nb::sig("def device_contacts(self, part: int = 0) -> tuple[DeviceContactList, "
                    "DeviceContactList]"),
            "The last step's contacts in device memory, of solids and of sheets; of several "
            "devices, those that one has found. Waits for nothing after set_stream(), else until "
            "they are there.")
        .def_prop_ro(
            "stats", [](PyWorld& w) { return Use(w)->stats(); }, "Of the last step, a copy.")
        .def_prop_ro("plan", plan_now,
                     "Which stages steps run, and which rules do not apply, a copy.")
        .def_prop_ro(
            "backend", [](PyWorld& w) { return Use(w)->backend(); }, "For people.")
        .def_prop_ro(
            "on_device", [](PyWorld& w) { return w.on_device; }, "Steps run on a GPU.")
        .def(
            "body_boxes", [](PyWorld& w) { return Use(w)->body_boxes(); },
            "The boxes of all bodies that took part in the last step. Raises InputError if bodies "
            "were added, removed, moved or changed since.")
        .def(
            "save",
            [](PyWorld& w) {
                std::ostringstream out(std::ios::binary);
                {
                    const Use world(w);
                    const WithoutGil without_gil;
                    world->save(out);
                }
                const std::string bytes = out.str();
                return nb::bytes(bytes.data(), bytes.size());
            },
            "The world as bytes, without contacts.")
        .def_static(
            "restore",
            [](nb::bytes saved, const std::string& backend, int threads, int parts,
               double host_share) {
                std::unique_ptr<Backend> made = backend_named(backend, threads, parts, host_share);
                const bool on_device = made->runs_on_device();
                std::istringstream in(std::string(saved.c_str(), saved.size()), std::ios::binary);
                const auto world = [&] {
                    const WithoutGil without_gil;
                    return std::make_shared<World>(World::restore(in, std::move(made)));
                }();
                return std::make_shared<PyWorld>(world, on_device);
            },
            nb::arg("saved"), nb::arg("backend") = "auto", nb::arg("threads") = 0,
            nb::arg("parts") = 1, nb::arg("host_share") = 0.0,
            "Makes a world from what save() has returned. Handles stay valid.");
}

}  // namespace

nb::object detect(nb::handle_t<PyWorld> self) {
    PyWorld& w = nb::cast<PyWorld&>(self);
    const Use world(w);
    {
        const WithoutGil without_gil;
        world->detect();
    }
    w.rethrow();
    ++w.steps;
    if (w.on_device) return nb::cast(Contacts(nb::borrow(self), w.steps));
    return nb::cast(Contacts(world->keep_contacts()));
}

void bind_world(nb::module_& module) {
    nb::class_<PyWorld> c(
        module, "World", nb::type_slots(world_slots),
        "Bodies and their contacts. Methods have the names of the C++ class, whose pages say more. "
        "One thread uses a world at a time; worlds in different threads run side by side.");
    c.def("__init__", make_world, nb::arg("backend") = "auto", nb::arg("threads") = 0,
          nb::arg("settings") = nb::none(), nb::arg("parts") = 1, nb::arg("host_share") = 0.0,
          nb::arg("fields"),
          nb::sig("def __init__(self, backend: str = 'auto', threads: int = 0, "
                  "settings: Settings | None = None, parts: int = 1, host_share: float = 0.0, "
                  "**fields: object) -> None"),
          "`backend`: auto, embree, cuda, bvh or reference; `threads`: 0 is one per processor; "
          "`settings`: Settings, or their fields by name; `parts`: so many backends share the "
          "world, of cuda one per device; `host_share`: of a device's work, which processors do "
          "beside cuda.")
        .def("__repr__", [](PyWorld& w) {
            const Use world(w);
            const WithoutGil without_gil;
            const Plan& plan = world->plan();
            return "<World on " + world->backend() + ": " + std::to_string(plan.fixed_bodies) +
                   " fixed, " + std::to_string(plan.rigid_bodies) + " rigid, " +
                   std::to_string(plan.deforming_bodies) + " deforming bodies>";
        });
    bind_bodies(c);
    bind_filters(c);
    bind_places(c);
    bind_steps(c);
    bind_questions(module, c);
}

}  // namespace pierce::python
