#pragma once

#include <filesystem>
#include <vector>

#include "pierce/inside.hpp"

namespace pierce::app {

struct CheckOptions {
    std::vector<std::filesystem::path> meshes;
    bool self_intersections = false;
    Inside inside = Inside::automatic;
    std::filesystem::path fix;   ///< where the mesh goes, repaired; empty: nowhere
    std::filesystem::path json;  ///< empty: none
};

/// What is wrong with mesh files. Returns 0 if nothing changes what detection finds, 1 if something
/// does, 2 if a file cannot be read; the other files are checked all the same.
int check(const CheckOptions& options);

}  // namespace pierce::app
