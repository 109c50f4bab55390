#include "core/partition/partition.hpp"

#include <algorithm>

#include "core/body/body_view.hpp"
#include "core/body/reach.hpp"
#include "core/geometry/motion_bound.hpp"
#include "core/partition/space_partition.hpp"
#include "pierce/constants.hpp"

namespace pierce {
namespace {

/// How far predictions look at most (stages::MeasureReach).
double longest_prediction(const BodyView& body, const Settings& settings) {
    if (settings.temporal != Temporal::paper || !settings.predict) return 0;
    return settings.prediction_distance >= 0
               ? 0.5 * settings.prediction_distance
               : 0.5 * constants::prediction_limit * body.mesh.mean_edge_length;
}

/// [length] How much further than around its points a body may have to do with others in a step,
/// but for tolerances and the way that it moves.
double reach_beyond_points(const BodyView& body, const Settings& settings) {
    return longest_prediction(body, settings) + body.collision.thickness + body.margin;
}

/// Where a body is whose place the host knows.
PlacedBox placed_box(const BodyView& body) {
    PlacedBox place;
    if (body.motion == Motion::deforming) {
        for (const Vec3f p : body.positions) place.box.extend(to_double(p));
        for (std::uint32_t v = 0; v < body.start.size; ++v)
            place.travel = std::max(
                place.travel, length(to_double(body.positions[v]) - to_double(body.start[v])));
    } else {
        place = placed_box(body.mesh.box, body.space);
        place.travel = largest_motion(body.start_space, body.space, body.mesh.box);
    }
    return place;
}

bool is_on_device(const BodyView& body) {
    return body.device_positions != nullptr || body.device_pose.exists();
}

/// What the moving bodies of a part reach: a box around those of each cell, and large bodies by
/// themselves, so that one of those does not make all bodies near.
class Region {
public:
    Region(std::uint32_t cells, double mean_extent)
        : large_(constants::large_body * mean_extent), cells_(cells) {}

    void add(std::uint32_t cell, const Box& box) {
        if (length_squared(box.upper - box.lower) > large_ * large_)
            single_.push_back(box);
        else
            cells_[cell].extend(box);
    }
    /// To be called once, when all boxes were added.
    void close(double more) {
        for (std::vector<Box>* boxes : {&cells_, &single_})
            for (Box& box : *boxes) {
                if (box.empty()) continue;
                box = box.inflated(more);
                all_.extend(box);
            }
    }
    bool meets(const Box& box) const {
        const auto meets_box = [&](const Box& one) { return overlap(one, box); };
        return overlap(all_, box) &&
               (std::ranges::any_of(cells_, meets_box) || std::ranges::any_of(single_, meets_box));
    }

private:
    double large_;
    Box all_;
    std::vector<Box> cells_, single_;
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
        reach_.assign(scene.bodies.size, {});
        for (std::uint32_t b = 0; b < scene.bodies.size; ++b) note(scene, b);
    } else {
        for (const std::uint32_t b : scene.changed) note(scene, b);
    }
    if (anew || scene.changed.size > 0) list_measured(scene);
}

void Partition::note(const Scene& scene, std::uint32_t b) {
    const BodyView& body = scene.bodies[b];
    const bool exists = static_cast<bool>(scene.ids[b]), active = exists && body.active;
    facts_[b] = {.weight = static_cast<float>(body.mesh.triangles.size),
                 .exists = exists,
                 .active = active,
                 .moves = body.motion != Motion::fixed};
    reach_[b] = active && !is_on_device(body)
                    ? reach_of(placed_box(body), reach_beyond_points(body, scene.plan->settings))
                    : Box{};
}

void Partition::list_measured(const Scene& scene) {
    for (Measured& m : measured_) m = {{}, {}, m.revision + 1};
    for (std::uint32_t b = 0; b < scene.bodies.size; ++b) {
        if (!facts_[b].active || !is_on_device(scene.bodies[b])) continue;
        Measured& m = measured_[b < owners_.size() ? owners_[b] : b % parts()];
        m.bodies.push_back(b);
        m.more.push_back(reach_beyond_points(scene.bodies[b], scene.plan->settings));
    }
    measures_ = std::ranges::any_of(measured_, [](const Measured& m) { return !m.bodies.empty(); });
}

void Partition::look_around(std::uint32_t part) { near_[part] = seen_from(part, 0, &loads_[part]); }

double Partition::worst_load() const {
    double worst = 0;
    for (std::uint32_t part = 0; part < parts(); ++part)
        worst = std::max(worst, loads_[part] / shares_[part]);
    return worst;
}

bool Partition::cut(const Scene& scene) {
    const bool same_bodies = planned_ == scene.plan->revision ||
                             std::ranges::equal(scene.ids, known_);
    planned_ = scene.plan->revision;
    if (same_bodies && worst_load() <= constants::uneven_parts * worst_at_first_) return false;
    owners_before_ = owners_;
    // Ghosts are work, too: parts that see more of them get less.
    std::vector<double> shares = shares_;
    for (std::uint32_t round = 0; round < constants::cut_rounds; ++round) {
        divide(shares);
        double all = 0, wanted = 0;
        for (std::uint32_t part = 0; part < parts(); ++part) {
            look_around(part);
            all += loads_[part];
            wanted += shares_[part];
        }
        for (std::uint32_t part = 0; part < parts(); ++part)
            if (loads_[part] > 0) shares[part] *= all * shares_[part] / (wanted * loads_[part]);
    }
    worst_at_first_ = worst_load();
    known_.assign(scene.ids.begin(), scene.ids.end());
    list_measured(scene);
    return true;
}

void Partition::divide(const std::vector<double>& shares) {
    std::vector<WeightedPoint> points(facts_.size());
    Vec3d last;
    double extents = 0;
    for (std::uint32_t b = 0; b < facts_.size(); ++b) {
        const Box& box = reach_[b];
        extents += box.extent();
        // Bodies that take no part go with the one before them.
        if (!box.empty()) last = box.center();
        points[b] = {last, box.empty() ? 0 : facts_[b].weight};
    }
    mean_extent_ = extents / std::max<double>(1, static_cast<double>(facts_.size()));
    owners_ = divide_space(points, shares);
    owned_.assign(parts(), {});
    for (std::uint32_t b = 0; b < facts_.size(); ++b)
        if (facts_[b].exists)
            owned_[owners_[b]].push_back({.body = b,
                                          .cell = 0,
                                          .weight = facts_[b].active ? facts_[b].weight : 0,
                                          .moves = facts_[b].moves});
    const std::vector<double> equal(constants::part_cells, 1.0);
    for (std::vector<Owned>& owned : owned_) {
        std::vector<WeightedPoint> places;
        places.reserve(owned.size());
        for (const Owned& own : owned) places.push_back(points[own.body]);
        const std::vector<std::uint32_t> cells = divide_space(places, equal);
        for (std::size_t k = 0; k < owned.size(); ++k) owned[k].cell = cells[k];
    }
}

BodySet Partition::residents(std::uint32_t part) const {
    return seen_from(part, constants::spare_reach * mean_extent_, nullptr);
}

BodySet Partition::seen_from(std::uint32_t part, double more, double* load) const {
    BodySet seen(facts_.size(), 0);
    if (owned_.empty() || owners_.size() != facts_.size()) return seen;
    Region region(constants::part_cells, mean_extent_);
    double weight = 0;
    for (const Owned& own : owned_[part]) {
        seen[own.body] = 1;
        weight += own.weight;
        if (own.moves) region.add(own.cell, reach_[own.body]);
    }
    region.close(more);
    for (std::uint32_t b = 0; b < facts_.size(); ++b) {
        // Pairs of two moving bodies belong to the lower one of their parts.
        const bool may_be_pair = owners_[b] > part || (owners_[b] < part && !facts_[b].moves);
        if (!may_be_pair || !region.meets(reach_[b])) continue;
        seen[b] = 1;
        weight += facts_[b].weight;
    }
    if (load != nullptr) *load = weight;
    return seen;
}

}  // namespace pierce
