#include "fuzz/pair_generator.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <limits>
#include <numbers>
#include <optional>
#include <utility>
#include <vector>

#include "fuzz/pair_solids.hpp"
#include "fuzz/solid_surface.hpp"
#include "pierce/box.hpp"
#include "pierce/constants.hpp"

namespace pierce::fuzz {
namespace {

/// One of many numbers that have nothing to do with each other (Steele, Lea and Flood 2014).
std::uint64_t mixed(std::uint64_t seed, std::uint64_t number) {
    std::uint64_t z = (seed + 1) * 0x9e3779b97f4a7c15u + number;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return z ^ (z >> 31);
}

Vec3d random_direction(Choices& choices) {
    const double z = choices.real(-1, 1), angle = choices.real(0, 2 * std::numbers::pi),
                 r = std::sqrt(std::max(0.0, 1 - z * z));
    return {r * std::cos(angle), r * std::sin(angle), z};
}

/// A mesh's points somewhere.
struct Placed {
    const MeshData* mesh = nullptr;
    std::vector<Vec3d> points;

    Placed(const MeshData& data, const Pose& pose) : mesh(&data) {
        const Frame frame = frame_of(pose);
        for (Vec3f p : data.positions) points.push_back(frame.to_parent(to_double(p)));
    }
};

/// How far `b` has to go along a direction until it comes apart from `a`, for features of both.
class Departures {
public:
    Departures(const Placed& a, const Placed& b, Vec3d along) : along_(along) {
        const Vec3d other = std::fabs(along.x) < 0.5 ? Vec3d{1, 0, 0} : Vec3d{0, 1, 0};
        across_ = normalized(cross(along, other));
        third_ = cross(along, across_);
        const std::vector<Vec3d> p = seen(a), q = seen(b);
        corners_on_faces(p, b.mesh->triangles, q, 1);
        corners_on_faces(q, a.mesh->triangles, p, -1);
        edges(p, a.mesh->triangles, q, b.mesh->triangles);
    }

    struct Departure {
        double way = 0;
        bool two_edges = false;
    };
    const std::vector<Departure>& all() const { return all_; }
    std::optional<Departure> last() const {
        if (all_.empty()) return std::nullopt;
        return *std::ranges::max_element(all_, {}, &Departure::way);
    }

private:
    std::vector<Vec3d> seen(const Placed& body) const {
        std::vector<Vec3d> points;
        for (const Vec3d& p : body.points)
            points.push_back({dot(across_, p), dot(third_, p), dot(along_, p)});
        return points;
    }
    static double turn(Vec3d a, Vec3d b, Vec3d c) {
        return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
    }

    void corners_on_faces(const std::vector<Vec3d>& corners, const std::vector<Triangle>& faces,
                          const std::vector<Vec3d>& points, double sign) {
        for (const Triangle& t : faces) {
            const Vec3d a = points[t.vertex[0]], b = points[t.vertex[1]], c = points[t.vertex[2]];
            const double whole = turn(a, b, c);
            if (whole == 0) continue;
            for (const Vec3d& p : corners) {
                const double u = turn(b, c, p) / whole, v = turn(c, a, p) / whole, w = 1 - u - v;
                if (u < 0 || v < 0 || w < 0) continue;
                all_.push_back({sign * (p.z - u * a.z - v * b.z - w * c.z), false});
            }
        }
    }

    void edges(const std::vector<Vec3d>& p, const std::vector<Triangle>& first,
               const std::vector<Vec3d>& q, const std::vector<Triangle>& second) {
        for (const Triangle& t : first)
            for (int k = 0; k < 3; ++k) {
                if (t.vertex[k] > t.vertex[(k + 1) % 3]) continue;  // its other triangle has it
                const Vec3d a = p[t.vertex[k]], b = p[t.vertex[(k + 1) % 3]];
                for (const Triangle& u : second)
                    for (int m = 0; m < 3; ++m) {
                        if (u.vertex[m] > u.vertex[(m + 1) % 3]) continue;
                        cross_edges(a, b, q[u.vertex[m]], q[u.vertex[(m + 1) % 3]]);
                    }
            }
    }
    void cross_edges(Vec3d a, Vec3d b, Vec3d c, Vec3d d) {
        if (std::max(a.x, b.x) < std::min(c.x, d.x) || std::max(c.x, d.x) < std::min(a.x, b.x))
            return;
        const double at_a = turn(c, d, a), at_b = turn(c, d, b), at_c = turn(a, b, c),
                     at_d = turn(a, b, d);
        if (at_a * at_b >= 0 || at_c * at_d >= 0) return;
        const double s = at_a / (at_a - at_b), t = at_c / (at_c - at_d);
        all_.push_back({a.z + s * (b.z - a.z) - c.z - t * (d.z - c.z), true});
    }

    Vec3d along_, across_, third_;
    std::vector<Departure> all_;
};

class Maker {
public:
    Maker(const MeshData& a, const MeshData& b, Placement placement, Choices& choices)
        : a_(a),
          b_(b),
          placement_(placement),
          choices_(choices),
          size_(std::max(extent_of(a), extent_of(b))) {}

    Program program() {
        place();
        together();
        Program made;
        // Coverage and the like are for whoever plays it to say.
        made.settings.reproject = true;
        for (const MeshData* mesh : {&a_, &b_}) {
            made.calls.emplace_back().kind = Call::Kind::add_mesh;
            made.calls.back().data = *mesh;
        }
        const std::uint32_t motions = choices_.below(8);
        add(made, 0,
            motions < 4 || motions == 5 ? Motion::rigid
            : motions == 4              ? Motion::fixed
                                        : Motion::deforming);
        add(made, 1, motions < 5 || motions == 7 ? Motion::rigid : Motion::deforming);
        made.calls.emplace_back().kind = Call::Kind::detect;
        return made;
    }

private:
    void place() {
        if (placement_ == Placement::grid) {
            pose_b_.rotation = choices_.pick<Quaternion>({{0, 0, 0, 1},
                                                          {1, 0, 0, 0},
                                                          {1, 0, 0, 1},
                                                          {0, 1, 0, 1},
                                                          {0, 0, 1, 1},
                                                          {1, 1, 1, 1}});
            pose_b_.position = {quarter(), quarter(), quarter()};
            if (choices_.one_in(3))
                pose_b_.position[static_cast<int>(choices_.below(3))] -= depth();
            return;
        }
        pose_b_.rotation = random_rotation(choices_);
        center();
        switch (placement_) {
            case Placement::anywhere:
                pose_b_.position += choices_.real(0, 0.5) * (extent_of(a_) + extent_of(b_)) *
                                    random_direction(choices_);
                break;
            case Placement::any_features:
            case Placement::two_edges:
            case Placement::inner:
                depart();
                break;
            case Placement::onto:
                bring(any_place(Placed(a_, {})), any_place(Placed(b_, pose_b_)));
                pose_b_.position += depth() * random_direction(choices_);
                break;
            case Placement::two_faces:
                face_to_face();
                break;
            case Placement::contained:
                contain();
                break;
            case Placement::grid:
            case Placement::count:
                break;
        }
    }

    double quarter() { return 0.25 * (static_cast<double>(choices_.below(13)) - 6); }

    /// How deep [length]: from less than the touch tolerance to a third of the larger body; in one
    /// of five places apart, and sometimes nothing at all.
    double depth() {
        const double decades = choices_.real(-8, -0.5);
        if (choices_.one_in(16)) return 0;
        if (choices_.one_in(5)) return -size_ * std::pow(10.0, std::min(decades, -2.0));
        return size_ * std::pow(10.0, decades);
    }

    /// The middle of the second body to that of the first.
    void center() {
        Box first, second;
        for (const Vec3d& p : Placed(a_, {}).points) first.extend(p);
        for (const Vec3d& p : Placed(b_, pose_b_).points) second.extend(p);
        pose_b_.position += first.center() - second.center();
    }

    void depart() {
        std::optional<Departures::Departure> chosen;
        Vec3d way;
        for (int tries = 0; tries < 4; ++tries) {
            way = random_direction(choices_);
            const Vec3d aside = cross(way, random_direction(choices_));
            const Vec3d back = pose_b_.position;
            pose_b_.position += 0.3 * choices_.real(0, 1) * size_ * aside;
            const Departures departures(Placed(a_, {}), Placed(b_, pose_b_), way);
            chosen = departures.last();
            if (chosen && placement_ == Placement::inner)
                chosen = departures.all()[choices_.below(
                    static_cast<std::uint32_t>(departures.all().size()))];
            if (chosen && (placement_ != Placement::two_edges || chosen->two_edges)) break;
            if (tries < 3) pose_b_.position = back;
        }
        if (chosen) pose_b_.position += (chosen->way - depth()) * way;
    }

    struct Spot {
        Vec3d at;
        Vec3d normal;
    };
    /// A corner, a place on an edge or on a face.
    Spot any_place(const Placed& body) {
        const Triangle& t = body.mesh->triangles[choices_.below(
            static_cast<std::uint32_t>(body.mesh->triangles.size()))];
        const Vec3d a = body.points[t.vertex[0]], b = body.points[t.vertex[1]],
                    c = body.points[t.vertex[2]];
        const Vec3d normal = normalized(cross(b - a, c - a));
        switch (choices_.below(3)) {
            case 0:
                return {a, normal};
            case 1:
                return {a + choices_.pick({0.5, 0.25, 0.7}) * (b - a), normal};
            default: {
                const double u = choices_.real(0, 1), v = (1 - u) * choices_.real(0, 1);
                return {a + u * (b - a) + v * (c - a), normal};
            }
        }
    }
    void bring(const Spot& on_a, const Spot& on_b) { pose_b_.position += on_a.at - on_b.at; }

    void face_to_face() {
        // Turned so that the normals are opposed, and then around them.
        const Spot on_a = any_place(Placed(a_, {})), on_b = any_place(Placed(b_, {}));
        const Vec3d from = on_b.normal, to = -on_a.normal, axis = cross(from, to);
        const double cosine = dot(from, to);
        Quaternion q{axis.x, axis.y, axis.z, 1 + cosine};
        if (1 + cosine < 1e-6) {
            const Vec3d other = normalized(
                cross(from, std::fabs(from.x) < 0.5 ? Vec3d{1, 0, 0} : Vec3d{0, 1, 0}));
            q = {other.x, other.y, other.z, 0};
        }
        const double half = choices_.real(0, std::numbers::pi);
        pose_b_.rotation = product(
            {to.x * std::sin(half), to.y * std::sin(half), to.z * std::sin(half), std::cos(half)},
            q);
        pose_b_.position = on_a.at - rotation_matrix(pose_b_.rotation) * on_b.at -
                           depth() * on_a.normal;
    }

    static Quaternion product(Quaternion p, Quaternion q) {
        return {p.w * q.x + p.x * q.w + p.y * q.z - p.z * q.y,
                p.w * q.y - p.x * q.z + p.y * q.w + p.z * q.x,
                p.w * q.z + p.x * q.y - p.y * q.x + p.z * q.w,
                p.w * q.w - p.x * q.x - p.y * q.y - p.z * q.z};
    }

    void contain() {
        // Somewhere behind a face, as far as up to twice the second body's size.
        const Spot spot = any_place(Placed(a_, {}));
        pose_b_.position += spot.at;
        Box first;
        for (const Vec3d& p : Placed(a_, {}).points) first.extend(p);
        pose_b_.position += -1.0 * first.center() -
                            choices_.real(0, 1) * extent_of(b_) * spot.normal;
    }

    /// Moves both, so that nothing is at the origin.
    void together() {
        if (placement_ == Placement::grid ? !choices_.one_in(4) : choices_.one_in(2)) return;
        Pose all;
        all.rotation = random_rotation(choices_);
        all.position = choices_.pick({0.0, 10.0, 100.0}) * size_ * random_direction(choices_);
        const Frame frame = frame_of(all);
        pose_a_ = all;
        pose_b_ = {frame.to_parent(pose_b_.position), product(all.rotation, pose_b_.rotation)};
    }

    void add(Program& made, std::uint32_t which, Motion motion) {
        const MeshData& mesh = which == 0 ? a_ : b_;
        const Pose& pose = which == 0 ? pose_a_ : pose_b_;
        std::vector<Vec3f> positions;
        if (motion == Motion::deforming) {
            positions = deformed(mesh, pose);
            // Float32 may have folded something thin.
            if (positions.empty()) motion = Motion::rigid;
        }
        Call& call = made.calls.emplace_back();
        call.kind = motion == Motion::fixed   ? Call::Kind::add_fixed_body
                    : motion == Motion::rigid ? Call::Kind::add_rigid_body
                                              : Call::Kind::add_deforming_body;
        call.mesh = which;
        if (motion == Motion::deforming)
            call.positions = std::move(positions);
        else
            call.pose = pose;
    }

    /// Nothing, if it is no solid any more.
    std::vector<Vec3f> deformed(const MeshData& mesh, const Pose& pose) {
        const double bend = choices_.pick({0.0, 0.0, 0.02, 0.1}) * extent_of(mesh),
                     wave = 4 / extent_of(mesh);
        const Frame frame = frame_of(pose);
        std::vector<Vec3f> positions;
        SolidSurface surface{{}, mesh.triangles};
        Box box;
        for (Vec3f p : mesh.positions) {
            Vec3d q = to_double(p);
            q.z += bend * std::sin(wave * q.x);
            positions.push_back(to_float(frame.to_parent(q)));
            surface.points.push_back(to_double(positions.back()));
            box.extend(surface.points.back());
        }
        if (!surface.is_proper(4 * constants::touch_tolerance * box.extent())) return {};
        return positions;
    }

    const MeshData &a_, &b_;
    Placement placement_;
    Choices& choices_;
    double size_;
    Pose pose_a_, pose_b_;
};

}  // namespace

const char* name_of(Placement placement) {
    constexpr const char* names[] = {"anywhere", "any_features", "two_edges", "inner",
                                     "onto",     "two_faces",    "grid",      "contained"};
    static_assert(std::size(names) == static_cast<std::size_t>(Placement::count));
    return names[static_cast<std::size_t>(placement)];
}

const MeshData& PairGenerator::mesh(std::uint32_t number) {
    const auto known = meshes_.find(number);
    if (known != meshes_.end()) return known->second;
    const std::vector<std::uint8_t> bytes = bytes_of(mixed(seed_, ~std::uint64_t{number}));
    Choices choices(bytes);
    // Some are small, and go into the others.
    const double scale = number % 4 == 0 ? 0.125 : choices.pick({1.0, 1.0, 0.5, 3.0});
    MeshData data = random_solid(choices);
    for (Vec3f& p : data.positions) p = to_float(scale * to_double(p));
    return meshes_.emplace(number, std::move(data)).first->second;
}

SolidPair PairGenerator::pair(std::uint64_t number) {
    const std::vector<std::uint8_t> bytes = bytes_of(mixed(seed_, number));
    Choices choices(bytes);
    SolidPair made;
    made.placement = static_cast<Placement>(number % static_cast<std::uint64_t>(Placement::count));
    std::uint32_t a = choices.below(mesh_count_), b = choices.below(mesh_count_);
    if (made.placement == Placement::contained) b -= b % 4;
    if (made.placement != Placement::contained && choices.one_in(3)) b = a;
    made.program = Maker(mesh(a), mesh(b), made.placement, choices).program();
    return made;
}

}  // namespace pierce::fuzz
