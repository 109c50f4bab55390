#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "fuzz/failure.hpp"
#include "fuzz/model.hpp"
#include "pierce/contact.hpp"

namespace pierce::fuzz {

/// How many questions were asked of the truth.
struct OracleCounts {
    std::uint64_t overlapping_pairs = 0;  ///< of solids, deeper than the touch tolerance
    std::uint64_t apart_pairs = 0;        ///< of solids, further than that
    std::uint64_t inside_vertices = 0;  ///< contacts whose vertex was looked for inside its target
    std::uint64_t expected_contacts = 0;  ///< of vertices, by definition (R1 to R3)
    std::uint64_t segments = 0;           ///< of contacts, looked for inside both bodies
    std::uint64_t feature_meetings = 0;   ///< contacts of sheets that are met during the step
    std::uint64_t feature_questions = 0;  ///< features near each other without a contact, which
                                          ///< exact arithmetic was asked about

    OracleCounts& operator+=(const OracleCounts& o);
};

/// Compares a step's contacts with what is true of the bodies, by predicates that know nothing of
/// the library's detection; the first thing that does not hold. Solids are judged where that is
/// well defined: closed surfaces that do not meet themselves and face outward.
std::optional<Failure> contradicted_by_truth(const Model& model, std::span<const Contact> contacts,
                                             OracleCounts& counts);

}  // namespace pierce::fuzz
