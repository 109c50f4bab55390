#pragma once

#include "pierce/core/constants.hpp"

namespace pierce {

/// How a world detects contacts. Every field has a default that suits any scale.
struct Settings {
    /// Rays of bodies without an inside reach this far [mean edge length of the body's mesh].
    double open_body_range = constants::open_body_range;
};

}  // namespace pierce
