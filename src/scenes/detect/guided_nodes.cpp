#include "scenes/detect/guided_nodes.hpp"

#include <algorithm>

#include "pierce/bullet/bullet_convert.hpp"

namespace pierce::scenes {

GuidedNodes::GuidedNodes(btSoftBody& soft, const std::vector<Guide>& guides) : soft_(soft) {
    for (const Guide& guide : guides) {
        Led led{guide, {}};
        for (std::uint32_t v : guide.vertices) {
            const auto index = static_cast<int>(v);
            const btSoftBody::Node& node = soft.m_nodes[index];
            led.nodes.push_back({index, bullet::from_bullet(node.m_x), node.m_im});
        }
        led_.push_back(std::move(led));
    }
}

void GuidedNodes::lead(double time, double dt) {
    bool changed = false;
    for (const Led& led : led_)
        for (const Node& n : led.nodes) {
            btSoftBody::Node& node = soft_.m_nodes[n.index];
            const std::optional<Vec3d> place = led.guide.place(n.start, time);
            // The mass is not set by setMass(): after that, Bullet would take the links' present
            // lengths as their rest lengths.
            const btScalar inverse = place ? btScalar(0) : n.inverse_mass;
            changed |= node.m_im != inverse;
            node.m_im = inverse;
            if (place)
                node.m_v = bullet::to_bullet((1 / dt) * (*place - bullet::from_bullet(node.m_x)));
        }
    if (changed) soft_.updateLinkConstants();
    std::erase_if(led_, [&](const Led& led) {
        return std::ranges::none_of(
            led.nodes, [&](const Node& n) { return led.guide.place(n.start, time).has_value(); });
    });
}

}  // namespace pierce::scenes
