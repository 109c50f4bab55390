#pragma once

#include "pierce/core/contact.hpp"
#include "pierce/core/stages/classify.hpp"

/// Stage 10, contacts: writes the contact list in (pair, side, vertex) order and carries ages over.
namespace pierce::stages {

/// Per candidate: the key that orders kept ones. Reads flags and offsets; writes keys and candidate indices.
struct KeyContacts {
    View<const RaySource> sources;
    View<const std::uint32_t> candidates, keep, offsets;
    View<std::uint64_t> keys;
    View<std::uint32_t> order;

    PIERCE_HD void operator()(std::uint32_t i) const {
        if (!keep[i]) return;
        const RaySource s = sources[candidates[i]];
        keys[offsets[i]] = std::uint64_t{s.pair} << 32 | std::uint64_t{s.side} << 31 | s.vertex;
        order[offsets[i]] = i;
    }
};

/// True if `c` comes before the contact of vertex `vertex` of side `side` of bodies `a`, `b`.
PIERCE_HD inline bool comes_before(const Contact& c, std::uint32_t a, std::uint32_t b, std::uint32_t side,
                                   std::uint32_t vertex) {
    if (c.a.index != a) return c.a.index < a;
    if (c.b.index != b) return c.b.index < b;
    if (static_cast<std::uint32_t>(c.source) != side) return static_cast<std::uint32_t>(c.source) < side;
    return c.vertex < vertex;
}

/// Per contact: everything in it. Reads rays, hits and last step's contacts; writes the contact.
struct FillContact {
    View<const BodyView> bodies;
    View<const BodyId> ids;
    View<const Pair> pairs;
    View<const Ray> rays;
    View<const RaySource> sources;
    View<const Hit> hits;
    View<const std::uint32_t> candidates, order;
    View<const Contact> last_contacts;
    View<Contact> contacts;

    PIERCE_HD void operator()(std::uint32_t i) const {
        const std::uint32_t r = candidates[order[i]];
        const Ray& ray = rays[r];
        const RaySource& from = sources[r];
        const Pair pair = pairs[from.pair];
        const BodyView& source = bodies[pair.source(from.side)];
        const BodyView& target = bodies[ray.target];
        const Surface surface = target.surface();
        const Meeting m = meet(ray, surface, hits[r].triangle);
        const Triangle& t = surface.triangles[hits[r].triangle];
        const Vec3d corner[3] = {to_double(surface.positions[t.vertex[0]]), to_double(surface.positions[t.vertex[1]]),
                                 to_double(surface.positions[t.vertex[2]])};
        Vec3d q;
        for (int k = 0; k < 3; ++k) q += m.barycentric[k] * corner[k];
        const Vec3d face = normalized(cross(corner[1] - corner[0], corner[2] - corner[0]));
        const Vec3d p_world = source.space.to_parent(to_double(source.positions[from.vertex]));
        const Vec3d q_world = target.space.to_parent(q);
        const Vec3d direction = target.space.rotation * ray.direction;

        Contact c;
        c.a = ids[pair.a];
        c.b = ids[pair.b];
        c.source = static_cast<Side>(from.side);
        c.grazing = std::fabs(dot(face, ray.direction)) < constants::grazing_sine;
        c.vertex = from.vertex;
        c.triangle = hits[r].triangle;
        for (int k = 0; k < 3; ++k) c.barycentric[k] = m.barycentric[k];
        c.point_a = from.side == 0 ? p_world : q_world;
        c.point_b = from.side == 0 ? q_world : p_world;
        c.normal = from.side == 0 ? -direction : direction;
        c.face_normal = target.space.rotation * face;
        c.distance = -m.t;
        c.age = age(c, pair);
        contacts[i] = c;
    }

private:
    PIERCE_HD std::uint32_t age(const Contact& c, Pair pair) const {
        std::uint32_t low = 0, high = last_contacts.size;
        while (low < high) {
            const std::uint32_t middle = low + (high - low) / 2;
            const bool before =
                comes_before(last_contacts[middle], pair.a, pair.b, static_cast<std::uint32_t>(c.source), c.vertex);
            (before ? low : high) = before ? middle + 1 : middle;
        }
        if (low == last_contacts.size) return 0;
        const Contact& last = last_contacts[low];
        const bool same = last.a.index == c.a.index && last.a.generation == c.a.generation && last.b.index == c.b.index &&
                          last.b.generation == c.b.generation && last.source == c.source && last.vertex == c.vertex;
        return same ? last.age + 1 : 0;
    }
};

}  // namespace pierce::stages
