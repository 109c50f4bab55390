#include "scenes/named/layers.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "scenes/named/shapes.hpp"

namespace pierce::scenes {
namespace {

constexpr double turn = 2 * std::numbers::pi;

// The waves that all sheets share, and the motion that each sheet has of its own; [length] unless
// said otherwise.
constexpr double common_height = 0.25, wave_length = 3.0;
constexpr double common_period = 2.0;                 // [s]
constexpr double slide = 0.3, slide_period = 1.6;     // [s]
constexpr double own_period = 1.1;                    // [s]
constexpr double middle_gap = 1.2, gap_change = 0.6;  // [thickness]

}  // namespace

// The waves that all sheets share are functions of a point's place above the ground plane, not of
// its vertex. So a sheet that slides follows the same surface as its neighbours. The gap along z is
// then the difference of the sheets' own parts alone, to the second order in the size of a
// triangle.
void Layers::positions(std::uint32_t sheet, double time, std::span<Vec3f> positions) const {
    const double way = sheet % 2 == 0 ? 1.0 : -1.0;
    const double shift = way * slide * std::sin(turn * time / slide_period);
    for (std::uint32_t j = 0; j < across; ++j)
        for (std::uint32_t i = 0; i < along; ++i) {
            const double x = width * (static_cast<double>(i) / (along - 1) - 0.5) + shift;
            const double y = depth * (static_cast<double>(j) / (across - 1) - 0.5);
            const double common = common_height *
                                  std::sin(turn * (x / wave_length - time / common_period)) *
                                  std::cos(turn * y / wave_length);
            const double own = 0.5 * way * gap_change * thickness *
                               std::sin(turn * (y / wave_length + time / own_period));
            const double z = sheet * middle_gap * thickness + own + common;
            positions[j * along + i] = to_float({x, y, z});
        }
}

SceneSetup Layers::scene() const {
    SceneSetup setup{"layers", {{"sheet", grid(width, depth, along, across), {}}}, {}};
    for (std::uint32_t s = 0; s < sheets; ++s) {
        SceneBody body{.name = "sheet " + std::to_string(s),
                       .mesh = 0,
                       .motion = Motion::deforming,
                       .pose = {},
                       .ground = false};
        body.collision = {SelfCollision::on, true, thickness};
        body.motion_of = [layers = *this, s](double time, std::span<Vec3f> at) {
            layers.positions(s, time, at);
        };
        setup.bodies.push_back(std::move(body));
    }
    return setup;
}

Layers layers_with(std::uint32_t nodes) {
    Layers layers;
    if (nodes == 0) return layers;
    // The sheet has about the proportions of 50 by 95 quads, and at least one quad.
    layers.across = std::max(nodes, 2u);
    layers.along = std::max(2 * nodes, 8u) - 6;
    // Triangles keep their size, as the waves are made for it.
    layers.width *= (layers.along - 1) / 95.0;
    layers.depth *= (layers.across - 1) / 50.0;
    return layers;
}

}  // namespace pierce::scenes
