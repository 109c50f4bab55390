#pragma once

#include <limits>

#include "core/body/body_view.hpp"
#include "core/device/bits.hpp"
#include "core/device/loops.hpp"
#include "core/device/view.hpp"
#include "core/device/warp.hpp"
#include "core/mesh/mesh_view.hpp"
#include "core/mesh/patch.hpp"
#include "core/step/common/pair_marks.hpp"
#include "core/step/common/records.hpp"
#include "core/step/solids/cull_item.hpp"
#include "core/step/solids/directed_pair.hpp"
#include "core/step/solids/displacement.hpp"
#include "core/trace/ray.hpp"
#include "pierce/body.hpp"
#include "pierce/min_max.hpp"

/// vertex_cull: drops vertices that cannot be inside the other body: patches first, then
/// vertices.
namespace pierce::stages {

/// True if, at the pace of this step, a proof that a vertex is outside of its target may hold for
/// so many steps that trying pays.
PIERCE_HD inline bool proofs_pay(const DirectedPair& d, const BodyView& target) {
    return target.is_simple() && constants::certificate_limit * target.mesh.mean_edge_length >
                                     constants::certificate_steps * static_cast<double>(d.step);
}

/// True if vertices of a directed pair's source are looked at: its target has an inside, or they
/// look along their velocities.
PIERCE_HD inline bool is_asked(const BodyView& source, const BodyView& target, bool self,
                               std::uint32_t side) {
    return (self && source.sends_velocity_rays()) ||
           (target.is_solid() && target.mesh.has_extent() && !(self && side == 1));
}

/// Per directed pair (pair * 2 + side): the frames, and the blocks of patches there are to test;
/// none if the target has no inside. Reads pairs, bodies and, if steps remember, the pairs' memory;
/// writes directed pairs, blocks and where they begin.
struct DirectPair {
    View<const BodyView> bodies;
    View<const Pair> pairs;
    View<const std::uint32_t> links;
    View<PairMemory> memory;  ///< this and the next are empty if steps do not remember
    View<const PairMemory> last;
    Settings settings;
    View<DirectedPair> directed;
    View<std::uint32_t> begins;
    PairMarks marks;  ///< empty if nobody asks for them

    /// The number of blocks.
    PIERCE_HD std::uint32_t find(std::uint32_t i) const {
        const Pair pair = pairs[i / 2];
        DirectedPair d;
        d.source = pair.source(i % 2);
        d.target = pair.target(i % 2);
        const BodyView& source = bodies[d.source];
        const BodyView& target = bodies[d.target];
        const bool known = memory.size > 0 && source.motion != Motion::deforming;
        d.to_fit = known ? memory[i].relative : relative_frame(source.space, target.fit);
        d.to_space = target.motion == Motion::deforming ? relative_frame(source.space, target.space)
                                                        : d.to_fit;
        d.touch = touch_between(source, target, d.to_space);
        const bool knows = settings.prediction_distance >= 0 || (source.seen && target.seen);
        if (!d.is_self() && knows)
            d.approach.most = source.prediction_range + target.prediction_range;
        if (memory.size > 0) {
            const PairMemory& m = memory[i];
            d.odometer = static_cast<float>(m.odometer);
            // A pair that has just begun may be fast: proofs wait until its pace is known.
            d.step = m.known ? static_cast<float>(m.step) : std::numeric_limits<float>::infinity();
            d.pass = m.pass;
            if (m.known) d.last_blocks = last[2 * links[i / 2] + i % 2].first_block;
            d.still = settings.keeps_contacts() && m.known && source.still && target.still;
            if (d.is_self()) d.pass = Pass::full;  // what it remembers is about others
            const bool looks = d.approach.most > 0 && d.pass == Pass::full &&
                               settings.prediction_distance < 0;
            if (looks) d.approach = approach_of(source, target, m.relative, settings.full_every);
        }
        d.along_velocity = d.is_self() && source.sends_velocity_rays();
        if (d.along_velocity) d.last_blocks = no_record;
        directed[i] = d;
        // A pair in which nothing has moved keeps its contacts: nothing is to be looked for.
        if (marks.words.size > 0 && i % 2 == 0)
            marks.begin(i / 2, d.still ? PairMarks::vertex_inside | PairMarks::in_contact |
                                             PairMarks::has_depth | PairMarks::has_way_out
                                       : 0u);
        return is_asked(source, target, d.is_self(), i % 2) ? block_count(source.mesh) : 0;
    }
    PIERCE_HD static std::uint32_t count(std::uint32_t found) { return found; }
    PIERCE_HD void write(std::uint32_t i, std::uint32_t found, std::uint32_t place,
                         CullItem* blocks) const {
        begins[i] = place;
        if (memory.size > 0) memory[i].first_block = place;
        write_blocks(i, found, place, blocks);
    }
};

/// Balls as a target sees them, all sixteen or a share: how far outside of the target's box they
/// are, and how far outside of its solid by the clearance of their centres, less the target's
/// deviation. The centres are `center` plus offsets, turned and placed by `to_fit`. The balls reach
/// at most `span` from `center`. They are points if `radius` is null, and larger by `extra`.
template <class Share = AllOfSixteen>
struct BallsNearby {
    float beyond_squared[Share::count] = {};
    float clearance[Share::count];
    float size[Share::count];
    float jump = 0;          ///< by how much the clearance found may drop without the ball moving
    std::uint32_t near = 0;  ///< a bit for every ball, of the share, that may reach the solid or
                             ///< touch it

    PIERCE_HD BallsNearby(const BodyView& target, const Frame& to_fit, Vec3d center,
                          const Offsets& offsets, const float* radius, double span, double extra) {
        const ClearanceGridView grid = target.mesh.clearance();
        const bool has_grid = grid.steps.size > 0;
        const Vec3d corner = has_grid ? grid.box.lower : target.fit_box.lower;
        const Vec3d in_grid = to_fit.to_parent(center) - corner;
        const Vec3f c = to_float(in_grid);
        const TurnedOffsets<Share> turned(offsets, to_fit.rotation);
        // The centre, the rotation, the offsets and their sums are rounded to float32: each by at
        // most an ulp of its size.
        const double rounding = 4 * constants::float_ulp *
                                (std::fabs(in_grid.x) + std::fabs(in_grid.y) +
                                 std::fabs(in_grid.z) + span);
        const auto margin = static_cast<float>(2 * target.touch + rounding + extra);
        const Vec3f low = to_float(target.fit_box.lower - corner),
                    high = to_float(target.fit_box.upper - corner);
        const auto per_length = static_cast<float>(grid.per_length);
        std::int32_t cell[3][Share::count];
        for (int r = 0; r < 3; ++r) {
            const float last = static_cast<float>(grid.size[r]) - 1.0f;
            PIERCE_VECTOR_LOOP
            for (std::uint32_t k = 0; k < Share::count; ++k) {
                const float x = c[r] + turned.at[r][k];
                cell[r][k] = static_cast<std::int32_t>(clamp_to(x * per_length, 0.0f, last));
                const float gap = max_of(max_of(low[r] - x, x - high[r]), 0.0f);
                beyond_squared[k] += gap * gap;
            }
        }
        // From one cell to the next, the bound may drop by both cells' diagonals. A ball that is
        // outside is still outside. But where the bound itself must be found again, that is certain
        // only if it was larger by this drop.
        if (!target.is_simple())
            jump = static_cast<float>(2 * constants::cell_diagonal * grid.cell);
        const auto deviation = static_cast<float>(target.deviation);
        const auto step = static_cast<float>(grid.step);
        const std::uint32_t first = Share::first();
        for (std::uint32_t k = 0; k < Share::count; ++k)
            size[k] = (radius != nullptr ? radius[first + k] : 0.0f) + margin;
        for (std::uint32_t k = 0; k < Share::count; ++k) {
            clearance[k] = 0;
            if (beyond_squared[k] > size[k] * size[k])
                continue;  // the box decides, so the cell is not fetched
            const std::uint8_t steps = has_grid ? grid.steps_at(cell[0][k], cell[1][k], cell[2][k])
                                                : std::uint8_t{0};
            clearance[k] = step * static_cast<float>(steps) - deviation;
            near |= static_cast<std::uint32_t>(!(clearance[k] > size[k])) << (first + k);
        }
    }

    /// How far the k-th ball of the share, or the target, may move while the ball is still not
    /// near. For a simple target, the ball is that far outside; for any other, the test would still
    /// find it outside.
    PIERCE_HD float gap(std::uint32_t k) const {
        return max_of(std::sqrt(beyond_squared[k]), clearance[k] - jump) - size[k];
    }

    /// The least of the gaps of some balls, of those in the share; infinite if there are none.
    PIERCE_HD float least_gap(std::uint32_t mask) const {
        float least = INFINITY;
        for (std::uint32_t k = 0; k < Share::count; ++k)
            if (mask >> (Share::first() + k) & 1u) least = min_of(gap(k), least);
        return least;
    }
};

/// The lowest `count` bits.
PIERCE_HD inline std::uint32_t first_bits(std::uint32_t count) {
    return count < 32 ? (1u << count) - 1u : ~0u;
}

/// Where deforming bodies' patches say how far they have moved (bounds.hpp).
using SeenShapes = View<const View<SeenPatch>>;

/// [length] How far vertices of a patch, or of a block of patches, have moved within their body in
/// the last step; 0 if no prediction asks.
PIERCE_HD inline double change_of_patch(SeenShapes seen, const DirectedPair& d,
                                        std::uint32_t patch) {
    return d.approach.steps > 0 ? static_cast<double>(seen[d.source][patch].motion) : 0.0;
}
PIERCE_HD inline double change_of_block(SeenShapes seen, const DirectedPair& d,
                                        const MeshView& mesh, std::uint32_t block) {
    double most = 0;
    if (d.approach.steps > 0)
        for (std::uint32_t k = 0; k < block_length(mesh, block); ++k)
            most = max_of(change_of_patch(seen, d, block * constants::block_size + k), most);
    return most;
}

/// Per block: the patches that may hold a vertex inside the target or touching it. With block
/// records: patches that are still proved to be outside are not looked at again, and a walk pass
/// keeps only those that were kept in the last step. Writes those records.
template <class Share = AllOfSixteen>
struct CullBlock {
    View<const BodyView> bodies;
    View<const DirectedPair> directed;
    View<const CullItem> blocks;
    Temporal temporal = Temporal::off;
    SeenShapes seen;
    RecordsView last;
    View<BlockRecord> records;  ///< empty if steps do not remember

    /// A bit for each.
    PIERCE_HD std::uint32_t find(std::uint32_t item) const {
        const std::uint32_t i = Share::group_of(item), first = Share::first();
        const DirectedPair& d = directed[blocks[i].directed];
        const BodyView& source = bodies[d.source];
        const BlockRecord* before = d.last_blocks == no_record
                                        ? nullptr
                                        : &last.blocks[d.last_blocks + blocks[i].index];
        const std::uint32_t all = first_bits(block_length(source.mesh, blocks[i].index));
        std::uint32_t mask = 0;
        if (d.still) {
            mask = before->kept & expired(*before, d.odometer, all);
            for (std::uint32_t k = first; k < first + Share::count; ++k)
                records[i].expiry[k] = before->expiry[k];
        } else if (d.along_velocity) {
            mask = all;
            if (temporal != Temporal::off)
                for (std::uint32_t k = first; k < first + Share::count; ++k)
                    records[i].expiry[k] = 0;
        } else if (temporal == Temporal::paper && d.pass == Pass::walk) {
            mask = before->kept;
        } else if (temporal == Temporal::certified && before != nullptr &&
                   (expired(*before, d.odometer, all) &
                    ~(bodies[d.target].is_simple() ? before->kept : 0u)) == 0) {
            // Nothing is new: patches that were near are looked at vertex by vertex, the others are
            // still outside.
            mask = expired(*before, d.odometer, all);
            for (std::uint32_t k = first; k < first + Share::count; ++k)
                records[i].expiry[k] = before->expiry[k];
        } else {
            const PatchBlock& block = source.blocks[blocks[i].index];
            const BallsNearby<Share> balls(
                bodies[d.target], d.to_fit, block.center, block.offsets, block.radius,
                static_cast<double>(block.reach),
                d.approach.reach(block.center, static_cast<double>(block.reach),
                                 change_of_block(seen, d, source.mesh, blocks[i].index)));
            mask = Share::of_all(balls.near) & all;
            if (temporal == Temporal::certified) {
                if (before != nullptr) mask &= expired(*before, d.odometer, all);
                for (std::uint32_t k = 0; k < Share::count; ++k) {
                    const float until = d.odometer + balls.gap(k);
                    records[i].expiry[first + k] = before != nullptr
                                                       ? max_of(before->expiry[first + k], until)
                                                       : until;
                }
            }
        }
        if (temporal != Temporal::off && first == 0) records[i].keep(mask);
        // Nothing expires here, but all of a record is saved.
        if (temporal == Temporal::paper)
            for (std::uint32_t k = first; k < first + Share::count; ++k) records[i].expiry[k] = 0;
        return Share::mine(mask);
    }
    PIERCE_HD static std::uint32_t count(std::uint32_t mask) { return bit_count(mask); }
    PIERCE_HD void write(std::uint32_t item, std::uint32_t mask, std::uint32_t place,
                         CullItem* patches) const {
        const std::uint32_t i = Share::group_of(item);
        if (records.size > 0 && Share::first() == 0) records[i].first_patch = place;
        write_parts(blocks[i], constants::block_size, mask, place, patches);
    }

private:
    PIERCE_HD static std::uint32_t expired(const BlockRecord& record, float odometer,
                                           std::uint32_t all) {
        std::uint32_t mask = 0;
        for (std::uint32_t k = 0; k < constants::block_size; ++k)
            mask |= static_cast<std::uint32_t>(!(record.expiry[k] > odometer)) << k;
        return mask & all;
    }
};

/// Per kept patch: the vertices that may be inside the target or touch it. With records, these
/// vertices stay the same while the others are proved to be outside. If all vertices of a patch
/// turn out to be outside, the patch is not looked at until one of them may be near. A walk pass
/// keeps the vertices with a triangle. Writes patch records. Beside the vertices left, lists their
/// records of the last step, and routes without a ray while a vertex is proved to be outside, or
/// nothing has moved.
template <class Share = AllOfSixteen>
struct CullVertices {
    View<const BodyView> bodies;
    View<const DirectedPair> directed;
    View<const CullItem> patches;
    Temporal temporal = Temporal::off;
    SeenShapes seen;
    RecordsView last;
    View<const std::uint32_t> block_offsets;  ///< per directed pair
    View<BlockRecord> block_records;  ///< this and the next are empty if steps do not remember
    View<PatchRecord> records;

    /// A bit for each.
    PIERCE_HD std::uint32_t find(std::uint32_t item) const {
        const std::uint32_t i = Share::group_of(item);
        const DirectedPair& d = directed[patches[i].directed];
        const BodyView& source = bodies[d.source];
        const std::uint32_t p = patches[i].index;
        PatchRecord record;
        const PatchRecord* before = before_of(d, p);
        if (d.still) {
            record = *before;
        } else if (d.along_velocity) {
            record.mask = first_bits(patch_length(source.mesh, p));
        } else if (temporal == Temporal::paper && d.pass == Pass::walk) {
            std::uint32_t slot = before->first_vertex;
            for (std::uint32_t mask = before->mask; mask != 0; mask &= mask - 1, ++slot)
                if (last.vertices[slot].triangle != no_triangle) record.mask |= mask & (0 - mask);
        } else if (temporal == Temporal::certified && before != nullptr &&
                   before->expiry > d.odometer && bodies[d.target].is_simple()) {
            record = *before;
        } else {
            const PatchBlock& block = source.blocks[p / constants::block_size];
            const Vec3d center = patch_center(source.blocks, p);
            const auto radius = static_cast<double>(block.radius[p % constants::block_size]);
            const BallsNearby<Share> balls(
                bodies[d.target], d.to_fit, center, source.patches[p], nullptr, radius,
                d.approach.reach(center, radius, change_of_patch(seen, d, p)));
            const std::uint32_t all = first_bits(patch_length(source.mesh, p));
            record.mask = Share::of_all(balls.near) & all;
            if (temporal == Temporal::certified) {
                record.expiry = d.odometer +
                                Share::least_of_all(balls.least_gap(all & ~record.mask));
                if (record.mask == 0 && Share::first() == 0)
                    block_records[block_offsets[patches[i].directed] + p / constants::block_size]
                        .expiry[p % constants::block_size] = record.expiry;
            }
        }
        record.first_vertex = 0;
        if (temporal != Temporal::off && Share::first() == 0) records[i] = record;
        return Share::mine(record.mask);
    }
    PIERCE_HD static std::uint32_t count(std::uint32_t mask) { return bit_count(mask); }
    PIERCE_HD void write(std::uint32_t item, std::uint32_t mask, std::uint32_t place,
                         RaySource* sources) const {
        const CullItem patch = patches[Share::group_of(item)];
        for (std::uint32_t left = mask; left != 0; left &= left - 1)
            sources[place++] = source_of(patch, lowest_bit(left));
    }
    PIERCE_HD void write(std::uint32_t item, std::uint32_t mask, std::uint32_t place,
                         RaySource* sources, Route* routes, VertexRecord* vertices) const {
        const std::uint32_t i = Share::group_of(item);
        const CullItem patch = patches[i];
        const DirectedPair& d = directed[patch.directed];
        const PatchRecord* before = before_of(d, patch.index);
        if (Share::first() == 0) records[i].first_vertex = place;
        for (std::uint32_t left = mask; left != 0; left &= left - 1, ++place) {
            const std::uint32_t k = lowest_bit(left);
            sources[place] = source_of(patch, k);
            const VertexRecord* record = last.vertex(before, k);
            vertices[place] = record != nullptr ? *record : VertexRecord{};
            const bool skips = record != nullptr && record->expiry > d.odometer &&
                               d.waits(temporal);
            routes[place] = skips ? Route::skip : Route::full;
            if (d.still) routes[place] = Route::kept;
        }
    }

private:
    PIERCE_HD const PatchRecord* before_of(const DirectedPair& d, std::uint32_t patch) const {
        return temporal == Temporal::off ? nullptr : last.patch(d.last_blocks, patch);
    }

    PIERCE_HD RaySource source_of(const CullItem& patch, std::uint32_t k) const {
        const View<const std::uint32_t> vertices = bodies[directed[patch.directed].source]
                                                       .mesh.patch_vertices;
        return {patch.directed / 2, vertices[patch_begin(patch.index) + k],
                static_cast<std::uint8_t>(patch.directed % 2)};
    }
};

static_assert(constants::patch_size == AllOfSixteen::count &&
              constants::block_size == AllOfSixteen::count);

}  // namespace pierce::stages
