#pragma once

#include "core/body/body_view.hpp"
#include "core/body/scene.hpp"
#include "core/device/view.hpp"
#include "core/device/warp.hpp"
#include "core/mesh/mesh_view.hpp"
#include "core/mesh/patch.hpp"
#include "core/step/common/records.hpp"

/// bounds, first part: the frame in which a deforming body is closest to its rest shape.
/// Bodies are measured patch by patch, and the results are added up block by block, so that sums
/// are the same on any machine.
namespace pierce::stages {

/// Sums from which the best-fitting rotation follows.
struct Moments {
    Vec3d sum;       ///< of patch centres, relative to the body's first vertex
    Vec3d rest_sum;  ///< of the rest shape's patch centres, relative to the rest centroid
    Matrix3 correlation{{{}, {}, {}}};  ///< sum of the products of the two

    PIERCE_HD void add(const Moments& more) {
        sum += more.sum;
        rest_sum += more.rest_sum;
        for (int r = 0; r < 3; ++r) correlation.row[r] += more.correlation.row[r];
    }
};

static_assert(constants::block_size == Sixteen<Moments>::count);

/// The sum of sixteen.
PIERCE_HD inline Moments sum_of(const Sixteen<Moments>& parts) {
    return parts.joined<Moments>([](std::uint32_t, const Moments& part) { return part; },
                                 [](Moments& sum, const Moments& part) { sum.add(part); });
}

/// Per block: measures its patches, and adds up the moments of the patches' centres, which stand
/// for the vertices. Reads positions; writes blocks and patches.
struct MeasurePatches {
    View<const BodyView> bodies;
    View<const BlockItem> items;
    View<const View<PatchBlock>> blocks;  ///< per body
    View<const View<Offsets>> patches;    ///< per body
    View<Moments> moments;                ///< per block

    PIERCE_HD void operator()(std::uint32_t i) const {
        const std::uint32_t at = Sixteen<Moments>::group_of(i);
        const BlockItem item = items[at];
        if (item.body == no_body) return;
        const BodyView& body = bodies[item.body];
        PatchBlock& block = blocks[item.body][item.block];
        const std::uint32_t first = item.first_patch(), last = item.last_patch(body.mesh);
        const bool active = body.active;
        Sixteen<Moments> of_patches;
        of_patches.each([&](std::uint32_t k, Moments& m) {
            m = {};
            if (!active || first + k >= last) return;
            measure_patch(body.mesh, body.positions, first + k, block,
                          patches[item.body][first + k]);
            const Vec3d center = measured_center(body.mesh, body.positions, block, first, k);
            m.sum = center - to_double(body.positions[0]);
            m.rest_sum = patch_center(body.mesh.blocks, first + k) - body.mesh.centroid;
            for (int r = 0; r < 3; ++r) m.correlation.row[r] = m.sum[r] * m.rest_sum;
        });
        Sixteen<Moments>::settle();
        const Moments all = sum_of(of_patches);
        if (!Sixteen<Moments>::is_first()) return;
        if (active) finish_block(body.mesh, body.positions, item.block, block);
        moments[at] = all;
    }
};

/// A rotation near the one closest to `a`: its quaternion is the eigenvector of the largest
/// eigenvalue of a symmetric matrix (Horn 1987), found by shifting that matrix to have no negative
/// eigenvalue and squaring it repeatedly. The identity for a zero matrix.
PIERCE_HD inline Quaternion rough_rotation(const Matrix3& a) {
    const double xx = a.row[0].x, xy = a.row[1].x, xz = a.row[2].x, yx = a.row[0].y,
                 yy = a.row[1].y, yz = a.row[2].y, zx = a.row[0].z, zy = a.row[1].z,
                 zz = a.row[2].z;
    double m[4][4] = {{xx - yy - zz, xy + yx, zx + xz, yz - zy},
                      {xy + yx, yy - xx - zz, yz + zy, zx - xz},
                      {zx + xz, yz + zy, zz - xx - yy, xy - yx},
                      {yz - zy, zx - xz, xy - yx, xx + yy + zz}};
    // No eigenvalue is below minus the sum of the singular values of `a`.
    const double norm = std::sqrt(
        3 * (length_squared(a.row[0]) + length_squared(a.row[1]) + length_squared(a.row[2])));
    if (!(norm > 0)) return {};
    for (int i = 0; i < 4; ++i) m[i][i] += norm;
    for (std::uint32_t k = 0; k < constants::frame_fit_squarings; ++k) {
        const double scale = 1 / (m[0][0] + m[1][1] + m[2][2] + m[3][3]);
        double squared[4][4];
        for (int i = 0; i < 4; ++i)
            for (int j = 0; j <= i; ++j) {
                double sum = 0;
                for (int l = 0; l < 4; ++l) sum += (scale * m[i][l]) * (scale * m[l][j]);
                squared[i][j] = squared[j][i] = sum;
            }
        for (int i = 0; i < 4; ++i)
            for (int j = 0; j < 4; ++j) m[i][j] = squared[i][j];
    }
    // Every column is the eigenvector by now; the longest column has the least rounding.
    Quaternion q{m[0][0], m[1][0], m[2][0], m[3][0]};
    double largest = m[0][0];
    for (int k = 1; k < 4; ++k) {
        if (!(m[k][k] > largest)) continue;
        largest = m[k][k];
        q = {m[0][k], m[1][k], m[2][k], m[3][k]};
    }
    return q;
}

/// The rotation closest to `a` (in the sense of largest trace of R^T a): a rough one, made better
/// by the iteration of Mueller, Bender, Chentanez and Macklin (MIG 2016). It depends on nothing but
/// `a`, so that contacts do not depend on earlier steps.
PIERCE_HD inline Quaternion closest_rotation(const Matrix3& a) {
    Quaternion q = rough_rotation(a);
    const Matrix3 columns = a.transposed();
    for (std::uint32_t i = 0; i < constants::frame_fit_iterations; ++i) {
        const Matrix3 axes = rotation_matrix(q).transposed();
        Vec3d torque;
        double trace = 0;
        for (int k = 0; k < 3; ++k) {
            torque += cross(axes.row[k], columns.row[k]);
            trace += dot(axes.row[k], columns.row[k]);
        }
        const double size = std::fabs(trace);
        if (!(size > 0)) break;
        const Vec3d h = torque * (0.5 / size);
        // One step of rotation by the vector 2h, as the quaternion (h, 1), then back to unit
        // length.
        const Quaternion r{
            q.x + h.x * q.w + h.y * q.z - h.z * q.y, q.y + h.y * q.w + h.z * q.x - h.x * q.z,
            q.z + h.z * q.w + h.x * q.y - h.y * q.x, q.w - h.x * q.x - h.y * q.y - h.z * q.z};
        const double l = std::sqrt(r.x * r.x + r.y * r.y + r.z * r.z + r.w * r.w);
        q = {r.x / l, r.y / l, r.z / l, r.w / l};
    }
    return q;
}

/// Per deforming body: fits a frame. Reads moments; writes the body's fit.
struct FitFrame {
    View<BodyView> bodies;
    View<const BlockRange> ranges;
    View<const Moments> moments;

    PIERCE_HD void operator()(std::uint32_t i) const {
        const BlockRange range = ranges[Sixteen<Moments>::group_of(i)];
        BodyView& body = bodies[range.body];
        if (!body.active) return;
        Sixteen<Moments> parts;
        parts.each([&](std::uint32_t k, Moments& sum) {
            sum = {};
            for (std::uint32_t b = range.first + k; b < range.last; b += parts.count)
                sum.add(moments[b]);
        });
        Moments m = sum_of(parts);
        if (!Sixteen<Moments>::is_first()) return;
        const double per_patch = 1.0 / patch_count(body.mesh);
        const Vec3d mean = per_patch * m.sum, rest_mean = per_patch * m.rest_sum;
        for (int r = 0; r < 3; ++r) m.correlation.row[r] -= m.sum[r] * rest_mean;
        body.fit.rotation = rotation_matrix(closest_rotation(m.correlation));
        body.fit.origin = to_double(body.positions[0]) + mean -
                          body.fit.rotation * (body.mesh.centroid + rest_mean);
    }
};

}  // namespace pierce::stages
