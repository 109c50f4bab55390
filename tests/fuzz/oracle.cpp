#include "fuzz/oracle.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>
#include <tuple>

#include "core/mesh/mesh_view.hpp"
#include "core/mesh/surface.hpp"
#include "fuzz/invariants.hpp"
#include "fuzz/solid_surface.hpp"
#include "support/brute_force.hpp"
#include "truth/exact_continuous.hpp"
#include "truth/meeting.hpp"

namespace pierce::fuzz {
namespace {

/// A body's surface in the world.
struct Surface : SolidSurface {
    const ModelBody* body = nullptr;
    Box box;
    bool has_inside = false;
    bool proper = false;  ///< closed, does not meet itself, faces outward everywhere
    double touch = 0;  ///< [length] a place closer to the surface than this is on it, for all that
                       ///< is promised
    bool active = false;
};

class Oracle {
public:
    Oracle(const Model& model, std::span<const Contact> contacts, OracleCounts& counts)
        : model_(model), contacts_(contacts), counts_(counts) {
        for (const ModelBody* b : model.bodies()) surfaces_.push_back(surface(*b));
    }

    std::optional<Failure> run() {
        // The paper's mode promises neither: a walk may end behind the first crossing.
        if (model_.settings().temporal != Temporal::paper)
            if (auto failure = judge_solids()) return failure;
        for (std::size_t i = 0; i < surfaces_.size(); ++i)
            for (std::size_t j = i; j < surfaces_.size(); ++j)
                if (const auto failure = judge_sheets(surfaces_[i], surfaces_[j])) return failure;
        return std::nullopt;
    }

private:
    std::optional<Failure> judge_solids() {
        for (std::size_t i = 0; i < surfaces_.size(); ++i)
            for (std::size_t j = i + 1; j < surfaces_.size(); ++j)
                if (auto failure = judge_pair(surfaces_[i], surfaces_[j])) return failure;
        for (const Contact& c : contacts_)
            if (auto failure = judge_contact(c)) return failure;
        for (const Surface& s : surfaces_)
            for (const Surface& t : surfaces_)
                if (auto failure = judge_margin(s, t)) return failure;
        for (const Surface& s : surfaces_)
            for (const Surface& t : surfaces_)
                if (auto failure = model_.settings().inside_is_contact() ? judge_inside(s, t)
                                                                         : judge_vertices(s, t))
                    return failure;
        for (const Surface& s : surfaces_)
            if (auto failure = judge_self(s)) return failure;
        return std::nullopt;
    }

    Surface surface(const ModelBody& b) const {
        Surface s;
        s.body = &b;
        s.active = model_.takes_part(b);
        if (!s.active) return s;
        s.points = model_.ends(b);
        s.triangles = model_.mesh(b).triangles;
        double coordinate = 0;
        for (const Vec3d& p : s.points) {
            s.box.extend(p);
            for (int k = 0; k < 3; ++k) coordinate = std::max(coordinate, std::fabs(p[k]));
        }
        s.touch = 4 * constants::touch_tolerance * s.box.extent() + 1e-13 * coordinate;
        // What is too large to multiply is not judged.
        s.active = s.active && coordinate < 1e30;
        s.has_inside = model_.has_inside(b);
        s.proper = s.active && s.has_inside && s.touch > 0 && s.is_proper(s.touch);
        return s;
    }

    const Surface* find(BodyId id) const {
        for (const Surface& s : surfaces_)
            if (s.body->id == id) return s.active ? &s : nullptr;
        return nullptr;
    }

    bool is_pair(const Surface& a, const Surface& b) const {
        return a.active && b.active && model_.may_meet(*a.body, *b.body) &&
               !(a.body->motion == Motion::fixed && b.body->motion == Motion::fixed);
    }
    static bool is_solid(const Surface& s) { return s.proper && !s.body->collision.sheet; }

    /// Of a solid: it does not overlap.
    static bool is_near(const Contact& c) { return !c.of_sheet && c.found == Found::near; }

    std::size_t contacts_between(const Surface& a, const Surface& b) const {
        return static_cast<std::size_t>(std::ranges::count_if(contacts_, [&](const Contact& c) {
            return c.a == a.body->id && c.b == b.body->id && !is_near(c);
        }));
    }

    static bool overlaps(const Surface& a, const Surface& b, Vec3d shift) {
        if (a.meets(b, shift)) return true;
        const auto holds_one = [](const Surface& x, const Surface& y, Vec3d by) {
            // Every connected part would do; all vertices are simpler.
            return std::ranges::any_of(y.triangles, [&](const Triangle& t) {
                return x.holds(y.points[t.vertex[0]] + by);
            });
        };
        return holds_one(a, b, shift) || holds_one(b, a, -shift);
    }

    /// Coverage::overlaps and complete: no overlap is missed, but within the touch tolerance; and
    /// what is apart has no contact.
    std::optional<Failure> judge_pair(const Surface& a, const Surface& b) {
        if (!is_pair(a, b) || !is_solid(a) || !is_solid(b)) return std::nullopt;
        const bool found = contacts_between(a, b) > 0;
        const bool misses_none = model_.settings().coverage != Coverage::vertices;
        if (!found && !misses_none) return std::nullopt;
        const double by = 4 * (a.touch + b.touch);
        if (!overlap(a.box.inflated(by), b.box.inflated(by))) {
            if (found)
                return Failure{"truth: bodies that are apart are not in contact", describe(a, b)};
            return std::nullopt;
        }
        bool always = true, ever = false;
        for (int x = -1; x <= 1; ++x)
            for (int y = -1; y <= 1; ++y)
                for (int z = -1; z <= 1; ++z) {
                    const bool now = overlaps(a, b, by * Vec3d{double(x), double(y), double(z)});
                    always = always && now;
                    ever = ever || now;
                    if (found ? ever : !always) {
                        x = y = z = 2;
                    }
                }
        counts_.overlapping_pairs += always && !found;
        counts_.overlapping_pairs += found && ever;
        counts_.apart_pairs += !ever;
        if (misses_none && always && !found)
            return Failure{"truth: no overlap is missed (coverage is not vertices)",
                           describe(a, b)};
        if (found && !ever)
            return Failure{"truth: bodies that are apart are not in contact", describe(a, b)};
        return std::nullopt;
    }

    static std::string describe(const Surface& a, const Surface& b) {
        return "bodies " + std::to_string(a.body->id.index) + " and " +
               std::to_string(b.body->id.index);
    }

    /// A contact of solids: its source point is inside the target, and so is the way to its end;
    /// that is in its own body, too, unless the way is not its own inward ray.
    std::optional<Failure> judge_contact(const Contact& c) {
        if (c.of_sheet || c.a == c.b || is_near(c)) return std::nullopt;
        const Surface* source = find(c.source == Side::a ? c.a : c.b);
        const Surface* target = find(c.source == Side::a ? c.b : c.a);
        if (source == nullptr || target == nullptr || !is_solid(*target)) return std::nullopt;
        const Vec3d from = c.source == Side::a ? c.point_a : c.point_b,
                    to = c.source == Side::a ? c.point_b : c.point_a;
        if (target->distance(to) > target->touch + source->touch)
            return Failure{"truth: a contact ends on its target", to_text(c)};
        if (target->has_plane_along(from, c.reprojected ? from + way_in(c, *source) : to,
                                    source->touch))
            return std::nullopt;
        if (target->distance(from) > target->touch + source->touch) {
            ++counts_.inside_vertices;
            if (!target->holds(from))
                return Failure{"truth: a contact starts inside its target", to_text(c)};
        }
        const bool in_own = is_solid(*source) && !c.reprojected && c.found != Found::separation &&
                            !model_.settings().inside_is_contact();
        for (double at : {0.25, 0.5, 0.75}) {
            const Vec3d p = from + at * (to - from);
            if (target->distance(p) > target->touch + source->touch) {
                ++counts_.segments;
                if (!target->holds(p))
                    return Failure{"truth: a contact is inside its target", to_text(c)};
            }
            if (in_own && source->distance(p) > source->touch + target->touch && !source->holds(p))
                return Failure{"truth: a contact is inside its own body", to_text(c)};
        }
        return std::nullopt;
    }

    /// The direction of the ray that found a contact, which ends elsewhere by now.
    Vec3d way_in(const Contact& c, const Surface& source) const {
        if (!c.is_edge()) {
            const test::SolidVec inward = inward_directions(source)[c.vertex];
            return {static_cast<double>(inward.x), static_cast<double>(inward.y),
                    static_cast<double>(inward.z)};
        }
        Vec3d outward;
        for (const Triangle& t : source.triangles) {
            const auto has = [&](std::uint32_t v) {
                return std::ranges::find(t.vertex, v) != std::end(t.vertex);
            };
            if (has(c.vertex) && has(c.edge_end))
                outward += normalized(
                    cross(source.points[t.vertex[1]] - source.points[t.vertex[0]],
                          source.points[t.vertex[2]] - source.points[t.vertex[0]]));
        }
        return -normalized(outward);
    }

    /// Every vertex inside another solid is in contact with it.
    std::optional<Failure> judge_inside(const Surface& source, const Surface& target) {
        if (&source == &target || !is_pair(source, target) || !source.proper ||
            source.body->collision.sheet || !is_solid(target) || !overlap(source.box, target.box))
            return std::nullopt;
        std::set<std::uint32_t> found;
        bool separates = false;
        for (const Contact& c : contacts_) {
            const bool from_a = c.source == Side::a;
            if (c.of_sheet || is_near(c) || (from_a ? c.a : c.b) != source.body->id ||
                (from_a ? c.b : c.a) != target.body->id)
                continue;
            if (!c.is_edge()) found.insert(c.vertex);
            separates = separates || c.found == Found::separation;
        }
        // A way apart that runs in a face of the target may not show that its start is inside.
        if (separates) return std::nullopt;
        const std::vector<test::SolidVec> inward = inward_directions(source);
        for (const Triangle& t : source.triangles)
            for (std::uint32_t v : t.vertex) {
                const Vec3d p = source.points[v];
                if (found.contains(v) || !target.box.contains(p) ||
                    target.distance(p) <= source.touch + target.touch || !target.holds(p))
                    continue;
                const auto& d = inward[v];
                const Vec3d way{static_cast<double>(d.x), static_cast<double>(d.y),
                                static_cast<double>(d.z)};
                ++counts_.expected_contacts;
                if (!target.has_plane_along(p, p + way, source.touch))
                    return Failure{"truth: a vertex inside is in contact",
                                   describe(source, target) + " vertex " + std::to_string(v)};
            }
        return std::nullopt;
    }

    /// Every vertex that is outside and nearer than the margin is in contact, and no other one.
    std::optional<Failure> judge_margin(const Surface& source, const Surface& target) {
        if (&source == &target || !is_pair(source, target) || !source.proper ||
            source.body->collision.sheet || !is_solid(target))
            return std::nullopt;
        const double margin = model_.margin(*source.body, *target.body),
                     room = source.touch + target.touch;
        if (!(margin > 0) || !overlap(source.box.inflated(margin), target.box)) return std::nullopt;
        std::map<std::uint32_t, double> found;
        for (const Contact& c : contacts_) {
            const bool from_a = c.source == Side::a;
            if (is_near(c) && !c.is_edge() && (from_a ? c.a : c.b) == source.body->id &&
                (from_a ? c.b : c.a) == target.body->id)
                found[c.vertex] = c.distance;
        }
        std::set<std::uint32_t> used;
        for (const Triangle& t : source.triangles)
            used.insert(std::begin(t.vertex), std::end(t.vertex));
        for (std::uint32_t v : used) {
            const Vec3d p = source.points[v];
            const double distance = target.distance(p);
            if (distance <= room || std::fabs(distance - margin) <= room) continue;
            const auto at = found.find(v);
            const bool expected = distance < margin && !target.holds(p);
            counts_.expected_contacts += expected;
            if (expected != (at != found.end()) ||
                (expected && std::fabs(at->second - distance) > room))
                return Failure{"truth: what is nearer than the margin is in contact",
                               describe(source, target) + " vertex " + std::to_string(v)};
        }
        return std::nullopt;
    }

    /// Vertices of solids, by definition.
    std::optional<Failure> judge_vertices(const Surface& source, const Surface& target) {
        if (&source == &target || !is_pair(source, target) || !is_solid(source) ||
            !is_solid(target))
            return std::nullopt;
        if (!overlap(source.box, target.box)) return std::nullopt;
        const std::vector<test::SolidVec> inward = inward_directions(source);
        const test::Expected expected = test::expected_contacts(solid(source, target), inward,
                                                                solid(target, target));
        std::set<std::uint32_t> found;
        for (const Contact& c : contacts_) {
            const bool from_a = c.source == Side::a;
            if (c.is_edge() || c.of_sheet || is_near(c) || c.found == Found::separation ||
                (from_a ? c.a : c.b) != source.body->id || (from_a ? c.b : c.a) != target.body->id)
                continue;
            found.insert(c.vertex);
        }
        std::set<std::uint32_t> unclear(expected.unclear.begin(), expected.unclear.end());
        for (const test::ExpectedContact& e : expected.contacts) {
            ++counts_.expected_contacts;
            if (!found.erase(e.vertex) && !unclear.contains(e.vertex))
                return Failure{"truth: a vertex inside has its contact (R1 to R3)",
                               describe(source, target) + " vertex " + std::to_string(e.vertex)};
        }
        for (std::uint32_t v : found)
            if (!unclear.contains(v))
                return Failure{"truth: a vertex with a contact passes R1 to R3",
                               describe(source, target) + " vertex " + std::to_string(v)};
        return std::nullopt;
    }

    /// Of a surface each of whose edges has two triangles.
    static double mean_edge_length(const Surface& s) {
        double sum = 0;
        for (const Triangle& t : s.triangles)
            for (int k = 0; k < 3; ++k)
                sum += length(s.points[t.vertex[(k + 1) % 3]] - s.points[t.vertex[k]]);
        return sum / static_cast<double>(3 * s.triangles.size());
    }

    /// Vertices of a deforming solid inside another part of it, by definition.
    std::optional<Failure> judge_self(const Surface& s) {
        if (!s.active || s.touch <= 0 || s.body->motion != Motion::deforming ||
            s.body->collision.sheet || s.body->collision.self != SelfCollision::on ||
            model_.settings().reproject || !is_manifold(s.triangles) || !s.has_area())
            return std::nullopt;
        const MeshData& mesh = model_.mesh(*s.body);
        Surface rest = s;
        for (std::size_t v = 0; v < rest.points.size(); ++v)
            rest.points[v] = to_double(mesh.positions[v]);
        if (!rest.has_area()) return std::nullopt;
        // Where parts overlap at rest, what they cover there counts as covered in every shape.
        if (Mesh("rest", mesh).inside().covered_triangles > 0) return std::nullopt;
        const test::Expected expected = test::expected_self_contacts(
            solid(s, s), inward_directions(s), solid(rest, s),
            constants::self_distance * mean_edge_length(rest) / s.box.extent());
        std::set<std::uint32_t> found;
        for (const Contact& c : contacts_)
            if (c.found == Found::self && c.a == s.body->id) found.insert(c.vertex);
        for (std::uint32_t v : expected.unclear) found.erase(v);
        const std::set<std::uint32_t> unclear(expected.unclear.begin(), expected.unclear.end());
        for (const test::ExpectedContact& e : expected.contacts) {
            if (unclear.contains(e.vertex)) continue;
            ++counts_.expected_contacts;
            if (!found.erase(e.vertex))
                return Failure{"truth: a vertex inside another part of its body has its contact",
                               describe(s, s) + " vertex " + std::to_string(e.vertex)};
        }
        if (!found.empty())
            return Failure{
                "truth: a contact of a body with itself starts inside another part of it",
                describe(s, s) + " vertex " + std::to_string(*found.begin())};
        return std::nullopt;
    }

    /// As large, and where, as if `one` were about one unit large: what counts as unclear is said
    /// in such units.
    static test::Solid solid(const Surface& s, const Surface& one) {
        test::Solid made;
        const double unit = 1 / one.box.extent();
        for (const Vec3d& p : s.points)
            made.positions.push_back(test::exact(unit * (p - one.points[0])));
        made.triangles = s.triangles;
        return made;
    }

    /// Against the mean of the normals around each vertex, by angles. Of a rigid body at rest, and
    /// turned: far from the origin its places say less of thin triangles.
    std::vector<test::SolidVec> inward_directions(const Surface& s) const {
        SolidSurface rest = s;
        Matrix3 turn;
        if (s.body->motion != Motion::deforming) {
            turn = frame_of(s.body->pose).rotation;
            for (std::size_t v = 0; v < rest.points.size(); ++v)
                rest.points[v] = to_double(model_.mesh(*s.body).positions[v]);
        }
        std::vector<test::SolidVec> inward;
        for (const Vec3d& n : rest.outward_directions()) inward.push_back(test::exact(turn * -n));
        return inward;
    }

    // What meets during the step, of two bodies one of which is a sheet, or of a sheet and itself,
    // is a contact.

    std::optional<Failure> judge_sheets(const Surface& a, const Surface& b) {
        const bool self = &a == &b;
        const Collision &of_a = a.body->collision, &of_b = b.body->collision;
        const bool looked_at = self ? of_a.sheet && of_a.self == SelfCollision::on
                                    : of_a.sheet || of_b.sheet;
        if (!looked_at || !a.active || !b.active || !model_.may_meet(*a.body, *b.body))
            return std::nullopt;
        const std::vector<MovingPoint> p = moving(a), q = self ? p : moving(b);
        std::set<std::tuple<bool, std::uint32_t, std::uint32_t>> vertices;  // from b, vertex,
                                                                            // triangle
        std::set<std::array<std::uint32_t, 4>> edges;
        for (const Contact& c : contacts_) {
            if (!c.of_sheet || c.a != a.body->id || c.b != b.body->id) continue;
            counts_.feature_meetings += c.found == Found::crossing;
            if (!c.is_edge()) {
                vertices.insert({c.source == Side::b, c.vertex, c.triangle});
            } else if (c.found != Found::tangled) {
                // The target's edge by its corners that have weight; both, if they are two.
                const Triangle& t = b.triangles[c.triangle];
                for (int k = 0; k < 3; ++k)
                    edges.insert(
                        key(c.vertex, c.edge_end, t.vertex[k], t.vertex[(k + 1) % 3], self));
            }
        }
        for (int turn = 0; turn < (self ? 1 : 2); ++turn) {
            const Surface &s = turn ? b : a, &t = turn ? a : b;
            const std::vector<MovingPoint>&of_s = turn ? q : p, &of_t = turn ? p : q;
            std::set<std::uint32_t> used;
            for (const Triangle& f : s.triangles)
                used.insert(std::begin(f.vertex), std::end(f.vertex));
            for (std::uint32_t v : used)
                for (std::uint32_t f = 0; f < t.triangles.size(); ++f) {
                    const Triangle& face = t.triangles[f];
                    if (self && has_vertex(face, v)) continue;
                    const std::array<MovingPoint, 4> corners = {
                        of_s[v], of_t[face.vertex[0]], of_t[face.vertex[1]], of_t[face.vertex[2]]};
                    // Exact arithmetic takes long: it is asked only about what is no contact.
                    if (vertices.contains({turn == 1, v, f}) || are_apart(corners, 1)) continue;
                    if (meet(truth::Features::vertex_and_face, corners) &&
                        !leaves_solid(corners, t))
                        return Failure{"truth: no crossing of a sheet is missed",
                                       describe(s, t) + " vertex " + std::to_string(v) +
                                           " triangle " + std::to_string(f)};
                }
        }
        const std::vector<std::array<std::uint32_t, 2>> of_first = edges_of(a),
                                                        of_second = edges_of(b);
        for (const auto& e : of_first)
            for (const auto& f : of_second) {
                if (self &&
                    (e >= f || e[0] == f[0] || e[0] == f[1] || e[1] == f[0] || e[1] == f[1]))
                    continue;
                const std::array<MovingPoint, 4> corners = {p[e[0]], p[e[1]], q[f[0]], q[f[1]]};
                if (edges.contains(key(e[0], e[1], f[0], f[1], self)) || are_apart(corners, 2))
                    continue;
                if (meet(truth::Features::edges, corners))
                    return Failure{"truth: no crossing of a sheet is missed",
                                   describe(a, b) + " edges " + std::to_string(e[0]) + "-" +
                                       std::to_string(e[1]) + " and " + std::to_string(f[0]) + "-" +
                                       std::to_string(f[1])};
            }
        return std::nullopt;
    }

    /// What rational numbers have to decide takes long: of that, no more than some questions a
    /// step.
    bool meet(truth::Features features, const std::array<MovingPoint, 4>& corners) {
        constexpr std::uint64_t most = 16;
        if (decided_.exact >= most) return false;
        ++counts_.feature_questions;
        return truth::features_meet(features, corners, &decided_);
    }

    static std::array<std::uint32_t, 4> key(std::uint32_t a, std::uint32_t b, std::uint32_t c,
                                            std::uint32_t d, bool self) {
        std::array<std::uint32_t, 4> k = {std::min(a, b), std::max(a, b), std::min(c, d),
                                          std::max(c, d)};
        if (self && std::tie(k[2], k[3]) < std::tie(k[0], k[1])) k = {k[2], k[3], k[0], k[1]};
        return k;
    }

    static std::vector<std::array<std::uint32_t, 2>> edges_of(const Surface& s) {
        std::set<std::array<std::uint32_t, 2>> edges;
        for (const Triangle& t : s.triangles)
            for (int k = 0; k < 3; ++k) {
                const std::uint32_t v = t.vertex[k], w = t.vertex[(k + 1) % 3];
                if (v != w) edges.insert({std::min(v, w), std::max(v, w)});
            }
        return {edges.begin(), edges.end()};
    }

    std::vector<MovingPoint> moving(const Surface& s) const {
        const std::vector<Vec3d> starts = model_.starts(*s.body);
        std::vector<MovingPoint> points;
        // Where sheets look, rigid bodies' vertices are float32 as theirs are.
        const auto rounded = [](Vec3d p) { return to_double(to_float(p)); };
        for (std::size_t v = 0; v < starts.size(); ++v)
            points.push_back({rounded(starts[v]), rounded(s.points[v])});
        return points;
    }

    /// True if an axis separates the first `split` points from the others throughout: spares most
    /// exact tests.
    static bool are_apart(const std::array<MovingPoint, 4>& p, std::size_t split) {
        for (int k = 0; k < 3; ++k) {
            double low[2] = {HUGE_VAL, HUGE_VAL}, high[2] = {-HUGE_VAL, -HUGE_VAL};
            for (std::size_t i = 0; i < 4; ++i)
                for (const Vec3d& at : {p[i].start, p[i].end}) {
                    low[i >= split] = std::min(low[i >= split], at[k]);
                    high[i >= split] = std::max(high[i >= split], at[k]);
                }
            if (high[0] < low[1] || high[1] < low[0]) return true;
        }
        return false;
    }

    /// True unless a vertex comes into a solid through a triangle for certain: what leaves is its
    /// ray's to report.
    bool leaves_solid(const std::array<MovingPoint, 4>& c, const Surface& target) const {
        if (target.body->collision.sheet || !target.has_inside || !is_closed(target)) return false;
        const std::optional<truth::ExactTime> time = truth::first_meeting_of_vertex_and_face(
            truth::exact(c));
        if (!time) return true;
        // Within the tolerance of a meeting nobody can tell on which side it began.
        double size_of_all = 0;
        for (const MovingPoint& p : c)
            for (const Vec3d& at : {p.start, p.end})
                size_of_all = std::max(size_of_all, length(at - c[0].start));
        const Vec3d first = normalized(cross(c[2].start - c[1].start, c[3].start - c[1].start));
        const double unclear = 2 * constants::meeting_tolerance * size_of_all;
        if (std::fabs(dot(first, c[0].start - c[1].start)) <= unclear) return true;
        const double t = time->lower.get_d();
        std::array<Vec3d, 4> at, way;
        for (std::size_t k = 0; k < 4; ++k) {
            way[k] = c[k].end - c[k].start;
            at[k] = c[k].start + t * way[k];
        }
        const Vec3d n = cross(at[2] - at[1], at[3] - at[1]);
        const double size = length_squared(n), longest = std::max(length_squared(at[2] - at[1]),
                                                                  length_squared(at[3] - at[1]));
        // Nor from which side it meets a triangle that is no wider.
        if (std::sqrt(size) <= unclear * std::sqrt(longest)) return true;
        // Of a triangle with less area [longest edge squared] rounding turns the normal by more
        // than what is certain.
        constexpr double certain = 1e-6, flat = 1e-10;
        // It has no sides then; which side is which was seen when the step began.
        if (size <= flat * flat * longest * longest)
            return dot(cross(c[2].start - c[1].start, c[3].start - c[1].start),
                       c[0].start - c[1].start) <= 0;
        const double u = dot(n, cross(at[3] - at[2], at[0] - at[2])) / size,
                     v = dot(n, cross(at[1] - at[3], at[0] - at[3])) / size;
        const Vec3d relative = way[0] - u * way[1] - v * way[2] - (1 - u - v) * way[3];
        return dot(n, relative) > -certain * length(n) * length(relative);
    }

    static bool is_closed(const Surface& s) {
        std::map<std::pair<std::uint32_t, std::uint32_t>, int> balance;
        for (const Triangle& t : s.triangles)
            for (int k = 0; k < 3; ++k) {
                const std::uint32_t v = t.vertex[k], w = t.vertex[(k + 1) % 3];
                if (v != w) balance[{std::min(v, w), std::max(v, w)}] += v < w ? 1 : -1;
            }
        return std::ranges::all_of(balance, [](const auto& edge) { return edge.second == 0; });
    }

    const Model& model_;
    std::span<const Contact> contacts_;
    OracleCounts& counts_;
    truth::MeetingCounts decided_;
    std::vector<Surface> surfaces_;
};

}  // namespace

OracleCounts& OracleCounts::operator+=(const OracleCounts& o) {
    for (const auto member :
         {&OracleCounts::overlapping_pairs, &OracleCounts::apart_pairs,
          &OracleCounts::inside_vertices, &OracleCounts::expected_contacts, &OracleCounts::segments,
          &OracleCounts::feature_meetings, &OracleCounts::feature_questions})
        this->*member += o.*member;
    return *this;
}

std::optional<Failure> contradicted_by_truth(const Model& model, std::span<const Contact> contacts,
                                             OracleCounts& counts) {
    return Oracle(model, contacts, counts).run();
}

}  // namespace pierce::fuzz
