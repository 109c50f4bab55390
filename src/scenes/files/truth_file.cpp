#include "scenes/files/truth_file.hpp"

#include <fstream>
#include <nlohmann/json.hpp>

#include "pierce/error.hpp"

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
            frame.frame = entry.at("frame");
            frame.overlapping = entry.at("overlapping");
            if (entry.contains("inside"))
                for (const json& v : entry.at("inside"))
                    frame.inside.push_back(
                        {v.at(0), v.at(1), v.at(2), v.at(3), {v.at(4), v.at(5), v.at(6)}});
            frames.push_back(std::move(frame));
        }
        return frames;
    } catch (const json::exception& error) {
        throw InputError("'" + file.string() + "' is not a truth file: " + error.what());
    }
}

}  // namespace pierce::scenes
