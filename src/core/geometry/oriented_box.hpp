#pragma once

#include "pierce/box.hpp"
#include "pierce/pose.hpp"

namespace pierce {

/// True unless a plane separates the two boxes, each axis-aligned in its own frame (Gottschalk, Lin
/// and Manocha 1996: three face normals each and nine products of edges). `margin` widens the
/// answer towards true.
PIERCE_HD inline bool oriented_boxes_overlap(const Frame& frame_a, const Box& a,
                                             const Frame& frame_b, const Box& b, double margin) {
    const Frame b_to_a = relative_frame(frame_b, frame_a);
    const Matrix3& r = b_to_a.rotation;
    const Vec3d ha = a.half_size(), hb = b.half_size();
    const Vec3d d = b_to_a.to_parent(b.center()) - a.center();
    double f[3][3];
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) f[i][j] = std::fabs(r.row[i][j]);

    for (int i = 0; i < 3; ++i)
        if (std::fabs(d[i]) > ha[i] + hb.x * f[i][0] + hb.y * f[i][1] + hb.z * f[i][2] + margin)
            return false;
    for (int j = 0; j < 3; ++j) {
        const double gap = std::fabs(d.x * r.row[0][j] + d.y * r.row[1][j] + d.z * r.row[2][j]);
        if (gap > hb[j] + ha.x * f[0][j] + ha.y * f[1][j] + ha.z * f[2][j] + margin) return false;
    }
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) {
            const int i1 = (i + 1) % 3, i2 = (i + 2) % 3, j1 = (j + 1) % 3, j2 = (j + 2) % 3;
            const double gap = std::fabs(d[i2] * r.row[i1][j] - d[i1] * r.row[i2][j]);
            const double reach = ha[i1] * f[i2][j] + ha[i2] * f[i1][j] + hb[j1] * f[i][j2] +
                                 hb[j2] * f[i][j1];
            if (gap > reach + margin) return false;
        }
    return true;
}

}  // namespace pierce
