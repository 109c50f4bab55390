#pragma once

#include <string>
#include <vector>

namespace pierce::app {

/// A backend, and whether it can run here.
struct BackendState {
    std::string name;         ///< as --backend takes it
    std::string description;  ///< what it is here; empty if it cannot run
    std::string problem;      ///< why it cannot run; empty if it can

    bool runs() const { return problem.empty(); }
};

/// All there are.
std::vector<BackendState> backends();

/// The one that "automatic" takes.
std::string automatic_backend();

/// What `pierce --version` prints: version, commit, build, and a line for each backend.
std::string version_text();

}  // namespace pierce::app
