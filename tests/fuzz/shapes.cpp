#include "fuzz/shapes.hpp"

#include <cmath>
#include <limits>
#include <utility>

namespace pierce::fuzz {
namespace {

using Triangles = std::vector<Triangle>;

MeshData box() {
    MeshData m;
    for (int k = 0; k < 8; ++k)
        m.positions.push_back({k & 1 ? 1.f : 0.f, k & 2 ? 1.f : 0.f, k & 4 ? 1.f : 0.f});
    m.triangles = {{{0, 2, 3}}, {{0, 3, 1}}, {{4, 5, 7}}, {{4, 7, 6}}, {{0, 1, 5}}, {{0, 5, 4}},
                   {{2, 6, 7}}, {{2, 7, 3}}, {{0, 4, 6}}, {{0, 6, 2}}, {{1, 3, 7}}, {{1, 7, 5}}};
    return m;
}

MeshData tetrahedron() {
    return {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}},
            {{{0, 2, 1}}, {{0, 1, 3}}, {{0, 3, 2}}, {{1, 2, 3}}}};
}

MeshData octahedron() {
    return {{{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}},
            {{{0, 2, 4}},
             {{2, 1, 4}},
             {{1, 3, 4}},
             {{3, 0, 4}},
             {{2, 0, 5}},
             {{1, 2, 5}},
             {{3, 1, 5}},
             {{0, 3, 5}}}};
}

/// `columns` by `rows` squares in a plane.
MeshData plate(std::uint32_t columns, std::uint32_t rows) {
    MeshData m;
    for (std::uint32_t y = 0; y <= rows; ++y)
        for (std::uint32_t x = 0; x <= columns; ++x)
            m.positions.push_back({static_cast<float>(x) / static_cast<float>(columns),
                                   static_cast<float>(y) / static_cast<float>(rows), 0});
    for (std::uint32_t y = 0; y < rows; ++y)
        for (std::uint32_t x = 0; x < columns; ++x) {
            const std::uint32_t a = y * (columns + 1) + x, b = a + columns + 1;
            m.triangles.push_back({{a, a + 1, b + 1}});
            m.triangles.push_back({{a, b + 1, b}});
        }
    return m;
}

MeshData torus(std::uint32_t around, std::uint32_t across) {
    MeshData m;
    const double turn = 2 * 3.14159265358979323846;
    for (std::uint32_t i = 0; i < around; ++i)
        for (std::uint32_t j = 0; j < across; ++j) {
            const double u = turn * i / around, v = turn * j / across, r = 0.5 + 0.2 * std::cos(v);
            m.positions.push_back(to_float({r * std::cos(u), r * std::sin(u), 0.2 * std::sin(v)}));
            const auto id = [&](std::uint32_t p, std::uint32_t q) {
                return p % around * across + q % across;
            };
            m.triangles.push_back({{id(i, j), id(i + 1, j), id(i + 1, j + 1)}});
            m.triangles.push_back({{id(i, j), id(i + 1, j + 1), id(i, j + 1)}});
        }
    return m;
}

/// Concave: a polygon like the letter U, drawn out.
MeshData channel() {
    constexpr float outline[8][2] = {{0, 0},         {1, 0},         {1, 1},     {0.75f, 1},
                                     {0.75f, 0.25f}, {0.25f, 0.25f}, {0.25f, 1}, {0, 1}};
    MeshData m;
    for (float z : {0.f, 1.f})
        for (const auto& p : outline) m.positions.push_back({p[0], p[1], z});
    for (std::uint32_t k = 0; k < 8; ++k) {
        const std::uint32_t n = (k + 1) % 8;
        m.triangles.push_back({{k, n, n + 8}});
        m.triangles.push_back({{k, n + 8, k + 8}});
    }
    for (const auto& t :
         Triangles{{{0, 1, 4}}, {{0, 4, 5}}, {{1, 2, 3}}, {{1, 3, 4}}, {{0, 5, 6}}, {{0, 6, 7}}}) {
        m.triangles.push_back({{t.vertex[0], t.vertex[2], t.vertex[1]}});
        m.triangles.push_back({{t.vertex[0] + 8, t.vertex[1] + 8, t.vertex[2] + 8}});
    }
    return m;
}

void flip(MeshData& mesh) {
    for (Triangle& t : mesh.triangles) std::swap(t.vertex[1], t.vertex[2]);
}

void transform(MeshData& mesh, Vec3d scale, Vec3d offset) {
    for (Vec3f& p : mesh.positions)
        p = to_float(Vec3d{scale.x * static_cast<double>(p.x), scale.y * static_cast<double>(p.y),
                           scale.z * static_cast<double>(p.z)} +
                     offset);
}

void append(MeshData& mesh, const MeshData& more) {
    const auto begin = static_cast<std::uint32_t>(mesh.positions.size());
    mesh.positions.insert(mesh.positions.end(), more.positions.begin(), more.positions.end());
    for (const Triangle& t : more.triangles)
        mesh.triangles.push_back({{t.vertex[0] + begin, t.vertex[1] + begin, t.vertex[2] + begin}});
}

/// Every triangle with vertices of its own. A mesh that names vertices it does not have stays as it
/// is.
MeshData torn(const MeshData& mesh) {
    for (const Triangle& t : mesh.triangles)
        for (std::uint32_t corner : t.vertex)
            if (corner >= mesh.positions.size()) return mesh;
    MeshData m;
    for (const Triangle& t : mesh.triangles) {
        const auto v = static_cast<std::uint32_t>(m.positions.size());
        for (std::uint32_t corner : t.vertex) m.positions.push_back(mesh.positions[corner]);
        m.triangles.push_back({{v, v + 1, v + 2}});
    }
    return m;
}

MeshData soup(Choices& choices) {
    MeshData m;
    const std::uint32_t vertices = 3 + choices.below(6), triangles = 1 + choices.below(8);
    for (std::uint32_t v = 0; v < vertices; ++v)
        m.positions.push_back(
            to_float({choices.real(0, 1), choices.real(0, 1), choices.real(0, 1)}));
    for (std::uint32_t t = 0; t < triangles; ++t)
        m.triangles.push_back(
            {{choices.below(vertices), choices.below(vertices), choices.below(vertices)}});
    return m;
}

MeshData base_shape(Choices& choices) {
    switch (choices.below(12)) {
        case 0:
        case 1:
            return box();
        case 2:
            return tetrahedron();
        case 3:
            return octahedron();
        case 4:
            return plate(1, 1);
        case 5:
            return plate(1 + choices.below(4), 1 + choices.below(4));
        case 6:
            return torus(4 + choices.below(4), 3 + choices.below(3));
        case 7:
            return channel();
        case 8:
            return {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{{0, 1, 2}}}};
        case 9:
            return {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{{0, 1, 2}}, {{0, 2, 1}}}};  // a pillow
                                                                                     // without a
                                                                                     // filling
        case 10:
            return soup(choices);
        default:
            return torus(8, 6);
    }
}

void spoil(MeshData& m, Choices& choices) {
    const auto vertex = [&] {
        return choices.below(static_cast<std::uint32_t>(m.positions.size()));
    };
    const auto triangle = [&] {
        return choices.below(static_cast<std::uint32_t>(m.triangles.size()));
    };
    switch (choices.below(15)) {
        case 0:
            flip(m);
            break;
        case 1:
            m.triangles.erase(m.triangles.begin() + triangle());
            break;
        case 2: {
            Triangle& t = m.triangles[triangle()];
            std::swap(t.vertex[0], t.vertex[1]);
            break;
        }
        case 3:
            m = torn(m);
            break;
        case 4:
            m.triangles.push_back(m.triangles[triangle()]);
            break;
        case 5: {
            const std::uint32_t v = vertex();
            m.triangles.push_back({{v, v, vertex()}});
            break;
        }
        case 6: {
            const std::uint32_t v = vertex();
            m.triangles.push_back({{v, v, v}});
            break;
        }
        case 7:
            m.positions.push_back({3, 3, 3});
            break;  // no triangle's
        case 8:
            m.positions[vertex()] = m.positions[vertex()];
            break;
        case 9: {
            MeshData other = base_shape(choices);
            transform(other, {0.5, 0.5, 0.5}, {choices.pick({0.25, 0.5, 1.0, 2.0}), 0.25, 0.25});
            if (choices.one_in(2)) flip(other);  // a cavity, if it is inside
            append(m, other);
            break;
        }
        case 10:
            transform(m, {1, 1, choices.pick({1e-2, 1e-4, 1e-6, 0.0})}, {});
            break;
        case 11:
            transform(m, {1, choices.pick({1e-3, 1e-6}), 1e-3}, {});
            break;
        case 12:
            transform(m, {1, 1, 1}, {choices.pick({10.0, 1e4, 1e7}), 0, 0});
            break;
        case 13:
            m.triangles.push_back({{vertex(), vertex(), vertex()}});
            break;
        default:
            // To be refused.
            switch (choices.below(4)) {
                case 0:
                    m.triangles.push_back({{0, 1, static_cast<std::uint32_t>(m.positions.size())}});
                    break;
                case 1:
                    m.positions[vertex()].y = std::numeric_limits<float>::quiet_NaN();
                    break;
                case 2:
                    m.positions[vertex()].x = std::numeric_limits<float>::infinity();
                    break;
                default:
                    m.triangles.clear();
            }
    }
}

}  // namespace

MeshData proper_mesh(Choices& choices) {
    MeshData mesh;
    switch (choices.below(6)) {
        case 0:
            mesh = box();
            break;
        case 1:
            mesh = tetrahedron();
            break;
        case 2:
            mesh = octahedron();
            break;
        case 3:
            mesh = channel();
            break;
        case 4:
            mesh = torus(5 + choices.below(6), 3 + choices.below(6));
            break;
        default:
            mesh = box();
            transform(mesh, {1, 1, choices.pick({0.5, 0.1, 0.02})}, {});
    }
    return mesh;
}

MeshData any_mesh(Choices& choices) {
    MeshData mesh = base_shape(choices);
    for (std::uint32_t left = choices.pick({0u, 0u, 0u, 1u, 1u, 2u});
         left > 0 && !mesh.triangles.empty(); --left)
        spoil(mesh, choices);
    return mesh;
}

}  // namespace pierce::fuzz
