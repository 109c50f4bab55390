#pragma once

#include <cstdint>

#include "scenes/recording/recording.hpp"

namespace pierce::scenes {

/// How the tori of a lattice move.
enum class LatticeMotion : std::uint8_t {
    soft,   ///< they turn and wobble: deforming bodies
    rigid,  ///< they turn
    rest,   ///< rigid, and stay where they are
};

/// `count` tori of the paper's scene in a grid, each in touch with its neighbours. Motion that a
/// formula gives scales to any count, which a pile does not. `side`: so many of them stand along x
/// and along y, and all layers are alike; 0: as many as along z.
Recording lattice(std::uint32_t count, std::uint32_t frames, LatticeMotion motion,
                  std::uint32_t side = 0);

}  // namespace pierce::scenes
