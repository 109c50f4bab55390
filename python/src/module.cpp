#include <nanobind/nanobind.h>

#include <exception>
#include <string_view>
#include <typeinfo>

#include "contacts.hpp"
#include "handles.hpp"
#include "mesh.hpp"
#include "pages.hpp"
#include "pierce/contact_reduction.hpp"
#include "pierce/error.hpp"
#include "pierce/filter.hpp"
#include "pierce/ids.hpp"
#include "recordings.hpp"
#include "results.hpp"
#include "scenes/detect/method.hpp"
#include "without_gil.hpp"
#include "world.hpp"

NB_MODULE(_core, module) {
    namespace python = pierce::python;
    namespace nb = nanobind;
    module.doc() = "Contacts between triangle meshes by ray tracing.";
    const nb::exception<pierce::InputError> input_error(module, "InputError", PyExc_ValueError);
    input_error.attr(
        "__doc__") = "Input that cannot be used; the message names it, and nothing has changed.";
    // A message may hold bytes of a file that are not UTF-8.
    nb::register_exception_translator(
        [](const std::exception_ptr& thrown, void* type) {
            try {
                std::rethrow_exception(thrown);
            } catch (const pierce::InputError& error) {
                const std::string_view text = error.what();
                const nb::object message = nb::steal(PyUnicode_DecodeUTF8(
                    text.data(), static_cast<Py_ssize_t>(text.size()), "replace"));
                PyErr_SetObject(static_cast<PyObject*>(type), message.ptr());
            }
        },
        input_error.ptr());
    nb::register_exception_translator([](const std::exception_ptr& thrown, void*) {
        try {
            std::rethrow_exception(thrown);
        } catch (const std::bad_cast&) {
            PyErr_SetString(PyExc_TypeError, "an argument is not of a type that is taken here");
        }
    });
    module.attr("all_worlds") = pierce::all_worlds;
    module.attr("least_reduced") = pierce::least_reduced;
    module.attr("no_vertex") = pierce::no_vertex;
    module.attr("no_triangle") = pierce::no_triangle;
    module.attr("version") = PIERCE_VERSION;
    module.def("cuda_can_run", &pierce::scenes::cuda_can_run,
               "True if this build has CUDA and there is a device for it.");
    python::bind_interpreter_end();
    python::bind_handles(module);
    python::bind_results(module);
    python::bind_meshes(module);
    python::bind_contacts(module);
    python::bind_world(module);
    python::bind_recordings(module);
    python::bind_pages(module);
}
