// Meshes made of closed parts that overlap are one solid: the union of the parts, by the winding
// number.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <limits>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "core/geometry/closest_point.hpp"
#include "pierce/contact_hash.hpp"
#include "pierce/world.hpp"
#include "scenes/named/shapes.hpp"
#include "support/backends.hpp"
#include "support/brute_force.hpp"
#include "support/random.hpp"
#include "support/welded.hpp"

namespace pierce {
namespace {

using test::NamedBackend;

class OverlappingPartsTest : public testing::TestWithParam<NamedBackend> {};

MeshData joined(const MeshData& one, const MeshData& other, Vec3d by = {}) {
    MeshData all = one;
    const auto first = static_cast<std::uint32_t>(one.positions.size());
    for (Vec3f p : other.positions) all.positions.push_back(to_float(to_double(p) + by));
    for (const Triangle& t : other.triangles)
        all.triangles.push_back({{first + t.vertex[0], first + t.vertex[1], first + t.vertex[2]}});
    return all;
}

MeshData turned_inside_out(MeshData mesh) {
    for (Triangle& t : mesh.triangles) std::swap(t.vertex[1], t.vertex[2]);
    return mesh;
}

std::uint32_t covered(const MeshData& mesh, Inside inside = Inside::automatic) {
    return Mesh("parts", mesh, {.inside = inside}).inside().covered_triangles;
}

double distance_to_surface(Vec3d p, const MeshData& mesh, const Frame& frame) {
    double least = std::numeric_limits<double>::infinity();
    const auto at = [&](std::uint32_t v) { return frame.to_parent(to_double(mesh.positions[v])); };
    for (const Triangle& t : mesh.triangles)
        least = std::min(least, length(p - closest_on_triangle(p, at(t.vertex[0]), at(t.vertex[1]),
                                                               at(t.vertex[2]))));
    return least;
}

/// A box whose sides are `n` by `n` squares.
MeshData fine_box(Vec3f lower, Vec3f upper, int n) {
    MeshData mesh;
    for (int axis = 0; axis < 3; ++axis)
        for (const bool high : {false, true}) {
            const auto first = static_cast<std::uint32_t>(mesh.positions.size());
            const int u = (axis + 1) % 3, v = (axis + 2) % 3;
            for (int i = 0; i <= n; ++i)
                for (int j = 0; j <= n; ++j) {
                    Vec3f p;
                    const auto between = [&](int k, int step) {
                        const float part = static_cast<float>(step) / static_cast<float>(n);
                        return step == n ? upper[k] : lower[k] + part * (upper[k] - lower[k]);
                    };
                    p[axis] = high ? upper[axis] : lower[axis];
                    p[u] = between(u, i);
                    p[v] = between(v, j);
                    mesh.positions.push_back(p);
                }
            const auto at = [&](int i, int j) {
                return first + static_cast<std::uint32_t>(i * (n + 1) + j);
            };
            for (int i = 0; i < n; ++i)
                for (int j = 0; j < n; ++j) {
                    Triangle one{{at(i, j), at(i + 1, j), at(i + 1, j + 1)}},
                        other{{at(i, j), at(i + 1, j + 1), at(i, j + 1)}};
                    if (!high)
                        for (Triangle* t : {&one, &other}) std::swap(t->vertex[1], t->vertex[2]);
                    mesh.triangles.push_back(one);
                    mesh.triangles.push_back(other);
                }
        }
    return test::welded(std::move(mesh));
}

// Faces of two parts that lie in one plane and face the same way are the surface of the union.
TEST_P(OverlappingPartsTest, FlushPartsHaveTheContactsOfOneBox) {
    test::Random random(9);
    SCOPED_TRACE("PIERCE_TEST_SEED=" + std::to_string(random.seed()));
    for (int i = 0; i < 48; ++i) {
        const int n = 1 << random.integer(0, 3);
        const bool is_in_twice = i % 4 == 0;
        const Vec3f one = {1, 1, 1}, from = {is_in_twice ? 0.0f : 0.5f, 0, 0},
                    to = {is_in_twice ? 1.0f : 1.5f, 1, 1};
        MeshData two = joined(fine_box({0, 0, 0}, one, n), fine_box(from, to, n)),
                 whole = fine_box({0, 0, 0}, to, 1);
        const Frame turn = frame_of({random.in_box(1), random.rotation()});
        for (MeshData* mesh : {&two, &whole})
            for (Vec3f& p : mesh->positions) p = to_float(turn.to_parent(to_double(p)));
        const double height = i % 2 == 0 ? 0.05 : -0.19;
        const Pose place{turn.to_parent({random.uniform(0.4, 0.6) * static_cast<double>(to.x), 0.5,
                                         1 + height + 0.2}),
                         random.rotation()};
        const auto contacts_of = [&](const MeshData& target) {
            World world(GetParam().make(), {.coverage = Coverage::vertices, .margin = 0.1});
            const MeshId id = world.add_mesh("target", target);
            if (i % 3 == 0)
                world.add_deforming_body(id);
            else
                world.add_fixed_body(id);
            world.add_rigid_body(world.add_mesh("ball", scenes::sphere(0.2, 2)), place);
            world.detect();
            std::vector<Contact> of_ball;
            std::ranges::copy_if(world.contacts(), std::back_inserter(of_ball),
                                 [](const auto& c) { return !c.is_edge() && c.source == Side::b; });
            return of_ball;
        };
        const std::vector<Contact> parts = contacts_of(two), box = contacts_of(whole);
        ASSERT_GT(box.size(), 3u) << i;
        ASSERT_EQ(parts.size(), box.size()) << i << " n " << n;
        for (std::size_t k = 0; k < box.size(); ++k) {
            EXPECT_EQ(parts[k].vertex, box[k].vertex) << i;
            EXPECT_NEAR(parts[k].distance, box[k].distance, 1e-5) << i << " n " << n;
            EXPECT_NEAR(length(parts[k].normal - box[k].normal), 0, 1e-3) << i << " n " << n;
        }
    }
}

// A bar lies through a cube; a box is near both.
TEST_P(OverlappingPartsTest, RidgesWithinTheUnionAreNearNothing) {
    const MeshData cube = scenes::box({-1, -1, -1}, {1, 1, 1}),
                   bar = scenes::box({-2, -0.2f, -0.2f}, {2, 0.2f, 0.2f});
    const auto is_in = [](Vec3d p, double x, double other) {
        return std::fabs(p.x) < x - 1e-3 && std::fabs(p.y) < other - 1e-3 &&
               std::fabs(p.z) < other - 1e-3;
    };
    test::Random random(31);
    SCOPED_TRACE("PIERCE_TEST_SEED=" + std::to_string(random.seed()));
    int near = 0, near_parts = 0;
    for (int i = 0; i < 200; ++i) {
        const Vec3d at{random.uniform(-2.2, 2.2), random.uniform(-1.3, 1.3),
                       random.uniform(-1.3, 1.3)};
        const Pose pose{at, random.rotation()};
        const auto edges_of = [&](const std::vector<MeshData>& targets) {
            World world(GetParam().make(), {.margin = 0.3});
            world.add_rigid_body(
                world.add_mesh("probe", scenes::box({-0.3f, -0.3f, -0.3f}, {0.3f, 0.3f, 0.3f})),
                pose);
            for (const MeshData& target : targets)
                world.add_fixed_body(world.add_mesh("target", target));
            world.detect();
            std::vector<Contact> found;
            std::ranges::copy_if(world.contacts(), std::back_inserter(found), [](const Contact& c) {
                return c.is_edge() && c.found == Found::near && c.distance >= 0;
            });
            return found;
        };
        // Those of the union are those of its parts that begin and end outside of the other part.
        std::size_t expected = 0;
        for (const Contact& c : edges_of({cube, bar})) {
            const bool of_cube = c.b.index == 1;
            const auto is_within = [&](Vec3d p) {
                return of_cube ? is_in(p, 2, 0.2) : is_in(p, 1, 1);
            };
            ++near_parts;
            expected += !is_within(c.point_a) && !is_within(c.point_b);
        }
        const std::size_t found = edges_of({joined(cube, bar)}).size();
        EXPECT_EQ(found, expected) << i;
        near += static_cast<int>(found);
    }
    EXPECT_GT(near, 10);
    EXPECT_GT(near_parts, near + 10);
}

TEST_P(OverlappingPartsTest, ASheetBecomesASolidWithoutMoving) {
    const MeshData two = joined(scenes::box({-1, -1, -1}, {1, 1, 1}),
                                scenes::box({-1, -1, -1}, {1, 1, 1}), {1, 0.3f, 0.2f});
    const MeshData spike = {{{0, 0, 0}, {0.4f, 0, 2}, {-0.2f, 0.35f, 2}, {-0.2f, -0.35f, 2}},
                            {{{0, 2, 1}}, {{0, 3, 2}}, {{0, 1, 3}}, {{1, 2, 3}}}};
    const auto hash_after = [&](bool as_sheet) {
        World world(GetParam().make());
        const BodyId body = world.add_deforming_body(world.add_mesh("two", two));
        world.add_rigid_body(world.add_mesh("spike", spike), {{0.5, 0.1, 0.5}, {}});
        if (as_sheet) {
            world.set_collision(body, {.sheet = true});
            world.detect();
            // A tree is made.
            const Vec3d along[] = {{1, 0.1, 0.05}};
            world.cast_rays({-3, 0.1, 0.05}, along);
            world.set_collision(body, {});
        }
        world.detect();
        return contact_hash(world.contacts());
    };
    EXPECT_EQ(hash_after(true), hash_after(false));
}

TEST(CoveredTrianglesTest, OnlyWhatLiesInOtherPartsIsCovered) {
    const MeshData box = scenes::box({-1, -1, -1}, {1, 1, 1});
    const MeshData small = scenes::box({-0.5, -0.5, -0.5}, {0.5, 0.5, 0.5});
    EXPECT_EQ(covered(box), 0u);
    EXPECT_EQ(covered(joined(box, box, {3, 0, 0})), 0u) << "apart";
    EXPECT_EQ(covered(joined(box, small)), 12u) << "one in the other";
    EXPECT_EQ(covered(joined(box, turned_inside_out(small))), 0u) << "a cavity";
    EXPECT_EQ(covered(joined(box, box, {2, 0, 0})), 4u) << "a common face: a wall";
    EXPECT_EQ(covered(joined(box, small, {1.5, 0, 0})), 4u) << "the face of one on the other's";
    EXPECT_EQ(covered(joined(box, small, {1, 0.1, 0.2})), 12u - 2 + 2) << "half in the other";
    EXPECT_EQ(covered(joined(box, small), Inside::closed), 0u) << "not asked for";
    EXPECT_EQ(covered(joined(box, small), Inside::none), 0u);
}

/// Two boxes side by side along x with common vertices, and with or without the two walls between
/// them.
MeshData two_rooms(bool with_walls) {
    MeshData both = test::welded(
        joined(scenes::box({-2, -1, -1}, {0, 1, 1}), scenes::box({0, -1, -1}, {2, 1, 1})));
    if (!with_walls)
        std::erase_if(both.triangles, [&](const Triangle& t) {
            return std::ranges::all_of(t.vertex,
                                       [&](std::uint32_t v) { return both.positions[v].x == 0; });
        });
    return both;
}

TEST(CoveredTrianglesTest, WallsWithinAreAndFlapsOutsideAreNot) {
    EXPECT_EQ(covered(two_rooms(true)), 4u);
    EXPECT_EQ(covered(two_rooms(false)), 0u);
    MeshData with_flap = scenes::box({-1, -1, -1}, {1, 1, 1});
    const auto first = static_cast<std::uint32_t>(with_flap.positions.size());
    for (Vec3f p : {Vec3f{1, 0, 0}, Vec3f{3, 0, 0}, Vec3f{1, 0, 0.5f}})
        with_flap.positions.push_back(p);
    with_flap.triangles.push_back({{first, first + 1, first + 2}});
    with_flap.triangles.push_back({{first, first + 2, first + 1}});
    EXPECT_EQ(covered(with_flap), 0u);
}

TEST_P(OverlappingPartsTest, ContactsDoNotEndAtWallsWithin) {
    const auto contacts_of = [&](bool with_walls) {
        World world(GetParam().make());
        world.add_rigid_body(world.add_mesh("rooms", two_rooms(with_walls)));
        world.add_rigid_body(
            world.add_mesh("small", scenes::box({-0.25, -0.25, -0.25}, {0.25, 0.25, 0.25})),
            {{0.1, 0.1, 0.9}, {}});
        world.detect();
        // The walls have edges, which go through the other body.
        std::vector<Contact> of_vertices;
        std::ranges::copy_if(world.contacts(), std::back_inserter(of_vertices),
                             [](const Contact& c) { return !c.is_edge(); });
        return of_vertices;
    };
    const std::vector<Contact> with = contacts_of(true), without = contacts_of(false);
    ASSERT_EQ(without.size(), 4u);
    ASSERT_EQ(with.size(), without.size());
    for (std::size_t i = 0; i < with.size(); ++i) {
        EXPECT_EQ(with[i].vertex, without[i].vertex);
        EXPECT_EQ(with[i].penetration_depth(), without[i].penetration_depth());
        EXPECT_EQ(with[i].point_a, without[i].point_a);
    }
}

TEST_P(OverlappingPartsTest, AVertexOnAWallThatIsPartlyWithinIsAsDeepAsTheUnion) {
    const MeshData target = joined(fine_box({0, 0, 0}, {4, 4, 4}, 1),
                                   fine_box({2, 1, 1}, {6, 5, 3}, 1));
    for (const double margin : {0.0, 0.1})
        for (const float from : {1.5f, 1.999f, 2.0f, 2.001f}) {
            SCOPED_TRACE("from " + std::to_string(from) + ", margin " + std::to_string(margin));
            World world(GetParam().make(), {.margin = margin});
            world.add_fixed_body(world.add_mesh("two", target));
            world.add_rigid_body(
                world.add_mesh("small", fine_box({0, 0, 0}, {0.5f, 0.5f, 0.5f}, 1)),
                {{static_cast<double>(from), 1.5, 1.5}, {}});
            world.detect();
            std::vector<int> seen(8, 0);
            for (const Contact& c : world.contacts()) {
                EXPECT_EQ(c.source, Side::b);
                EXPECT_GE(c.penetration_depth(), 1.5 - 1e-6) << "vertex " << c.vertex;
                if (!c.is_edge()) ++seen[c.vertex];
            }
            EXPECT_EQ(std::ranges::count(seen, 1), 8);
        }
}

TEST_P(OverlappingPartsTest, VerticesAreInContactWhereTheUnionIs) {
    std::size_t contacts = 0, by_rays = 0;
    for (std::uint32_t seed = 1; seed <= 16; ++seed) {
        test::Random random(seed);
        const MeshData target = test::random_overlapping_parts(random);
        const MeshData source = test::random_closed_mesh(random);
        const Pose pose{random.in_box(0.8), random.rotation()};
        for (const bool reproject : {true, false}) {
            SCOPED_TRACE("seed " + std::to_string(random.seed()) + (reproject ? "" : ", rays"));
            Settings settings;
            settings.coverage = Coverage::vertices;
            settings.reproject = reproject;
            World world(GetParam().make(), settings);
            const BodyId a = world.add_rigid_body(world.add_mesh("parts", target));
            world.add_rigid_body(world.add_mesh("source", source), pose);
            world.detect();

            const test::Solid solid = test::solid_of(target, {});
            const Frame frame = frame_of(pose);
            const double eps = 1e-5;
            std::vector<bool> is_in_contact(source.positions.size(), false);
            for (const Contact& c : world.contacts()) {
                if (c.source != Side::b || c.is_edge()) continue;
                is_in_contact[c.vertex] = true;
                EXPECT_EQ(c.a, a);
                if (c.penetration_depth() < eps || c.grazing) continue;
                ++contacts;
                by_rays += reproject && !c.reprojected;
                // `normal` points from a to b, and b goes that way to leave a.
                EXPECT_TRUE(test::is_inside(test::exact(c.point_a - eps * c.normal), solid))
                    << "vertex " << c.vertex << ": not inside right before the end";
                // In a vertex or an edge of the surface, the outside may lie to the side.
                bool is_out = !test::is_inside(test::exact(c.point_a + eps * c.normal), solid);
                for (int k = 0; k < 200 && c.reprojected && !is_out; ++k)
                    is_out = !test::is_inside(test::exact(c.point_a + eps * random.unit_vector()),
                                              solid);
                EXPECT_TRUE(is_out) << "vertex " << c.vertex << ": it ends in another part";
            }
            if (!reproject) continue;
            for (std::uint32_t v = 0; v < source.positions.size(); ++v) {
                const Vec3d p = frame.to_parent(to_double(source.positions[v]));
                if (distance_to_surface(p, target, {}) < eps) continue;
                EXPECT_EQ(is_in_contact[v], test::is_inside(test::exact(p), solid))
                    << "vertex " << v;
            }
        }
    }
    EXPECT_GT(contacts, 500u);
    EXPECT_GT(by_rays, 0u);
}

TEST_P(OverlappingPartsTest, EdgesAreInContactWhereTheUnionIs) {
    // A thin blade through both of two boxes that overlap: no vertex of either body is inside.
    const MeshData box = scenes::box({-1, -1, -1}, {1, 1, 1});
    const MeshData target = joined(box, box, {1.5, 0.1, 0.2});
    const MeshData blade = scenes::box({-4, -0.01, 0.85}, {5, 0.01, 0.9});
    for (const Coverage coverage : {Coverage::overlaps, Coverage::complete}) {
        Settings settings;
        settings.coverage = coverage;
        World world(GetParam().make(), settings);
        world.add_rigid_body(world.add_mesh("parts", target));
        world.add_rigid_body(world.add_mesh("blade", blade));
        world.detect();
        std::vector<std::uint32_t> edges;
        for (const Contact& c : world.contacts()) {
            EXPECT_TRUE(c.is_edge());
            if (c.source == Side::b) edges.push_back(c.edge);
        }
        // Each of the four long edges, and the diagonals between them, is in the union once.
        std::ranges::sort(edges);
        EXPECT_GE(edges.size(), 4u);
        EXPECT_EQ(std::ranges::adjacent_find(edges), edges.end());
    }
}

/// A tetrahedron whose first two vertices are `one` and `other`, and the same with these two in the
/// other order.
std::array<MeshData, 2> numbered_both_ways(Vec3f one, Vec3f other, Vec3f third, Vec3f fourth) {
    MeshData mesh{{one, other, third, fourth},
                  {{{0, 2, 1}}, {{0, 1, 3}}, {{1, 2, 3}}, {{0, 3, 2}}}};
    if (!(dot(cross(other - one, third - one), fourth - one) > 0))
        mesh = turned_inside_out(std::move(mesh));
    MeshData swapped = mesh;
    std::swap(swapped.positions[0], swapped.positions[1]);
    return {mesh, turned_inside_out(std::move(swapped))};
}

/// The depths of contacts, in ascending order.
std::vector<double> depths(const World& world) {
    std::vector<double> depths;
    for (const Contact& c : world.contacts()) depths.push_back(c.penetration_depth());
    std::ranges::sort(depths);
    return depths;
}

TEST_P(OverlappingPartsTest, EdgesAreTheSameFromEitherEnd) {
    const MeshData one = scenes::box({0, 0, 0}, {2, 2, 1}),
                   two = joined(one, scenes::box({1, 0.5f, -0.5f}, {3, 1.5f, 1.5f}));
    struct Case {
        const char* what;
        const MeshData& target;
        std::array<MeshData, 2> source;
    };
    const Case cases[] = {
        {"an end in one part, through the other", two,
         numbered_both_ways({0.5f, 1, 0.95f}, {4, 1, 1.2f}, {0.3f, 0.8f, 3}, {0.3f, 1.2f, 3})},
        {"an end on the surface of one part, through both", two,
         numbered_both_ways({0.5f, 1, 1}, {4, 1, 0.2f}, {0.3f, 0.8f, 3}, {0.3f, 1.2f, 3})},
        {"an end on the surface", one,
         numbered_both_ways({1, 1, 1}, {4, 1, -0.5f}, {1.2f, 1.8f, 0.999f}, {4, 0.8f, 2})}};
    for (const Case& c : cases)
        for (const Coverage coverage : {Coverage::overlaps, Coverage::complete}) {
            SCOPED_TRACE(testing::Message() << c.what << ", " << static_cast<int>(coverage));
            std::vector<double> found[2];
            for (std::size_t k = 0; k < 2; ++k) {
                World world(GetParam().make(), {.coverage = coverage});
                world.add_fixed_body(world.add_mesh("target", c.target));
                world.add_rigid_body(world.add_mesh("source", c.source[k]));
                world.detect();
                found[k] = depths(world);
            }
            ASSERT_EQ(found[0].size(), found[1].size());
            EXPECT_GT(found[0].size(), 0u);
            for (std::size_t i = 0; i < found[0].size(); ++i)
                EXPECT_NEAR(found[0][i], found[1][i], 1e-9);
        }
}

TEST_P(OverlappingPartsTest, ASavedWorldUnitesThem) {
    const MeshData box = scenes::box({-1, -1, -1}, {1, 1, 1});
    World world(GetParam().make());
    world.add_rigid_body(world.add_mesh("parts", joined(box, box, {1, 0.5, 0.5})));
    const BodyId small = world.add_rigid_body(
        world.add_mesh("small", scenes::box({-0.1, -0.1, -0.1}, {0.1, 0.1, 0.1})),
        {{0.75, 0.5, 0.5}, {}});
    world.detect();
    std::stringstream file;
    world.save(file);
    World restored = World::restore(file, GetParam().make());
    for (World* w : {&world, &restored}) w->set_pose(small, {{0.75, 0.6, 0.5}, {}});
    world.detect();
    restored.detect();
    EXPECT_GT(world.contacts().size(), 7u);
    EXPECT_EQ(contact_hash(world.contacts()), contact_hash(restored.contacts()));
}

TEST_P(OverlappingPartsTest, ThePlanSaysThatPartsAreUnited) {
    const MeshData box = scenes::box({-1, -1, -1}, {1, 1, 1});
    World world(GetParam().make());
    world.add_rigid_body(world.add_mesh("parts", joined(box, box, {1, 0.5, 0.5})));
    world.detect();
    EXPECT_TRUE(std::ranges::any_of(world.plan().notes, [](const std::string& note) {
        return note.find("count as one solid") != std::string::npos;
    }));
}

INSTANTIATE_TEST_SUITE_P(Backends, OverlappingPartsTest, testing::ValuesIn(test::backends()),
                         test::backend_name);

}  // namespace
}  // namespace pierce
