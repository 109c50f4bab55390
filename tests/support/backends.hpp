#pragma once

#include <gtest/gtest.h>

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "pierce/backend.hpp"

namespace pierce::test {

/// A backend a conformance test runs on.
struct NamedBackend {
    std::string name;
    std::function<std::unique_ptr<Backend>()> make;
};

/// Every backend of this build: the reference, our own trees, Embree with one thread and with
/// several, several backends that share a world, and CUDA. Does not look for a device.
std::vector<NamedBackend> known_backends();

/// Those that can run here.
std::vector<NamedBackend> backends();

/// True if a backend of this name can run here.
inline bool has_backend(const std::string& name) {
    for (const NamedBackend& backend : backends())
        if (backend.name == name) return true;
    return false;
}

inline std::string backend_name(const testing::TestParamInfo<NamedBackend>& info) {
    return info.param.name;
}
inline void PrintTo(const NamedBackend& backend, std::ostream* os) { *os << backend.name; }

}  // namespace pierce::test
