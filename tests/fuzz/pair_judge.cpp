#include "fuzz/pair_judge.hpp"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <optional>
#include <random>
#include <sstream>

#include "core/geometry/closest_points_of_segments.hpp"
#include "fuzz/invariants.hpp"
#include "fuzz/solid_surface.hpp"
#include "pierce/constants.hpp"
#include "truth/exact_mesh.hpp"
#include "truth/minimum_translation.hpp"

namespace pierce::fuzz {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using truth::Where;

Kernel::Point_3 exact(Vec3d p) { return {p.x, p.y, p.z}; }
Vec3d plain(const Kernel::Point_3& p) { return {p.x(), p.y(), p.z()}; }

/// A body in the world.
struct Body {
    const ModelBody* body;
    const std::vector<Triangle>* triangles;
    truth::ExactMesh mesh;

    double extent;  ///< of the box around its mesh, or around it now, if it deforms and that is
                    ///< more

    Body(const Model& model, const ModelBody& b)
        : body(&b),
          triangles(&model.mesh(b).triangles),
          mesh(model.ends(b), model.mesh(b).triangles) {
        Box rest;
        for (Vec3f p : model.mesh(b).positions) rest.extend(to_double(p));
        extent = rest.extent();
        if (b.motion == Motion::deforming) extent = std::max(extent, mesh.box().extent());
    }

    SolidSurface surface() const {
        return {{mesh.positions().begin(), mesh.positions().end()}, *triangles};
    }
    Vec3d corner(const Triangle& t, int k) const { return mesh.positions()[t.vertex[k]]; }
    Kernel::Triangle_3 face(const Triangle& t) const {
        return {exact(corner(t, 0)), exact(corner(t, 1)), exact(corner(t, 2))};
    }
    Box box(const Triangle& t) const {
        Box b;
        for (int k = 0; k < 3; ++k) b.extend(corner(t, k));
        return b;
    }
    bool is_convex() const {
        return std::ranges::all_of(*triangles, [&](const Triangle& t) {
            return std::ranges::all_of(mesh.vertices(), [&](std::uint32_t v) {
                return CGAL::orientation(exact(corner(t, 0)), exact(corner(t, 1)),
                                         exact(corner(t, 2)),
                                         exact(mesh.positions()[v])) != CGAL::POSITIVE;
            });
        });
    }
    Vec3d normal(const Triangle& t) const {
        return normalized(cross(corner(t, 1) - corner(t, 0), corner(t, 2) - corner(t, 0)));
    }
    /// The edges of its triangles, each once.
    std::vector<std::array<Vec3d, 2>> edges() const {
        std::vector<std::array<Vec3d, 2>> all;
        for (const Triangle& t : *triangles)
            for (int k = 0; k < 3; ++k)
                if (t.vertex[k] < t.vertex[(k + 1) % 3])
                    all.push_back({corner(t, k), corner(t, (k + 1) % 3)});
        return all;
    }
};

class PairJudge {
public:
    PairJudge(const Model& model, std::span<const Contact> contacts, Exact exact,
              PairCounts& counts)
        : contacts_(contacts),
          exact_(exact),
          counts_(counts),
          a_(model, *model.bodies()[0]),
          b_(model, *model.bodies()[1]),
          extent_(std::max(a_.extent, b_.extent)),
          ulp_(constants::float_ulp * extent_),
          touch_(constants::touch_tolerance * extent_) {}

    std::vector<Failure> run() {
        ++counts_.pairs;
        judge_overlap();
        judge_vertices(a_, b_);
        judge_vertices(b_, a_);
        for (const Contact& c : contacts_) judge_contact(c);
        return std::move(failures_);
    }

private:
    void fail(const char* kind, const std::string& text) { failures_.push_back({kind, text}); }

    // Pairs.

    void judge_overlap() {
        const bool overlaps = a_.mesh.overlaps(b_.mesh);
        const auto has_depth = [](const Contact& c) { return c.penetration_depth() > 0; };
        const bool found = std::ranges::any_of(contacts_, has_depth);
        counts_.overlapping += overlaps;
        counts_.found += found;
        if (overlaps && found) {
            const bool by_vertex = std::ranges::any_of(contacts_, [&](const Contact& c) {
                return !c.is_edge() && has_depth(c) && c.found != Found::separation;
            });
            counts_.without_vertex += !by_vertex;
            counts_.deep += certain_depth() > touch_;
        }
        if (overlaps && !found) judge_missed();
        if (found && !overlaps) {
            const double apart = gap();
            counts_.most_apart = std::max(counts_.most_apart, apart / ulp_);
            if (apart <= touch_) {
                ++counts_.near;
                return;
            }
            ++counts_.invented;
            fail("a pair that is apart has a contact", "apart by " + in_ulp(apart));
        }
    }

    void judge_missed() {
        // Of convex bodies the shortest way out is known.
        const bool convex = a_.is_convex() && b_.is_convex();
        const double least = certain_depth(256),
                     most = convex
                                ? truth::minimum_translation({a_.mesh.positions(), *a_.triangles},
                                                             {b_.mesh.positions(), *b_.triangles})
                                      .length
                                : way_out();
        const bool is_shallow = most <= touch_;
        counts_.unseen += !is_shallow && contacts_.empty();
        if (is_shallow || (most <= skin * touch_ && !an_edge_runs_inside())) {
            ++(is_shallow ? counts_.shallow : counts_.missed_skin);
            counts_.most_allowed = std::max(counts_.most_allowed, (convex ? most : least) / ulp_);
            return;
        }
        const std::string text = "from " + in_ulp(convex ? most : least) + " to " + in_ulp(most) +
                                 " deep, " +
                                 (contacts_.empty() ? "no contact" : "a contact without a depth");
        counts_.deep += convex || least > touch_;
        if (least > touch_) {
            ++counts_.missed;
            fail("a pair that overlaps is missed", text);
        } else if (convex) {
            ++counts_.missed_thin;
            fail("a pair is missed whose overlap is thin", text);
        } else {
            ++counts_.undecided;
            fail("a pair without a contact may be deeper than the touch tolerance", text);
        }
    }

    std::string in_ulp(double length) const {
        std::ostringstream text;
        text << length / ulp_ << " ulp of the extent " << extent_;
        return text.str();
    }

    /// Negative outside.
    static double depth_in(const Body& body, Vec3d p) {
        const double distance = body.mesh.nearest(p).distance;
        return body.mesh.where(p) == Where::outside ? -distance : distance;
    }

    /// The way that takes the bodies apart is at least this long: around a point that is p deep in
    /// one and q deep in the other, something of both is in the same place while they move by less
    /// than p + q, also if the point is outside one of them by rounding. With no `steps`, the first
    /// proof that it is more than the touch tolerance will do.
    double certain_depth(int steps = 0) const {
        double best = 0;
        Vec3d at;
        const auto try_point = [&](Vec3d p) {
            const double depth = depth_in(a_, p) + depth_in(b_, p);
            if (depth <= best) return false;
            best = depth;
            at = p;
            return true;
        };
        const auto enough = [&] { return steps == 0 && best > touch_; };
        for (const Body* body : {&a_, &b_})
            for (std::uint32_t v : body->mesh.vertices()) {
                try_point(body->mesh.positions()[v]);
                if (enough()) return best;
            }
        for (const auto& [one, other] : {std::pair(&a_, &b_), std::pair(&b_, &a_)})
            for (const auto& edge : one->edges())
                for (Vec3d p : middles_inside(edge, *other)) {
                    try_point(p);
                    if (enough()) return best;
                }
        if (best == 0) return 0;
        // Uphill, in smaller and smaller steps.
        std::minstd_rand engine;
        std::uniform_real_distribution<double> number(-1, 1);
        double step = std::max(best, touch_);
        for (int k = 0; k < std::max(steps, 64) && !enough(); ++k)
            step *= try_point(at + step * Vec3d{number(engine), number(engine), number(engine)})
                        ? 1.5
                        : 0.9;
        return best;
    }

    /// The middles of the parts of a segment between two places where it meets the body.
    static std::vector<Vec3d> middles_inside(const std::array<Vec3d, 2>& edge, const Body& body) {
        const Kernel::Segment_3 segment(exact(edge[0]), exact(edge[1]));
        Box box;
        for (Vec3d p : edge) box.extend(p);
        if (!overlap(box, body.mesh.box())) return {};
        const Vec3d way = edge[1] - edge[0];
        std::vector<double> met = {0, 1};
        for (const Triangle& t : *body.triangles) {
            if (!overlap(box, body.box(t)) || !CGAL::do_intersect(segment, body.face(t))) continue;
            const Vec3d n = cross(body.corner(t, 1) - body.corner(t, 0),
                                  body.corner(t, 2) - body.corner(t, 0));
            if (dot(n, way) != 0)
                met.push_back(
                    std::clamp(dot(n, body.corner(t, 0) - edge[0]) / dot(n, way), 0., 1.));
        }
        std::ranges::sort(met);
        std::vector<Vec3d> middles;
        for (std::size_t k = 0; k + 1 < met.size(); ++k)
            if (met[k] < met[k + 1]) middles.push_back(edge[0] + 0.5 * (met[k] + met[k + 1]) * way);
        return middles;
    }

    /// True if a part of an edge is certainly inside the other body, deeper than rounding.
    bool an_edge_runs_inside() const {
        for (const auto& [one, other] : {std::pair(&a_, &b_), std::pair(&b_, &a_)})
            for (const auto& edge : one->edges())
                for (Vec3d p : middles_inside(edge, *other))
                    if (other->mesh.where(p) == Where::inside &&
                        other->mesh.nearest(p).distance > touch_)
                        return true;
        return false;
    }

    /// The shortest way to take them apart that can be found, no shorter than the shortest there
    /// is; or any that is within the touch tolerance.
    double way_out() const {
        std::vector<Vec3d> directions = likely_directions();
        std::minstd_rand engine;
        std::uniform_real_distribution<double> number(-1, 1);
        const auto any = [&] { return Vec3d{number(engine), number(engine), number(engine)}; };
        std::vector<std::pair<double, Vec3d>> ways;
        for (Vec3d d : directions)
            for (double sign : {1.0, -1.0}) {
                const double way = way_along(sign * d);
                if (way <= touch_) return way;
                ways.emplace_back(way, sign * d);
            }
        std::ranges::sort(ways, {}, [](const auto& w) { return w.first; });
        ways.resize(std::min<std::size_t>(ways.size(), 4));
        for (auto& [best, at] : ways) {
            double step = 0.5;
            for (int k = 0; k < 64 && best > touch_; ++k) {
                const Vec3d d = normalized(at + step * any());
                const double way = way_along(d);
                step *= way < best ? 1.5 : 0.85;
                if (way < best) {
                    best = way;
                    at = d;
                }
            }
        }
        return std::ranges::min_element(ways, {}, [](const auto& w) { return w.first; })->first;
    }

    /// How far one of them has to go in a direction until they are apart, or a little more.
    double way_along(Vec3d direction) const {
        const auto apart = [&](double way) {
            return !a_.mesh.overlaps(b_.mesh, Frame{{}, way * direction});
        };
        if (apart(touch_)) return touch_;
        double least = touch_, most = 2 * touch_;
        for (; !apart(most); most *= 2) {
            if (most > 2 * skin * touch_) return HUGE_VAL;
            least = most;
        }
        for (int k = 0; k < 8; ++k) {
            const double middle = 0.5 * (least + most);
            (apart(middle) ? most : least) = middle;
        }
        return most;
    }

    /// Along axes and diagonals, and along what separates features that meet.
    std::vector<Vec3d> likely_directions() const {
        std::vector<Vec3d> directions;
        for (int x = 0; x <= 1; ++x)
            for (int y = -1; y <= 1; ++y)
                for (int z = -1; z <= 1; ++z)
                    if (x > 0 || y > 0 || (y == 0 && z > 0))
                        directions.push_back(normalized(Vec3d{double(x), double(y), double(z)}));
        constexpr std::size_t enough = 400;
        for (const Triangle& t : *a_.triangles)
            for (const Triangle& u : *b_.triangles) {
                if (directions.size() > enough) return directions;
                if (!overlap(a_.box(t), b_.box(u)) || !CGAL::do_intersect(a_.face(t), b_.face(u)))
                    continue;
                directions.push_back(a_.normal(t));
                directions.push_back(b_.normal(u));
                for (int i = 0; i < 3; ++i)
                    for (int j = 0; j < 3; ++j) {
                        const Vec3d n = normalized(
                            cross(a_.corner(t, (i + 1) % 3) - a_.corner(t, i),
                                  b_.corner(u, (j + 1) % 3) - b_.corner(u, j)));
                        if (length(n) > 0.5) directions.push_back(n);
                    }
            }
        return directions;
    }

    /// How far the surfaces are apart, given that they are.
    double gap() const {
        double least = HUGE_VAL;
        for (const auto& [one, other] : {std::pair(&a_, &b_), std::pair(&b_, &a_)})
            for (std::uint32_t v : one->mesh.vertices())
                least = std::min(least, other->mesh.nearest(one->mesh.positions()[v]).distance);
        for (const auto& e : a_.edges())
            for (const auto& f : b_.edges())
                least = std::min(least, std::sqrt(CGAL::squared_distance(
                                            Kernel::Segment_3(exact(e[0]), exact(e[1])),
                                            Kernel::Segment_3(exact(f[0]), exact(f[1])))));
        return least;
    }

    // Contacts.

    static Ending ending_of(const Contact& c) {
        if (c.found == Found::separation) return Ending::separation;
        if (!(c.penetration_depth() > 0)) return Ending::touching;
        return c.reprojected ? Ending::reprojected : Ending::unmoved;
    }

    /// True if the inward ray of a vertex lies in the plane of one of the target's faces.
    static bool ray_in_plane(const Contact& c, const Body& source, const Body& target) {
        if (c.is_edge() || c.found == Found::separation) return false;
        return ray_in_plane(c.vertex, source, target);
    }
    static bool ray_in_plane(std::uint32_t vertex, const Body& source, const Body& target) {
        const Vec3d from = source.mesh.positions()[vertex];
        const Vec3d out = source.surface().outward_directions()[vertex];
        const double touch = constants::touch_tolerance * source.extent;
        return target.surface().has_plane_along(from, from - source.extent * out, touch);
    }

    /// Every vertex inside the target is in contact with it.
    void judge_vertices(const Body& source, const Body& target) {
        for (std::uint32_t v : source.mesh.vertices()) {
            const Vec3d p = source.mesh.positions()[v];
            if (!target.mesh.box().contains(p) || target.mesh.where(p) != Where::inside) continue;
            const double distance = target.mesh.nearest(p).distance;
            if (distance <= touch_ || ray_in_plane(v, source, target)) continue;
            ++counts_.vertices_inside;
            const bool found = std::ranges::any_of(contacts_, [&](const Contact& c) {
                return !c.is_edge() && c.vertex == v &&
                       (c.source == Side::a ? &a_ : &b_) == &source;
            });
            if (found) continue;
            ++counts_.vertices_missed;
            fail("a vertex inside has no contact", "vertex " + std::to_string(v) + " of body " +
                                                       std::to_string(source.body->id.index) +
                                                       ", " + in_ulp(distance) + " inside");
        }
    }

    /// [length] How far the contact of an edge is from the shortest way between that edge and an
    /// edge of the target.
    static double off_ridge(const Contact& c, const Body& source, const Body& target, Vec3d start,
                            Vec3d end) {
        const Vec3d a = source.mesh.positions()[c.vertex], b = source.mesh.positions()[c.edge_end];
        double off = HUGE_VAL;
        for (const auto& ridge : target.edges()) {
            const SegmentPlaces at = closest_points_of_segments(a, b, ridge[0], ridge[1]);
            const Vec3d from = a + at.first * (b - a),
                        to = ridge[0] + at.second * (ridge[1] - ridge[0]);
            off = std::min(off, std::max({length(from - start), length(to - end),
                                          std::fabs(length(to - from) - c.penetration_depth())}));
        }
        return off;
    }

    void judge_contact(const Contact& c) {
        const bool from_a = c.source == Side::a;
        const Body &source = from_a ? a_ : b_, &target = from_a ? b_ : a_;
        const Vec3d start = c.is_edge() ? (from_a ? c.point_a : c.point_b)
                                        : source.mesh.positions()[c.vertex];
        const Vec3d end = from_a ? c.point_b : c.point_a, normal = from_a ? c.normal : -c.normal;
        const double depth = c.penetration_depth();
        const double distance = target.mesh.nearest(start).distance;
        const bool outside = target.mesh.where(start) == Where::outside;

        // Of all places that are as close, the one the contact ends at.
        constexpr double alike = 0x1p-40;
        double off = HUGE_VAL, angle = HUGE_VAL;
        for (const Triangle& t : *target.triangles) {
            const Vec3d closest = plain(
                Kernel().construct_projected_point_3_object()(target.face(t), exact(start)));
            const Vec3d way = closest - start;
            if (length(way) > distance + alike * extent_) continue;
            // The contact's normal goes into the target where it overlaps.
            const double here = std::max(length(end - closest), length(-depth * normal - way));
            off = std::min(off, here);
            angle = std::min(angle, std::atan2(length(cross(-normal, way)), dot(-normal, way)));
        }
        const double to_ridge = c.is_edge() && c.reprojected
                                    ? off_ridge(c, source, target, start, end)
                                    : HUGE_VAL;
        if (to_ridge <= touch_) {
            ++counts_.ridges;
            return;
        }
        const double depth_error = std::fabs(depth - (outside ? -distance : distance));
        off = std::max(off, depth_error);

        const Ending ending = ending_of(c);
        EndingErrors& errors = counts_.errors[c.is_edge()][static_cast<std::size_t>(ending)];
        ++errors.contacts;
        if (off > touch_ && ray_in_plane(c, source, target)) {
            ++errors.in_plane;
            if (exact_ == Exact::all && !c.is_edge())
                fail("a contact whose ray runs in the plane of a face is not exact", to_text(c));
            return;
        }
        errors.most = std::max(errors.most, off / ulp_);
        errors.most_depth = std::max(errors.most_depth, depth_error / ulp_);
        if (!outside && distance > touch_ && depth > 0)
            errors.most_angle = std::max(errors.most_angle, angle);
        if (!(off > touch_)) return;
        ++errors.beyond;
        const bool stays = ending == Ending::separation ||
                           (ending == Ending::unmoved && distance <= touch_);
        if (c.is_edge() || (stays && exact_ == Exact::documented)) return;
        std::ostringstream text;
        text << name_of(ending) << ": depth " << depth / ulp_ << " ulp, but the surface is "
             << (outside ? "outside by " : "") << distance / ulp_ << " ulp away; off by "
             << off / ulp_ << " ulp, " << angle << " rad: " << to_text(c);
        fail(!stays                         ? "a contact does not end at the closest point"
             : ending == Ending::separation ? "a contact by separation is not exact"
                                            : "a contact of a vertex that touches is not exact",
             text.str());
    }

    /// [touch tolerances] The least overlap that is found of bodies whose edges only touch.
    static constexpr double skin = 16;

    std::span<const Contact> contacts_;
    Exact exact_;
    PairCounts& counts_;
    Body a_, b_;
    double extent_, ulp_, touch_;
    std::vector<Failure> failures_;
};

}  // namespace

const char* name_of(Ending ending) {
    constexpr const char* names[] = {"reprojected", "touching", "unmoved", "separation"};
    static_assert(std::size(names) == static_cast<std::size_t>(Ending::count));
    return names[static_cast<std::size_t>(ending)];
}

EndingErrors& EndingErrors::operator+=(const EndingErrors& o) {
    contacts += o.contacts;
    beyond += o.beyond;
    in_plane += o.in_plane;
    most = std::max(most, o.most);
    most_depth = std::max(most_depth, o.most_depth);
    most_angle = std::max(most_angle, o.most_angle);
    return *this;
}

PairCounts& PairCounts::operator+=(const PairCounts& o) {
    for (const auto member :
         {&PairCounts::pairs, &PairCounts::overlapping, &PairCounts::deep, &PairCounts::found,
          &PairCounts::without_vertex, &PairCounts::missed, &PairCounts::missed_thin,
          &PairCounts::missed_skin, &PairCounts::undecided, &PairCounts::unseen,
          &PairCounts::shallow, &PairCounts::invented, &PairCounts::near, &PairCounts::ridges,
          &PairCounts::vertices_inside, &PairCounts::vertices_missed})
        this->*member += o.*member;
    most_allowed = std::max(most_allowed, o.most_allowed);
    most_apart = std::max(most_apart, o.most_apart);
    for (std::size_t of = 0; of < errors.size(); ++of)
        for (std::size_t k = 0; k < errors[of].size(); ++k) errors[of][k] += o.errors[of][k];
    return *this;
}

std::vector<Failure> judge_pair(const Model& model, std::span<const Contact> contacts, Exact exact,
                                PairCounts& counts) {
    return PairJudge(model, contacts, exact, counts).run();
}

}  // namespace pierce::fuzz
