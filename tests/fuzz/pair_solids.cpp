#include "fuzz/pair_solids.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>

#include "fuzz/shapes.hpp"
#include "fuzz/solid_surface.hpp"
#include "pierce/box.hpp"
#include "pierce/constants.hpp"
#include "scenes/named/shapes.hpp"

namespace pierce::fuzz {
namespace {

constexpr std::size_t most_triangles = 200;

/// A place in the plane of an outline.
using Place = std::array<double, 2>;
using Outline = std::vector<Place>;

double turn(const Place& a, const Place& b, const Place& c) {
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
}

/// Triangles of a simple outline that goes around counterclockwise: one corner after the other is
/// cut off.
std::vector<Triangle> triangles_of(const Outline& outline) {
    std::vector<std::uint32_t> left(outline.size());
    for (std::uint32_t k = 0; k < left.size(); ++k) left[k] = k;
    std::vector<Triangle> triangles;
    while (left.size() > 3) {
        const std::size_t before = left.size();
        for (std::size_t k = 0; k < left.size(); ++k) {
            const std::uint32_t u = left[(k + left.size() - 1) % left.size()], v = left[k],
                                w = left[(k + 1) % left.size()];
            const Place &a = outline[u], &b = outline[v], &c = outline[w];
            if (turn(a, b, c) <= 0) continue;
            const bool is_free = std::ranges::none_of(left, [&](std::uint32_t other) {
                const Place& p = outline[other];
                return other != u && other != v && other != w && turn(a, b, p) >= 0 &&
                       turn(b, c, p) >= 0 && turn(c, a, p) >= 0;
            });
            if (!is_free) continue;
            triangles.push_back({{u, v, w}});
            left.erase(left.begin() + static_cast<std::ptrdiff_t>(k));
            break;
        }
        if (left.size() == before) return {};
    }
    triangles.push_back({{left[0], left[1], left[2]}});
    return triangles;
}

/// The outline drawn out along z.
MeshData prism(const Outline& outline) {
    MeshData m;
    const auto n = static_cast<std::uint32_t>(outline.size());
    for (double z : {0.0, 1.0})
        for (const Place& p : outline) m.positions.push_back(to_float({p[0], p[1], z}));
    for (std::uint32_t k = 0; k < n; ++k) {
        const std::uint32_t next = (k + 1) % n;
        m.triangles.push_back({{k, next, next + n}});
        m.triangles.push_back({{k, next + n, k + n}});
    }
    for (const Triangle& t : triangles_of(outline)) {
        m.triangles.push_back({{t.vertex[0], t.vertex[2], t.vertex[1]}});
        m.triangles.push_back({{t.vertex[0] + n, t.vertex[1] + n, t.vertex[2] + n}});
    }
    return m;
}

/// Corners on a circle; every other one may be further in.
Outline around(std::uint32_t corners, double inner) {
    Outline outline;
    for (std::uint32_t k = 0; k < corners; ++k) {
        const double angle = 2 * std::numbers::pi * k / corners, r = k % 2 == 0 ? 1 : inner;
        outline.push_back({r * std::cos(angle), r * std::sin(angle)});
    }
    return outline;
}

Outline letter(Choices& choices) {
    switch (choices.below(5)) {
        case 0:
            return {{0, 0}, {1, 0}, {1, 0.25}, {0.25, 0.25}, {0.25, 1}, {0, 1}};  // L
        case 1:
            return {{0.375, 0}, {0.625, 0}, {0.625, 0.75}, {1, 0.75},
                    {1, 1},     {0, 1},     {0, 0.75},     {0.375, 0.75}};  // T
        case 2:
            return {{0, 0}, {0.75, 0}, {0.75, 0.5}, {1, 0.5},
                    {1, 1}, {0.5, 1},  {0.5, 0.25}, {0, 0.25}};  // Z
        case 3:
            return {{0, 0},       {1, 0},       {1, 1},    {0.75, 1},
                    {0.75, 0.25}, {0.25, 0.25}, {0.25, 1}, {0, 1}};  // U
        default:
            return {{0.25, 0},   {0.5, 0},   {0.5, 0.25}, {1, 0.25},
                    {1, 0.5},    {0.5, 0.5}, {0.5, 1},    {0.25, 1},
                    {0.25, 0.5}, {0, 0.5},   {0, 0.25},   {0.25, 0.25}};  // a cross
    }
}

MeshData bipyramid(std::uint32_t corners) {
    MeshData m;
    for (const Place& p : around(corners, 1)) m.positions.push_back(to_float({p[0], p[1], 0}));
    m.positions.push_back({0, 0, 1});
    m.positions.push_back({0, 0, -1});
    for (std::uint32_t k = 0; k < corners; ++k) {
        const std::uint32_t next = (k + 1) % corners;
        m.triangles.push_back({{k, next, corners}});
        m.triangles.push_back({{next, k, corners + 1}});
    }
    return m;
}

MeshData tetrahedron(Choices& choices) {
    MeshData m;
    for (int k = 0; k < 4; ++k)
        m.positions.push_back(
            to_float({choices.real(0, 1), choices.real(0, 1), choices.real(0, 1)}));
    m.triangles = {{{0, 2, 1}}, {{0, 1, 3}}, {{0, 3, 2}}, {{1, 2, 3}}};
    const auto at = [&](int k) { return to_double(m.positions[static_cast<std::size_t>(k)]); };
    if (dot(cross(at(1) - at(0), at(2) - at(0)), at(3) - at(0)) < 0)
        std::swap(m.positions[0], m.positions[1]);
    return m;
}

MeshData bumpy_sphere(Choices& choices) {
    MeshData m = scenes::sphere(1, static_cast<int>(choices.below(2)));
    const double least = choices.pick({1.0, 0.9, 0.5, 0.25});
    for (Vec3f& p : m.positions) p = to_float(choices.real(least, 1) * to_double(p));
    return m;
}

void move(MeshData& mesh, Vec3d by) {
    for (Vec3f& p : mesh.positions) p = to_float(to_double(p) + by);
}

MeshData part(Choices& choices) {
    switch (choices.below(10)) {
        case 0:
            return proper_mesh(choices);
        case 1:
            return tetrahedron(choices);
        case 2:
            return scenes::box({0, 0, 0}, {1, 1, 1});
        case 3:
            return prism(around(3 + choices.below(10), 1));
        case 4:
            return bipyramid(3 + choices.below(10));
        case 5:
            return scenes::sphere(1, static_cast<int>(choices.below(2)));
        case 6:
            return bumpy_sphere(choices);
        case 7:
            return scenes::torus(0.7, choices.real(0.1, 0.35), 4 + choices.below(7),
                                 3 + choices.below(6));
        case 8:
            return prism(around(2 * (3 + choices.below(6)), choices.real(0.25, 0.9)));
        default:
            return prism(letter(choices));
    }
}

MeshData any_solid(Choices& choices) {
    MeshData m = part(choices);
    if (choices.one_in(8)) {
        // More parts, beside each other.
        for (std::uint32_t left = 1 + choices.below(2); left > 0; --left) {
            MeshData more = part(choices);
            Box all, one;
            for (Vec3f p : m.positions) all.extend(to_double(p));
            for (Vec3f p : more.positions) one.extend(to_double(p));
            const std::uint32_t axis = choices.below(3);
            Vec3d by{choices.pick({0.0, 0.25, -0.25}), choices.pick({0.0, 0.25, -0.25}), 0};
            by[static_cast<int>(axis)] = all.upper[static_cast<int>(axis)] -
                                         one.lower[static_cast<int>(axis)] +
                                         choices.pick({0.0625, 0.25});
            move(more, by);
            m = scenes::joined(std::move(m), more);
        }
    } else if (choices.one_in(20)) {
        // A cavity in a box.
        MeshData hole = part(choices);
        for (Triangle& t : hole.triangles) std::swap(t.vertex[1], t.vertex[2]);
        m = scenes::joined(scenes::box({-2, -2, -2}, {2, 2, 2}), hole);
    }
    return m;
}

void stretch(MeshData& mesh, Choices& choices) {
    Vec3d scale{1, 1, 1};
    const std::uint32_t how = choices.below(3);
    if (how == 0) return;
    for (int k = 0; k < 3; ++k) scale[k] = choices.pick({1.0, 1.0, 0.5, 0.25, 0.0625, 2.0});
    const Matrix3 before = how == 1 ? Matrix3{} : rotation_matrix(random_rotation(choices));
    for (Vec3f& p : mesh.positions) {
        const Vec3d q = before * to_double(p);
        p = to_float({scale.x * q.x, scale.y * q.y, scale.z * q.z});
    }
}

}  // namespace

Quaternion random_rotation(Choices& choices) {
    return {choices.real(-1, 1), choices.real(-1, 1), choices.real(-1, 1), choices.real(0.1, 1)};
}

double extent_of(const MeshData& mesh) {
    Box box;
    for (Vec3f p : mesh.positions) box.extend(to_double(p));
    return box.extent();
}

MeshData random_solid(Choices& choices) {
    for (int tries = 0; tries < 8; ++tries) {
        MeshData mesh = any_solid(choices);
        stretch(mesh, choices);
        SolidSurface surface{{}, mesh.triangles};
        for (Vec3f p : mesh.positions) surface.points.push_back(to_double(p));
        if (mesh.triangles.size() <= most_triangles &&
            surface.is_proper(4 * constants::touch_tolerance * extent_of(mesh)))
            return mesh;
    }
    return scenes::box({0, 0, 0}, {1, 1, 1});
}

}  // namespace pierce::fuzz
