#include "page/reasons.hpp"

#include <algorithm>
#include <set>
#include <tuple>

namespace pierce::page {
namespace {

/// Of a sheet's vertices with another body's triangles, in a frame.
constexpr std::size_t most_comparisons = 1'000'000;

using Key = std::tuple<std::uint32_t, std::uint32_t, std::uint32_t>;  // body, other, vertex

/// The vertices in contact.
std::set<Key> in_contact(std::span<const Contact> contacts) {
    std::set<Key> result;
    for (const Contact& c : contacts) {
        const bool of_a = c.source == Side::a;
        if (!c.is_edge())
            result.insert({(of_a ? c.a : c.b).index, (of_a ? c.b : c.a).index, c.vertex});
    }
    return result;
}

bool tells_something(Reason reason) {
    return reason != Reason::contact && reason != Reason::boxes_apart &&
           reason != Reason::outside_box;
}

}  // namespace

Reasons reasons_of(World& world) {
    std::vector<World::BodyBox> boxes = world.body_boxes();
    std::ranges::sort(boxes, {}, [](const World::BodyBox& b) { return b.box.lower.x; });
    const std::set<Key> touching = in_contact(world.contacts());
    Reasons result;
    const auto is_sheet = [&](BodyId body) { return world.collision_of(body).sheet; };
    const auto mesh_of = [&](BodyId body) -> const Mesh& {
        return world.mesh(world.mesh_of(body));
    };
    const auto look = [&](const World::BodyBox& of, const World::BodyBox& other) {
        if ((is_sheet(of.body) || is_sheet(other.body)) &&
            mesh_of(of.body).positions().size() * mesh_of(other.body).triangles().size() >
                most_comparisons) {
            result.has_all = false;
            return;
        }
        std::uint32_t vertex = 0;
        for (Vec3d p : world.vertex_positions(of.body)) {
            const std::uint32_t v = vertex++;
            if (!other.box.contains(p) || touching.contains({of.body.index, other.body.index, v}))
                continue;
            Explanation why = world.explain(of.body, other.body, v);
            if (tells_something(why.reason)) result.list.push_back({of.body, other.body, v, why});
        }
    };
    for (std::size_t i = 0; i < boxes.size(); ++i) {
        if (is_sheet(boxes[i].body)) look(boxes[i], boxes[i]);
        for (std::size_t k = i + 1;
             k < boxes.size() && boxes[k].box.lower.x <= boxes[i].box.upper.x; ++k)
            if (overlap(boxes[i].box, boxes[k].box)) {
                look(boxes[i], boxes[k]);
                look(boxes[k], boxes[i]);
            }
    }
    std::ranges::sort(result.list, {}, [](const VertexReason& r) {
        return Key(r.body.index, r.vertex, r.other.index);
    });
    return result;
}

}  // namespace pierce::page
