#pragma once

#include <algorithm>

#include "core/body/body_view.hpp"
#include "core/device/view.hpp"
#include "core/mesh/patch.hpp"
#include "core/step/common/pairs.hpp"
#include "core/step/common/records.hpp"
#include "core/step/solids/vertex_cull.hpp"
#include "pierce/constants.hpp"
#include "pierce/explain.hpp"

namespace pierce {

/// The proof that spared a vertex of a pair its ray in the last step, if there was one. `memory`:
/// of the pair, from this side.
inline Certificate certificate_of(View<const BodyView> bodies, Pair pair, std::uint32_t side,
                                  std::uint32_t vertex, const PairMemory& memory,
                                  const RecordsView& records) {
    const BodyView &source = bodies[pair.source(side)], &target = bodies[pair.target(side)];
    if (!stages::is_asked(source, target, pair.is_self(), side)) return {};
    const View<const std::uint32_t> order = source.mesh.patch_vertices;
    const auto place = static_cast<std::uint32_t>(std::find(order.begin(), order.end(), vertex) -
                                                  order.begin());
    if (place == order.size) return {};
    const std::uint32_t patch = place / constants::patch_size;
    const auto until = [&](Certificate::Kind kind, float expiry) {
        const double left = static_cast<double>(expiry) - memory.odometer;
        return left > 0 ? Certificate{kind, left} : Certificate{};
    };
    const PatchRecord* in_patch = records.patch(memory.first_block, patch);
    if (in_patch == nullptr)
        return until(Certificate::patch,
                     records.blocks[memory.first_block + patch / constants::block_size]
                         .expiry[patch % constants::block_size]);
    const VertexRecord* record = records.vertex(in_patch, place % constants::patch_size);
    return record == nullptr ? until(Certificate::patch_rest, in_patch->expiry)
                             : until(Certificate::vertex, record->expiry);
}

}  // namespace pierce
