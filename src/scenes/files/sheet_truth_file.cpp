#include "scenes/files/sheet_truth_file.hpp"

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>

#include "pierce/error.hpp"
#include "scenes/files/json_index.hpp"

namespace pierce::scenes {

using nlohmann::json;

double TrueSheetFrame::self_penetration() const {
    double deepest = 0;
    for (const PiercingEdge& p : piercings)
        if (p.a == p.b) deepest = std::max(deepest, p.depth);
    return deepest;
}

std::vector<TrueSheetFrame> read_sheet_truth(const std::filesystem::path& file) {
    std::ifstream in(file);
    if (!in) throw InputError("cannot open '" + file.string() + "'");
    try {
        const json content = json::parse(in);
        if (content.at("format") != "pierce-sheet-truth" || content.at("version") != 1)
            throw InputError("'" + file.string() + "' is not a truth file of sheets of version 1");
        std::vector<TrueSheetFrame> frames;
        for (const json& entry : content.at("frames")) {
            const auto index = [&](const json& value) {
                return index_in(value, "'" + file.string() + "' is not a truth file of sheets");
            };
            TrueSheetFrame frame{index(entry.at("frame")), {}, {}};
            for (const json& m : entry.at("meetings"))
                frame.meetings.push_back({.edges = m.at(0) == 1,
                                          .a = index(m.at(1)),
                                          .item = index(m.at(2)),
                                          .b = index(m.at(3)),
                                          .other = index(m.at(4))});
            for (const json& p : entry.at("piercings"))
                frame.piercings.push_back({.a = index(p.at(0)),
                                           .edge = index(p.at(1)),
                                           .b = index(p.at(2)),
                                           .triangle = index(p.at(3)),
                                           .depth = p.at(4)});
            frames.push_back(std::move(frame));
        }
        return frames;
    } catch (const json::exception& error) {
        throw InputError("'" + file.string() + "' is not a truth file of sheets: " + error.what());
    }
}

}  // namespace pierce::scenes
