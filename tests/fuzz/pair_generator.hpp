#pragma once

#include <cstdint>
#include <map>
#include <string>

#include "fuzz/choices.hpp"
#include "fuzz/program.hpp"

namespace pierce::fuzz {

/// How two bodies are placed.
enum class Placement : std::uint8_t {
    anywhere,      ///< as near as their sizes
    any_features,  ///< so deep that they come apart in a random direction
    two_edges,     ///< likewise, and what comes apart last are two edges, if there is such a place
    inner,         ///< likewise, but what comes apart are any two features
    onto,          ///< a corner, an edge or a face lies on a corner, an edge or a face
    two_faces,     ///< two faces lie against each other
    grid,          ///< whole numbers, quarter turns
    contained,     ///< one within the other, or nearly
    count
};

const char* name_of(Placement placement);

/// Two solids, placed so that most overlap a little, touch or nearly do, as a program that makes a
/// world of them and detects once.
struct SolidPair {
    Placement placement = Placement::anywhere;
    Program program;
};

/// The pairs of a seed, by number. Their meshes come from a pool: most of the time of a small world
/// is spent on measuring its meshes.
class PairGenerator {
public:
    PairGenerator(std::uint64_t seed, std::uint32_t meshes) : seed_(seed), mesh_count_(meshes) {}

    SolidPair pair(std::uint64_t number);

private:
    const MeshData& mesh(std::uint32_t number);

    std::uint64_t seed_;
    std::uint32_t mesh_count_;
    std::map<std::uint32_t, MeshData> meshes_;
};

}  // namespace pierce::fuzz
