#include "pierce/parting.hpp"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "core/geometry/half_spaces.hpp"
#include "core/overlap/convex_parting.hpp"
#include "core/world/pair_copy.hpp"
#include "core/world/world_state.hpp"
#include "pierce/constants.hpp"
#include "pierce/error.hpp"

namespace pierce {
namespace {

Parting parting_by(Vec3d way) { return {normalized(way), length(way)}; }

}  // namespace

std::optional<Parting> least_translation(std::span<const Contact> contacts) {
    std::vector<HalfSpace> demands;
    for (const Contact& c : contacts)
        if (!c.unknown_side) demands.push_back({c.normal, -c.distance});
    const std::optional<Vec3d> way = closest_to_origin(demands);
    if (!way) return std::nullopt;
    return parting_by(*way);
}

/// Looks for a short translation that parts a pair. Each one that it finds was tried, or puts a
/// plane between the two.
class World::PartingSearch {
public:
    explicit PartingSearch(PairCopy& pair) : pair_(pair) {}

    /// Nothing if the bodies do not overlap.
    std::optional<Parting> shortest() {
        if (!look({})) return std::nullopt;
        if (const auto way = shortest_convex_parting(pair_.placed(0), pair_.placed(1)))
            return parting_by(*way);
        const std::vector<Deep> at_first = deep_;
        double least = 0;  // no way is shorter: a point in contact has that far to go
        for (const Deep& d : at_first) least = std::max(least, d.demand.least - touch_);

        best_ = pair_.way_apart();
        follow_demands();
        for (const Vec3d along : likely_directions(at_first)) {
            if (length(best_) <= constants::parting_enough * least) break;
            follow(along);
        }
        return parting_by(best_);
    }

private:
    /// What a contact demands of the translation, and its points on a and b before any.
    struct Deep {
        HalfSpace demand;
        Vec3d on_a, on_b;
    };

    /// Sets `deep_` to the contacts after a translation; false if the bodies are apart, and where
    /// contacts are looked for. Faces that lie on each other may have contacts without a depth
    /// where the bodies overlap.
    bool look(Vec3d way) {
        deep_.clear();
        const std::span<const Contact> contacts = pair_.contacts_after(way);
        touch_ = pair_.touch();
        for (const Contact& c : contacts) {
            if (!(c.penetration_depth() > touch_)) continue;
            const bool in_order = pair_.is_in_order(c);
            const Vec3d normal = in_order ? c.normal : -c.normal;
            deep_.push_back({.demand = {normal, dot(normal, way) + c.penetration_depth() + touch_},
                             .on_a = in_order ? c.point_a : c.point_b,
                             .on_b = in_order ? c.point_b : c.point_a});
        }
        if (!deep_.empty() || !pair_.are_within_reach()) return true;
        return !contacts.empty() && pair_.share_volume();
    }

    bool is_shorter(double way) const { return way < length(best_); }

    /// Moves the pair as all contacts so far demand until there are none.
    void follow_demands() {
        std::vector<HalfSpace> demands;
        Vec3d way;
        for (std::uint32_t round = 0; round < constants::parting_rounds; ++round) {
            if (!look(way)) {
                best_ = way;
                return;
            }
            if (deep_.empty()) return;  // nothing says where to go
            for (const Deep& d : deep_) demands.push_back(d.demand);
            const std::optional<Vec3d> next = closest_to_origin(demands);
            if (!next || !is_shorter(length(*next))) return;
            way = *next;
        }
    }

    /// Normals of contacts along which the pair looks thin, the thinnest first.
    static std::vector<Vec3d> likely_directions(const std::vector<Deep>& contacts) {
        std::vector<std::pair<double, Vec3d>> ranked;
        for (const Deep& d : contacts) {
            const Vec3d n = d.demand.normal;
            double high = -INFINITY, low = INFINITY;
            for (const Deep& other : contacts) {
                high = std::max(high, dot(n, other.on_a));
                low = std::min(low, dot(n, other.on_b));
            }
            ranked.push_back({high - low, n});
        }
        std::ranges::stable_sort(ranked, {}, [](const auto& one) { return one.first; });
        std::vector<Vec3d> directions;
        for (const auto& [thickness, n] : ranked) {
            const bool is_new = std::ranges::none_of(directions, [&](Vec3d known) {
                return dot(known, n) > constants::parting_same_direction;
            });
            if (is_new) directions.push_back(n);
            if (directions.size() == constants::parting_directions) break;
        }
        return directions;
    }

    /// Moves the pair along a direction until it is apart, and halves how far that was too far.
    void follow(Vec3d along) {
        double overlapping = 0, way = 0;
        for (std::uint32_t round = 0; look(way * along); ++round) {
            if (round == constants::parting_rounds) return;
            double more = 0;
            for (const Deep& d : deep_) {
                const double slope = std::max(dot(d.demand.normal, along),
                                              constants::parting_slope);
                more = std::max(more, (d.demand.least - way * dot(d.demand.normal, along)) / slope);
            }
            if (deep_.empty()) more = 0.5 * (length(best_) - way);
            overlapping = way;
            way += more;
            if (!is_shorter(overlapping)) return;
        }
        for (std::uint32_t k = 0; k < constants::parting_halvings; ++k) {
            const double middle = 0.5 * (overlapping + way);
            (look(middle * along) ? overlapping : way) = middle;
        }
        if (is_shorter(way)) best_ = way * along;
    }

    PairCopy& pair_;
    Vec3d best_;  ///< the shortest way so far that parts the pair
    std::vector<Deep> deep_;
    double touch_ = 0;
};

std::optional<Parting> World::parting(BodyId a, BodyId b) {
    if (a == b) throw InputError("a body cannot be parted from itself");
    const auto copy = [&](BodyId id) {
        const BodyEntry& body = state_->placed_body(id);
        const Mesh& mesh = state_->mesh_of(body);
        if (body.collision.sheet)
            throw InputError("a sheet of mesh '" + mesh.name() + "' has no inside to part from");
        return PairCopy::Body{.mesh = state_->meshes.get(body.mesh, "mesh").mesh,
                              .motion = body.motion,
                              .pose = body.pose,
                              .positions = body.positions};
    };
    const PairCopy::Body copy_a = copy(a), copy_b = copy(b);
    if (!state_->bodies.get(a, "body").is_placed() || !state_->bodies.get(b, "body").is_placed())
        return std::nullopt;
    if (!state_->pair) state_->pair = std::make_unique<PairCopy>();
    state_->pair->set(copy_a, copy_b);
    return PartingSearch(*state_->pair).shortest();
}

}  // namespace pierce
