#pragma once

#include <cstdint>

namespace pierce {

/// How a body moves; decides which stages it needs.
enum class Motion : std::uint8_t {
    fixed,      ///< never moves; two fixed bodies are no pair
    rigid,      ///< moves by its pose
    deforming,  ///< every vertex is given in world space, every step
};

/// How contacts of a deforming body with itself are found.
enum class SelfCollision : std::uint8_t {
    off,   ///< not at all
    on,    ///< of a solid: where it is inside itself; of a sheet: by continuous tests, which miss
           ///< nothing
    rays,  ///< of a sheet: by rays along the velocity of every vertex and against it, where the
           ///< velocity is relative to the triangle hit
    published,  ///< of a sheet: by the same rays with the vertex's own velocity, as the paper
                ///< prints it (section 5.2, Algorithm 1)
};

/// What a body is in contact with besides solids that it overlaps. All but the margin is for bodies
/// that deform.
struct Collision {
    SelfCollision self = SelfCollision::off;
    /// True for a body without an inside, whatever its mesh. Its surface keeps other bodies'
    /// surfaces out from both sides, by continuous tests over the motion of a step.
    bool sheet = false;
    /// [length] of a sheet: surfaces that come closer than this to it are in contact.
    double thickness = 0;
    /// [length] of a solid, also a rigid one: it is in contact with other solids that are nearer
    /// than this, or than their own margin if that is larger. Negative: Settings::margin.
    double margin = -1;

    friend bool operator==(const Collision&, const Collision&) = default;
};

}  // namespace pierce
