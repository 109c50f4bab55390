#include "app/output/gnuplot.hpp"

#include <fmt/core.h>

#include <cstdio>
#include <cstdlib>
#include <string_view>

namespace pierce::app {

std::string quoted(const std::string& text) {
    std::string result = "'";
    for (char c : text) {
        if (c == '\'') result += '\'';
        result += c;
    }
    return result + "'";
}

std::string styled(const std::string& text, const std::string& style) {
    std::string result;
    for (char c : text) {
        if (std::string_view("{}^_@&~\\").find(c) != std::string_view::npos) result += '\\';
        result += c;
    }
    return style.empty() ? result : "{/:" + style + " " + result + "}";
}

std::string svg_output(const std::filesystem::path& svg, int width, int height, int font_size) {
    return fmt::format(
        "set terminal svg size {},{} font 'sans-serif,{}' background 'white'\nset output {}\n",
        width, height, font_size, quoted(svg.string()));
}

bool run_gnuplot(const std::string& script) {
    if (std::system("command -v gnuplot >/dev/null 2>&1") != 0) return false;
    std::FILE* pipe = popen("gnuplot", "w");
    if (pipe == nullptr) return false;
    std::fputs(script.c_str(), pipe);
    return pclose(pipe) == 0;
}

}  // namespace pierce::app
