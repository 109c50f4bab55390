#include "c_api/mesh.hpp"

#include <memory>
#include <string>

#include "c_api/arguments.hpp"
#include "c_api/border.hpp"
#include "c_api/versioned.hpp"
#include "c_api/world_state.hpp"

struct pierce_shared_mesh {
    std::shared_ptr<const pierce::Mesh> mesh;
};

namespace pierce::c {
namespace {

constexpr pierce_mesh_options default_options{.struct_size = sizeof(pierce_mesh_options),
                                              .inside = PIERCE_INSIDE_AUTOMATIC,
                                              .threads = 0,
                                              .cache = nullptr,
                                              .progress = nullptr,
                                              .user = nullptr};

MeshOptions options_of(const pierce_mesh_options* given) {
    if (given == nullptr) return {};
    const pierce_mesh_options o = read_struct(given, default_options, "options");
    MeshOptions options{.inside = enumerated(o.inside, Inside::none, "options.inside"),
                        .cache = o.cache == nullptr ? "" : o.cache,
                        .threads = o.threads};
    if (o.progress != nullptr)
        options.progress = [told = o.progress, user = o.user](std::string_view what, double share) {
            told(std::string(what).c_str(), share, user);
        };
    return options;
}

std::string text(const char* name) { return name == nullptr ? "" : name; }

pierce_mesh_info info_of(const Mesh& mesh) {
    const MeshTraits& traits = mesh.traits();
    const MeshInside& inside = mesh.inside();
    return {.struct_size = sizeof(pierce_mesh_info),
            .name = mesh.name().c_str(),
            .positions = reinterpret_cast<const float*>(mesh.positions().data()),
            .normals = reinterpret_cast<const float*>(mesh.normals().data()),
            .triangles = reinterpret_cast<const std::uint32_t*>(mesh.triangles().data()),
            .vertex_count = mesh.positions().size(),
            .triangle_count = mesh.triangles().size(),
            .volume = traits.volume,
            .mean_edge_length = traits.mean_edge_length,
            .cap_share = inside.cap_share,
            .closed = traits.closed(),
            .boundary_edges = traits.boundary_edges,
            .non_manifold_edges = traits.non_manifold_edges,
            .inconsistent_edges = traits.inconsistent_edges,
            .degenerate_triangles = traits.degenerate_triangles,
            .inside = static_cast<std::uint32_t>(inside.rule),
            .covered_triangles = inside.covered_triangles,
            .joined_vertices = inside.joined_vertices,
            .turned_triangles = inside.turned_triangles,
            .left_out_triangles = inside.left_out_triangles,
            .holes = inside.holes,
            .cap_triangles = inside.cap_triangles};
}

}  // namespace

MeshData mesh_data(const float* positions, std::size_t vertex_count, const std::uint32_t* triangles,
                   std::size_t triangle_count) {
    static_assert(sizeof(Triangle) == 3 * sizeof(std::uint32_t));
    const auto points = vectors(positions, vertex_count, "positions");
    const auto corners = list(reinterpret_cast<const Triangle*>(triangles), triangle_count,
                              "triangles");
    return {{points.begin(), points.end()}, {corners.begin(), corners.end()}};
}

}  // namespace pierce::c

using namespace pierce::c;

pierce_status pierce_default_mesh_options(pierce_mesh_options* options, size_t struct_size) {
    return guarded([&] { write_defaults(default_options, options, struct_size, "options"); });
}

pierce_status pierce_add_mesh(pierce_world* world, const char* name, const float* positions,
                              size_t vertex_count, const uint32_t* triangles, size_t triangle_count,
                              const pierce_mesh_options* options, pierce_mesh_id* mesh) {
    return guarded([&] {
        auto& inner = world_of(world);
        required(mesh, "mesh");
        *mesh = number(inner.add_mesh(text(name),
                                      mesh_data(positions, vertex_count, triangles, triangle_count),
                                      options_of(options)));
    });
}

pierce_status pierce_add_changed_mesh(pierce_world* world, const char* name, const float* positions,
                                      size_t vertex_count, const uint32_t* triangles,
                                      size_t triangle_count, pierce_mesh_id before,
                                      const pierce_mesh_options* options, pierce_mesh_id* mesh) {
    return guarded([&] {
        auto& inner = world_of(world);
        required(mesh, "mesh");
        *mesh = number(inner.add_mesh(text(name),
                                      mesh_data(positions, vertex_count, triangles, triangle_count),
                                      mesh_handle(before), options_of(options)));
    });
}

pierce_status pierce_create_shared_mesh(const char* name, const float* positions,
                                        size_t vertex_count, const uint32_t* triangles,
                                        size_t triangle_count, const pierce_mesh_options* options,
                                        pierce_shared_mesh** shared) {
    return guarded([&] {
        required(shared, "shared");
        *shared = new pierce_shared_mesh{std::make_shared<const pierce::Mesh>(
            text(name), mesh_data(positions, vertex_count, triangles, triangle_count),
            options_of(options))};
    });
}

void pierce_destroy_shared_mesh(pierce_shared_mesh* shared) { delete shared; }

pierce_status pierce_add_shared_mesh(pierce_world* world, const pierce_shared_mesh* shared,
                                     pierce_mesh_id* mesh) {
    return guarded([&] {
        auto& inner = world_of(world);
        required(mesh, "mesh");
        *mesh = number(inner.add_mesh(required(shared, "shared").mesh));
    });
}

pierce_status pierce_share_mesh(const pierce_world* world, pierce_mesh_id mesh,
                                pierce_shared_mesh** shared) {
    return guarded([&] {
        const auto& inner = world_of(world);
        required(shared, "shared");
        *shared = new pierce_shared_mesh{inner.share_mesh(mesh_handle(mesh))};
    });
}

pierce_status pierce_is_convex(const pierce_world* world, pierce_mesh_id mesh,
                               uint32_t* is_convex) {
    return guarded([&] {
        auto& inner = world_of(world);
        required(is_convex, "is_convex");
        *is_convex = pierce::is_convex(inner.mesh(mesh_handle(mesh)));
    });
}

pierce_status pierce_remove_mesh(pierce_world* world, pierce_mesh_id mesh) {
    return guarded([&] { world_of(world).remove_mesh(mesh_handle(mesh)); });
}

pierce_status pierce_mesh(const pierce_world* world, pierce_mesh_id mesh, pierce_mesh_info* info) {
    return guarded([&] {
        auto& inner = world_of(world);
        check_struct(info, "info");
        write_struct(info_of(inner.mesh(mesh_handle(mesh))), info);
    });
}

pierce_status pierce_given_triangle(const pierce_world* world, pierce_mesh_id mesh,
                                    uint32_t triangle, uint32_t* given) {
    return guarded([&] {
        auto& inner = world_of(world);
        required(given, "given");
        *given = inner.mesh(mesh_handle(mesh)).given_triangle(triangle);
    });
}
