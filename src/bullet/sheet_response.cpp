#include "pierce/bullet/sheet_response.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "bullet/sheet_response_state.hpp"
#include "pierce/bullet/bullet_convert.hpp"
#include "pierce/error.hpp"

namespace pierce::bullet {
namespace {

using Clock = std::chrono::steady_clock;

double milliseconds_since(Clock::time_point begin) {
    return std::chrono::duration<double, std::milli>(Clock::now() - begin).count();
}

/// A pose after a small turn about its position, and a shift.
Pose moved(const Pose& pose, Vec3d shift, Vec3d turn) {
    const Quaternion& q = pose.rotation;
    const Vec3d v{q.x, q.y, q.z};
    const double angle = length(turn), half = std::sin(0.5 * angle), w = std::cos(0.5 * angle);
    const Vec3d axis = half * normalized(turn), turned = w * v + q.w * axis + cross(axis, v);
    return {pose.position + shift, {turned.x, turned.y, turned.z, w * q.w - dot(axis, v)}};
}

}  // namespace

/// Where a point of a body other than a sheet was when the step began.
Vec3d SheetResponse::State::start_of(BodyId body, Vec3d end) const {
    const auto found = obstacle_of.find(body);
    if (found == obstacle_of.end()) return end;
    const Obstacle& o = obstacles[found->second];
    return frame_of(o.start).to_parent(frame_of(o.end).to_local(end));
}

SheetProjection::Point SheetResponse::State::solid_point(BodyId body, Vec3d point) {
    SheetProjection::Point p;
    p.start = start_of(body, point);
    p.end = point;
    if (const auto found = obstacle_of.find(body); found != obstacle_of.end())
        p.body = &obstacles[found->second].moving;
    return p;
}

SheetProjection::Point SheetResponse::State::source_point(const Contact& c) {
    const auto found = sheet_of.find(c.source_body());
    if (found == sheet_of.end()) return solid_point(c.source_body(), c.source_point());
    SheetProjection::Point p;
    p.nodes = &found->second->nodes;
    p.vertex[0] = c.vertex;
    p.weight[0] = 1;
    if (c.is_edge()) {
        p.vertex[1] = c.edge_end;
        p.weight[0] = c.source_weight(0);
        p.weight[1] = c.source_weight(1);
    }
    return p;
}

SheetProjection::Point SheetResponse::State::target_point(const Contact& c) {
    const auto found = sheet_of.find(c.target_body());
    if (found == sheet_of.end()) return solid_point(c.target_body(), c.target_point());
    SheetProjection::Point p;
    p.nodes = &found->second->nodes;
    const Triangle& t = world.mesh(world.mesh_of(c.target_body())).triangles()[c.triangle];
    for (int k = 0; k < 3; ++k) {
        p.vertex[k] = t.vertex[k];
        p.weight[k] = c.barycentric[k];
    }
    return p;
}

/// Reads where Bullet's step has moved sheets and obstacles.
void SheetResponse::State::read_step() {
    for (const auto& sheet : sheets) {
        MovingNodes& nodes = sheet->nodes;
        for (std::size_t i = 0; i < nodes.end.size(); ++i) {
            const btSoftBody::Node& node = sheet->soft->m_nodes[static_cast<int>(i)];
            nodes.end[i] = from_bullet(node.m_x);
            nodes.inverse_mass[i] = node.m_im;
        }
        sheet->pulled_back.assign(nodes.end.size(), false);
    }
    for (Obstacle& o : obstacles) {
        o.start = o.end;
        o.end = from_bullet(o.rigid->getWorldTransform());
        o.shift = o.turn = o.impulse = {};
        o.moving = {};
        o.is_held = false;
        if (o.rigid->isStaticOrKinematicObject() || !o.rigid->isActive()) continue;
        o.moving.inverse_mass = o.rigid->getInvMass();
        for (int r = 0; r < 3; ++r)
            o.moving.inverse_inertia.row[r] = from_bullet(o.rigid->getInvInertiaTensorWorld()[r]);
    }
}

void SheetResponse::State::detect() {
    const auto begin = Clock::now();
    for (const auto& sheet : sheets) {
        std::ranges::transform(sheet->nodes.end, sheet->end.begin(),
                               [](Vec3d p) { return to_float(p); });
        std::ranges::transform(sheet->end, sheet->nodes.end.begin(),
                               [](Vec3f p) { return to_double(p); });
        world.set_motion(sheet->body, sheet->nodes.start, sheet->end);
    }
    for (const Obstacle& o : obstacles) world.set_motion(o.body, o.start, o.end);
    // What was through something at an end that was tried and given up is not through it now. A
    // search as far as its depth would take long.
    if (!is_crossed) world.forget_sides();
    const StepStats& stats = world.detect();
    for (const StageTime& t : stats.stages) add_time(report.stages, t.stage, t.milliseconds);
    ++report.detections;
    report.detection_ms += milliseconds_since(begin);
}

void SheetResponse::State::count_contacts() {
    for (const Contact& c : world.contacts()) {
        if (!c.of_sheet) continue;
        ++report.contacts;
        if (c.found == Found::crossing) ++report.crossings;
        if (c.found == Found::remembered) ++report.remembered;
        if (c.found == Found::tangled) ++report.tangled;
    }
}

/// True if features have met during the step, or if one is on its wrong side.
bool SheetResponse::State::has_violation() const {
    return std::ranges::any_of(world.contacts(), [&](const Contact& c) {
        return concerns_sheet(c) && (is_met(c) || (c.distance < 0 && counts(c)));
    });
}

/// False for a contact that is only remembered, when it is known that no sheet is through anything.
bool SheetResponse::State::counts(const Contact& c) const {
    return !c.unknown_side &&
           (is_crossed || !c.of_sheet || c.found == Found::near || c.found == Found::crossing);
}

MovingPoint SheetResponse::State::vertex_motion(BodyId body, std::uint32_t vertex) const {
    if (const auto found = sheet_of.find(body); found != sheet_of.end())
        return {to_double(found->second->nodes.start[vertex]),
                to_double(found->second->end[vertex])};
    const Vec3d end = world.vertex_position(body, vertex);
    return {start_of(body, end), end};
}

/// The direction in which the contact's source must go. A vertex that meets a triangle goes back to
/// the side it came from, whatever is remembered of it: near folds, the memory may be of another
/// layer.
Vec3d SheetResponse::State::out_of(const Contact& c) const {
    const Vec3d out = c.source == Side::a ? -c.normal : c.normal;
    if (is_crossed || !is_met(c) || c.is_edge()) return out;
    const Triangle& t = world.mesh(world.mesh_of(c.target_body())).triangles()[c.triangle];
    const MovingPoint p = vertex_motion(c.source_body(), c.vertex);
    MovingPoint corner[3];
    for (int k = 0; k < 3; ++k) corner[k] = vertex_motion(c.target_body(), t.vertex[k]);
    const auto when = [&](const MovingPoint& m) { return m.start + c.time * (m.end - m.start); };
    const Vec3d at[3] = {when(corner[0]), when(corner[1]), when(corner[2])}, met = when(p);
    const Vec3d n = cross(at[1] - at[0], at[2] - at[0]);
    const double size = length_squared(n);
    if (!(size > 0)) return out;
    const double weight[2] = {dot(n, cross(at[2] - at[1], met - at[1])) / size,
                              dot(n, cross(at[0] - at[2], met - at[2])) / size};
    const auto way = [](const MovingPoint& m) { return m.end - m.start; };
    const Vec3d motion = way(p) - weight[0] * way(corner[0]) - weight[1] * way(corner[1]) -
                         (1 - weight[0] - weight[1]) * way(corner[2]);
    const double approach = dot(n, motion);
    const Vec3d end = normalized(
        cross(corner[1].end - corner[0].end, corner[2].end - corner[0].end));
    return approach < 0 ? end : approach > 0 ? -end : out;
}

/// Moves vertices out of all contacts; false if there are none.
bool SheetResponse::State::project() {
    projection.clear();
    for (Obstacle& o : obstacles) {
        o.moving.center = o.end.position;
        o.moving.shift = o.moving.turn = o.moving.impulse = {};
    }
    for (const Contact& c : world.contacts()) {
        if (!concerns_sheet(c) || !counts(c)) continue;
        const Vec3d out = out_of(c);
        double thickness = std::max(world.collision_of(c.a).thickness,
                                    world.collision_of(c.b).thickness);
        if (c.a == c.b) {
            // In a sheet with edges shorter than its thickness, neighbours may stay as close as
            // they are at rest.
            const Mesh& mesh = world.mesh(world.mesh_of(c.a));
            const auto rest = [&](std::uint32_t v) { return to_double(mesh.positions()[v]); };
            Vec3d way = c.is_edge() ? c.source_weight(0) * rest(c.vertex) +
                                          c.source_weight(1) * rest(c.edge_end)
                                    : rest(c.vertex);
            const Triangle& t = mesh.triangles()[c.triangle];
            for (int k = 0; k < 3; ++k) way -= c.barycentric[k] * rest(t.vertex[k]);
            thickness = std::min(thickness, 0.5 * length(way));
        }
        projection.add(source_point(c), target_point(c), out, thickness);
    }
    ++report.rounds;
    if (!projection.project()) return false;
    move_bodies();
    return true;
}

/// Applies what the projection has done to rigid bodies.
void SheetResponse::State::move_bodies() {
    for (Obstacle& o : obstacles) {
        o.impulse += o.moving.impulse;
        if (!(o.moving.inverse_mass > 0)) continue;
        o.end = moved(o.end, o.moving.shift, o.moving.turn);
        o.shift += o.moving.shift;
        o.turn += o.moving.turn;
    }
}

void SheetResponse::State::keep_apart() {
    detect();
    count_contacts();
    if (report.tangled == 0 && report.remembered == 0) is_crossed = false;
    if (report.tangled > 0) is_crossed = true;
    for (std::uint32_t round = 0; round < settings.rounds; ++round) {
        if (round > 0 && !has_violation()) return;
        // There is nothing that contacts could move: all that has met is led.
        if (!project()) break;
        detect();
    }
    for (std::uint32_t attempt = 0; pull_back(attempt); ++attempt) detect();
    for (const auto& sheet : sheets)
        report.pulled_back += static_cast<std::uint32_t>(
            std::ranges::count(sheet->pulled_back, true));
    if (report.crossings_left > 0) is_crossed = true;
}

void SheetResponse::State::write_step(double dt) {
    for (const auto& sheet : sheets) {
        const btScalar kept = 1 - sheet->soft->m_cfg.kDP;
        for (std::size_t i = 0; i < sheet->end.size(); ++i) {
            btSoftBody::Node& node = sheet->soft->m_nodes[static_cast<int>(i)];
            node.m_x = to_bullet(sheet->end[i]);
            node.m_v = kept * to_bullet((1 / dt) * (to_double(sheet->end[i]) -
                                                    to_double(sheet->nodes.start[i])));
        }
        sheet->nodes.start = sheet->end;
        sheet->soft->updateNormals();
    }
    for (Obstacle& o : obstacles) {
        btRigidBody& rigid = *o.rigid;
        if (o.is_held) {
            ++report.held_bodies;
            // Bullet goes on from the velocities that the body has when it is placed.
            rigid.setLinearVelocity({0, 0, 0});
            rigid.setAngularVelocity({0, 0, 0});
            rigid.setCenterOfMassTransform(to_bullet(o.start));
            o.end = from_bullet(rigid.getWorldTransform());
        } else if (o.moving.inverse_mass > 0 && !(o.shift == Vec3d{} && o.turn == Vec3d{})) {
            ++report.moved_bodies;
            rigid.setLinearVelocity(rigid.getLinearVelocity() + to_bullet((1 / dt) * o.shift));
            rigid.setAngularVelocity(rigid.getAngularVelocity() + to_bullet((1 / dt) * o.turn));
            rigid.setCenterOfMassTransform(to_bullet(o.end));
            // The next step begins with the pose as Bullet stores it.
            o.end = from_bullet(rigid.getWorldTransform());
        }
        const double speed = length(o.impulse) * static_cast<double>(rigid.getInvMass()) / dt;
        if (!rigid.isActive() && speed > static_cast<double>(rigid.getLinearSleepingThreshold()))
            rigid.activate(true);
    }
}

SheetResponse::SheetResponse(World& world, SheetSettings settings)
    : state_(new State{.world = world,
                       .settings = settings,
                       .projection = SheetProjection(settings.projection),
                       .sheets = {},
                       .obstacles = {},
                       .sheet_of = {},
                       .obstacle_of = {},
                       .report = {}}) {}
SheetResponse::~SheetResponse() = default;

void SheetResponse::bind(btSoftBody& soft, BodyId body) {
    const Mesh& mesh = state_->world.mesh(state_->world.mesh_of(body));
    const std::size_t count = mesh.positions().size();
    if (static_cast<std::size_t>(soft.m_nodes.size()) != count)
        throw InputError("soft body has " + std::to_string(soft.m_nodes.size()) + " nodes, mesh '" +
                         mesh.name() + "' has " + std::to_string(count) + " vertices");
    auto sheet = std::make_unique<Sheet>();
    sheet->soft = &soft;
    sheet->body = body;
    sheet->nodes.end.resize(count);
    sheet->nodes.inverse_mass.resize(count);
    sheet->end.resize(count);
    for (std::size_t i = 0; i < count; ++i)
        sheet->nodes.start.push_back(from_bullet_float(soft.m_nodes[static_cast<int>(i)].m_x));
    state_->unbind(soft, body);
    state_->sheet_of[body] = sheet.get();
    state_->sheets.push_back(std::move(sheet));
}

void SheetResponse::bind(btRigidBody& rigid, BodyId body) {
    if (state_->world.motion_of(body) == Motion::deforming)
        throw InputError("body " + std::to_string(body.index) +
                         " deforms: it can follow a soft body only");
    state_->unbind(rigid, body);
    state_->obstacle_of[body] = state_->obstacles.size();
    const Pose pose = from_bullet(rigid.getWorldTransform());
    state_->obstacles.push_back({.rigid = &rigid,
                                 .body = body,
                                 .start = pose,
                                 .end = pose,
                                 .moving = {},
                                 .shift = {},
                                 .turn = {},
                                 .impulse = {}});
}

void SheetResponse::unbind(const btCollisionObject& object) { state_->unbind(object, {}); }

/// Forgets what is bound to an object, and what is bound to a body.
void SheetResponse::State::unbind(const btCollisionObject& object, BodyId body) {
    std::erase_if(sheets,
                  [&](const auto& sheet) { return sheet->soft == &object || sheet->body == body; });
    std::erase_if(obstacles,
                  [&](const Obstacle& o) { return o.rigid == &object || o.body == body; });
    sheet_of.clear();
    for (const auto& sheet : sheets) sheet_of[sheet->body] = sheet.get();
    obstacle_of.clear();
    for (std::size_t i = 0; i < obstacles.size(); ++i) obstacle_of[obstacles[i].body] = i;
}

const SheetReport& SheetResponse::finish_step(double dt) {
    if (!(dt > 0) || std::isinf(dt))
        throw InputError("a step needs a time that is positive and finite");
    const auto begin = Clock::now();
    State& s = *state_;
    s.report = {};
    s.read_step();
    s.keep_apart();
    s.write_step(dt);
    s.report.response_ms = milliseconds_since(begin) - s.report.detection_ms;
    return s.report;
}

const SheetReport& SheetResponse::report() const { return state_->report; }

}  // namespace pierce::bullet
