#pragma once

#include <cstdint>
#include <limits>
#include <nlohmann/json.hpp>
#include <string>

#include "pierce/error.hpp"

namespace pierce::scenes {

/// The number of a frame, a body, a vertex or the like. Throws InputError, which begins with
/// `where`, for anything else; a conversion would cut it to fit.
inline std::uint32_t index_in(const nlohmann::json& value, const std::string& where) {
    if (!value.is_number_unsigned() ||
        value.get<std::uint64_t>() > std::numeric_limits<std::uint32_t>::max())
        throw InputError(where + ": " +
                         (value.is_number() ? value.dump() : std::string(value.type_name())) +
                         " is no number of a frame, a body or the like");
    return value.get<std::uint32_t>();
}

}  // namespace pierce::scenes
