#pragma once

#include <compare>
#include <cstdint>
#include <filesystem>
#include <vector>

namespace pierce::scenes {

/// Two features of sheets or other bodies, by their index in the recording: a vertex of a and a
/// triangle of b; or edges of both, a < b, or a = b and item < other.
struct FeatureMeeting {
    bool edges = false;
    std::uint32_t a = 0, item = 0;
    std::uint32_t b = 0, other = 0;

    bool is_self() const { return a == b; }
    friend auto operator<=>(const FeatureMeeting&, const FeatureMeeting&) = default;
};

/// An edge of a that runs through a triangle of b.
struct PiercingEdge {
    std::uint32_t a = 0, edge = 0;
    std::uint32_t b = 0, triangle = 0;
    double depth = 0;  ///< [length] the smaller distance of its ends to the triangle's plane
};

/// What sheets do in a frame, and in the step that leads to it.
struct TrueSheetFrame {
    std::uint32_t frame = 0;
    std::vector<FeatureMeeting> meetings;  ///< sorted
    std::vector<PiercingEdge> piercings;

    /// The deepest edge of a body through itself [length]; 0 if there is none.
    double self_penetration() const;
};

/// Reads what pierce_truth --sheets wrote about a recording. Throws InputError, naming the file,
/// for any other content.
std::vector<TrueSheetFrame> read_sheet_truth(const std::filesystem::path& file);

}  // namespace pierce::scenes
