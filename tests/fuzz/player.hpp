#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "fuzz/mesh_pool.hpp"
#include "fuzz/program.hpp"
#include "pierce/backend.hpp"
#include "pierce/world.hpp"

namespace pierce::fuzz {

using MakeBackend = std::function<std::unique_ptr<Backend>()>;

/// Plays a program's calls on a world.
class Player {
public:
    /// Throws what World's constructor throws. Players of one program share their meshes.
    Player(MakeBackend backend, const Settings& settings,
           std::shared_ptr<MeshPool> pool = std::make_shared<MeshPool>());

    /// What a call came to: what it answered, or the error it was refused with. Lets any exception
    /// through but InputError.
    struct Outcome {
        bool refused = false;
        std::string text;

        friend bool operator==(const Outcome&, const Outcome&) = default;
    };
    Outcome play(const Call& call);

    /// Goes on with a world that another player has saved.
    std::string save() const;
    void restore(const std::string& saved);

    World& world() { return world_; }
    const World& world() const { return world_; }
    const std::vector<BodyId>& bodies() const { return bodies_; }
    const std::vector<MeshId>& meshes() const { return meshes_; }

private:
    std::string answer(const Call& call);
    MeshId mesh(std::uint32_t number) const {
        return number < meshes_.size() ? meshes_[number] : MeshId{};
    }
    BodyId body(std::uint32_t number) const {
        return number < bodies_.size() ? bodies_[number] : BodyId{};
    }

    MakeBackend make_;
    std::shared_ptr<MeshPool> pool_;
    World world_;
    std::vector<MeshId> meshes_;                     ///< null for what was refused
    std::vector<std::shared_ptr<const Mesh>> made_;  ///< the same; may be shorter
    std::vector<BodyId> bodies_;
};

}  // namespace pierce::fuzz
