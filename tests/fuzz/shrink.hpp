#pragma once

#include <functional>

#include "fuzz/program.hpp"

namespace pierce::fuzz {

/// A program that still `fails`, with fewer calls, fewer triangles and rounder numbers; nothing
/// that is tried makes it smaller (Zeller and Hildebrandt 2002, with the calls as the parts).
Program shrunk(Program program, const std::function<bool(const Program&)>& fails);

}  // namespace pierce::fuzz
