#pragma once

#include "fuzz/choices.hpp"
#include "fuzz/program.hpp"

namespace pierce::fuzz {

/// A random program: a few small bodies, a few steps, and between those any calls of a World, most
/// of them meaningful.
Program random_program(Choices& choices);

}  // namespace pierce::fuzz
