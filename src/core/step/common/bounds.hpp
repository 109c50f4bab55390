#pragma once

#include "core/body/body_view.hpp"
#include "core/body/scene.hpp"
#include "core/device/loops.hpp"
#include "core/device/view.hpp"
#include "core/device/warp.hpp"
#include "core/geometry/motion_bound.hpp"
#include "core/mesh/box_nodes.hpp"
#include "core/mesh/mesh_view.hpp"
#include "core/mesh/patch.hpp"
#include "core/step/common/records.hpp"
#include "pierce/ids.hpp"
#include "pierce/min_max.hpp"
#include "pierce/settings.hpp"

/// bounds, second part: where every body is, how far it is from its rest shape, and spheres around
/// its patches. Deforming bodies are measured as in frame_fit.hpp.
namespace pierce::stages {

/// What a patch, or a block of them, adds to its body's bounds.
struct PartBounds {
    Box fit_box, world_box;
    double deviation = 0, shape_motion = 0, travel = 0;  ///< [length]

    PIERCE_HD void extend(const PartBounds& part) {
        world_box.extend(part.world_box);
        fit_box.extend(part.fit_box);
        deviation = max_of(part.deviation, deviation);
        shape_motion = max_of(part.shape_motion, shape_motion);
        travel = max_of(part.travel, travel);
    }
};

/// An upper bound of how far a vertex of patch `p` has moved since the step began.
PIERCE_HD inline double longest_way(const BodyView& body, std::uint32_t p) {
    double squared = 0;
    PIERCE_OVERLAPPED_LOOP
    for (std::uint32_t k = 0; k < patch_length(body.mesh, p); ++k) {
        const std::uint32_t v = body.mesh.patch_vertices[patch_begin(p) + k];
        squared = max_of(length_squared(to_double(body.positions[v]) - to_double(body.start[v])),
                         squared);
    }
    return std::sqrt(squared);
}

/// The bounds of sixteen parts.
PIERCE_HD inline PartBounds bounds_of(const Sixteen<PartBounds>& parts) {
    return parts.joined<PartBounds>(
        [](std::uint32_t, const PartBounds& part) { return part; },
        [](PartBounds& all, const PartBounds& part) { all.extend(part); });
}

/// Per block: boxes and deviation. Reads blocks, patches and fit; writes its bounds. It computes in
/// float32 relative to the patch's centre; JoinBounds adds what that may lose.
struct MeasureBounds {
    View<const BodyView> bodies;
    View<const BlockItem> items;
    View<const View<SeenPatch>> seen;  ///< per body, its patches in its fit of the last step; empty
                                       ///< if not asked for
    View<PartBounds> bounds;           ///< per block

    PIERCE_HD void operator()(std::uint32_t i) const {
        const std::uint32_t at = Sixteen<PartBounds>::group_of(i);
        const BlockItem item = items[at];
        if (item.body == no_body) return;
        const BodyView& body = bodies[item.body];
        Sixteen<PartBounds> parts;
        parts.each([&](std::uint32_t k, PartBounds& part) {
            const std::uint32_t p = item.first_patch() + k;
            part = body.active && p < item.last_patch(body.mesh)
                       ? of_patch(body, p, seen[item.body])
                       : PartBounds{};
        });
        const PartBounds all = bounds_of(parts);
        if (Sixteen<PartBounds>::is_first()) bounds[at] = all;
    }

private:
    PIERCE_HD static PartBounds of_patch(const BodyView& body, std::uint32_t p,
                                         View<SeenPatch> last) {
        const Offsets now = body.patches[p], rest = body.mesh.patches[p];
        const Vec3d in_world = patch_center(body.blocks, p);
        const Vec3d center = body.fit.to_local(in_world);
        const Vec3f moved = to_float(center - patch_center(body.mesh.blocks, p));
        const TurnedOffsets<> turned(now, body.fit.rotation.transposed());
        float away[constants::patch_size];
        PIERCE_VECTOR_LOOP
        for (std::uint32_t k = 0; k < constants::patch_size; ++k) {
            const float x = moved.x + (turned.at[0][k] - rest.x[k]);
            const float y = moved.y + (turned.at[1][k] - rest.y[k]);
            const float z = moved.z + (turned.at[2][k] - rest.z[k]);
            away[k] = x * x + y * y + z * z;
        }
        float furthest = 0;
        for (std::uint32_t k = 0; k < constants::patch_size; ++k)
            furthest = max_of(away[k], furthest);
        PartBounds b;
        const float* fit_axis[3] = {turned.at[0], turned.at[1], turned.at[2]};
        extend(b.fit_box, center, fit_axis);
        const float* world_axis[3] = {now.x, now.y, now.z};
        extend(b.world_box, in_world, world_axis);
        b.deviation = std::sqrt(static_cast<double>(furthest));
        if (last.size > 0)
            b.shape_motion = std::sqrt(static_cast<double>(see(last[p], center, turned)));
        if (body.start.size > 0) b.travel = longest_way(body, p);
        return b;
    }

    /// Stores where a patch is now; returns the square of the longest way from where it was.
    PIERCE_HD static float see(SeenPatch& patch, Vec3d center, const TurnedOffsets<>& now) {
        const Vec3f moved = to_float(center - patch.center);
        float way[constants::patch_size];
        PIERCE_VECTOR_LOOP
        for (std::uint32_t k = 0; k < constants::patch_size; ++k) {
            const float x = moved.x + (now.at[0][k] - patch.offsets.x[k]);
            const float y = moved.y + (now.at[1][k] - patch.offsets.y[k]);
            const float z = moved.z + (now.at[2][k] - patch.offsets.z[k]);
            way[k] = x * x + y * y + z * z;
            patch.offsets.x[k] = now.at[0][k];
            patch.offsets.y[k] = now.at[1][k];
            patch.offsets.z[k] = now.at[2][k];
        }
        patch.center = center;
        float longest_way = 0;
        for (std::uint32_t k = 0; k < constants::patch_size; ++k)
            longest_way = max_of(way[k], longest_way);
        patch.motion = std::sqrt(longest_way);
        return longest_way;
    }

    PIERCE_HD static void extend(Box& box, Vec3d center, const float* const axis[3]) {
        for (int r = 0; r < 3; ++r) {
            float low = axis[r][0], high = low;
            for (std::uint32_t k = 1; k < constants::patch_size; ++k) {
                low = min_of(axis[r][k], low);
                high = max_of(axis[r][k], high);
            }
            box.lower[r] = min_of(center[r] + low, box.lower[r]);
            box.upper[r] = max_of(center[r] + high, box.upper[r]);
        }
    }
};

/// Per block, where no ray is cast: its box, and how far it has moved. Its body's frame is that of
/// the world.
struct MeasureBoxes {
    View<const BodyView> bodies;
    View<const BlockItem> items;
    View<PartBounds> bounds;  ///< per block

    PIERCE_HD void operator()(std::uint32_t i) const {
        const std::uint32_t at = Sixteen<PartBounds>::group_of(i);
        const BlockItem item = items[at];
        if (item.body == no_body) return;
        const BodyView& body = bodies[item.body];
        Sixteen<PartBounds> parts;
        parts.each([&](std::uint32_t k, PartBounds& part) {
            part = {};
            const std::uint32_t p = item.first_patch() + k;
            if (!body.active || p >= item.last_patch(body.mesh)) return;
            PIERCE_OVERLAPPED_LOOP
            for (std::uint32_t v = 0; v < patch_length(body.mesh, p); ++v)
                part.world_box.extend(
                    to_double(body.positions[body.mesh.patch_vertices[patch_begin(p) + v]]));
            part.fit_box = part.world_box;
            if (body.start.size > 0) part.travel = longest_way(body, p);
        });
        const PartBounds all = bounds_of(parts);
        if (Sixteen<PartBounds>::is_first()) bounds[at] = all;
    }
};

/// Per deforming body: joins its blocks' bounds. Writes the body's boxes, deviation and touch
/// tolerance.
struct JoinBounds {
    View<BodyView> bodies;
    View<const BlockRange> ranges;
    View<const PartBounds> bounds;
    bool has_fit = true;  ///< the body has a frame of its own

    PIERCE_HD void operator()(std::uint32_t i) const {
        const BlockRange range = ranges[Sixteen<PartBounds>::group_of(i)];
        BodyView& body = bodies[range.body];
        if (!body.active) return;
        Sixteen<PartBounds> parts;
        parts.each([&](std::uint32_t k, PartBounds& part) {
            part = {};
            for (std::uint32_t b = range.first + k; b < range.last; b += parts.count)
                part.extend(bounds[b]);
        });
        const PartBounds all = bounds_of(parts);
        if (!Sixteen<PartBounds>::is_first()) return;
        if (!has_fit) body.fit = {};
        body.touch = constants::touch_tolerance * all.fit_box.extent();
        body.world_box = all.world_box.inflated(body.touch);
        body.fit_box = all.fit_box.inflated(body.touch);
        body.deviation = all.deviation + body.touch;
        body.shape_motion = all.shape_motion + body.touch;
        body.travel = all.travel + (body.start.size > 0 ? body.touch : 0.0);
    }
};

/// Per node of deforming bodies' trees of boxes, level after level: the boxes around its triangles,
/// or around the nodes below.
struct MeasureNode {
    View<const BodyView> bodies;
    View<const NodeItem> items;
    View<const View<BoxNode>> nodes;   ///< per body
    View<const std::uint32_t> wanted;  ///< per body; empty: all of them are

    PIERCE_HD void operator()(std::uint32_t i) const {
        const NodeItem item = items[Sixteen<QuickBox>::group_of(i)];
        if (item.body == no_body) return;
        const BodyView& body = bodies[item.body];
        if (!body.active || (wanted.size > 0 && !wanted[item.body])) return;
        measure_node(body.mesh, body.positions, BoxLevels(body.mesh.triangles.size), item.node,
                     nodes[item.body]);
    }
};

/// Per body: whether the last step saw it, and where. Reads bodies; writes what this step saw.
struct CompareWithLast {
    View<BodyView> bodies;
    View<const BodyId> ids;
    View<const SeenBody> last;  ///< of the last step's bodies
    View<SeenBody> seen;

    PIERCE_HD void operator()(std::uint32_t i) const {
        BodyView& body = bodies[i];
        seen[i] = {ids[i], body.fit, body.active};
        body.seen = body.active && i < last.size && last[i].active && last[i].id == ids[i];
        body.still = body.seen && body.motion != Motion::deforming &&
                     are_identical(last[i].fit, body.fit);
        if (body.seen) body.last_fit = last[i].fit;
    }
};

/// Per body: how far predictions look, of its vertices and of what enters it: as far as the body
/// moves until the next full pass. The motion of a body that is seen for the first time is unknown,
/// so that nothing is predicted of it; the next step is a full pass. Reads bodies, their last fits
/// and settings; writes prediction_range.
struct MeasurePredictionRange {
    View<BodyView> bodies;
    Settings settings;

    static constexpr bool is_cheap = true;

    PIERCE_HD void operator()(std::uint32_t i) const {
        BodyView& body = bodies[i];
        body.prediction_range = 0;
        if (!body.active) return;
        if (settings.prediction_distance >= 0) {
            body.prediction_range = 0.5 * settings.prediction_distance;
            return;
        }
        if (!body.seen) return;
        body.prediction_range = min_of(
            settings.full_every *
                (largest_motion(body.last_fit, body.fit, body.fit_box) + body.shape_motion),
            0.5 * constants::prediction_limit * body.mesh.mean_edge_length);
    }
};

/// Per body: the world box of a fixed or rigid body that moved. Reads its pose and rest box.
struct PlaceBox {
    View<BodyView> bodies;
    bool meets_sheets = false;  ///< sheets see the body's vertices rounded to float32

    static constexpr bool is_cheap = true;

    PIERCE_HD void operator()(std::uint32_t i) const {
        BodyView& body = bodies[i];
        if (body.motion == Motion::deforming || !body.active) return;
        const Vec3d half = body.fit_box.half_size();
        const Vec3d center = body.space.to_parent(body.fit_box.center());
        Vec3d reach;
        for (int k = 0; k < 3; ++k) {
            const Vec3d r = body.space.rotation.row[k];
            reach[k] = std::fabs(r.x) * half.x + std::fabs(r.y) * half.y + std::fabs(r.z) * half.z;
        }
        body.world_box = {center - reach, center + reach};
        // If no stage needs where the step began, that is stored as where it ends.
        body.travel = largest_motion(body.start_space, body.space, body.fit_box);
        if (meets_sheets)
            body.travel += constants::float_ulp * (body.world_box.max_coordinate() + body.travel);
    }
};

}  // namespace pierce::stages
