#include "pierce/backend.hpp"

#include "core/body/body_view.hpp"
#include "core/device/view.hpp"
#include "core/mesh/mesh_view.hpp"
#include "pierce/device_contacts.hpp"
#include "pierce/error.hpp"

namespace pierce {

void Backend::set_stream(void*) { throw InputError("this backend has no streams"); }
DeviceContacts Backend::device_contacts(std::uint32_t) {
    throw InputError("this backend has no contacts in device memory");
}
void Backend::fetch_bodies(View<BodyView>) const {}
void Backend::fetch_seen(View<const BodyId>, View<const View<SeenPatch>>) const {}

}  // namespace pierce
