#include "c_api/settings.hpp"

#include "c_api/arguments.hpp"
#include "c_api/border.hpp"
#include "c_api/versioned.hpp"
#include "pierce/settings.hpp"

namespace pierce::c {

static_assert(PIERCE_COVERAGE_VERTICES == static_cast<int>(Coverage::vertices) &&
              PIERCE_COVERAGE_COMPLETE == static_cast<int>(Coverage::complete) &&
              PIERCE_COVERAGE_OVERLAPS == static_cast<int>(Coverage::overlaps));
static_assert(PIERCE_TEMPORAL_OFF == static_cast<int>(Temporal::off) &&
              PIERCE_TEMPORAL_PAPER == static_cast<int>(Temporal::paper) &&
              PIERCE_TEMPORAL_CERTIFIED == static_cast<int>(Temporal::certified));

pierce_settings settings_of(const Settings& s) {
    return {.struct_size = sizeof(pierce_settings),
            .open_body_range = s.open_body_range,
            .margin = s.margin,
            .prediction_distance = s.prediction_distance,
            .walk_threshold = s.walk_threshold,
            .coverage = static_cast<std::uint32_t>(s.coverage),
            .temporal = static_cast<std::uint32_t>(s.temporal),
            .full_every = s.full_every,
            .reproject = s.reproject,
            .may_rest = s.may_rest,
            .predict = s.predict};
}

Settings settings_of(const pierce_settings* given) {
    if (given == nullptr) return {};
    const pierce_settings s = read_struct(given, settings_of(Settings{}), "settings");
    return {.open_body_range = s.open_body_range,
            .coverage = enumerated(s.coverage, Coverage::overlaps, "settings.coverage"),
            .reproject = s.reproject != 0,
            .margin = s.margin,
            .temporal = enumerated(s.temporal, Temporal::certified, "settings.temporal"),
            .may_rest = s.may_rest != 0,
            .predict = s.predict != 0,
            .prediction_distance = s.prediction_distance,
            .full_every = s.full_every,
            .walk_threshold = s.walk_threshold};
}

}  // namespace pierce::c

using namespace pierce::c;

pierce_status pierce_default_settings(pierce_settings* settings, size_t struct_size) {
    return guarded([&] {
        write_defaults(settings_of(pierce::Settings{}), settings, struct_size, "settings");
    });
}
