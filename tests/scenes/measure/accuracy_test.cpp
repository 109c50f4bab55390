// Truth files, and how contacts differ from the truth.
#include "scenes/measure/accuracy.hpp"

#include <gmock/gmock.h>
#include <unistd.h>

#include <fstream>
#include <numbers>
#include <string>
#include <utility>

#include "pierce/error.hpp"
#include "scenes/named/shapes.hpp"

namespace pierce::scenes {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::DoubleEq;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Pair;
using testing::ThrowsMessage;

class TruthFileTest : public testing::Test {
protected:
    TruthFileTest()
        : file(fs::temp_directory_path() /
               ("pierce_truth_" + std::to_string(::getpid()) + ".json")) {}
    ~TruthFileTest() override { fs::remove(file); }

    void write(const std::string& text) const { std::ofstream(file) << text; }

    void expect_refused(const std::string& text, const std::string& why) const {
        write(text);
        EXPECT_THAT([&] { read_truth(file); },
                    ThrowsMessage<InputError>(AllOf(HasSubstr(file.string()), HasSubstr(why))))
            << text;
    }

    static std::string with_frames(const std::string& frames) {
        return R"({"format": "pierce-truth", "version": 1, "every": 2, "frames": )" + frames + "}";
    }

    fs::path file;
};

TEST_F(TruthFileTest, IsReadAsItStands) {
    write(with_frames(R"([{"frame": 0, "overlapping": [], "inside": []},
        {"frame": 2, "overlapping": [[0, 1], [0, 3]], "inside": [[3, 0, 62, 0.25, 0, 0.6, 0.8]]},
        {"frame": 4, "overlapping": [[1, 2]]}])"));
    const std::vector<TrueFrame> frames = read_truth(file);
    ASSERT_EQ(frames.size(), 3u);
    EXPECT_EQ(frames[0].frame, 0u);
    EXPECT_THAT(frames[0].overlapping, IsEmpty());
    EXPECT_EQ(frames[1].frame, 2u);
    EXPECT_THAT(frames[1].overlapping, ElementsAre(Pair(0, 1), Pair(0, 3)));
    ASSERT_EQ(frames[1].inside.size(), 1u);
    const TrueVertex& v = frames[1].inside[0];
    EXPECT_EQ(v.source, 3u);
    EXPECT_EQ(v.target, 0u);
    EXPECT_EQ(v.vertex, 62u);
    EXPECT_EQ(v.depth, 0.25);
    EXPECT_EQ(v.way_out, (Vec3d{0, 0.6, 0.8}));
    EXPECT_THAT(frames[2].inside, IsEmpty()) << "written without vertices";
}

TEST_F(TruthFileTest, AnythingElseIsRefusedByName) {
    EXPECT_THAT(
        [&] { read_truth(file); },
        ThrowsMessage<InputError>(AllOf(HasSubstr(file.string()), HasSubstr("cannot open"))));
    expect_refused("", "is not a truth file");
    expect_refused("[]", "is not a truth file");
    expect_refused("{}", "is not a truth file");
    expect_refused(R"({"format": "pierce-recording", "version": 1, "frames": []})",
                   "is not a truth file of version 1");
    expect_refused(R"({"format": "pierce-truth", "version": 2, "frames": []})",
                   "is not a truth file of version 1");
    expect_refused(R"({"format": "pierce-truth", "version": 1})", "frames");
    expect_refused(with_frames(R"([{"overlapping": []}])"), "frame");
    expect_refused(with_frames(R"([{"frame": 0}])"), "overlapping");
    expect_refused(with_frames(R"([{"frame": 0, "overlapping": [[0, "b"]]}])"),
                   "is not a truth file");
    using Shown = std::pair<std::string, std::string>;
    for (const auto& [number, shown] :
         {Shown{"-1", "-1"}, Shown{"2.5", "2.5"}, Shown{"4294967296", "4294967296"},
          Shown{"184467440737709551615", "1.8446744073770956e+20"}})
        expect_refused(with_frames("[{\"frame\": 0, \"overlapping\": [[0, " + number + "]]}]"),
                       "is not a truth file: " + shown + " is no number");
    expect_refused(with_frames(R"([{"frame": 0, "overlapping": [], "inside": [[0, 1, 2]]}])"),
                   "is not a truth file");
    expect_refused(with_frames("[").substr(0, 60), "is not a truth file");
}

/// Three cubes of side 1; where they stand does not matter here.
class AccuracyTest : public testing::Test {
protected:
    AccuracyTest() {
        recording.meshes = {{"cube", box({0, 0, 0}, {1, 1, 1}), {}}};
        recording.bodies.assign(3, {"cube", 0, Motion::rigid, false, {}});
    }

    /// Two vertices of body 1 are inside body 0, one of body 0 is inside body 1; bodies 1 and 2
    /// overlap by their edges.
    static TrueFrame truth() {
        return {
            0,
            {{0, 1}, {1, 2}},
            {{0, 1, 5, 0.5, {0, 0, 1}}, {1, 0, 3, 0.25, {0, 0, -1}}, {1, 0, 4, 0.125, {0, 1, 0}}}};
    }

    Accuracy accuracy(std::vector<MethodContact> contacts, bool names_vertices = true) const {
        AccuracyCount count(recording, names_vertices);
        count.add(truth(), contacts);
        return count.accuracy();
    }

    // What a method without an error says: normals lead from a to b, a vertex of a leaves b against
    // them.
    const MethodContact first{0, 1, 0, 5, 0.5, {0, 0, -1}};
    const MethodContact second{0, 1, 1, 3, 0.25, {0, 0, -1}};
    const MethodContact third{0, 1, 1, 4, 0.125, {0, 1, 0}};
    const MethodContact edge{1, 2, 1, no_vertex, 0.1, {1, 0, 0}};

    Recording recording;
};

TEST_F(AccuracyTest, OfTheTruthItself) {
    const Accuracy a = accuracy({first, second, third, edge});
    EXPECT_EQ(a.pairs, 2u);
    EXPECT_EQ(a.missed_pairs, 0u);
    EXPECT_EQ(a.false_pairs, 0u);
    EXPECT_EQ(a.vertices, 3u);
    EXPECT_EQ(a.missed_vertices, 0u);
    EXPECT_EQ(a.false_vertices, 0u);
    EXPECT_EQ(a.depth, 0.875);
    EXPECT_EQ(a.missed_depth, 0);
    EXPECT_EQ(a.missed_share(), 0);
    EXPECT_EQ(a.missed_pair_share(), 0);
    EXPECT_THAT(a.depth_ratios, ElementsAre(1, 1, 1));
    EXPECT_THAT(a.normal_errors, ElementsAre(0, 0, 0));
    EXPECT_EQ(a.pair_depth_ratio(), 1);
}

TEST_F(AccuracyTest, OfNothing) {
    const Accuracy a = accuracy({});
    EXPECT_EQ(a.missed_pairs, 2u);
    EXPECT_EQ(a.missed_vertices, 3u);
    EXPECT_EQ(a.missed_share(), 1);
    EXPECT_EQ(a.missed_pair_share(), 1);
    EXPECT_THAT(a.depth_ratios, IsEmpty());
    EXPECT_EQ(a.pair_depth_ratio(), 0);
}

TEST_F(AccuracyTest, MissedVerticesWeighTheirDepth) {
    const Accuracy a = accuracy({second, third, edge});
    EXPECT_EQ(a.missed_pairs, 0u);
    EXPECT_EQ(a.missed_vertices, 1u);
    EXPECT_EQ(a.missed_depth, 0.5);
    EXPECT_EQ(a.missed_share(), 0.5 / 0.875);
    EXPECT_EQ(a.missed_pair_share(), 0);
    EXPECT_EQ(a.pair_depth_ratio(), 0.5)
        << "the deepest contact is half as deep as the deepest vertex";
    EXPECT_EQ(accuracy({first, second, third}).missed_pairs, 1u)
        << "a pair without a vertex inside counts as any other";
}

TEST_F(AccuracyTest, FalseContactsAreThoseWithDepth) {
    const MethodContact pair{0, 2, 0, no_vertex, 0.1, {1, 0, 0}},
        vertex{0, 1, 1, 6, 0.1, {1, 0, 0}};
    const Accuracy a = accuracy({first, second, third, edge, pair, vertex});
    EXPECT_EQ(a.false_pairs, 1u);
    EXPECT_EQ(a.false_vertices, 1u);
    MethodContact touching_pair = pair, touching_vertex = vertex;
    touching_pair.depth = touching_vertex.depth = 0;
    const Accuracy b = accuracy({first, second, third, edge, touching_pair, touching_vertex});
    EXPECT_EQ(b.false_pairs, 0u);
    EXPECT_EQ(b.false_vertices, 0u);
}

TEST_F(AccuracyTest, DepthsAndNormalsAreThoseOfTheVerticesFound) {
    MethodContact deep = first, turned = second;
    deep.depth = 0.75;
    turned.normal = {1, 0, 0};
    const Accuracy a = accuracy({deep, turned, edge});
    EXPECT_THAT(a.depth_ratios, ElementsAre(1.5, 1));
    EXPECT_THAT(a.normal_errors, ElementsAre(0, DoubleEq(std::numbers::pi / 2)));
    EXPECT_EQ(a.pair_depth_ratio(), 1.5);
}

TEST_F(AccuracyTest, NextToTheSurfaceDepthsAreRounding) {
    AccuracyCount count(recording, true);
    count.add({0, {{0, 1}}, {{0, 1, 5, 1e-6, {0, 0, 1}}}},
              std::vector<MethodContact>{{0, 1, 0, 5, 2e-6, {1, 0, 0}}});
    EXPECT_EQ(count.accuracy().missed_vertices, 0u);
    EXPECT_THAT(count.accuracy().depth_ratios, IsEmpty());
    EXPECT_THAT(count.accuracy().normal_errors, IsEmpty());
}

TEST_F(AccuracyTest, MethodsThatNameNoVertexFindThoseOfTheirPairs) {
    const MethodContact unnamed{0, 1, 0, no_vertex, 0.5, {0, 0, -1}};
    const Accuracy generous = accuracy({unnamed}, false);
    EXPECT_EQ(generous.missed_vertices, 0u);
    EXPECT_EQ(generous.missed_pairs, 1u);
    EXPECT_THAT(generous.depth_ratios, IsEmpty());
    EXPECT_EQ(accuracy({unnamed}, true).missed_vertices, 3u);
    EXPECT_EQ(accuracy({edge}, false).missed_vertices, 3u);
}

TEST_F(AccuracyTest, FramesAddUp) {
    AccuracyCount count(recording, true);
    count.add(truth(), std::vector<MethodContact>{first, second, third, edge});
    count.add(truth(), std::vector<MethodContact>{first});
    EXPECT_EQ(count.accuracy().pairs, 4u);
    EXPECT_EQ(count.accuracy().missed_pairs, 1u);
    EXPECT_EQ(count.accuracy().vertices, 6u);
    EXPECT_EQ(count.accuracy().missed_vertices, 2u);
    EXPECT_EQ(count.accuracy().missed_share(), 0.375 / 1.75);
}

}  // namespace
}  // namespace pierce::scenes
