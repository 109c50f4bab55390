// Detects the contacts of sheets in single steps of a recording, as a program beside it asks:
// compare_ipc.py sends frames and reads times and contacts.
//   pierce_sheet_steps DIR [threads]
// A request is a line on the standard input, "BEGIN END" or "BEGIN END contacts": the step that
// starts at one frame and ends at the other. The answer is a line of JSON, and after it, if
// contacts were asked for, that many records (Record) in the byte order of the machine. "edges
// BODY" is answered by the ends of the body's edges, in the order of their numbers. Every step
// stands alone: nothing that was found before is remembered of the sheets' sides.
#include <time.h>

#include <chrono>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <iostream>
#include <sstream>
#include <string>
#include <vector>

#include "core/mesh/mesh_view.hpp"
#include "pierce/mesh.hpp"
#include "scenes/detect/detector.hpp"
#include "scenes/recording/recording.hpp"

namespace {

using namespace pierce;

/// A contact as it is written. Vertices are counted through all bodies of the recording.
struct Record {
    enum Kind : std::int32_t {
        vertex_and_triangle,  ///< the vertex, and the triangle's corners
        edges,                ///< the ends of both
        tangled,              ///< the ends of an edge, and the corners of the triangle it pierces
    };
    std::int32_t kind = 0;
    std::int32_t found = 0;  ///< pierce::Found
    std::int32_t vertex[6] = {-1, -1, -1, -1, -1, -1};
    double distance = 0, time = 0;
};
static_assert(sizeof(Record) == 48);

double processor_seconds() {
    timespec now{};
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
    return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

class Steps {
public:
    Steps(const scenes::Recording& recording, int threads)
        : recording_(recording), scene_(scenes::scene_of(recording), {"embree", threads, {}}) {
        for (const scenes::SceneMesh& mesh : recording.meshes)
            meshes_.emplace_back(mesh.name, mesh.data);
        std::uint32_t first = 0;
        for (const scenes::RecordedBody& body : recording.bodies) {
            first_vertex_.push_back(first);
            first += static_cast<std::uint32_t>(recording.meshes[body.mesh].data.positions.size());
        }
    }

    void run(std::uint32_t begin, std::uint32_t end, bool with_contacts) {
        const double processor_begin = processor_seconds();
        const auto clock_begin = std::chrono::steady_clock::now();
        World& world = scene_.world;
        for (std::uint32_t b = 0; b < recording_.bodies.size(); ++b) {
            if (recording_.bodies[b].motion == Motion::deforming)
                world.set_motion(scene_.bodies[b], recording_.positions(b, begin),
                                 recording_.positions(b, end));
            else
                world.set_motion(scene_.bodies[b], recording_.pose(b, begin),
                                 recording_.pose(b, end));
        }
        world.forget_sides();
        const StepStats& stats = world.detect();
        const std::chrono::duration<double, std::milli> wall = std::chrono::steady_clock::now() -
                                                               clock_begin;
        const double processor = 1000 * (processor_seconds() - processor_begin);
        double sheets = 0;
        for (const StageTime& t : stats.stages)
            if (t.stage == StageId::sheets) sheets += t.milliseconds;
        const std::vector<Record> records = sheet_contacts();
        std::printf(
            "{\"wall_ms\": %.6f, \"processor_ms\": %.6f, \"detect_ms\": %.6f, \"sheets_ms\": "
            "%.6f, \"triangle_pairs\": %u, \"contacts\": %zu, \"status\": %u, \"records\": %zu, "
            "\"self_contacts\": %zu}\n",
            wall.count(), processor, stats.milliseconds, sheets, stats.triangle_pairs,
            records.size(), stats.status, with_contacts ? records.size() : std::size_t{0},
            in_themselves());
        if (with_contacts) std::fwrite(records.data(), sizeof(Record), records.size(), stdout);
        std::fflush(stdout);
    }

    void print_edges(std::uint32_t body) const {
        std::printf("[");
        const char* before = "";
        for (const Edge& e : meshes_[recording_.bodies[body].mesh].view().edges) {
            std::printf("%s[%u, %u]", before, first_vertex_[body] + e.vertex[0],
                        first_vertex_[body] + e.vertex[1]);
            before = ", ";
        }
        std::printf("]\n");
        std::fflush(stdout);
    }

private:
    std::size_t in_themselves() const {
        std::size_t count = 0;
        for (const Contact& c : scene_.world.contacts()) count += c.of_sheet && c.a == c.b;
        return count;
    }

    std::vector<Record> sheet_contacts() const {
        std::vector<Record> records;
        for (const Contact& c : scene_.world.contacts()) {
            if (!c.of_sheet) continue;
            const std::uint32_t a = scene_.index_of(c.a), b = scene_.index_of(c.b);
            const std::uint32_t source = c.source == Side::a ? a : b,
                                target = c.source == Side::a ? b : a;
            const MeshView& mesh = meshes_[recording_.bodies[target].mesh].view();
            Record r{.kind = c.found == Found::tangled ? Record::tangled
                             : c.is_edge()             ? Record::edges
                                                       : Record::vertex_and_triangle,
                     .found = static_cast<std::int32_t>(c.found),
                     .distance = c.distance,
                     .time = c.time};
            std::size_t place = 0;
            const auto put = [&](std::uint32_t body, std::uint32_t vertex) {
                r.vertex[place++] = static_cast<std::int32_t>(first_vertex_[body] + vertex);
            };
            put(source, c.vertex);
            if (r.kind != Record::vertex_and_triangle) put(source, c.edge_end);
            if (r.kind == Record::edges)
                for (std::uint32_t v : mesh.edges[c.other_edge].vertex) put(target, v);
            else
                for (std::uint32_t v : mesh.triangles[c.triangle].vertex) put(target, v);
            records.push_back(r);
        }
        return records;
    }

    const scenes::Recording& recording_;
    scenes::SceneWorld scene_;
    std::vector<Mesh> meshes_;  ///< for the numbers of their edges
    std::vector<std::uint32_t> first_vertex_;
};

}  // namespace

int main(int argc, char** argv) try {
    if (argc < 2) {
        std::fputs("pierce_sheet_steps DIR [threads]\n", stderr);
        return 2;
    }
    const scenes::Recording recording = scenes::read_recording(argv[1]);
    scenes::require_lasting_meshes(recording, "pierce_sheet_steps");
    Steps steps(recording, argc > 2 ? std::atoi(argv[2]) : 1);
    for (std::string line; std::getline(std::cin, line);) {
        std::istringstream words(line);
        std::uint32_t begin = 0, end = 0;
        std::string word;
        if (line.starts_with("edges") && words >> word >> begin &&
            begin < recording.bodies.size()) {
            steps.print_edges(begin);
            continue;
        }
        if (!(words >> begin >> end) || begin >= recording.frame_count ||
            end >= recording.frame_count) {
            std::fprintf(stderr, "no such request: %s\n", line.c_str());
            return 2;
        }
        words >> word;
        steps.run(begin, end, word == "contacts");
    }
    return 0;
} catch (const std::exception& error) {
    std::fprintf(stderr, "pierce_sheet_steps: %s\n", error.what());
    return 2;
}
