#include "pierce/c/device.h"

#include "c_api/arguments.hpp"
#include "c_api/border.hpp"
#include "c_api/contacts.hpp"
#include "c_api/versioned.hpp"
#include "c_api/world_state.hpp"

namespace pierce::c {
namespace {

pierce_device_contact_list list_of(const DeviceContactList& l) {
    return {.struct_size = sizeof(pierce_device_contact_list),
            .count = l.count,
            .records = record(l.records),
            .body_a = l.body_a,
            .body_b = l.body_b,
            .feature = l.feature,
            .distance = l.distance,
            .point_a = l.point_a,
            .point_b = l.point_b,
            .normal = l.normal,
            .world_begins = l.world_begins,
            .room = l.room,
            .stride = sizeof(Contact)};
}

const Vec3f* device_vectors(const float* numbers, const char* name) {
    return reinterpret_cast<const Vec3f*>(&required(numbers, name));
}

template <class T>
pierce_status set_poses(pierce_world* world, const pierce_body_id* bodies, std::size_t body_count,
                        const T* poses) {
    return guarded([&] {
        auto& inner = world_of(world);
        const auto handles = body_handles(bodies, body_count, "bodies");
        inner.set_device_poses(handles, &required(poses, "poses"));
    });
}

}  // namespace
}  // namespace pierce::c

using namespace pierce::c;

pierce_status pierce_set_device_positions(pierce_world* world, const pierce_body_id* bodies,
                                          size_t body_count, const float* positions) {
    return guarded([&] {
        auto& inner = world_of(world);
        const auto handles = body_handles(bodies, body_count, "bodies");
        inner.set_device_positions(handles, device_vectors(positions, "positions"));
    });
}

pierce_status pierce_set_device_motion(pierce_world* world, pierce_body_id body, const float* start,
                                       const float* positions) {
    return guarded([&] {
        auto& inner = world_of(world);
        inner.set_device_motion(body_handle(body), device_vectors(start, "start"),
                                device_vectors(positions, "positions"));
    });
}

pierce_status pierce_set_device_poses(pierce_world* world, const pierce_body_id* bodies,
                                      size_t body_count, const double* poses) {
    return set_poses(world, bodies, body_count, poses);
}

pierce_status pierce_set_device_poses_float(pierce_world* world, const pierce_body_id* bodies,
                                            size_t body_count, const float* poses) {
    return set_poses(world, bodies, body_count, poses);
}

pierce_status pierce_set_stream(pierce_world* world, void* stream) {
    return guarded([&] { world_of(world).set_stream(stream); });
}

pierce_status pierce_device_contacts(const pierce_world* world, uint32_t part,
                                     pierce_device_contact_list* solids,
                                     pierce_device_contact_list* sheets) {
    return guarded([&] {
        auto& inner = world_of(world);
        check_struct(solids, "solids");
        check_struct(sheets, "sheets");
        const pierce::DeviceContacts contacts = inner.device_contacts(part);
        write_struct(list_of(contacts.solids), solids);
        write_struct(list_of(contacts.sheets), sheets);
    });
}
