#include "mesh.hpp"

#include <nanobind/ndarray.h>
#include <nanobind/stl/shared_ptr.h>

#include <cstring>
#include <string_view>
#include <vector>

#include "arrays.hpp"
#include "pierce/box.hpp"
#include "pierce/error.hpp"
#include "pierce/mesh_check.hpp"
#include "pierce/mesh_fix.hpp"
#include "records.hpp"
#include "scenes/files/mesh_io.hpp"
#include "without_gil.hpp"

namespace pierce::python {
namespace {

/// A view of an array of a mesh, (n, 3), which keeps the mesh.
template <class Number, class Item>
nb::object rows_in(std::span<const Item> items, nb::handle owner) {
    static_assert(sizeof(Item) == 3 * sizeof(Number));
    const std::size_t shape[2] = {items.size(), 3};
    return nb::cast(nb::ndarray<nb::numpy, const Number>(
        items.empty() ? nullptr : reinterpret_cast<const Number*>(items.data()), 2, shape, owner));
}

std::vector<Triangle> triangles_of(nb::handle given) {
    const nb::object numpy = nb::module_::import_("numpy");
    const nb::object array = numpy.attr("asarray")(given);
    if (nb::cast<int>(array.attr("ndim")) != 2 ||
        nb::cast<std::size_t>(array.attr("shape")[nb::int_(1)]) != 3)
        throw nb::value_error(
            ("triangles: expected shape (n, 3), got " + text_of_any(array.attr("shape"))).c_str());
    const auto kind = nb::cast<std::string>(array.attr("dtype").attr("kind"));
    if (kind != "i" && kind != "u")
        throw nb::type_error(
            ("triangles: expected whole numbers, got " + text_of_any(array.attr("dtype"))).c_str());
    // An index that is negative, or too large for 32 bits, names no vertex, and says so later.
    const nb::object limited = numpy.attr("clip")(array.attr("astype")(numpy.attr("int64")), -1,
                                                  std::int64_t{no_vertex});
    const nb::object numbers = numpy.attr("ascontiguousarray")(
        limited.attr("astype")(numpy.attr("uint32")));
    const auto view = nb::cast<nb::ndarray<const std::uint32_t, nb::c_contig>>(numbers);
    std::vector<Triangle> triangles(view.shape(0));
    if (!triangles.empty())
        std::memcpy(triangles.data(), view.data(), triangles.size() * sizeof(Triangle));
    return triangles;
}

}  // namespace

nb::tuple arrays_of(const MeshData& mesh) {
    return nb::make_tuple(owned_rows<float>(mesh.positions),
                          owned_rows<std::uint32_t>(mesh.triangles));
}

MeshData mesh_data_of(nb::handle given) {
    if (nb::isinstance<Mesh>(given)) return nb::cast<const Mesh&>(given).data();
    if (nb::hasattr(given, "vertices") && nb::hasattr(given, "faces"))
        return {positions_of(given.attr("vertices"), "vertices"),
                triangles_of(given.attr("faces"))};
    if (nb::hasattr(given, "points") && nb::hasattr(given, "cells_dict")) {
        const nb::object cells = given.attr("cells_dict");
        if (!nb::cast<bool>(cells.attr("__contains__")("triangle")))
            throw nb::value_error("mesh: the meshio mesh has no cells of type 'triangle'");
        return {positions_of(given.attr("points"), "points"), triangles_of(cells["triangle"])};
    }
    if (nb::isinstance<nb::tuple>(given) && nb::len(given) == 2)
        return {positions_of(given[0], "vertices"), triangles_of(given[1])};
    throw nb::type_error(
        ("mesh: expected a Mesh, a trimesh or meshio mesh, or a pair (vertices, triangles), got " +
         nb::cast<std::string>(nb::str(given.type().attr("__name__"))))
            .c_str());
}

namespace {

/// Calls a progress callback that may be gone. Where it raises, the work goes on.
void tell(const nb::object& call, std::string_view what, double share) {
    if (!call.is_valid() || call.is_none()) return;  // the garbage collector has taken it
    try {
        call(nb::str(what.data(), what.size()), share);
    } catch (nb::python_error& error) {
        // Ctrl-C is raised again when the call is over.
        if (error.matches(PyExc_KeyboardInterrupt)) return PyErr_SetInterrupt();
        error.discard_as_unraisable("the progress callback of a mesh");
    }
}

}  // namespace

MeshOptions mesh_options(nb::handle inside, const std::string& cache, std::uint32_t threads,
                         nb::handle progress, std::shared_ptr<nb::object>* callback) {
    MeshOptions options{
        .inside = choice<Inside>(inside, "inside"), .cache = cache, .threads = threads};
    if (progress.is_none()) return options;
    const std::shared_ptr<nb::object> shared = shared_object(nb::borrow(progress));
    if (callback != nullptr) *callback = shared;
    options.progress = [call = shared](std::string_view what, double share) {
        const nb::gil_scoped_acquire gil;
        tell(*call, what, share);
    };
    return options;
}

namespace {

/// A callback may hold the mesh that has it. So the mesh has it as an attribute, where the garbage
/// collector sees it, and calls it through a weak reference.
nb::object make_mesh(nb::handle mesh, const std::string& name, nb::handle inside,
                     const std::string& cache, std::uint32_t threads, nb::handle progress) {
    MeshData data = mesh_data_of(mesh);
    MeshOptions options = mesh_options(inside, cache, threads, nb::none());
    nb::object call;
    if (!progress.is_none()) {
        // Not every object has weak references; a partial of one has.
        call = nb::module_::import_("functools").attr("partial")(progress);
        options.progress = [weak = shared_object(nb::weakref(call))](std::string_view what,
                                                                     double share) {
            const nb::gil_scoped_acquire gil;
            tell(nb::object((*weak)()), what, share);
        };
    }
    std::shared_ptr<Mesh> made;
    {
        const WithoutGil without_gil;
        made = std::make_shared<Mesh>(name, std::move(data), std::move(options));
    }
    nb::object result = nb::cast(std::move(made));
    if (call.is_valid()) result.attr("_progress") = call;
    return result;
}

}  // namespace

void bind_meshes(nb::module_& module) {
    nb::enum_<Inside>(module, "Inside", "What decides whether a point is inside a mesh.")
        .value("automatic", Inside::automatic, "`closed` or `winding`, as the mesh allows")
        .value("closed", Inside::closed, "the surface as it is given")
        .value("winding", Inside::winding, "the winding number, with holes closed")
        .value("none", Inside::none, "a surface without an inside");
    nb::enum_<MeshDefect> defect(module, "MeshDefect", "What a mesh check looks for.");
    constexpr const char* defects[mesh_defect_count] = {
        "no_triangles",       "not_finite",        "bad_index",        "border_edge",
        "flipped_edge",       "non_manifold_edge", "inside_out",       "degenerate_triangle",
        "duplicate_triangle", "opposite_triangle", "bowtie_vertex",    "no_inward_direction",
        "self_intersection",  "unused_vertex",     "duplicate_vertex", "out_of_range"};
    for (std::uint32_t k = 0; k < mesh_defect_count; ++k) {
        const auto value = static_cast<MeshDefect>(k);
        defect.value(defects[k], value, std::string(meaning(value)).c_str());
    }

    Record<MeshTraits>(module, "MeshTraits", "What the check of a mesh's topology found.")
        .ro("boundary_edges", &MeshTraits::boundary_edges, "edges with one triangle")
        .ro("non_manifold_edges", &MeshTraits::non_manifold_edges, "edges with more than two")
        .ro("inconsistent_edges", &MeshTraits::inconsistent_edges,
            "edges that triangles do not run through equally often both ways")
        .ro("degenerate_triangles", &MeshTraits::degenerate_triangles, "triangles without area")
        .ro("volume", &MeshTraits::volume, "[length^3] signed; negative: inside out")
        .ro("mean_edge_length", &MeshTraits::mean_edge_length, "[length]")
        .get(
            "closed", [](const MeshTraits& t) { return t.closed(); }, "no border, one orientation");
    Record<MeshInside>(module, "MeshInside", "How a mesh got its inside, and what that took.")
        .ro("rule", &MeshInside::rule, "never `automatic`")
        .ro("covered_triangles", &MeshInside::covered_triangles, "in other parts of the mesh")
        .ro("joined_vertices", &MeshInside::joined_vertices, "at the position of an earlier one")
        .ro("turned_triangles", &MeshInside::turned_triangles, "that faced the other way")
        .ro("left_out_triangles", &MeshInside::left_out_triangles, "doubled, or within the solid")
        .ro("holes", &MeshInside::holes, "that are closed")
        .ro("cap_triangles", &MeshInside::cap_triangles, "that close them")
        .ro("cap_share", &MeshInside::cap_share, "area of the caps / area of the rest")
        .get(
            "exists", [](const MeshInside& i) { return i.exists(); }, "the mesh has an inside")
        .get(
            "description", [](const MeshInside& i) { return describe(i); }, "in a sentence");
    Record<MeshFinding>(module, "MeshFinding", "All defects of one kind.")
        .ro("kind", &MeshFinding::kind, "the defect")
        .ro("count", &MeshFinding::count, "of all of the kind")
        .ro("places", &MeshFinding::places, "ids of the first ones, one or two each")
        .get(
            "name", [](const MeshFinding& f) { return std::string(name(f.kind)); }, "in the plural")
        .get(
            "meaning", [](const MeshFinding& f) { return std::string(meaning(f.kind)); },
            "for detection, in a sentence")
        .get(
            "changes_detection", [](const MeshFinding& f) { return changes_detection(f.kind); },
            "False if contacts are the same without it");
    Record<MeshReport>(module, "MeshReport", "What check_mesh() found.")
        .ro("findings", &MeshReport::findings, "one per kind that was found")
        .ro("vertices", &MeshReport::vertices, "all of the mesh")
        .ro("triangles", &MeshReport::triangles, "all of the mesh")
        .ro("components", &MeshReport::components, "of triangles connected by vertices")
        .ro("traits", &MeshReport::traits, "of the topology")
        .ro("closed", &MeshReport::closed, "has triangles and is closed")
        .ro("inside", &MeshReport::inside, "of a Mesh with this rule")
        .get(
            "lower", [](const MeshReport& r) { return r.box.lower; }, "corner of the box around it")
        .get(
            "upper", [](const MeshReport& r) { return r.box.upper; }, "the other corner")
        .get(
            "sound", [](const MeshReport& r) { return r.sound(); },
            "nothing was found that changes detection");

    nb::class_<Mesh>(module, "Mesh", nb::dynamic_attr(),
                     "Topology and rest shape; any number of bodies and worlds share it.")
        .def_static(
            "make", &make_mesh, nb::arg("mesh"), nb::arg("name") = "mesh",
            nb::arg("inside") = "automatic", nb::arg("cache") = "", nb::arg("threads") = 0,
            nb::arg("progress") = nb::none(),
            nb::sig("def make(mesh: object, name: str = 'mesh', inside: object = 'automatic', "
                    "cache: str = '', threads: int = 0, progress: object | None = None) -> Mesh"),
            "Checks a mesh: a trimesh or meshio mesh, or a pair (vertices (n, 3), triangles (m, "
            "3)), counter-clockwise seen from outside. `cache`: a folder in which what is measured "
            "is kept. `progress`: called with what is made and its share. Raises InputError.")
        .def_prop_ro("name", &Mesh::name, "It appears in messages.")
        .def_prop_ro("inside", &Mesh::inside, "What decides whether a point is inside.")
        .def_prop_ro("traits", &Mesh::traits, "What the check of the topology found.")
        .def_prop_ro(
            "vertices",
            [](nb::handle_t<Mesh> self) {
                return rows_in<float>(nb::cast<const Mesh&>(self).positions(), self);
            },
            nb::sig("def vertices(self) -> numpy.typing.NDArray[numpy.float32]"),
            "Rest positions, float32 (n, 3), without a copy.")
        .def_prop_ro(
            "normals",
            [](nb::handle_t<Mesh> self) {
                return rows_in<float>(nb::cast<const Mesh&>(self).normals(), self);
            },
            nb::sig("def normals(self) -> numpy.typing.NDArray[numpy.float32]"),
            "Per vertex, unit and outward; zero where undefined, float32 (n, 3), without a copy.")
        .def_prop_ro(
            "triangles",
            [](nb::handle_t<Mesh> self) {
                return rows_in<std::uint32_t>(nb::cast<const Mesh&>(self).triangles(), self);
            },
            nb::sig("def triangles(self) -> numpy.typing.NDArray[numpy.uint32]"),
            "The triangles that contacts name, uint32 (m, 3), without a copy.")
        .def(
            "given_triangle", &Mesh::given_triangle, nb::arg("triangle"),
            "The place of a triangle among those that were given; no_triangle if it closes a hole.")
        .def(
            "data", [](const Mesh& mesh) { return arrays_of(mesh.data()); },
            nb::sig("def data(self) -> tuple[numpy.typing.NDArray[numpy.float32], "
                    "numpy.typing.NDArray[numpy.uint32]]"),
            "A copy of (vertices, triangles) as they were given.")
        .def("__repr__", [](const Mesh& mesh) {
            return "<Mesh '" + mesh.name() + "', " + std::to_string(mesh.positions().size()) +
                   " vertices, " + std::to_string(mesh.triangles().size()) +
                   " triangles, inside: " + std::string(name(mesh.inside().rule)) + ">";
        });

    module.def(
        "check_mesh",
        [](nb::handle mesh, bool self_intersections, nb::handle inside) {
            const MeshData data = mesh_data_of(mesh);
            const MeshCheckOptions options{self_intersections, choice<Inside>(inside, "inside")};
            const WithoutGil without_gil;
            return check_mesh(data, options);
        },
        nb::arg("mesh"), nb::arg("self_intersections") = false, nb::arg("inside") = "automatic",
        "Looks for everything in a mesh that changes what detection finds.");
    module.def(
        "fix_mesh",
        [](nb::handle mesh) {
            const MeshData data = mesh_data_of(mesh);
            const FixedMesh fixed = fix_mesh(data);
            return nb::make_tuple(arrays_of(fixed.mesh), nb::cast(fixed.vertices),
                                  nb::cast(fixed.done));
        },
        nb::arg("mesh"),
        nb::sig("def fix_mesh(mesh: object) -> tuple[tuple[numpy.typing.NDArray[numpy.float32], "
                "numpy.typing.NDArray[numpy.uint32]], list[int], MeshInside]"),
        "Repairs a mesh. Returns ((vertices, triangles), the place of each vertex in the given "
        "mesh, what was done). Raises InputError as Mesh.make() does.");
    module.def(
        "read_mesh",
        [](const std::filesystem::path& file) { return arrays_of(scenes::read_mesh(file)); },
        nb::arg("file"),
        nb::sig(
            "def read_mesh(file: str | os.PathLike) -> tuple[numpy.typing.NDArray[numpy.float32], "
            "numpy.typing.NDArray[numpy.uint32]]"),
        "Reads (vertices, triangles) from an OBJ, PLY, STL or OFF file, in the file's order.");
}

}  // namespace pierce::python
