#include "core/partition/partition.hpp"

#include <algorithm>
#include <numeric>

#include "core/body/body_view.hpp"
#include "core/partition/body_reach.hpp"
#include "core/partition/space_partition.hpp"
#include "pierce/constants.hpp"

namespace pierce {
namespace {

bool is_on_device(const BodyView& body) {
    return body.device_positions != nullptr || body.device_pose.exists();
}

/// What the moving bodies of a part reach: one box around most of them, and large ones by
/// themselves, so that one of those does not make all bodies near.
class Region {
public:
    explicit Region(double mean_extent) : large_(constants::large_body * mean_extent) {}

    void add(const Box& box) {
        if (box.extent() > large_)
            single_.push_back(box);
        else
            most_.extend(box);
    }
    bool meets(const Box& box) const {
        return overlap(most_, box) ||
               std::ranges::any_of(single_, [&](const Box& one) { return overlap(one, box); });
    }

private:
    double large_;
    Box most_;
    std::vector<Box> single_;
};

}  // namespace

Partition::Partition(std::vector<double> shares)
    : shares_(std::move(shares)),
      measured_(shares_.size()),
      near_(shares_.size()),
      loads_(shares_.size(), 0) {}

void Partition::begin(const Scene& scene, bool anew) {
    if (anew) {
        facts_.assign(scene.bodies.size, {});
        places_.assign(scene.bodies.size, {});
        for (std::uint32_t b = 0; b < scene.bodies.size; ++b) note(scene, b);
    } else {
        for (const std::uint32_t b : scene.changed) note(scene, b);
    }
    if (anew || scene.changed.size > 0) list_measured(scene);
}

void Partition::note(const Scene& scene, std::uint32_t b) {
    const BodyView& body = scene.bodies[b];
    facts_[b] = {.more = reach_beyond_box(body, scene.plan->settings),
                 .weight = static_cast<float>(body.mesh.triangles.size),
                 .exists = static_cast<bool>(scene.ids[b]),
                 .active = body.active,
                 .moves = body.motion != Motion::fixed};
    if (body.active && !is_on_device(body)) places_[b] = placed_box(body);
}

void Partition::list_measured(const Scene& scene) {
    for (std::vector<std::uint32_t>& list : measured_) list.clear();
    for (std::uint32_t b = 0; b < scene.bodies.size; ++b)
        if (facts_[b].active && is_on_device(scene.bodies[b]))
            measured_[b < owners_.size() ? owners_[b] : b % parts()].push_back(b);
}

Box Partition::reach(std::uint32_t b) const {
    return facts_[b].active ? box_of_reach(places_[b], facts_[b].more) : Box{};
}

void Partition::look_around(std::uint32_t part) {
    near_[part] = seen_from(part, 0);
    double load = 0;
    for (std::uint32_t b = 0; b < facts_.size(); ++b)
        if (near_[part][b]) load += facts_[b].active ? facts_[b].weight : 0.0f;
    loads_[part] = load;
}

double Partition::worst_load() const {
    double worst = 0;
    for (std::uint32_t part = 0; part < parts(); ++part)
        worst = std::max(worst, loads_[part] / shares_[part]);
    return worst;
}

bool Partition::cut(const Scene& scene) {
    if (std::ranges::equal(scene.ids, known_) &&
        worst_load() <= constants::uneven_parts * worst_at_first_)
        return false;
    std::vector<WeightedPoint> points(facts_.size());
    Vec3d last;
    double extents = 0;
    for (std::uint32_t b = 0; b < facts_.size(); ++b) {
        const Box box = reach(b);
        extents += box.extent();
        // Bodies that take no part go with the one before them.
        if (!box.empty()) last = box.center();
        points[b] = {last, box.empty() ? 0 : facts_[b].weight};
    }
    mean_extent_ = extents / std::max<double>(1, static_cast<double>(facts_.size()));
    owners_ = divide_space(points, shares_);
    known_.assign(scene.ids.begin(), scene.ids.end());
    list_measured(scene);
    return true;
}

BodySet Partition::residents(std::uint32_t part) const {
    return seen_from(part, constants::spare_reach * mean_extent_);
}

BodySet Partition::seen_from(std::uint32_t part, double more) const {
    BodySet seen(facts_.size(), 0);
    if (owners_.size() != facts_.size()) return seen;
    Region region(mean_extent_);
    for (std::uint32_t b = 0; b < facts_.size(); ++b)
        if (owners_[b] == part && facts_[b].moves && facts_[b].active)
            region.add(reach(b).inflated(more));
    for (std::uint32_t b = 0; b < facts_.size(); ++b)
        seen[b] = facts_[b].exists &&
                  (owners_[b] == part || (facts_[b].active && region.meets(reach(b))));
    return seen;
}

}  // namespace pierce
