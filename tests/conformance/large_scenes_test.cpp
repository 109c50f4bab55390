// Complete coverage on meshes that were scanned or modelled (Debian's libcgal-demo), many at a
// time: colliding pairs against exact predicates.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <deque>
#include <filesystem>
#include <map>
#include <set>

#include "pierce/constants.hpp"
#include "pierce/embree_backend.hpp"
#include "pierce/reference_backends.hpp"
#include "pierce/world.hpp"
#include "scenes/files/mesh_io.hpp"
#include "support/random.hpp"
#include "truth/exact_mesh.hpp"

namespace pierce {
namespace {

namespace fs = std::filesystem;

using Pair = std::pair<std::uint32_t, std::uint32_t>;
using Pairs = std::set<Pair>;

std::vector<Vec3d> in_double(std::span<const Vec3f> positions) {
    std::vector<Vec3d> result;
    for (Vec3f p : positions) result.push_back(to_double(p));
    return result;
}

truth::ExactMesh exact(const MeshData& mesh) { return {in_double(mesh.positions), mesh.triangles}; }

/// The file's mesh around the origin, its longest side of the given length.
MeshData read_scaled(const std::string& name, double size) {
    MeshData mesh = scenes::read_mesh(fs::path(PIERCE_MESH_FOLDER) / (name + ".off"));
    Box box;
    for (Vec3f p : mesh.positions) box.extend(to_double(p));
    const Vec3d extent = box.upper - box.lower;
    const double scale = size / std::max({extent.x, extent.y, extent.z});
    for (Vec3f& p : mesh.positions) p = to_float(scale * (to_double(p) - box.center()));
    return mesh;
}

/// What a body of a crowd is.
struct Kind {
    std::string mesh;
    double size = 1;
    bool deforms = false;
    std::string within = "";  ///< its middle is put inside the body of this mesh, if there is one
                              ///< before it
};

/// Bodies of many meshes, how they stand, and which of them overlap.
class Crowd {
public:
    explicit Crowd(std::vector<Kind> kinds)
        : kinds_(std::move(kinds)), poses_(kinds_.size()), twists_(kinds_.size()) {
        for (const Kind& kind : kinds_) {
            meshes_.push_back(read_scaled(kind.mesh, kind.size));
            rest_.push_back(exact(meshes_.back()));
            EXPECT_TRUE(rest_.back().closed()) << kind.mesh << " has no inside";
        }
    }

    World world(std::unique_ptr<Backend> backend, const Settings& settings) const {
        World world(std::move(backend), settings);
        for (std::size_t i = 0; i < kinds_.size(); ++i) {
            const MeshId mesh = world.add_mesh(kinds_[i].mesh, meshes_[i]);
            if (kinds_[i].deforms)
                world.add_deforming_body(mesh);
            else
                world.add_rigid_body(mesh);
        }
        return world;
    }

    /// Puts everything anywhere, middles in a box of twice this half width.
    void scatter(test::Random& random, double half) {
        for (std::size_t i = 0; i < kinds_.size(); ++i) {
            poses_[i] = {random.in_box(half), random.rotation()};
            twists_[i] = random.uniform(-0.5, 0.5);
            for (std::size_t k = 0; k < i; ++k)
                if (kinds_[i].within == kinds_[k].mesh)
                    poses_[i].position = frame_of(poses_[k]).to_parent(point_inside(k, random));
        }
    }

    /// Moves, turns and twists everything a little.
    void move(test::Random& random, double way) {
        for (std::size_t i = 0; i < kinds_.size(); ++i) {
            poses_[i].position += random.in_box(way);
            Quaternion& q = poses_[i].rotation;
            for (double* part : {&q.x, &q.y, &q.z, &q.w}) *part += random.uniform(-way, way);
            twists_[i] += random.uniform(-way, way);
        }
    }

    /// Puts two rigid bodies side by side, all others far away, and returns by how much b must move
    /// along x to and fro: at the first place the two overlap, at the second, further by `width`,
    /// they do not.
    std::array<double, 2> part(std::size_t a, std::size_t b, test::Random& random, double width) {
        for (std::size_t i = 0; i < kinds_.size(); ++i)
            poses_[i].position = {0, 100.0 + static_cast<double>(i) * 10, 0};
        poses_[a] = {{}, random.rotation()};
        poses_[b] = {{}, random.rotation()};
        const auto overlap_at = [&](double x) {
            place(b, x);
            return rest_[a].overlaps(rest_[b],
                                     relative_frame(frame_of(poses_[b]), frame_of(poses_[a])));
        };
        double inside = 0, outside = 4;
        while (!overlap_at(inside)) inside = random.uniform(-1, 1);
        while (outside - inside > width) {
            const double middle = (inside + outside) / 2;
            (overlap_at(middle) ? inside : outside) = middle;
        }
        return {inside, outside};
    }

    void place(std::size_t i, double x) { poses_[i].position = {x, 0, 0}; }

    /// Puts the world's bodies, all of which are the crowd's, where the crowd is.
    void put(World& world) const {
        for (std::uint32_t i = 0; i < kinds_.size(); ++i)
            if (kinds_[i].deforms)
                world.set_positions({i, 1}, twisted(i));
            else
                world.set_pose({i, 1}, poses_[i]);
    }

    struct Overlaps {
        Pairs pairs;
        std::size_t inside_one_another = 0;  ///< pairs whose surfaces do not meet
    };

    Overlaps overlaps() const {
        std::deque<truth::ExactMesh> deformed;
        std::vector<Placed> bodies;
        for (std::size_t i = 0; i < kinds_.size(); ++i) bodies.push_back(placed(i, deformed));
        Overlaps result;
        for (std::uint32_t a = 0; a < bodies.size(); ++a)
            for (std::uint32_t b = a + 1; b < bodies.size(); ++b) {
                const Frame b_in_a = relative_frame(bodies[b].frame, bodies[a].frame);
                const bool meet = bodies[a].mesh->surfaces_intersect(*bodies[b].mesh, b_in_a);
                if (!meet && !bodies[a].mesh->overlaps(*bodies[b].mesh, b_in_a)) continue;
                result.pairs.insert({a, b});
                result.inside_one_another += !meet;
            }
        return result;
    }

    /// True if two touch tolerances' way, in one of 26 directions, parts the two: they overlap by
    /// less than that.
    bool overlap_within_tolerance(Pair pair) const {
        std::deque<truth::ExactMesh> deformed;
        const Placed a = placed(pair.first, deformed), b = placed(pair.second, deformed);
        const double way = 2 * constants::touch_tolerance *
                           std::max(a.mesh->box().extent(), b.mesh->box().extent());
        for (int direction = 0; direction < 27; ++direction) {
            Frame moved = b.frame;
            moved.origin += way * normalized(Vec3d{direction % 3 - 1.0, direction / 3 % 3 - 1.0,
                                                   direction / 9 - 1.0});
            if (!a.mesh->overlaps(*b.mesh, relative_frame(moved, a.frame))) return true;
        }
        return false;
    }

    std::string name(Pair pair) const {
        return kinds_[pair.first].mesh + " (" + std::to_string(pair.first) + ") and " +
               kinds_[pair.second].mesh + " (" + std::to_string(pair.second) + ")";
    }

private:
    struct Placed {
        const truth::ExactMesh* mesh;
        Frame frame;
    };

    /// `deformed` keeps the mesh of a body that deforms.
    Placed placed(std::size_t i, std::deque<truth::ExactMesh>& deformed) const {
        if (!kinds_[i].deforms) return {&rest_[i], frame_of(poses_[i])};
        return {&deformed.emplace_back(exact({twisted(i), meshes_[i].triangles})), {}};
    }

    std::vector<Vec3f> twisted(std::size_t i) const {
        MeshData mesh = meshes_[i];
        for (Vec3f& p : mesh.positions) {
            const Vec3d q = to_double(p);
            const double angle = twists_[i] * q.z / kinds_[i].size, c = std::cos(angle),
                         s = std::sin(angle);
            p = to_float({c * q.x - s * q.y, s * q.x + c * q.y, q.z});
        }
        return test::placed(mesh, poses_[i]);
    }

    Vec3d point_inside(std::size_t i, test::Random& random) const {
        for (;;)
            if (const Vec3d p = random.in_box(0.5); rest_[i].where(p) == truth::Where::inside)
                return p;
    }

    std::vector<Kind> kinds_;
    std::vector<MeshData> meshes_;
    std::vector<truth::ExactMesh> rest_;
    std::vector<Pose> poses_;
    std::vector<double> twists_;  ///< [rad] from end to end
};

/// The pairs of a world's last step.
struct FoundPairs {
    Pairs touching, overlapping, by_vertices;

    explicit FoundPairs(const World& world) {
        for (const Contact& c : world.contacts()) {
            const Pair pair{c.a.index, c.b.index};
            touching.insert(pair);
            if (c.penetration_depth() > 0) overlapping.insert(pair);
            if (!c.is_edge() && c.found != Found::separation) by_vertices.insert(pair);
        }
    }
};

Pairs without(const Pairs& all, const Pairs& some) {
    Pairs rest;
    std::ranges::set_difference(all, some, std::inserter(rest, rest.end()));
    return rest;
}

class LargeScenesTest : public testing::Test {
protected:
    LargeScenesTest()
        : random(2024), trace(__FILE__, __LINE__, "seed " + std::to_string(random.seed())) {}

    void SetUp() override {
        if (!fs::exists(PIERCE_MESH_FOLDER)) GTEST_SKIP() << "libcgal-demo is not installed";
    }

    void TearDown() override {
        for (const auto& [name, number] : seen) {
            RecordProperty(name, std::to_string(number));
            std::printf("%s: %zu\n", name.c_str(), number);
        }
    }

    /// One step of every world, each of which must find the pairs that overlap, by more than the
    /// tolerance, and no others.
    void compare(const Crowd& crowd, std::vector<World>& worlds) {
        const Crowd::Overlaps truth = crowd.overlaps();
        for (World& world : worlds) {
            SCOPED_TRACE(!world.plan().remembers() ? "off" : "certified");
            crowd.put(world);
            world.detect();
            const FoundPairs found(world);
            for (Pair p : without(truth.pairs, found.touching)) {
                ++seen["missed"];
                EXPECT_TRUE(crowd.overlap_within_tolerance(p)) << crowd.name(p) << " are missed";
            }
            for (Pair p : without(found.overlapping, truth.pairs))
                ADD_FAILURE() << crowd.name(p) << " do not overlap";
        }
        const FoundPairs found(worlds[0]);
        seen["pairs of boxes"] += worlds[0].stats().pairs;
        seen["overlapping"] += truth.pairs.size();
        seen["inside one another"] += truth.inside_one_another;
        seen["separated"] += worlds[0].stats().separated_pairs;
        seen["touching only"] += without(found.touching, truth.pairs).size();
        seen["missed by vertices"] += without(truth.pairs, found.by_vertices).size();
    }

    /// Anywhere, then on by small and large steps.
    void run(Crowd& crowd, std::vector<World>& worlds, int scatters) {
        for (int i = 0; i < scatters; ++i) {
            crowd.scatter(random, i % 2 == 0 ? 0.5 : 1.0);
            for (double way : {0.0, 0.0, 1e-4, 1e-3, 1e-2, 0.05}) {
                SCOPED_TRACE("scatter " + std::to_string(i) + ", way " + std::to_string(way));
                crowd.move(random, way);
                compare(crowd, worlds);
            }
        }
    }

    test::Random random;
    testing::ScopedTrace trace;
    std::map<std::string, std::size_t> seen;
};

Settings complete(Temporal temporal) {
    return {.coverage = Coverage::complete, .temporal = temporal};
}

TEST_F(LargeScenesTest, CompleteCoverageFindsThePairsThatOverlapAndNoOthers) {
    Crowd crowd({{"armadillo"},
                 {"camel"},
                 {"turbine"},
                 {"bear_bis"},
                 {"fandisk"},
                 {"homer"},
                 {"dino"},
                 {"femur"},
                 {"knot2"},
                 {"retinal"},
                 {"anchor"},
                 {"spool"},
                 {"blobby"},
                 {"hand", 1, true},
                 {"elephant", 1, true},
                 {"cactus", 1, true},
                 {"rotor", 0.15, false, "bear_bis"},
                 {"hand", 0.1, false, "fandisk"},
                 {"pinion", 0.1, true, "bear_bis"}});
    std::vector<World> worlds;
    for (Temporal temporal : {Temporal::certified, Temporal::off})
        worlds.push_back(crowd.world(embree_backend(), complete(temporal)));
    run(crowd, worlds, 5);
    EXPECT_GT(seen["overlapping"], 800u);
    EXPECT_GT(seen["inside one another"], 10u);
    EXPECT_GT(seen["pairs of boxes"], seen["overlapping"] + 200);
}

TEST_F(LargeScenesTest, AlsoWhereTheyBarelyOverlap) {
    Crowd crowd({{"elephant"},
                 {"dino"},
                 {"knot2"},
                 {"anchor"},
                 {"fandisk"},
                 {"hand"},
                 {"cactus"},
                 {"rotor"}});
    std::vector<World> worlds;
    for (Temporal temporal : {Temporal::certified, Temporal::off})
        worlds.push_back(crowd.world(embree_backend(), complete(temporal)));
    for (int i = 0; i < 200; ++i) {
        const int a = random.integer(0, 7), b = (a + random.integer(1, 7)) % 8;
        const double width = std::pow(10, random.uniform(-5, -2));
        SCOPED_TRACE("pair " + std::to_string(i) + ", width " + std::to_string(width));
        for (double x :
             crowd.part(static_cast<std::size_t>(a), static_cast<std::size_t>(b), random, width)) {
            crowd.place(static_cast<std::size_t>(b), x);
            compare(crowd, worlds);
        }
    }
    EXPECT_EQ(seen["overlapping"], 200u);
    EXPECT_LT(seen["missed"], 10u) << "within the tolerance, by either of the two worlds";
    EXPECT_GT(seen["missed by vertices"], 30u);
}

TEST_F(LargeScenesTest, SoDoesTheReference) {
    Crowd crowd({{"anchor"},
                 {"spool"},
                 {"hand"},
                 {"helmet"},
                 {"cactus", 1, true},
                 {"rotor", 0.05, false, "anchor"}});
    std::vector<World> worlds;
    for (Temporal temporal : {Temporal::certified, Temporal::off})
        worlds.push_back(crowd.world(reference_backend(), complete(temporal)));
    run(crowd, worlds, 4);
    EXPECT_GT(seen["overlapping"], 50u);
    EXPECT_GT(seen["inside one another"], 0u);
}

}  // namespace
}  // namespace pierce
