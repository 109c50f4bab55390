#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "pierce/contact.hpp"
#include "scenes/files/sheet_truth_file.hpp"
#include "scenes/recording/recording.hpp"

namespace pierce::scenes {

/// The meetings that are counted.
enum class SheetPairs : std::uint8_t {
    self,    ///< of a sheet with itself
    others,  ///< of a sheet with another body
};

/// How contacts of sheets compare with what truly meets, summed over steps.
struct SheetAccuracy {
    std::uint64_t vertex_meetings = 0, missed_vertex_meetings = 0;  ///< a vertex and a triangle
    std::uint64_t edge_meetings = 0, missed_edge_meetings = 0;
    /// Vertices that go from one side to the other of a triangle that they meet, per step, and
    /// those of them that have no contact at all. A vertex that slides or rests in a triangle's
    /// plane does not count.
    std::uint64_t vertices = 0, missed_vertices = 0;
    std::uint64_t leaving = 0;  ///< meetings that do not count as missed: a vertex leaves a solid;
                                ///< if anything reports that, it is the vertex's ray
    std::uint64_t crossings = 0;  ///< contacts which say that the two features meet in the step
    std::uint64_t near = 0;       ///< of these, features that do not meet, but come within half a
                                  ///< float32 ulp of a meeting
    std::uint64_t wrong = 0;      ///< of these, all others that do not meet

    std::uint64_t meetings() const { return vertex_meetings + edge_meetings; }
    std::uint64_t missed() const { return missed_vertex_meetings + missed_edge_meetings; }
    /// The part of the true meetings that was found [0..1]; 1 if nothing meets.
    double recall() const;
    /// The part of the reported meetings that are true, or nearly so [0..1]; 1 if none was
    /// reported.
    double precision() const;
    SheetAccuracy& operator+=(const SheetAccuracy& other);
};

/// Compares contacts with what truly meets in the steps of a recording.
class SheetJudge {
public:
    /// The recording must outlive the judge.
    explicit SheetJudge(const Recording& recording);

    /// Compares the contacts after the step that leads to the frame of `truth`, which must not be
    /// the first frame. The contacts name bodies by their index in the recording.
    SheetAccuracy judge(const TrueSheetFrame& truth, std::span<const Contact> contacts,
                        SheetPairs pairs) const;

private:
    using Corners = std::array<Vec3d, 4>;

    bool is_solid(std::uint32_t body, std::uint32_t frame) const;
    Vec3d place(std::uint32_t body, std::uint32_t vertex, std::uint32_t frame,
                std::uint32_t to) const;
    Corners corners(const FeatureMeeting& m, std::uint32_t frame, double time) const;
    bool is_near(const FeatureMeeting& m, std::uint32_t frame, double time) const;
    bool goes_through(const FeatureMeeting& m, std::uint32_t frame) const;
    bool leaves(const FeatureMeeting& m, std::uint32_t frame) const;

    const Recording& recording_;
    std::vector<Mesh> meshes_;
};

}  // namespace pierce::scenes
