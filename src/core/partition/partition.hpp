#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "core/body/scene.hpp"
#include "core/device/view.hpp"
#include "core/partition/space_cut.hpp"
#include "pierce/box.hpp"
#include "pierce/constants.hpp"

namespace pierce {

/// Bodies with places in device memory, whose reach a part is to measure.
struct Measured {
    std::vector<std::uint32_t> bodies;
    std::vector<double> more;  ///< [length] how far each reaches beyond its points
    std::uint64_t revision = 0;
};

/// Which part owns each body of a scene, and which bodies each part has to see. What is done for
/// every body in every step reads short lists, not the bodies themselves.
class Partition {
public:
    /// `shares`: of the work, per part.
    explicit Partition(std::vector<double> shares);

    std::uint32_t parts() const { return static_cast<std::uint32_t>(shares_.size()); }
    std::span<const double> shares() const { return shares_; }
    /// Each body's part; empty before the first cut().
    std::span<const std::uint32_t> owners() const { return space_.owners(); }
    /// The part that counts for a body's pairs (SpaceCut).
    std::uint32_t pair_part(std::uint32_t body) const {
        return space_.pair_part(facts_[body], body);
    }

    /// The same before the last cut.
    std::span<const std::uint32_t> owners_before() const { return owners_before_; }

    /// Sets each body's part for the next step, and for all later ones with these bodies, instead
    /// of cuts of space.
    void set_owners(std::vector<std::uint32_t> owners) { given_ = std::move(owners); }

    /// Begins a step: notes what bodies are. `anew`: bodies were added, removed or changed.
    void begin(const Scene& scene, bool anew);
    /// Then, for every part: measures what some of the bodies reach whose places the host knows.
    /// Parts may do so at the same time.
    void measure_on_host(const Scene& scene, std::uint32_t part);
    /// How many bodies these are, of all parts.
    std::size_t noted() const { return noted_.size(); }
    /// What each part is to measure in a step.
    bool measures() const { return measures_; }
    const Measured& measured(std::uint32_t part) const { return measured_[part]; }
    /// True if parts have to look around in this step: some body reaches so much further than when
    /// they last did that they may not see all that is near. `grown`: the most that was measured.
    bool is_out_of_date(double grown) const;
    /// Where the reach of measured bodies goes before parts look around.
    View<Box> reach() { return view_of(reach_); }
    /// Looks for what is near a part, once the reach of all bodies is known. Parts may do so at the
    /// same time.
    void look_around(std::uint32_t part);
    /// To be called when all parts have looked around. Cuts space anew if there are other bodies
    /// than at the last cut, or if a part has to see much more than after it; then bodies may have
    /// other owners, and it returns true.
    bool cut(const Scene& scene);

    /// The bodies that a part owns, and those that are near enough to be a pair of this part.
    const BodySet& near(std::uint32_t part) const { return near_[part]; }
    /// The same, but looking so much further that they are likely to be enough for later steps.
    BodySet residents(std::uint32_t part) const;

private:
    void note(const Scene& scene, std::uint32_t body);
    void list_measured(const Scene& scene);
    double worst_load() const;
    /// [length] How much further than bodies reach parts look for ghosts.
    double spare() const { return 0.5 * constants::spare_reach * space_.mean_extent(); }
    void note_looked();
    /// To be called when bodies have other owners.
    bool note_owners(const Scene& scene);

    std::vector<double> shares_;
    // Per body.
    std::vector<BodyFacts> facts_;
    std::vector<Box> reach_;            ///< empty if it takes no part
    std::vector<Box> looked_;           ///< the same when parts last looked around
    std::vector<std::uint32_t> noted_;  ///< bodies that may differ from the last step
    std::vector<std::uint32_t> owners_before_;
    std::vector<BodyId> known_;  ///< whom the owner was chosen for
    std::uint64_t planned_ = 0;  ///< revision of the plan of the last cut()
    SpaceCut space_;
    std::optional<std::vector<std::uint32_t>> given_;  ///< owners to come
    bool is_given_ = false;                            ///< owners were not found by a cut
    // Per part.
    std::vector<double> grown_;  ///< [length] the most that reach has grown since, as it measured
    std::vector<Measured> measured_;
    bool measures_ = false;  ///< there is something to measure
    std::vector<BodySet> near_;
    std::vector<double> loads_;
    double worst_at_first_ = 0;  ///< the largest load for its share after the last cut
};

}  // namespace pierce
