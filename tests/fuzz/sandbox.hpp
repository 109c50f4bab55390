#pragma once

#include <string>

#include "fuzz/judge.hpp"

namespace pierce::fuzz {

/// Judges a program in a process of its own, so that a crash, too, is a failure. The caller must
/// not have used a backend.
std::optional<Failure> judge_apart(const Program& program, const Backends& backends);

/// What a process that ended by a signal is said to have failed by.
std::string name_of_signal(int signal);

/// A world that takes longer than this hangs [s].
inline constexpr unsigned longest_world = 60;

}  // namespace pierce::fuzz
