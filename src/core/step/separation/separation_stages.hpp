#pragma once

#include "core/body/body_view.hpp"
#include "core/body/part_along_boxes.hpp"
#include "core/device/number.hpp"
#include "core/device/view.hpp"
#include "core/mesh/mesh_view.hpp"
#include "core/mesh/vertex_normal.hpp"
#include "core/step/common/pair_marks.hpp"
#include "core/step/common/records.hpp"
#include "core/step/edges/touch_stages.hpp"
#include "core/step/separation/ask_parts.hpp"
#include "core/step/separation/ray_chains.hpp"
#include "core/step/solids/directed_pair.hpp"
#include "core/step/solids/join_batch.hpp"
#include "core/trace/meeting.hpp"
#include "pierce/min_max.hpp"

/// After classify, unless coverage is `vertices`: pairs that overlap but have no contact along an
/// inward ray, because each ray leaves its own body first, or because one body is wholly inside the
/// other. The direction in which the two separate soonest gives them their contacts.
namespace pierce::stages {

/// True for pairs that the rest of separation may have something to do for: nothing of one is known
/// to be inside the other, or what is inside gives no contact, or no depth.
struct NeedsMore {
    View<const BodyView> bodies;
    View<const DirectedPair> directed;
    PairMarks marks;
    bool inside_is_contact = false;

    PIERCE_HD bool operator()(std::uint32_t pair) const {
        if (directed[2 * pair].is_self()) return false;
        if (marks.any(pair, PairMarks::contained) ||
            (!marks.any(pair, PairMarks::has_depth) &&
             marks.any(pair, PairMarks::edge_crosses | PairMarks::runs_inside)))
            return true;
        const bool in_contact = marks.any(pair, PairMarks::in_contact);
        if (!in_contact && marks.any(pair, PairMarks::edge_touches | PairMarks::vertex_inside |
                                               PairMarks::holds_chord))
            return true;
        const AskParts parts{.bodies = bodies,
                             .directed = directed,
                             .marks = marks,
                             .inside_is_contact = inside_is_contact};
        return parts.find(2 * pair) + parts.find(2 * pair + 1) > 0;
    }
};

/// Turns a ray that runs inside its target into the question whether what it runs through is deep:
/// what is near the middle of its way. Where bodies only touch, a ray along their surfaces runs
/// far, but never deeper in the target than by rounding.
PIERCE_HD inline Ray middle_of(Ray ray, double way) {
    ray.origin = ray.origin + (0.5 * way) * ray.direction;
    ray.t_max = ray.touch;
    return ray;
}

/// Per ray of a part: asks how deep the middle of its way is, if the ray leaves the target.
struct GenerateMiddlesOfParts {
    LeavesTarget leaves;
    View<Ray> middles;

    PIERCE_HD void operator()(std::uint32_t i) const {
        Ray middle = leaves.rays[i];
        if (leaves(i))
            middle = middle_of(middle, leaves.way(i));
        else
            middle.t_max = -1.0;
        middles[i] = middle;
    }
};

/// Per ray of a part: lists the parts that are inside, by their first vertices, and marks their
/// pairs.
struct FindContained {
    LeavesTarget leaves;
    View<const RaySource> sources;
    View<const std::uint32_t> closest;  ///< to the middle of each way, if it touches
    PairMarks marks;

    static constexpr bool in_order = true;

    PIERCE_HD bool find(std::uint32_t i) const {
        if (i % MeshPart::count != 0) return false;
        for (std::uint32_t k = i; k < i + MeshPart::count; ++k)
            if (leaves(k) && closest[k] == no_triangle) {
                marks.set(sources[i].pair, PairMarks::separates);
                return true;
            }
        return false;
    }
    PIERCE_HD static std::uint32_t count(bool found) { return found; }
    PIERCE_HD void write(std::uint32_t i, bool found, std::uint32_t place,
                         RaySource* inside) const {
        if (found) inside[place] = sources[i];
    }
};

/// Per candidate: lists vertices of bodies that are inside as a whole, vertices that are inside
/// although their pair has no contact, and, of pairs without a depth, vertices that touch and whose
/// rays run inside. Of these, it also asks how deep the middle is; of the others, nothing.
struct FindStrandedVertices {
    View<const Pair> pairs;
    View<const Ray> rays;
    View<const RaySource> sources;
    View<const Meeting> meetings;
    View<const std::uint32_t> candidates, keep;
    PairMarks marks;

    enum Stranded : std::uint8_t { none, inside, runs_inside };

    PIERCE_HD Stranded find(std::uint32_t i) const {
        const std::uint32_t ray = candidates[i];
        const RaySource& from = sources[ray];
        if (from.start != RayStart::vertex || pairs[from.pair].is_self()) return none;
        if (!marks.any(from.pair, PairMarks::in_contact) ||
            (!keep[i] && marks.any(from.pair, PairMarks::contained)))
            return inside;
        const bool runs = marks.any(from.pair, PairMarks::runs_inside) &&
                          !marks.any(from.pair, PairMarks::has_depth) &&
                          meetings[ray].t > constants::skin * rays[ray].touch;
        return runs ? runs_inside : none;
    }
    PIERCE_HD static std::uint32_t count(Stranded found) { return found != none; }
    PIERCE_HD void write(std::uint32_t i, Stranded found, std::uint32_t place, Ray* middles,
                         RaySource* stranded) const {
        if (found == none) return;
        const std::uint32_t ray = candidates[i];
        middles[place] = middle_of(rays[ray], meetings[ray].t);
        if (found == inside) middles[place].t_max = -1.0;
        stranded[place] = sources[ray];
    }
};

/// Per stranded vertex: lists those that are deep, and marks their pairs.
struct FindDeepVertices {
    View<const RaySource> sources;
    View<const std::uint32_t> closest;  ///< to the middle, if it touches
    PairMarks marks;

    PIERCE_HD bool find(std::uint32_t i) const {
        if (closest[i] != no_triangle) return false;
        marks.set(sources[i].pair, PairMarks::separates);
        return true;
    }
    PIERCE_HD static std::uint32_t count(bool found) { return found; }
    PIERCE_HD void write(std::uint32_t i, bool found, std::uint32_t place, RaySource* deep) const {
        if (found) deep[place] = sources[i];
    }
};

/// Per chord: if its pair has no contact with a depth, lists the two rays that show whether it is
/// inside by more than rounding. A chord is inside, whether or not its ray reached the target's
/// surface; but a chord along the surface may be inside by rounding alone.
struct FindStrandedChords {
    View<const BodyView> bodies;
    View<const DirectedPair> directed;
    View<const Chord> chords;
    View<const RaySource> sources;  ///< of chords
    PairMarks marks;

    PIERCE_HD bool find(std::uint32_t i) const {
        return !marks.any(sources[i].pair, PairMarks::has_depth);
    }
    PIERCE_HD static std::uint32_t count(bool found) { return found ? 2 : 0; }
    PIERCE_HD void write(std::uint32_t i, bool found, std::uint32_t place, Ray* rays,
                         RaySource* rays_from) const {
        if (!found) return;
        const RaySource& from = sources[i];
        const std::uint32_t direction = 2 * from.pair + from.side;
        const DirectedPair& d = directed[direction];
        const double least = constants::least_inside * touch_of_pair(directed, direction);
        write_inside_rays(bodies, d, chords[i], max_of(chords[i].skin, least), rays[place],
                          rays[place + 1]);
        rays_from[place] = rays_from[place + 1] = from;
    }
};

/// Per ray of such a chord: of a chord whose two rays leave their bodies, asks once how deep the
/// middle of what both run through is.
struct GenerateMiddlesOfChords {
    LeavesBoth leaves;
    View<Ray> middles;

    PIERCE_HD void operator()(std::uint32_t i) const {
        Ray middle = leaves.rays[i];
        if (i % 2 == 0 && leaves(i / 2) && leaves.has_way(i / 2))
            middle = middle_of(middle, leaves.way(i / 2));
        else
            middle.t_max = -1.0;
        middles[i] = middle;
    }
};

/// Per ray of such a chord: lists the chords both of whose rays leave their bodies and run deep,
/// and marks their pairs.
struct FindDeepChords {
    LeavesBoth leaves;
    View<const RaySource> sources;
    View<const std::uint32_t> closest;  ///< to the middle, if it touches
    PairMarks marks;

    PIERCE_HD bool find(std::uint32_t i) const {
        if (i % 2 == 1 || !leaves(i / 2) || closest[i] != no_triangle) return false;
        marks.set(sources[i].pair, PairMarks::separates);
        return true;
    }
    PIERCE_HD static std::uint32_t count(bool found) { return found; }
    PIERCE_HD void write(std::uint32_t i, bool found, std::uint32_t place, RaySource* deep) const {
        if (found) deep[place] = sources[i];
    }
};

/// True for pairs that overlap without a contact.
struct Separates {
    PairMarks marks;

    PIERCE_HD bool operator()(std::uint32_t pair) const {
        return marks.any(pair, PairMarks::separates);
    }
};

/// Per deep pair: the direction along which the first body leaves the second one soonest.
struct FindSeparation {
    View<const BodyView> bodies;
    View<const Pair> pairs;
    View<const std::uint32_t> deep_pairs;
    View<Vec3d> directions;  ///< per pair, world space

    PIERCE_HD void operator()(std::uint32_t i) const {
        const Pair pair = pairs[deep_pairs[i]];
        directions[deep_pairs[i]] = part_along_boxes(bodies[pair.a], bodies[pair.b]).direction;
    }
};

/// Rays that lead out of a deep pair's target along the pair's direction of separation.
struct SeparationRays {
    View<const BodyView> bodies;
    View<const Chord> chords;
    View<const DirectedPair> directed;
    View<const Vec3d> directions;
    Number begin;  ///< rays there are already
    View<Ray> rays;
    View<RaySource> sources;

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
    Number first;  ///< of the sources of all chords

    PIERCE_HD void operator()(std::uint32_t i) const {
        const RaySource& chord = from[first + i];
        const BodyView& source = out.bodies[out.directed[2 * chord.pair + chord.side].source];
        const Edge& edge = source.mesh.edges[out.chords[chord.item].edge];
        out.write(i, chord, source.space.rotation * inward_direction(source, edge));
    }
};

/// Per part found inside: a ray from its vertex and, once per body, rays from the vertices that are
/// furthest behind along the way out; none from a stranded vertex, which has one already.
struct GenerateContainedRays {
    static constexpr std::uint32_t per_part = 1 + constants::separation_vertices;

    SeparationRays out;
    View<const RaySource> from;
    View<const RaySource> stranded;  ///< vertices
    RayChains chains;                ///< of these

    PIERCE_HD void operator()(std::uint32_t i) const {
        const RaySource part = from[i];
        const BodyView& source = out.bodies[out.directed[2 * part.pair + part.side].source];
        const Vec3d u = source.space.rotation.transposed() * out.direction(part);
        std::uint32_t vertex[per_part];
        double height[per_part];
        std::uint32_t count = 0;
        const bool again = i > 0 && from[i - 1].pair == part.pair && from[i - 1].side == part.side;
        // Parts are sorted by their first vertex, which gets a ray for the part.
        const View<const MeshPart> parts = source.mesh.parts;
        std::uint32_t next_part = 0;
        for (std::uint32_t v = 0; v < source.mesh.positions.size && !again; ++v) {
            while (next_part < parts.size && parts[next_part].vertex[0] < v) ++next_part;
            const bool is_part = next_part < parts.size && parts[next_part].vertex[0] == v;
            if (is_part || !has_triangles(source.mesh, v)) continue;
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
        const std::uint32_t first = i * per_part;
        for (std::uint32_t k = 0; k < per_part; ++k) {
            RaySource one = part;
            if (k < count) one.item = vertex[k];
            const bool is_used = k == constants::separation_vertices || k < count;
            if (is_used && !is_stranded(one))
                out.write(first + k, one);
            else
                out.write_none(first + k, one);
        }
    }

private:
    PIERCE_HD bool is_stranded(const RaySource& vertex) const {
        return chains.find(vertex.pair, [&](std::uint32_t k) {
            return stranded[k].side == vertex.side && stranded[k].item == vertex.item;
        }) != no_record;
    }
};

/// Per new ray that starts inside: makes it a contact without a test of its own body, and tells its
/// pair if the contact has any depth. It may have none, because the way apart may lead out of the
/// target at once; of a chord, that is no contact. A contact along the way apart replaces one of
/// the same chord or vertex without a depth.
struct JoinSeparated {
    View<const std::uint32_t> inside;
    JoinBatch batch;
    PairMarks marks;
    View<const std::uint32_t> flat;  ///< per chord, its candidate without a depth
    RayChains touching;              ///< candidates that are vertices, where one only touches

    static constexpr bool is_cheap = true;

    PIERCE_HD void operator()(std::uint32_t i) const {
        const std::uint32_t ray = inside[i];
        const RaySource& from = batch.from_sources[ray];
        const bool is_deep = batch.from_meetings[ray].t > 0,
                   is_chord = from.start == RayStart::chord;
        const std::uint32_t before = is_chord ? no_record : touching_candidate(from);
        batch.join(i, ray, is_deep || (!is_chord && before == no_record));
        if (!is_deep) return;
        if (before != no_record) batch.keep[before] = 0;
        marks.set(from.pair, PairMarks::in_contact | PairMarks::has_depth);
        if (is_chord && flat[from.item] != no_record) batch.keep[flat[from.item]] = 0;
    }

private:
    /// The contact of the same vertex that was found along its inward ray, or no_record.
    PIERCE_HD std::uint32_t touching_candidate(const RaySource& from) const {
        if (!marks.any(from.pair, PairMarks::vertex_touches)) return no_record;
        return touching.find(from.pair, [&](std::uint32_t k) {
            const RaySource& other = batch.sources[batch.candidates[k]];
            // Only the item of this vertex may read or write that it is kept.
            return other.side == from.side && other.item == from.item && batch.keep[k];
        });
    }
};

}  // namespace pierce::stages
