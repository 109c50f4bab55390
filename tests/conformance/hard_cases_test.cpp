// The twenty-five hard cases with their exact answers, as they are and under changes that must not
// matter.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <optional>

#include "core/geometry/triangle.hpp"
#include "pierce/mesh_check.hpp"
#include "pierce/reference_backends.hpp"
#include "pierce/world.hpp"
#include "scenes/measure/ray_probe.hpp"
#include "scenes/named/hard_cases.hpp"
#include "scenes/named/shapes.hpp"
#include "support/backends.hpp"
#include "support/metamorphic.hpp"

namespace pierce {
namespace {

using scenes::HardBodies;
using scenes::HardCase;
using scenes::HardContacts;
using scenes::HardRay;
using scenes::Meets;
using test::Change;

constexpr double rounding = 0x1p-50;                          ///< of the numbers a ray is made of
constexpr double normal_rounding = 4 * constants::float_ulp;  ///< directions come from float32
                                                              ///< normals

struct Param {
    test::NamedBackend backend;
    HardCase hard;
};

void PrintTo(const Param& param, std::ostream* os) {
    *os << param.backend.name << " " << param.hard.name;
}

std::vector<Param> params(const std::function<bool(const HardCase&)>& wanted) {
    std::vector<Param> all;
    for (const test::NamedBackend& backend : test::backends())
        for (const HardCase& hard : scenes::hard_cases())
            if (wanted(hard)) all.push_back({backend, hard});
    return all;
}

std::string param_name(const testing::TestParamInfo<Param>& info) {
    const std::string number = std::to_string(info.param.hard.number);
    return info.param.backend.name + "_" + (number.size() < 2 ? "0" : "") + number + "_" +
           info.param.hard.name;
}

class HardRaysTest : public testing::TestWithParam<Param> {};

TEST_P(HardRaysTest, MeetWhatTheyMust) {
    scenes::RayProbe probe(GetParam().backend.make());
    for (const Change& change : test::changes())
        for (const HardRay& ray : GetParam().hard.rays) {
            Change by_vertices = change;
            by_vertices.by_pose = false;  // a ray's mesh has no pose
            const auto mesh = by_vertices.mesh(ray.mesh);
            if (!mesh) continue;
            const scenes::Met met = probe.meet(
                *mesh, change.point(ray.origin), change.direction(ray.direction),
                change.deforming ? Motion::deforming : Motion::fixed);
            const double size = std::max(change.scale * ray.t, length(change.offset));
            const bool is_near = ray.meets == Meets::exit &&
                                 change.scale * ray.t <=
                                     scenes::RayProbe::touch(*mesh, change.point(ray.origin));
            ASSERT_EQ(met.how, is_near ? Meets::touching : ray.meets) << change.name;
            ASSERT_NEAR(met.t, is_near ? 0.0 : change.scale * ray.t, rounding * size)
                << change.name;
        }
}

INSTANTIATE_TEST_SUITE_P(All, HardRaysTest, testing::ValuesIn(params([](const HardCase& c) {
                             return !c.rays.empty();
                         })),
                         param_name);

TEST(HardCasesTest, ASmallDepthUnderAHugeFaceIsExact) {
    const HardRay ray = scenes::hard_cases()[10].rays[1];
    ASSERT_EQ(ray.origin.z, -0x1p-10);
    const scenes::Met met = scenes::RayProbe(reference_backend())
                                .meet(ray.mesh, ray.origin, ray.direction);
    const Triangle& t = ray.mesh.triangles[met.triangle];
    const auto corner = [&](int k) { return to_double(ray.mesh.positions[t.vertex[k]]); };
    EXPECT_NEAR(cross_triangle({ray.origin, ray.direction}, corner(0), corner(1), corner(2)).t,
                0x1p-10, 0x1p-30)
        << "the triangle test itself does not lose it";
    EXPECT_EQ(met.how, scenes::Meets::exit);
    EXPECT_EQ(met.t, 0x1p-10);
}

TEST(HardCasesTest, ASmallBodyOnAHugeOneHasASmallTouchTolerance) {
    constexpr double depth = 0x1p-10;
    for (const test::NamedBackend& backend : test::backends())
        for (const Coverage coverage : {Coverage::vertices, Coverage::complete}) {
            World world(backend.make(), {.coverage = coverage, .reproject = false});
            const MeshId slab = world.add_mesh("slab",
                                               scenes::box({-1e6, -1e6, -8}, {1e6, 1e6, 0}));
            const MeshId box = world.add_mesh("box", scenes::box({-1, -1, 0}, {1, 1, 2}));
            world.add_fixed_body(slab);
            const BodyId small = world.add_rigid_body(box, {{3, 5, -depth}, {}});
            EXPECT_EQ(world.detect().touching_pairs, 1u) << backend.name;
            // The rays of the box's corners lie along its diagonals.
            EXPECT_NEAR(world.stats().penetration_max, std::sqrt(3.0) * depth, 1e-6 * depth)
                << backend.name;
            // Above the slab by as much, it touches nothing.
            world.set_pose(small, {{3, 5, depth}, {}});
            EXPECT_EQ(world.detect().contacts, 0u) << backend.name;
        }
}

class HardBodiesTest : public testing::TestWithParam<Param> {};

/// A contact as the unchanged scene would have it.
struct Seen {
    bool of_a = true;
    bool edge = false, separates = false;
    double distance = 0;
    Vec3d from, to;  ///< on the source and on the target
    Vec3d normal;    ///< from the first body to the second
};

/// Contacts of two bodies under a change, changed back.
struct Observed {
    std::vector<Seen> contacts;
    double deepest = 0;
    Vec3d push;
    double extent = 0;  ///< of the larger body
};

/// Two bodies under a change. Their poses may change on.
class Scene {
public:
    /// Nothing to observe if float32 would round a coordinate.
    Scene(const test::NamedBackend& backend, const HardBodies& bodies, const Change& change,
          const Settings& settings)
        : bodies_(bodies), world_(backend.make(), settings) {
        const std::optional<MeshData> first = change.mesh(bodies.a), second = change.mesh(bodies.b);
        exact_ = first && second;
        if (!exact_) return;
        const MeshId meshes[2] = {world_.add_mesh("first", *first),
                                  world_.add_mesh("second", *second)};
        for (int k : {change.swapped ? 1 : 0, change.swapped ? 0 : 1})
            body_[k] = change.deforming ? world_.add_deforming_body(meshes[k])
                                        : world_.add_rigid_body(meshes[k]);
    }

    bool exact() const { return exact_; }
    const std::vector<std::string>& notes() { return world_.plan().notes; }

    /// Their contacts under a change that differs from the scene's in its offset by pose at most.
    Observed observe(const Change& change) {
        if (!change.deforming)
            for (BodyId body : body_)
                world_.set_pose(body, {change.by_pose ? change.offset : Vec3d{}, {}});
        world_.detect();
        Observed observed;
        Vec3d sum;
        for (const Contact& c : world_.contacts()) {
            const bool first = c.source == Side::a;
            Seen seen;
            seen.of_a = first != change.swapped;
            seen.edge = c.is_edge();
            seen.separates = c.found == Found::separation;
            seen.distance = c.distance / change.scale;
            seen.from = change.point_back(first ? c.point_a : c.point_b);
            seen.to = change.point_back(first ? c.point_b : c.point_a);
            seen.normal = (change.swapped ? -1.0 : 1.0) * change.direction_back(c.normal);
            observed.contacts.push_back(seen);
            observed.deepest = std::max(observed.deepest, -seen.distance);
            sum += seen.distance * seen.normal;
        }
        observed.push = normalized(sum);
        for (const MeshData* data : {&bodies_.a, &bodies_.b}) {
            Box box;
            for (Vec3f p : data->positions) box.extend(to_double(p));
            observed.extent = std::max(box.extent(), observed.extent);
        }
        return observed;
    }

private:
    const HardBodies& bodies_;
    World world_;
    BodyId body_[2];
    bool exact_ = false;
};

void expect_answer(const Observed& observed, const HardContacts& answer) {
    const auto count = [&](bool of_a, bool edge) {
        return std::ranges::count_if(
            observed.contacts, [&](const Seen& s) { return s.of_a == of_a && s.edge == edge; });
    };
    ASSERT_EQ(!observed.contacts.empty(), answer.any());
    for (const Seen& s : observed.contacts) {
        ASSERT_EQ(s.separates, answer.separated);
        for (double number : {s.distance, dot(s.from, s.to), length(s.normal)})
            ASSERT_TRUE(std::isfinite(number));
        ASSERT_LE(s.distance, 0);
    }
    if (!answer.separated) {
        ASSERT_EQ(count(true, false), answer.vertices_a);
        ASSERT_EQ(count(false, false), answer.vertices_b);
        ASSERT_EQ(count(true, true), answer.edges_a);
        ASSERT_EQ(count(false, true), answer.edges_b);
    }
    const double tolerance = normal_rounding * observed.extent;
    if (answer.depth >= 0) {
        ASSERT_NEAR(observed.deepest, answer.depth, tolerance);
    }
    if (length_squared(answer.push) > 0 && answer.depth > 0) {
        ASSERT_LT(length(observed.push - answer.push), normal_rounding);
    }
}

/// The same contacts, whatever their order.
void expect_same(const Observed& changed, const Observed& plain) {
    const double tolerance = normal_rounding * plain.extent;
    ASSERT_NEAR(changed.deepest, plain.deepest, tolerance);
    // Which of many points stand for a separation depends on the vertices' order.
    if (!plain.contacts.empty() && plain.contacts[0].separates) return;
    ASSERT_EQ(changed.contacts.size(), plain.contacts.size());
    std::vector<bool> taken(changed.contacts.size());
    for (const Seen& s : plain.contacts) {
        const auto match = std::ranges::find_if(changed.contacts, [&](const Seen& c) {
            return !taken[static_cast<std::size_t>(&c - changed.contacts.data())] &&
                   c.of_a == s.of_a && c.edge == s.edge &&
                   std::abs(c.distance - s.distance) <= tolerance &&
                   length(c.from - s.from) <= tolerance && length(c.to - s.to) <= tolerance &&
                   length(c.normal - s.normal) <= normal_rounding;
        });
        ASSERT_NE(match, changed.contacts.end())
            << "none like that at (" << s.from.x << ", " << s.from.y << ", " << s.from.z
            << "), distance " << s.distance;
        taken[static_cast<std::size_t>(match - changed.contacts.begin())] = true;
    }
}

/// Powers of two change nothing but the exponent.
void expect_scaled_exactly(const Observed& changed, const Observed& plain) {
    ASSERT_EQ(changed.contacts.size(), plain.contacts.size());
    for (std::size_t i = 0; i < plain.contacts.size(); ++i) {
        ASSERT_EQ(changed.contacts[i].distance, plain.contacts[i].distance);
        ASSERT_EQ(changed.contacts[i].from, plain.contacts[i].from);
        ASSERT_EQ(changed.contacts[i].to, plain.contacts[i].to);
        ASSERT_EQ(changed.contacts[i].normal, plain.contacts[i].normal);
    }
}

TEST_P(HardBodiesTest, AreInContactAsTheyMust) {
    for (const HardBodies& bodies : GetParam().hard.bodies)
        for (Coverage coverage : {Coverage::vertices, Coverage::complete}) {
            SCOPED_TRACE(bodies.situation +
                         (coverage == Coverage::complete ? " complete" : " vertices"));
            const Settings settings{.coverage = coverage, .reproject = false};
            const HardContacts& answer = coverage == Coverage::complete ? bodies.complete
                                                                        : bodies.vertices;
            Scene unchanged(GetParam().backend, bodies, {}, settings);
            const Observed plain = unchanged.observe({});
            for (const Change& change : test::changes()) {
                SCOPED_TRACE(change.name);
                std::optional<Scene> own;
                if (!change.by_pose || change.shuffle_seed != 0)
                    own.emplace(GetParam().backend, bodies, change, settings);
                Scene& scene = own ? *own : unchanged;
                if (!scene.exact())
                    continue;  // rounded bodies have other answers; their poses go as far
                const Observed observed = scene.observe(change);
                expect_answer(observed, answer);
                expect_same(observed, plain);
                if (change.name.starts_with("scale")) expect_scaled_exactly(observed, plain);
                if (HasFatalFailure()) return;
            }
        }
}

TEST_P(HardBodiesTest, AreAsDeepByDefaultAsTheDefinitionSays) {
    for (const HardBodies& bodies : GetParam().hard.bodies) {
        if (bodies.by_default < 0) continue;
        const Observed observed = Scene(GetParam().backend, bodies, {}, Settings{}).observe({});
        EXPECT_NEAR(observed.deepest, bodies.by_default, normal_rounding * observed.extent);
    }
}

TEST_P(HardBodiesTest, OpenOnesAreNamedByThePlan) {
    for (const HardBodies& bodies : GetParam().hard.bodies) {
        Scene scene(GetParam().backend, bodies, {}, {});
        for (const auto& [name, data] :
             {std::pair{"'first': open", &bodies.a}, {"'second': open", &bodies.b}}) {
            const bool noted = std::ranges::any_of(scene.notes(), [&](const std::string& note) {
                return note.find(name) != std::string::npos;
            });
            EXPECT_EQ(noted, !Mesh("", *data).inside().exists());
        }
    }
}

INSTANTIATE_TEST_SUITE_P(All, HardBodiesTest, testing::ValuesIn(params([](const HardCase& c) {
                             return !c.bodies.empty();
                         })),
                         param_name);

TEST(HardMeshesTest, DefectsAreFound) {
    for (const HardCase& hard : scenes::hard_cases())
        for (const scenes::HardFinding& expected : hard.findings) {
            const MeshReport report = check_mesh(expected.mesh);
            const MeshFinding* found = report.find(expected.kind);
            EXPECT_EQ(found == nullptr ? 0 : found->count, expected.count)
                << hard.name << ": " << name(expected.kind);
        }
}

TEST(HardCasesTest, AreTwentyFiveAndEachIsAsked) {
    const std::vector<HardCase> cases = scenes::hard_cases();
    ASSERT_EQ(cases.size(), 25u);
    for (std::size_t i = 0; i < cases.size(); ++i) {
        EXPECT_EQ(cases[i].number, static_cast<int>(i) + 1);
        EXPECT_FALSE(cases[i].name.empty() || cases[i].answer.empty());
        EXPECT_FALSE(cases[i].rays.empty() && cases[i].bodies.empty());
    }
}

}  // namespace
}  // namespace pierce
