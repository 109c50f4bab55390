#pragma once

#include <btBulletCollisionCommon.h>

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "pierce/mesh.hpp"

namespace pierce::bullet {

/// Bullet's own methods for contacts of triangle meshes, with which Pierce is compared.
enum class Baseline {
    gjk_epa,   ///< convex pieces in a dynamic tree, GJK for distance and EPA for depth
    gjk_hull,  ///< one convex hull: wrong for a concave mesh, but often used
    gimpact,   ///< triangle against triangle
};

/// A shape and everything it points to.
class BaselineShape {
public:
    /// `convex_pieces` are the point sets whose hulls make up the mesh; only gjk_epa uses them, and
    /// it throws InputError if there are none. `margin` [length] is that around hulls; none:
    /// Bullet's own, 0.04.
    BaselineShape(Baseline method, const std::string& name, const MeshData& mesh,
                  std::span<const std::vector<Vec3f>> convex_pieces,
                  std::optional<double> margin = {});
    /// The half space below the mesh's highest point along z.
    static BaselineShape ground(const MeshData& mesh);
    ~BaselineShape();
    BaselineShape(BaselineShape&&) noexcept;

    btCollisionShape& shape() const { return *shape_; }
    /// How far Bullet's surface stands outside the mesh: the distances of Bullet's contacts are
    /// smaller by the margins of both shapes.
    double margin() const { return margin_; }

    /// Gives a gimpact shape other vertex positions and refits its tree. Throws InputError for
    /// other methods.
    void set_positions(std::span<const Vec3f> positions);

private:
    BaselineShape();

    struct Triangles;
    std::unique_ptr<Triangles> triangles_;
    std::vector<std::unique_ptr<btCollisionShape>> parts_;
    std::unique_ptr<btCollisionShape> shape_;
    double margin_ = 0;
};

/// Bullet's configuration with a clock on EPA, so that the times of finding pairs (GJK) and of
/// finding depths (EPA) are separate.
class TimedConfiguration : public btDefaultCollisionConfiguration {
public:
    TimedConfiguration();
    ~TimedConfiguration() override;

    /// Time spent in EPA since the last call [ms].
    double take_epa_milliseconds();

private:
    struct Clock;
    std::unique_ptr<Clock> clock_;
};

}  // namespace pierce::bullet
