// The words of docs/glossary.md are used, and none of those it replaces.
#include <gtest/gtest.h>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

namespace pierce {
namespace {

namespace fs = std::filesystem;

const fs::path root = PIERCE_SOURCE_FOLDER;

std::string lower(std::string text) {
    std::ranges::transform(text, text.begin(),
                           [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    return text;
}

std::string text_of(const fs::path& path) {
    std::ifstream in(path);
    return lower({std::istreambuf_iterator<char>(in), {}});
}

struct Entry {
    std::vector<std::string> words, instead_of;
};

std::vector<std::string> listed(const std::string& cell) {
    std::vector<std::string> words;
    std::istringstream in(cell);
    for (std::string word; std::getline(in, word, ',');) {
        const auto begin = word.find_first_not_of(' ');
        if (begin == std::string::npos) continue;
        words.push_back(lower(word.substr(begin, word.find_last_not_of(' ') - begin + 1)));
    }
    return words;
}

std::vector<Entry> glossary() {
    std::ifstream in(root / "docs/glossary.md");
    std::vector<Entry> entries;
    for (std::string line; std::getline(in, line);) {
        if (!line.starts_with("| ") || line.starts_with("| word")) continue;
        std::vector<std::string> cells;
        std::istringstream cut(line.substr(1));
        for (std::string cell; std::getline(cut, cell, '|');) cells.push_back(cell);
        entries.push_back({listed(cells.at(0)), listed(cells.at(2))});
    }
    return entries;
}

/// True if `word` stands in `text` with no letter before or behind it.
bool has_word(const std::string& text, const std::string& word) {
    for (std::size_t at = text.find(word); at != std::string::npos; at = text.find(word, at + 1)) {
        const bool begins = at == 0 || !std::isalpha(static_cast<unsigned char>(text[at - 1]));
        const std::size_t end = at + word.size();
        if (begins && (end == text.size() || !std::isalpha(static_cast<unsigned char>(text[end]))))
            return true;
    }
    return false;
}

/// Pages, and sources of the library itself: adapters speak of Bullet's things, too.
std::vector<fs::path> texts() {
    std::vector<fs::path> found{root / "README.md"};
    for (const auto& entry : fs::directory_iterator(root / "docs"))
        if (entry.path().extension() == ".md" && entry.path().filename() != "glossary.md")
            found.push_back(entry.path());
    for (const char* module : {"src/core", "src/cpu_embree", "src/gpu_cuda", "src/c_api"})
        for (const auto& entry : fs::recursive_directory_iterator(root / module))
            if (entry.is_regular_file()) found.push_back(entry.path());
    return found;
}

TEST(WordsTest, NoneIsUsedThatTheGlossaryReplaces) {
    const std::vector<Entry> entries = glossary();
    ASSERT_GT(entries.size(), 30u);
    std::size_t replaced = 0;
    for (const fs::path& path : texts()) {
        const std::string text = text_of(path);
        for (const Entry& entry : entries)
            for (const std::string& word : entry.instead_of) {
                ++replaced;
                EXPECT_FALSE(has_word(text, word))
                    << path << " has '" << word << "'; the word is '" << entry.words[0] << "'";
            }
    }
    EXPECT_GT(replaced, 1000u);
}

TEST(WordsTest, TheGlossarysWordsAreUsed) {
    std::string all;
    for (const fs::path& path : texts()) all += text_of(path);
    for (const Entry& entry : glossary())
        for (const std::string& word : entry.words) EXPECT_TRUE(has_word(all, word)) << word;
}

}  // namespace
}  // namespace pierce
