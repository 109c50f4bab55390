#include "fuzz/invariants.hpp"
#include "core/mesh/mesh_view.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <sstream>
#include <tuple>

namespace pierce::fuzz {
namespace {

constexpr double rounding = 1e-12;  // of double arithmetic on coordinates, with some hundred to
                                    // spare

/// A body's points and how large it is.
struct Placed {
    const ModelBody* body = nullptr;
    const MeshData* mesh = nullptr;
    std::vector<Vec3d> points;
    double extent = 0, coordinate = 0;
};

class Checker {
public:
    Checker(const Model& model, std::span<const Contact> contacts)
        : model_(model), contacts_(contacts) {
        for (const ModelBody* b : model.bodies()) {
            Placed& p = placed_[b->id];
            p.body = b;
            p.mesh = &model.mesh(*b);
            p.points = model.ends(*b);
            Box box;
            for (const Vec3d& v : p.points) {
                box.extend(v);
                p.coordinate = std::max(p.coordinate, length(v));
            }
            p.extent = box.extent();
        }
    }

    std::optional<Failure> run() {
        std::set<std::tuple<BodyId, BodyId, std::uint64_t>> keys;
        for (const Contact& c : contacts_) {
            check(c);
            if (!keys.insert({c.a, c.b, c.feature()}).second) fail("keys are unique", c);
            if (failure_) return failure_;
        }
        check_order();
        return failure_;
    }

private:
    void fail(const char* promise, const Contact& c, const std::string& more = {}) {
        if (!failure_) failure_ = {std::string("contact: ") + promise, to_text(c) + " " + more};
    }

    void check(const Contact& c) {
        const auto at_a = placed_.find(c.a), at_b = placed_.find(c.b);
        if (at_a == placed_.end() || at_b == placed_.end())
            return fail("names bodies of the world", c);
        if (c.a.index > c.b.index) return fail("a is not after b", c);
        const Placed &a = at_a->second, &b = at_b->second;
        if (!model_.takes_part(*a.body) || !model_.takes_part(*b.body))
            return fail("excluded bodies have none", c);
        const Placed &source = c.source == Side::a ? a : b, &target = c.source == Side::a ? b : a;
        if (c.vertex >= source.points.size() || c.triangle >= target.mesh->triangles.size() ||
            (c.is_edge() && c.edge_end >= source.points.size()))
            return fail("ids are in range", c);
        for (double x : {c.distance, c.along, c.time, c.point_a.x, c.point_a.y, c.point_a.z,
                         c.point_b.x, c.point_b.y, c.point_b.z, c.normal.x, c.normal.y, c.normal.z,
                         c.face_normal.x, c.face_normal.y, c.face_normal.z, c.barycentric[0],
                         c.barycentric[1], c.barycentric[2]})
            if (!std::isfinite(x)) return fail("numbers are finite", c);
        if (c.is_edge() && !is_edge(*source.mesh, c.vertex, c.edge_end))
            return fail("an edge is one of the mesh", c);
        if (!(c.along >= 0 && c.along <= 1))
            return fail("a place along an edge is between its ends", c);
        if (!(c.time >= 0 && c.time <= 1)) return fail("a time is within the step", c);
        if (std::fabs(length(c.normal) - 1) > 1e-9 && !(c.unknown_side && length(c.normal) == 0))
            return fail("the normal is unit or flagged", c);
        const double face = length(c.face_normal);
        if (std::fabs(face - 1) > 1e-9 && face != 0) return fail("the face normal is unit", c);
        const double sum = c.barycentric[0] + c.barycentric[1] + c.barycentric[2];
        if (std::fabs(sum - 1) > 1e-9)
            return fail("barycentrics sum to one", c, std::to_string(sum));
        const double size = std::max(source.extent, target.extent);
        // Sheets see float32 coordinates.
        const double digits = c.of_sheet ? rounding + constants::float_ulp : rounding;
        const double room = digits * (source.coordinate + target.coordinate) +
                            2 * constants::touch_tolerance * size;
        if (std::fabs(dot(c.point_b - c.point_a, c.normal) - c.distance) > room && !c.unknown_side)
            return fail("(point_b - point_a) . normal = distance", c,
                        "is " + std::to_string(dot(c.point_b - c.point_a, c.normal)));
        if (!model_.may_meet(*a.body, *b.body)) return fail("the bodies meet", c);
        const bool is_near = !c.of_sheet && c.found == Found::near;
        const double margin = model_.margin(*a.body, *b.body),
                     least = c.is_edge() ? -constants::passed_share * margin : 0.0;
        if (is_near && !(c.distance >= least && c.distance < margin))
            return fail("what is near is nearer than the margin", c);
        if (!c.of_sheet && !is_near && c.distance > 0)
            return fail("solids in contact are not apart", c);
        check_points(c, source, target, room);
    }

    void check_points(const Contact& c, const Placed& source, const Placed& target, double room) {
        Vec3d p = source.points[c.vertex];
        if (c.is_edge()) p = (1 - c.along) * p + c.along * source.points[c.edge_end];
        Vec3d q;
        const Triangle& t = target.mesh->triangles[c.triangle];
        double weight = 1;
        for (int k = 0; k < 3; ++k) {
            q += c.barycentric[k] * target.points[t.vertex[k]];
            weight = std::max(weight, std::fabs(c.barycentric[k]));
        }
        if (c.source == Side::b) std::swap(p, q);
        if (length(p - c.point_a) > weight * room || length(q - c.point_b) > weight * room)
            fail("points are where their weights say", c);
    }

    static bool is_edge(const MeshData& mesh, std::uint32_t v, std::uint32_t w) {
        return v != w && std::ranges::any_of(mesh.triangles, [&](const Triangle& t) {
                   return has_vertex(t, v) && has_vertex(t, w);
               });
    }

    /// Contacts of solids come in this order; of sheets, by pair.
    void check_order() {
        const auto world = [&](const Contact& c) {
            const std::int32_t of_pair = std::max(placed_.at(c.a).body->filter.world,
                                                  placed_.at(c.b).body->filter.world);
            return of_pair == all_worlds ? std::numeric_limits<std::int32_t>::max() : of_pair;
        };
        const auto key = [&](const Contact& c) {
            const bool is_near = c.found == Found::near;
            return std::tuple(world(c), c.a.index, c.b.index, c.source, c.is_edge(),
                              c.is_edge() ? c.edge : c.vertex, is_near,
                              is_near ? c.other_edge : c.chord);
        };
        for (std::size_t i = 1; i < contacts_.size(); ++i) {
            const Contact &before = contacts_[i - 1], &c = contacts_[i];
            if (!before.of_sheet && !c.of_sheet && key(c) < key(before))
                return fail("are in order", c);
        }
    }

    const Model& model_;
    std::span<const Contact> contacts_;
    std::map<BodyId, Placed> placed_;
    std::optional<Failure> failure_;
};

}  // namespace

std::optional<Failure> broken_invariant(const Model& model, std::span<const Contact> contacts) {
    return Checker(model, contacts).run();
}

std::string to_text(const Contact& c) {
    std::ostringstream s;
    s.precision(17);
    const auto vector = [&](Vec3d v) { s << '(' << v.x << ' ' << v.y << ' ' << v.z << ')'; };
    s << "bodies " << c.a.index << '-' << c.b.index << " source "
      << (c.source == Side::a ? 'a' : 'b') << " vertex " << c.vertex;
    if (c.is_edge())
        s << " to " << c.edge_end << " edge " << c.edge << " chord " << c.chord << " along "
          << c.along;
    s << " triangle " << c.triangle << " other edge " << c.other_edge << " found "
      << static_cast<int>(c.found) << " sheet " << c.of_sheet << " reprojected " << c.reprojected
      << " grazing " << c.grazing << " unknown " << c.unknown_side << " age " << c.age << " time "
      << c.time << " distance " << c.distance << " weights " << c.barycentric[0] << ' '
      << c.barycentric[1] << ' ' << c.barycentric[2] << " a ";
    vector(c.point_a);
    s << " b ";
    vector(c.point_b);
    s << " normal ";
    vector(c.normal);
    s << " face ";
    vector(c.face_normal);
    return s.str();
}

}  // namespace pierce::fuzz
