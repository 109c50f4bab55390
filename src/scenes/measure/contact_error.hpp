#pragma once

#include <cstdint>
#include <map>
#include <span>
#include <tuple>

#include "pierce/contact.hpp"

namespace pierce::scenes {

/// How contacts of some method differ from those of another one on the same frames, added up over
/// the frames.
struct ContactError {
    std::uint64_t expected = 0;      ///< contacts that should be found
    std::uint64_t missed = 0;        ///< of these, not found
    std::uint64_t added = 0;         ///< found, but not there
    std::uint64_t wrong = 0;         ///< found at another triangle
    double depth = 0;                ///< [length] summed over the expected ones
    double missed_depth = 0;         ///< [length] summed over the missed ones
    std::uint64_t first = 0;         ///< contacts that began
    std::uint64_t first_missed = 0;  ///< of these, missed in their first frame
    std::uint64_t late_steps = 0;    ///< frames until those contacts were found, or ended, added up
    std::uint32_t latest = 0;        ///< the most such frames for one contact

    /// Part of the depth that was missed [1].
    double missed_share() const { return depth > 0 ? missed_depth / depth : 0; }
    /// Part of the found contacts at another triangle [1].
    double wrong_share() const {
        return expected > missed
                   ? static_cast<double>(wrong) / static_cast<double>(expected - missed)
                   : 0;
    }
};

/// Compares contact lists frame by frame.
class ContactComparison {
public:
    /// Adds a frame; both lists must be sorted as a World sorts them.
    void add(std::span<const Contact> expected, std::span<const Contact> found);
    const ContactError& error() const { return error_; }

private:
    using Key = std::tuple<BodyId, BodyId, std::uint64_t>;

    ContactError error_;
    std::map<Key, std::uint32_t> waiting_;  ///< contacts missed since they began, and for how many
                                            ///< frames
    std::map<Key, bool> present_;           ///< expected in the last frame
};

}  // namespace pierce::scenes
