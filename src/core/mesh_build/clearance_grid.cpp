#include "core/mesh/clearance_grid.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "pierce/mesh.hpp"

namespace pierce {
namespace {

enum Cell : std::uint8_t { unknown, surface, outside };

struct Cells {
    ClearanceGridLayout layout;
    std::vector<Cell> state;

    std::size_t at(std::int32_t x, std::int32_t y, std::int32_t z) const {
        return layout.index_of(x, y, z);
    }
};

Cells make_cells(const ClearanceGridLayout& layout) {
    Cells cells{layout, {}};
    const std::int32_t count = layout.size[0] * layout.size[1] * layout.size[2];
    cells.state.assign(static_cast<std::size_t>(count), unknown);
    return cells;
}

ClearanceGridLayout layout_around(const Box& solid, std::uint32_t resolution) {
    ClearanceGridLayout layout;
    const Vec3d size = solid.upper - solid.lower;
    const double longest = std::max({size.x, size.y, size.z});
    // Two of the cells form the border, so that the outside is connected all around.
    layout.cell = longest / (resolution - 2);
    const double h = layout.cell;
    layout.per_length = 1.0 / h;
    layout.step = h / constants::clearance_steps_per_cell;
    for (int i = 0; i < 3; ++i) {
        const auto inner = static_cast<std::int32_t>(std::ceil(size[i] / h));
        layout.size[i] = std::max(inner, 1) + 2;
        layout.box.lower[i] = solid.center()[i] - 0.5 * h * layout.size[i];
        layout.box.upper[i] = solid.center()[i] + 0.5 * h * layout.size[i];
    }
    return layout;
}

/// Marks every cell that the triangle may touch: the cells of its box that its plane also meets.
void mark_triangle(Cells& cells, Vec3d a, Vec3d b, Vec3d c) {
    const ClearanceGridLayout& grid = cells.layout;
    const double margin = constants::touch_tolerance * grid.box.extent();
    Box box;
    for (Vec3d p : {a, b, c}) box.extend(p);
    std::int32_t first[3], last[3];
    for (int i = 0; i < 3; ++i) {
        const double low = (box.lower[i] - margin - grid.box.lower[i]) / grid.cell;
        const double high = (box.upper[i] + margin - grid.box.lower[i]) / grid.cell;
        first[i] = static_cast<std::int32_t>(std::max(low, 0.0));
        last[i] = std::min(static_cast<std::int32_t>(std::max(high, 0.0)), grid.size[i] - 1);
    }
    const Vec3d n = cross(b - a, c - a);
    const double reach = 0.5 * grid.cell * (std::abs(n.x) + std::abs(n.y) + std::abs(n.z)) +
                         margin * length(n);
    for (std::int32_t z = first[2]; z <= last[2]; ++z)
        for (std::int32_t y = first[1]; y <= last[1]; ++y)
            for (std::int32_t x = first[0]; x <= last[0]; ++x) {
                const Vec3d center = grid.box.lower + grid.cell * Vec3d{x + 0.5, y + 0.5, z + 0.5};
                if (std::abs(dot(n, center - a)) <= reach) cells.state[cells.at(x, y, z)] = surface;
            }
}

/// Floods the outside from a corner through the faces of unmarked cells, one run along x at a time.
void flood_outside(Cells& cells) {
    const auto* size = cells.layout.size;
    std::vector<std::array<std::int32_t, 3>> open{{0, 0, 0}};
    while (!open.empty()) {
        const auto [x, y, z] = open.back();
        open.pop_back();
        Cell* const row = cells.state.data() + cells.at(0, y, z);
        if (row[x] != unknown) continue;
        std::int32_t first = x, last = x;
        while (first > 0 && row[first - 1] == unknown) --first;
        while (last + 1 < size[0] && row[last + 1] == unknown) ++last;
        std::fill(row + first, row + last + 1, outside);
        for (const auto [dy, dz] : {std::array{-1, 0}, {1, 0}, {0, -1}, {0, 1}}) {
            const std::int32_t ny = y + dy, nz = z + dz;
            if (ny < 0 || ny >= size[1] || nz < 0 || nz >= size[2]) continue;
            const Cell* const next = cells.state.data() + cells.at(0, ny, nz);
            for (std::int32_t k = first; k <= last; ++k)
                if (next[k] == unknown && (k == first || next[k - 1] != unknown))
                    open.push_back({k, ny, nz});
        }
    }
}

/// The square of a gap in whole cells. It is limited to `most`, as clearance is stored in a byte.
using Gap = std::int16_t;
constexpr std::int32_t most_cells = 256 / constants::clearance_steps_per_cell + 1;
constexpr Gap most = most_cells * most_cells;

Gap squared_gap(std::int32_t cells_away) {
    const std::int32_t gap = std::clamp(cells_away - 1, 0, most_cells);
    return static_cast<Gap>(gap * gap);
}

/// Squared gaps to the nearest cell of the same row along x that is not outside.
std::vector<Gap> gaps_along_x(const Cells& cells) {
    const auto length = static_cast<std::size_t>(cells.layout.size[0]);
    std::vector<Gap> gaps(cells.state.size());
    for (std::size_t row = 0; row < gaps.size(); row += length) {
        std::int32_t away = most_cells + 1;
        for (std::size_t i = 0; i < length; ++i) {
            away = cells.state[row + i] == outside ? away + 1 : 0;
            gaps[row + i] = squared_gap(away);
        }
        away = most_cells + 1;
        for (std::size_t i = length; i-- > 0;) {
            away = cells.state[row + i] == outside ? away + 1 : 0;
            gaps[row + i] = std::min(gaps[row + i], squared_gap(away));
        }
    }
    return gaps;
}

/// Adds one axis to the distance transform. For every line of `count` rows, `stride` apart: out[i]
/// = min over j of in[j] + gap(i, j)^2.
void join_rows(const ClearanceGridLayout& grid, int axis, std::vector<Gap>& gaps) {
    const auto length = static_cast<std::size_t>(grid.size[0]),
               rows_y = static_cast<std::size_t>(grid.size[1]);
    const std::size_t stride = axis == 1 ? length : length * rows_y,
                      count = static_cast<std::size_t>(grid.size[axis]);
    const std::size_t lines = static_cast<std::size_t>(axis == 1 ? grid.size[2] : grid.size[1]);
    const std::size_t line_stride = axis == 1 ? length * rows_y : length;
    const std::vector<Gap> in = gaps;
    for (std::size_t line = 0; line < lines; ++line)
        for (std::size_t i = 0; i < count; ++i) {
            Gap* const out = gaps.data() + line * line_stride + i * stride;
            const auto take = [&](std::size_t j, Gap further) {
                const Gap* const other = in.data() + line * line_stride + j * stride;
                for (std::size_t x = 0; x < length; ++x) {
                    const auto candidate = static_cast<Gap>(other[x] + further);
                    out[x] = candidate < out[x] ? candidate : out[x];
                }
            };
            for (std::size_t d = 1; d < count; ++d) {
                const Gap further = squared_gap(static_cast<std::int32_t>(d));
                if (further >= *std::max_element(out, out + length)) break;
                if (i >= d) take(i - d, further);
                if (i + d < count) take(i + d, further);
            }
        }
}

std::vector<Gap> squared_gaps(const Cells& cells) {
    std::vector<Gap> gaps = gaps_along_x(cells);
    join_rows(cells.layout, 1, gaps);
    join_rows(cells.layout, 2, gaps);
    return gaps;
}

}  // namespace

ClearanceGridLayout clearance_layout(std::span<const Vec3f> positions,
                                     std::span<const Triangle> triangles,
                                     std::uint32_t resolution) {
    Box solid;
    for (const Triangle& t : triangles)
        for (std::uint32_t v : t.vertex) solid.extend(to_double(positions[v]));
    return solid.extent() > 0 ? layout_around(solid, resolution) : ClearanceGridLayout{};
}

ClearanceGrid build_clearance_grid(std::span<const Vec3f> positions,
                                   std::span<const Triangle> triangles, std::uint32_t resolution) {
    const ClearanceGridLayout layout = clearance_layout(positions, triangles, resolution);
    if (layout.size[0] == 0) return {};

    Cells cells = make_cells(layout);
    for (const Triangle& t : triangles)
        mark_triangle(cells, to_double(positions[t.vertex[0]]), to_double(positions[t.vertex[1]]),
                      to_double(positions[t.vertex[2]]));
    flood_outside(cells);

    ClearanceGrid grid{cells.layout, {}};
    grid.steps.reserve(cells.state.size());
    std::array<std::uint8_t, most + 1> steps_of{};
    for (std::size_t squared = 0; squared < steps_of.size(); ++squared) {
        const double steps = std::floor(std::sqrt(static_cast<double>(squared)) *
                                        constants::clearance_steps_per_cell);
        steps_of[squared] = static_cast<std::uint8_t>(std::min(steps, 255.0));
    }
    for (const Gap squared : squared_gaps(cells))
        grid.steps.push_back(steps_of[static_cast<std::size_t>(squared)]);
    return grid;
}

}  // namespace pierce
