#include "contacts.hpp"

#include <nanobind/ndarray.h>

#include <algorithm>
#include <cstddef>
#include <iterator>
#include <memory>
#include <numeric>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "casters.hpp"
#include "pierce/contact.hpp"
#include "pierce/contact_changes.hpp"
#include "pierce/contact_hash.hpp"
#include "pierce/contact_reduction.hpp"
#include "pierce/parting.hpp"
#include "records.hpp"
#include "world.hpp"

namespace pierce::python {
namespace {

std::span<const Contact> all(const Contacts& c) { return c.kept().all(); }

/// The places that an array of places or a mask names, of `size` ones; None: all.
std::vector<std::uint32_t> places_among(std::size_t size, const nb::object& among) {
    std::vector<std::uint32_t> places(size);
    std::iota(places.begin(), places.end(), 0u);
    if (among.is_none()) return places;
    const nb::object numpy = nb::module_::import_("numpy");
    // Indexing knows masks and negative places, and refuses what is out of range.
    const nb::object named = numpy.attr("arange")(size,
                                                  nb::arg("dtype") = numpy.attr("uint32"))[among];
    const auto view = nb::cast<nb::ndarray<const std::uint32_t, nb::ndim<1>, nb::c_contig>>(
        numpy.attr("ascontiguousarray")(named));
    places.assign(view.data(), view.data() + view.size());
    return places;
}

/// Contacts from one place to another; they keep the whole list.
Contacts part_of(const Contacts& c, std::size_t begin, std::size_t end) {
    const KeptContacts& whole = c.kept();
    return Contacts(
        {std::shared_ptr<const Contact>(whole.first, whole.first.get() + begin), end - begin});
}

/// A list of its own of some of the contacts.
template <class IsWanted>
Contacts copy_of(const Contacts& c, const IsWanted& is_wanted) {
    const auto list = std::make_shared<std::vector<Contact>>();
    std::ranges::copy_if(all(c), std::back_inserter(*list), is_wanted);
    return Contacts({std::shared_ptr<const Contact>(list, list->data()), list->size()});
}

/// A member of every record, as a view: shape (n,), or (n, columns) if columns is not 0.
template <class Number>
nb::object column(nb::handle_t<Contacts> self, std::size_t offset, std::size_t columns) {
    static_assert(sizeof(Contact) % sizeof(Number) == 0);
    const std::span<const Contact> contacts = all(nb::cast<const Contacts&>(self));
    const auto* bytes = reinterpret_cast<const std::byte*>(contacts.data());
    const auto* first = contacts.empty() ? nullptr
                                         : reinterpret_cast<const Number*>(bytes + offset);
    const std::size_t shape[2] = {contacts.size(), columns};
    const std::int64_t strides[2] = {sizeof(Contact) / sizeof(Number), 1};
    return nb::cast(
        nb::ndarray<nb::numpy, const Number>(first, columns > 0 ? 2 : 1, shape, self, strides));
}

/// One field of the records, for the type of the records in NumPy and for a property.
struct Field {
    const char* name;
    const char* type;  ///< as NumPy writes it
    std::size_t offset;
    std::size_t columns;  ///< 0: a number
    const char* doc;
};

constexpr Field fields[] = {
    {"a", "uint64", offsetof(Contact, a), 0, "handle of the body in the lower slot, uint64 (n,)"},
    {"b", "uint64", offsetof(Contact, b), 0, "handle of the other body, uint64 (n,)"},
    {"source", "uint8", offsetof(Contact, source), 0,
     "which of the two the vertex or edge belongs to, as Side, uint8 (n,)"},
    {"grazing", "bool", offsetof(Contact, grazing), 0,
     "the ray meets the triangle so flatly that the depth is uncertain, bool (n,)"},
    {"found", "uint8", offsetof(Contact, found), 0, "how it was found, as Found, uint8 (n,)"},
    {"reprojected", "bool", offsetof(Contact, reprojected), 0,
     "it ends at the closest point, not at the end of its ray, bool (n,)"},
    {"of_sheet", "bool", offsetof(Contact, of_sheet), 0, "one of the two is a sheet, bool (n,)"},
    {"unknown_side", "bool", offsetof(Contact, unknown_side), 0,
     "of a sheet: the normal does not tell the way out, bool (n,)"},
    {"vertex", "uint32", offsetof(Contact, vertex), 0,
     "vertex of the source, or the first one of its edge, uint32 (n,)"},
    {"edge_end", "uint32", offsetof(Contact, edge_end), 0,
     "second vertex of the edge; no_vertex if a vertex is in contact, uint32 (n,)"},
    {"edge", "uint32", offsetof(Contact, edge), 0, "edge of the source's mesh, uint32 (n,)"},
    {"chord", "uint32", offsetof(Contact, chord), 0,
     "which of the edge's parts inside the target, uint32 (n,)"},
    {"other_edge", "uint32", offsetof(Contact, other_edge), 0,
     "edge of the target's mesh, if two edges are near, uint32 (n,)"},
    {"triangle", "uint32", offsetof(Contact, triangle), 0, "triangle of the target, uint32 (n,)"},
    {"age", "uint32", offsetof(Contact, age), 0,
     "steps in a row that this has been in contact, uint32 (n,)"},
    {"along", "float64", offsetof(Contact, along), 0, "where on the edge, 0 to 1, float64 (n,)"},
    {"time", "float64", offsetof(Contact, time), 0,
     "of a sheet: when in the step they first meet, 0 to 1, float64 (n,)"},
    {"distance", "float64", offsetof(Contact, distance), 0,
     "[length] signed: negative where bodies overlap, float64 (n,)"},
    {"barycentric", "float64", offsetof(Contact, barycentric), 3,
     "of the target point in the triangle, float64 (n, 3)"},
    {"point_a", "float64", offsetof(Contact, point_a), 3, "on body a, world space, float64 (n, 3)"},
    {"point_b", "float64", offsetof(Contact, point_b), 3, "on body b, world space, float64 (n, 3)"},
    {"normal", "float64", offsetof(Contact, normal), 3, "unit, from a to b, float64 (n, 3)"},
    {"face_normal", "float64", offsetof(Contact, face_normal), 3,
     "unit, outward, of the target triangle, float64 (n, 3)"},
};

nb::object view_of_field(nb::handle_t<Contacts> self, const Field& field) {
    const std::string_view type = field.type;
    if (type == "float64") return column<double>(self, field.offset, field.columns);
    if (type == "bool") return column<bool>(self, field.offset, field.columns);
    if (type == "uint64") return column<std::uint64_t>(self, field.offset, field.columns);
    if (type == "uint32") return column<std::uint32_t>(self, field.offset, field.columns);
    return column<std::uint8_t>(self, field.offset, field.columns);
}

/// Per field, what a type checker knows of its array.
std::vector<std::string> array_signatures() {
    std::vector<std::string> all;
    for (const Field& field : fields) {
        const std::string type = field.type == std::string_view("bool") ? "bool_" : field.type;
        all.push_back("def " + std::string(field.name) + "(self) -> numpy.typing.NDArray[numpy." +
                      type + "]");
    }
    return all;
}

/// The NumPy type of a record.
nb::object record_type() {
    nb::list names, formats, offsets;
    for (const Field& field : fields) {
        names.append(field.name);
        if (field.columns > 0)
            formats.append(nb::make_tuple(field.type, nb::make_tuple(field.columns)));
        else
            formats.append(field.type);
        offsets.append(field.offset);
    }
    nb::dict about;
    about["names"] = names;
    about["formats"] = formats;
    about["offsets"] = offsets;
    about["itemsize"] = sizeof(Contact);
    return nb::module_::import_("numpy").attr("dtype")(about);
}

/// An array that Python owns, of numbers made now.
template <class Number>
nb::object array_from(std::vector<Number> numbers) {
    auto* kept = new std::vector<Number>(std::move(numbers));
    const nb::capsule owner(kept, [](void* p) noexcept { delete static_cast<decltype(kept)>(p); });
    return nb::cast(nb::ndarray<nb::numpy, Number>(kept->data(), {kept->size()}, owner));
}

/// Throws RuntimeError for contacts that a later step has replaced.
const DeviceList& now(nb::handle_t<DeviceList> self) {
    const auto& of = nb::cast<const DeviceList&>(self);
    if (nb::cast<const PyWorld&>(of.world).steps != of.step)
        throw std::runtime_error(
            "these contacts are of an earlier step: device memory has those of the last one only");
    return of;
}

/// An array in device memory, of rows if there are columns.
template <class Number>
nb::object on_device(nb::handle_t<DeviceList> self, const Number* first, std::size_t length,
                     std::size_t columns = 0) {
    const std::size_t shape[2] = {length, columns};
    return nb::cast(nb::ndarray<nb::array_api, const Number>(
        first, columns > 0 ? 2 : 1, shape, self, nullptr, nb::dtype<Number>(),
        nb::device::cuda::value, now(self).device));
}

}  // namespace

const KeptContacts& Contacts::kept() const {
    if (!world_.is_valid()) return kept_;
    PyWorld& world = nb::cast<PyWorld&>(world_);
    if (world.steps != step_)
        throw std::runtime_error(
            "these contacts are of an earlier step on a device: read them before the next "
            "detect()");
    kept_ = Use(world)->keep_contacts();
    world_.reset();
    return kept_;
}

void bind_contacts(nb::module_& module) {
    auto contacts = nb::class_<Contacts>(
        module, "Contacts",
        "The contacts of a step. Arrays are views of the records, without a copy, and stay valid "
        "through later steps. The order is that of (a, b, source, vertex).");
    // Python reads these texts for as long as the module is there.
    static const std::vector<std::string> signatures = array_signatures();
    for (std::size_t k = 0; k < std::size(fields); ++k)
        contacts.def_prop_ro(
            fields[k].name,
            [k](nb::handle_t<Contacts> self) { return view_of_field(self, fields[k]); },
            nb::sig(signatures[k].c_str()), fields[k].doc);
    const nb::object type = record_type();
    module.attr("contact_dtype") = type;
    contacts.attr("fields") = type.attr("names");
    contacts.def("__len__", [](const Contacts& c) { return c.kept().count; })
        .def(
            "__getitem__",
            [](const Contacts& c, nb::handle which) {
                Py_ssize_t begin = 0, end = 0, step = 1;
                const auto count = static_cast<Py_ssize_t>(c.kept().count);
                if (nb::isinstance<nb::slice>(which)) {
                    if (PySlice_Unpack(which.ptr(), &begin, &end, &step) < 0)
                        throw nb::python_error();
                    PySlice_AdjustIndices(count, &begin, &end, step);
                    if (step != 1) throw nb::value_error("contacts: expected a step of 1");
                } else {
                    if (PyIndex_Check(which.ptr()) == 0)
                        throw nb::type_error("contacts: expected a number or a slice");
                    begin = PyNumber_AsSsize_t(which.ptr(), PyExc_IndexError);
                    if (begin == -1 && PyErr_Occurred() != nullptr) throw nb::python_error();
                    if (begin < 0) begin += count;
                    if (begin < 0 || begin >= count)
                        throw nb::index_error(
                            ("there are " + std::to_string(count) + " contacts").c_str());
                    end = begin + 1;
                }
                return part_of(c, static_cast<std::size_t>(begin),
                               static_cast<std::size_t>(std::max(begin, end)));
            },
            nb::arg("which"), nb::sig("def __getitem__(self, which: int | slice) -> Contacts"),
            "One contact, or some that follow each other, without a copy.")
        .def(
            "__iter__", [](nb::handle self) { return nb::steal(PySeqIter_New(self.ptr())); },
            nb::sig("def __iter__(self) -> collections.abc.Iterator[Contacts]"),
            "The contacts one by one. NumPy's arrays of all of them are faster.")
        .def(
            "of_pair",
            [](const Contacts& c, BodyId one, BodyId other) {
                const BodyId a = std::min(one, other), b = std::max(one, other);
                const std::span<const Contact> list = all(c);
                const auto is_of = [&](const Contact& contact) {
                    return contact.a == a && contact.b == b;
                };
                const auto begin = std::ranges::find_if(list, is_of);
                const auto end = std::find_if_not(begin, list.end(), is_of);
                // Contacts of sheets come after all others.
                if (std::find_if(end, list.end(), is_of) != list.end()) return copy_of(c, is_of);
                return part_of(c, static_cast<std::size_t>(begin - list.begin()),
                               static_cast<std::size_t>(end - list.begin()));
            },
            nb::arg("a"), nb::arg("b"),
            "The contacts of two bodies, in either order, without a copy unless there are contacts "
            "of both solids and sheets among them.")
        .def("__repr__",
             [](const Contacts& c) {
                 double deepest = 0;
                 for (const Contact& contact : all(c))
                     deepest = std::max(deepest, contact.penetration_depth());
                 return "<" + std::to_string(c.kept().count) + " contacts, the deepest " +
                        std::to_string(deepest) + ">";
             })
        .def_prop_ro(
            "records",
            [](nb::handle_t<Contacts> self) {
                const std::span<const Contact> list = all(nb::cast<const Contacts&>(self));
                const std::size_t shape[1] = {list.size() * sizeof(Contact)};
                const nb::object bytes = nb::cast(
                    nb::ndarray<nb::numpy, const std::uint8_t>(list.data(), 1, shape, self));
                return bytes.attr("view")(
                    nb::module_::import_("pierce._core").attr("contact_dtype"));
            },
            nb::sig("def records(self) -> numpy.typing.NDArray[numpy.void]"),
            "All contacts as a structured array (n,) of contact_dtype, without a copy.")
        .def_prop_ro(
            "depth",
            [](const Contacts& c) {
                std::vector<double> depths;
                for (const Contact& contact : all(c)) depths.push_back(contact.penetration_depth());
                return array_from(std::move(depths));
            },
            nb::sig("def depth(self) -> numpy.typing.NDArray[numpy.float64]"),
            "[length] max(-distance, 0), float64 (n,), made anew.")
        .def_prop_ro(
            "feature",
            [](const Contacts& c) {
                std::vector<std::uint64_t> features;
                for (const Contact& contact : all(c)) features.push_back(contact.feature());
                return array_from(std::move(features));
            },
            nb::sig("def feature(self) -> numpy.typing.NDArray[numpy.uint64]"),
            "A number that names a contact within its pair from step to step, uint64 (n,), made "
            "anew.")
        .def_prop_ro(
            "hash", [](const Contacts& c) { return contact_hash(all(c)); },
            "64-bit hash of the list: equal lists have equal hashes, on every backend.")
        .def(
            "reduce",
            [](const Contacts& c, std::uint32_t most_per_pair, const nb::object& among) {
                const std::vector<std::uint32_t> given = places_among(all(c).size(), among);
                std::vector<Contact> some;
                for (const std::uint32_t place : given) some.push_back(all(c)[place]);
                std::vector<std::uint32_t> places;
                std::vector<double> weights;
                for (const ReducedContact& r : reduce(some, most_per_pair)) {
                    places.push_back(given[r.contact]);
                    weights.push_back(r.weight);
                }
                return nb::make_tuple(array_from(std::move(places)),
                                      array_from(std::move(weights)));
            },
            nb::arg("most_per_pair"), nb::arg("among") = nb::none(),
            nb::sig("def reduce(self, most_per_pair: int, among: numpy.typing.ArrayLike | None = "
                    "None) -> tuple[numpy.typing.NDArray[numpy.uint32], "
                    "numpy.typing.NDArray[numpy.float64]]"),
            "Picks at most `most_per_pair` contacts of each pair, six at least, with weights, so "
            "that force and torque stay. Returns places, uint32 (k,), and weights, float64 (k,). "
            "`among`: picks from these only, places or a mask; None: all.")
        .def(
            "changes",
            [](const Contacts& later, const Contacts& earlier) {
                const ContactChanges found = contact_changes(all(earlier), all(later));
                return nb::make_tuple(array_from(found.began), array_from(found.stayed),
                                      array_from(found.ended));
            },
            nb::arg("earlier"),
            nb::sig(
                "def changes(self, earlier: Contacts) -> tuple[numpy.typing.NDArray[numpy.uint32], "
                "numpy.typing.NDArray[numpy.uint32], numpy.typing.NDArray[numpy.uint32]]"),
            "What began and stayed, as places in this list, and what ended, as places in the "
            "earlier one; uint32 arrays.")
        .def(
            "least_translation", [](const Contacts& c) { return least_translation(all(c)); },
            "The shortest translation of body b that takes all these contacts apart; they must be "
            "of one pair. None if there is none.");

    auto device = nb::class_<DeviceList>(
        module, "DeviceContactList",
        "Contacts in device memory as arrays with room for `room` of them; the first `count[0]` "
        "are there. They are read through DLPack, and valid until the next detect().");
    device
        .def_prop_ro(
            "room", [](const DeviceList& d) { return d.list.room; },
            "There are never more contacts.")
        .def_prop_ro(
            "count",
            [](nb::handle_t<DeviceList> self) { return on_device(self, now(self).list.count, 1); },
            "How many there are, uint32 (1,).")
        .def_prop_ro(
            "world_begins",
            [](nb::handle_t<DeviceList> self) {
                const DeviceList& of = now(self);
                if (of.list.world_begins == nullptr) return nb::object(nb::none());
                return on_device(self, of.list.world_begins, of.worlds + std::size_t{1});
            },
            "Where the contacts of each world begin, and where those of the last one end, uint32 "
            "(worlds + 1,); None without worlds.");
    const auto column_of = [&](const char* name, auto member, std::size_t columns,
                               const char* doc) {
        device.def_prop_ro(
            name,
            [member, columns](nb::handle_t<DeviceList> self) {
                const DeviceContactList& list = now(self).list;
                const auto* const first = list.*member;
                if (first == nullptr && list.room > 0) return nb::object(nb::none());
                return on_device(self, first, list.room, columns);
            },
            doc);
    };
    column_of("body_a", &DeviceContactList::body_a, 0, "index of body a, uint32 (room,)");
    column_of("body_b", &DeviceContactList::body_b, 0, "index of body b, uint32 (room,)");
    column_of("feature", &DeviceContactList::feature, 0, "Contacts.feature, uint64 (room,)");
    column_of("distance", &DeviceContactList::distance, 0, "[length] signed, float32 (room,)");
    column_of("point_a", &DeviceContactList::point_a, 3, "on body a, float32 (room, 3)");
    column_of("point_b", &DeviceContactList::point_b, 3, "on body b, float32 (room, 3)");
    column_of("normal", &DeviceContactList::normal, 3, "unit, from a to b, float32 (room, 3)");
}

}  // namespace pierce::python
