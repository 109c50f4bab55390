#pragma once

#include <exception>

#include "mpi/communicator.hpp"

/// How a failure of one rank becomes a failure of all.
namespace pierce::mpi {

/// What run() throws, or null.
template <class Run>
std::exception_ptr failure_of(const Run& run) {
    try {
        run();
    } catch (...) {
        return std::current_exception();
    }
    return nullptr;
}

/// Collective. True if there is a failure on some rank.
bool any_failed(const Communicator& comm, const std::exception_ptr& failure);

/// Collective, for when there is a failure on some rank. Throws the first rank's failure on all: an
/// InputError, or else a std::runtime_error.
[[noreturn]] void throw_failure(const Communicator& comm, const std::exception_ptr& failure);

}  // namespace pierce::mpi
