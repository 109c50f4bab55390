#include "fuzz/model.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace pierce::fuzz {
namespace {

bool is_good(Vec3d p) {
    constexpr double most = 0x1p60;
    return std::fabs(p.x) <= most && std::fabs(p.y) <= most && std::fabs(p.z) <= most;
}
bool is_good(const Pose& pose) {
    const Quaternion& q = pose.rotation;
    const double norm = q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w;
    return is_good(pose.position) && norm >= 0x1p-1000 && norm <= 0x1p1000;
}
bool is_good(const std::vector<Vec3f>& positions) {
    return std::ranges::all_of(positions, [](Vec3f p) { return is_good(to_double(p)); });
}

std::vector<Vec3d> placed(const MeshData& mesh, const Pose& pose) {
    std::vector<Vec3d> points;
    for (const Vec3f& p : mesh.positions) points.push_back(frame_of(pose).to_parent(to_double(p)));
    return points;
}
std::vector<Vec3d> in_double(const std::vector<Vec3f>& positions) {
    std::vector<Vec3d> points;
    for (const Vec3f& p : positions) points.push_back(to_double(p));
    return points;
}

std::pair<BodyId, BodyId> pair_of(BodyId a, BodyId b) { return {std::min(a, b), std::max(a, b)}; }

void begin_motion(ModelBody& b) {
    if (b.moved) return;
    b.moved = true;
    b.start_pose = b.pose;
    b.start = b.positions;
    if (b.finite) return;
    // The last step has not seen it.
    b.start_pose.position.x = NAN;
    if (!b.start.empty()) b.start[0].x = NAN;
}

void move(ModelBody& b, const Pose& pose) {
    begin_motion(b);
    b.pose = pose;
    if (!is_good(b.start_pose)) b.start_pose = pose;
    b.finite = is_good(pose);
}
void move(ModelBody& b, const std::vector<Vec3f>& positions) {
    begin_motion(b);
    b.positions = positions;
    if (!is_good(b.start)) b.start = positions;
    b.finite = is_good(positions);
}

}  // namespace

Model::ModelMesh::ModelMesh(const MeshData& data, Inside rule) : given(data), inside(rule) {
    const Mesh made("model", data, {.inside = rule});
    surface = {data.positions, {made.triangles().begin(), made.triangles().end()}};
    has_inside = made.inside().exists();
}

void Model::skip(const Call& call) {
    using Kind = Call::Kind;
    if (call.kind == Kind::add_mesh) meshes_.push_back({{}, Inside::none, {}, false});
    if (call.kind == Kind::add_fixed_body || call.kind == Kind::add_rigid_body ||
        call.kind == Kind::add_deforming_body)
        bodies_.emplace_back();
}

void Model::apply(const Call& call, const Player& player) {
    using Kind = Call::Kind;
    const auto add = [&](Motion motion) -> ModelBody& {
        ModelBody& b = bodies_.emplace_back();
        b.mesh = call.mesh;
        b.motion = motion;
        b.pose = b.start_pose = call.pose;
        b.id = player.bodies().back();
        b.used = true;
        return b;
    };
    switch (call.kind) {
        case Kind::add_mesh:
            meshes_.emplace_back(call.data, call.inside);
            break;
        case Kind::add_fixed_body:
            add(Motion::fixed);
            break;
        case Kind::add_rigid_body:
            add(Motion::rigid);
            break;
        case Kind::add_deforming_body: {
            ModelBody& b = add(Motion::deforming);
            b.positions = b.start = call.positions.empty() ? meshes_[call.mesh].given.positions
                                                           : call.positions;
            break;
        }
        case Kind::remove_body:
            bodies_[call.body].used = false;
            break;
        case Kind::set_collision:
            bodies_[call.body].collision = call.collision;
            break;
        case Kind::set_filter:
            if (bodies_of(call.filter.world).empty()) left_out_.erase(call.filter.world);
            bodies_[call.body].filter = call.filter;
            break;
        case Kind::replicate:
            replicate(call, player);
            break;
        case Kind::copy_places:
            copy_places(call);
            break;
        case Kind::remove_world:
            for (ModelBody* b : bodies_of(call.world)) b->used = false;
            break;
        case Kind::set_world_active:
            if (call.active)
                left_out_.erase(call.world);
            else
                left_out_.insert(call.world);
            break;
        case Kind::exclude:
            excluded_.insert(pair_of(bodies_[call.body].id, bodies_[call.other].id));
            break;
        case Kind::include:
            excluded_.erase(pair_of(bodies_[call.body].id, bodies_[call.other].id));
            break;
        case Kind::set_pose:
            move(bodies_[call.body], call.pose);
            break;
        case Kind::set_positions:
            move(bodies_[call.body], call.positions);
            break;
        case Kind::set_pose_motion: {
            ModelBody& b = bodies_[call.body];
            move(b, call.pose);
            b.start_pose = call.start_pose;
            b.finite = b.finite && is_good(call.start_pose);
            break;
        }
        case Kind::set_position_motion: {
            ModelBody& b = bodies_[call.body];
            move(b, call.positions);
            b.start = call.start;
            b.finite = b.finite && is_good(call.start);
            break;
        }
        case Kind::set_mesh: {
            ModelBody& b = bodies_[call.body];
            b.mesh = call.mesh;
            if (b.motion != Motion::deforming) break;
            b.positions = b.start = call.positions;
            b.moved = true;
            b.finite = is_good(call.positions);
            break;
        }
        case Kind::detect:
            each_body([](ModelBody& b) {
                b.moved = false;
                b.start_pose = b.pose;
                b.start = b.positions;
            });
            break;
        case Kind::remove_mesh:
        case Kind::forget_sides:
        case Kind::explain:
        case Kind::cast_rays:
        case Kind::probe:
        case Kind::overlap:
        case Kind::parting:
        case Kind::impacts:
        case Kind::restore:
            break;
    }
}

std::vector<ModelBody*> Model::bodies_of(std::int32_t world) {
    std::vector<ModelBody*> there;
    each_body([&](ModelBody& b) {
        if (b.filter.world == world) there.push_back(&b);
    });
    std::ranges::sort(there, {}, [](const ModelBody* b) { return b->id.index; });
    return there;
}

void Model::replicate(const Call& call, const Player& player) {
    const std::int32_t first = worlds().back() + 1;
    std::vector<ModelBody> originals;
    for (const ModelBody* b : bodies_of(call.world)) originals.push_back(*b);
    const std::set<std::pair<BodyId, BodyId>> excluded = excluded_;
    for (std::int32_t k = 0; k < static_cast<std::int32_t>(call.count); ++k) {
        left_out_.erase(first + k);
        const std::vector<BodyId> made = player.world().bodies_of(first + k);
        const auto copy = [&](BodyId id) {
            for (std::size_t i = 0; i < originals.size(); ++i)
                if (originals[i].id == id) return made[i];
            return id;
        };
        for (std::size_t i = 0; i < originals.size(); ++i) {
            ModelBody body = originals[i];
            body.id = made[i];
            body.filter.world = first + k;
            body.start_pose = body.pose;
            body.start = body.positions;
            body.moved = false;
            copies_.push_back(body);
        }
        for (const auto& [a, b] : excluded) excluded_.insert(pair_of(copy(a), copy(b)));
    }
}

void Model::copy_places(const Call& call) {
    const std::vector<ModelBody*> from = bodies_of(call.world), to = bodies_of(call.other_world);
    for (std::size_t i = 0; i < from.size(); ++i) {
        to[i]->pose = to[i]->start_pose = from[i]->pose;
        to[i]->positions = from[i]->positions;
        to[i]->start = to[i]->positions;
        to[i]->finite = from[i]->finite;
        to[i]->moved = false;
    }
}

std::vector<const ModelBody*> Model::bodies() const {
    std::vector<const ModelBody*> all;
    for (const std::vector<ModelBody>* some : {&bodies_, &copies_})
        for (const ModelBody& b : *some)
            if (b.used) all.push_back(&b);
    std::ranges::sort(all, {}, [](const ModelBody* b) { return b->id.index; });
    return all;
}

bool Model::takes_part(const ModelBody& body) const {
    return body.finite && !left_out_.contains(body.filter.world);
}

std::vector<std::int32_t> Model::worlds() const {
    std::set<std::int32_t> found;
    for (const ModelBody* b : bodies()) found.insert(b->filter.world);
    found.erase(all_worlds);
    return {found.begin(), found.end()};
}

bool Model::has_sheets() const {
    return std::ranges::any_of(bodies(), [](const ModelBody* b) { return b->collision.sheet; });
}

bool Model::may_meet(const ModelBody& a, const ModelBody& b) const {
    if (a.id == b.id) return true;
    const Filter &f = a.filter, &g = b.filter;
    return (f.groups & g.meets) != 0 && (g.groups & f.meets) != 0 &&
           (f.chain == 0 || f.chain != g.chain) &&
           (f.world == g.world || f.world == all_worlds || g.world == all_worlds) &&
           !excluded_.contains(pair_of(a.id, b.id));
}

double Model::margin(const ModelBody& a, const ModelBody& b) const {
    const auto own = [&](const ModelBody& body) {
        return body.collision.margin < 0 ? settings_.margin : body.collision.margin;
    };
    return std::max(own(a), own(b));
}

std::vector<Vec3d> Model::starts(const ModelBody& body) const {
    return body.motion == Motion::deforming ? in_double(body.start)
                                            : placed(mesh(body), body.start_pose);
}
std::vector<Vec3d> Model::ends(const ModelBody& body) const {
    return body.motion == Motion::deforming ? in_double(body.positions)
                                            : placed(mesh(body), body.pose);
}

Player Model::fresh(const MakeBackend& backend, Temporal temporal,
                    std::shared_ptr<MeshPool> pool) const {
    return made_of(bodies(), true, backend, temporal, std::move(pool));
}

Player Model::alone(std::int32_t world, const MakeBackend& backend, Temporal temporal,
                    std::shared_ptr<MeshPool> pool, std::vector<const ModelBody*>& some) const {
    some = bodies();
    std::erase_if(some, [&](const ModelBody* b) {
        return b->filter.world != world && b->filter.world != all_worlds;
    });
    return made_of(some, false, backend, temporal, std::move(pool));
}

Player Model::made_of(const std::vector<const ModelBody*>& some, bool with_worlds,
                      const MakeBackend& backend, Temporal temporal,
                      std::shared_ptr<MeshPool> pool) const {
    Settings settings = settings_;
    settings.temporal = temporal;
    Player player(backend, settings, std::move(pool));
    std::vector<std::uint32_t> number(meshes_.size(), std::numeric_limits<std::uint32_t>::max());
    std::uint32_t body = 0;
    for (const ModelBody* b : some) {
        if (number[b->mesh] == std::numeric_limits<std::uint32_t>::max()) {
            number[b->mesh] = static_cast<std::uint32_t>(player.meshes().size());
            Call call{.kind = Call::Kind::add_mesh};
            call.data = meshes_[b->mesh].given;
            call.inside = meshes_[b->mesh].inside;
            player.play(call);
        }
        const bool deforms = b->motion == Motion::deforming;
        Call add{.kind = b->motion == Motion::fixed ? Call::Kind::add_fixed_body
                                                    : Call::Kind::add_rigid_body};
        if (deforms) add.kind = Call::Kind::add_deforming_body;
        add.mesh = number[b->mesh];
        player.play(add);
        Call collide{.kind = Call::Kind::set_collision};
        collide.body = body;
        collide.collision = b->collision;
        player.play(collide);
        Call filter{.kind = Call::Kind::set_filter};
        filter.body = body;
        filter.filter = b->filter;
        if (!with_worlds) filter.filter.world = all_worlds;
        player.play(filter);
        Call place{.kind = deforms ? Call::Kind::set_position_motion : Call::Kind::set_pose_motion};
        place.body = body;
        place.start_pose = b->start_pose;
        place.pose = b->pose;
        place.start = b->start;
        place.positions = b->positions;
        if (!b->finite) {
            place.pose.position.x = std::nan("");
            for (Vec3f& p : place.positions) p.x = std::nanf("");
        }
        player.play(place);
        ++body;
    }
    for (std::uint32_t a = 0; a < some.size(); ++a)
        for (std::uint32_t b = a + 1; b < some.size(); ++b) {
            if (!excluded_.contains(pair_of(some[a]->id, some[b]->id))) continue;
            Call exclude{.kind = Call::Kind::exclude};
            exclude.body = a;
            exclude.other = b;
            player.play(exclude);
        }
    for (const std::int32_t world : with_worlds ? worlds() : std::vector<std::int32_t>{}) {
        if (!left_out_.contains(world)) continue;
        Call leave_out{.kind = Call::Kind::set_world_active};
        leave_out.world = world;
        leave_out.active = false;
        player.play(leave_out);
    }
    return player;
}

}  // namespace pierce::fuzz
