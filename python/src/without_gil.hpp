#pragma once

#include <nanobind/nanobind.h>

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

/// Makes the end of the interpreter wait.
void bind_interpreter_end();

}  // namespace pierce::python
