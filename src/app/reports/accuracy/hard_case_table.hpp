#pragma once

#include "app/output/page.hpp"

namespace pierce::app {

/// The hard cases, their exact answers, and what each method answers; also as hard_cases.csv.
void hard_case_table(Page& page);

}  // namespace pierce::app
