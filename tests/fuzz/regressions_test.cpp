// Programs that once broke a promise: small, found by the fuzzer or by people, each named after
// what was wrong.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "fuzz/judge.hpp"

namespace pierce::fuzz {
namespace {

std::vector<std::string> programs() {
    std::vector<std::string> names;
    for (const auto& entry : std::filesystem::directory_iterator(PIERCE_REGRESSIONS))
        if (entry.path().extension() == ".json") names.push_back(entry.path().stem().string());
    std::ranges::sort(names);
    return names;
}

class RegressionTest : public testing::TestWithParam<std::string> {};

TEST_P(RegressionTest, KeepsEveryPromise) {
    std::ifstream file(std::filesystem::path(PIERCE_REGRESSIONS) / (GetParam() + ".json"));
    const Program program = program_of({std::istreambuf_iterator<char>(file), {}});
    JudgeCounts counts;
    const auto failure = judge(program, test::backends(), counts);
    EXPECT_FALSE(failure) << failure->kind << "\n" << failure->text;
    EXPECT_GT(counts.steps, 0u);
}

TEST(RegressionProgramsTest, AreThere) { EXPECT_GE(programs().size(), 18u); }

INSTANTIATE_TEST_SUITE_P(Programs, RegressionTest, testing::ValuesIn(programs()),
                         [](const auto& made) { return made.param; });

}  // namespace
}  // namespace pierce::fuzz
