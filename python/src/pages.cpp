#include "pages.hpp"

#include <algorithm>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "casters.hpp"
#include "page/scene_page.hpp"
#include "page/step_figures.hpp"
#include "pierce/error.hpp"
#include "without_gil.hpp"
#include "world.hpp"

namespace pierce::python {
namespace {

using nlohmann::json;

/// A page and the world that it shows.
struct PyPage {
    nb::object world;
    std::unique_ptr<page::ScenePage> page;
};

/// What Python's json module makes of it.
json json_of(nb::handle value) {
    const nb::object dumps = nb::module_::import_("json").attr("dumps");
    try {
        // NumPy's numbers are none of Python's.
        const nb::object number_of = nb::cpp_function([](nb::handle object) -> nb::object {
            if (!nb::hasattr(object, "item"))
                throw nb::type_error("a value of a page is no number, text, list or dict");
            return object.attr("item")();
        });
        return json::parse(nb::cast<std::string>(
            dumps(value, nb::arg("allow_nan") = false, nb::arg("default") = number_of)));
    } catch (nb::python_error& error) {
        if (!error.matches(PyExc_ValueError)) throw;
        throw InputError("a value of a page is not finite, or holds itself");
    } catch (const json::exception&) {
        // Python has numbers without an end, and texts that are no Unicode.
        throw InputError("a value of a page is a number beyond float64, or no Unicode text");
    }
}

void make_page(PyPage* self, nb::handle_t<PyWorld> world, std::string title, nb::dict names,
               double dt, bool reasons) {
    std::map<BodyId, std::string> of_bodies;
    const Use asked(nb::cast<PyWorld&>(world));
    for (const auto& [body, name] : names) {
        BodyId id;
        std::string text;
        if (!nb::try_cast(body, id) || !nb::try_cast(name, text))
            throw nb::type_error("names: a dict of bodies and strings");
        asked->mesh_of(id);  // throws for what is no body of the world
        of_bodies[id] = std::move(text);
    }
    if (!(dt >= 0) || std::isinf(dt))
        throw InputError("dt: the time from frame to frame is negative or not finite");
    new (self) PyPage{nb::borrow(world), std::make_unique<page::ScenePage>(page::ScenePage::Options{
                                             .title = std::move(title),
                                             .body_names = std::move(of_bodies),
                                             .dt = dt,
                                             .reasons = reasons})};
}

void add(PyPage& self, const nb::kwargs& figures) {
    const json own = json_of(figures);
    PyWorld& shown = world_in(self.world);
    const Use world(shown);
    json all = page::step_figures(world->stats());
    all.update(own);
    {
        const WithoutGil without_gil;
        self.page->add(*world, all);
    }
    shown.rethrow();
}

void write(const PyPage& self, const std::filesystem::path& file, const nb::kwargs& made_with) {
    if (self.page->frame_count() == 0)
        throw InputError("the page has no frames: add() keeps one after each detect()");
    json about{{"versions", {{"pierce", PIERCE_VERSION}}}};
    about.update(json_of(made_with));
    // Nobody adds a frame meanwhile.
    const Use world(world_in(self.world));
    const WithoutGil without_gil;
    about["backend"] = {{"name", world->backend()}};
    about["plan"] = page::plan_figures(world->plan());
    about["notes"] = world->plan().notes;
    self.page->write(file, about);
}

}  // namespace

void bind_pages(nb::module_& module) {
    nb::class_<PyPage>(module, "Page", nb::type_slots(HoldsWorld<PyPage>::slots),
                       "One HTML file that plays what a world did: bodies, contacts, charts, and "
                       "why vertices have no contact.")
        .def("__init__", make_page, nb::arg("world"), nb::arg("title") = "",
             nb::arg("names") = nb::dict(), nb::arg("dt") = 0.0, nb::arg("reasons") = true,
             nb::sig("def __init__(self, world: World, title: str = '', names: dict[BodyId, str] = "
                     "{}, dt: float = 0.0, reasons: bool = True) -> None"),
             "`names`: of bodies; the others have their mesh's. `dt`: [s] from frame to frame; 0: "
             "unknown. `reasons`: also why vertices have no contact, which takes longer than to "
             "detect.")
        .def("add", add, nb::arg("figures"), nb::sig("def add(self, **figures: object) -> None"),
             "Keeps the world after detect(), as the next frame. `figures`: numbers that charts "
             "show beside times and counts; a dict of numbers has a chart of its own.")
        .def("write", write, nb::arg("file"), nb::arg("made_with"),
             nb::sig("def write(self, file: str | os.PathLike, **made_with: object) -> None"),
             "Writes the page. `made_with`: dicts that the page shows under \"About\".")
        .def_prop_ro(
            "frame_count", [](const PyPage& p) { return p.page->frame_count(); },
            "Frames that were added.")
        .def("__repr__", [](const PyPage& p) {
            return "Page(" + std::to_string(p.page->frame_count()) + " frames)";
        });
}

}  // namespace pierce::python
