#pragma once

#include <span>
#include <vector>

#include "scenes/detect/method.hpp"
#include "scenes/files/truth_file.hpp"
#include "scenes/recording/recording.hpp"

namespace pierce::scenes {

/// How a method's contacts differ from the truth, added up over frames.
struct Accuracy {
    std::uint64_t pairs = 0;         ///< that overlap
    std::uint64_t missed_pairs = 0;  ///< of these, without a contact
    std::uint64_t false_pairs = 0;   ///< pairs that do not overlap but have a contact of some depth
    std::uint64_t vertices = 0;      ///< inside another body
    std::uint64_t missed_vertices = 0;  ///< of these, not found: see AccuracyCount
    std::uint64_t false_vertices = 0;   ///< vertices that are found with some depth, but are not
                                        ///< inside
    double depth = 0;                   ///< [length] summed over the vertices inside
    double missed_depth = 0;            ///< [length] summed over the missed ones
    double missed_pair_depth = 0;      ///< [length] summed over the vertices inside of missed pairs
    std::vector<double> depth_ratios;  ///< per vertex found: its contact's depth over the true one
    std::vector<double> normal_errors;  ///< [rad] per vertex found: the angle between its contact's
                                        ///< normal and the way out
    double pair_depth = 0;        ///< [length] depth of the deepest vertex, summed over pairs found
    double found_pair_depth = 0;  ///< [length] depth of the deepest contact, summed over pairs
                                  ///< found

    /// Part of the pairs that was missed [1].
    double missed_pairs_share() const {
        return pairs > 0 ? static_cast<double>(missed_pairs) / static_cast<double>(pairs) : 0;
    }
    /// Part of the vertices that was missed [1].
    double missed_vertex_share() const {
        return vertices > 0 ? static_cast<double>(missed_vertices) / static_cast<double>(vertices)
                            : 0;
    }
    /// Parts of the depth that was missed [1].
    double missed_share() const { return depth > 0 ? missed_depth / depth : 0; }
    double missed_pair_share() const { return depth > 0 ? missed_pair_depth / depth : 0; }
    /// How deep the method says that pairs are, over how deep their vertices are [1]. Edges may be
    /// deeper than any vertex.
    double pair_depth_ratio() const { return pair_depth > 0 ? found_pair_depth / pair_depth : 0; }
};

/// Compares contact lists with the truth frame by frame. A method whose contacts name vertices has
/// found a vertex if a contact names it. Any other method has found a vertex if it has found the
/// pair, which is generous. Depths and normals are compared where the true depth is ten touch
/// tolerances or more: nearer to the surface they are rounding.
class AccuracyCount {
public:
    /// `names_vertices`: true if the method's contacts name vertices.
    AccuracyCount(const Recording& recording, bool names_vertices);

    void add(const TrueFrame& truth, std::span<const MethodContact> contacts);
    const Accuracy& accuracy() const { return accuracy_; }

private:
    bool names_vertices_;
    std::vector<double> least_depth_;  ///< [length] per body, as a target
    Accuracy accuracy_;
};

}  // namespace pierce::scenes
