#pragma once

#include <nanobind/nanobind.h>
#include <nanobind/stl/filesystem.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <string>

#include "pierce/vec3.hpp"

namespace pierce::python {

/// str(value).
inline std::string text_of_any(nanobind::handle value) {
    return nanobind::cast<std::string>(nanobind::steal<nanobind::str>(PyObject_Str(value.ptr())));
}

}  // namespace pierce::python

/// A vector of three is a tuple in Python; any sequence of three numbers is taken for it.
template <>
struct nanobind::detail::type_caster<pierce::Vec3d> {
    NB_TYPE_CASTER(pierce::Vec3d,
                   io_name("collections.abc.Sequence[float] | numpy.typing.NDArray[numpy.floating]",
                           "tuple[float, float, float]"))

    bool from_python(handle given, std::uint8_t, cleanup_list*) noexcept {
        if (PySequence_Check(given.ptr()) == 0 || PySequence_Size(given.ptr()) != 3) {
            PyErr_Clear();
            return false;
        }
        for (int k = 0; k < 3; ++k) {
            PyObject* item = PySequence_GetItem(given.ptr(), k);
            value[k] = item == nullptr ? 0 : PyFloat_AsDouble(item);
            Py_XDECREF(item);
            if (PyErr_Occurred() != nullptr) {
                PyErr_Clear();
                return false;
            }
        }
        return true;
    }
    static handle from_cpp(const pierce::Vec3d& v, rv_policy, cleanup_list*) noexcept {
        PyObject* three = PyTuple_New(3);
        for (int k = 0; k < 3 && three != nullptr; ++k)
            PyTuple_SetItem(three, k, PyFloat_FromDouble(v[k]));
        return three;
    }
};
