#pragma once

#include <nanobind/nanobind.h>
#include <nanobind/stl/shared_ptr.h>

#include <cstdint>
#include <exception>
#include <memory>
#include <mutex>
#include <stdexcept>
#include <utility>
#include <vector>

#include "kept_arrays.hpp"
#include "pierce/world.hpp"

namespace pierce::python {

namespace nb = nanobind;

/// A World in Python. One thread uses it at a time.
struct PyWorld {
    /// Objects that the world in C++ has. The garbage collector has to see them.
    using Kept = std::vector<std::shared_ptr<nb::object>>;

    std::shared_ptr<World> world;
    bool on_device = false;
    std::uint64_t steps = 0;  ///< that Python has run
    std::mutex busy;
    KeptArrays places, starts;
    nb::object stream;           ///< kept while steps wait for it
    nb::object filter;           ///< of pairs; the world calls it
    std::exception_ptr failure;  ///< of the filter, in this call
    Kept progress;               ///< callbacks of meshes that were added as arrays
    Kept meshes;                 ///< that were added as objects

    /// Asks the filter; what it throws is kept until the call is over, and the pair is left out.
    bool wants(BodyId a, BodyId b);
    /// To be called after calls that ask it: throws what it has thrown.
    void rethrow();
    /// Notes an object that the world has. Each time the list has doubled, it lets go of those that
    /// no world has any more, so that this costs little per object.
    static void keep(Kept& kept, std::shared_ptr<nb::object> object);
    /// Lets go of objects that the world has no longer.
    static void let_go(Kept& kept);

    PyWorld(std::shared_ptr<World> its_world, bool runs_on_device)
        : world(std::move(its_world)), on_device(runs_on_device) {}
};

/// The use of a world by one thread. Throws RuntimeError if another thread uses it.
class Use {
public:
    explicit Use(PyWorld& of) : lock_(of.busy, std::try_to_lock), world_(of.world.get()) {
        if (!lock_.owns_lock())
            throw std::runtime_error(
                "this World is in a call of another thread, or of its own pair filter");
    }
    World* operator->() const { return world_; }
    World& operator*() const { return *world_; }

private:
    std::unique_lock<std::mutex> lock_;
    World* world_;
};

/// The slots of a class T with a member `world`, the object of a PyWorld: the garbage collector has
/// to see it, because the world's filter may hold what holds the T.
template <class T>
struct HoldsWorld {
    static int visit(PyObject* self, visitproc visit, void* arg) {
        Py_VISIT(Py_TYPE(self));
        if (nb::inst_ready(self)) Py_VISIT(nb::inst_ptr<T>(self)->world.ptr());
        return 0;
    }
    static int clear(PyObject* self) {
        if (nb::inst_ready(self)) nb::inst_ptr<T>(self)->world.reset();
        return 0;
    }
    static inline PyType_Slot slots[] = {{Py_tp_traverse, reinterpret_cast<void*>(visit)},
                                         {Py_tp_clear, reinterpret_cast<void*>(clear)},
                                         {0, nullptr}};
};

/// The world of such an object. Throws RuntimeError if the garbage collector has taken it.
inline PyWorld& world_in(const nb::object& world) {
    if (!world.is_valid()) throw std::runtime_error("the World is gone");
    return nb::cast<PyWorld&>(world);
}

/// Runs a step without the interpreter's lock, and returns its contacts.
nb::object detect(nb::handle_t<PyWorld> self);

void bind_world(nb::module_& module);

/// Where bodies are: poses, positions, meshes, on the host and in device memory (places.cpp).
void bind_places(nb::class_<PyWorld>& world);
/// What a world answers about its bodies (questions.cpp).
void bind_questions(nb::module_& module, nb::class_<PyWorld>& world);

}  // namespace pierce::python
