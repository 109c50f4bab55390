#pragma once

#include <memory>

#include "pierce/backend.hpp"
#include "pierce/c/settings.h"

namespace pierce {
struct Settings;
}  // namespace pierce

namespace pierce::c {

/// Settings as a caller gives them; null: the defaults. Throws InputError for impossible ones.
Settings settings_of(const pierce_settings* given);
pierce_settings settings_of(const Settings& settings);

/// The backend that a caller asks for; null: the default one. Throws InputError, or NotBuilt.
std::unique_ptr<Backend> backend_of(const pierce_backend_options* given);

}  // namespace pierce::c
