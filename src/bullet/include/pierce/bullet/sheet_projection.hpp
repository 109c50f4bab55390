#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "pierce/contact.hpp"
#include "pierce/pose.hpp"
#include "pierce/vec3.hpp"

namespace pierce::bullet {

/// The vertices of a soft body during a step, while contacts move them.
struct MovingNodes {
    std::vector<Vec3f> start;          ///< where the step began
    std::vector<Vec3d> end;            ///< where the step ends, as far as is known yet
    std::vector<double> inverse_mass;  ///< [1 / mass] 0: nothing moves it
};

/// A rigid body at the end of a step, while contacts move it.
struct MovingBody {
    double inverse_mass = 0;  ///< [1 / mass] 0: nothing moves it
    Matrix3 inverse_inertia;  ///< [1 / (mass * length^2)] in world space; without meaning if
                              ///< nothing moves the body
    Vec3d center;
    Vec3d shift, turn;  ///< what contacts have done: a shift of the centre [length] and a turn
                        ///< about it [rad]
    Vec3d impulse;      ///< the sum of contacts' impulses, also if nothing moves the body [mass *
                        ///< length]

    /// How far a point has been moved.
    Vec3d way(Vec3d arm) const { return shift + cross(turn, arm); }
};

/// How contacts move vertices.
struct ProjectionSettings {
    double friction = 0.3;    ///< Coulomb's [1]
    double kept_share = 0.8;  ///< [thickness] gap that is kept: less than the thickness, so that
                              ///< contacts stay contacts
    double recovery_share = 0.1;  ///< [thickness] a gap that was too small opens by so much per
                                  ///< step; opening faster would throw things apart
    double least_share = 0.25;    ///< [thickness] a smaller gap opens to this at once
    std::uint32_t sweeps = 16;    ///< over all contacts
};

/// Moves vertices, and rigid bodies, at the end of a step until the gaps of contacts are kept:
/// non-linear Gauss-Seidel on positions (Müller et al. 2007), with accumulated corrections, so that
/// no contact pulls, and friction within Coulomb's cone.
class SheetProjection {
public:
    /// One of a contact's two points. It belongs to a soft body if `nodes` is given, and to a rigid
    /// body if `body` is given. Otherwise its motion is given.
    struct Point {
        MovingNodes* nodes = nullptr;
        MovingBody* body = nullptr;
        std::uint32_t vertex[3] = {};
        double weight[3] = {};  ///< zero where there is no vertex
        Vec3d start, end;       ///< set if the point is not of a soft body
    };

    explicit SheetProjection(const ProjectionSettings& settings) : settings_(settings) {}

    void clear() { rows_.clear(); }
    /// A contact that pushes its source along `out`, a unit vector, until it is `thickness` times
    /// kept_share from its target.
    void add(const Point& source, const Point& target, Vec3d out, double thickness);
    /// Moves nodes and bodies; returns false if no contact can move any of them.
    bool project();

private:
    struct Term {
        MovingNodes* nodes;
        std::uint32_t vertex;
        double weight;  ///< positive: of the source
    };
    /// The gap along `out` is out . (sum of weight * end + given_end + sign * what the body has
    /// been moved by).
    struct Row {
        std::uint32_t first = 0, last = 0;  ///< its terms
        Vec3d out, given_end, start;  ///< `start`: the source relative to the target when the step
                                      ///< began
        MovingBody* body = nullptr;
        Vec3d arm;              ///< from the body's centre to its point
        double sign = 0;        ///< 1: the body holds the source point, -1: the target point
        double compliance = 0;  ///< [1 / mass] how far a unit impulse along `out` opens the gap
        double slip_compliance = 0;  ///< [1 / mass] the same along the surface, at most
        double gap = 0;              ///< wanted
        double pushed = 0;           ///< so far [mass * length]
        Vec3d dragged;
    };

    void add_terms(const Point& point, double sign, Row& row);
    Vec3d offset(const Row& row) const;
    void move(const Row& row, Vec3d impulse);
    void solve(Row& row);

    ProjectionSettings settings_;
    std::vector<Row> rows_;
    std::vector<Term> terms_;
};

}  // namespace pierce::bullet
