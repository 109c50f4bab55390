#include "handles.hpp"

#include <cstdint>
#include <string>

#include "casters.hpp"
#include "pierce/ids.hpp"

namespace pierce::python {
namespace {

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
        .def("__copy__", [](const Handle& id) { return id; })
        .def(
            "__deepcopy__", [](const Handle& id, nb::handle) { return id; }, nb::arg("memo"))
        .def("__reduce__",
             [number](nb::handle_t<Handle> self) {
                 return nb::make_tuple(self.type(), nb::make_tuple(number(nb::cast<Handle>(self))));
             })
        .def("__repr__", [name](const Handle& id) {
            if (!id) return std::string(name) + "()";
            return std::string(name) + "(" + std::to_string(id.index) +
                   (id.generation > 1 ? ", generation " + std::to_string(id.generation) : "") + ")";
        });
}

}  // namespace

void bind_handles(nb::module_& module) {
    bind_handle<BodyTag>(module, "BodyId",
                         "A handle of a body; as a number, index + generation * "
                         "2**32.");
    bind_handle<MeshTag>(module, "MeshId", "A handle of a mesh.");
}

}  // namespace pierce::python
