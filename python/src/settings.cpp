#include "settings.hpp"

#include "records.hpp"
#include "scenes/detect/method.hpp"

namespace pierce::python {

Settings settings_from(nb::handle settings, const nb::kwargs& fields) {
    const nb::object all = nb::cast(settings.is_none() ? Settings{} : nb::cast<Settings>(settings));
    set_fields(all, fields);
    return nb::cast<Settings>(all);
}

std::unique_ptr<Backend> backend_named(const std::string& name, int threads, int parts,
                                       double host_share) {
    scenes::RaySettings rays;
    rays.backend = name == "auto" ? "automatic" : name;
    rays.threads = threads;
    rays.parts = parts;
    rays.host_share = host_share;
    return scenes::make_backend(rays);
}

}  // namespace pierce::python
