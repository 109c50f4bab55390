#pragma once

#include "app/output/frame_log.hpp"

namespace pierce::app {

/// The paper's Table 4 measured here: update, narrow phase, response and total per frame of rays
/// and of GJK/EPA on the same motion, beside the paper's figures, with the colliding pairs each of
/// them found.
void print_table_4(const FrameLog& rays, const FrameLog& gjk_epa);

}  // namespace pierce::app
