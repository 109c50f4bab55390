// Recordings and mesh files: what is written is read back, and damage is named.
#include "scenes/recording/recording.hpp"
#include "scenes/recording/lattice.hpp"

#include <gmock/gmock.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <limits>
#include <sstream>

#include "pierce/error.hpp"
#include "scenes/detect/detector.hpp"
#include "scenes/files/mesh_io.hpp"
#include "scenes/files/npy.hpp"
#include "scenes/named/mass_properties.hpp"
#include "scenes/named/shapes.hpp"

namespace pierce::scenes {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::ThrowsMessage;

/// A folder of its own that goes away with the test.
class RecordingTest : public testing::Test {
protected:
    RecordingTest() {
        const auto* test = testing::UnitTest::GetInstance()->current_test_info();
        folder = fs::temp_directory_path() /
                 ("pierce_" + std::string(test->name()) + "_" + std::to_string(::getpid()));
        fs::create_directories(folder);
    }
    ~RecordingTest() override { fs::remove_all(folder); }

    Recording sample() const {
        SceneSetup scene{"sample",
                         {{"ground", box({-5, -5, -1}, {5, 5, 0}), {}}, {"ball", sphere(1, 1), {}}},
                         {}};
        scene.bodies = {{"ground", 0, Motion::fixed, {}, true},
                        {"rigid", 1, Motion::rigid, {}, false},
                        {"soft", 1, Motion::deforming, {}, false}};
        Recording recording = start_recording(scene, 0.01);
        recording.bodies[0].values = {0, 0, 0, 0, 0, 0, 1};
        for (int f = 0; f < 3; ++f) {
            const auto height = static_cast<float>(f);
            for (float v : {0.f, 0.f, height, 0.f, 0.f, 0.f, 1.f})
                recording.bodies[1].values.push_back(v);
            for (Vec3f p : sphere(1, 1).positions)
                for (float v : {p.x, p.y, p.z + 0.1f * height})
                    recording.bodies[2].values.push_back(v);
        }
        recording.frame_count = 3;
        return recording;
    }

    void overwrite(const std::string& file, const std::string& from, const std::string& to) const {
        std::ifstream in(folder / file);
        std::string text((std::istreambuf_iterator<char>(in)), {});
        const std::size_t at = text.find(from);
        ASSERT_NE(at, std::string::npos) << from;
        std::ofstream(folder / file) << text.replace(at, from.size(), to);
    }

    void expect_refused(const std::string& why) const {
        EXPECT_THAT([&] { read_recording(folder); }, ThrowsMessage<InputError>(HasSubstr(why)));
    }

    fs::path folder;
};

TEST_F(RecordingTest, ReadsBackWhatItWrote) {
    const Recording written = sample();
    write_recording(written, folder);
    const Recording read = read_recording(folder);
    EXPECT_EQ(read.dt, written.dt);
    EXPECT_EQ(read.frame_count, 3u);
    ASSERT_EQ(read.bodies.size(), 3u);
    for (std::size_t b = 0; b < 3; ++b) {
        EXPECT_EQ(read.bodies[b].name, written.bodies[b].name);
        EXPECT_EQ(read.bodies[b].motion, written.bodies[b].motion);
        EXPECT_EQ(read.bodies[b].ground, written.bodies[b].ground);
        EXPECT_EQ(read.bodies[b].values, written.bodies[b].values);
        EXPECT_EQ(read.meshes[read.bodies[b].mesh].data.positions,
                  written.meshes[written.bodies[b].mesh].data.positions);
        EXPECT_EQ(read.meshes[read.bodies[b].mesh].data.triangles,
                  written.meshes[written.bodies[b].mesh].data.triangles);
    }
    EXPECT_EQ(read.pose(1, 2).position.z, 2);
    EXPECT_EQ(read.pose(0, 2).rotation.w, 1) << "a static body may have one frame only";
}

/// The sample with a soft body that is a box in frame 1 and a ball again in frame 2.
Recording changing(Recording recording) {
    const MeshData ball = sphere(1, 1), cube = box({-1, -1, -1}, {1, 1, 1});
    recording.meshes.push_back({"cube", cube, {}});
    RecordedBody& soft = recording.bodies[2];
    soft.mesh_changes = {{1, 2}, {2, 1}};
    soft.values.clear();
    for (const MeshData* mesh : {&ball, &cube, &ball})
        for (Vec3f p : mesh->positions) soft.values.insert(soft.values.end(), {p.x, p.y, p.z});
    return recording;
}

TEST_F(RecordingTest, BodiesMayChangeTheirMesh) {
    write_recording(changing(sample()), folder);
    const Recording read = read_recording(folder);
    EXPECT_EQ(read.frame_count, 3u);
    const std::vector<std::uint32_t> meshes{read.mesh_of(2, 0), read.mesh_of(2, 1),
                                            read.mesh_of(2, 2)};
    EXPECT_EQ(meshes, (std::vector<std::uint32_t>{1, 2, 1}));
    for (std::uint32_t f = 0; f < 3; ++f)
        EXPECT_TRUE(
            std::ranges::equal(read.positions(2, f), read.meshes[meshes[f]].data.positions));
    EXPECT_TRUE(std::ranges::equal(read.start_positions(2, 0, 1), read.positions(2, 1)));
    EXPECT_EQ(read.start_positions(2, 0, 2).data(), read.positions(2, 0).data());

    const Recording part = excerpt(read, 1, 2), few = thinned(read, 1);
    EXPECT_EQ(part.bodies[2].mesh, 2u);
    EXPECT_EQ(part.mesh_of(2, 1), 1u);
    EXPECT_TRUE(std::ranges::equal(part.positions(2, 0), read.positions(2, 1)));
    EXPECT_TRUE(std::ranges::equal(part.positions(2, 1), read.positions(2, 2)));
    EXPECT_TRUE(few.bodies[2].mesh_changes.empty());
    EXPECT_THAT([&] { require_lasting_meshes(read, "this"); },
                ThrowsMessage<InputError>(HasSubstr("body 'soft' changes")));
    EXPECT_NO_THROW(require_lasting_meshes(sample(), "this"));
}

TEST_F(RecordingTest, RefusesMeshesThatHaveNotTheirVertices) {
    const Recording changes = changing(sample());
    for (const char* text : {"f 1 2 3\n", "v 0 0 0\nv 1 0 0\nf 1 2 3\n"}) {
        write_recording(changes, folder);
        for (const auto& entry : std::filesystem::directory_iterator(folder))
            if (entry.path().extension() == ".obj") std::ofstream(entry.path()) << text;
        expect_refused("has no vertex");
    }
}

TEST_F(RecordingTest, RefusesChangesThatDoNotFit) {
    write_recording(changing(sample()), folder);
    overwrite("scene.json", "\"frame\": 2", "\"frame\": 1");
    expect_refused("ascending frames");
    write_recording(changing(sample()), folder);
    overwrite("scene.json", "\"version\": 2", "\"version\": 1");
    expect_refused("has version 1, and what is in it has version 2");
    for (const char* other : {"-2", "2.5", "1e300"}) {
        SCOPED_TRACE(other);
        write_recording(changing(sample()), folder);
        overwrite("scene.json", "\"frame\": 2", std::string("\"frame\": ") + other);
        expect_refused("is no number of a frame");
    }
    write_recording(changing(sample()), folder);
    overwrite("scene.json", "\"frame\": 2", "\"frame\": 3");
    expect_refused("whole frames");
    write_recording(changing(sample()), folder);
    overwrite("scene.json", "\"mesh\": \"cube\"", "\"mesh\": \"tube\"");
    expect_refused("unknown mesh 'tube'");
    write_recording(changing(sample()), folder);
    overwrite("scene.json", "\"motion\": \"deforming\"", "\"motion\": \"rigid\"");
    expect_refused("poses");
    Recording longer = changing(sample());
    longer.bodies[2].values.resize(longer.bodies[2].values.size() + 3);
    write_recording(longer, folder);
    expect_refused("whole frames");
}

/// The sample with a body of another chain and world, and an excluded pair.
Recording filtered(Recording recording) {
    recording.bodies[1].filter = {.groups = 0x80000000u, .meets = 3, .chain = 4, .world = 5};
    recording.excluded = {{0, 2}};
    return recording;
}

TEST_F(RecordingTest, FiltersAndExcludedPairsAreKept) {
    write_recording(filtered(sample()), folder);
    const Recording read = read_recording(folder);
    EXPECT_EQ(read.bodies[0].filter, Filter{});
    EXPECT_EQ(read.bodies[1].filter, filtered(sample()).bodies[1].filter);
    EXPECT_EQ(read.excluded, (std::set<BodyPair>{{0, 2}}));
    for (const Recording& part : {excerpt(read, 1, 1), thinned(read, 2), as_deforming(read)}) {
        EXPECT_EQ(part.bodies[1].filter, read.bodies[1].filter);
        EXPECT_EQ(part.excluded, read.excluded);
    }
}

TEST_F(RecordingTest, RefusesFiltersThatDoNotFit) {
    const auto refused = [&](const char* from, const char* to, const char* why) {
        write_recording(filtered(sample()), folder);
        overwrite("scene.json", from, to);
        expect_refused(why);
    };
    refused("\"version\": 3", "\"version\": 2", "has version 2, and what is in it has version 3");
    refused("\"meets\": 3", "\"meets\": -1", "a filter's meets cannot be -1");
    refused("\"meets\": 3", "\"meets\": 4294967296", "a filter's meets cannot be");
    refused("\"chain\": 4", "\"chain\": 4.5", "a filter's chain cannot be 4.5");
    refused("\"world\": 5", "\"world\": -2", "a filter's world cannot be -2");
    refused("\"world\": 5", "\"word\": 5", "a filter has no 'word'");
    refused("      0,\n      2\n", "      0,\n      3\n", "bodies [0,3] are no pair");
    refused("      0,\n      2\n", "      2,\n      2\n", "bodies [2,2] are no pair");
    refused("      0,\n      2\n", "      0\n", "is no list of two bodies");
}

/// Three boxes in one place; no pair of the first two.
TEST(RecordedFiltersTest, EveryMethodFollowsThem) {
    SceneSetup scene{"boxes", {{"box", box({-1, -1, -1}, {1, 1, 1}), {}}}, {}};
    for (const double at : {0.0, 0.5, 1.0})
        scene.bodies.push_back({"box", 0, Motion::rigid, {{at, at, at}, {}}});
    scene.bodies[0].filter.chain = scene.bodies[1].filter.chain = 1;
    scene.excluded = {{0, 2}};
    const auto found = [&](Method method) {
        const auto detector = make_detector(scene, method);
        for (std::uint32_t b = 0; b < 3; ++b) detector->set_pose(b, scene.bodies[b].pose);
        return detector->detect().touching;
    };
    for (const Method method : {Method::rays, Method::gimpact, Method::gjk_hull}) {
        SCOPED_TRACE(static_cast<int>(method));
        EXPECT_EQ(found(method), (std::vector<BodyPair>{{1, 2}}));
    }
}

TEST(RecordingFramesTest, PartsOfARecordingHaveItsFrames) {
    const Recording all = lattice(3, 10, LatticeMotion::soft);
    const Recording part = excerpt(all, 4, 3), few = thinned(all, 5);
    ASSERT_EQ(part.frame_count, 3u);
    ASSERT_EQ(few.frame_count, 5u);
    EXPECT_EQ(few.dt, 2 * all.dt);
    for (std::uint32_t f = 0; f < 3; ++f)
        EXPECT_TRUE(std::ranges::equal(part.positions(1, f), all.positions(1, f + 4)));
    for (std::uint32_t f = 0; f < 5; ++f)
        EXPECT_TRUE(std::ranges::equal(few.positions(2, f), all.positions(2, 2 * f)));
    EXPECT_EQ(excerpt(all, 8, 9).frame_count, 2u) << "no more than there are";
    const Recording rigid = excerpt(lattice(2, 6, LatticeMotion::rigid), 5, 1);
    EXPECT_EQ(rigid.pose(1, 0).position.x,
              lattice(2, 6, LatticeMotion::rigid).pose(1, 5).position.x);
}

TEST_F(RecordingTest, MeshesOfOneNameGetOthers) {
    Recording twins = sample();
    for (SceneMesh& mesh : twins.meshes) mesh.name = "mesh";
    twins.meshes.push_back(twins.meshes[0]);
    twins.meshes.back().name = "mesh 2";
    write_recording(twins, folder);
    const Recording read = read_recording(folder);
    const auto name = [&](std::size_t m) { return read.meshes[m].name; };
    EXPECT_EQ(name(0), "mesh");
    EXPECT_EQ(name(1), "mesh 3");
    EXPECT_EQ(name(2), "mesh 2");
    for (std::size_t b = 0; b < 3; ++b) EXPECT_EQ(read.bodies[b].mesh, twins.bodies[b].mesh);
    overwrite("scene.json", "\"name\": \"mesh 3\"", "\"name\": \"mesh\"");
    expect_refused("two meshes are named 'mesh'");
}

TEST_F(RecordingTest, DamageIsNamed) {
    expect_refused("cannot open");
    write_recording(sample(), folder);
    overwrite("scene.json", "pierce-recording", "other");
    expect_refused("is not a pierce-recording");
    write_recording(sample(), folder);
    overwrite("scene.json", "\"version\": 1", "\"version\": 4");
    expect_refused("version 4");
    write_recording(sample(), folder);
    overwrite("scene.json", "\"dt\": 0.01", "\"dt\": -0.01");
    expect_refused("dt must be positive");
    write_recording(sample(), folder);
    overwrite("scene.json", "\"mesh\": \"ball\"", "\"mesh\": \"bill\"");
    expect_refused("unknown mesh 'bill'");
    write_recording(sample(), folder);
    overwrite("scene.json", "\"motion\": \"rigid\"", "\"motiom\": 1, \"motion\": \"rigid\"");
    expect_refused("a body has no 'motiom'");
    write_recording(sample(), folder);
    overwrite("scene.json", "\"dt\": 0.01", "\"dt\": 0.01, \"dtt\": 3");
    expect_refused("a recording has no 'dtt'");
    write_recording(sample(), folder);
    overwrite("body_1.npy", "<f4", "<f8");
    expect_refused("its numbers are of another type: '<f8'");
    write_recording(sample(), folder);
    overwrite("scene.json", "body_1.npy", "../1.npy");
    expect_refused("is not a file inside the folder");
    write_recording(sample(), folder);
    overwrite("scene.json", "\"dt\"", "\"td\"");
    expect_refused("a recording has no 'td'");
    write_recording(sample(), folder);
    fs::resize_file(folder / "scene.json", 100);
    expect_refused("scene.json");
}

TEST_F(RecordingTest, CollisionsAreReadAndTheirMistakesNamed) {
    Recording recording = sample();
    recording.bodies[2].collision = {.self = SelfCollision::on, .thickness = 0.25, .margin = 0.5};
    write_recording(recording, folder);
    EXPECT_EQ(read_recording(folder).bodies[2].collision, recording.bodies[2].collision);
    overwrite("scene.json", "\"thickness\"", "\"depth\"");
    expect_refused("a collision has no 'depth'");
    write_recording(recording, folder);
    overwrite("scene.json", "\"on\"", "\"perhaps\"");
    expect_refused("self-collision is 'perhaps'");
}

TEST_F(RecordingTest, DamagedArraysAreNamed) {
    write_recording(sample(), folder);
    fs::resize_file(folder / "body_2.npy", fs::file_size(folder / "body_2.npy") - 5);
    expect_refused("body_2.npy");
    write_recording(sample(), folder);
    std::ofstream(folder / "body_1.npy", std::ios::app) << "more";
    expect_refused("body_1.npy");
    write_recording(sample(), folder);
    fs::copy_file(folder / "body_1.npy", folder / "body_2.npy",
                  fs::copy_options::overwrite_existing);
    expect_refused("wrong shape");
    write_recording(sample(), folder);
    const std::vector<float> two(14);
    write_npy(folder / "body_1.npy", std::array<std::size_t, 2>{2, 7}, two);
    expect_refused("frames");
    for (const char* file : {"body_0.npy", "body_1.npy"}) {
        write_recording(sample(), folder);
        write_npy(folder / file, std::array<std::size_t, 2>{0, 7}, {});
        expect_refused("has no frames");
    }
    write_recording(sample(), folder);
    std::ofstream(folder / "body_1.npy") << "no array at all";
    expect_refused("body_1.npy");
}

TEST_F(RecordingTest, MeshFilesKeepTheirOrder) {
    const fs::path off = folder / "two.off", obj = folder / "quad.obj", ply = folder / "tri.ply",
                   stl = folder / "tri.stl";
    std::ofstream(off) << "OFF\n4 2 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n3 0 1 2\n3 0 2 3\n";
    std::ofstream(obj) << "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nf 1/1 2/1 3/1 4/1\n";
    std::ofstream(ply) << "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty "
                          "float y\nproperty float z\n"
                          "element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 "
                          "0\n1 0 0\n0 1 0\n3 0 1 2\n";
    std::ofstream(stl) << "solid s\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 "
                          "0\nvertex 0 1 0\nendloop\nendfacet\n"
                          "endsolid s\n";
    for (const fs::path& file : {off, obj}) {
        const MeshData mesh = read_mesh(file);
        EXPECT_EQ(mesh.positions.size(), 4u);
        EXPECT_EQ(mesh.positions[2], (Vec3f{1, 1, 0}));
        EXPECT_EQ(mesh.triangles, (std::vector<Triangle>{{{0, 1, 2}}, {{0, 2, 3}}}));
    }
    for (const fs::path& file : {ply, stl})
        EXPECT_EQ(read_mesh(file).triangles, (std::vector<Triangle>{{{0, 1, 2}}}));
}

TEST_F(RecordingTest, NonManifoldMeshesAreReadAsTheyAre) {
    const fs::path off = folder / "fan.off";
    std::ofstream(off)
        << "OFF\n5 3 0\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n0 -1 0\n3 0 1 2\n3 0 1 3\n3 0 1 4\n";
    EXPECT_EQ(read_mesh(off).triangles,
              (std::vector<Triangle>{{{0, 1, 2}}, {{0, 1, 3}}, {{0, 1, 4}}}));
    EXPECT_EQ(read_mesh(off).positions.size(), 5u);
}

TEST_F(RecordingTest, UnreadableMeshFilesAreNamed) {
    const auto refused = [](const fs::path& file, const std::string& why) {
        EXPECT_THAT([&] { read_mesh(file); },
                    ThrowsMessage<InputError>(
                        testing::AllOf(HasSubstr(file.filename().string()), HasSubstr(why))));
    };
    refused(folder / "nothing.obj", "cannot open");
    std::ofstream(folder / "noise.obj") << "hello\n";
    refused(folder / "noise.obj", "");
    std::ofstream(folder / "mesh.xyz") << "hello\n";
    refused(folder / "mesh.xyz", "cannot read");
    std::ofstream(folder / "short.off") << "OFF\n4 2 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n3 0 1 2\n";
    refused(folder / "short.off", "cut short");
    std::ofstream(folder / "short.ply")
        << "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
           "property float z\nelement face 2\nproperty list uchar int vertex_indices\n"
           "end_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
    refused(folder / "short.ply", "");
}

TEST_F(RecordingTest, BrokenNumbersAndIndicesAreHandedOn) {
    const std::string ply =
        "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty "
        "float z\nelement face 1\n"
        "property list uchar int vertex_indices\nend_header\n";
    std::ofstream(folder / "nan.off")
        << "OFF\n4 1 0\n0 0 0\nnan 1 -inf\n+1.5e1 1e60 0\n0 0 1\n3 0 1 2\n";
    std::ofstream(folder / "nan.ply") << ply << "0 0 0\nnan 1 -inf\n15 1e60 0\n0 0 1\n3 0 1 2\n";
    std::ofstream(folder / "nan.obj")
        << "v 0 0 0\nv nan 1 -inf\nv +1.5e1 1e60 0\nv 0 0 1\nf 1 2 3\n";
    for (const char* file : {"nan.off", "nan.ply", "nan.obj"}) {
        const MeshData mesh = read_mesh(folder / file);
        EXPECT_TRUE(std::isnan(mesh.positions[1].x)) << file;
        EXPECT_EQ(mesh.positions[1].y, 1) << file;
        EXPECT_LT(mesh.positions[1].z, std::numeric_limits<float>::lowest()) << file;
        EXPECT_EQ(mesh.positions[2].x, 15) << file;
        EXPECT_GT(mesh.positions[2].y, std::numeric_limits<float>::max()) << file;
        EXPECT_EQ(mesh.positions[3], (Vec3f{0, 0, 1})) << file;
        EXPECT_THROW(Mesh("broken", mesh), InputError) << file;
    }
    std::ofstream(folder / "index.off") << "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 7\n";
    std::ofstream(folder / "index.obj") << "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 8\n";
    for (const char* file : {"index.off", "index.obj"})
        EXPECT_EQ(read_mesh(folder / file).triangles, (std::vector<Triangle>{{{0, 1, 7}}})) << file;
    // Without such a vertex all later ones would change their ids.
    for (const char* vertex : {"v 1 0", "v 1 0 up", "v"}) {
        std::ofstream(folder / "none.obj") << "v 0 0 0\n"
                                           << vertex << "\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
        EXPECT_THAT(
            [&] { read_mesh(folder / "none.obj"); },
            ThrowsMessage<InputError>(testing::AllOf(HasSubstr("none.obj"), HasSubstr("line 2"))))
            << vertex;
    }
}

TEST(MassPropertiesTest, OfABoxAndATorus) {
    const MassProperties b = mass_properties(box({1, 1, 1}, {2, 3, 4}));
    EXPECT_NEAR(b.mass, 6, 1e-6);
    EXPECT_NEAR(length(b.center - Vec3d{1.5, 2, 2.5}), 0, 1e-6);
    EXPECT_NEAR(b.inertia.x + b.inertia.y + b.inertia.z, 6.0 / 12 * 2 * (1 + 4 + 9), 1e-5);
    MeshData turned = torus(2, 0.5, 40, 20);
    for (Vec3f& p : turned.positions) p = {p.z + 3, p.x, p.y};
    to_principal_frame(turned);
    const MassProperties t = mass_properties(turned);
    EXPECT_NEAR(length(t.center), 0, 1e-5);
    EXPECT_NEAR(t.inertia.x, t.inertia.y, 1e-3 * t.inertia.x);
    EXPECT_GT(t.inertia.z, 1.5 * t.inertia.x);
    MeshData inside_out = box({0, 0, 0}, {1, 1, 1});
    for (Triangle& triangle : inside_out.triangles)
        std::swap(triangle.vertex[0], triangle.vertex[1]);
    EXPECT_THROW(mass_properties(inside_out), InputError);
}

TEST(SceneTest, ScenesAreWhatTheyClaim) {
    const SceneSetup tori = make_scene("tori");
    EXPECT_EQ(tori.bodies.size(), 101u);
    EXPECT_EQ(tori.meshes[1].data.positions.size(), 300u);
    EXPECT_EQ(tori.meshes[1].data.triangles.size(), 600u);
    EXPECT_EQ(tori.meshes[1].convex_pieces.size(), 30u);
    const SceneSetup bunnies = make_scene("bunnies", {7, true, 2});
    EXPECT_EQ(bunnies.bodies.size(), 8u);
    EXPECT_EQ(bunnies.bodies[1].motion, Motion::deforming);
    EXPECT_EQ(bunnies.meshes[1].data.positions.size(), 453u);
    EXPECT_EQ(bunnies.meshes[1].data.triangles.size(), 902u);
    const Mesh bunny("bunny", bunnies.meshes[1].data);
    EXPECT_TRUE(bunny.traits().closed());
    EXPECT_GT(bunny.traits().volume, 0);
    EXPECT_THAT([] { make_scene("toris"); },
                ThrowsMessage<InputError>(HasSubstr("unknown scene 'toris'; there are: tori")));
    EXPECT_THROW(make_scene("tori", {0, false, 1}), InputError);
}

}  // namespace
}  // namespace pierce::scenes
