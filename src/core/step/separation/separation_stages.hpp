#pragma once

#include "core/body/body_view.hpp"
#include "core/device/atomics.hpp"
#include "core/device/view.hpp"
#include "core/mesh/mesh_view.hpp"
#include "core/step/common/records.hpp"
#include "core/step/edges/touch_stages.hpp"
#include "core/step/solids/directed_pair.hpp"
#include "core/trace/meeting.hpp"
#include "pierce/min_max.hpp"

/// After classify, with complete coverage: pairs that overlap but have no contact along an inward
/// ray, because each ray leaves its own body first, or because one body is wholly inside the other.
/// The direction in which the two separate soonest gives them their contacts.
namespace pierce::stages {

/// Per candidate: tells its pair that something is inside, whether it is a contact, and whether
/// that has any depth. Notes the contacts of chords that have none: another one may replace them.
struct MarkTouching {
    View<const RaySource> sources;
    View<const Meeting> meetings;
    View<const std::uint32_t> candidates, keep;
    View<std::uint32_t> reached, touching, has_depth;  ///< per pair
    View<std::uint32_t> flat;                          ///< per chord, its candidate

    static constexpr bool is_cheap = true;

    PIERCE_HD void operator()(std::uint32_t i) const {
        const std::uint32_t ray = candidates[i], pair = sources[ray].pair;
        atomic_mark(reached[pair]);
        const bool is_deep = meetings[ray].t > 0;
        if (!keep[i]) return;
        atomic_mark(touching[pair]);
        if (is_deep)
            atomic_mark(has_depth[pair]);
        else if (sources[ray].start == RayStart::chord)
            flat[sources[ray].item] = i;
    }
};

/// Per pair: one in which nothing has moved keeps its contacts, and nothing is to be looked for.
struct MarkStill {
    View<const DirectedPair> directed;
    View<std::uint32_t> reached, touching, has_depth;  ///< per pair

    static constexpr bool is_cheap = true;

    PIERCE_HD void operator()(std::uint32_t i) const {
        if (directed[2 * i].still) reached[i] = touching[i] = has_depth[i] = 1;
    }
};

/// Per directed pair without a candidate: how many parts of its source there are to look for inside
/// the target.
struct CountParts {
    View<const BodyView> bodies;
    View<const DirectedPair> directed;
    View<const std::uint32_t> reached;
    View<std::uint32_t> counts;

    static constexpr bool is_cheap = true;

    PIERCE_HD void operator()(std::uint32_t i) const {
        const bool asked = !reached[i / 2] && bodies[directed[i].target].is_solid() &&
                           !directed[i].is_self();
        counts[i] = asked ? bodies[directed[i].source].mesh.parts.size : 0;
    }
};

/// Per directed pair: a ray from one vertex of each of its source's parts, long enough to leave the
/// target. Vertices that are certainly outside get none.
struct GeneratePartRays {
    View<const BodyView> bodies;
    View<const DirectedPair> directed;
    View<const std::uint32_t> counts, offsets;
    View<Ray> rays;
    View<RaySource> sources;

    PIERCE_HD void operator()(std::uint32_t i) const {
        const DirectedPair& d = directed[i];
        const BodyView& source = bodies[d.source];
        const BodyView& target = bodies[d.target];
        for (std::uint32_t k = 0; k < counts[i]; ++k) {
            const std::uint32_t v = source.mesh.parts[k];
            const Vec3d start = to_double(source.positions[v]);
            const Vec3d in_fit = d.to_fit.to_parent(start);
            Ray ray;
            ray.origin = d.to_space.to_parent(start);
            ray.direction = {0, 0, 1};
            ray.target = d.target;
            ray.touch = d.touch;
            const double free = max_of(target.fit_box.distance(in_fit),
                                       target.mesh.clearance()(in_fit) - target.deviation);
            ray.t_max = free > 2 * target.touch ? -1.0 : target.fit_box.extent();
            rays[offsets[i] + k] = ray;
            sources[offsets[i] + k] = {i / 2, v, static_cast<std::uint8_t>(i % 2)};
        }
    }
};

/// Per source: tells its pair that something is inside.
struct MarkReached {
    View<const RaySource> sources;
    View<std::uint32_t> reached;  ///< per pair

    static constexpr bool is_cheap = true;

    PIERCE_HD void operator()(std::uint32_t i) const { atomic_mark(reached[sources[i].pair]); }
};

/// True for vertices that are candidates, but whose pair has no contact.
struct IsStrandedVertex {
    View<const Pair> pairs;
    View<const RaySource> sources;
    View<const std::uint32_t> candidates, touching;

    PIERCE_HD bool operator()(std::uint32_t i) const {
        const RaySource& from = sources[candidates[i]];
        return from.start == RayStart::vertex && !touching[from.pair] &&
               !pairs[from.pair].is_self();
    }
};

/// True for chords whose pair has no contact with a depth. A chord is inside, whether or not its
/// ray reached the target's surface; but a chord along the surface may be inside by rounding alone.
struct IsStrandedChord {
    View<const RaySource> sources;
    View<const std::uint32_t> has_depth;

    PIERCE_HD bool operator()(std::uint32_t i) const { return !has_depth[sources[i].pair]; }
};

/// Per stranded chord: the rays that show whether it is inside by more than rounding.
struct GenerateStrandedChordRays {
    View<const BodyView> bodies;
    View<const DirectedPair> directed;
    View<const Chord> chords;
    View<const std::uint32_t> stranded;
    View<const RaySource> sources;  ///< of chords
    View<Ray> rays;                 ///< two per chord

    PIERCE_HD void operator()(std::uint32_t i) const {
        const RaySource& from = sources[stranded[i]];
        const std::uint32_t direction = 2 * from.pair + from.side;
        const DirectedPair& d = directed[direction];
        const double least = constants::least_inside * touch_of_pair(directed, direction);
        const Chord& chord = chords[from.item];
        write_inside_rays(bodies, d, chord, max_of(chord.skin, least), rays[2 * i],
                          rays[2 * i + 1]);
    }
};

/// True for pairs that overlap without a contact.
struct IsDeep {
    View<const std::uint32_t> deep;

    PIERCE_HD bool operator()(std::uint32_t i) const { return deep[i] != 0; }
};

/// Per deep pair: of the axes of both bodies' boxes, the direction along which the first body
/// leaves the second one soonest. The way along a direction is from the lowest point of the first
/// body to the highest point of the second.
struct FindSeparation {
    View<const BodyView> bodies;
    View<const Pair> pairs;
    View<const std::uint32_t> deep_pairs;
    View<Vec3d> directions;  ///< per pair, world space

    PIERCE_HD void operator()(std::uint32_t i) const {
        const Pair pair = pairs[deep_pairs[i]];
        const BodyView& a = bodies[pair.a];
        const BodyView& b = bodies[pair.b];
        double least = INFINITY;
        for (int k = 0; k < 12; ++k) {
            const Matrix3 axes = (k < 6 ? a : b).fit.rotation.transposed();
            const Vec3d u = (k % 2 == 0 ? 1.0 : -1.0) * axes.row[k % 6 / 2];
            const double way = highest(b, u) + highest(a, -u);
            if (!(way < least)) continue;
            least = way;
            directions[deep_pairs[i]] = u;
        }
    }

private:
    PIERCE_HD static double highest(const BodyView& body, Vec3d u) {
        const Vec3d in_space = body.space.rotation.transposed() * u;
        double most = -INFINITY;
        for (std::uint32_t v = 0; v < body.mesh.positions.size; ++v)
            most = max_of(dot(in_space, to_double(body.positions[v])), most);
        return most + dot(u, body.space.origin);
    }
};

/// Rays that lead out of a deep pair's target along the pair's direction of separation.
struct SeparationRays {
    View<const BodyView> bodies;
    View<const Chord> chords;
    View<const DirectedPair> directed;
    View<const Vec3d> directions;
    std::uint32_t begin = 0;  ///< rays there are already
    View<Ray> rays;
    View<RaySource> sources;
    View<Hit> hits;
    View<Route> routes;  ///< empty if steps do not remember

    PIERCE_HD Vec3d direction(const RaySource& from) const {
        return (from.side == 0 ? 1.0 : -1.0) * directions[from.pair];
    }

    PIERCE_HD void write(std::uint32_t i, const RaySource& from) const {
        write(i, from, direction(from));
    }

    PIERCE_HD void write(std::uint32_t i, RaySource from, Vec3d direction) const {
        const DirectedPair& d = directed[2 * from.pair + from.side];
        const BodyView& target = bodies[d.target];
        Ray ray;
        ray.origin = d.to_space.to_parent(start_of(bodies[d.source], from, chords));
        ray.direction = normalized(target.space.rotation.transposed() * direction);
        ray.t_max = target.fit_box.extent();
        if (from.start == RayStart::chord) ray.t_min = chords[from.item].skin;
        ray.target = d.target;
        ray.touch = d.touch;
        from.separates = true;
        rays[begin + i] = ray;
        sources[begin + i] = from;
        hits[begin + i] = {};
        if (routes.size > 0) routes[begin + i] = Route::full;
    }

    PIERCE_HD void write_none(std::uint32_t i, RaySource from) const {
        write(i, from);
        rays[begin + i].t_max = -1.0;
    }
};

/// Per source of a stranded vertex or chord: its ray.
struct GenerateStrandedRays {
    SeparationRays out;
    View<const RaySource> from;

    PIERCE_HD void operator()(std::uint32_t i) const { out.write(i, from[i]); }
};

/// Per chord of an edge that only touches: a ray between the edge's triangles. Both bodies have an
/// inside there, but their way apart may lead out of the target at once.
struct GenerateTouchingRays {
    SeparationRays out;
    View<const RaySource> from;

    PIERCE_HD void operator()(std::uint32_t i) const {
        const BodyView& source = out.bodies[out.directed[2 * from[i].pair + from[i].side].source];
        const Edge& edge = source.mesh.edges[out.chords[from[i].item].edge];
        out.write(i, from[i], source.space.rotation * inward_direction(source, edge));
    }
};

/// Per part found inside: a ray from its vertex and, once per body, rays from the vertices that are
/// furthest behind along the way out.
struct GenerateContainedRays {
    static constexpr std::uint32_t per_part = 1 + constants::separation_vertices;

    SeparationRays out;
    View<const RaySource> from;
    std::uint32_t stranded = 0;  ///< how many rays start from stranded vertices and chords; these
                                 ///< come first

    PIERCE_HD void operator()(std::uint32_t i) const {
        const RaySource part = from[i];
        const BodyView& source = out.bodies[out.directed[2 * part.pair + part.side].source];
        const Vec3d u = source.space.rotation.transposed() * out.direction(part);
        std::uint32_t vertex[per_part];
        double height[per_part];
        std::uint32_t count = 0;
        const bool again = i > 0 && from[i - 1].pair == part.pair && from[i - 1].side == part.side;
        for (std::uint32_t v = 0; v < source.mesh.positions.size && !again; ++v) {
            if (is_part(source.mesh, v)) continue;
            const double h = dot(u, to_double(source.positions[v]));
            if (count == constants::separation_vertices && !(h < height[count - 1])) continue;
            count = min_of(count + 1, constants::separation_vertices);
            std::uint32_t k = count - 1;
            for (; k > 0 && h < height[k - 1]; --k) {
                height[k] = height[k - 1];
                vertex[k] = vertex[k - 1];
            }
            height[k] = h;
            vertex[k] = v;
        }
        const std::uint32_t first = stranded + i * per_part;
        for (std::uint32_t k = 0; k < per_part; ++k) {
            RaySource one = part;
            if (k < count) one.item = vertex[k];
            if (k == constants::separation_vertices || k < count)
                out.write(first + k, one);
            else
                out.write_none(first + k, one);
        }
    }

private:
    /// True for vertices that get a ray for the part they stand for.
    PIERCE_HD static bool is_part(const MeshView& mesh, std::uint32_t v) {
        for (std::uint32_t part : mesh.parts)
            if (part >= v) return part == v;
        return false;
    }
};

/// Per new ray that starts inside: makes it a contact without a test of its own body, and tells its
/// pair if the contact has any depth. It may have none, because the way apart may lead out of the
/// target at once; of a chord, that is no contact. A chord's contact along the way apart replaces
/// one without a depth.
struct KeepSeparated {
    View<const std::uint32_t> inside;
    View<const RaySource> sources;
    View<const Meeting> meetings;
    std::uint32_t first_ray = 0, first_candidate = 0;
    View<std::uint32_t> candidates, keep;
    View<std::uint32_t> touching;    ///< per pair
    View<const std::uint32_t> flat;  ///< per chord of the step's first ones, its candidate

    static constexpr bool is_cheap = true;

    PIERCE_HD void operator()(std::uint32_t i) const {
        const std::uint32_t ray = first_ray + inside[i];
        const RaySource& from = sources[ray];
        const bool is_deep = meetings[ray].t > 0, is_chord = from.start == RayStart::chord;
        candidates[first_candidate + i] = ray;
        keep[first_candidate + i] = is_deep || !is_chord;
        if (!is_deep) return;
        atomic_mark(touching[from.pair]);
        if (is_chord && from.item < flat.size && flat[from.item] != no_record)
            keep[flat[from.item]] = 0;
    }
};

}  // namespace pierce::stages
