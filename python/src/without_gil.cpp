#include "without_gil.hpp"

#include <chrono>
#include <optional>
#include <thread>
#include <utility>

namespace pierce::python {
namespace {

constexpr std::chrono::milliseconds between_looks{1};

/// Of the interpreter, and read and written by the thread that holds its lock.
struct Interpreter {
    int threads_without_lock = 0;
    std::optional<std::thread::id> ending_thread;
};
Interpreter interpreter;

void wait_for_threads() {
    interpreter.ending_thread = std::this_thread::get_id();
    // What threads have that are still there is not a leak.
    const nb::object threads = nb::module_::import_("threading").attr("active_count")();
    if (interpreter.threads_without_lock > 0 || nb::cast<int>(threads) > 1)
        nb::set_leak_warnings(false);
    while (interpreter.threads_without_lock > 0) {
        const nb::gil_scoped_release release;
        std::this_thread::sleep_for(between_looks);
    }
}

/// The thread runs no Python any more.
[[noreturn]] void stop_here() {
    nb::set_leak_warnings(false);
    PyEval_SaveThread();
    for (;;) std::this_thread::sleep_for(std::chrono::hours(1));
}

}  // namespace

WithoutGil::WithoutGil() {
    if (interpreter.ending_thread && *interpreter.ending_thread != std::this_thread::get_id())
        stop_here();
    ++interpreter.threads_without_lock;
    thread_ = PyEval_SaveThread();
}

WithoutGil::~WithoutGil() {
    PyEval_RestoreThread(thread_);
    --interpreter.threads_without_lock;
}

std::shared_ptr<nb::object> shared_object(nb::object object) {
    return {new nb::object(std::move(object)), [](nb::object* last) {
                const nb::gil_scoped_acquire gil;
                delete last;
            }};
}

void bind_interpreter_end() {
    nb::module_::import_("atexit").attr("register")(nb::cpp_function(wait_for_threads));
    // A fork has one thread only.
    nb::module_::import_("os").attr("register_at_fork")(
        nb::arg("after_in_child") = nb::cpp_function([] { interpreter.threads_without_lock = 0; }));
}

}  // namespace pierce::python
