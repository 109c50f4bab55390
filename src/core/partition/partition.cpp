#include "core/partition/partition.hpp"

#include <algorithm>
#include <numeric>

#include "core/body/body_view.hpp"
#include "core/partition/body_reach.hpp"
#include "core/partition/space_partition.hpp"
#include "pierce/constants.hpp"

namespace pierce {
namespace {

double weight_of(const BodyView& body) { return static_cast<double>(body.mesh.triangles.size); }

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

bool Partition::update(const Scene& scene, bool anew) {
    if (anew) {
        boxes_.assign(scene.bodies.size, {});
        for (std::uint32_t b = 0; b < scene.bodies.size; ++b)
            boxes_[b] = box_of_reach(scene.bodies[b], scene.plan->settings);
        const double extents = std::accumulate(
            boxes_.begin(), boxes_.end(), 0.0,
            [](double sum, const Box& box) { return sum + box.extent(); });
        mean_extent_ = extents / std::max<double>(1, static_cast<double>(boxes_.size()));
    } else {
        for (const std::uint32_t b : scene.changed)
            boxes_[b] = box_of_reach(scene.bodies[b], scene.plan->settings);
    }
    if (std::ranges::equal(scene.ids, known_)) {
        look_around(scene);
        if (worst_ <= constants::uneven_parts * worst_at_first_) return false;
    }
    divide(scene);
    look_around(scene);
    worst_at_first_ = worst_;
    return true;
}

void Partition::divide(const Scene& scene) {
    std::vector<WeightedPoint> points(scene.bodies.size);
    Vec3d last;
    for (std::uint32_t b = 0; b < scene.bodies.size; ++b) {
        // Bodies that take no part go with the one before them.
        if (!boxes_[b].empty()) last = boxes_[b].center();
        points[b] = {last, boxes_[b].empty() ? 0 : weight_of(scene.bodies[b])};
    }
    owners_ = divide_space(points, shares_);
    known_.assign(scene.ids.begin(), scene.ids.end());
}

void Partition::look_around(const Scene& scene) {
    near_.resize(shares_.size());
    worst_ = 0;
    for (std::uint32_t part = 0; part < shares_.size(); ++part) {
        near_[part] = seen_from(scene, part, 0);
        double load = 0;
        for (std::uint32_t b = 0; b < scene.bodies.size; ++b)
            if (near_[part][b] && !boxes_[b].empty()) load += weight_of(scene.bodies[b]);
        worst_ = std::max(worst_, load / shares_[part]);
    }
}

std::vector<bool> Partition::residents(const Scene& scene, std::uint32_t part) const {
    return seen_from(scene, part, constants::spare_reach * mean_extent_);
}

std::vector<bool> Partition::seen_from(const Scene& scene, std::uint32_t part, double more) const {
    Region region(mean_extent_);
    for (std::uint32_t b = 0; b < scene.bodies.size; ++b)
        if (owners_[b] == part && !boxes_[b].empty() && scene.bodies[b].motion != Motion::fixed)
            region.add(boxes_[b].inflated(more));
    std::vector<bool> seen(scene.bodies.size, false);
    for (std::uint32_t b = 0; b < scene.bodies.size; ++b)
        seen[b] = scene.ids[b] &&
                  (owners_[b] == part || (!boxes_[b].empty() && region.meets(boxes_[b])));
    return seen;
}

}  // namespace pierce
