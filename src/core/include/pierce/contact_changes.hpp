#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "pierce/contact.hpp"

namespace pierce {

/// Which contacts are new, which were there before, and which are gone: places in the lists that
/// were compared, in their order.
struct ContactChanges {
    std::vector<std::uint32_t> began;   ///< places in the later list
    std::vector<std::uint32_t> stayed;  ///< places in the later list
    std::vector<std::uint32_t> ended;   ///< places in the earlier list
};

/// Compares two lists of contacts, such as copies of World::contacts() after two steps. Two
/// contacts are the same if their bodies and Contact::feature() are. Takes n log n.
ContactChanges contact_changes(std::span<const Contact> earlier, std::span<const Contact> later);

}  // namespace pierce
