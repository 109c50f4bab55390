#include "core/mesh_build/mesh_change.hpp"

#include <algorithm>
#include <array>
#include <map>
#include <utility>

#include "pierce/constants.hpp"

namespace pierce {
namespace {

Box box_of(const MeshView& mesh, const Triangle& t) {
    Box box;
    for (std::uint32_t v : t.vertex) box.extend(to_double(mesh.positions[v]));
    return box;
}

std::array<std::uint32_t, 3> key_of(const Triangle& t) {
    return {t.vertex[0], t.vertex[1], t.vertex[2]};
}

/// Per triangle of `now`, one with the same vertices before; no_triangle if there was none.
std::vector<std::uint32_t> matches(const MeshView& before, const MeshView& now) {
    std::vector<std::uint32_t> match(now.triangles.size, no_triangle);
    std::vector<bool> taken(before.triangles.size, false);
    // Most triangles keep their place, or move up together.
    const std::uint32_t both = std::min(before.triangles.size, now.triangles.size);
    for (std::uint32_t t = 0; t < both; ++t)
        if (before.triangles[t] == now.triangles[t]) {
            match[t] = t;
            taken[t] = true;
        }
    std::map<std::array<std::uint32_t, 3>, std::uint32_t> left;
    for (std::uint32_t t = 0; t < before.triangles.size; ++t)
        if (!taken[t]) left.emplace(key_of(before.triangles[t]), t);
    for (std::uint32_t t = 0; t < now.triangles.size; ++t) {
        if (match[t] != no_triangle) continue;
        const auto found = left.find(key_of(now.triangles[t]));
        if (found == left.end()) continue;
        match[t] = found->second;
        left.erase(found);
    }
    return match;
}

}  // namespace

MeshChange::MeshChange(const MeshView& before, const MeshView& now)
    : before_(matches(before, now)), vertex_changed_(now.positions.size, false) {
    std::vector<bool> stays(before.triangles.size, false);
    std::vector<Box> boxes;
    const auto touch = [&](const Triangle& t) {
        for (std::uint32_t v : t.vertex)
            if (v < vertex_changed_.size()) vertex_changed_[v] = true;
    };
    const auto is_in_place = [&](std::uint32_t v) {
        return v < before.positions.size && before.positions[v] == now.positions[v];
    };
    for (std::uint32_t t = 0; t < now.triangles.size; ++t) {
        const Triangle& triangle = now.triangles[t];
        if (before_[t] != no_triangle && !std::ranges::all_of(triangle.vertex, is_in_place))
            before_[t] = no_triangle;
        if (before_[t] != no_triangle) {
            stays[before_[t]] = true;
            continue;
        }
        boxes.push_back(box_of(now, triangle));
        came_.push_back(boxes.back());
        touch(triangle);
    }
    for (std::uint32_t t = 0; t < before.triangles.size; ++t) {
        if (stays[t]) continue;
        boxes.push_back(box_of(before, before.triangles[t]));
        touch(before.triangles[t]);
    }
    if (!boxes.empty()) changed_.emplace(std::move(boxes));
    same_box_ = before.box.lower == now.box.lower && before.box.upper == now.box.upper;
    rings_.assign(before.rings.begin(), before.rings.end());
    stars_.assign(before.star_clearance.begin(), before.star_clearance.end());
    clearance_ = {before.clearance_at,
                  {before.clearance_steps.begin(), before.clearance_steps.end()}};
}

bool MeshChange::is_same_around(const Box& region) const {
    if (!same_box_) return false;
    bool same = true;
    if (changed_) changed_->for_each_in(region, [&](std::uint32_t) { same = false; });
    return same;
}

std::optional<TriangleRing> MeshChange::ring(const MeshView& now, std::uint32_t triangle,
                                             double reach) const {
    const std::uint32_t before = before_[triangle];
    if (before == no_triangle || rings_.empty()) return std::nullopt;
    const Triangle& t = now.triangles[triangle];
    for (std::uint32_t v : t.vertex)
        if (vertex_changed_[v]) return std::nullopt;
    // The triangle that is nearest beyond the ring decides on the gap, which is told a little too
    // small. What is further away than that does not matter.
    const double near = std::min(
        reach, static_cast<double>(rings_[before].gap) + constants::ring_gap_loss * reach);
    if (!is_same_around(box_of(now, t).inflated(near))) return std::nullopt;
    return rings_[before];
}

std::optional<float> MeshChange::star(const MeshView& now, std::uint32_t vertex,
                                      double reach) const {
    if (vertex >= stars_.size() || vertex_changed_[vertex]) return std::nullopt;
    Box region;
    region.extend(to_double(now.positions[vertex]));
    if (!is_same_around(region.inflated(reach))) return std::nullopt;
    return stars_[vertex];
}

std::optional<ClearanceGrid> MeshChange::clearance() const {
    if (!same_box_ || clearance_.steps.empty()) return std::nullopt;
    const ClearanceGridView grid{clearance_.layout, view_of(clearance_.steps)};
    for (const Box& box : came_) {
        // The cells next to the surface are outside, too, and know of no clearance either.
        std::int32_t first[3], last[3];
        for (int k = 0; k < 3; ++k) {
            const auto cell = [&](double place) {
                return static_cast<std::int32_t>(std::clamp(
                    (place - grid.box.lower[k]) * grid.per_length, 0.0, grid.size[k] - 1.0));
            };
            first[k] = std::max(cell(box.lower[k]) - 1, 0);
            last[k] = std::min(cell(box.upper[k]) + 1, grid.size[k] - 1);
        }
        for (std::int32_t z = first[2]; z <= last[2]; ++z)
            for (std::int32_t y = first[1]; y <= last[1]; ++y)
                for (std::int32_t x = first[0]; x <= last[0]; ++x)
                    if (grid.steps_at(x, y, z) > 0) return std::nullopt;
    }
    return clearance_;
}

}  // namespace pierce
