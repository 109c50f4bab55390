#pragma once

#include <cstdint>

namespace pierce {

/// How a body moves; decides which stages it needs.
enum class Motion : std::uint8_t {
    fixed,      ///< never moves; two fixed bodies are no pair
    rigid,      ///< moves by its pose
    deforming,  ///< every vertex is given in world space, every step
};

/// How a deforming body is looked for in itself.
enum class SelfCollision : std::uint8_t {
    off,   ///< not at all
    on,    ///< a solid: where it is inside itself; a sheet: by continuous tests, nothing is missed
    rays,  ///< a sheet: rays along the velocity of every vertex and against it, relative to the
           ///< triangle hit
    published,  ///< a sheet: the same with the vertex' own velocity, as the paper prints it
                ///< (section 5.2, Algorithm 1)
};

/// What a deforming body is in contact with besides solids that it overlaps.
struct Collision {
    SelfCollision self = SelfCollision::off;
    /// It has no inside, whatever its mesh: from both sides, its surface keeps other bodies'
    /// surfaces out, by continuous tests over the motion of a step.
    bool sheet = false;
    /// [length] of a sheet: surfaces that come closer than this to it are in contact.
    double thickness = 0;

    friend bool operator==(const Collision&, const Collision&) = default;
};

}  // namespace pierce
