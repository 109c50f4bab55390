#include <string>
#include <vector>

#include "arrays.hpp"
#include "casters.hpp"
#include "without_gil.hpp"
#include "world.hpp"

namespace pierce::python {
namespace {

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
    {
        const WithoutGil without_gil;  // it may measure meshes, which tells Python how far it is
        world->set_device_positions(ids, static_cast<const Vec3f*>(rows.data));
    }
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

}  // namespace

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

}  // namespace pierce::python
