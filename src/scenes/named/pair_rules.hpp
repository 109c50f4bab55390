#pragma once

#include <algorithm>
#include <cstdint>
#include <set>
#include <vector>

#include "pierce/body.hpp"
#include "pierce/filter.hpp"
#include "scenes/named/scene.hpp"

namespace pierce::scenes {

/// Which bodies of a scene, or of a recording, may be a pair.
class PairRules {
public:
    template <class Scene>
    explicit PairRules(const Scene& scene) : excluded_(scene.excluded) {
        for (const auto& body : scene.bodies)
            rules_.push_back({body.filter, body.motion == Motion::fixed});
    }

    /// True if one of the two moves, their filters allow it and the pair is not excluded; also of
    /// a body and itself.
    bool allow(std::uint32_t a, std::uint32_t b) const {
        return a == b || (!(rules_[a].fixed && rules_[b].fixed) &&
                          rules_[a].filter.allows(rules_[b].filter) &&
                          !excluded_.contains(std::minmax(a, b)));
    }

private:
    struct Rule {
        Filter filter;
        bool fixed = false;
    };

    std::vector<Rule> rules_;  ///< by body
    std::set<BodyPair> excluded_;
};

}  // namespace pierce::scenes
