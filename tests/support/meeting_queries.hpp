#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "truth/exact_continuous.hpp"

namespace pierce::test {

using truth::ExactCorners;

/// A question with a known answer: do four moving corners meet?
struct MeetingQuery {
    ExactCorners corners;
    bool meets = false;
};

/// Reads a file of the continuous collision benchmark of Wang et al. (2021): eight lines a query,
/// four corners at the start and four at the end; each line x, y, z as numerator, denominator, and
/// the answer. Throws std::runtime_error that names the line at fault.
std::vector<MeetingQuery> read_meeting_queries(const std::filesystem::path& file);

/// Files of a folder and those below it whose own folder has this name, sorted.
std::vector<std::filesystem::path> meeting_query_files(const std::filesystem::path& folder,
                                                       const std::string& name);

/// Corners as doubles, and whether nothing was lost.
struct RoundedCorners {
    std::array<MovingPoint, 4> corners;
    bool exact = true;
};
RoundedCorners rounded(const ExactCorners& corners);

}  // namespace pierce::test
