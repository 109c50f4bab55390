// A world that several devices share, with places in the memory of each. Where there is one device,
// it takes both parts.
#include <cuda_runtime.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <span>
#include <thread>
#include <utility>
#include <vector>

#include "gpu_cuda/cuda_check.hpp"
#include "gpu_cuda/on_device.hpp"
#include "pierce/contact_hash.hpp"
#include "pierce/cuda_backend.hpp"
#include "pierce/device_contacts.hpp"
#include "pierce/error.hpp"
#include "pierce/reference_backends.hpp"
#include "pierce/world.hpp"
#include "scenes/named/shapes.hpp"
#include "support/random.hpp"

namespace pierce {
namespace {

using cuda::check;

const MeshData ring = scenes::torus(1, 0.35, 20, 10);

/// An array on a device.
template <class T>
class ArrayThere {
public:
    ArrayThere(int device, std::size_t count) {
        const cuda::OnDevice here(device);
        check(cudaMalloc(&data_, count * sizeof(T)), "an array");
    }
    ~ArrayThere() { cudaFree(data_); }
    void write(const std::vector<T>& from, cudaStream_t stream) {
        check(cudaMemcpyAsync(data_, from.data(), from.size() * sizeof(T), cudaMemcpyHostToDevice,
                              stream),
              "a copy");
    }
    const T* data() const { return data_; }

private:
    T* data_ = nullptr;
};

/// A stream of a device on which what is written is late.
class LateStream {
public:
    explicit LateStream(int device) {
        const cuda::OnDevice there(device);
        check(cudaStreamCreateWithFlags(&stream_, cudaStreamNonBlocking), "a stream");
    }
    ~LateStream() { cudaStreamDestroy(stream_); }
    cudaStream_t get() const { return stream_; }
    void be_late() {
        check(cudaLaunchHostFunc(
                  stream_, [](void*) { std::this_thread::sleep_for(std::chrono::milliseconds(3)); },
                  nullptr),
              "a delay");
    }

private:
    cudaStream_t stream_ = nullptr;
};

/// The contacts that all devices have, in the order of one world.
std::vector<Contact> contacts_of_devices(const World& world, std::uint32_t devices,
                                         cudaStream_t stream) {
    std::vector<Contact> all;
    for (std::uint32_t part = 0; part < devices; ++part) {
        const DeviceContactList list = world.device_contacts(part).solids;
        std::uint32_t count = 0;
        check(cudaMemcpyAsync(&count, list.count, sizeof count, cudaMemcpyDeviceToHost, stream),
              "a count");
        check(cudaStreamSynchronize(stream), "waiting");
        const std::size_t before = all.size();
        all.resize(before + count);
        check(cudaMemcpyAsync(all.data() + before, list.records, count * sizeof(Contact),
                              cudaMemcpyDeviceToHost, stream),
              "contacts");
        check(cudaStreamSynchronize(stream), "waiting");
    }
    std::ranges::stable_sort(all, {}, [](const Contact& c) { return std::pair(c.a, c.b); });
    return all;
}

/// Sanitizers of devices take minutes for a few steps.
int step_count(int wanted) {
    const char* const few = std::getenv("PIERCE_TEST_STEPS");
    return few == nullptr ? wanted : std::atoi(few);
}

class SeveralDevicesTest : public testing::TestWithParam<Coverage> {
protected:
    void SetUp() override {
        if (!cuda_problem().empty()) GTEST_SKIP() << cuda_problem();
        int count = 0;
        check(cudaGetDeviceCount(&count), "the number of devices");
        last_ = count - 1;
    }
    /// Bodies drift through the space of all of them, so that they change parts.
    Pose place(int body, int step) {
        const double t = 0.05 * step + body;
        return {{0.9 * body + std::sin(0.3 * t), 2 * std::sin(0.05 * step), 0.2 * (body % 3)},
                random_.rotation()};
    }
    std::vector<Vec3f> placed(const Pose& pose) const {
        std::vector<Vec3f> positions;
        for (Vec3f p : ring.positions)
            positions.push_back(to_float(frame_of(pose).to_parent(to_double(p))));
        return positions;
    }
    test::Random random_{29};
    int last_ = 0;
};

TEST_P(SeveralDevicesTest, FindWhatOneBackendFinds) {
    const Settings settings{.coverage = GetParam()};
    World there(cuda_backend({.devices = {0, last_, 0}}), settings), here(bvh_backend(), settings);
    constexpr int bodies = 24;
    std::vector<BodyId> rigid, soft, rigid_here, soft_here;
    for (World* w : {&there, &here}) {
        const MeshId mesh = w->add_mesh("ring", ring);
        for (int b = 0; b < bodies; ++b)
            (w == &there ? b % 2 ? rigid : soft
             : b % 2     ? rigid_here
                         : soft_here)
                .push_back(b % 2 ? w->add_rigid_body(mesh) : w->add_deforming_body(mesh));
    }
    // Which device has the places is not what decides who owns the bodies.
    const std::size_t half = soft.size() / 2, vertices = ring.positions.size();
    std::array<ArrayThere<Vec3f>, 2> positions{ArrayThere<Vec3f>(last_, half * vertices),
                                               ArrayThere<Vec3f>(0, half * vertices)};
    ArrayThere<double> poses(last_, 7 * rigid.size());
    std::size_t contacts = 0;
    LateStream stream(last_);
    there.set_stream(stream.get());
    EXPECT_THROW(there.device_contacts(3), InputError);
    const int steps = step_count(40);
    for (int step = 0; step < steps; ++step) {
        std::array<std::vector<Vec3f>, 2> moved;
        std::vector<double> numbers;
        for (int b = 0; b < bodies; ++b) {
            const Pose pose = place(b, step);
            if (b % 2) {
                for (double x : {pose.position.x, pose.position.y, pose.position.z, pose.rotation.x,
                                 pose.rotation.y, pose.rotation.z, pose.rotation.w})
                    numbers.push_back(x);
                here.set_pose(rigid_here[b / 2], pose);
            } else {
                const std::vector<Vec3f> all = placed(pose);
                here.set_positions(soft_here[b / 2], all);
                std::vector<Vec3f>& list = moved[static_cast<std::size_t>(b / 2) / half];
                list.insert(list.end(), all.begin(), all.end());
            }
        }
        stream.be_late();
        for (int k = 0; k < 2; ++k) positions[k].write(moved[k], stream.get());
        poses.write(numbers, stream.get());
        if (step == 0) {
            const std::span<const BodyId> all(soft);
            there.set_device_positions(all.first(half), positions[0].data());
            there.set_device_positions(all.subspan(half), positions[1].data());
            there.set_device_poses(rigid, poses.data());
        }
        there.detect();
        here.detect();
        EXPECT_EQ(contact_hash(contacts_of_devices(there, 3, stream.get())),
                  contact_hash(here.contacts()))
            << step;
        EXPECT_EQ(contact_hash(there.contacts()), contact_hash(here.contacts())) << step;
        contacts += here.contacts().size();
    }
    EXPECT_GT(contacts, 50u * static_cast<unsigned>(steps));
}

INSTANTIATE_TEST_SUITE_P(Coverages, SeveralDevicesTest,
                         testing::Values(Coverage::vertices, Coverage::complete));

TEST_P(SeveralDevicesTest, FindWhatOneBackendFindsForSheets) {
    const Settings settings{.coverage = GetParam()};
    World there(cuda_backend({.devices = {0, last_}}), settings), here(bvh_backend(), settings);
    constexpr int bodies = 10;
    const MeshData square = scenes::grid(1, 1, 7, 7);
    std::vector<BodyId> sheets, sheets_here;
    for (World* w : {&there, &here}) {
        const MeshId mesh = w->add_mesh("square", square);
        for (int b = 0; b < bodies; ++b) {
            const BodyId body = w->add_deforming_body(mesh);
            w->set_collision(body, {.self = SelfCollision::on, .sheet = true, .thickness = 0.03});
            (w == &there ? sheets : sheets_here).push_back(body);
        }
    }
    // Sheets in a row of steps, each half above the next one; they wave and go through each other.
    const auto placed = [&](int body, int step) {
        const double t = 0.1 * step;
        std::vector<Vec3f> positions;
        for (const Vec3f p : square.positions)
            positions.push_back(to_float(Vec3d{
                p.x + 0.6 * body + 3 * std::sin(t), p.y,
                0.1 * std::sin(3 * t + 2 * body) + 0.05 * std::sin(9.0 * p.x + t * (1 + body))}));
        return positions;
    };
    // The last device has all places, so that all those that the first one needs are far.
    const std::size_t vertices = square.positions.size();
    ArrayThere<Vec3f> starts(last_, bodies * vertices), ends(last_, bodies * vertices);
    LateStream stream(last_);
    there.set_stream(stream.get());
    std::size_t contacts = 0;
    const int steps = step_count(40);
    for (int step = 0; step < steps; ++step) {
        std::vector<Vec3f> before, after;
        for (int b = 0; b < bodies; ++b) {
            const std::vector<Vec3f> from = placed(b, step), to = placed(b, step + 1);
            before.insert(before.end(), from.begin(), from.end());
            after.insert(after.end(), to.begin(), to.end());
            here.set_motion(sheets_here[b], from, to);
        }
        stream.be_late();
        starts.write(before, stream.get());
        ends.write(after, stream.get());
        if (step == 0)
            for (std::size_t b = 0; b < sheets.size(); ++b)
                there.set_device_motion(sheets[b], starts.data() + b * vertices,
                                        ends.data() + b * vertices);
        there.detect();
        here.detect();
        EXPECT_EQ(contact_hash(there.contacts()), contact_hash(here.contacts())) << step;
        contacts += here.contacts().size();
    }
    EXPECT_GT(contacts, 100u * static_cast<unsigned>(steps));
}

TEST_P(SeveralDevicesTest, NamesADeviceThatIsNotThere) {
    EXPECT_THROW(cuda_backend({.devices = {0, 1000}}), InputError);
    EXPECT_THROW(cuda_backend({.devices = {-1}}), InputError);
}

}  // namespace
}  // namespace pierce
