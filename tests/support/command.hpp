#pragma once

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>

namespace pierce::test {

/// What came of a command.
struct Outcome {
    int code = -1;
    std::string text;  ///< standard output and error
};

/// Runs the pierce command, in `folder` if one is given.
inline Outcome pierce(const std::string& arguments, const std::string& folder = ".") {
    Outcome outcome;
    std::FILE* pipe = popen(
        ("cd '" + folder + "' && " + PIERCE_APP + " " + arguments + " 2>&1").c_str(), "r");
    for (char buffer[4096]; const std::size_t n = std::fread(buffer, 1, sizeof buffer, pipe);)
        outcome.text.append(buffer, n);
    outcome.code = WEXITSTATUS(pclose(pipe));
    return outcome;
}

/// Expects the command to end as it does for bad input, with a message that says `why`.
inline void expect_refused(const std::string& arguments, const std::string& why) {
    const Outcome outcome = pierce(arguments);
    EXPECT_EQ(outcome.code, 2) << arguments << "\n" << outcome.text;
    EXPECT_NE(outcome.text.find(why), std::string::npos) << arguments << "\n" << outcome.text;
}

/// A folder of its own that goes away with the test.
class AppTest : public testing::Test {
protected:
    AppTest()
        : folder(std::filesystem::temp_directory_path() /
                 ("pierce_app_" + std::to_string(::getpid()))) {
        std::filesystem::create_directories(folder);
    }
    ~AppTest() override { std::filesystem::remove_all(folder); }

    std::string path(const std::string& name) const { return (folder / name).string(); }
    nlohmann::json read(const std::string& name) const {
        return nlohmann::json::parse(std::ifstream(folder / name));
    }

    std::filesystem::path folder;
};

}  // namespace pierce::test
