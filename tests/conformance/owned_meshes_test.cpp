// Meshes that people own, and damaged ones: every backend finds the same contacts in them, whatever
// decides what is inside. Meshes are those of Debian's libcgal-demo.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "core/mesh/half_edges.hpp"
#include "pierce/contact_hash.hpp"
#include "pierce/error.hpp"
#include "pierce/mesh_check.hpp"
#include "pierce/reference_backends.hpp"
#include "pierce/world.hpp"
#include "scenes/files/mesh_io.hpp"
#include "support/backends.hpp"
#include "support/random.hpp"

namespace pierce {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t few_triangles = 400;  ///< that the reference can look at

/// A mesh and a copy of it, which is turned and moved by a part of its size and may deform.
std::vector<std::uint64_t> hashes(const MeshData& mesh, std::unique_ptr<Backend> backend,
                                  const Settings& settings, Inside inside, bool deforms) {
    Box box;
    for (Vec3f p : mesh.positions) box.extend(to_double(p));
    World world(std::move(backend), settings);
    const MeshId id = world.add_mesh("mesh", mesh, {.inside = inside});
    world.add_rigid_body(id);
    const Pose pose{0.15 * (box.upper - box.lower), {0.1, 0.2, 0.3, 0.9}};
    const BodyId other = deforms ? world.add_deforming_body(id, test::placed(mesh, pose))
                                 : world.add_rigid_body(id, pose);
    std::vector<std::uint64_t> result;
    for (int step = 0; step < 2; ++step) {
        world.detect();
        result.push_back(contact_hash(world.contacts()));
        const Pose next{pose.position + 0.01 * (box.upper - box.lower), pose.rotation};
        if (deforms)
            world.set_positions(other, test::placed(mesh, next));
        else
            world.set_pose(other, next);
    }
    return result;
}

/// Fails unless all backends find the same contacts.
void expect_same_on_all_backends(const MeshData& mesh, Inside inside, bool deforms,
                                 const std::string& what) {
    for (const Coverage coverage : {Coverage::vertices, Coverage::overlaps, Coverage::complete}) {
        Settings settings;
        settings.coverage = coverage;
        std::vector<std::uint64_t> expected;
        for (const test::NamedBackend& backend : test::backends()) {
            const bool is_slow = backend.name == "reference" || backend.name == "shuffled" ||
                                 backend.name == "parallel";
            if (is_slow && mesh.triangles.size() > few_triangles) continue;
            const std::vector<std::uint64_t> found = hashes(mesh, backend.make(), settings, inside,
                                                            deforms);
            if (expected.empty()) expected = found;
            EXPECT_EQ(found, expected)
                << what << ", coverage " << static_cast<int>(coverage) << ", " << backend.name;
        }
    }
}

TEST(OwnedMeshesTest, AllBackendsFindTheSameContacts) {
    if (!fs::exists(PIERCE_MESH_FOLDER)) GTEST_SKIP() << "libcgal-demo is not installed";
    std::vector<fs::path> files;
    for (const fs::directory_entry& entry : fs::directory_iterator(PIERCE_MESH_FOLDER))
        files.push_back(entry.path());
    std::ranges::sort(files);
    int read = 0, by_winding = 0, none = 0;
    for (const fs::path& file : files) {
        MeshData mesh;
        try {
            mesh = scenes::read_mesh(file);
            const Mesh made(file.filename().string(), mesh);
            by_winding += made.inside().rule == Inside::winding;
            none += !made.inside().exists();
            EXPECT_EQ(check_mesh(mesh).inside.rule, made.inside().rule) << file;
        } catch (const InputError&) {
            continue;
        }
        ++read;
        if (mesh.triangles.size() > 6000) continue;
        expect_same_on_all_backends(mesh, Inside::automatic, read % 2 == 0,
                                    file.filename().string());
    }
    EXPECT_GT(read, 80);
    EXPECT_GT(by_winding, 8);
    EXPECT_GT(none, 20);
}

TEST(OwnedMeshesTest, AllBackendsFindTheSameContactsOfDamagedMeshes) {
    int closed = 0;
    for (std::uint32_t seed = 0; seed < 200; ++seed) {
        test::Random random(seed);
        MeshData mesh = test::random_closed_mesh(random);
        const double share = random.uniform(0.005, 0.1);
        std::erase_if(mesh.triangles,
                      [&](const Triangle&) { return random.uniform(0, 1) < share; });
        for (Triangle& t : mesh.triangles)
            if (random.uniform(0, 1) < share) std::swap(t.vertex[1], t.vertex[2]);
        if (seed % 4 == 0) mesh.triangles.push_back(mesh.triangles.front());
        if (mesh.triangles.size() > few_triangles) continue;
        const Mesh made("damaged", mesh, {.inside = Inside::winding});
        closed += made.inside().exists();
        // Every edge of the surface is balanced.
        bool balanced = true;
        HalfEdges(made.triangles(), made.positions().size()).for_each_edge([&](auto sides) {
            balanced = balanced && is_balanced(sides);
        });
        EXPECT_EQ(balanced, made.inside().exists()) << "seed " << seed;
        if (seed % 5 != 0) continue;
        expect_same_on_all_backends(mesh, Inside::winding, seed % 2 == 0,
                                    "seed " + std::to_string(seed));
    }
    EXPECT_GT(closed, 150);
}

TEST(OwnedMeshesTest, AllBackendsFindTheSameContactsOfOverlappingParts) {
    for (std::uint32_t seed = 0; seed < 24; ++seed) {
        test::Random random(seed);
        const MeshData mesh = test::random_overlapping_parts(random);
        if (mesh.triangles.size() > 2 * few_triangles) continue;
        expect_same_on_all_backends(mesh, Inside::automatic, seed % 2 == 0,
                                    "seed " + std::to_string(seed));
    }
}

}  // namespace
}  // namespace pierce
