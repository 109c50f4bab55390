// The mesh check on the meshes of Debian's libcgal-demo: modelled, scanned and broken ones.
#include <gmock/gmock.h>

#include <filesystem>
#include <map>

#include "core/mesh/mesh_view.hpp"
#include "pierce/constants.hpp"
#include "pierce/error.hpp"
#include "pierce/mesh_check.hpp"
#include "scenes/files/mesh_io.hpp"

namespace pierce::scenes {
namespace {

namespace fs = std::filesystem;
using enum MeshDefect;
using testing::HasSubstr;

constexpr std::size_t few_triangles = 20000;

std::string findings_text(const MeshReport& report) {
    std::string text;
    for (const MeshFinding& f : report.findings) text += std::string(name(f.kind)) + ", ";
    return text;
}

/// Every file is checked once, for all tests.
class MeshFilesTest : public testing::Test {
protected:
    static void SetUpTestSuite() {
        if (!fs::exists(PIERCE_MESH_FOLDER)) return;
        for (const fs::directory_entry& entry : fs::directory_iterator(PIERCE_MESH_FOLDER)) {
            const std::string file = entry.path().filename().string();
            try {
                meshes[file] = read_mesh(entry.path());
                reports[file] = check_mesh(
                    meshes[file],
                    {.self_intersections = meshes[file].triangles.size() < few_triangles});
            } catch (const InputError& error) {
                meshes.erase(file);
                errors[file] = error.what();
            }
        }
    }

    void SetUp() override {
        if (meshes.empty()) GTEST_SKIP() << "libcgal-demo is not installed";
    }

    /// Exactly these kinds are found in the file, if there is such a file. Counts the files.
    static void expect_kinds(const std::string& file, const std::vector<MeshDefect>& kinds) {
        if (!reports.contains(file)) return;
        ++known;
        std::vector<MeshDefect> found;
        for (const MeshFinding& f : reports[file].findings) found.push_back(f.kind);
        EXPECT_EQ(found, kinds) << file << ": " << findings_text(reports[file]);
    }

    inline static std::map<std::string, MeshData> meshes;
    inline static std::map<std::string, MeshReport> reports;
    inline static std::map<std::string, std::string> errors;
    inline static int known = 0;
};

TEST_F(MeshFilesTest, MostAreReadAndTheOthersNamed) {
    EXPECT_GT(reports.size(), 10 * errors.size());
    for (const auto& [file, error] : errors) EXPECT_THAT(error, HasSubstr(file));
}

TEST_F(MeshFilesTest, ReportsAreConsistent) {
    for (const auto& [file, report] : reports) {
        EXPECT_EQ(report.triangles, meshes[file].triangles.size()) << file;
        EXPECT_GE(report.components, 1u) << file;
        EXPECT_GT(report.traits.mean_edge_length, 0) << file;
        if (report.closed) {
            EXPECT_EQ(report.find(border_edge), nullptr) << file;
        }
        for (const MeshFinding& f : report.findings) {
            EXPECT_GT(f.count, 0u) << file;
            EXPECT_EQ(f.places.size(),
                      std::min(f.count, constants::finding_places) * ids_per_place(element(f.kind)))
                << file;
        }
    }
}

TEST_F(MeshFilesTest, ReportsSayWhatMeshesDo) {
    int simple = 0;
    for (const auto& [file, report] : reports) {
        if (report.triangles > few_triangles) continue;
        const Mesh mesh(file, meshes[file]);
        EXPECT_EQ(report.closed, mesh.traits().closed()) << file;
        EXPECT_EQ(report.find(degenerate_triangle) == nullptr,
                  mesh.traits().degenerate_triangles == 0)
            << file;
        if (!mesh.view().simple || mesh.inside().rule != Inside::closed) continue;
        ++simple;
        for (const MeshDefect defect :
             {border_edge, flipped_edge, non_manifold_edge, inside_out, self_intersection})
            EXPECT_EQ(report.find(defect), nullptr) << file << ": " << name(defect);
        EXPECT_EQ(report.components, 1u) << file;
    }
    EXPECT_GT(simple, 30);
}

TEST_F(MeshFilesTest, KnownMeshes) {
    for (const char* file :
         {"cube.off", "bunny00.off", "elephant.off", "anchor.off", "armadillo.off", "knot1.off"})
        expect_kinds(file, {});
    for (const char* file : {"hedra_open.off", "open_cube.off", "lion-head.off", "blob.off"})
        expect_kinds(file, {border_edge});
    expect_kinds("tetrahedron.off", {inside_out});
    expect_kinds("tet-shuffled.off", {flipped_edge});
    expect_kinds("degtri_sliding.off", {border_edge, degenerate_triangle});
    expect_kinds("cube-ouvert.off", {border_edge, unused_vertex});
    expect_kinds("quads_to_stitch.off", {border_edge, duplicate_vertex});
    expect_kinds("camel.off", {self_intersection});
    expect_kinds("tetra_intersected_by_triangle.off", {border_edge, inside_out, self_intersection});
    EXPECT_GE(known, 12) << "of 17 files, as packages differ";
}

}  // namespace
}  // namespace pierce::scenes
