#pragma once

#include <charconv>
#include <cstddef>
#include <cstdlib>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>

#include "pierce/error.hpp"

namespace pierce::scenes {

/// The text of a file, from its start to its end, line by line and word by word. Lines end with
/// LF, CR LF or CR. A byte order mark is passed over.
class TextScanner {
public:
    /// `comment`: begins what is passed over up to the end of its line; 0: nothing does.
    explicit TextScanner(std::string_view text, char comment = 0) : rest_(text), comment_(comment) {
        if (rest_.starts_with("\xef\xbb\xbf")) rest_.remove_prefix(3);
    }

    /// Goes to the next line; false at the end of the text.
    bool next_line() {
        if (rest_.empty()) {
            line_ = {};
            return false;
        }
        ++number_;
        const std::size_t end = rest_.find_first_of("\r\n");
        line_ = rest_.substr(0, end);
        if (end == std::string_view::npos) {
            rest_ = {};
        } else {
            rest_.remove_prefix(end + (rest_.substr(end).starts_with("\r\n") ? 2 : 1));
        }
        if (comment_ != 0) line_ = line_.substr(0, line_.find(comment_));
        return true;
    }

    /// The next word of the line; empty at its end. Spaces and tabs separate words.
    std::string_view next_word_in_line() {
        const std::size_t begin = line_.find_first_not_of(blanks);
        if (begin == std::string_view::npos) {
            line_ = {};
            return {};
        }
        line_.remove_prefix(begin);
        const std::string_view word = line_.substr(0, line_.find_first_of(blanks));
        line_.remove_prefix(word.size());
        return word;
    }

    /// The next word, of this line or a later one; empty at the end of the text.
    std::string_view next_word() {
        for (;;) {
            const std::string_view word = next_word_in_line();
            if (!word.empty() || !next_line()) return word;
        }
    }

    /// What is left of the line.
    std::string_view line() const { return line_; }
    void set_line(std::string_view line) { line_ = line; }
    void skip_line() { line_ = {}; }
    /// What follows the line.
    std::string_view rest() const { return rest_; }

    /// Throws InputError that names the line.
    [[noreturn]] void refuse(const std::string& why) const {
        throw InputError("line " + std::to_string(number_) + " " + why);
    }

private:
    static constexpr std::string_view blanks = " \t\v\f";

    std::string_view rest_, line_;
    char comment_ = 0;
    std::size_t number_ = 0;
};

/// A decimal number, "nan" or "inf"; nothing if the word is no number. What is beyond float64 is
/// infinite, or zero.
inline std::optional<double> number_of(std::string_view word) {
    if (word.starts_with('+')) {
        word.remove_prefix(1);
        if (word.starts_with('-')) return std::nullopt;
    }
    double value = 0;
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
    if (error == std::errc::invalid_argument || end != word.data() + word.size())
        return std::nullopt;
    if (error == std::errc::result_out_of_range)
        return std::strtod(std::string(word).c_str(), nullptr);
    return value;
}

/// A whole number; nothing if the word is none, or does not fit.
template <class Int>
std::optional<Int> whole_number_of(std::string_view word) {
    if (word.starts_with('+')) {
        word.remove_prefix(1);
        if (word.starts_with('-')) return std::nullopt;
    }
    Int value = 0;
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
    if (error != std::errc() || end != word.data() + word.size()) return std::nullopt;
    return value;
}

}  // namespace pierce::scenes
