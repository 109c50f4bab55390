#include "core/mesh_build/covered_triangles.hpp"

#include <algorithm>
#include <utility>

#include "core/geometry/triangle_pair.hpp"
#include "core/mesh_build/box_tree.hpp"
#include "core/mesh_build/connected_parts.hpp"
#include "core/mesh_build/winding_tree.hpp"
#include "pierce/box.hpp"
#include "pierce/constants.hpp"

namespace pierce {
namespace {

constexpr std::uint32_t triangles_at_once = 64;  ///< of a thread

/// Where a triangle's winding number is asked for [barycentric]: in the middle, and near each
/// corner, since a face of another part may cover only an end of it.
constexpr double near_corner = 0.9, near_others = 0.05;

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

/// Says of triangles near other parts whether those parts cover them.
class CoverSearch {
public:
    CoverSearch(std::span<const Vec3f> positions, std::span<const Triangle> triangles,
                const std::vector<Box>& boxes, const PartsInBoxes& parts)
        : positions_(positions),
          triangles_(triangles),
          boxes_(boxes),
          parts_(parts),
          tree_(boxes),
          winding_(positions, triangles) {}

    Cover cover_of(std::uint32_t t) const {
        const Corners own = corners(t);
        if (is_degenerate(own[0], own[1], own[2])) return Cover::none;
        bool crosses = false;
        tree_.for_each_in(boxes_[t], [&](std::uint32_t other) {
            crosses = crosses || (parts_.part[other] != parts_.part[t] &&
                                  triangles_cross(own, corners(other)));
        });
        if (crosses) return Cover::partly;
        const int inside = is_inside(t, own, 1.0 / 3, 1.0 / 3) +
                           is_inside(t, own, near_corner, near_others) +
                           is_inside(t, own, near_others, near_corner) +
                           is_inside(t, own, near_others, near_others);
        return inside == 4 ? Cover::wholly : inside > 0 ? Cover::partly : Cover::none;
    }

private:
    Corners corners(std::uint32_t t) const {
        return corners_of({positions_.data(), static_cast<std::uint32_t>(positions_.size())},
                          triangles_[t]);
    }
    /// On the surface of a solid the winding number is 1/2, the mean of both sides.
    bool is_inside(std::uint32_t t, const Corners& c, double weight, double next) const {
        const Vec3d p = weight * c[0] + next * c[1] + (1 - weight - next) * c[2];
        return winding_.at(p, t) > 0.5 + constants::surface_winding;
    }

    std::span<const Vec3f> positions_;
    std::span<const Triangle> triangles_;
    const std::vector<Box>& boxes_;
    const PartsInBoxes& parts_;
    BoxTree tree_;
    WindingTree winding_;
};

}  // namespace

std::uint32_t count_covered(std::span<const Cover> covered) {
    return static_cast<std::uint32_t>(covered.size()) -
           static_cast<std::uint32_t>(std::ranges::count(covered, Cover::none));
}

std::vector<Cover> covered_triangles(std::span<const Vec3f> positions,
                                     std::span<const Triangle> triangles, Workers& workers) {
    std::vector<Box> boxes(triangles.size());
    for (std::size_t t = 0; t < triangles.size(); ++t)
        for (std::uint32_t v : triangles[t].vertex) boxes[t].extend(to_double(positions[v]));
    const PartsInBoxes parts = parts_in_boxes(triangles, positions.size(), boxes);
    if (parts.boxes.size() < 2) return {};

    const BoxTree part_tree(parts.boxes);
    std::vector<std::uint32_t> near;
    for (std::uint32_t t = 0; t < triangles.size(); ++t) {
        bool is_near = false;
        part_tree.for_each_in(boxes[t],
                              [&](std::uint32_t part) { is_near |= part != parts.part[t]; });
        if (is_near) near.push_back(t);
    }
    if (near.empty()) return {};

    const CoverSearch search(positions, triangles, boxes, parts);
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
