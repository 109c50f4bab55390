#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "arrays.hpp"
#include "casters.hpp"
#include "contacts.hpp"
#include "pierce/error.hpp"
#include "pierce/impact_contact.hpp"
#include "records.hpp"
#include "without_gil.hpp"
#include "world.hpp"

namespace pierce::python {
namespace {

/// The answer to ask(world), for which other threads need not wait.
template <class Ask>
auto asked(PyWorld& self, const Ask& ask) {
    const Use world(self);
    auto answer = [&] {
        const WithoutGil without_gil;
        return ask(*world);
    }();
    self.rethrow();
    return answer;
}

std::vector<std::optional<RayHit>> cast_rays(PyWorld& self, Vec3d origin, nb::handle directions) {
    const nb::object numpy = nb::module_::import_("numpy");
    const nb::object numbers = numpy.attr("ascontiguousarray")(directions, numpy.attr("float64"));
    const Rows rows = rows_of(array_of(numbers, "directions"), 3, "directions", true);
    static_assert(sizeof(Vec3d) == 3 * sizeof(double));
    return asked(self, [&](World& world) {
        return world.cast_rays(origin, {static_cast<const Vec3d*>(rows.data), rows.count});
    });
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
    const bool asks_nobody = !others.is_none() && bodies.empty();
    return asked(self, [&](World& world) {
        if (asks_nobody) return std::vector<std::optional<ProbeContact>>(places.count);
        return world.probe({static_cast<const Vec3d*>(places.data), places.count},
                           {static_cast<const Vec3d*>(ways.data), ways.count}, radius, bodies);
    });
}

nb::object contact_of(const Explanation& e) {
    if (!e.contact) return nb::none();
    const auto copy = std::make_shared<Contact>(*e.contact);
    return nb::cast(Contacts({std::shared_ptr<const Contact>(copy), 1}));
}

}  // namespace

void bind_questions(nb::module_& module, nb::class_<PyWorld>& c) {
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
    c.def(
         "explain",
         [](PyWorld& w, BodyId body, BodyId other, std::uint32_t vertex) {
             return asked(w, [&](World& world) { return world.explain(body, other, vertex); });
         },
         nb::arg("body"), nb::arg("other"), nb::arg("vertex"),
         "Says why a vertex has a contact with another body after the last step, or none.")
        .def(
            "parting",
            [](PyWorld& w, BodyId a, BodyId b) {
                return asked(w, [&](World& world) { return world.parting(a, b); });
            },
            nb::arg("a"), nb::arg("b"),
            "How far b has to move, and where to, until it does not overlap a; None if it does "
            "not.")
        .def(
            "overlap",
            [](PyWorld& w, BodyId a, BodyId b, double same_direction) {
                return asked(w, [&](World& world) { return world.overlap(a, b, same_direction); });
            },
            nb::arg("a"), nb::arg("b"), nb::arg("same_direction") = 0.9,
            "What two solids have in common: volume, areas, patches; None if they have no volume "
            "in common.")
        .def(
            "impacts",
            [](PyWorld& w, std::uint32_t most_per_pair) {
                return asked(w, [&](World& world) { return world.impacts(most_per_pair); });
            },
            nb::arg("most_per_pair") = 1,
            "The first meeting of every pair of solids that are apart as the step begins, and "
            "first meetings of other vertices.")
        .def(
            "impacts_ahead",
            [](PyWorld& w, nb::handle given, nb::handle poses, std::uint32_t most_per_pair) {
                const std::vector<BodyId> bodies = bodies_of(given);
                if (nb::len(poses) != bodies.size())
                    throw InputError("impacts_ahead needs a pose for each body");
                std::vector<PoseAhead> ahead;
                for (std::size_t i = 0; i < bodies.size(); ++i)
                    ahead.push_back({bodies[i], pose_of(poses[i])});
                return asked(
                    w, [&](World& world) { return world.impacts_ahead(ahead, most_per_pair); });
            },
            nb::arg("bodies"), nb::arg("poses"), nb::arg("most_per_pair") = 1,
            nb::sig("def impacts_ahead(self, bodies: collections.abc.Iterable[BodyId] | "
                    "numpy.typing.NDArray[numpy.uint64], poses: collections.abc.Sequence[Pose | "
                    "numpy.typing.ArrayLike] | numpy.typing.NDArray[numpy.floating], "
                    "most_per_pair: int = 1) -> list[ImpactContact]"),
            "The same for rigid bodies on their way from where they are now to the given poses.")
        .def("cast_rays", cast_rays, nb::arg("origin"), nb::arg("directions"),
             "The first body along each line of sight, as RayHit or None.")
        .def("probe", probe, nb::arg("points"), nb::arg("normals"), nb::arg("radius"),
             nb::arg("others") = nb::none(),
             "What touches the points of a sensor, as ProbeContact or None. `others`: the bodies "
             "that "
             "are looked at; None: all.");
}

}  // namespace pierce::python
