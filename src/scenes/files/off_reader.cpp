#include <algorithm>
#include <optional>
#include <string>
#include <vector>

#include "scenes/files/mesh_readers.hpp"
#include "scenes/files/text_scanner.hpp"

namespace pierce::scenes {
namespace {

class OffReader {
public:
    explicit OffReader(std::string_view content) : text_(content, '#') {}

    MeshData read() {
        read_header();
        // Files mostly have a line for each vertex and face, which may hold more than is needed.
        by_lines_ = count_lines() >= vertices_ + faces_;
        for (std::uint64_t v = 0; v < vertices_; ++v) {
            if (by_lines_) next_line_with_words();
            float at[3];
            for (float& x : at) x = static_cast<float>(number());
            mesh_.positions.push_back({at[0], at[1], at[2]});
        }
        std::vector<std::uint32_t> corners;
        for (; read_faces_ < faces_; ++read_faces_) {
            if (by_lines_) next_line_with_words();
            corners.clear();
            for (std::uint32_t left = index(); left > 0; --left) corners.push_back(index());
            add_polygon(corners, mesh_);
        }
        if (by_lines_) text_.skip_line();  // colours
        if (!text_.next_word().empty()) text_.refuse("is more than the header promises");
        return std::move(mesh_);
    }

private:
    void read_header() {
        const std::string_view keyword = text_.next_word();
        if (!keyword.ends_with("OFF") || keyword.find_first_not_of("STCN") != keyword.size() - 3)
            throw InputError("it does not begin with OFF, or is of more than three dimensions");
        has_more_ = keyword != "OFF";
        std::string_view word = text_.next_word();
        if (word == "BINARY") throw InputError("binary OFF files cannot be read");
        for (std::uint64_t* count : {&vertices_, &faces_}) {
            const auto number = whole_number_of<std::uint64_t>(word);
            if (!number) text_.refuse("does not tell how many vertices and faces there are");
            *count = *number;
            word = count == &vertices_ ? text_.next_word() : std::string_view{};
        }
        text_.next_word_in_line();  // the number of edges
    }

    /// The lines with words that are left; none if the first one holds more than the header.
    std::uint64_t count_lines() const {
        TextScanner text = text_;
        std::uint64_t count = 0;
        if (!text.next_word_in_line().empty()) return 0;
        while (text.next_line()) count += !text.next_word_in_line().empty();
        return count;
    }

    void next_line_with_words() {
        while (text_.next_line())
            if (text_.line().find_first_not_of(" \t") != std::string_view::npos) return;
        end();
    }

    std::string_view word() {
        const std::string_view found = by_lines_ ? text_.next_word_in_line() : text_.next_word();
        if (!found.empty()) return found;
        if (by_lines_) text_.refuse("is cut short");
        end();
    }
    double number() {
        const std::optional<double> found = number_of(word());
        if (!found) text_.refuse("is no vertex");
        return *found;
    }
    std::uint32_t index() {
        const auto found = whole_number_of<std::uint32_t>(word());
        if (!found) text_.refuse("is no face");
        return *found;
    }
    [[noreturn]] void end() const {
        throw InputError("it is cut short: its header promises " + std::to_string(vertices_) +
                         " vertices and " + std::to_string(faces_) + " faces, it holds " +
                         std::to_string(mesh_.positions.size()) + " and " +
                         std::to_string(read_faces_) +
                         (has_more_ ? "; vertices with more than positions need a line each" : ""));
    }

    TextScanner text_;
    std::uint64_t vertices_ = 0, faces_ = 0, read_faces_ = 0;
    bool has_more_ = false;  ///< than positions
    bool by_lines_ = true;
    MeshData mesh_;
};

}  // namespace

MeshData read_off(std::string_view content) { return OffReader(content).read(); }

}  // namespace pierce::scenes
