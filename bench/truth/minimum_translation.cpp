#include "truth/minimum_translation.hpp"

#include <algorithm>
#include <limits>
#include <vector>

namespace pierce::truth {
namespace {

std::vector<Vec3d> edges(Convex body) {
    std::vector<Vec3d> result;
    for (const Triangle& t : body.triangles)
        for (int k = 0; k < 3; ++k) {
            const std::uint32_t v = t.vertex[k], w = t.vertex[(k + 1) % 3];
            if (v < w)
                result.push_back(body.positions[w] - body.positions[v]);  // its other triangle has
                                                                          // w < v
        }
    return result;
}

/// How far the body reaches along `direction`.
double support(Convex body, Vec3d direction) {
    double most = -std::numeric_limits<double>::infinity();
    for (Vec3d p : body.positions) most = std::max(most, dot(p, direction));
    return most;
}

}  // namespace

Translation minimum_translation(Convex a, Convex b) {
    Translation best{std::numeric_limits<double>::infinity(), {}};
    const auto try_direction = [&](Vec3d u) {
        const double way = support(a, u) + support(b, -u);
        if (way < best.length) best = {way, u};
    };
    // Any direction's way takes b out of a: one that rounding has turned is never too short, only
    // not the shortest.
    const auto try_both = [&](Vec3d direction) {
        const Vec3d u = normalized(direction);
        if (u == Vec3d{}) return;
        try_direction(u);
        try_direction(-u);
    };
    for (Convex body : {a, b})
        for (const Triangle& t : body.triangles) {
            const Vec3d corner = body.positions[t.vertex[0]];
            try_both(
                cross(body.positions[t.vertex[1]] - corner, body.positions[t.vertex[2]] - corner));
        }
    const std::vector<Vec3d> edges_of_b = edges(b);
    for (Vec3d of_a : edges(a))
        for (Vec3d of_b : edges_of_b) try_both(cross(of_a, of_b));
    return best;
}

}  // namespace pierce::truth
