// What a step costs that changes a mesh, beside the same step without. Prints CSV.
//   pierce_changed_mesh FOLDER BACKEND THREADS
// Two worlds replay a recording of deforming bodies. In every frame the first one gives one of its
// bodies a mesh in which 1 % of the triangles are others: pairs of neighbours whose common edge was
// turned. Times are medians over all frames but the first ten; `ratio` is that of each frame.
#include <algorithm>
#include <array>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "pierce/error.hpp"
#include "pierce/world.hpp"
#include "scenes/detect/method.hpp"
#include "scenes/recording/recording.hpp"
#include "times.hpp"

namespace {

using namespace pierce;
/// Turns the common edges of a few pairs of triangles, from a place on that depends on `round`.
void turn_edges(MeshData& mesh, std::size_t round) {
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::size_t> triangle_at;  // by directed edge
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
        for (int k = 0; k < 3; ++k)
            triangle_at[{mesh.triangles[t].vertex[k], mesh.triangles[t].vertex[(k + 1) % 3]}] = t;
    const std::size_t pairs = std::max<std::size_t>(mesh.triangles.size() / 200, 1);
    std::vector<bool> taken(mesh.triangles.size(), false);
    for (std::size_t done = 0, i = 0; done < pairs && i < mesh.triangles.size(); ++i) {
        const std::size_t t = (round * 37 + i) % mesh.triangles.size();
        const auto [a, b, c] = std::to_array(mesh.triangles[t].vertex);
        const auto across = triangle_at.find({b, a});
        if (across == triangle_at.end() || taken[t] || taken[across->second]) continue;
        std::uint32_t d = a;
        for (std::uint32_t v : mesh.triangles[across->second].vertex)
            if (v != a && v != b) d = v;
        if (triangle_at.contains({c, d}) || triangle_at.contains({d, c})) continue;
        taken[t] = taken[across->second] = true;
        mesh.triangles[t] = {{a, d, c}};
        mesh.triangles[across->second] = {{d, b, c}};
        ++done;
    }
}

struct Replay {
    World world;
    std::vector<BodyId> bodies;
    std::vector<MeshId> meshes;  ///< of each body, like the next one
    std::vector<MeshData> data;

    Replay(const scenes::Recording& recording, const scenes::RaySettings& rays)
        : world(scenes::make_backend(rays), rays.world) {
        for (std::uint32_t b = 0; b < recording.bodies.size(); ++b) {
            const scenes::SceneMesh& mesh = recording.meshes[recording.bodies[b].mesh];
            data.push_back(mesh.data);
            meshes.push_back(world.add_mesh(mesh.name, mesh.data, rays.mesh_options()));
            switch (recording.bodies[b].motion) {
                case Motion::deforming:
                    bodies.push_back(world.add_deforming_body(meshes.back()));
                    break;
                case Motion::rigid:
                    bodies.push_back(world.add_rigid_body(meshes.back()));
                    break;
                case Motion::fixed:
                    bodies.push_back(world.add_fixed_body(meshes.back(), recording.pose(b, 0)));
            }
        }
    }
    void place(const scenes::Recording& recording, std::uint32_t frame) {
        for (std::uint32_t b = 0; b < bodies.size(); ++b)
            if (recording.bodies[b].motion == Motion::deforming)
                world.set_positions(bodies[b], recording.positions(b, frame));
            else
                world.set_pose(bodies[b], recording.pose(b, frame));
    }
    void change(const scenes::Recording& recording, std::uint32_t body, std::uint32_t frame,
                int threads) {
        const MeshId before = meshes[body];
        meshes[body] = world.add_mesh("changed", data[body], before,
                                      {.threads = static_cast<std::uint32_t>(threads)});
        if (recording.bodies[body].motion == Motion::deforming)
            world.set_mesh(bodies[body], meshes[body], recording.positions(body, frame));
        else
            world.set_mesh(bodies[body], meshes[body]);
        world.remove_mesh(before);
    }
};

}  // namespace

int main(int argc, char** argv) try {
    if (argc != 4) {
        std::fputs("usage: pierce_changed_mesh FOLDER BACKEND THREADS\n", stderr);
        return 2;
    }
    const scenes::Recording recording = scenes::read_recording(argv[1]);
    scenes::require_lasting_meshes(recording, "pierce_changed_mesh");
    scenes::RaySettings rays;
    rays.backend = argv[2];
    rays.threads = std::atoi(argv[3]);
    Replay changing(recording, rays), quiet(recording, rays);
    std::vector<double> changed_ms, quiet_ms, edit_ms, ratios;
    std::uint64_t contacts = 0, contacts_quiet = 0;
    std::uint32_t body = 0;
    for (std::uint32_t f = 0; f < recording.frame_count; ++f) {
        changing.place(recording, f);
        quiet.place(recording, f);
        do body = (body + 1) % static_cast<std::uint32_t>(recording.bodies.size());
        while (recording.bodies[body].motion == Motion::fixed);
        turn_edges(changing.data[body], f);
        auto begin = Clock::now();
        changing.change(recording, body, f, rays.threads);
        const double edit = milliseconds_since(begin);
        changing.world.detect();
        const double changed = milliseconds_since(begin);
        begin = Clock::now();
        quiet.world.detect();
        const double without = milliseconds_since(begin);
        contacts += changing.world.contacts().size();
        contacts_quiet += quiet.world.contacts().size();
        if (f < 10) continue;
        changed_ms.push_back(changed);
        quiet_ms.push_back(without);
        edit_ms.push_back(edit);
        ratios.push_back(changed / without);
    }
    std::puts(
        "bodies,frames,backend,threads,quiet_ms,changed_ms,edit_ms,ratio,contacts,contacts_quiet");
    std::printf("%zu,%zu,%s,%d,%.3f,%.3f,%.3f,%.3f,%llu,%llu\n", recording.bodies.size(),
                ratios.size(), argv[2], rays.threads, median(quiet_ms), median(changed_ms),
                median(edit_ms), median(ratios), static_cast<unsigned long long>(contacts),
                static_cast<unsigned long long>(contacts_quiet));
} catch (const InputError& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 2;
}
