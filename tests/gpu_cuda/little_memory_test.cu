// Steps that run out of the device's memory.
#include <gtest/gtest.h>

#include <cuda_runtime.h>

#include <cstdint>
#include <stdexcept>
#include <string>
#include <vector>

#include "gpu_cuda/cuda_check.hpp"
#include "pierce/contact_hash.hpp"
#include "pierce/cuda_backend.hpp"
#include "pierce/reference_backends.hpp"
#include "pierce/world.hpp"
#include "scenes/named/shapes.hpp"
#include "support/random.hpp"

namespace pierce {
namespace {

using cuda::check;

/// The device's memory, of which no more can be had than a few megabytes.
class LittleMemory {
public:
    explicit LittleMemory(std::size_t bytes) {
        check(cudaDeviceGetMemPool(&before_, 0), "the device's memory pool");
        cudaMemPoolProps properties{};
        properties.allocType = cudaMemAllocationTypePinned;
        properties.location = {.type = cudaMemLocationTypeDevice, .id = 0};
        properties.maxSize = bytes;
        check(cudaMemPoolCreate(&pool_, &properties), "a memory pool");
        check(cudaDeviceSetMemPool(0, pool_), "the device's memory pool");
    }
    LittleMemory(const LittleMemory&) = delete;
    ~LittleMemory() {
        give_back();
        cudaMemPoolDestroy(pool_);
    }
    void give_back() const { cudaDeviceSetMemPool(0, before_); }
    void take() const { cudaDeviceSetMemPool(0, pool_); }

private:
    cudaMemPool_t before_ = nullptr, pool_ = nullptr;
};

TEST(CudaLittleMemoryTest, AStepThatRunsOutOfMemoryIsForgotten) {
    if (!cuda_problem().empty()) GTEST_SKIP() << cuda_problem();
    test::Random random(5);
    SCOPED_TRACE("seed " + std::to_string(random.seed()));
    const MeshData ring = scenes::torus(1, 0.4, 24, 16);
    int failed = 0;
    for (const bool deforms : {false, true})
        for (const std::size_t megabytes : {4, 8, 16, 24, 32, 64}) {
            World there(cuda_backend()), here(bvh_backend());
            constexpr int bodies = 24;
            std::vector<BodyId> ids[2];
            for (World* world : {&there, &here}) {
                const MeshId mesh = world->add_mesh("ring", ring);
                for (int b = 0; b < bodies; ++b)
                    ids[world == &here].push_back(deforms ? world->add_deforming_body(mesh)
                                                          : world->add_rigid_body(mesh));
            }
            const auto move = [&](double spread) {
                for (std::size_t b = 0; b < bodies; ++b) {
                    const Pose pose{random.in_box(spread), random.rotation()};
                    for (World* world : {&there, &here}) {
                        const BodyId body = ids[world == &here][b];
                        if (deforms)
                            world->set_positions(body, test::placed(ring, pose));
                        else
                            world->set_pose(body, pose);
                    }
                }
            };
            const auto step = [&] {
                there.detect();
                here.detect();
                ASSERT_EQ(contact_hash(there.contacts()), contact_hash(here.contacts()));
            };
            // Steps are captured by then; what follows needs more.
            for (int i = 0; i < 8; ++i) {
                move(20);
                step();
            }
            const LittleMemory little(megabytes << 20);
            for (int i = 0; i < 4; ++i) {
                move(1.5);
                little.take();
                try {
                    there.detect();
                } catch (const std::runtime_error& error) {
                    EXPECT_NE(std::string(error.what()).find("out of memory"), std::string::npos)
                        << error.what();
                    EXPECT_TRUE(there.contacts().empty());
                    ++failed;
                }
                little.give_back();
                if (i % 2 == 0) move(1.5);
                there.detect();
                here.detect();
                ASSERT_EQ(contact_hash(there.contacts()), contact_hash(here.contacts()))
                    << megabytes << " MB, step " << i;
            }
        }
    EXPECT_GT(failed, 5);
}

}  // namespace
}  // namespace pierce
