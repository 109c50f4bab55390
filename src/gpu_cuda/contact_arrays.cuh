#pragma once

#include <cstdint>

#include "core/body/body_view.hpp"
#include "core/device/partition_point.hpp"
#include "core/device/view.hpp"
#include "gpu_cuda/cuda_executor.cuh"
#include "gpu_cuda/device_buffer.hpp"
#include "pierce/contact.hpp"
#include "pierce/device_contacts.hpp"
#include "pierce/min_max.hpp"

namespace pierce::cuda {

/// One thread: writes how many there are.
struct WriteNumber {
    Number number;
    std::uint32_t* to = nullptr;

    PIERCE_HD void operator()(std::uint32_t) const { *to = number; }
};

/// Per contact: writes its part of the arrays.
struct FillContactArrays {
    const Contact* contacts = nullptr;
    std::uint32_t *body_a = nullptr, *body_b = nullptr;
    std::uint64_t* feature = nullptr;
    float *distance = nullptr, *point_a = nullptr, *point_b = nullptr, *normal = nullptr;

    PIERCE_HD void operator()(std::uint32_t i) const {
        const Contact& c = contacts[i];
        body_a[i] = c.a.index;
        body_b[i] = c.b.index;
        feature[i] = c.feature();
        distance[i] = static_cast<float>(c.distance);
        for (int k = 0; k < 3; ++k) {
            point_a[3 * i + k] = static_cast<float>(c.point_a[k]);
            point_b[3 * i + k] = static_cast<float>(c.point_b[k]);
            normal[3 * i + k] = static_cast<float>(c.normal[k]);
        }
    }
};

/// Per place of a world, and one beyond: finds where its contacts begin, which are sorted by world.
struct FindWorldBegin {
    const Contact* contacts = nullptr;
    Number count;
    View<const BodyView> bodies;
    std::uint32_t* begins = nullptr;

    PIERCE_HD void operator()(std::uint32_t place) const {
        begins[place] = partition_point(count, [&](std::uint32_t i) {
            const Contact& c = contacts[i];
            return min_of(bodies[c.a.index].world_place, bodies[c.b.index].world_place) < place;
        });
    }
};

/// A list of contacts as callers see it in device memory.
class ContactArrays {
public:
    DeviceContactList fill(CudaExecutor& executor, const DeviceBuffer<Contact>& contacts,
                           View<const BodyView> bodies, std::uint32_t worlds) {
        const DeviceCount count = executor.in_last_step(contacts.count());
        const std::uint32_t room = count.bound();
        count_.resize(1);
        executor.for_each(1, WriteNumber{count, count_.data()});
        for (DeviceBuffer<std::uint32_t>* ids : {&body_a_, &body_b_}) ids->resize(room);
        for (DeviceBuffer<float>* vectors : {&point_a_, &point_b_, &normal_})
            vectors->resize(3 * room);
        feature_.resize(room);
        distance_.resize(room);
        executor.for_each(count, FillContactArrays{.contacts = contacts.data(),
                                                   .body_a = body_a_.data(),
                                                   .body_b = body_b_.data(),
                                                   .feature = feature_.data(),
                                                   .distance = distance_.data(),
                                                   .point_a = point_a_.data(),
                                                   .point_b = point_b_.data(),
                                                   .normal = normal_.data()});
        if (worlds > 0) {
            begins_.resize(worlds + 1);
            executor.for_each(worlds + 1, FindWorldBegin{.contacts = contacts.data(),
                                                         .count = count,
                                                         .bodies = bodies,
                                                         .begins = begins_.data()});
        }
        return {.count = count_.data(),
                .room = room,
                .records = contacts.data(),
                .body_a = body_a_.data(),
                .body_b = body_b_.data(),
                .feature = feature_.data(),
                .distance = distance_.data(),
                .point_a = point_a_.data(),
                .point_b = point_b_.data(),
                .normal = normal_.data(),
                .world_begins = worlds > 0 ? begins_.data() : nullptr};
    }

private:
    DeviceBuffer<std::uint32_t> count_, body_a_, body_b_, begins_;
    DeviceBuffer<std::uint64_t> feature_;
    DeviceBuffer<float> distance_, point_a_, point_b_, normal_;
};

}  // namespace pierce::cuda
