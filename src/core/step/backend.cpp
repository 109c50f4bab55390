#include "pierce/backend.hpp"

#include "core/body/body_view.hpp"
#include "core/device/view.hpp"
#include "core/mesh/mesh_view.hpp"

namespace pierce {

void Backend::fetch_bodies(View<BodyView>) const {}
void Backend::fetch_seen(View<const BodyId>, View<const View<SeenPatch>>) const {}

}  // namespace pierce
