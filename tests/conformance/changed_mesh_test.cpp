// Meshes that are damaged, and meshes that change while steps go on: bodies whose mesh is cut, torn
// or mended have the contacts that a new world with a new mesh would find.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <map>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "pierce/contact_hash.hpp"
#include "pierce/reference_backends.hpp"
#include "pierce/world.hpp"
#include "scenes/named/shapes.hpp"
#include "support/backends.hpp"
#include "support/random.hpp"

namespace pierce {
namespace {

class ChangedMeshTest : public testing::TestWithParam<test::NamedBackend> {};

std::uint64_t hash_of(const World& world) { return contact_hash(world.contacts()); }

/// A few changes of a mesh, as cutting, tearing and mending make them. Vertices keep their numbers.
MeshData changed(MeshData mesh, test::Random& random) {
    const auto any = [&](std::size_t count) {
        return static_cast<std::size_t>(random.integer(0, static_cast<int>(count) - 1));
    };
    for (int change = random.integer(1, 3); change > 0; --change) {
        const std::size_t t = any(mesh.triangles.size());
        switch (random.integer(0, 3)) {
            case 0:  // a triangle goes
                mesh.triangles.erase(mesh.triangles.begin() + static_cast<std::ptrdiff_t>(t));
                break;
            case 1:  // a triangle is turned around
                std::swap(mesh.triangles[t].vertex[0], mesh.triangles[t].vertex[1]);
                break;
            case 2: {  // a triangle gets a vertex in its middle
                Vec3d middle;
                for (std::uint32_t v : mesh.triangles[t].vertex)
                    middle += (1.0 / 3) * to_double(mesh.positions[v]);
                const auto v = static_cast<std::uint32_t>(mesh.positions.size());
                mesh.positions.push_back(to_float(middle));
                const auto [a, b, c] = std::to_array(mesh.triangles[t].vertex);
                mesh.triangles[t] = {{a, b, v}};
                mesh.triangles.push_back({{b, c, v}});
                mesh.triangles.push_back({{c, a, v}});
                break;
            }
            default: {  // a vertex is torn off from one of its triangles
                const auto v = static_cast<std::uint32_t>(mesh.positions.size());
                std::uint32_t& corner = mesh.triangles[t].vertex[random.integer(0, 2)];
                mesh.positions.push_back(mesh.positions[corner]);
                mesh.positions.back().x += 0.01f;
                corner = v;
            }
        }
    }
    return mesh;
}

TEST_P(ChangedMeshTest, ContactsAreThoseOfANewWorldWithNewMeshes) {
    std::size_t contacts = 0, solid = 0, changes = 0;
    for (int scene = 0; scene < 6; ++scene) {
        test::Random random(static_cast<std::uint32_t>(scene) + 31);
        SCOPED_TRACE("scene " + std::to_string(scene));
        Settings settings;
        if (scene % 3 == 1) settings.coverage = Coverage::complete;
        if (scene % 3 == 2) {
            settings.coverage = Coverage::vertices;
            settings.reproject = false;
        }
        World world(GetParam().make(), settings);
        struct Body {
            MeshData data;
            MeshId mesh;
            BodyId id;
            bool deforms;
            Pose pose;
        };
        std::vector<Body> bodies;
        for (int b = 0; b < 4; ++b) {
            Body body{test::random_closed_mesh(random), {}, {}, b % 2 == 0, {}};
            body.mesh = world.add_mesh("mesh " + std::to_string(b), body.data);
            body.pose = {0.6 * random.in_box(1), random.rotation()};
            body.id = body.deforms
                          ? world.add_deforming_body(body.mesh, test::placed(body.data, body.pose))
                          : world.add_rigid_body(body.mesh, body.pose);
            bodies.push_back(body);
        }
        for (int step = 0; step < 8; ++step) {
            for (Body& body : bodies) {
                body.pose.position += 0.03 * random.in_box(1);
                if (random.integer(0, 2) == 0) {
                    body.data = changed(body.data, random);
                    const MeshId before = body.mesh;
                    body.mesh = world.add_mesh("changed", body.data, before);
                    if (body.deforms)
                        world.set_mesh(body.id, body.mesh, test::placed(body.data, body.pose));
                    else
                        world.set_mesh(body.id, body.mesh);
                    world.remove_mesh(before);
                    ++changes;
                }
                if (body.deforms)
                    world.set_positions(body.id, test::placed(body.data, body.pose));
                else
                    world.set_pose(body.id, body.pose);
            }
            world.detect();

            Settings plain = settings;
            plain.temporal = Temporal::off;
            World fresh(reference_backend(), plain);
            for (const Body& body : bodies) {
                const MeshId mesh = fresh.add_mesh("fresh", body.data);
                solid += fresh.mesh(mesh).inside().rule == Inside::winding;
                if (body.deforms)
                    fresh.add_deforming_body(mesh, test::placed(body.data, body.pose));
                else
                    fresh.add_rigid_body(mesh, body.pose);
            }
            fresh.detect();
            ASSERT_EQ(hash_of(world), hash_of(fresh))
                << "step " << step << ": " << world.contacts().size() << " contacts and "
                << fresh.contacts().size();
            contacts += world.contacts().size();
        }
    }
    EXPECT_GT(contacts, 2000u);
    EXPECT_GT(solid, 60u);
    EXPECT_GT(changes, 40u);
}

// Most bodies stay as they are, so that backends keep what they have of them. Some share a mesh
// until they change, some take the mesh of another body, and some grow without end.
TEST_P(ChangedMeshTest, AFewOfManyBodiesChange) {
    std::size_t contacts = 0;
    for (std::uint32_t scene = 0; scene < 2; ++scene) {
        test::Random random(scene + 7);
        SCOPED_TRACE("scene " + std::to_string(scene));
        Settings settings;
        settings.coverage = scene % 2 == 0 ? Coverage::overlaps : Coverage::complete;
        World world(GetParam().make(), settings);
        struct Body {
            MeshData data;
            MeshId mesh;
            BodyId id;
            Pose pose;
        };
        std::vector<Body> bodies;
        const auto is_deforming = [](std::size_t b) { return b % 2 == 0; };
        const MeshData shared = scenes::sphere(0.5, 1);
        const MeshId shared_mesh = world.add_mesh("shared", shared);
        const auto positions = [&](std::size_t b) {
            return test::placed(bodies[b].data, bodies[b].pose);
        };
        for (std::size_t b = 0; b < 14; ++b) {
            bodies.push_back(
                {shared, shared_mesh, {}, {1.5 * random.in_box(1), random.rotation()}});
            bodies[b].id = is_deforming(b) ? world.add_deforming_body(shared_mesh, positions(b))
                                           : world.add_rigid_body(shared_mesh, bodies[b].pose);
        }
        for (int step = 0; step < 16; ++step) {
            // The first bodies change most, and grow out of their places.
            for (int change = random.integer(0, 2); change > 0; --change) {
                const auto b = static_cast<std::size_t>(
                    random.integer(0, random.integer(0, 1) == 0 ? 2 : 13));
                const auto other = static_cast<std::size_t>(random.integer(0, 13));
                Body& body = bodies[b];
                if (random.integer(0, 4) == 0) {
                    body.data = bodies[other].data;
                    body.mesh = bodies[other].mesh;
                } else {
                    for (int more = 8; more > 0; --more) body.data = changed(body.data, random);
                    body.mesh = world.add_mesh("changed", body.data, body.mesh);
                }
                if (is_deforming(b))
                    world.set_mesh(body.id, body.mesh, positions(b));
                else
                    world.set_mesh(body.id, body.mesh);
            }
            for (std::size_t b = 0; b < bodies.size(); ++b) {
                bodies[b].pose.position += 0.03 * random.in_box(1);
                if (is_deforming(b))
                    world.set_positions(bodies[b].id, positions(b));
                else
                    world.set_pose(bodies[b].id, bodies[b].pose);
            }
            world.detect();

            Settings plain = settings;
            plain.temporal = Temporal::off;
            World fresh(bvh_backend(), plain);
            for (std::size_t b = 0; b < bodies.size(); ++b) {
                const MeshId mesh = fresh.add_mesh("fresh", bodies[b].data);
                if (is_deforming(b))
                    fresh.add_deforming_body(mesh, positions(b));
                else
                    fresh.add_rigid_body(mesh, bodies[b].pose);
            }
            fresh.detect();
            ASSERT_EQ(hash_of(world), hash_of(fresh))
                << "step " << step << ": " << world.contacts().size() << " contacts and "
                << fresh.contacts().size();
            contacts += world.contacts().size();
        }
    }
    EXPECT_GT(contacts, 1500u);
}

// Steps of sheets alone place them once for a plan. After steps without a change, some get more
// vertices, and some another filter, which asks for a new plan, too.
TEST_P(ChangedMeshTest, AFewOfManySheetsChange) {
    constexpr double thickness = 0.05;
    test::Random random(12);
    World world(GetParam().make(), {});
    struct Sheet {
        MeshData data;
        MeshId mesh;
        BodyId id;
        Filter filter;
        std::vector<Vec3f> positions;
    };
    std::vector<Sheet> sheets(8);
    const Collision collision{.sheet = true, .thickness = thickness};
    for (std::size_t k = 0; k < sheets.size(); ++k) {
        Sheet& sheet = sheets[k];
        sheet.data = scenes::grid(1, 1, 6, 6);
        for (Vec3f& p : sheet.data.positions)
            p = to_float(to_double(p) + Vec3d{0, 0, thickness * (0.9 * static_cast<double>(k))} +
                         0.2 * thickness * random.in_box(1));
        sheet.mesh = world.add_mesh("sheet", sheet.data);
        sheet.id = world.add_deforming_body(sheet.mesh, sheet.data.positions);
        world.set_collision(sheet.id, collision);
    }
    std::size_t contacts = 0;
    for (int step = 0; step < 30; ++step) {
        // A backend captures its steps after some without a change.
        if (step % 10 > 5) {
            Sheet& sheet = sheets[static_cast<std::size_t>(random.integer(0, 7))];
            if (random.integer(0, 2) == 0) {
                sheet.filter.chain = static_cast<std::uint32_t>(random.integer(0, 20));
                world.set_filter(sheet.id, sheet.filter);
            } else {
                const std::size_t before = sheet.data.positions.size();
                while (sheet.data.positions.size() == before)
                    sheet.data = changed(sheet.data, random);
                sheet.mesh = world.add_mesh("changed", sheet.data, sheet.mesh);
                world.set_mesh(sheet.id, sheet.mesh, sheet.data.positions);
            }
        }
        for (Sheet& sheet : sheets) {
            sheet.positions = sheet.data.positions;
            for (Vec3f& p : sheet.positions)
                p = to_float(to_double(p) + 0.01 * thickness * random.in_box(1));
            world.set_motion(sheet.id, sheet.positions, sheet.positions);
        }
        world.forget_sides();
        world.detect();

        World fresh(bvh_backend(), {});
        for (const Sheet& sheet : sheets) {
            const BodyId body = fresh.add_deforming_body(fresh.add_mesh("fresh", sheet.data),
                                                         sheet.positions);
            fresh.set_collision(body, collision);
            fresh.set_filter(body, sheet.filter);
        }
        fresh.detect();
        ASSERT_EQ(hash_of(world), hash_of(fresh))
            << "step " << step << ": " << world.contacts().size() << " contacts and "
            << fresh.contacts().size();
        contacts += world.contacts().size();
    }
    EXPECT_GT(contacts, 3000u);
}

TEST_P(ChangedMeshTest, PairsWithoutTheBodyRememberWhatTheyKnew) {
    World world(GetParam().make());
    const MeshData ball = scenes::sphere(1, 2);
    MeshId mesh = world.add_mesh("ball", ball);
    std::vector<BodyId> bodies;
    for (const double x : {0.0, 1.5, 10.0, 11.5})
        bodies.push_back(world.add_rigid_body(mesh, {{x, 0, 0}, {}}));
    test::Random random(2);
    MeshData data = ball;
    for (std::uint32_t step = 0; step < 5; ++step) {
        world.detect();
        std::size_t kept = 0, changed_pair = 0;
        for (const Contact& c : world.contacts()) {
            const bool keeps = c.a == bodies[0];
            (keeps ? kept : changed_pair) += 1;
            EXPECT_EQ(c.age, keeps ? step : 0u) << "step " << step;
        }
        EXPECT_GT(kept, 0u);
        EXPECT_GT(changed_pair, 0u);
        data = changed(data, random);
        mesh = world.add_mesh("changed", data, mesh);
        world.set_mesh(bodies[3], mesh);
    }
}

// Steps need more of a rigid body's mesh than of a deforming one's.
TEST_P(ChangedMeshTest, BodiesThatMoveDifferentlyGetTheSameNewMesh) {
    const MeshData ball = scenes::sphere(1, 2);
    const std::uint32_t bodies = 16;
    const auto place = [](std::uint32_t b) { return Pose{{1.5 * b, 0, 0}, {}}; };
    const auto deforms = [](std::uint32_t b) { return b % 2 == 0; };
    const auto add = [&](World& world, MeshId mesh, const MeshData& data, std::uint32_t b) {
        return deforms(b) ? world.add_deforming_body(mesh, test::placed(data, place(b)))
                          : world.add_rigid_body(mesh, place(b));
    };
    World world(GetParam().make());
    std::vector<MeshData> shapes(bodies, ball);
    std::vector<BodyId> ids;
    const MeshId first = world.add_mesh("ball", ball);
    for (std::uint32_t b = 0; b < bodies; ++b) ids.push_back(add(world, first, ball, b));
    world.detect();
    for (std::uint32_t step = 0; step < 8; ++step) {
        MeshData data = ball;
        for (Vec3f& p : data.positions) p.x *= 1 - 0.02f * static_cast<float>(step + 1);
        const MeshId mesh = world.add_mesh("another", data);
        // The deforming one comes first, or the rigid one.
        for (const std::uint32_t b : {step + 3, step + 4}) {
            shapes[b] = data;
            if (deforms(b))
                world.set_mesh(ids[b], mesh, test::placed(data, place(b)));
            else
                world.set_mesh(ids[b], mesh);
        }
        world.detect();
        World fresh(bvh_backend());
        for (std::uint32_t b = 0; b < bodies; ++b)
            add(fresh, fresh.add_mesh("fresh", shapes[b]), shapes[b], b);
        fresh.detect();
        EXPECT_FALSE(world.contacts().empty());
        EXPECT_EQ(hash_of(world), hash_of(fresh)) << "step " << step;
    }
}

/// The share of the triangles that are gone or turned.
MeshData damaged(MeshData mesh, double share, bool turned, test::Random& random) {
    if (turned) {
        for (Triangle& t : mesh.triangles)
            if (random.uniform(0, 1) < share) std::swap(t.vertex[0], t.vertex[1]);
        return mesh;
    }
    std::erase_if(mesh.triangles, [&](const Triangle&) { return random.uniform(0, 1) < share; });
    return mesh;
}

TEST_P(ChangedMeshTest, DamagedMeshesHaveNearlyTheContactsOfWholeOnes) {
    const MeshData torus = scenes::torus(1, 0.4, 40, 20), ball = scenes::sphere(0.5, 3);
    for (const bool turned : {false, true})
        for (const double share : {0.01, 0.03, 0.1}) {
            test::Random random(5);
            SCOPED_TRACE(std::to_string(share) + (turned ? " turned" : " gone"));
            const MeshData torn = damaged(torus, share, turned, random);
            const auto detect = [&](const MeshData& mesh, Inside inside,
                                    std::unique_ptr<Backend> backend) {
                World world(std::move(backend), {});
                const MeshId target = world.add_mesh("torus", mesh, {.inside = inside});
                world.add_rigid_body(target);
                const MeshId source = world.add_mesh("ball", ball);
                world.add_rigid_body(source, {{1, 0.2, 0.3}, {}});
                world.add_deforming_body(source, test::placed(ball, {{-1, 0.2, 0.3}, {}}));
                world.detect();
                return world;
            };
            const World whole = detect(torus, Inside::automatic, GetParam().make()),
                        nearly = detect(torn, Inside::winding, GetParam().make()),
                        reference = detect(torn, Inside::winding, reference_backend()),
                        open = detect(torn, Inside::closed, GetParam().make());
            EXPECT_EQ(hash_of(nearly), hash_of(reference));
            // Vertices of the balls in the torus: the tear changes few of them.
            const auto inside = [](const World& world) {
                std::vector<std::pair<BodyId, std::uint32_t>> vertices;
                for (const Contact& c : world.contacts())
                    if (c.source == Side::b && !c.is_edge()) vertices.emplace_back(c.b, c.vertex);
                return vertices;
            };
            const auto all = inside(whole), now = inside(nearly);
            std::vector<std::pair<BodyId, std::uint32_t>> both;
            std::ranges::set_intersection(all, now, std::back_inserter(both));
            EXPECT_GT(all.size(), 100u);
            EXPECT_GE(both.size(), 0.98 * static_cast<double>(all.size()));
            EXPECT_LE(now.size(), 1.02 * static_cast<double>(all.size()));
            EXPECT_TRUE(inside(open).empty()) << "no inside, no contacts in it";
            if (turned) {
                EXPECT_EQ(both, all);
            }
        }
}

INSTANTIATE_TEST_SUITE_P(Backends, ChangedMeshTest, testing::ValuesIn(test::backends()),
                         test::backend_name);

}  // namespace
}  // namespace pierce
