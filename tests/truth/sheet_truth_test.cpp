// What sheets truly meet from frame to frame, against hand-made cases and all pairs by definition,
// and the program that writes it down.
#include "truth/sheet_truth.hpp"

#include <gmock/gmock.h>
#include <unistd.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <limits>

#include "core/mesh/mesh_view.hpp"
#include "pierce/error.hpp"
#include "scenes/files/sheet_truth_file.hpp"
#include "scenes/named/shapes.hpp"
#include "support/random.hpp"
#include "truth/exact_continuous.hpp"

namespace pierce::truth {
namespace {

namespace fs = std::filesystem;
using scenes::box;
using scenes::grid;
using scenes::joined;
using scenes::moved;
using testing::HasSubstr;
using testing::IsEmpty;

class SheetTruthTest : public testing::Test {
protected:
    scenes::Recording recording{0.01, 2, {}, {}};

    /// A sheet and where its vertices are in each frame.
    void add_sheet(const MeshData& mesh, const std::vector<std::vector<Vec3f>>& frames) {
        scenes::RecordedBody body{
            "sheet", add_mesh(mesh), Motion::deforming, false, {}, {SelfCollision::on, true, 0.01}};
        for (const std::vector<Vec3f>& positions : frames)
            for (Vec3f p : positions) body.values.insert(body.values.end(), {p.x, p.y, p.z});
        recording.bodies.push_back(body);
    }
    void add_fixed(const MeshData& mesh) {
        recording.bodies.push_back(
            {"fixed", add_mesh(mesh), Motion::fixed, false, {0, 0, 0, 0, 0, 0, 1}, {}});
    }
    std::uint32_t add_mesh(const MeshData& mesh) {
        recording.meshes.push_back({"mesh " + std::to_string(recording.meshes.size()), mesh, {}});
        return static_cast<std::uint32_t>(recording.meshes.size() - 1);
    }
    std::vector<SheetMeeting> meetings() const { return SheetTruth(recording).meetings(1); }
};

/// One triangle in the plane x = `x`, its lowest corner at z = `z`.
MeshData upright(float x, float z) {
    return {{{x, -0.5f, z + 1}, {x, 0.5f, z + 1}, {x, 0, z}}, {{{0, 1, 2}}}};
}

/// A triangle around the z axis at z = 0.
MeshData level() { return {{{-1, -1, 0}, {3, -1, 0}, {-1, 3, 0}}, {{{0, 1, 2}}}}; }

TEST_F(SheetTruthTest, AVertexThroughAPlateInOneStepMeetsBothSides) {
    // Hard case 24: from z = 1 to z = -1 through abs(z) <= 0.005.
    add_fixed(box({-1, -1, -0.005f}, {1, 1, 0.005f}));
    const MeshData mesh{{{0.1f, 0.2f, 1}, {0.2f, 0.2f, 1.5f}, {0.1f, 0.3f, 1.5f}}, {{{0, 1, 2}}}};
    add_sheet(mesh, {mesh.positions, moved(mesh.positions, {0, 0, -2})});
    int of_lowest = 0;
    for (const SheetMeeting& m : meetings())
        of_lowest += m.features == Features::vertex_and_face && m.a == 1 && m.item == 0 && m.b == 0;
    EXPECT_EQ(of_lowest, 2) << "a triangle of the upper side, and one of the lower";
}

TEST_F(SheetTruthTest, LayersThatMoveTogetherMeetNothing) {
    // Hard case 25: 0.1 apart, both by 0.2.
    const MeshData lower = grid(1, 1, 4, 4);
    const MeshData mesh = joined(lower,
                                 {moved(lower.positions, {0.03f, 0.02f, 0.1f}), lower.triangles});
    add_sheet(mesh, {mesh.positions, moved(mesh.positions, {0, 0, 0.2f})});
    EXPECT_THAT(meetings(), IsEmpty());
    EXPECT_THAT(SheetTruth(recording).piercings(1), IsEmpty());
}

TEST_F(SheetTruthTest, TouchingAtTheEndOfAStepIsMeeting) {
    add_sheet(level(), {level().positions, level().positions});
    const MeshData tip = upright(0, 0);
    add_sheet(tip, {upright(0, 1).positions, tip.positions});
    EXPECT_THAT(meetings(),
                testing::ElementsAre(SheetMeeting{Features::vertex_and_face, 1, 2, 0, 0}));
    EXPECT_THAT(SheetTruth(recording).piercings(1), IsEmpty()) << "touching is not piercing";
    recording.bodies[1].values.back() = 0x1p-100f;
    EXPECT_THAT(meetings(), IsEmpty());
}

TEST_F(SheetTruthTest, AnEdgeThroughATriangleIsAsDeepAsItsNearerEnd) {
    add_sheet(level(), {level().positions, level().positions});
    const MeshData tip = upright(0, -0.25f);
    add_sheet(tip, {tip.positions, tip.positions});
    const std::vector<Piercing> found = SheetTruth(recording).piercings(1);
    ASSERT_EQ(found.size(), 2u) << "both edges at the tip";
    for (const Piercing& p : found) {
        EXPECT_EQ(p.a, 1u);
        EXPECT_EQ(p.b, 0u);
        EXPECT_EQ(p.depth, 0.25);
    }
    EXPECT_THAT(meetings(), IsEmpty()) << "nothing moves, and no two borders touch";
}

TEST_F(SheetTruthTest, AFoldThatClosesMeetsItself) {
    // Three squares in a row, the middle one a ramp; the last one turns over it, down onto the
    // first and a little through.
    const MeshData strip = grid(3, 1, 4, 2);
    std::vector<Vec3f> flat = strip.positions;
    for (Vec3f& p : flat) p.z = p.x > 0 ? 0.25f : 0.0f;
    std::vector<Vec3f> open = flat, through = flat;
    for (std::size_t v = 0; v < flat.size(); ++v) {
        if (flat[v].x < 1) continue;
        open[v] = {0.5f, 0.8f * flat[v].y, 1};
        through[v] = {-0.75f, 0.8f * flat[v].y, -0.03125f};
    }
    add_sheet(strip, {flat, open, through});
    recording.frame_count = 3;
    const SheetTruth truth(recording);
    EXPECT_THAT(truth.meetings(1), IsEmpty());
    EXPECT_THAT(truth.piercings(1), IsEmpty());
    int vertices = 0;
    for (const SheetMeeting& m : truth.meetings(2))
        vertices += m.features == Features::vertex_and_face && m.a == m.b;
    EXPECT_GE(vertices, 2) << "both corners that went through";
    const std::vector<Piercing> piercings = truth.piercings(2);
    ASSERT_FALSE(piercings.empty());
    EXPECT_EQ(std::ranges::max(piercings, {}, &Piercing::depth).depth, 0.03125)
        << "as deep as the corners are below";
}

TEST_F(SheetTruthTest, OnlySheetsAreLookedAtAndOnlyIfAsked) {
    const MeshData mesh = joined(level(), upright(0, 1));
    std::vector<Vec3f> end = mesh.positions;
    for (std::size_t v = 3; v < 6; ++v) end[v].z -= 1.5f;
    add_sheet(mesh, {mesh.positions, end});
    EXPECT_EQ(meetings().size(), 1u);
    recording.bodies[0].collision.self = SelfCollision::off;
    EXPECT_THAT(meetings(), IsEmpty());
    add_fixed(box({-1, -1, -1}, {1, 1, -0.1f}));
    EXPECT_FALSE(meetings().empty()) << "with another body, sheets always";
    recording.excluded = {{0, 1}};
    EXPECT_THAT(meetings(), IsEmpty());
    recording.excluded.clear();
    recording.bodies[0].collision.sheet = false;
    EXPECT_THAT(meetings(), IsEmpty());
}

TEST_F(SheetTruthTest, ABodyThatIsNotFiniteIsLeftOut) {
    const MeshData mesh = joined(level(), upright(0, 1));
    std::vector<Vec3f> end = moved(mesh.positions, {0, 0, 0});
    for (std::size_t v = 3; v < 6; ++v) end[v].z -= 1.5f;
    add_sheet(mesh, {mesh.positions, end});
    ASSERT_FALSE(meetings().empty());
    recording.bodies[0].values[0] = std::numeric_limits<float>::quiet_NaN();
    EXPECT_THAT(meetings(), IsEmpty());
    EXPECT_THAT(SheetTruth(recording).piercings(0), IsEmpty());
}

TEST_F(SheetTruthTest, AgreesWithAllPairsByDefinition) {
    test::Random random(7);
    const MeshData first = joined(grid(1, 1, 3, 3),
                                  {moved(grid(0.8, 0.8, 3, 3).positions, {0.1f, 0, 0.1f}),
                                   grid(0.8, 0.8, 3, 3).triangles}),
                   second = grid(1, 1, 4, 4),
                   solid = box({-0.2f, -0.2f, -0.2f}, {0.2f, 0.2f, 0.2f});
    const auto shaken = [&](std::vector<Vec3f> positions, double by) {
        for (Vec3f& p : positions) p += to_float(random.in_box(by));
        return positions;
    };
    for (const MeshData* mesh : {&first, &second}) {
        const std::vector<Vec3f> start = shaken(mesh->positions, 0.05);
        add_sheet(*mesh, {start, shaken(start, 0.15)});
    }
    add_fixed(solid);

    struct Body {
        Mesh mesh;
        std::vector<MovingPoint> points;
    };
    std::vector<Body> bodies;
    for (std::uint32_t b = 0; b < 3; ++b) {
        const MeshData& data = recording.meshes[recording.bodies[b].mesh].data;
        bodies.push_back({Mesh("body", data), {}});
        for (std::size_t v = 0; v < data.positions.size(); ++v)
            bodies.back().points.push_back(
                b == 2 ? MovingPoint{to_double(data.positions[v]), to_double(data.positions[v])}
                       : MovingPoint{to_double(recording.positions(b, 0)[v]),
                                     to_double(recording.positions(b, 1)[v])});
    }
    std::vector<SheetMeeting> expected;
    for (std::uint32_t a = 0; a < 3; ++a)
        for (std::uint32_t b = 0; b < 3; ++b) {
            if (a == 2 && b == 2) continue;
            const auto& p = bodies[a].points;
            const auto& q = bodies[b].points;
            const auto triangles = bodies[b].mesh.triangles();
            for (std::uint32_t v = 0; v < p.size(); ++v)
                for (std::uint32_t t = 0; t < triangles.size(); ++t) {
                    const auto& c = triangles[t].vertex;
                    if (a == b && has_vertex(triangles[t], v)) continue;
                    if (first_meeting_of_vertex_and_face(exact({p[v], q[c[0]], q[c[1]], q[c[2]]})))
                        expected.push_back({Features::vertex_and_face, a, v, b, t});
                }
            if (a > b) continue;
            const auto edges_a = bodies[a].mesh.view().edges, edges_b = bodies[b].mesh.view().edges;
            for (std::uint32_t e = 0; e < edges_a.size; ++e)
                for (std::uint32_t f = a == b ? e + 1 : 0; f < edges_b.size; ++f) {
                    const auto &i = edges_a[e].vertex, &j = edges_b[f].vertex;
                    if (a == b && (i[0] == j[0] || i[0] == j[1] || i[1] == j[0] || i[1] == j[1]))
                        continue;
                    if (first_meeting_of_edges(exact({p[i[0]], p[i[1]], q[j[0]], q[j[1]]})))
                        expected.push_back({Features::edges, a, e, b, f});
                }
        }
    std::ranges::sort(expected);
    EXPECT_GT(expected.size(), 20u);
    EXPECT_EQ(meetings(), expected);
}

class SheetTruthFileTest : public SheetTruthTest {
protected:
    void SetUp() override {
        folder_ = fs::temp_directory_path() / ("pierce_sheets_" + std::to_string(getpid()));
        fs::remove_all(folder_);
    }
    void TearDown() override { fs::remove_all(folder_); }

    fs::path folder_;
};

TEST_F(SheetTruthFileTest, TheProgramWritesWhatIsTrue) {
    add_sheet(level(), {level().positions, level().positions});
    add_sheet(upright(0, 0), {upright(0, 0.5f).positions, upright(0, -0.25f).positions});
    scenes::write_recording(recording, folder_);
    ASSERT_EQ(std::system((PIERCE_TRUTH " " + folder_.string() + " --sheets").c_str()), 0);
    const std::vector<scenes::TrueSheetFrame> frames = scenes::read_sheet_truth(folder_ /
                                                                                "sheets.json");
    ASSERT_EQ(frames.size(), 2u);
    EXPECT_THAT(frames[0].meetings, IsEmpty());
    const SheetTruth truth(recording);
    const std::vector<SheetMeeting> expected = truth.meetings(1);
    ASSERT_EQ(frames[1].meetings.size(), expected.size());
    for (std::size_t i = 0; i < expected.size(); ++i) {
        const scenes::FeatureMeeting& m = frames[1].meetings[i];
        EXPECT_EQ(expected[i], (SheetMeeting{m.edges ? Features::edges : Features::vertex_and_face,
                                             m.a, m.item, m.b, m.other}));
    }
    ASSERT_EQ(frames[1].piercings.size(), truth.piercings(1).size());
    EXPECT_EQ(frames[1].piercings[0].depth, 0.25);
    EXPECT_EQ(frames[1].self_penetration(), 0) << "of two bodies, not of one";
}

TEST_F(SheetTruthFileTest, OtherFilesAreRefused) {
    fs::create_directories(folder_);
    const auto written = [&](const std::string& text) {
        std::ofstream(folder_ / "sheets.json") << text;
        return folder_ / "sheets.json";
    };
    EXPECT_THROW(scenes::read_sheet_truth(folder_ / "none.json"), InputError);
    for (const char* text :
         {"", "{}", R"({"format": "pierce-truth", "version": 1, "frames": []})",
          R"({"format": "pierce-sheet-truth", "version": 2, "frames": []})",
          R"({"format": "pierce-sheet-truth", "version": 1, "frames": [{"frame": 0}]})"})
        EXPECT_THAT([&] { scenes::read_sheet_truth(written(text)); },
                    testing::ThrowsMessage<InputError>(HasSubstr("sheets.json")))
            << text;
}

}  // namespace
}  // namespace pierce::truth
