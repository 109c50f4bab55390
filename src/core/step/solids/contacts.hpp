#pragma once

#include "core/body/body_view.hpp"
#include "core/device/number.hpp"
#include "core/device/order_ties.hpp"
#include "core/device/view.hpp"
#include "core/device/warp.hpp"
#include "core/device/whole.hpp"
#include "core/mesh/mesh_view.hpp"
#include "core/mesh/surface.hpp"
#include "core/step/common/contact_keys.hpp"
#include "core/step/common/count.hpp"
#include "core/step/common/pair_marks.hpp"
#include "core/step/common/pairs.hpp"
#include "core/step/common/records.hpp"
#include "core/step/solids/classify.hpp"
#include "core/step/solids/directed_pair.hpp"
#include "core/step/solids/ray_batch.hpp"
#include "core/trace/meeting.hpp"
#include "pierce/contact.hpp"

/// contacts: writes the contact list in (pair, side, vertex or edge) order and carries
/// ages over.
namespace pierce::stages {

/// The key that orders contacts; chords of one edge share it.
PIERCE_HD inline std::uint64_t contact_key(const RaySource& from, std::uint32_t pair,
                                           View<const Chord> chords) {
    if (from.start == RayStart::vertex) return ContactKey::of_vertex(pair, from.side, from.item);
    return ContactKey::of_edge(pair, from.side, chords[from.item].edge);
}

/// Marks a contact that is taken over from the last step: the rest is its place in the last list.
inline constexpr std::uint32_t taken_over = std::uint32_t{1} << 31;

/// Per contact: it is one step older.
struct GrowOlder {
    View<Contact> contacts;
    View<std::uint32_t> ages;
    std::uint32_t steps = 1;

    static constexpr bool is_cheap = true;

    PIERCE_HD void operator()(std::uint32_t i) const { ages[i] = contacts[i].age += steps; }
};

/// Per candidate: if it is kept, its key and its index. Items after the candidates are pairs: one
/// in which nothing has moved lists its contacts of the last step.
struct KeyContacts {
    View<const Chord> chords;
    View<const RaySource> sources;
    View<const std::uint32_t> candidates, keep;
    View<const DirectedPair> directed;
    View<const std::uint32_t> links;
    View<const std::uint64_t> last_keys;

    PIERCE_HD std::uint32_t find(std::uint32_t i) const {
        if (i < candidates.size) return keep[i];
        const std::uint32_t pair = i - candidates.size;
        return directed[2 * pair].still ? first_of(links[pair] + 1) - first_of(links[pair]) : 0;
    }
    PIERCE_HD static std::uint32_t count(std::uint32_t kept) { return kept; }
    PIERCE_HD void write(std::uint32_t i, std::uint32_t kept, std::uint32_t place,
                         std::uint64_t* keys, std::uint32_t* order) const {
        if (!kept) return;
        if (i < candidates.size) {
            const RaySource s = sources[candidates[i]];
            keys[place] = contact_key(s, s.pair, chords);
            order[place] = i;
            return;
        }
        const std::uint32_t pair = i - candidates.size, first = first_of(links[pair]);
        for (std::uint32_t k = 0; k < kept; ++k) {
            keys[place + k] = ContactKey::in_pair(pair, last_keys[first + k]);
            order[place + k] = taken_over | (first + k);
        }
    }

private:
    PIERCE_HD std::uint32_t first_of(std::uint32_t last_pair) const {
        return first_not_less(last_keys, ContactKey::first_of(last_pair));
    }
};

/// Per contact: if it is the first chord of an edge, puts the chords of that edge in order. The
/// lists that they come from have no order.
struct OrderChords {
    View<const Chord> chords;
    View<const RaySource> sources;
    View<const std::uint32_t> candidates;
    View<const std::uint64_t> keys;
    View<std::uint32_t> order;

    PIERCE_HD void operator()(std::uint32_t i) const {
        // Only the first of a key reads their order, which it writes.
        if (i > 0 && keys[i - 1] == keys[i]) return;
        if (order[i] & taken_over) return;  // all of its key are, in their order
        order_ties(keys, order, i,
                   [&](std::uint32_t a, std::uint32_t b) { return chord(a) < chord(b); });
    }

private:
    /// Edges near the target come after chords inside of it, and chords of bodies that were moved a
    /// little come last.
    PIERCE_HD std::uint64_t chord(std::uint32_t candidate) const {
        const RaySource& from = sources[candidates[candidate]];
        if (from.start == RayStart::vertex) return 0;
        const std::uint32_t item = from.item;
        const Chord& c = chords[item];
        return std::uint64_t{c.skin > 0} << 63 | std::uint64_t{from.is_near} << 62 |
               std::uint64_t{c.ordinal} << 32 | item;
    }
};

/// Per contact in the order of their keys: lists it, but for two kinds: a near vertex that is also
/// in contact by a ray, and ridges that have passed each other if a chord of one of them over the
/// other is in contact. Rounding may see a vertex on both sides of a surface that it
/// touches.
struct DropDuplicates {
    View<const RaySource> sources;
    View<const std::uint32_t> candidates;
    View<const BodyView> bodies;
    View<const Pair> pairs;
    View<const Chord> chords;
    View<const Meeting> meetings;  ///< per ray
    View<const std::uint32_t> order;
    View<const std::uint64_t> keys;

    static constexpr bool in_order = true;

    PIERCE_HD bool find(std::uint32_t i) const {
        if (order[i] & taken_over) return true;
        const std::uint32_t ray = candidates[order[i]];
        const RaySource& from = sources[ray];
        if (!from.is_near) return true;
        if (from.start == RayStart::chord)
            return !(meetings[ray].t > 0) || !has_chord_over_ridge(from);
        return !(i > 0 && keys[i - 1] == keys[i]) && !(i + 1 < keys.size && keys[i + 1] == keys[i]);
    }
    PIERCE_HD static std::uint32_t count(bool stays) { return stays; }
    PIERCE_HD void write(std::uint32_t i, bool stays, std::uint32_t place, std::uint64_t* keys_left,
                         std::uint32_t* order_left) const {
        if (!stays) return;
        keys_left[place] = keys[i];
        order_left[place] = order[i];
    }
    /// Past the last contact, the largest key, as a sort has it.
    PIERCE_HD static void pad(std::uint32_t place, std::uint64_t* keys_left, std::uint32_t*) {
        keys_left[place] = ~std::uint64_t{0};
    }

private:
    PIERCE_HD bool has_chord_over_ridge(const RaySource& near) const {
        const Chord& c = chords[near.item];
        return is_chord_over(near.pair, near.side, c.edge, c.ordinal) ||
               is_chord_over(near.pair, 1u - near.side, c.ordinal, c.edge);
    }
    /// True if a chord of an edge of one body is in contact and lies over a ridge of the other one.
    PIERCE_HD bool is_chord_over(std::uint32_t pair, std::uint32_t side, std::uint32_t edge,
                                 std::uint32_t ridge) const {
        const MeshView& target = bodies[pairs[pair].target(side)].mesh;
        const std::uint64_t key = ContactKey::of_edge(pair, side, edge);
        for (std::uint32_t k = first_not_less(keys, key); k < keys.size && keys[k] == key; ++k) {
            const RaySource& from = sources[candidates[order[k]]];
            const Ridge over = chords[from.item].ridge;
            if (!from.is_near && over.exists() &&
                target.features[over.triangle].edge[over.corner == 2 ? 0 : over.corner + 1] ==
                    ridge)
                return true;
        }
        return false;
    }
};

/// Per contact: everything in it, and what it adds to the sums. Reads rays, hits and last step's
/// contacts and ages; writes the contact, its age and where its vertex finds it.
struct FillContact {
    View<const BodyView> bodies;
    View<const BodyId> ids;
    View<const Pair> pairs;
    View<const Chord> chords;
    View<const RaySource> sources;
    RayResults found_rays;
    RayResults aimed;  ///< per candidate, re-projected; empty if that is not asked for
    View<const std::uint32_t> accepted;  ///< per candidate: the re-projected one counts
    Number decided;                      ///< of how many candidates; separation adds others
    PairMarks marks;                     ///< if contacts are re-projected
    View<const std::uint32_t> candidates, order;
    View<const std::uint64_t> keys;
    View<const Route> routes;  ///< empty if steps do not remember
    View<const Found> found;   ///< per ray, where it was walked
    View<const std::uint32_t> links;
    View<const std::uint64_t> last_keys;
    View<const std::uint32_t> last_ages;
    View<const Contact> last_contacts;  ///< where some are kept
    View<VertexRecord> records;         ///< empty if steps do not remember
    bool looks = false;                 ///< steps look from last step's triangles
    View<std::uint32_t> ages;
    View<Contact> contacts;

    PIERCE_HD ContactSums operator()(std::uint32_t i) const {
        const bool first = i == 0 ||
                           ContactKey::pair_of(keys[i - 1]) != ContactKey::pair_of(keys[i]);
        if (order[i] & taken_over) {
            Contact kept = last_contacts[order[i] & ~taken_over];
            ages[i] = ++kept.age;
            write_whole(contacts[i], kept);
            return sums_of(kept, first);
        }
        ContactSums sums;
        write_side_by_side(contacts.data, i, [&](Contact& c) {
            fill(i, c);
            sums = sums_of(c, first);
        });
        return sums;
    }

private:
    PIERCE_HD void fill(std::uint32_t i, Contact& c) const {
        const std::uint32_t r = candidates[order[i]];
        const bool moved = order[i] < decided && accepted[order[i]] &&
                           !stays_on_ray(order[i], sources[r]);
        const RayResults& results = moved ? aimed : found_rays;
        const std::uint32_t place = moved ? order[i] : r;
        const Ray& ray = results.rays[place];
        const RaySource& from = sources[r];
        const Pair pair = pairs[from.pair];
        const BodyView& source = bodies[pair.source(from.side)];
        const BodyView& target = bodies[ray.target];
        const Surface surface = target.surface();
        const Meeting& m = results.meetings[place];
        const std::uint32_t triangle = results.hits[place].triangle;
        const Triangle& t = surface.triangles[triangle];
        const Vec3d corner[3] = {to_double(surface.positions[t.vertex[0]]),
                                 to_double(surface.positions[t.vertex[1]]),
                                 to_double(surface.positions[t.vertex[2]])};
        Vec3d q;
        for (int k = 0; k < 3; ++k) q += m.barycentric[k] * corner[k];
        const Vec3d face = normalized(cross(corner[1] - corner[0], corner[2] - corner[0]));
        const Vec3d p_world = source.space.to_parent(start_of(source, from, chords));
        const Vec3d q_world = target.space.to_parent(q);
        const Vec3d direction = target.space.rotation * ray.direction;

        c = {};
        c.a = ids[pair.a];
        c.b = ids[pair.b];
        c.source = static_cast<Side>(from.side);
        c.grazing = !from.is_near && std::fabs(dot(face, ray.direction)) < constants::grazing_sine;
        const bool looked = routes.size > 0 && routes[r] == Route::looked;
        if (routes.size > 0 && routes[r] == Route::walked) c.found = found[r];
        if (looked) c.found = Found::walk;
        if (pair.is_self()) c.found = Found::self;
        if (from.separates) c.found = Found::separation;
        if (from.is_near) c.found = Found::near;
        c.reprojected = moved || looked || from.is_near;
        c.vertex = from.item;
        if (from.start == RayStart::chord) {
            const Chord& chord = chords[from.item];
            const Edge& edge = source.mesh.edges[chord.edge];
            c.edge = chord.edge;
            (from.is_near ? c.other_edge : c.chord) = chord.ordinal;
            c.along = chord.along;
            c.vertex = edge.vertex[0];
            c.edge_end = edge.vertex[1];
        }
        c.triangle = triangle;
        for (int k = 0; k < 3; ++k) c.barycentric[k] = m.barycentric[k];
        c.point_a = from.side == 0 ? p_world : q_world;
        c.point_b = from.side == 0 ? q_world : p_world;
        c.normal = from.side == 0 ? -direction : direction;
        c.face_normal = target.space.rotation * face;
        c.distance = -m.t;
        if (target.collision.sheet) of_velocity_ray(c, from, p_world, q_world, direction, m.t);
        c.age = ages[i] = age(from, r);
        if (r < records.size) records[r].contact = i;
        // After a walk, the next step looks from the closest triangle; the record of a full ray is
        // written anew by Remember.
        if (r < records.size && moved && looks) records[r].triangle = triangle;
    }

    /// True for re-projected contacts without a depth in a pair that has no other contact with
    /// one, if separation has shown that the bodies overlap deeply, and their rays run there.
    PIERCE_HD bool stays_on_ray(std::uint32_t candidate, const RaySource& from) const {
        if (aimed.meetings[candidate].t > 0 || marks.any(from.pair, PairMarks::has_depth) ||
            !marks.any(from.pair, PairMarks::separates))
            return false;
        const Ray& ray = found_rays.rays[candidates[candidate]];
        const double t = found_rays.meetings[candidates[candidate]].t;
        return from.start == RayStart::vertex
                   ? runs_through_both(bodies[pairs[from.pair].source(from.side)], from.item, t,
                                       ray.touch)
                   : t > constants::skin * ray.touch;
    }

    /// A sheet's vertex belongs where it has come from: the ray ahead hits what it would meet, the
    /// ray behind what it has passed.
    PIERCE_HD static void of_velocity_ray(Contact& c, const RaySource& from, Vec3d p, Vec3d q,
                                          Vec3d direction, double t) {
        const bool passed = from.side == 1;
        c.source = Side::a;
        c.of_sheet = true;
        c.found = passed ? Found::crossing : Found::near;
        c.point_a = p;
        c.point_b = q;
        c.normal = passed ? -direction : direction;
        c.distance = passed ? -t : t;
    }

    PIERCE_HD std::uint32_t age(const RaySource& from, std::uint32_t ray) const {
        if (links[from.pair] == no_pair) return 0;
        const std::uint64_t key = contact_key(from, links[from.pair], chords);
        if (ray < records.size && is_contact(last_keys, records[ray].contact, key))
            return last_ages[records[ray].contact] + 1;
        const std::uint32_t low = first_not_less(last_keys, key);
        return low < last_keys.size && last_keys[low] == key ? last_ages[low] + 1 : 0;
    }
};

}  // namespace pierce::stages
