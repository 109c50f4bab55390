#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <utility>
#include <vector>

#include "core/body/placed_box.hpp"
#include "core/body/scene.hpp"
#include "core/device/view.hpp"
#include "pierce/box.hpp"

namespace pierce {

/// Per body: 1 if it belongs to a set of bodies, else 0.
using BodySet = std::vector<std::uint8_t>;

/// Which part owns each body of a scene, and which bodies each part has to see. What is done for
/// every body in every step reads short lists, not the bodies themselves.
class Partition {
public:
    /// `shares`: of the work, per part.
    explicit Partition(std::vector<double> shares);

    std::uint32_t parts() const { return static_cast<std::uint32_t>(shares_.size()); }
    /// Each body's part; empty before the first cut().
    std::span<const std::uint32_t> owners() const { return owners_; }

    /// Begins a step: notes what bodies are. `anew`: bodies were added, removed or changed.
    void begin(const Scene& scene, bool anew);
    /// The bodies with places in device memory that a part is to measure, and where to.
    std::span<const std::uint32_t> to_measure(std::uint32_t part) const { return measured_[part]; }
    View<PlacedBox> places() { return view_of(places_); }
    /// Looks for what is near a part, once all places are known. Parts may do so at the same time.
    void look_around(std::uint32_t part);
    /// Cuts space anew if there are other bodies than at the last cut, or if a part has to see much
    /// more than after it; then bodies may have other owners, all parts have to look around again,
    /// and it returns true.
    bool cut(const Scene& scene);
    /// To be called when all parts have looked around after a cut.
    void note_loads() { worst_at_first_ = worst_load(); }

    /// The bodies that a part owns, and those that are near enough to be a pair with one of them.
    const BodySet& near(std::uint32_t part) const { return near_[part]; }
    /// The same, but looking so much further that they are likely to be enough for later steps.
    BodySet residents(std::uint32_t part) const;

private:
    /// What is read of a body in every step.
    struct Facts {
        double more = 0;  ///< [length] how far it reaches beyond its box
        float weight = 0;
        bool exists = false, active = false, moves = false;
    };

    void note(const Scene& scene, std::uint32_t body);
    void list_measured(const Scene& scene);
    Box reach(std::uint32_t body) const;
    double worst_load() const;
    /// The bodies of a part, and those that come within `more` [length] of its reach.
    BodySet seen_from(std::uint32_t part, double more) const;

    std::vector<double> shares_;
    // Per body.
    std::vector<Facts> facts_;
    std::vector<PlacedBox> places_;
    std::vector<std::uint32_t> owners_;
    std::vector<BodyId> known_;  ///< whom the owner was chosen for
    double mean_extent_ = 0;
    // Per part.
    std::vector<std::vector<std::uint32_t>> measured_;
    std::vector<BodySet> near_;
    std::vector<double> loads_;
    double worst_at_first_ = 0;  ///< the largest load for its share after the last cut
};

}  // namespace pierce
