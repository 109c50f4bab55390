#include "pierce/core/clearance_grid.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "pierce/core/mesh.hpp"

namespace pierce {
namespace {

enum Cell : std::uint8_t { unknown, surface, outside };

struct Cells {
    ClearanceGridView layout;
    std::vector<Cell> state;

    std::size_t at(std::int32_t x, std::int32_t y, std::int32_t z) const { return layout.index_of(x, y, z); }
};

Cells make_cells(const Box& solid) {
    Cells cells;
    const Vec3d size = solid.upper - solid.lower;
    const double longest = std::max({size.x, size.y, size.z});
    // Two of the cells go to the border, so that the outside is connected all around.
    cells.layout.cell = longest / (constants::grid_resolution - 2);
    const double h = cells.layout.cell;
    cells.layout.per_length = 1.0 / h;
    cells.layout.step = h / constants::clearance_steps_per_cell;
    for (int i = 0; i < 3; ++i) {
        const auto inner = static_cast<std::int32_t>(std::ceil(size[i] / h));
        cells.layout.size[i] = std::max(inner, 1) + 2;
        cells.layout.box.lower[i] = solid.center()[i] - 0.5 * h * cells.layout.size[i];
        cells.layout.box.upper[i] = solid.center()[i] + 0.5 * h * cells.layout.size[i];
    }
    const std::int32_t count = cells.layout.size[0] * cells.layout.size[1] * cells.layout.size[2];
    cells.state.assign(static_cast<std::size_t>(count), unknown);
    return cells;
}

/// Marks every cell the triangle may touch: its box's cells that its plane also meets.
void mark_triangle(Cells& cells, Vec3d a, Vec3d b, Vec3d c) {
    const ClearanceGridView& grid = cells.layout;
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
    const double reach = 0.5 * grid.cell * (std::abs(n.x) + std::abs(n.y) + std::abs(n.z)) + margin * length(n);
    for (std::int32_t z = first[2]; z <= last[2]; ++z)
        for (std::int32_t y = first[1]; y <= last[1]; ++y)
            for (std::int32_t x = first[0]; x <= last[0]; ++x) {
                const Vec3d center = grid.box.lower + grid.cell * Vec3d{x + 0.5, y + 0.5, z + 0.5};
                if (std::abs(dot(n, center - a)) <= reach) cells.state[cells.at(x, y, z)] = surface;
            }
}

/// Floods the outside from a corner through faces of unmarked cells.
void flood_outside(Cells& cells) {
    const auto* size = cells.layout.size;
    std::vector<std::array<std::int32_t, 3>> open{{0, 0, 0}};
    cells.state[0] = outside;
    while (!open.empty()) {
        const auto cell = open.back();
        open.pop_back();
        for (int axis = 0; axis < 3; ++axis)
            for (int step : {-1, 1}) {
                auto next = cell;
                next[axis] += step;
                if (next[axis] < 0 || next[axis] >= size[axis]) continue;
                Cell& state = cells.state[cells.at(next[0], next[1], next[2])];
                if (state != unknown) continue;
                state = outside;
                open.push_back(next);
            }
    }
}

/// One axis of the distance transform: out[i] = min over j of in[j] + gap(i, j)^2, gap in whole cells.
void sweep(std::span<float> line, std::vector<float>& scratch) {
    scratch.assign(line.begin(), line.end());
    const std::size_t n = line.size();
    for (std::size_t i = 0; i < n; ++i) {
        float best = scratch[i];
        for (std::size_t d = 1; d < n; ++d) {
            const float gap = static_cast<float>(d - 1);
            if (gap * gap >= best) break;
            if (i >= d) best = std::min(best, scratch[i - d] + gap * gap);
            if (i + d < n) best = std::min(best, scratch[i + d] + gap * gap);
        }
        line[i] = best;
    }
}

std::vector<float> squared_gaps(const Cells& cells) {
    const auto* size = cells.layout.size;
    std::vector<float> gap(cells.state.size());
    for (std::size_t i = 0; i < gap.size(); ++i)
        gap[i] = cells.state[i] == outside ? std::numeric_limits<float>::infinity() : 0.0f;
    std::vector<float> line, scratch;
    for (int axis = 0; axis < 3; ++axis) {
        const int u = (axis + 1) % 3, v = (axis + 2) % 3;
        line.resize(static_cast<std::size_t>(size[axis]));
        for (std::int32_t a = 0; a < size[u]; ++a)
            for (std::int32_t b = 0; b < size[v]; ++b) {
                std::int32_t index[3];
                index[u] = a;
                index[v] = b;
                const auto at = [&](std::int32_t i) {
                    index[axis] = i;
                    return cells.at(index[0], index[1], index[2]);
                };
                for (std::int32_t i = 0; i < size[axis]; ++i) line[static_cast<std::size_t>(i)] = gap[at(i)];
                sweep(line, scratch);
                for (std::int32_t i = 0; i < size[axis]; ++i) gap[at(i)] = line[static_cast<std::size_t>(i)];
            }
    }
    return gap;
}

}  // namespace

ClearanceGrid build_clearance_grid(std::span<const Vec3f> positions, std::span<const Triangle> triangles) {
    Box solid;
    for (const Triangle& t : triangles)
        for (std::uint32_t v : t.vertex) solid.extend(to_double(positions[v]));
    if (!(solid.extent() > 0)) return {};

    Cells cells = make_cells(solid);
    for (const Triangle& t : triangles)
        mark_triangle(cells, to_double(positions[t.vertex[0]]), to_double(positions[t.vertex[1]]),
                      to_double(positions[t.vertex[2]]));
    flood_outside(cells);

    ClearanceGrid grid{cells.layout, {}};
    grid.steps.reserve(cells.state.size());
    for (float squared : squared_gaps(cells)) {
        const double steps = std::floor(std::sqrt(static_cast<double>(squared)) * constants::clearance_steps_per_cell);
        grid.steps.push_back(static_cast<std::uint8_t>(std::min(steps, 255.0)));
    }
    return grid;
}

}  // namespace pierce
