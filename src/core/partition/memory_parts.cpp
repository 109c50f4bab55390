#include "core/partition/memory_parts.hpp"

#include <algorithm>
#include <cstddef>
#include <utility>
#include <vector>

#include "core/step/common/contact_keys.hpp"
#include "core/step/common/pairs.hpp"

namespace pierce {
namespace {

constexpr std::uint32_t dropped = 0xffffffffu;

/// Puts pairs of several memories in order, with all that belongs to them.
class MemoryJoiner {
public:
    explicit MemoryJoiner(std::span<const StepMemory> from) : from_(from), moved_(from.size()) {
        for (std::size_t m = 0; m < from.size(); ++m) {
            moved_[m].assign(from[m].contact_keys.size(), dropped);
            joined_.by_world |= from[m].by_world;
            joined_.sheet_bits = std::max(joined_.sheet_bits, from[m].sheet_bits);
        }
    }

    /// Takes over the pairs for which is_wanted(pair), sorted by their keys.
    template <class IsWanted>
    void take_pairs(const IsWanted& is_wanted) {
        std::vector<Place> places;
        for (std::size_t m = 0; m < from_.size(); ++m)
            for (std::size_t p = 0; p < from_[m].pair_keys.size(); ++p)
                if (is_wanted(stages::PairKeys{from_[m].by_world}.pair(from_[m].pair_keys[p])))
                    places.push_back({m, p});
        const auto key = [&](const Place& at) { return from_[at.memory].pair_keys[at.pair]; };
        std::ranges::sort(places, {}, key);
        for (const Place& at : places) take_pair(at);
    }

    /// Takes over what pairs refer to.
    void take_records() {
        for (std::size_t m = 0; m < from_.size(); ++m) {
            const StepMemory& f = from_[m];
            const auto first_patch = static_cast<std::uint32_t>(joined_.patches.size());
            const auto first_vertex = static_cast<std::uint32_t>(joined_.vertices.size());
            for (BlockRecord block : f.blocks) {
                block.first_patch += first_patch;
                joined_.blocks.push_back(block);
            }
            for (PatchRecord patch : f.patches) {
                patch.first_vertex += first_vertex;
                joined_.patches.push_back(patch);
            }
            for (VertexRecord vertex : f.vertices) {
                const std::vector<std::uint32_t>& moved = moved_[m];
                vertex.contact = vertex.contact < moved.size() ? moved[vertex.contact] : no_record;
                joined_.vertices.push_back(vertex);
            }
        }
    }

    StepMemory result() && { return std::move(joined_); }
    StepMemory& joined() { return joined_; }

private:
    struct Place {
        std::size_t memory, pair;
    };

    void take_pair(const Place& at) {
        const StepMemory& f = from_[at.memory];
        const auto here = static_cast<std::uint32_t>(joined_.pair_keys.size());
        joined_.pair_keys.push_back(f.pair_keys[at.pair]);
        joined_.identities.push_back(f.identities[at.pair]);
        if (!f.deepest.empty()) joined_.deepest.push_back(f.deepest[at.pair]);
        if (!f.directed.empty())
            for (std::size_t side = 0; side < 2; ++side) {
                PairMemory directed = f.directed[2 * at.pair + side];
                if (directed.first_block != no_record)
                    directed.first_block += blocks_before(at.memory);
                joined_.directed.push_back(directed);
            }
        take_contacts(at, here);
        take_sheet_records(at, here);
    }

    std::uint32_t blocks_before(std::size_t memory) const {
        std::size_t blocks = 0;
        for (std::size_t m = 0; m < memory; ++m) blocks += from_[m].blocks.size();
        return static_cast<std::uint32_t>(blocks);
    }

    void take_contacts(const Place& at, std::uint32_t here) {
        const StepMemory& f = from_[at.memory];
        for (std::size_t c = first_of(f.contact_keys, at.pair, ContactKey::pair_of);
             c < f.contact_keys.size() && ContactKey::pair_of(f.contact_keys[c]) == at.pair; ++c) {
            moved_[at.memory][c] = static_cast<std::uint32_t>(joined_.contact_keys.size());
            joined_.contact_keys.push_back(ContactKey::in_pair(here, f.contact_keys[c]));
            joined_.ages.push_back(f.ages[c]);
            if (!f.contacts.empty()) joined_.contacts.push_back(f.contacts[c]);
        }
    }

    void take_sheet_records(const Place& at, std::uint32_t here) {
        const StepMemory& f = from_[at.memory];
        const SheetKey before{f.sheet_bits}, now{joined_.sheet_bits};
        const auto pair_of = [&](std::uint64_t key) { return before.pair_of(key); };
        for (std::size_t r = first_of(f.sheet_keys, at.pair, pair_of);
             r < f.sheet_keys.size() && pair_of(f.sheet_keys[r]) == at.pair; ++r) {
            const std::uint64_t key = f.sheet_keys[r];
            joined_.sheet_keys.push_back(now.of(here, before.kind_of(key), before.item_of(key)));
            joined_.sheet_records.push_back(f.sheet_records[r]);
        }
    }

    /// Where the items of a pair begin in a list of keys that begin with the pair.
    template <class PairOf>
    static std::size_t first_of(const std::vector<std::uint64_t>& keys, std::size_t pair,
                                const PairOf& pair_of) {
        return static_cast<std::size_t>(std::ranges::lower_bound(keys, pair, {}, pair_of) -
                                        keys.begin());
    }

    std::span<const StepMemory> from_;
    std::vector<std::vector<std::uint32_t>> moved_;  ///< per memory, where its contacts have gone
    StepMemory joined_;
};

}  // namespace

StepMemory join_memory(std::span<const StepMemory> parts, std::span<const std::uint32_t> owners) {
    MemoryJoiner joiner(parts);
    joiner.take_pairs([](Pair) { return true; });
    joiner.take_records();
    for (std::size_t b = 0; b < owners.size(); ++b) {
        const std::vector<SeenBody>& seen = parts[owners[b]].bodies;
        if (b < seen.size()) {
            joiner.joined().bodies.resize(b + 1);
            joiner.joined().bodies[b] = seen[b];
        }
    }
    return std::move(joiner).result();
}

StepMemory part_of_memory(const StepMemory& all, const std::function<bool(Pair)>& is_here) {
    MemoryJoiner joiner({&all, 1});
    joiner.take_pairs(is_here);
    joiner.take_records();
    joiner.joined().bodies = all.bodies;
    return std::move(joiner).result();
}

}  // namespace pierce
