#pragma once

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <unordered_map>
#include <utility>
#include <vector>

#include "core/body/body_view.hpp"
#include "core/device/view.hpp"
#include "core/mesh/mesh_view.hpp"
#include "gpu_cuda/cuda_executor.cuh"

namespace pierce::cuda {

/// The arrays of bodies' meshes in device memory: one piece of memory per mesh, which another mesh
/// takes over when no body has the first any more.
class MeshMirror {
public:
    explicit MeshMirror(CudaExecutor& executor) : executor_(executor) {}

    /// False if copying the mesh of this body would move arrays that are on the device.
    bool can_add(const BodyView& body) const {
        const auto known = copies_.find(body.mesh_key);
        return known == copies_.end() || has_all(known->second, body.mesh);
    }

    /// Copies what is not on the device yet. Views of a mesh that gets more arrays are void: plans,
    /// and bodies of one plan, differ in which arrays they need.
    void add(const BodyView& body) {
        Copy& copy = copies_[body.mesh_key];
        if (!has_all(copy, body.mesh)) send(copy, body.mesh);
    }

    /// A body's mesh on the device.
    MeshView view_of(const BodyView& body) const {
        const Copy& copy = copies_.at(body.mesh_key);
        MeshView view;
        static_cast<MeshShape&>(view) = body.mesh;
        for_each_array(
            [](auto& seen, const auto& host, const auto& on_device) {
                if (host.size > 0) seen = on_device;
            },
            view, body.mesh, copy.on_device);
        return view;
    }

    /// To be called when nothing reads the meshes.
    void forget_unused(View<const BodyView> bodies) {
        std::unordered_map<std::uint64_t, bool> used;
        for (const BodyView& body : bodies) used[body.mesh_key] = true;
        for (auto copy = copies_.begin(); copy != copies_.end();) {
            if (used.contains(copy->first)) {
                ++copy;
                continue;
            }
            spare_.push_back(std::move(copy->second.memory));
            copy = copies_.erase(copy);
        }
        // Those that were kept longest fit least.
        if (spare_.size() > most_spare)
            spare_.erase(spare_.begin(), spare_.end() - static_cast<std::ptrdiff_t>(most_spare));
    }

    /// What was copied can be overwritten on the host: the device is done with it.
    void settle() { staged_ = 0; }

private:
    static constexpr std::size_t most_spare = 8;
    static constexpr std::size_t small_array = std::size_t{1} << 16;  ///< [bytes]
    static constexpr std::size_t piece = sizeof(uint4);  ///< alignment of every array [bytes]

    struct Copy {
        DeviceBuffer<uint4> memory;
        MeshArrays<ConstView> on_host, on_device;
    };

    static bool has_all(const Copy& copy, const MeshView& mesh) {
        bool has = true;
        for_each_array(
            [&](const auto& known, const auto& host) {
                has = has &&
                      (host.size == 0 || (known.data == host.data && known.size == host.size));
            },
            copy.on_host, mesh);
        return has;
    }

    /// Copies a mesh: small arrays with each other, large ones each for itself.
    void send(Copy& copy, const MeshView& mesh) {
        MeshArrays<ConstView> all = copy.on_host;
        for_each_array(
            [](auto& known, const auto& host) {
                if (host.size > 0) known = host;
            },
            all, mesh);
        std::size_t pieces = 0, small = 0;
        const auto place_arrays = [&](bool are_small, auto&& see) {
            for_each_array(
                [&](const auto& host, auto& on_device) {
                    const std::size_t bytes = host.size * sizeof(host.data[0]);
                    if (bytes == 0 || (bytes < small_array) != are_small) return;
                    see(host, on_device, pieces, bytes);
                    pieces += (bytes + piece - 1) / piece;
                },
                all, copy.on_device);
        };
        const auto skip = [](const auto&, auto&, std::size_t, std::size_t) {};
        place_arrays(true, skip);
        small = pieces;
        place_arrays(false, skip);

        copy.memory = memory_for(std::move(copy.memory), pieces);
        copy.on_host = all;
        uint4* const device = copy.memory.data();
        uint4* const staged = stage(small);
        pieces = 0;
        const auto put = [&](const auto& host, auto& on_device, std::size_t at) {
            using T = std::remove_cvref_t<decltype(host.data[0])>;
            on_device = {reinterpret_cast<const T*>(device + at), host.size};
        };
        place_arrays(true, [&](const auto& host, auto& on_device, std::size_t at, std::size_t n) {
            std::memcpy(staged + at, host.data, n);
            put(host, on_device, at);
        });
        executor_.copy(device, staged, small, cudaMemcpyHostToDevice);
        place_arrays(false, [&](const auto& host, auto& on_device, std::size_t at, std::size_t n) {
            executor_.copy(reinterpret_cast<std::byte*>(device + at),
                           reinterpret_cast<const std::byte*>(host.data), n,
                           cudaMemcpyHostToDevice);
            put(host, on_device, at);
        });
    }

    /// Memory of that many pieces, if possible memory that is there.
    DeviceBuffer<uint4> memory_for(DeviceBuffer<uint4> had, std::size_t pieces) {
        if (had.capacity() < pieces) {
            const auto fits = std::ranges::find_if(spare_, [&](const DeviceBuffer<uint4>& m) {
                return m.capacity() >= pieces && m.capacity() / 2 <= pieces;
            });
            had = {};
            if (fits != spare_.end()) {
                had = std::move(*fits);
                spare_.erase(fits);
            }
        }
        had.clear();
        had.resize(static_cast<std::uint32_t>(pieces));
        return had;
    }

    /// Host memory that the device copies from, not used before the next settle().
    uint4* stage(std::size_t pieces) {
        if (staged_ + pieces > stage_.capacity()) {
            executor_.wait();
            staged_ = 0;
        }
        uint4* const begin = stage_.resize(std::max(stage_.capacity(), pieces)) + staged_;
        staged_ += pieces;
        return begin;
    }

    CudaExecutor& executor_;
    std::unordered_map<std::uint64_t, Copy> copies_;  ///< by mesh key
    std::vector<DeviceBuffer<uint4>> spare_;
    StagingBuffer<uint4> stage_;
    std::size_t staged_ = 0;  ///< pieces of it that may still be read
};

}  // namespace pierce::cuda
