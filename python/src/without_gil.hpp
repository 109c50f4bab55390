#pragma once

#include <nanobind/nanobind.h>

#include <memory>

namespace pierce::python {

namespace nb = nanobind;

/// While it exists, other threads may run Python. The end of the interpreter waits for it, because
/// Python ends a thread that asks for the lock after that, in the middle of our functions.
class WithoutGil {
public:
    /// Does not return in a thread that begins when the interpreter ends.
    WithoutGil();
    ~WithoutGil();
    WithoutGil(const WithoutGil&) = delete;
    WithoutGil& operator=(const WithoutGil&) = delete;

private:
    PyThreadState* thread_;
};

/// An object that threads without the lock may copy, and let go of.
std::shared_ptr<nb::object> shared_object(nb::object object);

/// Makes the end of the interpreter wait.
void bind_interpreter_end();

}  // namespace pierce::python
