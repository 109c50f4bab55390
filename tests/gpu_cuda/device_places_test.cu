// Places and contacts in device memory, against a world whose places are set from the host.
#include <cuda_runtime.h>
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "gpu_cuda/device_buffer.hpp"
#include "pierce/contact_hash.hpp"
#include "pierce/cuda_backend.hpp"
#include "pierce/error.hpp"
#include "pierce/reference_backends.hpp"
#include "pierce/world.hpp"
#include "scenes/named/shapes.hpp"
#include "support/random.hpp"

namespace pierce {
namespace {

using cuda::check;

const MeshData ring = scenes::torus(1, 0.35, 20, 10);

template <class T>
void send(const std::vector<T>& from, T* to, cudaStream_t stream = nullptr) {
    check(cudaMemcpyAsync(to, from.data(), from.size() * sizeof(T), cudaMemcpyHostToDevice, stream),
          "a copy");
    check(cudaStreamSynchronize(stream), "a copy");
}

template <class T>
std::vector<T> receive(const T* from, std::size_t count) {
    std::vector<T> items(count);
    check(cudaMemcpy(items.data(), from, count * sizeof(T), cudaMemcpyDeviceToHost), "a copy");
    return items;
}

class DevicePlacesTest : public testing::Test {
protected:
    void SetUp() override {
        if (!cuda_problem().empty()) GTEST_SKIP() << cuda_problem();
    }
    test::Random random_{12};

    Pose near_origin() { return {random_.in_box(1), random_.rotation()}; }
    std::vector<Vec3f> placed(const Pose& pose) const {
        std::vector<Vec3f> positions;
        for (Vec3f p : ring.positions)
            positions.push_back(to_float(frame_of(pose).to_parent(to_double(p))));
        return positions;
    }
};

/// Worlds with the same bodies: one on the device, one on the host.
struct TwoWorlds {
    World there, here;
    std::vector<BodyId> bodies, same;

    explicit TwoWorlds(const Settings& settings = {})
        : there(cuda_backend(), settings), here(bvh_backend(), settings) {}
    void add(bool deforms, std::int32_t world = all_worlds) {
        for (World* w : {&there, &here}) {
            const MeshId mesh = w->add_mesh("ring", ring);
            const BodyId body = deforms ? w->add_deforming_body(mesh) : w->add_rigid_body(mesh);
            w->set_filter(body, {.world = world});
            (w == &there ? bodies : same).push_back(body);
        }
    }
    void expect_same() {
        there.detect();
        here.detect();
        EXPECT_EQ(contact_hash(there.contacts()), contact_hash(here.contacts()));
    }
};

TEST_F(DevicePlacesTest, PositionsThatChangeWithoutACall) {
    TwoWorlds worlds;
    for (int b = 0; b < 4; ++b) worlds.add(true);
    cuda::DeviceBuffer<Vec3f> device;
    device.resize(static_cast<std::uint32_t>(4 * ring.positions.size()));
    std::size_t contacts = 0;
    for (int step = 0; step < 12; ++step) {
        std::vector<Vec3f> all;
        for (const BodyId body : worlds.same) {
            const std::vector<Vec3f> positions = placed(near_origin());
            worlds.here.set_positions(body, positions);
            all.insert(all.end(), positions.begin(), positions.end());
        }
        send(all, device.data());
        if (step == 0) worlds.there.set_device_positions(worlds.bodies, device.data());
        worlds.expect_same();
        contacts += worlds.here.contacts().size();
    }
    EXPECT_GT(contacts, 500u);
}

template <class Real>
void expect_poses(TwoWorlds& worlds, test::Random& random) {
    cuda::DeviceBuffer<Real> device;
    device.resize(static_cast<std::uint32_t>(7 * worlds.bodies.size()));
    for (int step = 0; step < 12; ++step) {
        std::vector<Real> numbers;
        for (std::size_t b = 0; b < worlds.bodies.size(); ++b) {
            const Vec3d p = random.in_box(1);
            const Quaternion q = random.rotation();
            for (double x : {p.x, p.y, p.z, q.x, q.y, q.z, q.w})
                numbers.push_back(static_cast<Real>(x));
            // Now and then a pose that is none, for one body.
            if (step % 4 == 3 && b == 1) numbers.back() = static_cast<Real>(NAN);
        }
        worlds.here.set_poses(worlds.same, std::span<const Real>(numbers));
        send(numbers, device.data());
        if (step == 0) worlds.there.set_device_poses(worlds.bodies, std::as_const(device).data());
        worlds.expect_same();
    }
}

TEST_F(DevicePlacesTest, PosesInFloats) {
    TwoWorlds worlds;
    for (int b = 0; b < 5; ++b) worlds.add(false);
    expect_poses<float>(worlds, random_);
}

TEST_F(DevicePlacesTest, PosesInDoubles) {
    TwoWorlds worlds;
    for (int b = 0; b < 5; ++b) worlds.add(false);
    expect_poses<double>(worlds, random_);
    // Back on the host.
    const Pose pose = near_origin();
    worlds.there.set_pose(worlds.bodies[2], pose);
    worlds.here.set_pose(worlds.same[2], pose);
    worlds.expect_same();
}

TEST_F(DevicePlacesTest, SomeOfManyMove) {
    TwoWorlds worlds;
    for (int b = 0; b < 8; ++b) worlds.add(b % 3 != 0);
    for (int step = 0; step < 20; ++step) {
        for (std::size_t b = 0; b < worlds.bodies.size(); ++b) {
            if (step > 0 && random_.integer(0, 2) > 0) continue;
            const Pose pose = near_origin();
            for (World* w : {&worlds.there, &worlds.here}) {
                const BodyId body = (w == &worlds.there ? worlds.bodies : worlds.same)[b];
                if (w->motion_of(body) == Motion::deforming)
                    w->set_positions(body, placed(pose));
                else
                    w->set_pose(body, pose);
            }
        }
        worlds.expect_same();
    }
}

/// Waits a while, so that what follows on the stream is late.
__global__ void wait_for(long long cycles) {
    const long long begin = clock64();
    while (clock64() - begin < cycles) {
    }
}

TEST_F(DevicePlacesTest, AStreamIsWaitedForAndContactsAreReadOnIt) {
    TwoWorlds worlds;
    for (std::int32_t w = 0; w < 6; ++w) {
        worlds.add(true, w);
        worlds.add(true, w);
    }
    cudaStream_t stream = nullptr;
    check(cudaStreamCreateWithFlags(&stream, cudaStreamNonBlocking), "a stream");
    worlds.there.set_stream(stream);
    const std::size_t vertices = worlds.bodies.size() * ring.positions.size();
    cuda::DeviceBuffer<Vec3f> staged, device;
    staged.resize(static_cast<std::uint32_t>(vertices));
    device.resize(static_cast<std::uint32_t>(vertices));
    worlds.there.set_device_positions(worlds.bodies, device.data());
    for (int step = 0; step < 8; ++step) {
        std::vector<Vec3f> all;
        for (const BodyId body : worlds.same) {
            const std::vector<Vec3f> positions = placed(near_origin());
            worlds.here.set_positions(body, positions);
            all.insert(all.end(), positions.begin(), positions.end());
        }
        send(all, staged.data());
        wait_for<<<1, 1, 0, stream>>>(20'000'000);
        check(cudaMemcpyAsync(device.data(), staged.data(), vertices * sizeof(Vec3f),
                              cudaMemcpyDeviceToDevice, stream),
              "a copy");
        worlds.expect_same();

        const std::span<const Contact> expected = worlds.here.contacts();
        const DeviceContactList list = worlds.there.device_contacts().solids;
        check(cudaStreamSynchronize(stream), "the caller's stream");
        ASSERT_EQ(receive(list.count, 1)[0], expected.size());
        ASSERT_GE(list.room, expected.size());
        const auto records = receive(list.records, expected.size());
        EXPECT_EQ(contact_hash(records), contact_hash(expected));
        const auto body_a = receive(list.body_a, expected.size()),
                   body_b = receive(list.body_b, expected.size());
        const auto feature = receive(list.feature, expected.size());
        const auto distance = receive(list.distance, expected.size()),
                   point_b = receive(list.point_b, 3 * expected.size()),
                   normal = receive(list.normal, 3 * expected.size());
        for (std::size_t i = 0; i < expected.size(); ++i) {
            EXPECT_EQ(body_a[i], expected[i].a.index);
            EXPECT_EQ(body_b[i], expected[i].b.index);
            EXPECT_EQ(feature[i], expected[i].feature());
            EXPECT_EQ(distance[i], static_cast<float>(expected[i].distance));
            EXPECT_EQ(point_b[3 * i + 1], static_cast<float>(expected[i].point_b.y));
            EXPECT_EQ(normal[3 * i + 2], static_cast<float>(expected[i].normal.z));
        }
        EXPECT_EQ(receive(list.world_begins, 7), worlds.here.world_offsets().solids);
        EXPECT_EQ(worlds.there.device_contacts().sheets.records, nullptr);
    }
    worlds.there.set_stream(nullptr);
    check(cudaStreamDestroy(stream), "a stream");
}

TEST_F(DevicePlacesTest, RefusesWhatNeedsTheHost) {
    TwoWorlds worlds;
    worlds.add(true);
    worlds.add(false);
    cuda::DeviceBuffer<float> poses;
    poses.resize(7);
    EXPECT_THROW(worlds.there.set_device_poses(worlds.bodies, poses.data()), InputError)
        << "one deforms";
    EXPECT_THROW(worlds.there.device_contacts(), InputError) << "before the first step";
    send({0.f, 0.f, 0.f, 0.f, 0.f, 0.f, 1.f}, poses.data());
    const BodyId rigid = worlds.bodies[1];
    worlds.there.set_device_poses({&rigid, 1}, std::as_const(poses).data());
    worlds.there.detect();
    EXPECT_THROW(worlds.there.explain(rigid, worlds.bodies[0], 0), InputError);
    EXPECT_THROW(worlds.there.impacts(), InputError);
    EXPECT_EQ(worlds.there.vertex_position(rigid, 1), to_double(ring.positions[1]));
}

TEST(DevicePlacesOnTheHostTest, AreRefused) {
    World world(bvh_backend());
    const BodyId body = world.add_rigid_body(world.add_mesh("ring", ring));
    const float* none = nullptr;
    EXPECT_THROW(world.set_device_poses({&body, 1}, none), InputError);
    EXPECT_THROW(world.set_stream(nullptr), InputError);
    world.detect();
    EXPECT_THROW(world.device_contacts(), InputError);
}

}  // namespace
}  // namespace pierce
