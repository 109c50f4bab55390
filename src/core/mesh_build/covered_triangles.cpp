#include "core/mesh_build/covered_triangles.hpp"

#include <algorithm>
#include <utility>

#include "core/geometry/triangle_pair.hpp"
#include "core/mesh_build/box_tree.hpp"
#include "core/mesh_build/connected_parts.hpp"
#include "core/mesh_build/triangle_groups.hpp"
#include "core/mesh_build/winding_tree.hpp"
#include "pierce/box.hpp"
#include "pierce/constants.hpp"

namespace pierce {
namespace {

constexpr std::uint32_t triangles_at_once = 64;  ///< of a thread

/// The connected parts of a surface and the boxes around them.
struct PartsInBoxes {
    std::vector<std::uint32_t> part;  ///< per triangle
    std::vector<Box> boxes;           ///< per part
};

PartsInBoxes parts_in_boxes(std::span<const Triangle> triangles, std::size_t vertex_count,
                            std::span<const Box> boxes) {
    ConnectedParts parts = connected_parts(triangles, vertex_count);
    PartsInBoxes result{std::move(parts.part), std::vector<Box>(parts.count)};
    for (std::size_t t = 0; t < triangles.size(); ++t) {
        result.boxes[result.part[t]].extend(boxes[t].lower);
        result.boxes[result.part[t]].extend(boxes[t].upper);
    }
    return result;
}

/// [length] How far from a surface something else must be to be seen on one side of it: beyond the
/// rounding of positions, and where things touch.
double off_surface(std::span<const Box> boxes) {
    Box box;
    for (const Box& b : boxes) {
        box.extend(b.lower);
        box.extend(b.upper);
    }
    return 2 * constants::touch_tolerance * box.extent() +
           2 * constants::float_ulp * std::max(length(box.lower), length(box.upper));
}

/// Says of triangles near other parts whether those parts cover them: whether they are around the
/// triangle's outer side. What lies flush with the triangle, and faces the same way, is not.
class CoverSearch {
public:
    CoverSearch(std::span<const Vec3f> positions, std::span<const Triangle> triangles,
                const std::vector<Box>& boxes, const PartsInBoxes& parts,
                std::span<const Twins> twins)
        : positions_(positions),
          triangles_(triangles),
          boxes_(boxes),
          parts_(parts),
          off_(off_surface(boxes)),
          tree_(boxes),
          winding_(positions, triangles),
          has_twin_(triangles.size(), false) {
        for (const auto& [one, other] : twins) has_twin_[one] = has_twin_[other] = true;
    }

    Cover cover_of(std::uint32_t t) const {
        const Corners own = corners(t);
        if (is_degenerate(own[0], own[1], own[2])) return Cover::none;
        const Corners outside = over(own);
        const Box region = boxes_[t].inflated(off_);
        bool crosses = false;
        tree_.for_each_that([&](const Box& box) { return !crosses && overlap(box, region); },
                            [&](std::uint32_t other) {
                                crosses = crosses || (parts_.part[other] != parts_.part[t] &&
                                                      !has_twin_[other] &&
                                                      triangles_cross(outside, corners(other)));
                            });
        if (crosses) return Cover::partly;
        const auto inside = std::ranges::count_if(places_of(outside),
                                                  [&](Vec3d p) { return winding_.at(p) > 0.5; });
        return inside == 4 ? Cover::wholly : inside > 0 ? Cover::partly : Cover::none;
    }

private:
    Corners corners(std::uint32_t t) const {
        return corners_of({positions_.data(), static_cast<std::uint32_t>(positions_.size())},
                          triangles_[t]);
    }
    /// A triangle that is a little outside of this one, and smaller: its sides touch no neighbours.
    Corners over(const Corners& c) const {
        const Vec3d middle = (1.0 / 3) * (c[0] + c[1] + c[2]),
                    up = off_ * normalized(cross(c[1] - c[0], c[2] - c[0]));
        Corners result;
        for (std::size_t k = 0; k < 3; ++k) {
            const Vec3d inward = middle - c[k];
            const double away = length(inward);
            result[k] = c[k] + std::min(2 * off_ / away, 0.5) * inward + up;
        }
        return result;
    }

    std::span<const Vec3f> positions_;
    std::span<const Triangle> triangles_;
    const std::vector<Box>& boxes_;
    const PartsInBoxes& parts_;
    double off_;  ///< [length]
    BoxTree tree_;
    WindingTree winding_;
    std::vector<bool> has_twin_;
};

}  // namespace

std::uint32_t count_covered(std::span<const Cover> covered) {
    return static_cast<std::uint32_t>(covered.size()) -
           static_cast<std::uint32_t>(std::ranges::count(covered, Cover::none));
}

std::vector<Cover> covered_triangles(std::span<const Vec3f> positions,
                                     std::span<const Triangle> triangles,
                                     std::span<const Twins> twins, Workers& workers) {
    std::vector<Box> boxes(triangles.size());
    for (std::size_t t = 0; t < triangles.size(); ++t)
        for (std::uint32_t v : triangles[t].vertex) boxes[t].extend(to_double(positions[v]));
    const PartsInBoxes parts = parts_in_boxes(triangles, positions.size(), boxes);
    if (parts.boxes.size() < 2) return {};

    const BoxTree part_tree(parts.boxes);
    std::vector<std::uint32_t> near;
    for (std::uint32_t t = 0; t < triangles.size(); ++t) {
        bool is_near = false;
        part_tree.for_each_that(
            [&](const Box& box) { return !is_near && overlap(box, boxes[t]); },
            [&](std::uint32_t part) { is_near = is_near || part != parts.part[t]; });
        if (is_near) near.push_back(t);
    }
    if (near.empty()) return {};

    const CoverSearch search(positions, triangles, boxes, parts, twins);
    std::vector<Cover> covered(triangles.size(), Cover::none);
    workers.share_out("parts", static_cast<std::uint32_t>(near.size()), triangles_at_once,
                      [&](std::uint32_t begin, std::uint32_t end) {
                          for (std::uint32_t i = begin; i < end; ++i)
                              covered[near[i]] = search.cover_of(near[i]);
                      });
    if (count_covered(covered) == 0) covered.clear();
    return covered;
}

}  // namespace pierce
