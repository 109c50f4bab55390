#include "app/output/self_contained.hpp"

#include <md4c-html.h>

#include <fstream>
#include <iterator>
#include <regex>

#include "page/base64.hpp"
#include "pierce/error.hpp"

namespace pierce::app {
namespace {

namespace fs = std::filesystem;

constexpr const char* style = R"(
:root { color-scheme: light dark; }
body { font: 16px/1.5 system-ui, sans-serif; max-width: 70em; margin: 2em auto; padding: 0 1em; }
table { border-collapse: collapse; display: block; overflow-x: auto; margin: 1em 0; }
th, td { border: 1px solid #8888; padding: 0.25em 0.6em; text-align: left; }
img { max-width: 100%; height: auto; }
)";

void append(const char* text, MD_SIZE size, void* to) {
    static_cast<std::string*>(to)->append(text, size);
}

std::string data_of(const fs::path& picture) {
    std::ifstream in(picture, std::ios::binary);
    const std::string bytes{std::istreambuf_iterator<char>(in), {}};
    if (bytes.empty()) throw InputError("cannot read '" + picture.string() + "'");
    const char* kind = picture.extension() == ".svg" ? "svg+xml" : "png";
    return std::string("data:image/") + kind + ";base64," + page::base64(bytes);
}

}  // namespace

std::string self_contained_html(const std::string& title, const std::string& markdown,
                                const fs::path& folder) {
    std::string body;
    md_html(markdown.data(), static_cast<MD_SIZE>(markdown.size()), append, &body,
            MD_DIALECT_GITHUB, 0);
    std::string page =
        "<!doctype html>\n<html lang=\"en\">\n<meta charset=\"utf-8\">\n"
        "<meta name=\"viewport\" content=\"width=device-width\">\n<title>" +
        title + "</title>\n<style>" + style + "</style>\n";
    static const std::regex shown("<img src=\"([^\":]+)\"");
    auto rest = body.cbegin();
    for (std::sregex_iterator at(body.cbegin(), body.cend(), shown), end; at != end; ++at) {
        page.append(rest, (*at)[0].first);
        page += "<img src=\"" + data_of(folder / (*at)[1].str()) + '"';
        rest = (*at)[0].second;
    }
    page.append(rest, body.cend());
    return page + "</html>\n";
}

}  // namespace pierce::app
