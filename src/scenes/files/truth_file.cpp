#include "scenes/files/truth_file.hpp"

#include <fstream>
#include <nlohmann/json.hpp>

#include "pierce/error.hpp"
#include "scenes/files/json_index.hpp"

namespace pierce::scenes {

using nlohmann::json;

std::vector<TrueFrame> read_truth(const std::filesystem::path& file) {
    std::ifstream in(file);
    if (!in) throw InputError("cannot open '" + file.string() + "'");
    try {
        const json content = json::parse(in);
        if (content.at("format") != "pierce-truth" || content.at("version") != 1)
            throw InputError("'" + file.string() + "' is not a truth file of version 1");
        std::vector<TrueFrame> frames;
        for (const json& entry : content.at("frames")) {
            TrueFrame frame;
            const auto index = [&](const json& value) {
                return index_in(value, "'" + file.string() + "' is not a truth file");
            };
            frame.frame = index(entry.at("frame"));
            for (const json& pair : entry.at("overlapping"))
                frame.overlapping.emplace_back(index(pair.at(0)), index(pair.at(1)));
            if (entry.contains("inside"))
                for (const json& v : entry.at("inside"))
                    frame.inside.push_back({.source = index(v.at(0)),
                                            .target = index(v.at(1)),
                                            .vertex = index(v.at(2)),
                                            .depth = v.at(3),
                                            .way_out = {v.at(4), v.at(5), v.at(6)}});
            frames.push_back(std::move(frame));
        }
        return frames;
    } catch (const json::exception& error) {
        throw InputError("'" + file.string() + "' is not a truth file: " + error.what());
    }
}

}  // namespace pierce::scenes
