#include "scenes/named/bunny.hpp"

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "pierce/error.hpp"
#include "scenes/files/mesh_io.hpp"
#include "scenes/named/mass_properties.hpp"

namespace pierce::scenes {

std::filesystem::path data_folder() {
    if (const char* given = std::getenv("PIERCE_DATA_DIR")) return given;
    return PIERCE_DEFAULT_DATA_DIR;
}

SceneMesh bunny_mesh() {
    const std::filesystem::path mesh_file = data_folder() / "bunny.off",
                                pieces_file = data_folder() / "bunny_pieces.json";
    if (!std::filesystem::exists(mesh_file))
        throw InputError(
            "'" + mesh_file.string() +
            "' is missing: install libcgal-demo and build again, or set PIERCE_DATA_DIR");
    SceneMesh mesh{"bunny", read_mesh(mesh_file), {}};
    const Frame moved = to_principal_frame(mesh.data);
    std::ifstream pieces(pieces_file);
    if (!pieces) return mesh;
    for (const auto& piece : nlohmann::json::parse(pieces)) {
        std::vector<Vec3f>& points = mesh.convex_pieces.emplace_back();
        for (const auto& p : piece)
            points.push_back(to_float(moved.to_parent(
                {p.at(0).get<double>(), p.at(1).get<double>(), p.at(2).get<double>()})));
    }
    return mesh;
}

}  // namespace pierce::scenes
