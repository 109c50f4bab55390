// Sheets on recorded motion of all scenes of cloth, in which nothing keeps them off themselves,
// against exact truth: continuous detection misses nothing and invents nothing.
#include <gtest/gtest.h>

#include <algorithm>
#include <map>

#include "scenes/detect/detector.hpp"
#include "scenes/measure/sheet_accuracy.hpp"
#include "scenes/simulate/crossing_motion.hpp"
#include "support/backends.hpp"
#include "truth/sheet_truth.hpp"

namespace pierce {
namespace {

using scenes::SheetAccuracy;
using scenes::SheetPairs;

struct Motion {
    const char* name;
    std::uint32_t nodes;
    double seconds;
    bool self;    ///< it meets itself
    bool others;  ///< it meets other bodies
};

constexpr double dt = 1.0 / 30;

struct Recorded {
    scenes::Recording recording;
    std::vector<scenes::TrueSheetFrame> truth;
};

/// Made once for all backends.
const Recorded& recorded(const Motion& motion) {
    static std::map<std::string, Recorded> all;
    const auto [at, is_new] = all.try_emplace(motion.name);
    Recorded& made = at->second;
    if (!is_new) return made;
    made.recording = scenes::crossing_motion(
        motion.name, {.seconds = motion.seconds, .dt = dt, .nodes = motion.nodes});
    const truth::SheetTruth truth(made.recording);
    for (std::uint32_t f = 0; f < made.recording.frame_count; ++f) {
        scenes::TrueSheetFrame frame{f, {}, {}};
        for (const truth::SheetMeeting& m : truth.meetings(f))
            frame.meetings.push_back(
                {m.features == truth::Features::edges, m.a, m.item, m.b, m.other});
        made.truth.push_back(std::move(frame));
    }
    return made;
}

class RecordedSheetsTest : public testing::TestWithParam<std::tuple<test::NamedBackend, Motion>> {};

TEST_P(RecordedSheetsTest, NothingThatMeetsIsMissedAndNothingElseCrosses) {
    const auto& [backend, motion] = GetParam();
    const auto& [recording, truth] = recorded(motion);
    const scenes::SheetJudge judge(recording);
    const auto detector = scenes::make_detector(scenes::scene_of(recording), backend.make(), {});
    SheetAccuracy self, others;
    for (std::uint32_t f = 0; f < recording.frame_count; ++f) {
        scenes::put_frame(*detector, recording, f);
        detector->detect();
        if (f == 0) continue;
        self += judge.judge(truth[f], detector->world()->contacts(), SheetPairs::self);
        others += judge.judge(truth[f], detector->world()->contacts(), SheetPairs::others);
    }
    EXPECT_EQ(self.meetings() > 0, motion.self);
    EXPECT_EQ(others.meetings() > 0, motion.others);
    for (const SheetAccuracy& a : {self, others}) {
        EXPECT_EQ(a.missed_vertex_meetings, 0u);
        EXPECT_EQ(a.missed_edge_meetings, 0u);
        EXPECT_EQ(a.missed_vertices, 0u);
        EXPECT_EQ(a.wrong, 0u);
    }
}

constexpr Motion motions[] = {{"cloth-capsule", 14, 2.5, true, false},
                              {"cloth-fold", 10, 2.5, true, false},
                              {"cloth-twist", 12, 3, true, false},
                              {"ball-squash", 20, 2, true, true},
                              {"layers", 8, 0.5, false, true}};

INSTANTIATE_TEST_SUITE_P(Backends, RecordedSheetsTest,
                         testing::Combine(testing::ValuesIn(test::backends()),
                                          testing::ValuesIn(motions)),
                         [](const auto& made) {
                             std::string name = std::get<0>(made.param).name + "_" +
                                                std::get<1>(made.param).name;
                             std::ranges::replace(name, '-', '_');
                             return name;
                         });

}  // namespace
}  // namespace pierce
