#include "core/geometry/half_spaces.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "pierce/constants.hpp"

namespace pierce {
namespace {

/// Half-spaces on whose planes a point lies.
struct Active {
    std::array<const HalfSpace*, 3> planes{};
    std::size_t count = 0;

    void add(const HalfSpace* plane) { planes[count++] = plane; }
};

/// The point of all these planes that is closest to the origin; nothing if they have no point in
/// common that is well defined.
std::optional<Vec3d> point_on(const Active& active) {
    const auto n = [&](std::size_t i) { return active.planes[i]->normal; };
    const auto d = [&](std::size_t i) { return active.planes[i]->least; };
    if (active.count == 1) return d(0) * n(0);
    if (active.count == 2) {
        const double c = dot(n(0), n(1)), det = length_squared(cross(n(0), n(1)));
        if (!(det > constants::translation_rounding)) return std::nullopt;
        return ((d(0) - c * d(1)) / det) * n(0) + ((d(1) - c * d(0)) / det) * n(1);
    }
    const double volume = dot(n(0), cross(n(1), n(2)));
    if (!(std::fabs(volume) > constants::translation_rounding)) return std::nullopt;
    return (1 / volume) *
           (d(0) * cross(n(1), n(2)) + d(1) * cross(n(2), n(0)) + d(2) * cross(n(0), n(1)));
}

/// The same for a point that misses no half-space by more than `slack` [length].
std::optional<Vec3d> closest_within(double slack, std::span<const HalfSpace> all) {
    const auto missed_by = [](const HalfSpace& h, Vec3d point) {
        return h.least - dot(h.normal, point);
    };
    Active active;
    Vec3d point;
    // In exact arithmetic no set of planes comes again, and hardly any half-space joins twice.
    for (std::size_t round = 0; round < all.size() + constants::translation_rounds; ++round) {
        const HalfSpace* worst = nullptr;
        double most = slack;
        for (const HalfSpace& h : all)
            if (const double by = missed_by(h, point); by > most) {
                most = by;
                worst = &h;
            }
        if (worst == nullptr) return point;

        // The closest point that is in this half-space and in those that held the last point: its
        // own plane holds it, and some of the others do.
        std::optional<Vec3d> next;
        Active holding;
        for (unsigned subset = 0; subset < 1u << active.count; ++subset) {
            Active some;
            some.add(worst);
            for (std::size_t i = 0; i < active.count; ++i)
                if ((subset >> i & 1u) != 0 && some.count < some.planes.size())
                    some.add(active.planes[i]);
            const std::optional<Vec3d> candidate = point_on(some);
            if (!candidate || (next && length_squared(*candidate) >= length_squared(*next)))
                continue;
            const auto holds = [&](const HalfSpace* h) {
                return missed_by(*h, *candidate) <= slack;
            };
            if (std::all_of(active.planes.begin(), active.planes.begin() + active.count, holds) &&
                holds(worst)) {
                next = candidate;
                holding = some;
            }
        }
        if (!next) return std::nullopt;
        point = *next;
        active = holding;
    }
    return std::nullopt;
}

}  // namespace

std::optional<Vec3d> closest_to_origin(std::span<const HalfSpace> all) {
    double furthest = 0;
    for (const HalfSpace& h : all) furthest = std::max(furthest, h.least);
    // Planes that are nearly parallel have no point in common that is well defined. A point of one
    // of them then misses the others by a little more than its rounding, so each search that finds
    // nothing is followed by one that is half as exact.
    double slack = constants::translation_rounding * furthest;
    for (std::uint32_t k = 0; k < constants::translation_tries; ++k, slack *= 2)
        if (const std::optional<Vec3d> point = closest_within(slack, all)) return point;
    return std::nullopt;
}

}  // namespace pierce
