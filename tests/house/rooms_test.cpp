// Who may include whom, as docs/map.md says, and no way around that leads back.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <functional>
#include <map>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <vector>

namespace pierce {
namespace {

namespace fs = std::filesystem;

const fs::path root = PIERCE_SOURCE_FOLDER;

std::string text_of(const fs::path& path) {
    std::ifstream in(path);
    return {std::istreambuf_iterator<char>(in), {}};
}

/// All that stands in backquotes.
std::vector<std::string> quoted(const std::string& text) {
    static const std::regex pattern("`([^`]+)`");
    std::vector<std::string> found;
    for (std::sregex_iterator at(text.begin(), text.end(), pattern), end; at != end; ++at)
        found.push_back((*at)[1]);
    return found;
}

/// The rows of the table in docs/map.md under a heading, as cells.
std::vector<std::vector<std::string>> rows_under(const std::string& heading) {
    std::istringstream in(text_of(root / "docs/map.md"));
    std::vector<std::vector<std::string>> rows;
    bool here = false;
    for (std::string line; std::getline(in, line);) {
        if (line.starts_with("## ")) here = line == "## " + heading;
        if (!here || !line.starts_with("| `")) {
            // Of "What people look for" the first cell is plain text.
            if (!here || !line.starts_with("| ") || line.find('`') == std::string::npos) continue;
        }
        std::vector<std::string> cells;
        std::istringstream cut(line.substr(1));
        for (std::string cell; std::getline(cut, cell, '|');) cells.push_back(cell);
        rows.push_back(cells);
    }
    return rows;
}

/// The sources of the library by the names they are included by, and what they include of it.
std::map<std::string, std::set<std::string>> includes() {
    static const std::regex pattern("#include \"([^\"]+)\"");
    const fs::path src = root / "src";
    std::map<std::string, std::set<std::string>> all;
    for (const auto& entry : fs::recursive_directory_iterator(src)) {
        const std::string kind = entry.path().extension();
        if (kind != ".hpp" && kind != ".cpp" && kind != ".cuh" && kind != ".cu" && kind != ".h")
            continue;
        std::string name = fs::relative(entry.path(), src);
        if (const auto at = name.find("/include/"); at != std::string::npos)
            name = name.substr(at + 9);
        const std::string text = text_of(entry.path());
        auto& of_file = all[name];
        for (std::sregex_iterator at(text.begin(), text.end(), pattern), end; at != end; ++at)
            of_file.insert((*at)[1]);
    }
    return all;
}

std::string room_of(const std::string& file) {
    return file.starts_with("pierce/") ? "pierce" : fs::path(file).parent_path().string();
}

TEST(RoomsTest, FilesIncludeWhatTheMapAllows) {
    std::map<std::string, std::set<std::string>> allowed;
    for (const auto& cells : rows_under("Rooms")) {
        const auto rooms = quoted(cells[2]);
        allowed[quoted(cells[0]).at(0)] = {rooms.begin(), rooms.end()};
    }
    ASSERT_GT(allowed.size(), 15u);
    std::set<std::string> used;
    for (const auto& [file, included] : includes()) {
        const std::string room = room_of(file);
        used.insert(room);
        if (room != "pierce") {
            ASSERT_TRUE(allowed.contains(room))
                << file << " is in a room that docs/map.md does not name";
        }
        for (const std::string& other : included) {
            const std::string its = room_of(other);
            if (its == room || its == "pierce") continue;
            EXPECT_TRUE(room != "pierce" && allowed[room].contains(its))
                << file << " includes " << other;
        }
    }
    for (const auto& [room, others] : allowed)
        EXPECT_TRUE(used.contains(room)) << "docs/map.md names " << room;
}

TEST(RoomsTest, NoFileIncludesItselfByAnyWayAround) {
    const auto all = includes();
    std::map<std::string, int> state;  // 1: on the way, 2: done
    std::vector<std::string> way;
    std::string cycle;
    const std::function<void(const std::string&)> visit = [&](const std::string& file) {
        state[file] = 1;
        way.push_back(file);
        const auto found = all.find(file);
        if (found != all.end())
            for (const std::string& other : found->second) {
                if (state[other] == 1 && cycle.empty()) {
                    for (const std::string& step : way) cycle += step + " > ";
                    cycle += other;
                }
                if (state[other] == 0 && all.contains(other)) visit(other);
            }
        way.pop_back();
        state[file] = 2;
    };
    for (const auto& [file, included] : all)
        if (state[file] == 0) visit(file);
    EXPECT_EQ(cycle, "");
}

TEST(RoomsTest, WorldReachesNoStage) {
    const auto all = includes();
    std::set<std::string> reached;
    std::vector<std::string> open{"pierce/world.hpp"};
    while (!open.empty()) {
        const std::string file = open.back();
        open.pop_back();
        if (!reached.insert(file).second) continue;
        EXPECT_TRUE(file.starts_with("pierce/")) << file;
        ASSERT_TRUE(all.contains(file)) << file;
        open.insert(open.end(), all.at(file).begin(), all.at(file).end());
    }
    EXPECT_LT(reached.size(), 25u);
}

/// How many values stand between a brace and the one that closes it, and whether the first is
/// named. Strings are skipped.
std::pair<int, bool> values_in(const std::string& text, std::size_t open) {
    int depth = 0, values = 1;
    bool in_string = false;
    for (std::size_t at = open; at < text.size(); ++at) {
        const char c = text[at];
        if (c == '"' && text[at - 1] != '\\') in_string = !in_string;
        if (in_string) continue;
        depth += c == '{' || c == '(' || c == '[';
        depth -= c == '}' || c == ')' || c == ']';
        values += c == ',' && depth == 1;
        if (depth == 0) break;
    }
    const std::size_t first = text.find_first_not_of(" \n", open + 1);
    return {values, first != std::string::npos && (text[first] == '.' || text[first] == '}')};
}

// With more than three values nobody sees which is which.
TEST(RoomsTest, StructsAreFilledByName) {
    static const std::regex declared(R"(\bstruct (?:alignas\(\d+\) )?(\w+))"),
        comment(R"(//[^\n]*)"), filled(R"(\b(?:\w+::)*([A-Z]\w+)(?:<[^{};()]*>)?(?: \w+)?\{)"),
        declares(R"(\b(?:struct|class|enum)\s+(?:\w+::)*$)");
    // Their members are x, y, z and w.
    const std::set<std::string> vectors{"Vec3", "Quaternion"};
    std::map<fs::path, std::string> sources;
    std::set<std::string> structs;
    for (const auto& entry : fs::recursive_directory_iterator(root / "src")) {
        if (!entry.is_regular_file()) continue;
        const std::string text = std::regex_replace(text_of(entry.path()), comment, "");
        for (std::sregex_iterator at(text.begin(), text.end(), declared), end; at != end; ++at)
            structs.insert((*at)[1]);
        sources[entry.path()] = text;
    }
    std::size_t named_ones = 0;
    for (const auto& [path, text] : sources)
        for (std::sregex_iterator at(text.begin(), text.end(), filled), end; at != end; ++at) {
            const auto begin = static_cast<std::size_t>(at->position());
            const std::string before = text.substr(begin < 30 ? 0 : begin - 30,
                                                   std::min<std::size_t>(begin, 30));
            if (!structs.contains((*at)[1]) || vectors.contains((*at)[1]) ||
                std::regex_search(before, declares))
                continue;
            const auto [values, named] = values_in(
                text, begin + static_cast<std::size_t>(at->length()) - 1);
            named_ones += named;
            EXPECT_TRUE(named || values <= 3)
                << path << ": " << at->str() << " has " << values << " values";
        }
    EXPECT_GT(named_ones, 100u);
}

// A test lies in the room of what it tests.
TEST(RoomsTest, TestsMirrorTheRooms) {
    std::size_t tests = 0;
    for (const char* module : {"core", "cpu_embree", "bullet", "c_api", "scenes", "app"})
        for (const auto& entry : fs::recursive_directory_iterator(root / "tests" / module)) {
            if (entry.path().extension() != ".cpp") continue;
            ++tests;
            const fs::path room = fs::relative(entry.path().parent_path(), root / "tests");
            EXPECT_TRUE(fs::exists(root / "src" / room)) << entry.path();
            EXPECT_TRUE(room != "core") << entry.path() << " is in no room";
        }
    EXPECT_GT(tests, 25u);
}

TEST(RoomsTest, WhatTheMapNamesIsThere) {
    const auto rows = rows_under("What people look for");
    ASSERT_GT(rows.size(), 10u);
    for (const auto& cells : rows) {
        const std::string path = quoted(cells[1]).at(0);
        EXPECT_TRUE(fs::exists(root / path)) << path;
    }
}

}  // namespace
}  // namespace pierce
