#include "page/scene_page.hpp"

#include <fstream>
#include <nlohmann/json.hpp>
#include <string_view>
#include <utility>

#include "core/base/whole_file.hpp"
#include "page/frame_store.hpp"
#include "page/packed_arrays.hpp"
#include "page/template.hpp"

namespace pierce::page {

using nlohmann::json;

struct ScenePage::State {
    Options options;
    FrameStore store;
    json figures = json::array();
};

ScenePage::ScenePage(Options options) : state_(new State{std::move(options), {}}) {}
ScenePage::~ScenePage() = default;

void ScenePage::add(World& world, const json& figures) {
    state_->store.add(world, state_->options.body_names, state_->options.reasons);
    state_->figures.push_back(figures);
}

std::uint32_t ScenePage::frame_count() const { return state_->store.frame_count(); }

namespace {

/// Text between tags.
std::string escaped(std::string_view text) {
    std::string result;
    for (char c : text) switch (c) {
            case '&':
                result += "&amp;";
                break;
            case '<':
                result += "&lt;";
                break;
            case '>':
                result += "&gt;";
                break;
            default:
                result += c;
        }
    return result;
}

}  // namespace

void ScenePage::write(const std::filesystem::path& file, const json& made_with,
                      const std::function<void(double)>& progress) const {
    PackedArrays arrays;
    json description{{"title", state_->options.title},
                     {"dt", state_->options.dt},
                     {"has_reasons", state_->options.reasons},
                     {"figures", state_->figures},
                     {"made_with", made_with}};
    state_->store.pack(arrays, description);
    write_whole_file(file, [&](std::ostream& out) {
        std::string_view rest(page_template);
        for (const auto& [mark, text] :
             {std::pair("<!--title-->", escaped(state_->options.title)),
              std::pair("<!--data-->", arrays.text(std::move(description), progress))}) {
            const std::size_t at = rest.find(mark);
            out << rest.substr(0, at) << text;
            rest.remove_prefix(at + std::string_view(mark).size());
        }
        out << rest;
    });
}

}  // namespace pierce::page
