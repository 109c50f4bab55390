#include "core/mesh_build/mesh_change.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <utility>

#include "core/mesh_build/kept_order.hpp"

namespace pierce {
namespace {

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
    : before_(matches(before, now)),
      triangles_before_(before.triangles.size),
      vertices_before_(before.positions.size),
      vertex_changed_(now.positions.size, false) {
    std::vector<bool> stays(before.triangles.size, false);
    const auto touch = [&](const Triangle& t) {
        for (std::uint32_t v : t.vertex)
            if (v < vertex_changed_.size()) vertex_changed_[v] = true;
    };
    const auto is_in_place = [&](std::uint32_t v) {
        return v < before.positions.size && before.positions[v] == now.positions[v];
    };
    std::uint32_t last = 0;
    for (std::uint32_t t = 0; t < now.triangles.size; ++t) {
        const Triangle& triangle = now.triangles[t];
        if (before_[t] != no_triangle && !std::ranges::all_of(triangle.vertex, is_in_place))
            before_[t] = no_triangle;
        if (before_[t] != no_triangle) {
            stays[before_[t]] = true;
            keeps_sequence_ = keeps_sequence_ && last <= before_[t];
            last = before_[t];
            continue;
        }
        corners_.push_back(corners_of(now.positions, triangle));
        touch(triangle);
    }
    new_triangles_ = corners_.size();
    for (std::uint32_t t = 0; t < before.triangles.size; ++t) {
        if (stays[t]) continue;
        corners_.push_back(corners_of(before.positions, before.triangles[t]));
        touch(before.triangles[t]);
    }
    std::vector<Box> boxes(corners_.size());
    for (std::size_t i = 0; i < boxes.size(); ++i)
        for (Vec3d p : corners_[i]) boxes[i].extend(p);
    for (const Box& box : boxes) all_changed_.extend(box);
    if (!boxes.empty()) changed_.emplace(std::move(boxes));
    same_box_ = before.box.lower == now.box.lower && before.box.upper == now.box.upper;
    rings_.assign(before.rings.begin(), before.rings.end());
    stars_.assign(before.star_clearance.begin(), before.star_clearance.end());
    clearance_ = {before.clearance_at,
                  {before.clearance_steps.begin(), before.clearance_steps.end()}};
}

std::vector<std::uint32_t> MeshChange::triangles_now() const {
    std::vector<std::uint32_t> now(triangles_before_, is_gone);
    for (std::uint32_t t = 0; t < before_.size(); ++t)
        if (before_[t] != no_triangle) now[before_[t]] = t;
    return now;
}

std::vector<std::uint32_t> MeshChange::partners(const MeshView& now,
                                                View<const bvh::Leaf> before) const {
    const std::vector<std::uint32_t> number = triangles_now();
    std::vector<std::uint32_t> partner(before_.size(), no_triangle);
    for (const bvh::Leaf& leaf : before) {
        if (leaf.size() == 1) continue;
        const std::uint32_t first = number[leaf.triangle[0]], second = number[leaf.triangle[1]];
        if (first == is_gone || second == is_gone) continue;
        // Around new triangles all are coupled anew, so that as few as possible stay alone.
        if (has_changed_corner(now, first) || has_changed_corner(now, second)) continue;
        partner[first] = second;
        partner[second] = first;
    }
    return partner;
}

bool MeshChange::has_changed_corner(const MeshView& now, std::uint32_t triangle) const {
    return std::ranges::any_of(now.triangles[triangle].vertex,
                               [&](std::uint32_t v) { return vertex_changed_[v]; });
}

bool MeshChange::is_same_around(const Box& region) const {
    if (!same_box_) return false;
    bool same = true;
    if (changed_) changed_->for_each_in(region, [&](std::uint32_t) { same = false; });
    return same;
}

const TriangleRing* MeshChange::ring(const MeshView& now, std::uint32_t triangle) const {
    const std::uint32_t before = before_[triangle];
    if (before == no_triangle || rings_.empty() || !same_box_) return nullptr;
    return has_changed_corner(now, triangle) ? nullptr : &rings_[before];
}

std::vector<std::uint32_t> MeshChange::triangles_with_changed_rings(const MeshView& now) const {
    double longest = 0;
    for (const Triangle& t : now.triangles) {
        const Corners c = corners_of(now.positions, t);
        for (std::size_t k = 0; k < 3; ++k)
            longest = std::max(length_squared(c[(k + 1) % 3] - c[k]), longest);
    }
    // No corner of a ring is further from the triangle's middle than by two edges.
    const double reach = 2 * std::sqrt(longest), loss = gap_loss(reach, now);
    std::vector<std::uint32_t> changed;
    for (std::uint32_t t = 0; t < now.triangles.size; ++t) {
        const TriangleRing* const known = ring(now, t);
        if (known == nullptr) {
            changed.push_back(t);
            continue;
        }
        Box region;
        for (Vec3d p : corners_of(now.positions, now.triangles[t])) region.extend(p);
        region = region.inflated(static_cast<double>(known->gap) + loss);
        if (overlap(region, all_changed_) && !is_same_around(region)) changed.push_back(t);
    }
    return changed;
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
    for (std::size_t i = 0; i < new_triangles_; ++i) {
        Box box;
        for (Vec3d p : corners_[i]) box.extend(p);
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
