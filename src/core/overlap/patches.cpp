#include "core/overlap/patches.hpp"

#include <algorithm>
#include <functional>

#include "core/geometry/closest_point.hpp"
#include "core/mesh_build/box_tree.hpp"
#include "pierce/constants.hpp"

namespace pierce {
namespace {

/// A place of one surface inside the other one.
struct Place {
    Vec3d at;
    double area = 0;  ///< that it stands for
    double depth = 0;
    Vec3d normal;  ///< unit, from a to b
};

/// Closest points of a surface.
class Closest {
public:
    Closest(const Grid& grid, const GridSurface& surface) : tree_(boxes_of(grid, surface)) {
        for (const Triangle& t : surface.triangles) {
            auto& corners = corners_.emplace_back();
            for (std::size_t k = 0; k < 3; ++k)
                corners[k] = grid.place(surface.points[t.vertex[k]]);
        }
    }

    Vec3d to(Vec3d p) {
        // What is close to one place is close to the next.
        Vec3d found = on(last_, p);
        double nearest = length(found - p);
        tree_.for_each_that([&](const Box& box) { return box.distance(p) < nearest; },
                            [&](std::uint32_t t) {
                                const Vec3d other = on(t, p);
                                if (!(length(other - p) < nearest)) return;
                                nearest = length(other - p);
                                found = other;
                                last_ = t;
                            });
        return found;
    }

private:
    static std::vector<Box> boxes_of(const Grid& grid, const GridSurface& surface) {
        std::vector<Box> boxes(surface.triangles.size());
        for (std::size_t t = 0; t < boxes.size(); ++t)
            for (std::uint32_t v : surface.triangles[t].vertex)
                boxes[t].extend(grid.place(surface.points[v]));
        return boxes;
    }

    Vec3d on(std::uint32_t t, Vec3d p) const {
        return closest_on_triangle(p, corners_[t][0], corners_[t][1], corners_[t][2]);
    }

    BoxTree tree_;
    std::vector<std::array<Vec3d, 3>> corners_;
    std::uint32_t last_ = 0;
};

/// Finds the places of one surface that is inside another one.
class Places {
public:
    /// What is not deeper than `touch` has no way out of its own; `outward` turns the surface's
    /// normals so that they point from a to b.
    Places(Closest& other, Vec3d origin, double touch, double outward, std::vector<Place>& places)
        : other_(other), origin_(origin), touch_(touch), outward_(outward), places_(places) {}

    /// Triangles from the middle of the part to its outline, each by the middles of its edges: a
    /// rule that is exact for squares of places. Of a part that does not see its whole outline from
    /// its middle, as a ring, the middle may be outside: it counts at the middles of its outline,
    /// where it has no depth.
    void add(const FacePart& part) {
        if (!(part.area > 0)) return;
        // Of a sliver, whose area is hardly more than rounding, the middle is within the outline,
        // too.
        Box around;
        for (const OutlinePiece& piece : part.outline) {
            around.extend(piece.from);
            around.extend(piece.to);
        }
        const Vec3d middle = clamped(1 / part.area * part.moment, around);
        const auto area = [&](const OutlinePiece& piece) {
            return 0.5 * piece.weight *
                   dot(part.normal, cross(piece.from - middle, piece.to - middle));
        };
        const bool is_star = std::ranges::all_of(part.outline, [&](const OutlinePiece& piece) {
            return area(piece) >= -constants::double_rounding * part.area;
        });
        if (!is_star) {
            double around_all = 0;
            const auto size = [](const OutlinePiece& piece) {
                return piece.weight * length(piece.to - piece.from);
            };
            for (const OutlinePiece& piece : part.outline) around_all += size(piece);
            for (const OutlinePiece& piece : part.outline)
                add(origin_ + 0.5 * (piece.from + piece.to), part.area * size(piece) / around_all,
                    part.normal);
            return;
        }
        for (const OutlinePiece& piece : part.outline) {
            const double share = area(piece) / 3;
            // A piece without area lies anywhere on a line through the middle.
            if (!(share > constants::double_rounding * part.area)) continue;
            add(origin_ + 0.5 * (middle + piece.from), share, part.normal);
            add(origin_ + 0.5 * (middle + piece.to), share, part.normal);
            add(origin_ + 0.5 * (piece.from + piece.to), share, part.normal);
        }
    }
    /// A vertex stands for no area, but may be the deepest place.
    void add_vertex(Vec3d at) { add(at, 0, {}); }

private:
    void add(Vec3d at, double area, Vec3d face_normal) {
        const Vec3d way = other_.to(at) - at;
        const double depth = length(way);
        const bool touches = !(depth > touch_);
        if (touches && area == 0) return;
        places_.push_back(
            {at, area, depth, touches ? outward_ * face_normal : -outward_ / depth * way});
    }

    static Vec3d clamped(Vec3d p, const Box& box) {
        for (int k = 0; k < 3; ++k) p[k] = std::clamp(p[k], box.lower[k], box.upper[k]);
        return p;
    }

    Closest& other_;
    Vec3d origin_;  ///< of the parts' places
    double touch_;
    double outward_;
    std::vector<Place>& places_;
};

}  // namespace

std::vector<ContactPatch> find_patches(const Grid& grid, const std::array<GridSurface, 2>& surfaces,
                                       const FaceParts& parts, double same_direction) {
    std::vector<Place> places;
    for (std::size_t side = 0; side < 2; ++side) {
        if (parts.of[side].empty()) continue;
        Closest other(grid, surfaces[1 - side]);
        Places of_side(other, parts.origin, constants::touch_tolerance * grid.extent(),
                       side == 0 ? 1 : -1, places);
        for (const FacePart& part : parts.of[side]) of_side.add(part);
        for (const std::uint32_t v : parts.vertices_in[side])
            of_side.add_vertex(grid.place(surfaces[side].points[v]));
    }
    std::ranges::stable_sort(places, std::greater{}, &Place::depth);

    struct Group {
        Vec3d lead;  ///< the normal of the deepest place
        ContactPatch patch;
    };
    std::vector<Group> groups;
    for (const Place& place : places) {
        auto home = std::ranges::find_if(
            groups, [&](const Group& g) { return dot(g.lead, place.normal) >= same_direction; });
        if (home == groups.end()) {
            home = groups.insert(groups.end(), {.lead = place.normal, .patch = {}});
            home->patch.depth = place.depth;
            home->patch.deepest = place.at;
        }
        ContactPatch& patch = home->patch;
        const double share = 0.5 * place.area;
        patch.area += share;
        patch.depth_volume += share * place.depth;
        patch.center += share * place.at;
        patch.normal += share * place.normal;
    }
    std::vector<ContactPatch> patches;
    for (Group& group : groups) {
        ContactPatch& patch = group.patch;
        // Vertices alone have no area.
        if (!(patch.area > 0)) continue;
        patch.center = 1 / patch.area * patch.center;
        patch.normal = normalized(patch.normal);
        patches.push_back(patch);
    }
    return patches;
}

}  // namespace pierce
