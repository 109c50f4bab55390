// What docs point at is there: links, and files by their names.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <regex>
#include <set>
#include <string>
#include <vector>

namespace pierce {
namespace {

namespace fs = std::filesystem;

const fs::path root = PIERCE_SOURCE_FOLDER;

std::vector<fs::path> pages() {
    std::vector<fs::path> found;
    for (const char* folder : {"", "docs", "bench", "data"})
        for (const auto& entry : fs::directory_iterator(root / folder))
            if (entry.path().extension() == ".md") found.push_back(entry.path());
    return found;
}

std::string text_of(const fs::path& path) {
    std::ifstream in(path);
    return {std::istreambuf_iterator<char>(in), {}};
}

std::vector<std::string> matches(const std::string& text, const std::regex& pattern) {
    std::vector<std::string> found;
    for (std::sregex_iterator at(text.begin(), text.end(), pattern), end; at != end; ++at)
        found.push_back((*at)[1]);
    return found;
}

/// What a heading is linked by.
std::string anchor_of(const std::string& heading) {
    std::string anchor;
    for (const char c : heading)
        if (std::isalnum(static_cast<unsigned char>(c)) || c == '_' || c == '-')
            anchor += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
        else if (c == ' ')
            anchor += '-';
    return anchor;
}

TEST(DocsTest, LinksLeadSomewhere) {
    std::size_t links = 0;
    for (const fs::path& page : pages()) {
        for (const std::string& link : matches(text_of(page), std::regex(R"(\]\(([^)\s]+)\))"))) {
            if (link.starts_with("http")) continue;
            ++links;
            const std::size_t hash = link.find('#');
            const fs::path target = hash == 0 ? page : page.parent_path() / link.substr(0, hash);
            ASSERT_TRUE(fs::exists(target)) << page << " links to " << link;
            if (hash == std::string::npos || target.extension() != ".md") continue;
            std::set<std::string> anchors;
            for (const std::string& heading :
                 matches(text_of(target), std::regex(R"(\n#+ ([^\n]+))")))
                anchors.insert(anchor_of(heading));
            EXPECT_TRUE(anchors.contains(link.substr(hash + 1))) << page << " links to " << link;
        }
    }
    EXPECT_GT(links, 20u);
}

TEST(DocsTest, NoPageIsEmpty) {
    for (const fs::path& page : pages()) EXPECT_GT(text_of(page).size(), 100u) << page;
}

TEST(DocsTest, FilesThatAreNamedAreThere) {
    std::vector<std::string> files;
    for (const char* folder : {"src", "tests", "bench", "data", "docs", "cmake", "python"})
        for (const auto& entry : fs::recursive_directory_iterator(root / folder))
            if (entry.is_regular_file())
                files.push_back((fs::path("/") / fs::relative(entry.path(), root)).string());
    std::size_t names = 0;
    for (const fs::path& page : pages())
        for (const std::string& name :
             matches(text_of(page), std::regex(R"(([\w/]+\.(?:hpp|cpp|cuh|cu|cmake))\b)"))) {
            ++names;
            const std::string end = name.starts_with("/") ? name : std::string("/").append(name);
            const bool known = std::ranges::any_of(
                files, [&](const std::string& file) { return file.ends_with(end); });
            EXPECT_TRUE(known) << page << " names " << name;
        }
    EXPECT_GT(names, 40u);
}

/// The lines of a page that are prose: no code, no tables, no headings.
std::vector<std::string> prose_of(const fs::path& page) {
    std::ifstream in(page);
    std::vector<std::string> lines;
    bool code = false;
    for (std::string line; std::getline(in, line);) {
        if (line.find("```") != std::string::npos) code = !code;
        if (!code && !line.starts_with("|") && !line.starts_with("#") && !line.starts_with("```"))
            lines.push_back(line);
    }
    return lines;
}

TEST(DocsTest, ALineHoldsOneSentence) {
    static const std::regex two(R"([^.][.!?]\)? +[A-Z])"),
        abbreviation(R"(\b(et al|e\.g|i\.e)\. )"), quoted("`[^`]*`");
    std::size_t lines = 0;
    for (const fs::path& page : pages())
        for (const std::string& line : prose_of(page)) {
            const std::string plain = std::regex_replace(std::regex_replace(line, quoted, "x"),
                                                         abbreviation, "");
            EXPECT_FALSE(std::regex_search(plain, two)) << page << ": " << line;
            ++lines;
        }
    EXPECT_GT(lines, 500u);
}

TEST(DocsTest, CodeIsNoWiderThanAHundredColumns) {
    for (const char* folder : {"src", "tests", "bench", "docs/examples", "python"})
        for (const auto& entry : fs::recursive_directory_iterator(root / folder)) {
            const fs::path kind = entry.path().extension();
            if (kind != ".hpp" && kind != ".cpp" && kind != ".cuh" && kind != ".cu" &&
                kind != ".h" && kind != ".c")
                continue;
            std::ifstream in(entry.path());
            for (std::string line; std::getline(in, line);)
                EXPECT_LE(std::count_if(line.begin(), line.end(),
                                        [](char c) { return (c & 0xc0) != 0x80; }),
                          100)
                    << entry.path() << ": " << line;
        }
}

TEST(DocsTest, LongFilesAreExceptionsOfTheStyle) {
    const std::string style = text_of(root / "docs/style.md");
    for (const auto& entry : fs::recursive_directory_iterator(root / "src")) {
        const std::string text = entry.is_regular_file() ? text_of(entry.path()) : "";
        if (std::ranges::count(text, '\n') <= 400) continue;
        EXPECT_NE(style.find('`' + entry.path().filename().string() + '`'), std::string::npos)
            << entry.path() << " has more than 400 lines";
    }
}

}  // namespace
}  // namespace pierce
