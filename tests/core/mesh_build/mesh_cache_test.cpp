// What was measured of meshes, kept in files: found again, and not believed where it is damaged.
#include "core/mesh_build/mesh_cache.hpp"

#include <gtest/gtest.h>

#include <bit>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include "core/base/archive.hpp"
#include "core/mesh/mesh_view.hpp"
#include "pierce/error.hpp"
#include "scenes/named/shapes.hpp"
#include "support/random.hpp"

namespace pierce {
namespace {

namespace fs = std::filesystem;

class MeshCacheTest : public testing::Test {
protected:
    // Tests may run at the same time.
    MeshCacheTest()
        : folder_(fs::path(testing::TempDir()) /
                  (std::string("pierce_mesh_cache_") +
                   testing::UnitTest::GetInstance()->current_test_info()->name())) {
        fs::remove_all(folder_);
    }
    ~MeshCacheTest() override { fs::remove_all(folder_); }

    Mesh made() const { return Mesh("torus", data_, {.cache = folder_}); }
    fs::path file() const {
        const Mesh plain("torus", data_);
        return MeshCache(folder_).file_of(plain.view({}));
    }
    std::size_t files() const {
        return static_cast<std::size_t>(
            std::distance(fs::directory_iterator(folder_), fs::directory_iterator()));
    }
    static std::string content(const fs::path& file) {
        std::ifstream in(file, std::ios::binary);
        return {std::istreambuf_iterator<char>(in), {}};
    }
    static void write(const fs::path& file, const std::string& bytes) {
        std::ofstream(file, std::ios::binary) << bytes;
    }

    const fs::path folder_;
    const MeshData data_ = scenes::torus(1, 0.4, 20, 10);
};

/// Compares all arrays bit for bit.
void expect_same(const MeshView& mesh, const MeshView& other) {
    for_each_array(
        [](const auto& a, const auto& b) {
            ASSERT_EQ(a.size, b.size);
            if (a.size == 0) return;  // there is no address
            EXPECT_EQ(std::memcmp(a.data, b.data, a.size * sizeof *a.data), 0);
        },
        mesh, other);
    EXPECT_EQ(mesh.simple, other.simple);
    EXPECT_EQ(mesh.clearance_at.cell, other.clearance_at.cell);
    EXPECT_EQ(mesh.slabs_at.step, other.slabs_at.step);
}

TEST_F(MeshCacheTest, WhatWasMeasuredIsFoundAgain) {
    const Mesh plain("torus", data_);
    const Mesh first = made();
    first.view({});
    EXPECT_EQ(files(), 0u) << "nothing was measured";
    first.view({.rings = true});
    ASSERT_EQ(files(), 1u);
    const std::string few = content(file());
    const Mesh second = made();
    expect_same(second.view(), plain.view());
    ASSERT_EQ(files(), 1u) << "the same file";
    const std::string all = content(file());
    EXPECT_GT(all.size(), few.size());
    const Mesh third = made();
    expect_same(third.view(), plain.view());
    EXPECT_EQ(content(file()), all);
    const Mesh other("sphere", scenes::sphere(1, 2), {.cache = folder_});
    other.view();
    EXPECT_EQ(files(), 2u);
}

TEST_F(MeshCacheTest, DamagedFilesAreLeftAside) {
    const Mesh plain("torus", data_);
    made().view();
    const std::string good = content(file());
    test::Random random(9);
    for (int round = 0; round < 60; ++round) {
        std::string bad = good;
        switch (round % 3) {
            case 0:
                bad.resize(
                    static_cast<std::size_t>(random.integer(0, static_cast<int>(good.size()) - 1)));
                break;
            case 1:
                bad[static_cast<std::size_t>(
                    random.integer(0, static_cast<int>(good.size()) - 1))] ^= 1;
                break;
            default:
                bad += "more";
        }
        write(file(), bad);
        expect_same(made().view(), plain.view());
        EXPECT_EQ(content(file()), good) << "it was written again";
    }
    const std::filesystem::path name = file();
    // Longer than memory: it is not read, and does not fit on the disk either.
    std::filesystem::resize_file(name, std::uintmax_t{1} << 40);
    expect_same(made().view(), plain.view());
    EXPECT_EQ(content(name), good) << "it was written again";
    std::filesystem::remove(name);
    std::filesystem::create_directory(name);
    expect_same(made().view(), plain.view());
    EXPECT_TRUE(std::filesystem::is_directory(name));
}

/// Files with a right checksum whose content was made to do harm: nothing is read beyond an array.
TEST_F(MeshCacheTest, HostileFilesDoNoHarm) {
    made().view();
    const std::string good = content(file());
    constexpr std::size_t header = 20;
    test::Random random(10);
    for (int round = 0; round < 400; ++round) {
        std::string bad = good.substr(header);
        for (int k = random.integer(1, 4); k > 0; --k) {
            // Lengths and choices are at the front, indices of slabs at the end.
            const int last = static_cast<int>(bad.size()) - 1;
            const int at = round % 2 == 0 ? random.integer(0, 60) : random.integer(0, last);
            bad[static_cast<std::size_t>(at)] = static_cast<char>(random.integer(0, 255));
        }
        const std::uint64_t sum = checksum(bad);
        std::string front = good.substr(0, header);
        std::memcpy(front.data() + 12, &sum, sizeof sum);
        write(file(), front + bad);
        const Mesh mesh = made();
        const MeshView view = mesh.view();
        EXPECT_EQ(view.rings.size, view.triangles.size);
        EXPECT_EQ(view.star_clearance.size, view.positions.size);
        EXPECT_EQ(view.own_exit.size, view.positions.size);
        for (const SlabCell& cell : view.slab_cells) ASSERT_LT(cell.slab, view.slabs.size);
        const SlabGridView slabs = view.slabs_by_cell();
        for (int k = 0; k < 20; ++k) {
            view.clearance()(random.in_box(3));
            slabs.along(random.in_box(2), random.in_box(2));
        }
    }
}

TEST_F(MeshCacheTest, AFolderThatCannotBeIsNamed) {
    const fs::path file = fs::path(testing::TempDir()) / "pierce_no_folder";
    write(file, "a file");
    EXPECT_THROW(Mesh("torus", data_, {.cache = file / "below"}), InputError);
    EXPECT_THROW(Mesh("torus", data_, {.cache = folder_ / std::string(300, 'a')}), InputError);
    fs::remove(file);
}

/// If this fails because meshes are measured in another way, raise the version in mesh_cache.cpp,
/// so that files of older programs are left aside, and write the new number here.
TEST_F(MeshCacheTest, TheVersionChangesWithWhatIsMeasured) {
    const Mesh plain("box", scenes::box({0, 0, 0}, {1, 2, 3}));
    const MeshView view = plain.view();
    std::string bytes;
    const auto add = [&](const auto& array) {
        bytes.append(reinterpret_cast<const char*>(array.data), array.size * sizeof *array.data);
    };
    add(view.clearance_steps);
    add(view.rings);
    add(view.star_clearance);
    add(view.own_exit);
    add(view.slab_cells);
    add(view.slabs);
    EXPECT_EQ(checksum(bytes), 12432716233544501445u);
}

}  // namespace
}  // namespace pierce
