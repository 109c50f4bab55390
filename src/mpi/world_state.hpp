#pragma once

#include <cstdint>
#include <exception>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "core/partition/partition.hpp"
#include "core/partition/region.hpp"
#include "core/partition/space_cut.hpp"
#include "core/step/common/step_memory.hpp"
#include "core/world/world_state.hpp"
#include "mpi/communicator.hpp"
#include "mpi/failure.hpp"
#include "mpi/messages.hpp"
#include "mpi/near_ranks.hpp"
#include "pierce/mpi/world.hpp"

namespace pierce::mpi {

/// What this rank knows of another one, and has told it.
struct OtherRank {
    std::vector<std::uint32_t> has;  ///< numbers of own bodies that are its ghosts, sorted
    std::set<std::uint64_t> meshes;  ///< keys of those that it need not get again
    std::set<std::uint64_t> got;     ///< keys of those that it was ever sent, and may still have
};

/// A mesh that others have sent.
struct KnownMesh {
    MeshId here;
    std::set<std::uint32_t> senders;  ///< ranks that take it to be known here
};

/// Where other ranks have seen a body last.
struct Told {
    std::uint64_t positions_version = 0;
    Pose pose;
};

/// A body where space is cut.
struct PlacedBody {
    std::uint32_t number = 0;
    BodyFacts facts;
    Box reach;
};
PlacedBody placed(std::uint32_t number, const BodyView& view, const Box& reach);

/// What a World consists of; bodies of all ranks have their numbers as slots of `local`.
struct World::State {
    Communicator comm;
    pierce::World local;
    WorldInside::State& inside;

    std::vector<std::uint32_t> own;   ///< numbers of the bodies that this rank owns, sorted
    std::vector<std::uint32_t> cell;  ///< per own body: one of the rank's compact cells
    bool own_changed = true;          ///< the two lists are to be made anew
    double mean_extent = 0;
    double cells_extent = 0;  ///< [length] of all cells when they were made
    std::vector<Box> reach;   ///< by number; of own bodies
    std::vector<Told> told;   ///< by number; of own bodies
    BodySet refreshed_now;    ///< by number; bodies whose input may differ from the last step's
    std::vector<std::uint32_t> on_device;  ///< own bodies whose reach the device has measured
    std::vector<OtherRank> others;
    NearRanks near_ranks;      ///< what others' moving bodies reach
    std::vector<double> work;  ///< per rank, in the last step

    News news;
    std::set<BodyId> heard;  ///< bodies in `news.added` that a step was refused for
    bool has_news = true;
    bool forgets_sides = false;
    std::set<std::uint32_t> changed_bodies;           ///< own ones that others have to get anew
    std::vector<std::uint32_t> removed;               ///< numbers of own bodies since the last step
    std::set<BodyIdPair> excluded;                    ///< of all ranks
    std::set<std::int32_t> left_out;                  ///< worlds, wherever their bodies are
    std::map<std::uint64_t, KnownMesh> known_meshes;  ///< those of other ranks, by key

    bool hands_over = false;           ///< the next step's ghosts come with what is remembered
    std::optional<StepMemory> handed;  ///< what the next step is to remember
    bool by_world = false;             ///< how pairs of the last step's contacts are written
    bool detected = false;             ///< the last step has not failed
    std::uint64_t revision = 0;        ///< of the plan of the last step
    std::vector<BodyId> motions;       ///< own bodies that move in the step that is being taken

    /// Throws on all ranks what make(), which makes `local`, throws on one.
    State(MPI_Comm ranks, const std::function<pierce::World()>& make);

    std::uint32_t rank() const { return static_cast<std::uint32_t>(comm.rank()); }
    bool is_own(BodyId body) const;
    /// True if there is a body of that number here, and that rank owns it.
    bool belongs_to(std::uint32_t number, std::uint32_t owner) const {
        const auto& slots = inside.bodies.slots();
        return number < slots.size() && slots[number].used && slots[number].thing.part == owner;
    }
    /// Throws InputError unless this rank owns the bodies.
    void check_own(std::span<const BodyId> some) const;
    /// Throws InputError for bodies that can be no pair, as far as this rank knows.
    BodyIdPair pair_of(BodyId a, BodyId b) const;
    /// Throws InputError if there is a body of that number here.
    void check_free(std::uint32_t number) const;
    BodyEntry& entry(std::uint32_t number) { return inside.bodies.slots()[number].thing; }
    BodyId id(std::uint32_t number) const {
        return {number, inside.bodies.slots()[number].generation};
    }
    /// Puts a body that `local` has added where its number says.
    BodyId add(std::uint32_t number, BodyId added);
    /// To be called when an own body has changed but for its place.
    void note_changed(BodyId body);

    /// Calls run(), and then throws on all ranks if it has thrown on one.
    template <class Run>
    void together(const Run& run) {
        const std::exception_ptr failure = failure_of(run);
        if (any_failed(comm, failure)) fail(failure);
    }
    /// Collective, for when there is a failure on some rank.
    [[noreturn]] void fail(const std::exception_ptr& failure);
    /// The own bodies that have moved since the last step.
    std::vector<BodyId> moved_bodies() const;
    /// Forgets ghosts, and what is remembered.
    void start_over();
    void drop_ghosts();

    // The parts of a step, in their order (ghosts.cpp).
    void agree_on_news();
    void look_around();
    std::vector<std::string> messages();
    void take_in(std::vector<std::string> all);

    void take_in_news(const std::vector<std::string>& all);
    /// Says which body a rank has added although there is, or was in the last step, another one of
    /// that number elsewhere; empty: none. `news_of`: by rank.
    std::string conflict_in(std::span<const News> news_of) const;
    /// Leaves worlds out as long as some rank has a body of theirs. `used`: of all ranks' bodies.
    void settle_worlds(const std::set<std::int32_t>& used);
    Summary summary();
    void measure_on_device();
    /// Brings the places that others have to know from device memory. Bodies whose places there are
    /// unusable are near nobody.
    void bring_places(std::vector<std::vector<NearBody>>& near);
    /// Per rank, the own bodies that are near it, by number.
    std::vector<std::vector<NearBody>> near_bodies() const;
    bool has_mesh(std::uint64_t key) const;
    GhostMessage message_to(std::uint32_t other, const std::vector<NearBody>& near);
    /// Adds where a body is now, if others do not know.
    void add_moved(std::vector<MovedBody>& all, std::uint32_t number) const;
    void take_in(std::uint32_t from, GhostMessage message);
    /// Leaves out pairs that are not wanted, of bodies that are here; before a plan is made.
    void exclude_pairs();

    /// True if ghosts that come have to know how the last step saw them.
    bool tells_seen() const {
        // How far predictions look depends on where bodies were, also ghosts.
        return hands_over || inside.plan.settings.temporal == Temporal::paper;
    }
    /// `memory`: what is remembered, if how the last step saw the body matters; else null.
    WholeBody whole(std::uint32_t number, const StepMemory* memory) const;
    /// Adds the mesh of a body to a message unless the receiver has it.
    void add_mesh_to(std::vector<SavedMesh>& meshes, std::uint32_t number,
                     std::set<std::uint64_t>& has) const;
    void take_meshes(std::uint32_t from, std::vector<SavedMesh> meshes);
    void forget_mesh(std::uint32_t from, std::uint64_t key);
    /// Takes away bodies of other ranks that are not near; the next step makes a new plan if there
    /// is one.
    void drop_away();
    void put(const WholeBody& body, std::uint32_t owner);
    void make_lists();
    bool is_moving(std::uint32_t number) const {
        return inside.bodies.slots()[number].thing.motion != Motion::fixed;
    }

    /// Brings what deforming bodies looked like in the last step, and returns what it remembers.
    StepMemory remembered();
    /// Collective. What the next step is to remember, as far as all ranks know as much.
    StepMemory memory_to_share();
    /// What the next step is to remember, if it is not to be what the last one has left.
    StepMemory& to_remember();
    /// Collective. What is to be known of all ranks' bodies to cut space.
    std::vector<PlacedBody> all_placed() const;
    /// Collective. Cuts space, as all ranks do: each body's new owner, by number.
    std::vector<std::uint32_t> cut(std::span<const PlacedBody> all) const;
};

/// What there is to know of bodies, by number.
std::vector<BodyFacts> facts_by_number(std::span<const PlacedBody> all);
/// Of what is remembered, the pairs of one part. `facts`, `owners`: by number, of all ranks'
/// bodies.
StepMemory memory_of_part(const StepMemory& all, std::span<const BodyFacts> facts,
                          std::span<const std::uint32_t> owners, std::uint32_t part);

}  // namespace pierce::mpi
