#pragma once

#include <set>
#include <utility>
#include <vector>

#include "fuzz/player.hpp"
#include "fuzz/program.hpp"

namespace pierce::fuzz {

/// A body as the calls so far have left it.
struct ModelBody {
    std::uint32_t mesh = 0;  ///< its number
    BodyId id;
    Motion motion = Motion::fixed;
    Collision collision;
    Filter filter;
    Pose start_pose, pose;
    std::vector<Vec3f> start, positions;  ///< of a deforming body
    bool finite = true;
    bool moved = false;  ///< since the last step
    bool used = false;   ///< in the world
};

/// What a world's documentation says that the world consists of after some calls: its state without
/// its history.
class Model {
public:
    explicit Model(const Settings& settings) : settings_(settings) {}

    /// Takes a call into account that was not refused. `player` has played it.
    void apply(const Call& call, const Player& player);
    /// As a refused call leaves the numbering.
    void skip(const Call& call);

    const Settings& settings() const { return settings_; }
    /// Those in the world, in the order of their handles' indices.
    std::vector<const ModelBody*> bodies() const;
    /// The surface that contacts name: with Inside::winding, another than the given one.
    const MeshData& mesh(const ModelBody& body) const { return meshes_[body.mesh].surface; }
    bool has_inside(const ModelBody& body) const { return meshes_[body.mesh].has_inside; }
    bool has_sheets() const;
    /// False for two bodies that are no pair by their filters, or because the pair is excluded.
    bool may_meet(const ModelBody& a, const ModelBody& b) const;
    /// [length] How near the two are in contact without overlapping.
    double margin(const ModelBody& a, const ModelBody& b) const;

    /// Where a body's vertices are when the step begins and when it ends, in world space.
    std::vector<Vec3d> starts(const ModelBody& body) const;
    std::vector<Vec3d> ends(const ModelBody& body) const;

    /// A new world in the same state; its bodies are those of bodies(), in that order.
    Player fresh(const MakeBackend& backend, Temporal temporal,
                 std::shared_ptr<MeshPool> pool) const;

private:
    Settings settings_;
    struct ModelMesh {
        MeshData given;
        Inside inside = Inside::automatic;  ///< that was asked for
        MeshData surface = {};
        bool has_inside = false;

        ModelMesh(const MeshData& data, Inside rule);
        ModelMesh(MeshData its_data, Inside rule, MeshData its_surface, bool its_has_inside)
            : given(std::move(its_data)),
              inside(rule),
              surface(std::move(its_surface)),
              has_inside(its_has_inside) {}
    };

    std::vector<ModelMesh> meshes_;
    std::vector<ModelBody> bodies_;
    std::set<std::pair<BodyId, BodyId>> excluded_;
};

}  // namespace pierce::fuzz
