#include <optional>
#include <string>
#include <vector>

#include "scenes/files/mesh_readers.hpp"
#include "scenes/files/text_scanner.hpp"

namespace pierce::scenes {
namespace {

/// Joins a line that ends in a backslash to the next ones; `joined` then holds its text.
void join_lines(TextScanner& text, std::string& joined) {
    const auto goes_on = [&] {
        const std::string_view line = text.line();
        const std::size_t last = line.find_last_not_of(" \t");
        return last != std::string_view::npos && line[last] == '\\';
    };
    if (!goes_on()) return;
    joined.clear();
    while (goes_on()) {
        joined += text.line().substr(0, text.line().find_last_of('\\'));
        joined += ' ';
        if (!text.next_line()) break;
    }
    joined += text.line();
    text.set_line(joined);
}

/// The vertex that a corner names: `7`, `7/1`, `7//3` or `7/1/3`.
std::uint32_t vertex_of(std::string_view corner, std::size_t vertices, const TextScanner& text) {
    const auto number = whole_number_of<std::int64_t>(corner.substr(0, corner.find('/')));
    if (!number) text.refuse("has a corner that is no vertex: " + std::string(corner));
    const std::int64_t vertex = *number < 0 ? static_cast<std::int64_t>(vertices) + *number
                                            : *number - 1;
    if (*number == 0 || vertex < 0 || vertex > std::int64_t{0xffffffff})
        text.refuse("names a vertex that cannot be: " + std::string(corner));
    return static_cast<std::uint32_t>(vertex);
}

}  // namespace

MeshData read_obj(std::string_view content) {
    MeshData mesh;
    TextScanner text(content, '#');
    std::string joined;
    std::vector<std::uint32_t> corners;
    while (text.next_line()) {
        join_lines(text, joined);
        const std::string_view keyword = text.next_word_in_line();
        if (keyword == "v") {
            float at[3];
            for (float& x : at) {
                const std::optional<double> number = number_of(text.next_word_in_line());
                if (!number) text.refuse("is no vertex");
                x = static_cast<float>(*number);
            }
            mesh.positions.push_back({at[0], at[1], at[2]});
        } else if (keyword == "f") {
            corners.clear();
            for (std::string_view word = text.next_word_in_line(); !word.empty();
                 word = text.next_word_in_line())
                corners.push_back(vertex_of(word, mesh.positions.size(), text));
            add_polygon(corners, mesh);
        }
    }
    return mesh;
}

}  // namespace pierce::scenes
