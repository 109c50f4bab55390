#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "pierce/world.hpp"

namespace pierce::page {

/// One HTML file that plays what a world did: bodies, contacts, charts, and why vertices have no
/// contact. The file asks for no other. docs/page.md says what it shows.
class ScenePage {
public:
    struct Options {
        std::string title;
        std::map<BodyId, std::string> body_names = {};  ///< the others have their mesh's
        double dt = 0;                                  ///< [s] from frame to frame; 0: unknown
        bool reasons = true;  ///< why vertices have no contact, which takes
                              ///< longer than to detect
    };

    explicit ScenePage(Options options);
    ~ScenePage();

    /// Keeps the world's bodies and contacts as the last detect() saw them, as the next frame.
    /// `figures`: what charts show of the frame; of objects in it, such as times by stage, each
    /// member. Throws InputError if bodies were added, removed, moved or changed since, or have
    /// their places in device memory.
    void add(World& world, const nlohmann::json& figures);
    std::uint32_t frame_count() const;

    /// Writes the page. `made_with`: machine, versions and settings, and whatever else the page
    /// shall say of itself; `tables`, an array of {title, columns, rows}, is shown as tables.
    /// The file is there as a whole or not at all. `progress` is told the share that is done.
    /// Throws InputError if the file cannot be written.
    void write(const std::filesystem::path& file, const nlohmann::json& made_with,
               const std::function<void(double share)>& progress = {}) const;

private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace pierce::page
