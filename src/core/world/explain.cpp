#include "pierce/explain.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <span>
#include <vector>

#include "core/body/body_view.hpp"
#include "core/device/view.hpp"
#include "core/geometry/oriented_box.hpp"
#include "core/partition/contact_order.hpp"
#include "core/step/common/pairs.hpp"
#include "core/step/solids/directed_pair.hpp"
#include "core/step/solids/ray_gen.hpp"
#include "core/step/solids/rules.hpp"
#include "core/trace/meeting.hpp"
#include "core/world/explain_sheet.hpp"
#include "core/world/world_state.hpp"
#include "pierce/error.hpp"

namespace pierce {
namespace {

/// Answers with the step's own functors, for bodies as the last step left them.
class Explainer {
public:
    Explainer(Backend& backend, const Settings& settings, View<const BodyView> bodies,
              std::uint32_t source, std::uint32_t target, std::uint32_t vertex)
        : backend_(backend),
          only_inside_(settings.inside_is_contact()),
          bodies_(bodies),
          source_(bodies[source]),
          target_(bodies[target]),
          source_index_(source),
          vertex_(vertex) {
        directed_.source = source;
        directed_.target = target;
        directed_.to_fit = relative_frame(source_.space, target_.fit);
        directed_.to_space = relative_frame(source_.space, target_.space);
        directed_.touch = stages::touch_between(source_, target_, directed_.to_space);
    }

    Explanation answer() {
        if (pair_fails() || is_culled()) return result_;
        Ray ray;
        stages::aim_vertex_ray(bodies_, directed_, vertex_, only_inside_, ray);
        if (length_squared(ray.direction) == 0) return because(Reason::no_direction);
        trace(ray);
        return result_;
    }

private:
    Explanation& because(Reason reason, double distance = 0) {
        result_.reason = reason;
        result_.distance = distance;
        return result_;
    }

    bool pair_fails() {
        const auto says = [&](Reason reason, double distance = 0) {
            because(reason, distance);
            return true;
        };
        if (!source_.active || !target_.active) return says(Reason::excluded);
        if (source_.motion == Motion::fixed && target_.motion == Motion::fixed)
            return says(Reason::both_fixed);
        if (!overlap(source_.world_box.inflated(source_.touch),
                     target_.world_box.inflated(target_.touch))) {
            Vec3d gap;
            for (int i = 0; i < 3; ++i)
                gap[i] = std::max({source_.world_box.lower[i] - target_.world_box.upper[i],
                                   target_.world_box.lower[i] - source_.world_box.upper[i], 0.0});
            return says(Reason::boxes_apart, length(gap));
        }
        if (!oriented_boxes_overlap(source_.fit, source_.fit_box, target_.fit, target_.fit_box,
                                    std::max(source_.touch, target_.touch)))
            return says(Reason::boxes_apart);
        if (!target_.mesh.closed) return says(Reason::open_target);
        return false;
    }

    bool is_culled() {
        const Vec3d p = directed_.to_fit.to_parent(to_double(source_.positions[vertex_]));
        const rules::Gap gap = rules::gap_to(target_, p);
        if (gap.may_be_inside(target_.touch)) return false;
        if (gap.beyond_box > 2 * target_.touch)
            because(Reason::outside_box, gap.beyond_box);
        else
            because(Reason::outside_solid, gap.clearance);
        return true;
    }

    Hit first_hit(const Ray& ray) {
        Hit hit;
        backend_.closest_hits(bodies_, {&ray, 1}, {&hit, 1});
        return hit;
    }

    /// Applies R1 and, where they matter, R2 and R3. The ray is as long as the target, to see what
    /// lies beyond the ray's range.
    void trace(Ray ray) {
        const double range = ray.t_max;
        ray.t_max = target_.fit_box.extent();
        const Hit hit = first_hit(ray);
        if (hit.triangle == no_triangle) {
            because(Reason::nothing_ahead);
            return;
        }
        const Meeting meeting = meet(ray, target_.surface(), hit.triangle);
        result_.t = meeting.t;
        result_.triangle = hit.triangle;
        if (!rules::starts_inside(meeting)) {
            because(Reason::entry_first);
            return;
        }
        if (only_inside_) {
            because(Reason::contact);
            return;
        }
        if (!source_.mesh.closed) {
            result_.own_exit = range;
            because(rules::leaves_target_first(meeting.t, range, ray.touch) ? Reason::contact
                                                                            : Reason::beyond_range);
            return;
        }
        const std::optional<double> own = own_exit();
        if (!own) {
            because(Reason::not_inside_own);
            return;
        }
        // A source that crosses itself may show no exit; the step's ray ends with its box.
        result_.own_exit = std::min(*own, range);
        because(rules::leaves_target_first(meeting.t, result_.own_exit, ray.touch)
                    ? Reason::contact
                    : Reason::own_exit_first);
    }

    /// Length of the ray inside its own body; nothing if the ray does not start inside.
    std::optional<double> own_exit() {
        Ray ray;
        ray.direction = stages::inward_direction(source_, vertex_);
        ray.origin = to_double(source_.positions[vertex_]);
        ray.t_max = source_.fit_box.extent();
        ray.target = source_index_;
        ray.touch = source_.touch;
        ray.excluded[0] = ray.excluded[1] = vertex_;
        const Hit hit = first_hit(ray);
        if (hit.triangle == no_triangle) {
            // Only the triangles around the vertex lie ahead: the ray starts inside if it starts
            // behind them.
            if (!leads_inside(source_.mesh, source_.positions, vertex_, ray.direction))
                return std::nullopt;
            return INFINITY;
        }
        const Meeting exit = meet(ray, source_.surface(), hit.triangle);
        if (!rules::starts_in_own(exit)) return std::nullopt;
        return exit.t;
    }

    Backend& backend_;
    bool only_inside_;
    View<const BodyView> bodies_;
    const BodyView& source_;
    const BodyView& target_;
    std::uint32_t source_index_, vertex_;
    stages::DirectedPair directed_;
    Explanation result_;
};

/// Those of a world's contacts that a pair of solids may have: all of them where contacts are
/// sorted by world before pairs, and else the pair's own.
std::span<const Contact> contacts_of(std::span<const Contact> all, View<const BodyView> bodies,
                                     Pair pair, bool by_world) {
    if (by_world) return all;
    const auto of_pair = [](const Contact& c) { return Pair{c.a.index, c.b.index}; };
    const auto solids_end = std::ranges::partition_point(
        all, [&](const Contact& c) { return is_by_ray(c, bodies); });
    const std::ranges::subrange solids(all.begin(), solids_end);
    const auto own = std::ranges::equal_range(
        solids, pair, [](Pair p, Pair q) { return p < q; }, of_pair);
    return {own.begin(), own.end()};
}

/// The contacts of a vertex of `body` with `other`, which may be the same body.
std::vector<Contact> of_vertex(std::span<const Contact> some, BodyId body, BodyId other,
                               std::uint32_t vertex) {
    std::vector<Contact> result;
    std::ranges::copy_if(some, std::back_inserter(result), [&](const Contact& c) {
        return c.source_body() == body && c.target_body() == other && c.vertex == vertex &&
               !c.is_edge();
    });
    return result;
}

}  // namespace

Explanation World::explain(BodyId body, BodyId other, std::uint32_t vertex) {
    for (const BodyId id : {body, other})
        if (state_->bodies.get(id, "body").is_on_device())
            throw InputError("body " + std::to_string(id.index) +
                             " has its place in device memory");
    vertex_position(body, vertex);  // checks the vertex
    const bool sheet = collision_of(body).sheet || collision_of(other).sheet;
    if (body == other && !sheet)
        throw InputError("a vertex of a solid is not explained against its own body");
    state_->check_stepped("explain");
    state_->backend->fetch_bodies(view_of(state_->views));
    const View<const BodyView> views = view_of(std::as_const(state_->views));
    const stages::WantedPairs wanted{.bodies = views,
                                     .ids = view_of(std::as_const(state_->ids)),
                                     .excluded = view_of(std::as_const(state_->excluded_pairs)),
                                     .filter = state_->asked_filter()};
    const Pair pair{std::min(body.index, other.index), std::max(body.index, other.index)};
    const auto because = [](Reason reason) {
        Explanation explanation;
        explanation.reason = reason;
        return explanation;
    };
    if (!wanted.allows(pair) || !wanted.wants(pair)) return because(Reason::filtered);
    if (!has_triangles(views[body.index].mesh, vertex))
        return because(Reason::no_triangle_names_it);
    const std::vector<Contact> found = of_vertex(
        contacts_of(contacts(), views, pair, sheet || !state_->worlds.empty()), body, other,
        vertex);
    if (sheet)
        return explain_sheet(views[body.index], views[other.index], vertex,
                             std::max(collision_of(body).thickness, collision_of(other).thickness),
                             found);
    Explanation result = Explainer(*state_->backend, state_->plan.settings, views, body.index,
                                   other.index, vertex)
                             .answer();

    const BodyId a = std::min(body, other), b = std::max(body, other);
    const Side side = body == a ? Side::a : Side::b;
    if (state_->plan.settings.temporal == Temporal::certified)
        result.certificate = state_->backend->certificate(views, {a.index, b.index},
                                                          static_cast<std::uint32_t>(side), vertex);
    if (!found.empty()) {
        result.contact = found.front();
        result.reason = Reason::contact;
    } else if (result.reason == Reason::contact) {
        result.reason = state_->plan.settings.temporal == Temporal::paper ? Reason::not_looked_at
                                                                          : Reason::unexplained;
    }
    return result;
}

}  // namespace pierce
