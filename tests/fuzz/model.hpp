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
    /// False for a body whose place is not usable, and in a world that is left out.
    bool takes_part(const ModelBody& body) const;
    bool is_active(std::int32_t world) const { return !left_out_.contains(world); }
    /// The worlds that bodies are in, sorted, without all_worlds.
    std::vector<std::int32_t> worlds() const;
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
    /// A new world of the bodies that are in `world` or in all worlds, as if there were no worlds.
    /// `bodies`: those, in the order of the new world's.
    Player alone(std::int32_t world, const MakeBackend& backend, Temporal temporal,
                 std::shared_ptr<MeshPool> pool, std::vector<const ModelBody*>& bodies) const;

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

    void replicate(const Call& call, const Player& player);
    void copy_places(const Call& call);
    /// Of a world, in the order of their handles' indices.
    std::vector<ModelBody*> bodies_of(std::int32_t world);
    template <class See>
    void each_body(const See& see) {
        for (std::vector<ModelBody>* all : {&bodies_, &copies_})
            for (ModelBody& b : *all)
                if (b.used) see(b);
    }
    Player made_of(const std::vector<const ModelBody*>& bodies, bool with_worlds,
                   const MakeBackend& backend, Temporal temporal,
                   std::shared_ptr<MeshPool> pool) const;

    std::vector<ModelMesh> meshes_;
    std::vector<ModelBody> bodies_;  ///< by number
    std::vector<ModelBody> copies_;  ///< that replicate() has made
    std::set<std::int32_t> left_out_;
    std::set<std::pair<BodyId, BodyId>> excluded_;
};

}  // namespace pierce::fuzz
