// Makes the bunny of the bunnies scene: reduces a mesh to 453 vertices, centres and scales it, and
// cuts it into convex pieces. Run once, when the project is built.   make_bunny INPUT.off BUNNY.off
// PIECES.json
#include <HACD/hacdHACD.h>

#include <OpenMesh/Core/IO/MeshIO.hh>
#include <OpenMesh/Core/Mesh/TriMesh_ArrayKernelT.hh>
#include <OpenMesh/Tools/Decimater/DecimaterT.hh>
#include <OpenMesh/Tools/Decimater/ModNormalFlippingT.hh>
#include <OpenMesh/Tools/Decimater/ModQuadricT.hh>
#include <fstream>
#include <iostream>
#include <nlohmann/json.hpp>

using Mesh = OpenMesh::TriMesh_ArrayKernelT<>;

constexpr std::size_t vertex_count = 453;
constexpr float height = 4.0f;
constexpr double largest_turn = 60;  // [degrees]

/// Quadric edge collapses (Garland and Heckbert 1997) until `vertex_count` are left. Collapses that
/// turn a face by more than `largest_turn` are left out: without that the ears end up crossing
/// themselves.
void reduce(Mesh& mesh) {
    mesh.request_face_normals();
    mesh.update_face_normals();
    OpenMesh::Decimater::DecimaterT<Mesh> decimater(mesh);
    OpenMesh::Decimater::ModQuadricT<Mesh>::Handle quadric;
    decimater.add(quadric);
    decimater.module(quadric).unset_max_err();
    OpenMesh::Decimater::ModNormalFlippingT<Mesh>::Handle flipping;
    decimater.add(flipping);
    decimater.module(flipping).set_max_normal_deviation(largest_turn);
    decimater.initialize();
    decimater.decimate_to(vertex_count);
    mesh.garbage_collection();
}

/// Puts the middle of the bounding box at the origin, stands the bunny up along z and gives it its
/// height.
void place(Mesh& mesh) {
    auto low = mesh.point(*mesh.vertices_begin()), high = low;
    for (auto v : mesh.vertices()) {
        low.minimize(mesh.point(v));
        high.maximize(mesh.point(v));
    }
    const auto middle = 0.5f * (low + high);
    const float scale = height / (high - low).max();
    for (auto v : mesh.vertices()) {
        const auto p = scale * (mesh.point(v) - middle);
        mesh.set_point(v, {p[0], -p[2], p[1]});
    }
}

nlohmann::json convex_pieces(const Mesh& mesh) {
    std::vector<HACD::Vec3<HACD::Real>> points;
    std::vector<HACD::Vec3<long>> triangles;
    for (auto v : mesh.vertices())
        points.emplace_back(mesh.point(v)[0], mesh.point(v)[1], mesh.point(v)[2]);
    for (auto f : mesh.faces()) {
        long corner[3];
        int k = 0;
        for (auto v : mesh.fv_range(f)) corner[k++] = v.idx();
        triangles.emplace_back(corner[0], corner[1], corner[2]);
    }
    HACD::HACD hacd;
    hacd.SetPoints(points.data());
    hacd.SetNPoints(points.size());
    hacd.SetTriangles(triangles.data());
    hacd.SetNTriangles(triangles.size());
    hacd.SetCompacityWeight(0.1);
    hacd.SetVolumeWeight(0.0);
    hacd.SetNClusters(2);
    hacd.SetNVerticesPerCH(100);
    hacd.SetConcavity(10);
    hacd.SetAddExtraDistPoints(true);
    hacd.SetAddNeighboursDistPoints(true);
    hacd.SetAddFacesPoints(true);
    hacd.Compute();
    nlohmann::json pieces = nlohmann::json::array();
    for (std::size_t c = 0; c < hacd.GetNClusters(); ++c) {
        std::vector<HACD::Vec3<HACD::Real>> hull(hacd.GetNPointsCH(c));
        std::vector<HACD::Vec3<long>> faces(hacd.GetNTrianglesCH(c));
        hacd.GetCH(c, hull.data(), faces.data());
        nlohmann::json piece = nlohmann::json::array();
        for (const auto& p : hull) piece.push_back({p.X(), p.Y(), p.Z()});
        pieces.push_back(piece);
    }
    return pieces;
}

int main(int argc, char** argv) {
    if (argc != 4) {
        std::cerr << "usage: make_bunny INPUT.off BUNNY.off PIECES.json\n";
        return 2;
    }
    Mesh mesh;
    if (!OpenMesh::IO::read_mesh(mesh, argv[1])) return 1;
    reduce(mesh);
    place(mesh);
    if (mesh.n_vertices() != vertex_count || mesh.n_faces() != 2 * vertex_count - 4) {
        std::cerr << "make_bunny: got " << mesh.n_vertices() << " vertices and " << mesh.n_faces()
                  << " triangles\n";
        return 1;
    }
    if (!OpenMesh::IO::write_mesh(mesh, argv[2], OpenMesh::IO::Options::Default, 9)) return 1;
    std::ofstream(argv[3]) << convex_pieces(mesh);
    std::cout << "bunny: " << mesh.n_vertices() << " vertices, " << mesh.n_faces()
              << " triangles\n";
}
