#include "fuzz/player.hpp"

#include <bit>
#include <sstream>
#include <utility>

#include "pierce/error.hpp"

namespace pierce::fuzz {
namespace {

/// An answer as text. One that the step disagrees with is a defect.
std::string explained(const Explanation& answer) {
    if (answer.reason == Reason::unexplained) throw std::logic_error(answer.text());
    return answer.text();
}

void put(std::ostream& text, double x) {
    text << std::hex << std::bit_cast<std::uint64_t>(x + 0.0) << ' ';
}
void put(std::ostream& text, Vec3d v) {
    for (int k = 0; k < 3; ++k) put(text, v[k]);
}

template <class Found, class Put>
std::string to_text(const Found& all, const Put& put_one) {
    std::ostringstream text;
    for (const auto& one : all)
        if (one)
            put_one(text, *one);
        else
            text << "nothing ";
    return text.str();
}

std::string to_text(const Overlap& overlap) {
    std::ostringstream text;
    for (double x : {overlap.volume, overlap.area_a, overlap.area_b}) put(text, x);
    for (Vec3d v : {overlap.center, overlap.push, overlap.turn}) put(text, v);
    for (const ContactPatch& patch : overlap.patches) {
        for (double x : {patch.area, patch.depth_volume, patch.depth}) put(text, x);
        for (Vec3d v : {patch.center, patch.normal, patch.deepest}) put(text, v);
    }
    return text.str();
}

std::string to_text(const Parting& parting) {
    std::ostringstream text;
    put(text, parting.direction);
    put(text, parting.depth);
    return text.str();
}

std::string to_text(const std::vector<ImpactContact>& impacts) {
    std::ostringstream text;
    for (const ImpactContact& i : impacts) {
        text << std::dec << i.a.index << ' ' << i.b.index << ' ' << i.vertex << ' ' << i.triangle
             << ' ';
        for (double x : {i.time, i.gap}) put(text, x);
        for (Vec3d v : {i.point, i.normal, i.start_a, i.start_b}) put(text, v);
    }
    return text.str();
}

std::vector<Vec3d> in_double(const std::vector<Vec3f>& all) {
    std::vector<Vec3d> wide;
    for (const Vec3f& v : all) wide.push_back(to_double(v));
    return wide;
}

}  // namespace

Player::Player(MakeBackend backend, const Settings& settings, std::shared_ptr<MeshPool> pool)
    : make_(std::move(backend)), pool_(std::move(pool)), world_(make_(), settings) {}

Player::Outcome Player::play(const Call& call) {
    try {
        return {false, answer(call)};
    } catch (const InputError& error) {
        if (call.kind == Call::Kind::add_mesh) meshes_.emplace_back();
        const bool adds_body = call.kind == Call::Kind::add_fixed_body ||
                               call.kind == Call::Kind::add_rigid_body ||
                               call.kind == Call::Kind::add_deforming_body;
        if (adds_body) bodies_.emplace_back();
        return {true, error.what()};
    }
}

std::string Player::save() const {
    std::ostringstream out;
    world_.save(out);
    return out.str();
}

void Player::restore(const std::string& saved) {
    std::istringstream in(saved);
    world_ = World::restore(in, make_());
}

std::string Player::answer(const Call& c) {
    using Kind = Call::Kind;
    switch (c.kind) {
        case Kind::add_mesh:
            made_.resize(meshes_.size());
            made_.push_back(pool_->made_of(
                c.data, c.inside, c.before < made_.size() ? made_[c.before].get() : nullptr));
            meshes_.push_back(world_.add_mesh(made_.back()));
            break;
        case Kind::remove_mesh:
            world_.remove_mesh(mesh(c.mesh));
            break;
        case Kind::add_fixed_body:
            bodies_.push_back(world_.add_fixed_body(mesh(c.mesh), c.pose));
            break;
        case Kind::add_rigid_body:
            bodies_.push_back(world_.add_rigid_body(mesh(c.mesh), c.pose));
            break;
        case Kind::add_deforming_body:
            bodies_.push_back(world_.add_deforming_body(mesh(c.mesh), c.positions));
            break;
        case Kind::remove_body:
            world_.remove_body(body(c.body));
            break;
        case Kind::set_collision:
            world_.set_collision(body(c.body), c.collision);
            break;
        case Kind::set_pose:
            world_.set_pose(body(c.body), c.pose);
            break;
        case Kind::set_positions:
            world_.set_positions(body(c.body), c.positions);
            break;
        case Kind::set_pose_motion:
            world_.set_motion(body(c.body), c.start_pose, c.pose);
            break;
        case Kind::set_position_motion:
            world_.set_motion(body(c.body), std::span<const Vec3f>(c.start),
                              std::span<const Vec3f>(c.positions));
            break;
        case Kind::set_mesh:
            if (c.positions.empty())
                world_.set_mesh(body(c.body), mesh(c.mesh));
            else
                world_.set_mesh(body(c.body), mesh(c.mesh), c.positions);
            break;
        case Kind::set_filter:
            world_.set_filter(body(c.body), c.filter);
            break;
        case Kind::exclude:
            world_.exclude(body(c.body), body(c.other));
            break;
        case Kind::include:
            world_.include(body(c.body), body(c.other));
            break;
        case Kind::replicate:
            return std::to_string(world_.replicate(c.world, c.count));
        case Kind::copy_places:
            world_.copy_places(c.world, c.other_world);
            break;
        case Kind::remove_world:
            world_.remove_world(c.world);
            break;
        case Kind::set_world_active:
            world_.set_world_active(c.world, c.active);
            break;
        case Kind::forget_sides:
            world_.forget_sides();
            break;
        case Kind::detect: {
            const StepStats& s = world_.detect();
            std::ostringstream text;
            text << "status " << s.status << " excluded " << s.excluded_bodies << " pairs "
                 << s.pairs << " contacts " << s.contacts;
            return text.str();
        }
        case Kind::explain:
            return explained(world_.explain(body(c.body), body(c.other), c.vertex));
        case Kind::cast_rays:
            return to_text(world_.cast_rays(c.pose.position, in_double(c.positions)),
                           [](std::ostream& text, const RayHit& hit) {
                               text << std::dec << hit.body.index << ' ' << hit.triangle << ' ';
                               put(text, hit.t);
                               put(text, hit.normal);
                           });
        case Kind::probe:
            return to_text(world_.probe(in_double(c.positions), in_double(c.start), c.radius),
                           [](std::ostream& text, const ProbeContact& found) {
                               text << std::dec << found.body.index << ' ' << found.triangle << ' ';
                               put(text, found.distance);
                               put(text, found.normal);
                           });
        case Kind::overlap: {
            const auto found = world_.overlap(body(c.body), body(c.other));
            return found ? to_text(*found) : "nothing";
        }
        case Kind::parting: {
            const auto found = world_.parting(body(c.body), body(c.other));
            return found ? to_text(*found) : "nothing";
        }
        case Kind::impacts:
            return to_text(world_.impacts(c.count));
        case Kind::restore:
            return {};  // of all backends at once: restore()
    }
    return {};
}

}  // namespace pierce::fuzz
