#include "pierce/backend.hpp"

#include <memory>
#include <vector>

#include "core/body/body_view.hpp"
#include "core/body/fetched_place.hpp"
#include "core/device/view.hpp"
#include "core/mesh/mesh_view.hpp"
#include "pierce/box.hpp"
#include "pierce/contact.hpp"
#include "pierce/device_contacts.hpp"
#include "pierce/error.hpp"
#include "pierce/plan.hpp"

namespace pierce {

std::vector<PlannedPart> Backend::parts() const { return {}; }
void Backend::set_stream(void*) { throw InputError("this backend has no streams"); }
DeviceContacts Backend::device_contacts(std::uint32_t, std::uint32_t) {
    throw InputError("this backend has no contacts in device memory");
}
double Backend::measure_reach(View<const BodyView>, View<const std::uint32_t>, View<const double>,
                              bool) {
    throw InputError("this backend reads no places in device memory");
}
void Backend::fetch_reach(View<const std::uint32_t>, View<Box>) {
    throw InputError("this backend reads no places in device memory");
}
View<const FetchedPlace> Backend::fetch_places(View<const BodyView>, View<const std::uint32_t>) {
    throw InputError("this backend reads no places in device memory");
}
std::shared_ptr<const Contact> Backend::keep_contacts() {
    const View<const Contact> all = contacts();
    const auto copy = std::make_shared<std::vector<Contact>>(all.begin(), all.end());
    return {copy, copy->data()};
}
void Backend::fetch_bodies(View<BodyView>) const {}
void Backend::fetch_seen(View<const BodyId>, View<const View<SeenPatch>>) const {}

}  // namespace pierce
