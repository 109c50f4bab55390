#pragma once

#include <exception>
#include <new>
#include <stdexcept>

#include "pierce/c/base.h"
#include "pierce/error.hpp"

namespace pierce::c {

/// What is asked for is not in this build of the library.
class NotBuilt : public std::runtime_error {
public:
    using std::runtime_error::runtime_error;
};

/// Keeps the message of a failed call for pierce_last_error(), and returns the status.
pierce_status failed(pierce_status status, const char* message) noexcept;

/// The one place where exceptions end: runs what a call of the C API does, and says how it went.
template <class Call>
pierce_status guarded(Call&& call) noexcept {
    try {
        call();
        return PIERCE_OK;
    } catch (const InputError& error) {
        return failed(PIERCE_INVALID_INPUT, error.what());
    } catch (const NotBuilt& error) {
        return failed(PIERCE_NOT_BUILT, error.what());
    } catch (const OutOfMemory& error) {
        return failed(PIERCE_OUT_OF_MEMORY, error.what());
    } catch (const std::bad_alloc&) {
        return failed(PIERCE_OUT_OF_MEMORY, "out of memory");
    } catch (const std::exception& error) {
        return failed(PIERCE_INTERNAL, error.what());
    } catch (...) {
        return failed(PIERCE_INTERNAL, "an exception that says nothing");
    }
}

}  // namespace pierce::c
