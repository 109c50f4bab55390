#include "scenes/named/shapes.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <utility>

namespace pierce::scenes {
namespace {

struct Icosahedron {
    std::vector<Vec3d> points;
    std::vector<Triangle> triangles;
};

Icosahedron icosahedron() {
    Icosahedron solid;
    const double g = std::numbers::phi;
    solid.points = {{-1, g, 0},  {1, g, 0},  {-1, -g, 0}, {1, -g, 0}, {0, -1, g},  {0, 1, g},
                    {0, -1, -g}, {0, 1, -g}, {g, 0, -1},  {g, 0, 1},  {-g, 0, -1}, {-g, 0, 1}};
    solid.triangles = {{{0, 11, 5}}, {{0, 5, 1}},  {{0, 1, 7}},   {{0, 7, 10}}, {{0, 10, 11}},
                       {{1, 5, 9}},  {{5, 11, 4}}, {{11, 10, 2}}, {{10, 7, 6}}, {{7, 1, 8}},
                       {{3, 9, 4}},  {{3, 4, 2}},  {{3, 2, 6}},   {{3, 6, 8}},  {{3, 8, 9}},
                       {{4, 9, 5}},  {{2, 4, 11}}, {{6, 2, 10}},  {{8, 6, 7}},  {{9, 8, 1}}};
    return solid;
}

}  // namespace

MeshData torus(double major_radius, double minor_radius, std::uint32_t around,
               std::uint32_t across) {
    MeshData mesh;
    for (std::uint32_t i = 0; i < around; ++i)
        for (std::uint32_t j = 0; j < across; ++j) {
            const double a = 2 * std::numbers::pi * i / around,
                         b = 2 * std::numbers::pi * j / across;
            const double r = major_radius + minor_radius * std::cos(b);
            mesh.positions.push_back(
                to_float({r * std::cos(a), r * std::sin(a), minor_radius * std::sin(b)}));
        }
    for (std::uint32_t i = 0; i < around; ++i)
        for (std::uint32_t j = 0; j < across; ++j) {
            const std::uint32_t i1 = (i + 1) % around, j1 = (j + 1) % across;
            const std::uint32_t a = i * across + j, b = i1 * across + j, c = i1 * across + j1,
                                d = i * across + j1;
            mesh.triangles.push_back({{a, b, c}});
            mesh.triangles.push_back({{a, c, d}});
        }
    return mesh;
}

MeshData box(Vec3d lower, Vec3d upper) {
    MeshData mesh;
    for (int k = 0; k < 8; ++k)
        mesh.positions.push_back(to_float(
            {k & 1 ? upper.x : lower.x, k & 2 ? upper.y : lower.y, k & 4 ? upper.z : lower.z}));
    // Bit k of a corner's number says whether its coordinate k is lower or upper. Each face is two
    // triangles, counter-clockwise seen from outside.
    mesh.triangles = {{{0, 2, 3}}, {{0, 3, 1}}, {{4, 5, 7}}, {{4, 7, 6}}, {{0, 1, 5}}, {{0, 5, 4}},
                      {{2, 6, 7}}, {{2, 7, 3}}, {{0, 4, 6}}, {{0, 6, 2}}, {{1, 3, 7}}, {{1, 7, 5}}};
    return mesh;
}

MeshData sphere(double radius, int levels) {
    auto [points, triangles] = icosahedron();
    for (int level = 0; level < levels; ++level) {
        std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> middles;
        const auto middle = [&](std::uint32_t a, std::uint32_t b) {
            const std::pair edge{std::min(a, b), std::max(a, b)};
            const auto [it, is_new] = middles.try_emplace(
                edge, static_cast<std::uint32_t>(points.size()));
            if (is_new) points.push_back(0.5 * (points[a] + points[b]));
            return it->second;
        };
        std::vector<Triangle> finer;
        for (const Triangle& t : triangles) {
            const std::uint32_t a = t.vertex[0], b = t.vertex[1], c = t.vertex[2];
            const std::uint32_t ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
            for (Triangle f : {Triangle{{a, ab, ca}}, Triangle{{b, bc, ab}}, Triangle{{c, ca, bc}},
                               Triangle{{ab, bc, ca}}})
                finer.push_back(f);
        }
        triangles = std::move(finer);
    }
    MeshData mesh{{}, std::move(triangles)};
    for (Vec3d p : points) mesh.positions.push_back(to_float(radius * normalized(p)));
    return mesh;
}

MeshData geodesic_sphere(double radius, std::uint32_t parts) {
    const Icosahedron solid = icosahedron();
    MeshData mesh;
    // A place is named by the corners that have a weight in it, so that triangles share it.
    using Weights = std::map<std::uint32_t, std::uint32_t>;
    std::map<Weights, std::uint32_t> places;
    for (const Triangle& t : solid.triangles) {
        const auto place = [&](std::uint32_t i, std::uint32_t j) {
            Weights weights;
            Vec3d sum;
            const std::uint32_t weight[3] = {parts - i - j, i, j};
            for (int k = 0; k < 3; ++k) {
                if (weight[k] == 0) continue;
                weights[t.vertex[k]] = weight[k];
            }
            for (const auto& [corner, times] : weights)
                sum += static_cast<double>(times) * solid.points[corner];
            const auto [at, is_new] = places.try_emplace(
                std::move(weights), static_cast<std::uint32_t>(mesh.positions.size()));
            if (is_new) mesh.positions.push_back(to_float(radius * normalized(sum)));
            return at->second;
        };
        for (std::uint32_t i = 0; i < parts; ++i)
            for (std::uint32_t j = 0; i + j < parts; ++j) {
                mesh.triangles.push_back({{place(i, j), place(i + 1, j), place(i, j + 1)}});
                if (i + j + 1 < parts)
                    mesh.triangles.push_back(
                        {{place(i + 1, j), place(i + 1, j + 1), place(i, j + 1)}});
            }
    }
    return mesh;
}

MeshData grid(double width, double depth, std::uint32_t along, std::uint32_t across) {
    MeshData mesh;
    for (std::uint32_t j = 0; j < across; ++j)
        for (std::uint32_t i = 0; i < along; ++i)
            mesh.positions.push_back(
                to_float({width * (static_cast<double>(i) / (along - 1) - 0.5),
                          depth * (static_cast<double>(j) / (across - 1) - 0.5), 0}));
    for (std::uint32_t j = 0; j + 1 < across; ++j)
        for (std::uint32_t i = 0; i + 1 < along; ++i) {
            const std::uint32_t a = j * along + i, b = a + 1, c = b + along, d = a + along;
            if ((i + j) % 2 == 0) {
                mesh.triangles.push_back({{a, b, c}});
                mesh.triangles.push_back({{a, c, d}});
            } else {
                mesh.triangles.push_back({{a, b, d}});
                mesh.triangles.push_back({{b, c, d}});
            }
        }
    return mesh;
}

MeshData tube(double radius, double height, std::uint32_t around, std::uint32_t rings) {
    MeshData mesh;
    for (std::uint32_t j = 0; j < rings; ++j)
        for (std::uint32_t i = 0; i < around; ++i) {
            const double a = 2 * std::numbers::pi * i / around;
            mesh.positions.push_back(
                to_float({radius * std::cos(a), radius * std::sin(a),
                          height * (static_cast<double>(j) / (rings - 1) - 0.5)}));
        }
    for (std::uint32_t j = 0; j + 1 < rings; ++j)
        for (std::uint32_t i = 0; i < around; ++i) {
            const std::uint32_t a = j * around + i, b = j * around + (i + 1) % around,
                                c = b + around, d = a + around;
            mesh.triangles.push_back({{a, b, c}});
            mesh.triangles.push_back({{a, c, d}});
        }
    return mesh;
}

MeshData capsule(double radius, double half_length, std::uint32_t around, std::uint32_t rings) {
    MeshData mesh;
    const auto add = [&](double x, double r, double turn) {
        const double a = 2 * std::numbers::pi * turn / around;
        mesh.positions.push_back(to_float({x, r * std::cos(a), r * std::sin(a)}));
    };
    // In order: a pole, the rings of its half sphere, the rings of the other half sphere, and that
    // one's pole.
    add(-half_length - radius, 0, 0);
    for (int side : {-1, 1})
        for (std::uint32_t j = 0; j < rings; ++j) {
            const double up = 0.5 * std::numbers::pi * (side < 0 ? rings - 1 - j : j) / rings;
            for (std::uint32_t i = 0; i < around; ++i)
                add(side * (half_length + radius * std::sin(up)), radius * std::cos(up), i);
        }
    add(half_length + radius, 0, 0);
    const std::uint32_t last = static_cast<std::uint32_t>(mesh.positions.size()) - 1;
    for (std::uint32_t i = 0; i < around; ++i) {
        const std::uint32_t next = (i + 1) % around, end = (2 * rings - 1) * around + 1;
        mesh.triangles.push_back({{0, 1 + next, 1 + i}});
        mesh.triangles.push_back({{last, end + i, end + next}});
        for (std::uint32_t j = 0; j + 1 < 2 * rings; ++j) {
            const std::uint32_t a = 1 + j * around + i, b = 1 + j * around + next, c = b + around,
                                d = a + around;
            mesh.triangles.push_back({{a, b, c}});
            mesh.triangles.push_back({{a, c, d}});
        }
    }
    return mesh;
}

MeshData joined(MeshData first, const MeshData& second) {
    const auto count = static_cast<std::uint32_t>(first.positions.size());
    first.positions.insert(first.positions.end(), second.positions.begin(), second.positions.end());
    for (const Triangle& t : second.triangles)
        first.triangles.push_back(
            {{t.vertex[0] + count, t.vertex[1] + count, t.vertex[2] + count}});
    return first;
}

std::vector<Vec3f> moved(std::vector<Vec3f> positions, Vec3f by) {
    for (Vec3f& p : positions) p += by;
    return positions;
}

}  // namespace pierce::scenes
