#include "support/brute_force.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace pierce::test {
namespace {

constexpr long double edge_band = 1e-5L;  // barycentric distance to an edge below which a hit is
                                          // unclear

SolidVec sub(SolidVec a, SolidVec b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
long double dot(SolidVec a, SolidVec b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
SolidVec cross(SolidVec a, SolidVec b) {
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
long double norm(SolidVec a) { return std::sqrt(dot(a, a)); }

struct Cross {
    long double t;
    int sign;
    std::uint32_t triangle;
    bool unclear;
};

long double extent(const Solid& solid) {
    SolidVec low = solid.positions[0], high = low;
    for (SolidVec p : solid.positions) {
        low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
        high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
    }
    return norm(sub(high, low));
}

std::vector<Cross> crossings(SolidVec o, SolidVec d, const Solid& solid, std::uint32_t excluded) {
    std::vector<Cross> found;
    for (std::uint32_t i = 0; i < solid.triangles.size(); ++i) {
        const auto& v = solid.triangles[i].vertex;
        if (v[0] == excluded || v[1] == excluded || v[2] == excluded) continue;
        const SolidVec a = solid.positions[v[0]], e1 = sub(solid.positions[v[1]], a),
                       e2 = sub(solid.positions[v[2]], a);
        const SolidVec n = cross(e1, e2);
        const long double det = -dot(d, n);
        if (std::fabs(det) <= 1e-9L * norm(n)) {
            // Parallel: unclear if the line runs close to the plane.
            if (std::fabs(dot(n, sub(o, a))) <= 1e-5L * norm(n)) found.push_back({0, 0, i, true});
            continue;
        }
        const SolidVec s = sub(o, a);
        const SolidVec q = cross(s, d);
        const long double t = dot(s, n) / det, u = dot(e2, q) / det, w = -dot(e1, q) / det,
                          rest = 1 - u - w;
        const long double least = std::min({u, w, rest});
        if (least < -edge_band) continue;
        found.push_back({t, dot(d, n) > 0 ? 1 : -1, i, least < edge_band});
    }
    std::ranges::sort(found, {}, &Cross::t);
    return found;
}

/// The first crossing at or after the start; nothing if there is none. Sets `unclear` if rounding
/// could change it.
std::optional<Cross> first(const std::vector<Cross>& sorted, long double band, bool& unclear) {
    for (const Cross& c : sorted) {
        if (c.t < -band) continue;
        if (c.unclear || c.t < band) unclear = true;
        return c;
    }
    return std::nullopt;
}

}  // namespace

SolidVec exact(Vec3d p) { return {p.x, p.y, p.z}; }

Solid solid_of(const MeshData& mesh, const Pose& pose) {
    const Frame frame = frame_of(pose);
    Solid solid{{}, mesh.triangles};
    for (Vec3f p : mesh.positions) solid.positions.push_back(exact(frame.to_parent(to_double(p))));
    return solid;
}

Expected expected_contacts(const Solid& source, const std::vector<SolidVec>& inward,
                           const Solid& target) {
    Expected expected;
    const long double band = 1e-5L * (extent(target) + extent(source));
    for (std::uint32_t v = 0; v < source.positions.size(); ++v) {
        bool unclear = false;
        const auto into_target = first(crossings(source.positions[v], inward[v], target, ~0u), band,
                                       unclear);
        const auto into_own = first(crossings(source.positions[v], inward[v], source, v), band,
                                    unclear);
        const bool r1 = into_target && into_target->sign > 0;
        const bool r2 = into_own && into_own->sign > 0;
        if (into_target && into_own && std::fabs(into_target->t - into_own->t) < band)
            unclear = true;
        if (unclear) {
            expected.unclear.push_back(v);
            continue;
        }
        if (r1 && r2 && into_target->t <= into_own->t)
            expected.contacts.push_back({v, into_target->triangle, into_target->t});
    }
    return expected;
}

Expected expected_self_contacts(const Solid& body, const std::vector<SolidVec>& inward,
                                const Solid& rest, long double away) {
    Expected expected;
    const long double band = 1e-5L * extent(body);
    for (std::uint32_t v = 0; v < body.positions.size(); ++v) {
        const std::vector<Cross> all = crossings(body.positions[v], inward[v], body, v);
        bool unclear = false;
        int winding = 0;
        for (const Cross& c : all) {
            unclear = unclear || c.unclear || std::fabs(c.t) < band;
            if (c.t < 0) winding -= c.sign;  // seen along the outward ray
        }
        const auto exit = first(all, band, unclear);
        if (unclear) {
            expected.unclear.push_back(v);
            continue;
        }
        if (winding < 1 || !exit || exit->sign < 0) continue;
        // The point of the triangle at rest, by the same weights.
        const auto& t = body.triangles[exit->triangle].vertex;
        const SolidVec a = body.positions[t[0]], e1 = sub(body.positions[t[1]], a),
                       e2 = sub(body.positions[t[2]], a);
        const SolidVec p{body.positions[v].x + exit->t * inward[v].x - a.x,
                         body.positions[v].y + exit->t * inward[v].y - a.y,
                         body.positions[v].z + exit->t * inward[v].z - a.z};
        const SolidVec n = cross(e1, e2);
        const long double u = dot(n, cross(p, e2)) / dot(n, n),
                          w = dot(n, cross(e1, p)) / dot(n, n);
        const auto at_rest = [&](long double SolidVec::*k) {
            return (1 - u - w) * rest.positions[t[0]].*k + u * rest.positions[t[1]].*k +
                   w * rest.positions[t[2]].*k;
        };
        const SolidVec q{at_rest(&SolidVec::x), at_rest(&SolidVec::y), at_rest(&SolidVec::z)};
        const long double distance = norm(sub(q, rest.positions[v]));
        if (std::fabs(distance - away) < band) expected.unclear.push_back(v);
        if (distance >= away) expected.contacts.push_back({v, exit->triangle, exit->t});
    }
    return expected;
}

int crossings_between(SolidVec from, SolidVec to, const Solid& solid, std::uint32_t excluded,
                      long double margin) {
    const SolidVec d = sub(to, from);
    int count = 0;
    for (const Cross& c : crossings(from, d, solid, excluded))
        if (c.sign != 0 && c.t > margin && c.t < 1 - margin) ++count;
    return count;
}

bool is_inside(SolidVec point, const Solid& solid) {
    // Sum of signed solid angles (Van Oosterom and Strackee 1983).
    long double sum = 0;
    for (const Triangle& t : solid.triangles) {
        const SolidVec a = sub(solid.positions[t.vertex[0]], point),
                       b = sub(solid.positions[t.vertex[1]], point),
                       c = sub(solid.positions[t.vertex[2]], point);
        const long double la = norm(a), lb = norm(b), lc = norm(c);
        sum += 2 * std::atan2(dot(a, cross(b, c)),
                              la * lb * lc + dot(a, b) * lc + dot(b, c) * la + dot(c, a) * lb);
    }
    return sum > 2 * std::numbers::pi_v<long double>;
}

}  // namespace pierce::test
