// The contacts of the scenes are what they were: one hash per scene, coverage and memory, the same
// for every backend and number of threads. PIERCE_WRITE_GOLDEN=1 writes the file anew; CHANGELOG.md
// says why it changed.
#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>
#include <map>
#include <sstream>

#include "scenes/detect/detector.hpp"
#include "scenes/recording/recording.hpp"
#include "scenes/simulate/simulation.hpp"
#include "support/backends.hpp"

namespace pierce {
namespace {

using namespace scenes;

constexpr double dt = 1.0 / 60;

struct Case {
    const char* scene;
    bool soft;
    std::uint32_t nodes = 0;  ///< 0: the scene's own number
};

constexpr Case cases[] = {{"tori", false},       {"tori", true},          {"bunnies", false},
                          {"bunnies", true},     {"cloth-capsule", true}, {"cloth-fold", true},
                          {"cloth-catch", true}, {"cloth-twist", true},   {"ball-squash", true},
                          {"layers", true, 3}};

Recording record(const Case& wanted) {
    const SceneSetup scene = make_scene(wanted.scene, {8, wanted.soft, 3, wanted.nodes});
    Simulation simulation(scene, Method::rays, {"embree", 1});
    Recording recording = start_recording(scene, dt);
    for (int i = 0; i < 120; ++i) {
        simulation.step(dt);
        if (i % 10 == 9) simulation.record(recording);
    }
    return recording;
}

/// A hash over all frames, and how many contacts they have.
std::string result(const Recording& recording, const RaySettings& settings) {
    const auto detector = make_detector(scene_of(recording), Method::rays, settings);
    std::uint64_t hash = 0xcbf29ce484222325ull, contacts = 0;
    for (std::uint32_t f = 0; f < recording.frame_count; ++f) {
        put_frame(*detector, recording, f);
        const FrameResult frame = detector->detect();
        hash = (hash ^ frame.hash) * 0x100000001b3ull;
        contacts += frame.contacts;
    }
    std::ostringstream text;
    text << std::hex << hash << std::dec << ' ' << contacts;
    return text.str();
}

std::string name_of(const Case& c, Coverage coverage, Temporal temporal) {
    static constexpr const char* memories[] = {"off", "paper", "certified"};
    static constexpr const char* coverages[] = {"vertices ", "complete ", "overlaps "};
    return std::string(c.scene) + (c.soft ? " soft " : " rigid ") +
           coverages[static_cast<int>(coverage)] + memories[static_cast<int>(temporal)];
}

std::map<std::string, std::string> golden() {
    std::map<std::string, std::string> all;
    std::ifstream file(PIERCE_GOLDEN);
    for (std::string line; std::getline(file, line);)
        if (const std::size_t at = line.find(": "); at != std::string::npos)
            all[line.substr(0, at)] = line.substr(at + 2);
    return all;
}

TEST(GoldenTest, ContactsAreWhatTheyWere) {
    const bool writes = std::getenv("PIERCE_WRITE_GOLDEN") != nullptr;
    const std::map<std::string, std::string> expected = golden();
    std::ofstream file;
    if (writes) file.open(PIERCE_GOLDEN);
    for (const Case& c : cases) {
        const Recording recording = record(c);
        for (const Coverage coverage : {Coverage::vertices, Coverage::overlaps, Coverage::complete})
            for (const Temporal temporal : {Temporal::off, Temporal::paper, Temporal::certified}) {
                const Settings settings{.coverage = coverage,
                                        .reproject = coverage == Coverage::overlaps,
                                        .temporal = temporal,
                                        .may_rest = false};
                const std::string name = name_of(c, coverage, temporal);
                const std::string found = result(recording, {"embree", 1, settings});
                if (writes) {
                    file << name << ": " << found << '\n';
                    continue;
                }
                ASSERT_TRUE(expected.contains(name)) << name;
                EXPECT_EQ(found, expected.at(name)) << name;
                for (const int threads : {2, 3, 8})
                    EXPECT_EQ(result(recording, {"embree", threads, settings}), found) << name;
                EXPECT_EQ(result(recording, {"bvh", 1, settings}), found) << name;
                if (test::has_backend("cuda")) {
                    EXPECT_EQ(result(recording, {"cuda", 1, settings}), found) << name;
                }
            }
    }
}

}  // namespace
}  // namespace pierce
