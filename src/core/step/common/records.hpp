#pragma once

#include "core/device/bits.hpp"
#include "core/device/view.hpp"
#include "core/trace/ray.hpp"
#include "pierce/body.hpp"
#include "pierce/constants.hpp"
#include "pierce/contact.hpp"
#include "pierce/pose.hpp"

/// What a step remembers of pairs, vertices and contacts for the next one. It is written anew in
/// every step and read in the next. It is dropped with its pair, when a body is
/// removed, and when a body gets another mesh.
namespace pierce {

/// A body as the last step saw it.
struct SeenBody {
    BodyId id;
    Frame fit;
    bool active = false;
    std::uint8_t padding[7] = {};
};

/// What must be the same for a pair to be last step's pair again.
struct PairIdentity {
    BodyId a, b;
    std::uint64_t mesh_a = 0, mesh_b = 0;
    SelfCollision self_a = SelfCollision::off, self_b = SelfCollision::off;
    bool sheet_a = false, sheet_b = false;
    std::uint8_t padding[4] = {};
    double margin = 0;  ///< [length] the larger one of both bodies'

    PIERCE_HD bool is(const PairIdentity& other) const {
        return a.index == other.a.index && a.generation == other.a.generation &&
               b.index == other.b.index && b.generation == other.b.generation &&
               mesh_a == other.mesh_a && mesh_b == other.mesh_b && self_a == other.self_a &&
               self_b == other.self_b && sheet_a == other.sheet_a && sheet_b == other.sheet_b &&
               margin == other.margin;
    }
};

inline constexpr std::uint32_t no_record = 0xffffffffu;

/// What is done with a directed pair in a step that remembers by the paper's threshold.
enum class Pass : std::uint8_t {
    full,  ///< all its vertices are looked at
    walk,  ///< only those with a record
};

/// The memory of a directed pair.
struct PairMemory {
    Frame relative;       ///< the fit of the source to that of the target
    double step = 0;      ///< [length] by how much the odometer went on in this step
    double odometer = 0;  ///< [length] no point of the source has moved further relative to the
                          ///< target since memory began
    double at_full = 0;   ///< the odometer at the last full pass; negative if predictions could not
                          ///< tell in that pass how the bodies move
    std::uint32_t since_full = 0;  ///< steps
    Pass pass = Pass::full;
    bool known = false;  ///< last step's records hold
    std::uint8_t padding[2] = {};
    std::uint32_t first_block = 0;  ///< where its block records begin
    std::uint32_t padding_at_end = 0;
};

/// A block of patches of one direction of a pair: 72 bytes.
struct BlockRecord {
    float expiry[constants::block_size] = {};  ///< per patch: outside the target until the odometer
                                               ///< reaches this
    std::uint32_t kept = 0;         ///< a bit for every patch whose vertices were looked at
    std::uint32_t first_patch = 0;  ///< where the records of those patches begin

    /// Where they begin is written later, if there are any.
    PIERCE_HD void keep(std::uint32_t patches) {
        kept = patches;
        first_patch = 0;
    }
};

/// A patch whose vertices were looked at: 12 bytes.
struct PatchRecord {
    std::uint32_t mask = 0;          ///< a bit for every vertex that was near the target
    std::uint32_t first_vertex = 0;  ///< where their records begin
    float expiry = 0;  ///< the other vertices are outside until the odometer reaches this
};

/// A vertex that was near the target: 44 bytes.
struct VertexRecord {
    std::uint32_t triangle = no_triangle;  ///< its ray's last hit, or the triangle it is predicted
                                           ///< to enter through
    std::uint32_t predicted = 0;           ///< 1: still outside
    float expiry = 0;                      ///< no contact until the odometer reaches this
    float retry = 0;  ///< no attempt to prove that before the odometer reaches this
    std::uint32_t contact = no_record;  ///< its contact's place in the step's list; any value if it
                                        ///< had no contact
    // Where the ray met the target when it was last traced: the material point, and the way there
    // in the target's fit frame.
    std::uint32_t seen_triangle = no_triangle;
    float seen_weight[2] = {};
    Vec3f seen_offset;
};

static_assert(sizeof(BlockRecord) == 72 && sizeof(PatchRecord) == 12 && sizeof(VertexRecord) == 44);

/// What is remembered of a contact of a sheet. If the same features meet again, they are the same
/// contact. For a vertex that has ended a step on the wrong side, the record says where the vertex
/// belongs, also when it is by now over a triangle that shares a corner with this one. For any
/// other vertex the start of the next step says where it belongs, and says it better: at a sharp
/// fold, triangles that share a corner have different sides.
struct SheetRecord {
    std::uint32_t other = 0;  ///< the triangle, or the edge of b
    std::uint32_t age = 0;
    std::int8_t side = 0;  ///< of a vertex that touches or is through, and of edges that touch:
                           ///< where they belong, as Judgement has it
    Found found = Found::near;
    bool is_self = false;
    bool is_edge = false;
    std::uint32_t padding = 0;
    double distance = 0;  ///< of the contact, for the sums over contacts
};

/// True if the contact at a place of the last step's list is the one with that key.
PIERCE_HD inline bool is_contact(View<const std::uint64_t> last_keys, std::uint32_t place,
                                 std::uint64_t key) {
    return place < last_keys.size && last_keys[place] == key;
}

/// Last step's records, found without a search: a block knows which patches it kept, and a patch
/// knows which vertices it kept.
struct RecordsView {
    View<const BlockRecord> blocks;
    View<const PatchRecord> patches;
    View<const VertexRecord> vertices;

    /// The record of a patch, or null.
    PIERCE_HD const PatchRecord* patch(std::uint32_t first_block, std::uint32_t patch) const {
        if (first_block == no_record) return nullptr;
        const BlockRecord& block = blocks[first_block + patch / constants::block_size];
        const std::uint32_t bit = 1u << patch % constants::block_size;
        if (!(block.kept & bit)) return nullptr;
        return &patches[block.first_patch + bit_count(block.kept & (bit - 1))];
    }

    /// The record of the patch's k-th vertex, or null.
    PIERCE_HD const VertexRecord* vertex(const PatchRecord* patch, std::uint32_t k) const {
        const std::uint32_t bit = 1u << k;
        if (patch == nullptr || !(patch->mask & bit)) return nullptr;
        return &vertices[patch->first_vertex + bit_count(patch->mask & (bit - 1))];
    }
};

/// What becomes of a vertex near the target in this step.
enum class Route : std::uint32_t {
    skip,    ///< certainly no contact
    walk,    ///< from its record
    full,    ///< a ray through the target's tree
    walked,  ///< the walk found the answer
    looked,  ///< a look from its record found the closest point
    kept,    ///< nothing has moved: its pair's contacts stay as they were
};

}  // namespace pierce
