#pragma once

#include <gtest/gtest.h>

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "pierce/core/backend.hpp"

namespace pierce::test {

/// A backend a conformance test runs on.
struct NamedBackend {
    std::string name;
    std::function<std::unique_ptr<Backend>()> make;
};

/// Every backend of this build: the reference, and Embree with one thread and with several.
std::vector<NamedBackend> backends();

inline std::string backend_name(const testing::TestParamInfo<NamedBackend>& info) { return info.param.name; }
inline void PrintTo(const NamedBackend& backend, std::ostream* os) { *os << backend.name; }

}  // namespace pierce::test
