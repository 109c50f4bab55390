#pragma once

#include <cstdint>

#include "core/body/body_view.hpp"
#include "core/geometry/triangle.hpp"
#include "core/mesh/box_nodes.hpp"
#include "core/mesh/surface.hpp"
#include "core/step/common/records.hpp"
#include "core/step/edges/near_edge.hpp"
#include "core/step/edges/near_edges.hpp"
#include "core/step/edges/segment_gap.hpp"
#include "core/trace/first_crossing.hpp"
#include "pierce/min_max.hpp"

/// The triangles that an edge may cross, and where it crosses them.
namespace pierce::stages {

/// The triangles that an edge may cross.
class EdgeTriangles {
public:
    /// Of the target's triangles, those that may be closer to the edge than `slack` [length].
    /// Looks as far as `limit` [length], which is not less than the slack.
    PIERCE_HD EdgeTriangles(const BodyView& target, const PlacedEdge& edge, double slack,
                            double limit)
        : target_(target), gap_(limit), second_gap_(limit) {
        boxes_ = boxes_along(edge, target, limit);
        look(edge, slack, limit, [&](const auto& see) { for_each(see); });
    }

    /// The same of a few triangles; no others are closer than `limit`.
    PIERCE_HD EdgeTriangles(const BodyView& target, const PlacedEdge& edge, double slack,
                            double limit, const NearTriangles& few)
        : target_(target), gap_(limit), second_gap_(limit) {
        look(edge, slack, limit, [&](const auto& see) {
            for (std::uint32_t k = 0; k < few.count; ++k) see(few.triangle[k]);
        });
    }

    /// The only triangle that the edge may cross.
    PIERCE_HD EdgeTriangles(const BodyView& target, std::uint32_t triangle)
        : target_(target), count_(1), triangles_{triangle} {}

    PIERCE_HD std::uint32_t count() const { return count_; }
    PIERCE_HD std::uint32_t first() const { return triangles_[0]; }
    PIERCE_HD std::uint32_t operator[](std::uint32_t k) const { return triangles_[k]; }
    /// True if all of them are at hand.
    PIERCE_HD bool are_listed() const { return count_ <= most; }

    /// [length] How far away all of them are, or all but one, at least; the limit if further.
    PIERCE_HD double gap() const { return gap_; }
    PIERCE_HD double second_gap() const { return second_gap_; }

    /// The triangle that a ray along the edge crosses first.
    PIERCE_HD Hit first_hit(const Ray& ray) const {
        Surface alone = target_.surface();
        alone.covered = {};
        return first_crossing(ray, alone, [&](CrossingSearch& search) {
            each([&](std::uint32_t triangle) { search.test(triangle); });
        });
    }

    /// Calls see(triangle) for each of them, and maybe for others that are near.
    template <class See>
    PIERCE_HD void each(const See& see) const {
        if (!are_listed()) return for_each(see);
        for (std::uint32_t k = 0; k < count_; ++k) see(triangles_[k]);
    }

    /// The triangles that are closer than the limit, if they are few.
    PIERCE_HD const NearTriangles& near() const { return near_; }
    PIERCE_HD bool are_few() const { return near_.count <= NearTriangles::most; }

private:
    static constexpr std::uint32_t most = 16;

    template <class List>
    PIERCE_HD void look(const PlacedEdge& edge, double slack, double limit, const List& list) {
        std::uint32_t asked[SegmentGaps::count], size = 0;
        const auto measure = [&] {
            for (std::uint32_t k = size; k < SegmentGaps::count; ++k) asked[k] = asked[0];
            const SegmentGaps gaps(edge.a, edge.b, target_.surface(), asked);
            for (std::uint32_t k = 0; k < size; ++k) add(asked[k], gaps[k], slack, limit);
            size = 0;
        };
        list([&](std::uint32_t triangle) {
            asked[size++] = triangle;
            if (size == SegmentGaps::count) measure();
        });
        if (size > 0) measure();
    }

    PIERCE_HD void add(std::uint32_t triangle, double gap, double slack, double limit) {
        if (!(gap < limit)) return;
        if (are_few()) {
            if (near_.count < NearTriangles::most) near_.triangle[near_.count] = triangle;
            ++near_.count;
        }
        second_gap_ = min_of(max_of(gap, gap_), second_gap_);
        gap_ = min_of(gap, gap_);
        if (gap > slack) return;
        if (count_ < most) triangles_[count_] = triangle;
        ++count_;
    }

    template <class See>
    PIERCE_HD void for_each(const See& see) const {
        for_each_group(
            target_.box_nodes, BoxLevels(target_.mesh.triangles.size), boxes_,
            [&](std::uint32_t group, std::uint32_t mask) {
                for (; mask != 0; mask &= mask - 1)
                    see(target_.mesh
                            .group_triangles[group * constants::group_size + lowest_bit(mask)]);
                return false;
            });
    }

    const BodyView& target_;
    FewBoxes boxes_;
    double gap_ = 0, second_gap_ = 0;
    std::uint32_t count_ = 0;
    std::uint32_t triangles_[most];
    NearTriangles near_;
};

/// The crossings of a ray along an edge with its triangles, in their order, if each is inside its
/// triangle and further than the touch tolerance from the others and from the ray's ends. Then they
/// are what a search for one after the other finds.
class CleanCrossings {
public:
    static constexpr std::uint32_t most = 4;

    PIERCE_HD CleanCrossings(const EdgeTriangles& triangles, const Ray& ray,
                             const Surface& surface) {
        const ShearedRay line(ray.origin, ray.direction);
        hold_ = triangles.are_listed();
        for (std::uint32_t k = 0; hold_ && k < triangles.count(); ++k) {
            const TriangleCorners at = surface.corners(triangles[k]);
            add(triangles[k], cross_triangle(line, at.a, at.b, at.c), ray);
        }
        for (std::uint32_t k = 1; k < count_; ++k) hold_ &= t_[k] > t_[k - 1] + ray.touch;
    }

    PIERCE_HD bool hold() const { return hold_; }
    PIERCE_HD std::uint32_t count() const { return count_; }
    PIERCE_HD double t(std::uint32_t k) const { return t_[k]; }
    PIERCE_HD bool is_exit(std::uint32_t k) const { return is_exit_[k]; }
    PIERCE_HD std::uint32_t triangle(std::uint32_t k) const { return triangle_[k]; }

private:
    PIERCE_HD void add(std::uint32_t triangle, const Crossing& crossing, const Ray& ray) {
        if (crossing.kind == Crossing::none) return;
        const bool is_clean = crossing.kind == Crossing::transversal && crossing.weight[0] > 0 &&
                              crossing.weight[1] > 0 && crossing.weight[2] > 0;
        if (is_clean && (crossing.t < -ray.touch || crossing.t > ray.t_max + ray.touch)) return;
        hold_ = is_clean && count_ < most && crossing.t > ray.touch &&
                crossing.t < ray.t_max - ray.touch;
        if (!hold_) return;
        std::uint32_t k = count_++;
        for (; k > 0 && crossing.t < t_[k - 1]; --k) {
            t_[k] = t_[k - 1];
            triangle_[k] = triangle_[k - 1];
            is_exit_[k] = is_exit_[k - 1];
        }
        t_[k] = crossing.t;
        triangle_[k] = triangle;
        is_exit_[k] = crossing.sign > 0;
    }

    std::uint32_t count_ = 0;
    double t_[most];
    std::uint32_t triangle_[most];
    bool is_exit_[most];
    bool hold_ = true;
};

}  // namespace pierce::stages
