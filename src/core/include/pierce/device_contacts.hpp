#pragma once

#include <cstdint>

#include "pierce/contact.hpp"

namespace pierce {

/// A list of contacts in device memory: as records, and as arrays with an entry for each contact,
/// points and normals with three numbers. All pointers are to device memory, but where there is no
/// room they may be null.
struct DeviceContactList {
    const std::uint32_t* count = nullptr;  ///< one number: how many contacts there are
    std::uint32_t room = 0;                ///< there are never more
    const Contact* records = nullptr;
    const std::uint32_t* body_a = nullptr;  ///< BodyId::index, like the next one
    const std::uint32_t* body_b = nullptr;
    const std::uint64_t* feature = nullptr;  ///< Contact::feature()
    const float* distance = nullptr;
    const float* point_a = nullptr;
    const float* point_b = nullptr;
    const float* normal = nullptr;
    /// Where each world's contacts begin in this list, and where the last one's end (WorldOffsets);
    /// null if there are no worlds.
    const std::uint32_t* world_begins = nullptr;
};

/// The contacts of the last step in device memory.
struct DeviceContacts {
    DeviceContactList solids, sheets;
    int device = 0;  ///< whose memory it is, by CUDA's numbers
};

}  // namespace pierce
