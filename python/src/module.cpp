#include <nanobind/nanobind.h>

#include "contacts.hpp"
#include "handles.hpp"
#include "mesh.hpp"
#include "pages.hpp"
#include "pierce/error.hpp"
#include "pierce/filter.hpp"
#include "pierce/ids.hpp"
#include "recordings.hpp"
#include "results.hpp"
#include "scenes/detect/method.hpp"
#include "world.hpp"

NB_MODULE(_core, module) {
    namespace python = pierce::python;
    namespace nb = nanobind;
    module.doc() = "Contacts between triangle meshes by ray tracing.";
    nb::exception<pierce::InputError>(module, "InputError", PyExc_ValueError).attr("__doc__") =
        "Input that cannot be used; the message names it, and nothing has changed.";
    module.attr("all_worlds") = pierce::all_worlds;
    module.attr("no_vertex") = pierce::no_vertex;
    module.attr("no_triangle") = pierce::no_triangle;
    module.attr("version") = PIERCE_VERSION;
    module.def("cuda_can_run", &pierce::scenes::cuda_can_run,
               "True if this build has CUDA and there is a device for it.");
    python::bind_handles(module);
    python::bind_results(module);
    python::bind_meshes(module);
    python::bind_contacts(module);
    python::bind_world(module);
    python::bind_recordings(module);
    python::bind_pages(module);
}
