#include "fuzz/generator.hpp"

#include <cmath>
#include <limits>

#include "fuzz/shapes.hpp"

namespace pierce::fuzz {
namespace {

using Kind = Call::Kind;

/// What the generator knows of a body it has added.
struct KnownBody {
    std::uint32_t mesh = 0;
    Motion motion = Motion::fixed;
    Pose pose;
    std::vector<Vec3f> positions;
    bool is_sheet = false;
};

class Generator {
public:
    explicit Generator(Choices& choices) : choices_(choices) {}

    Program run() {
        choose_settings();
        scale_ = choices_.pick({1.0, 1.0, 1.0, 1.0, 1e-3, 1e3, 0x1p20, 1e-6});
        offset_ = choices_.pick({0.0, 0.0, 0.0, 0.0, 0.0, 100.0, 1e5, 1e7});
        on_grid_ = choices_.one_in(3);
        likes_sheets_ = choices_.one_in(3);
        likes_worlds_ = choices_.one_in(5);
        // Some worlds are as people make them: truth has more to say of these.
        is_tame_ = choices_.one_in(3);
        if (is_tame_) scale_ = 1, offset_ = 0, on_grid_ = false;
        if (choices_.one_in(4)) program_.settings.margin = scale_ * choices_.pick({0.01, 0.1, 0.5});
        const std::uint32_t meshes = 1 + choices_.below(3), bodies = 2 + choices_.below(3);
        for (std::uint32_t m = 0; m < meshes; ++m) add_mesh();
        for (std::uint32_t b = 0; b < bodies; ++b) add_body();
        const std::uint32_t steps = 1 + choices_.below(6);
        detect();
        for (std::uint32_t s = 1; s < steps; ++s) {
            // What happens to worlds shows best where nothing else happens.
            if (!likes_worlds_ || choices_.one_in(2)) move_all();
            const auto changes = likes_worlds_ ? choices_.pick({1u, 1u, 2u, 4u})
                                               : choices_.pick({0u, 0u, 0u, 1u, 1u, 2u, 4u});
            for (std::uint32_t left = changes; left > 0; --left) change_something();
            detect();
        }
        return std::move(program_);
    }

private:
    void choose_settings() {
        Settings& s = program_.settings;
        s.coverage = choices_.pick({Coverage::vertices, Coverage::overlaps, Coverage::complete});
        s.reproject = choices_.one_in(3);
        s.temporal = choices_.pick(
            {Temporal::certified, Temporal::certified, Temporal::off, Temporal::paper});
        s.predict = !choices_.one_in(4);
        s.may_rest = choices_.one_in(3);
        if (choices_.one_in(4)) s.prediction_distance = choices_.pick({0.0, 0.1, 10.0});
        if (choices_.one_in(4)) s.full_every = 1 + choices_.below(4);
        if (choices_.one_in(4)) s.walk_threshold = choices_.pick({0.0, 0.5, 100.0});
        if (choices_.one_in(4)) s.open_body_range = choices_.pick({0.1, 100.0});
        if (!choices_.one_in(100)) return;
        // To be refused.
        switch (choices_.below(4)) {
            case 0:
                s.open_body_range = -1;
                break;
            case 1:
                s.full_every = 0;
                break;
            case 2:
                s.walk_threshold = -1;
                break;
            default:
                s.prediction_distance = std::numeric_limits<double>::quiet_NaN();
        }
    }

    Call& push(Kind kind) {
        program_.calls.emplace_back();
        program_.calls.back().kind = kind;
        return program_.calls.back();
    }
    void detect() { push(Kind::detect); }

    void add_mesh() {
        Call& call = push(Kind::add_mesh);
        call.data = is_tame_ ? proper_mesh(choices_) : any_mesh(choices_);
        for (Vec3f& p : call.data.positions) p = to_float(scale_ * to_double(p));
        if (choices_.one_in(8))
            call.inside = choices_.pick({Inside::closed, Inside::winding, Inside::none});
        meshes_.push_back(call.data);
    }

    /// A mesh from another one: some triangles are others, and one may be gone.
    void change_mesh() {
        const std::uint32_t before = any_mesh_number();
        if (meshes_[before].triangles.empty() || meshes_[before].positions.empty())
            return add_mesh();
        Call& call = push(Kind::add_mesh);
        call.before = before;
        call.data = meshes_[before];
        std::vector<Triangle>& triangles = call.data.triangles;
        const auto any = [&] {
            return choices_.below(static_cast<std::uint32_t>(triangles.size()));
        };
        for (std::uint32_t changes = choices_.below(3) + 1; changes > 0; --changes) {
            const std::uint32_t t = any(), k = choices_.below(3);
            switch (choices_.below(3)) {
                case 0:
                    if (triangles.size() > 1) triangles.erase(triangles.begin() + t);
                    break;
                case 1: {
                    const auto v = static_cast<std::uint32_t>(call.data.positions.size());
                    call.data.positions.push_back(
                        call.data.positions[triangles[t].vertex[k] % call.data.positions.size()]);
                    triangles[t].vertex[k] = v;
                    break;
                }
                default:
                    std::swap(triangles[t].vertex[0], triangles[any()].vertex[k]);
            }
        }
        meshes_.push_back(call.data);
    }

    std::uint32_t any_mesh_number() {
        return choices_.below(static_cast<std::uint32_t>(meshes_.size()));
    }
    std::uint32_t any_body_number() {
        return choices_.below(static_cast<std::uint32_t>(bodies_.size()));
    }

    double coordinate() {
        return on_grid_ ? 0.25 * (static_cast<double>(choices_.below(9)) - 4)
                        : choices_.real(-1.2, 1.2);
    }

    Pose any_pose() {
        Pose pose;
        pose.position = {offset_ + scale_ * coordinate(), scale_ * coordinate(),
                         scale_ * coordinate()};
        switch (on_grid_ ? choices_.below(4) : 4 + choices_.below(2)) {
            case 0:
            case 5:
                break;
            case 1:
                pose.rotation = choices_.pick<Quaternion>(
                    {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}});
                break;
            case 2:
                pose.rotation = choices_.pick<Quaternion>(
                    {{1, 0, 0, 1}, {0, 1, 0, 1}, {0, 0, 1, 1}});
                break;
            case 3:
                pose.rotation = {1, 1, 1, 1};
                break;
            default:
                pose.rotation = {choices_.real(-1, 1), choices_.real(-1, 1), choices_.real(-1, 1),
                                 choices_.real(0.1, 1)};
        }
        if (!is_tame_ && choices_.one_in(60)) spoil(pose);
        return pose;
    }

    void spoil(Pose& pose) {
        switch (choices_.below(5)) {
            case 0:
                pose.position.x = std::numeric_limits<double>::quiet_NaN();
                break;
            case 1:
                pose.position.z = std::numeric_limits<double>::infinity();
                break;
            case 2:
                pose.rotation = {0, 0, 0, 0};
                break;
            case 3:
                pose.position.y = choices_.pick({1e20, 1e30, 3e38, 1e39, 1e300});
                break;
            default:
                pose.rotation = {1e-200, 0, 0, 1e-200};
        }
    }

    std::vector<Vec3f> placed(std::uint32_t mesh, const Pose& pose) {
        std::vector<Vec3f> positions;
        const Frame frame = frame_of(pose);
        for (const Vec3f& p : meshes_[mesh].positions)
            positions.push_back(to_float(frame.to_parent(to_double(p))));
        return positions;
    }

    /// Where the vertices of a body may be.
    std::vector<Vec3f> any_positions(std::uint32_t mesh, const std::vector<Vec3f>* before) {
        std::vector<Vec3f> p = before != nullptr &&
                                       before->size() == meshes_[mesh].positions.size() &&
                                       !choices_.one_in(3)
                                   ? *before
                                   : placed(mesh, any_pose());
        const auto size = static_cast<std::uint32_t>(p.size());
        if (size == 0) return p;
        const double step = scale_ * (is_tame_ ? choices_.pick({0.0, 0.01, 0.05})
                                               : choices_.pick({0.0, 0.01, 0.1, 0.5}));
        const auto some = [&] {
            return step *
                   (on_grid_ ? static_cast<double>(choices_.below(3)) - 1 : choices_.real(-1, 1));
        };
        switch (choices_.below(is_tame_ ? 4 : 8)) {
            case 0:
                break;
            case 1: {
                const Vec3d way{some(), some(), some()};
                for (Vec3f& v : p) v = to_float(to_double(v) + way);
                break;
            }
            case 2:
                for (Vec3f& v : p) v = to_float(to_double(v) + Vec3d{some(), some(), some()});
                break;
            case 3:
                for (Vec3f& v : p)
                    v.z += static_cast<float>(step *
                                              std::sin(3 * static_cast<double>(v.x) / scale_));
                break;
            case 4:
                p[choices_.below(size)] = to_float(
                    {offset_ + scale_ * coordinate(), scale_ * coordinate(), 0});
                break;
            case 5:
                p[choices_.below(size)] = p[choices_.below(size)];
                break;
            case 6: {
                const std::uint32_t axis = choices_.below(3);
                for (Vec3f& v : p)
                    (axis == 0 ? v.x : axis == 1 ? v.y : v.z) *= choices_.pick({-1.f, 0.5f, 0.f});
                break;
            }
            default:
                if (choices_.one_in(4))
                    p.assign(size, p[0]);
                else
                    for (Vec3f& v : p) v = to_float(to_double(v) + Vec3d{some(), some(), some()});
        }
        if (is_tame_) return p;
        if (choices_.one_in(40))
            p[choices_.below(size)].x = choices_.pick({std::numeric_limits<float>::quiet_NaN(),
                                                       std::numeric_limits<float>::infinity(),
                                                       1e20f, 3e38f});
        if (choices_.one_in(200)) p.pop_back();  // to be refused
        return p;
    }

    void add_body() {
        KnownBody body;
        body.mesh = any_mesh_number();
        body.motion = choices_.pick(
            {Motion::fixed, Motion::rigid, Motion::rigid, Motion::deforming, Motion::deforming});
        body.pose = any_pose();
        Call& call = push(body.motion == Motion::fixed   ? Kind::add_fixed_body
                          : body.motion == Motion::rigid ? Kind::add_rigid_body
                                                         : Kind::add_deforming_body);
        call.mesh = body.mesh;
        call.pose = body.pose;
        if (body.motion == Motion::deforming)
            call.positions = body.positions = any_positions(body.mesh, nullptr);
        bodies_.push_back(body);
        if (body.motion == Motion::deforming && choices_.one_in(likes_sheets_ ? 2 : 6))
            set_collision(static_cast<std::uint32_t>(bodies_.size()) - 1);
        if (likes_worlds_) {
            Call& filter = push(Kind::set_filter);
            filter.body = static_cast<std::uint32_t>(bodies_.size()) - 1;
            filter.filter.world = choices_.pick({0, 0, 1, -1});
        }
    }

    void set_collision(std::uint32_t body) {
        Call& call = push(Kind::set_collision);
        call.body = body;
        if (choices_.one_in(3)) call.collision.margin = scale_ * choices_.pick({0.0, 0.05, 0.3});
        if (choices_.one_in(100)) call.collision.margin = std::nan("");
        if (bodies_[body].motion != Motion::deforming && !choices_.one_in(6)) return;
        call.collision.sheet = likes_sheets_ || choices_.one_in(2);
        call.collision.self = choices_.pick({SelfCollision::on, SelfCollision::on,
                                             SelfCollision::off, SelfCollision::rays,
                                             SelfCollision::published});
        if (!call.collision.sheet && !choices_.one_in(10))
            call.collision.self = choices_.pick({SelfCollision::on, SelfCollision::off});
        if (call.collision.sheet)
            call.collision.thickness = scale_ * choices_.pick({0.0, 0.01, 0.1, 1.0});
        if (choices_.one_in(100))
            call.collision.thickness = choices_.pick({-1.0, HUGE_VAL, std::nan("")});
        bodies_[body].is_sheet = call.collision.sheet;
    }

    void move_all() {
        for (std::uint32_t b = 0; b < bodies_.size(); ++b)
            if (!choices_.one_in(3)) move(b);
    }

    void move(std::uint32_t b) {
        KnownBody& body = bodies_[b];
        const bool with_start = choices_.one_in(6);
        if (body.motion == Motion::deforming) {
            const std::vector<Vec3f> before = body.positions;
            Call& call = push(with_start ? Kind::set_position_motion : Kind::set_positions);
            call.body = b;
            if (with_start) call.start = any_positions(body.mesh, &before);
            call.positions = body.positions = any_positions(body.mesh, &before);
            return;
        }
        Pose pose = body.pose;
        const double step = scale_ * choices_.pick({0.0, 0.001, 0.05, 0.25});
        if (choices_.one_in(4))
            pose = any_pose();
        else if (on_grid_)
            pose.position.z += 0.25 * scale_ * (static_cast<double>(choices_.below(3)) - 1);
        else
            pose.position += Vec3d{choices_.real(-step, step), choices_.real(-step, step),
                                   choices_.real(-step, step)};
        Call& call = push(with_start ? Kind::set_pose_motion : Kind::set_pose);
        call.body = b;
        if (with_start) call.start_pose = choices_.one_in(2) ? any_pose() : body.pose;
        call.pose = body.pose = pose;
    }

    void change_something() {
        if (likes_worlds_ && !choices_.one_in(3)) return change_worlds();
        switch (choices_.below(26)) {
            case 0:
                if (choices_.one_in(2))
                    add_mesh();
                else
                    change_mesh();
                break;
            case 1:
            case 2:
                add_body();
                break;
            case 3:
            case 4:
                push(Kind::remove_body).body = any_body_number();
                break;
            case 5:
                push(Kind::remove_mesh).mesh = any_mesh_number();
                break;
            case 6:
            case 7:
                set_collision(any_body_number());
                break;
            case 8:
                push(Kind::forget_sides);
                break;
            case 9:
            case 10: {
                const std::uint32_t b = any_body_number(), mesh = any_mesh_number();
                Call& call = push(Kind::set_mesh);
                call.body = b;
                call.mesh = bodies_[b].mesh = mesh;
                if (bodies_[b].motion == Motion::deforming || choices_.one_in(8))
                    call.positions = bodies_[b].positions = any_positions(mesh, nullptr);
                break;
            }
            case 11: {
                Call& call = push(Kind::explain);
                call.body = any_body_number();
                call.other = any_body_number();
                call.vertex = choices_.below(10);
                break;
            }
            case 12: {
                Call& call = push(Kind::cast_rays);
                call.pose = any_pose();
                for (int k = 0; k < 4; ++k)
                    call.positions.push_back(to_float({coordinate(), coordinate(), coordinate()}));
                break;
            }
            case 13:
                detect();
                break;
            case 14:
                push(Kind::restore);
                break;
            case 15:
            case 16: {
                Call& call = push(Kind::set_filter);
                call.body = any_body_number();
                call.filter = {.groups = 1u << choices_.below(2),
                               .meets = choices_.pick({~0u, ~0u, 1u, 2u}),
                               .chain = choices_.below(3),
                               .world = choices_.pick({-1, -1, 0, 1, 7})};
                if (choices_.one_in(50)) call.filter.world = choices_.pick({-2, 1 << 20});
                break;
            }
            case 17:
            case 18:
                change_worlds();
                break;
            case 19:
            case 20:
                ask_of_pair();
                break;
            case 21: {
                Call& call = push(Kind::probe);
                for (int k = 0; k < 4; ++k) {
                    call.positions.push_back(to_float(any_pose().position));
                    call.start.push_back(to_float({coordinate(), coordinate(), coordinate()}));
                }
                call.radius = scale_ * choices_.pick({0.0, 0.5, 10.0});
                break;
            }
            case 22:
                push(Kind::impacts).count = choices_.pick({1u, 4u});
                break;
            case 23:
            case 24: {
                Call& call = push(choices_.one_in(3) ? Kind::include : Kind::exclude);
                call.body = any_body_number();
                call.other = any_body_number();
                break;
            }
            default:
                move(any_body_number());
        }
    }

    std::int32_t any_world() {
        return likes_worlds_ ? choices_.pick({0, 0, 1, 1, 2, -1}) : choices_.pick({0, 1, 7, 8});
    }

    void change_worlds() {
        switch (choices_.below(6)) {
            case 0:
                // Each time there are more bodies, which take time.
                if (has_copies_) return;
                has_copies_ = true;
                {
                    Call& call = push(Kind::replicate);
                    call.world = any_world();
                    call.count = choices_.pick({1u, 2u, 0u});
                }
                break;
            case 1:
            case 2: {
                Call& call = push(Kind::set_world_active);
                call.world = any_world();
                call.active = choices_.one_in(2);
                break;
            }
            case 3: {
                Call& call = push(Kind::set_filter);
                call.body = any_body_number();
                call.filter.world = any_world();
                break;
            }
            case 4: {
                Call& call = push(Kind::copy_places);
                call.world = any_world();
                call.other_world = any_world();
                break;
            }
            default:
                push(Kind::remove_world).world = any_world();
        }
    }

    void ask_of_pair() {
        Call& call = push(choices_.one_in(4) ? Kind::parting : Kind::overlap);
        call.body = any_body_number();
        call.other = any_body_number();
    }

    Choices& choices_;
    Program program_;
    std::vector<MeshData> meshes_;
    std::vector<KnownBody> bodies_;
    double scale_ = 1, offset_ = 0;
    bool on_grid_ = false, likes_sheets_ = false, likes_worlds_ = false, is_tame_ = false;
    bool has_copies_ = false;
};

}  // namespace

Program random_program(Choices& choices) { return Generator(choices).run(); }

}  // namespace pierce::fuzz
