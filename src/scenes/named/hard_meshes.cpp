#include "scenes/named/hard_meshes.hpp"

#include <utility>

namespace pierce::scenes::hard {

MeshData cube() { return box({0, 0, 0}, {1, 1, 1}); }

MeshData placed(MeshData mesh, float scale, Vec3f by) {
    for (Vec3f& p : mesh.positions) p = scale * p + by;
    return mesh;
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

MeshData prism(Vec3f a, Vec3f b, Vec3f c, Vec3f along) {
    return {{a, b, c, a + along, b + along, c + along},
            {{{0, 1, 2}},
             {{3, 5, 4}},
             {{0, 3, 4}},
             {{0, 4, 1}},
             {{1, 4, 5}},
             {{1, 5, 2}},
             {{0, 2, 5}},
             {{0, 5, 3}}}};
}

MeshData spike(Vec3f apex, Vec3f base, float half) {
    return {{apex, base + Vec3f{-half, -half, 0}, base + Vec3f{half, -half, 0},
             base + Vec3f{half, half, 0}, base + Vec3f{-half, half, 0}},
            {{{0, 2, 1}}, {{0, 3, 2}}, {{0, 4, 3}}, {{0, 1, 4}}, {{1, 2, 3}}, {{1, 3, 4}}}};
}

MeshData cube_with_filler() {
    MeshData mesh = cube();
    mesh.positions.push_back({0.5f, 0, 0});
    mesh.triangles[4] = {{0, 8, 5}};
    mesh.triangles.push_back({{8, 1, 5}});
    mesh.triangles.push_back({{0, 1, 8}});
    return mesh;
}

MeshData bowtie(bool in_plane) {
    MeshData mesh{{{0, 0, 0}, {1, 0, 1}, {-0.5f, 0.75f, 1}, {-0.5f, -0.75f, 1}},
                  {{{0, 2, 1}}, {{0, 3, 2}}, {{0, 1, 3}}, {{1, 2, 3}}}};
    for (std::uint32_t v = 1; v < 4; ++v) {
        const Vec3f p = mesh.positions[v];
        mesh.positions.push_back(in_plane ? Vec3f{p.x, p.y, -p.z} : -p);
    }
    for (Triangle t : {Triangle{{0, 4, 5}}, {{0, 5, 6}}, {{0, 6, 4}}, {{4, 6, 5}}})
        mesh.triangles.push_back(t);
    return mesh;
}

MeshData pyramid_over_c() {
    MeshData mesh{{{0, 0, 0},
                   {0, 0, -1},
                   {5, 0, -1},
                   {5, 5, -1},
                   {1, 5, -1},
                   {1, 3, -1},
                   {3, 3, -1},
                   {3, 2, -1},
                   {0, 2, -1}},
                  {}};
    for (std::uint32_t k = 1; k <= 8; ++k) mesh.triangles.push_back({{0, k, k % 8 + 1}});
    for (Triangle t :
         {Triangle{{1, 7, 2}}, {{1, 8, 7}}, {{3, 5, 4}}, {{3, 6, 5}}, {{2, 6, 3}}, {{2, 7, 6}}})
        mesh.triangles.push_back(t);
    return mesh;
}

MeshData sheet(Vec3f center, float half, bool upward) {
    MeshData mesh{{center, center + Vec3f{-half, -half, 0}, center + Vec3f{half, -half, 0},
                   center + Vec3f{half, half, 0}, center + Vec3f{-half, half, 0}},
                  {{{0, 1, 2}}, {{0, 2, 3}}, {{0, 3, 4}}, {{0, 4, 1}}}};
    for (Triangle& t : mesh.triangles)
        if (!upward) std::swap(t.vertex[1], t.vertex[2]);
    return mesh;
}

constexpr std::uint32_t defect = 2;  // the cube's triangle (0,0,1), (1,0,1), (1,1,1)

MeshData cube_with_flipped_triangle() {
    MeshData mesh = cube();
    std::swap(mesh.triangles[defect].vertex[1], mesh.triangles[defect].vertex[2]);
    return mesh;
}

MeshData cube_with_missing_triangle() {
    MeshData mesh = cube();
    mesh.triangles.erase(mesh.triangles.begin() + defect);
    return mesh;
}

MeshData small_cube_around(Vec3f center) {
    return placed(box({-1, -1, -1}, {1, 1, 1}), 0x1p-4f, center);
}

}  // namespace pierce::scenes::hard
