#pragma once

#include <vector>

#include "core/step/common/records.hpp"
#include "pierce/contact.hpp"

namespace pierce {

/// All that a step leaves for the next one, in host memory, so that a world can be saved.
struct StepMemory {
    bool by_world = false;                 ///< how pair_keys are written (PairKeys)
    std::vector<std::uint64_t> pair_keys;  ///< sorted
    std::vector<PairIdentity> identities;
    std::vector<SeenBody> bodies;

    // Of rays (records.hpp).
    std::vector<PairMemory> directed;  ///< two per pair, or none
    std::vector<BlockRecord> blocks;
    std::vector<PatchRecord> patches;
    std::vector<VertexRecord> vertices;
    std::vector<std::uint64_t> contact_keys;
    std::vector<std::uint32_t> ages;
    std::vector<Contact> contacts;  ///< as many, or none

    // Of sheets (sheet_memory.hpp).
    std::uint32_t sheet_bits = 0;
    std::vector<std::uint64_t> sheet_keys;
    std::vector<SheetRecord> sheet_records;
    std::vector<std::uint32_t> deepest;  ///< per pair, or none
};

}  // namespace pierce
