#include "pierce/bullet/contact_reduction.hpp"

#include <algorithm>

namespace pierce::bullet {
namespace {

/// Indices into the contact list; the first one is the deepest and gives the cluster its direction.
using Cluster = std::vector<std::size_t>;

Vec3d middle(const FramedContact& c) { return 0.5 * (c.point_a + c.point_b); }

/// The deepest contact, then again and again the contact that is furthest from all those already
/// taken.
Cluster outermost(const std::vector<FramedContact>& contacts, const Cluster& cluster,
                  std::uint32_t count) {
    Cluster taken{cluster.front()};
    std::vector<double> gap(cluster.size(), std::numeric_limits<double>::infinity());
    while (taken.size() < std::min<std::size_t>(count, cluster.size())) {
        for (std::size_t i = 0; i < cluster.size(); ++i)
            gap[i] = std::min(gap[i], length_squared(middle(contacts[cluster[i]]) -
                                                     middle(contacts[taken.back()])));
        taken.push_back(
            cluster[static_cast<std::size_t>(std::ranges::max_element(gap) - gap.begin())]);
    }
    return taken;
}

}  // namespace

std::vector<FramedContact> reduce(const std::vector<FramedContact>& contacts,
                                  const ReductionSettings& settings) {
    std::vector<std::size_t> by_depth(contacts.size());
    for (std::size_t i = 0; i < by_depth.size(); ++i) by_depth[i] = i;
    std::ranges::stable_sort(by_depth, {}, [&](std::size_t i) { return contacts[i].distance; });

    std::vector<Cluster> clusters;
    for (std::size_t i : by_depth) {
        const auto fits = [&](const Cluster& cluster) {
            return dot(contacts[cluster.front()].normal_on_b, contacts[i].normal_on_b) >
                   settings.same_direction;
        };
        const auto home = std::ranges::find_if(clusters, fits);
        if (home != clusters.end())
            home->push_back(i);
        else if (clusters.size() < settings.max_clusters)
            clusters.push_back({i});
    }

    Cluster kept;
    for (const Cluster& cluster : clusters)
        for (std::size_t i : outermost(contacts, cluster, settings.points)) kept.push_back(i);
    std::ranges::sort(kept);
    std::vector<FramedContact> result;
    for (std::size_t i : kept) result.push_back(contacts[i]);
    return result;
}

}  // namespace pierce::bullet
