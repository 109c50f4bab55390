#include "fuzz/shrink.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

namespace pierce::fuzz {
namespace {

using Kind = Call::Kind;

bool adds_body(const Call& c) {
    return c.kind == Kind::add_fixed_body || c.kind == Kind::add_rigid_body ||
           c.kind == Kind::add_deforming_body;
}
bool names_mesh(const Call& c) {
    return adds_body(c) || c.kind == Kind::remove_mesh || c.kind == Kind::set_mesh;
}
bool names_two(const Call& c) {
    switch (c.kind) {
        case Kind::explain:
        case Kind::exclude:
        case Kind::include:
        case Kind::overlap:
        case Kind::parting:
            return true;
        default:
            return false;
    }
}

bool names_body(const Call& c) {
    switch (c.kind) {
        case Kind::remove_body:
        case Kind::set_collision:
        case Kind::set_pose:
        case Kind::set_positions:
        case Kind::set_pose_motion:
        case Kind::set_position_motion:
        case Kind::set_mesh:
        case Kind::set_filter:
            return true;
        default:
            return names_two(c);
    }
}

/// Without some calls, nor those that name what these would have added; the rest is numbered anew.
Program without(const Program& program, std::size_t begin, std::size_t end) {
    Program rest;
    rest.settings = program.settings;
    std::vector<std::optional<std::uint32_t>> mesh, body;
    std::uint32_t meshes = 0, bodies = 0;
    const auto known = [](const std::vector<std::optional<std::uint32_t>>& numbers,
                          std::uint32_t number) {
        return number < numbers.size() && numbers[number].has_value();
    };
    for (std::size_t i = 0; i < program.calls.size(); ++i) {
        Call c = program.calls[i];
        const bool keep = (i < begin || i >= end) && (!names_mesh(c) || known(mesh, c.mesh)) &&
                          (!names_body(c) || known(body, c.body)) &&
                          (!names_two(c) || known(body, c.other));
        if (c.before != Call::no_mesh)
            c.before = known(mesh, c.before) ? *mesh[c.before] : Call::no_mesh;
        if (c.kind == Kind::add_mesh) mesh.push_back(keep ? std::optional(meshes++) : std::nullopt);
        if (keep && names_mesh(c)) c.mesh = *mesh[c.mesh];
        if (adds_body(c)) body.push_back(keep ? std::optional(bodies++) : std::nullopt);
        if (!keep) continue;
        if (names_body(c)) c.body = *body[c.body];
        if (names_two(c)) c.other = *body[c.other];
        rest.calls.push_back(std::move(c));
    }
    return rest;
}

class Shrinker {
public:
    Shrinker(Program program, const std::function<bool(const Program&)>& fails)
        : best_(std::move(program)), fails_(fails) {}

    Program run() {
        do {
            improved_ = false;
            drop_calls();
            simplify_settings();
            drop_triangles();
            simplify_numbers();
        } while (improved_);
        return best_;
    }

private:
    bool take(Program tried) {
        if (!fails_(tried)) return false;
        best_ = std::move(tried);
        improved_ = true;
        return true;
    }

    void drop_calls() {
        for (std::size_t size = std::max<std::size_t>(best_.calls.size() / 2, 1); size > 0;
             size /= 2)
            for (std::size_t end = best_.calls.size(); end > 0;) {
                const std::size_t begin = end > size ? end - size : 0;
                take(without(best_, begin, std::min(end, best_.calls.size())));
                end = std::min(begin, best_.calls.size());
            }
    }

    template <class Change>
    void try_with(const Change& change) {
        Program tried = best_;
        if (change(tried)) take(std::move(tried));
    }

    template <class T>
    void try_setting(T Settings::*member, T value) {
        try_with([&](Program& p) { return std::exchange(p.settings.*member, value) != value; });
    }

    void simplify_settings() {
        const Settings plain;
        try_setting(&Settings::coverage, plain.coverage);
        try_setting(&Settings::reproject, plain.reproject);
        try_setting(&Settings::temporal, Temporal::off);
        try_setting(&Settings::predict, plain.predict);
        try_setting(&Settings::may_rest, false);
        try_setting(&Settings::prediction_distance, plain.prediction_distance);
        try_setting(&Settings::full_every, plain.full_every);
        try_setting(&Settings::walk_threshold, plain.walk_threshold);
        try_setting(&Settings::open_body_range, plain.open_body_range);
    }

    void drop_triangles() {
        for (std::size_t i = 0; i < best_.calls.size(); ++i)
            for (std::size_t t = best_.calls[i].data.triangles.size(); t-- > 0;)
                try_with([&](Program& p) {
                    auto& triangles = p.calls[i].data.triangles;
                    if (triangles.size() < 2 || t >= triangles.size()) return false;
                    triangles.erase(triangles.begin() + static_cast<std::ptrdiff_t>(t));
                    return true;
                });
    }

    /// Fewer digits, where that is still the same failure.
    void simplify_numbers() {
        for (std::size_t i = 0; i < best_.calls.size(); ++i) {
            for (const auto member : {&Call::pose, &Call::start_pose}) {
                try_with([&](Program& p) {
                    return std::exchange((p.calls[i].*member).rotation, {}) != Quaternion{};
                });
                for (int k = 0; k < 3; ++k)
                    for (double step : {1e9, 1.0, 0.25, 0.01})
                        try_with([&](Program& p) {
                            return round((p.calls[i].*member).position[k], step);
                        });
            }
            for (double step : {1.0, 0.25, 0.01})
                for (const auto member : {&Call::positions, &Call::start})
                    try_with([&](Program& p) { return round(p.calls[i].*member, step); });
            for (double step : {1.0, 0.25, 0.01})
                try_with([&](Program& p) { return round(p.calls[i].data.positions, step); });
        }
    }

    static bool round(double& x, double step) {
        const double rounded = std::round(x / step) * step;
        if (!(std::fabs(rounded) < 1e6) || rounded == x) return false;
        x = rounded;
        return true;
    }
    static bool round(std::vector<Vec3f>& points, double step) {
        bool any = false;
        for (Vec3f& p : points) {
            const Vec3f before = p;
            Vec3d wide = to_double(p);
            for (int k = 0; k < 3; ++k) round(wide[k], step);
            p = to_float(wide);
            any = any || p != before;  // in float32: what is rounded once stays as it is
        }
        return any;
    }

    Program best_;
    const std::function<bool(const Program&)>& fails_;
    bool improved_ = false;
};

}  // namespace

Program shrunk(Program program, const std::function<bool(const Program&)>& fails) {
    return Shrinker(std::move(program), fails).run();
}

}  // namespace pierce::fuzz
