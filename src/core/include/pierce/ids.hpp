#pragma once

#include <compare>
#include <cstdint>
#include <string_view>  // for std::hash; <functional> has it too, but is much larger

namespace pierce {

/// A handle: index plus generation. A default-made handle is null; a removed thing's handle never
/// becomes valid again.
template <class Tag>
struct Id {
    std::uint32_t index = 0;
    std::uint32_t generation = 0;

    explicit operator bool() const { return generation != 0; }
    friend auto operator<=>(const Id&, const Id&) = default;
};

/// Stands for a vertex or triangle where there is none.
inline constexpr std::uint32_t no_vertex = 0xffffffffu;
inline constexpr std::uint32_t no_triangle = 0xffffffffu;

using MeshId = Id<struct MeshTag>;
using BodyId = Id<struct BodyTag>;

}  // namespace pierce

/// \cond
template <class Tag>
struct std::hash<pierce::Id<Tag>> {
    std::size_t operator()(pierce::Id<Tag> id) const noexcept {
        return std::hash<std::uint64_t>{}((std::uint64_t{id.generation} << 32) | id.index);
    }
};
/// \endcond
