#include "fuzz/player.hpp"

#include <bit>
#include <sstream>
#include <utility>

#include "pierce/error.hpp"

namespace pierce::fuzz {
namespace {

void put(std::ostream& text, double x) {
    text << std::hex << std::bit_cast<std::uint64_t>(x + 0.0) << ' ';
}
void put(std::ostream& text, Vec3d v) {
    for (int k = 0; k < 3; ++k) put(text, v[k]);
}

std::string to_text(const std::vector<std::optional<RayHit>>& hits) {
    std::ostringstream text;
    for (const auto& hit : hits) {
        if (!hit) {
            text << "nothing ";
            continue;
        }
        text << hit->body.index << ' ' << hit->triangle << ' ';
        put(text, hit->t);
        put(text, hit->normal);
    }
    return text.str();
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
            return world_.explain(body(c.body), body(c.other), c.vertex).text();
        case Kind::cast_rays: {
            std::vector<Vec3d> directions;
            for (const Vec3f& d : c.positions) directions.push_back(to_double(d));
            return to_text(world_.cast_rays(c.pose.position, directions));
        }
        case Kind::restore:
            return {};  // of all backends at once: restore()
    }
    return {};
}

}  // namespace pierce::fuzz
