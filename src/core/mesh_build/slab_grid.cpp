#include "core/mesh_build/slab_grid.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/base/workers.hpp"
#include "pierce/mesh.hpp"

namespace pierce {
namespace {

/// How far from the middle of a cell a slab holds the surface [cell]. Places are rounded, here,
/// too.
constexpr double reach = 0.5 + constants::slab_reach + constants::slab_rounding;

/// A place in the list of slabs fits into these bits of a SlabCell: there are fewer cells.
constexpr std::uint32_t slab_bits = (1u << 24) - 1;
static_assert((constants::slab_resolution + 2) * (constants::slab_resolution + 2) *
                  (constants::slab_resolution + 2) <
              slab_bits);

double middle_of(std::int32_t cell) { return cell + 0.5; }

/// A triangle in cells of the grid.
struct GridTriangle {
    std::array<Vec3d, 3> corner;
    Vec3d normal;                                 ///< unit; zero if the triangle has none
    std::array<std::int32_t, 3> first{}, last{};  ///< cells that it is near, by its box
    bool is_small = false;                        ///< not worth clipping
};

/// A convex polygon: a triangle clipped by up to six planes.
class Polygon {
public:
    explicit Polygon(const GridTriangle& t) : count_(3) {
        std::ranges::copy(t.corner, corner_.begin());
    }

    std::span<const Vec3d> corners() const { return {corner_.data(), count_}; }
    bool is_empty() const { return count_ == 0; }

    /// What is within `reach` of the middle of these cells along an axis.
    template <double Vec3d::*axis>
    Polygon clipped(std::int32_t cell) const {
        const double low = middle_of(cell) - reach, high = middle_of(cell) + reach;
        const auto is_over = [&](Vec3d p) { return p.*axis < low || p.*axis > high; };
        Polygon polygon = *this;
        if (std::ranges::none_of(corners(), is_over)) return polygon;
        polygon.clip<axis>(-1, -low);
        polygon.clip<axis>(1, high);
        return polygon;
    }

    /// Twice the area, along the normal.
    Vec3d area() const {
        Vec3d sum;
        for (std::size_t k = 2; k < count_; ++k)
            sum += cross(corner_[k - 1] - corner_[0], corner_[k] - corner_[0]);
        return sum;
    }

private:
    template <double Vec3d::*axis>
    void clip(double side, double limit) {
        std::array<Vec3d, 9> kept;
        std::size_t count = 0;
        for (std::size_t k = 0; k < count_; ++k) {
            const Vec3d p = corner_[k], q = corner_[k + 1 < count_ ? k + 1 : 0];
            const double over_p = side * p.*axis - limit, over_q = side * q.*axis - limit;
            if (over_p <= 0) kept[count++] = p;
            if ((over_p < 0 && over_q > 0) || (over_p > 0 && over_q < 0))
                kept[count++] = p + (over_p / (over_p - over_q)) * (q - p);
        }
        corner_ = kept;
        count_ = count;
    }

    std::array<Vec3d, 9> corner_;
    std::size_t count_;
};

GridTriangle in_cells(const ClearanceGridLayout& grid, std::span<const Vec3f> positions,
                      const Triangle& triangle) {
    GridTriangle t;
    Box box;
    for (std::size_t c = 0; c < 3; ++c) {
        t.corner[c] = (1 / grid.cell) * (to_double(positions[triangle.vertex[c]]) - grid.box.lower);
        box.extend(t.corner[c]);
    }
    for (int i = 0; i < 3; ++i) {
        const auto at = static_cast<std::size_t>(i);
        t.first[at] = std::max(static_cast<std::int32_t>(std::floor(box.lower[i] + 0.5 - reach)),
                               0);
        t.last[at] = std::min(static_cast<std::int32_t>(std::floor(box.upper[i] - 0.5 + reach)),
                              grid.size[i] - 1);
    }
    const Vec3d product = cross(t.corner[1] - t.corner[0], t.corner[2] - t.corner[0]);
    const double sides = std::max({length_squared(t.corner[1] - t.corner[0]),
                                   length_squared(t.corner[2] - t.corner[1]),
                                   length_squared(t.corner[0] - t.corner[2])});
    if (length(product) > constants::degenerate_area * sides) t.normal = normalized(product);
    t.is_small = box.extent() < constants::slab_small_triangle;
    return t;
}

/// The slab of a cell: first its normal is found, then it is made to hold what is in the cell.
class SlabBuilder {
public:
    /// Counts for the normal. `area`: twice that of a polygon, along its normal.
    void add(Vec3d area) {
        area_ += area;
        is_empty_ = false;
    }
    bool is_empty() const { return is_empty_; }

    void choose_normal() {
        const Vec3d along = normalized(area_);
        for (int i = 0; i < 3; ++i) {
            slab_.normal[i] = static_cast<std::int8_t>(along[i] * constants::slab_normal_unit);
            stored_[i] = slab_.normal[i] / constants::slab_normal_unit;
        }
        axis_ = normalized(stored_);
    }
    /// Makes the slab hold a polygon around `middle`.
    void hold(Vec3d normal, std::span<const Vec3d> corners, Vec3d middle) {
        for (const Vec3d p : corners) hold(p - middle);
        face(normal);
    }

    CellSlab slab() const {
        CellSlab slab = slab_;
        slab.low = static_cast<std::int16_t>(std::floor(low_ * constants::slab_units) - 1);
        slab.high = static_cast<std::int16_t>(std::ceil(high_ * constants::slab_units) + 1);
        if (cosine_ > 0)
            slab.sine = static_cast<std::int8_t>(std::min(
                std::ceil(sine_ * constants::slab_normal_unit), double{CellSlab::slab_any_way}));
        return slab;
    }

private:
    void hold(Vec3d from_middle) {
        low_ = std::min(dot(stored_, from_middle), low_);
        high_ = std::max(dot(stored_, from_middle), high_);
    }
    void face(Vec3d normal) {
        cosine_ = std::min(dot(axis_, normal), cosine_);
        sine_ = std::max(length(cross(axis_, normal)), sine_);
    }

    Vec3d area_, stored_, axis_;
    bool is_empty_ = true;
    double low_ = INFINITY, high_ = -INFINITY, cosine_ = 1, sine_ = 0;
    CellSlab slab_;
};

/// The slabs of a layer of cells.
class LayerBuilder {
public:
    LayerBuilder(const ClearanceGridLayout& grid, std::int32_t z)
        : grid_(grid), z_(z), cells_(grid.index_of(0, 0, 1)) {}

    /// Adds the triangles to the cells that they are in. Of small ones there may be very many in a
    /// cell; so they are looked at twice, and not kept.
    void add(std::span<const GridTriangle> triangles, std::span<const std::uint32_t> of_layer) {
        for (const std::uint32_t i : of_layer) {
            const GridTriangle& t = triangles[i];
            if (t.is_small)
                for_each_cell(
                    t, [area = Polygon(t).area()](SlabBuilder& cell, Vec3d) { cell.add(area); });
            else
                clip(t, i);
        }
        for (SlabBuilder& cell : cells_)
            if (!cell.is_empty()) cell.choose_normal();
        for (const Piece& piece : pieces_)
            cells_[piece.cell].hold(
                triangles[piece.triangle].normal,
                std::span(corners_).subspan(piece.first_corner, piece.corner_count), piece.middle);
        for (const std::uint32_t i : of_layer) {
            const GridTriangle& t = triangles[i];
            if (t.is_small)
                for_each_cell(t, [&t](SlabBuilder& cell, Vec3d middle) {
                    cell.hold(t.normal, t.corner, middle);
                });
        }
    }

    /// Per cell of the layer, in the order of the grid.
    std::span<const SlabBuilder> cells() const { return cells_; }

private:
    /// What of a triangle is in a cell.
    struct Piece {
        std::size_t cell;
        std::uint32_t triangle;
        std::uint32_t corner_count;
        std::size_t first_corner;
        Vec3d middle;
    };

    static bool is_near(const GridTriangle& t, Vec3d middle) {
        const double span = reach *
                            (std::abs(t.normal.x) + std::abs(t.normal.y) + std::abs(t.normal.z));
        return std::abs(dot(t.normal, middle - t.corner[0])) <= span;
    }

    /// Calls f(cell, middle) for the cells that the triangle's box and its plane are near.
    template <class F>
    void for_each_cell(const GridTriangle& t, const F& f) {
        for (std::int32_t y = t.first[1]; y <= t.last[1]; ++y)
            for (std::int32_t x = t.first[0]; x <= t.last[0]; ++x) {
                const Vec3d middle{middle_of(x), middle_of(y), middle_of(z_)};
                if (is_near(t, middle)) f(cells_[grid_.index_of(x, y, 0)], middle);
            }
    }

    /// Clips the triangle to the layer, each row of the layer and each cell of the row, and keeps
    /// the pieces.
    void clip(const GridTriangle& t, std::uint32_t number) {
        const Polygon in_layer = Polygon(t).clipped<&Vec3d::z>(z_);
        for (std::int32_t y = t.first[1]; y <= t.last[1] && !in_layer.is_empty(); ++y) {
            const Polygon in_row = in_layer.clipped<&Vec3d::y>(y);
            for (std::int32_t x = t.first[0]; x <= t.last[0] && !in_row.is_empty(); ++x) {
                const Vec3d middle{middle_of(x), middle_of(y), middle_of(z_)};
                if (!is_near(t, middle)) continue;
                const Polygon in_cell = in_row.clipped<&Vec3d::x>(x);
                if (in_cell.is_empty()) continue;
                const std::span<const Vec3d> corners = in_cell.corners();
                pieces_.push_back({.cell = grid_.index_of(x, y, 0),
                                   .triangle = number,
                                   .corner_count = static_cast<std::uint32_t>(corners.size()),
                                   .first_corner = corners_.size(),
                                   .middle = middle});
                corners_.insert(corners_.end(), corners.begin(), corners.end());
                cells_[pieces_.back().cell].add(in_cell.area());
            }
        }
    }

    const ClearanceGridLayout& grid_;
    std::int32_t z_;
    std::vector<SlabBuilder> cells_;
    std::vector<Piece> pieces_;
    std::vector<Vec3d> corners_;  ///< of the pieces
};

}  // namespace

std::uint32_t slab_resolution(std::size_t triangles) {
    const double fitting = std::ceil(std::sqrt(2.0 * static_cast<double>(triangles)));
    return static_cast<std::uint32_t>(
        std::clamp<double>(fitting, constants::slab_resolution_least, constants::slab_resolution));
}

SlabGrid build_slab_grid(const ClearanceGrid& clearance, std::span<const Vec3f> positions,
                         std::span<const Triangle> triangles, Workers& workers) {
    const ClearanceGridLayout& grid = clearance.layout;
    SlabGrid slabs;
    if (!(grid.cell > 0)) return slabs;
    slabs.cells.reserve(clearance.steps.size());
    for (const std::uint8_t steps : clearance.steps) slabs.cells.push_back({steps, 0});
    slabs.slabs.push_back({});
    std::vector<GridTriangle> placed;
    placed.reserve(triangles.size());
    std::vector<std::vector<std::uint32_t>> of_layer(static_cast<std::size_t>(grid.size[2]));
    for (const Triangle& t : triangles) {
        placed.push_back(in_cells(grid, positions, t));
        for (std::int32_t z = placed.back().first[2]; z <= placed.back().last[2]; ++z)
            of_layer[static_cast<std::size_t>(z)].push_back(
                static_cast<std::uint32_t>(placed.size() - 1));
    }
    // Of each layer, the cells that have a slab, and the slabs.
    struct Layer {
        std::vector<std::size_t> cells;
        std::vector<CellSlab> slabs;
    };
    std::vector<Layer> layers(of_layer.size());
    workers.share_out("slabs", static_cast<std::uint32_t>(layers.size()), 1,
                      [&](std::uint32_t z, std::uint32_t) {
                          LayerBuilder builder(grid, static_cast<std::int32_t>(z));
                          builder.add(placed, of_layer[z]);
                          std::size_t cell = grid.index_of(0, 0, static_cast<std::int32_t>(z));
                          for (const SlabBuilder& slab : builder.cells()) {
                              if (!slab.is_empty()) {
                                  layers[z].cells.push_back(cell);
                                  layers[z].slabs.push_back(slab.slab());
                              }
                              ++cell;
                          }
                      });
    for (const Layer& layer : layers)
        for (std::size_t k = 0; k < layer.cells.size(); ++k) {
            slabs.cells[layer.cells[k]].slab = slabs.slabs.size() & slab_bits;
            slabs.slabs.push_back(layer.slabs[k]);
        }
    return slabs;
}

}  // namespace pierce
