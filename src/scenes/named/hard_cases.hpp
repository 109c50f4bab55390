#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "pierce/mesh.hpp"
#include "pierce/mesh_defect.hpp"

namespace pierce::scenes {

/// How a ray meets a surface at its first crossing.
enum class Meets : std::uint8_t {
    nothing,
    entry,     ///< from outside
    exit,      ///< from inside
    touching,  ///< the origin lies on the surface: an exit at distance zero
};

/// A ray, a mesh, and what the ray meets first in the mesh.
struct HardRay {
    MeshData mesh;
    Vec3d origin, direction;  ///< the direction need not be unit
    Meets meets = Meets::nothing;
    double t = 0;          ///< [length]; zero where nothing is met
    bool differs = false;  ///< from the exact answer: see HardCase::differs
};

/// The contacts of two bodies under one coverage.
struct HardContacts {
    int vertices_a = 0, vertices_b = 0;  ///< contacts of the first body's vertices, and of the
                                         ///< second's
    int edges_a = 0, edges_b = 0;        ///< contacts of parts of edges
    bool separated = false;  ///< the contacts lie along the direction of separation; their number
                             ///< is not part of the answer
    double depth = 0;        ///< the deepest [length]; negative: not part of the answer
    Vec3d push;  ///< unit, the way the first body is pushed, all depths together; zero: not part of
                 ///< the answer

    bool any() const { return separated || vertices_a + vertices_b + edges_a + edges_b > 0; }
};

/// Two meshes at their places, how far they overlap, and their contacts.
struct HardBodies {
    std::string situation;
    MeshData a, b;
    double parting = 0;  ///< exact: the shortest move that parts them [length]; zero: they touch;
                         ///< negative: they are apart
    HardContacts vertices, complete;
    double by_default = -1;  ///< the deepest contact with the default settings [length]; 0 if there
                             ///< is none, or none with a depth; negative: not part of the answer
};

/// What the check of a mesh must find.
struct HardFinding {
    MeshData mesh;
    MeshDefect kind = MeshDefect::no_triangles;
    std::uint32_t count = 0;
};

/// One of the twenty-five hard cases: the questions and the exact answers.
struct HardCase {
    int number = 0;
    std::string name;
    std::vector<HardRay> rays;
    std::vector<HardBodies> bodies;
    std::vector<HardFinding> findings;
    std::string answer;   ///< one line
    std::string differs;  ///< where Pierce's rules answer something else than the exact answer, and
                          ///< why; mostly empty
};

/// All hard cases, by number.
std::vector<HardCase> hard_cases();

}  // namespace pierce::scenes
