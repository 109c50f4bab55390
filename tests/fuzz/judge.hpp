#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "fuzz/failure.hpp"
#include "fuzz/oracle.hpp"
#include "fuzz/program.hpp"
#include "support/backends.hpp"

namespace pierce::fuzz {

/// Which backends to play on; asked in the process that does, as a GPU's driver does not survive a
/// fork.
using Backends = std::function<std::vector<test::NamedBackend>()>;

/// What was looked at.
struct JudgeCounts {
    std::uint64_t worlds = 0, steps = 0, contacts = 0, calls = 0, refused = 0;
    OracleCounts oracle;

    JudgeCounts& operator+=(const JudgeCounts& o);
};

/// Plays a program on every backend side by side and looks, call by call, for a promise that is
/// broken: all answer alike; the contacts are those of a new world in the same state; invariants
/// hold; truth agrees. The first that is.
std::optional<Failure> judge(const Program& program,
                             const std::vector<test::NamedBackend>& backends, JudgeCounts& counts);

}  // namespace pierce::fuzz
