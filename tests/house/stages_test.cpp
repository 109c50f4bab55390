// docs/step.md has the table of stages, and a step runs those that its plan names.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "pierce/plan.hpp"
#include "pierce/reference_backends.hpp"
#include "pierce/stage.hpp"
#include "pierce/world.hpp"
#include "scenes/named/shapes.hpp"

namespace pierce {
namespace {

const std::filesystem::path root = PIERCE_SOURCE_FOLDER;

/// A row of docs/step.md as it is to be.
std::string row_of(const StageInfo& stage) {
    std::string page = stage.page;
    if (page.starts_with("step.md#")) page = page.substr(7);
    return "| [" + std::string(stage.name) + "](" + page + ") | " + stage.when + " | " +
           stage.reads + " | " + stage.writes + " |";
}

TEST(StagesTest, ThePageHasTheTable) {
    std::ifstream in(root / "docs/step.md");
    std::vector<std::string> rows, expected;
    for (std::string line; std::getline(in, line);)
        if (line.starts_with("| [")) rows.push_back(line);
    for (const StageInfo& stage : stage_table()) expected.push_back(row_of(stage));
    EXPECT_EQ(rows, expected);
}

TEST(StagesTest, AStepRunsWhatItsPlanNames) {
    for (const Coverage coverage : {Coverage::vertices, Coverage::overlaps, Coverage::complete})
        for (const Temporal temporal : {Temporal::off, Temporal::paper, Temporal::certified})
            for (const bool reproject : {false, true})
                for (const char* bodies : {"solids", "sheet", "both", "folded", "velocities"}) {
                    Settings settings;
                    settings.coverage = coverage;
                    settings.temporal = temporal;
                    settings.reproject = reproject;
                    World world(bvh_backend(), settings);
                    const std::string kind = bodies;
                    const MeshData box = scenes::box({0, 0, 0}, {1, 1, 1});
                    const MeshId mesh = world.add_mesh("box", box);
                    if (kind == "solids" || kind == "both") {
                        world.add_fixed_body(mesh);
                        world.add_rigid_body(
                            mesh, {.position = {0.5, 0.5, 0.5}, .rotation = {0, 0, 0, 1}});
                    }
                    if (kind != "solids") {
                        const BodyId body = world.add_deforming_body(mesh, box.positions);
                        world.set_collision(
                            body,
                            {.self = kind == "velocities" ? SelfCollision::rays : SelfCollision::on,
                             .sheet = kind != "folded"});
                    }
                    world.detect();
                    std::vector<StageId> ran;
                    for (const StageTime& t : world.stats().stages) ran.push_back(t.stage);
                    EXPECT_EQ(ran, world.plan().stages) << kind;
                }
}

TEST(StagesTest, EveryStageHasItsName) {
    for (const StageInfo& stage : stage_table()) EXPECT_STREQ(name_of(stage.id), stage.name);
    EXPECT_EQ(stage_table().size(), 18u);
}

}  // namespace
}  // namespace pierce
