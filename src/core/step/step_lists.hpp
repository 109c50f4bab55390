#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "core/execute/executor.hpp"
#include "core/step/common/bounds.hpp"
#include "core/step/common/count.hpp"
#include "core/step/common/frame_fit.hpp"
#include "core/step/common/pairs.hpp"
#include "core/step/common/records.hpp"
#include "core/step/common/step_memory.hpp"
#include "core/step/solids/ray_batch.hpp"
#include "core/step/solids/vertex_cull.hpp"
#include "pierce/contact.hpp"

/// The lists of a step, grouped by the stages that write them. They grow and are kept.
namespace pierce {

/// What a step leaves for the next one, where the executor keeps it.
template <Executor E>
struct StepRecords {
    template <class Item>
    using Buffer = typename E::template Buffer<Item>;

    bool by_world = false;  ///< how pair_keys are written (PairKeys)
    Buffer<std::uint64_t> pair_keys;
    Buffer<PairIdentity> identities;
    Buffer<SeenBody> bodies;
    Buffer<PairMemory> directed;
    Buffer<BlockRecord> blocks;
    Buffer<PatchRecord> patches;
    Buffer<VertexRecord> vertices;
    Buffer<std::uint64_t> contact_keys;
    Buffer<std::uint32_t> ages;
    Buffer<Contact> contacts;
    std::shared_ptr<Buffer<Contact>> kept;  ///< where contacts go that a caller keeps for longer

    /// The contacts, which stay as they are as long as the pointer is there.
    std::shared_ptr<const Contact> keep_contacts() {
        if (kept == nullptr) kept = std::make_shared<Buffer<Contact>>();
        return {kept, contacts.data()};
    }
    /// To be called before contacts are written anew: those that somebody keeps move out, without a
    /// copy.
    void leave_contacts() {
        if (kept != nullptr && kept.use_count() > 1) {
            *kept = std::move(contacts);
            contacts = {};
        }
        kept.reset();
        // Another thread may have been the last one that kept them: it has read them before.
        std::atomic_thread_fence(std::memory_order_acquire);
    }

    /// What vertices, patches and blocks remember.
    RecordsView of_vertices() const {
        return {view_of(blocks), view_of(patches), view_of(vertices)};
    }

    /// Clears what stages that cast rays remember.
    void forget_rays() {
        directed.clear();
        blocks.clear();
        patches.clear();
        vertices.clear();
        contact_keys.clear();
        ages.clear();
        contacts.clear();
    }

    void save(const E& executor, StepMemory& m) const {
        m.by_world = by_world;
        m.pair_keys = executor.download(pair_keys);
        m.identities = executor.download(identities);
        m.bodies = executor.download(bodies);
        m.directed = executor.download(directed);
        m.blocks = executor.download(blocks);
        m.patches = executor.download(patches);
        m.vertices = executor.download(vertices);
        m.contact_keys = executor.download(contact_keys);
        m.ages = executor.download(ages);
        if (!m.directed.empty()) m.contacts = executor.download(contacts);
    }

    void restore(E& executor, const StepMemory& m) {
        const auto take = [&]<class Item>(const std::vector<Item>& from, Buffer<Item>& to) {
            executor.upload(std::span<const Item>(from), to);
        };
        by_world = m.by_world;
        take(m.pair_keys, pair_keys);
        take(m.identities, identities);
        take(m.bodies, bodies);
        take(m.directed, directed);
        take(m.blocks, blocks);
        take(m.patches, patches);
        take(m.vertices, vertices);
        take(m.contact_keys, contact_keys);
        take(m.ages, ages);
        take(m.contacts, contacts);
    }
};

/// Of deforming bodies, per block.
template <Executor E>
struct BoundsLists {
    template <class Item>
    using Buffer = typename E::template Buffer<Item>;

    Buffer<stages::Moments> moments;
    Buffer<stages::PartBounds> blocks;
};

/// Pairs, and how they are found.
template <Executor E>
struct PairLists {
    template <class Item>
    using Buffer = typename E::template Buffer<Item>;

    Buffer<std::uint64_t> body_keys;  ///< bodies by where their boxes begin
    Buffer<stages::SweepItem> sweep;
    Buffer<std::uint64_t> box_keys;  ///< pairs whose boxes overlap along all axes
    Buffer<Pair> pairs;
    Buffer<std::uint32_t> links;  ///< per pair, which of the last step's pairs it was
    Buffer<std::uint32_t> marks;  ///< per pair (PairMarks); empty if nobody asks for them
    Buffer<std::uint32_t> deep;   ///< likewise, two per pair
    Buffer<std::uint32_t> depth;  ///< likewise, of steps with margins
};

/// Vertices that may be inside, by blocks and patches.
template <Executor E>
struct CullLists {
    template <class Item>
    using Buffer = typename E::template Buffer<Item>;

    Buffer<stages::DirectedPair> directed;
    Buffer<std::uint32_t> block_offsets;  ///< per directed pair, where its blocks begin
    Buffer<stages::CullItem> blocks, patches;
};

/// Which rays are walks and which go through trees; and proofs that some vertices need none.
template <Executor E>
struct RouteLists {
    template <class Item>
    using Buffer = typename E::template Buffer<Item>;

    Buffer<Route> routes;  ///< per ray
    Buffer<Found> found;   ///< per ray that was walked
    Buffer<std::uint32_t> walks, full;
    Buffer<stages::WalkCount> counts;  ///< per walk
    Buffer<Ray> full_rays;
    Buffer<Hit> full_hits;
    Buffer<std::uint32_t> uncertain;  ///< of the full rays, those for which a proof is tried
};

/// Rays from bodies into themselves.
template <Executor E>
struct ExitLists {
    template <class Item>
    using Buffer = typename E::template Buffer<Item>;

    Buffer<Ray> rays;
    Buffer<Hit> hits;
    Buffer<std::uint32_t> starts_inside;

    void clear() {
        rays.clear();
        hits.clear();
        starts_inside.clear();
    }
};

/// The sums of a step.
template <Executor E>
struct StepSums {
    template <class Value>
    using Sum = typename E::template Sum<Value>;

    Sum<stages::ContactSums> contacts, sheet_contacts;
    Sum<stages::WalkSums> walks;
    Sum<std::uint32_t> hits{}, own_rays{}, skipped{}, looked{}, predicted{}, full_passes{},
        proofs{};
};

}  // namespace pierce
