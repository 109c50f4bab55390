#include "core/step/memory_check.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/body/body_view.hpp"
#include "core/device/view.hpp"
#include "core/mesh/mesh_view.hpp"
#include "core/mesh/patch.hpp"
#include "core/step/common/contact_keys.hpp"
#include "core/step/common/pairs.hpp"
#include "core/step/common/records.hpp"
#include "core/step/solids/vertex_cull.hpp"
#include "pierce/error.hpp"

namespace pierce {
namespace {

void require(bool holds) {
    if (!holds) throw InputError("a saved world's memory of its last step does not fit its bodies");
}

/// Requires that the `count` places from `first` on lie in a list of `size` items.
void require_range(std::uint32_t first, std::uint32_t count, std::size_t size) {
    require(first <= size && count <= size - first);
}

class Checker {
public:
    Checker(const StepMemory& memory, View<const BodyView> bodies, View<const BodyId> ids,
            const std::function<const MeshView*(std::uint64_t key)>& mesh_with)
        : memory_(memory),
          bodies_(bodies),
          ids_(ids),
          mesh_with_(mesh_with),
          as_keys_{memory.by_world} {}

    /// A remembered pair, and its two bodies as they were; not known if it cannot be again.
    struct Known {
        Pair pair;
        BodyView a, b;
        bool is_known = false;

        const BodyView& source(std::uint32_t side) const { return side == 0 ? a : b; }
        const BodyView& target(std::uint32_t side) const { return side == 0 ? b : a; }
    };
    Known known(std::uint64_t pair) const {
        require(pair < memory_.pair_keys.size());
        const Pair p = as_keys_.pair(memory_.pair_keys[pair]);
        const PairIdentity& was = memory_.identities[pair];
        if (p.a >= bodies_.size || p.b >= bodies_.size) return {};
        if (!ids_[p.a] || !ids_[p.b] || was.a != ids_[p.a] || was.b != ids_[p.b]) return {};
        Known known{.pair = p, .a = bodies_[p.a], .b = bodies_[p.b]};
        known.is_known = take_mesh(was.mesh_a, known.a) && take_mesh(was.mesh_b, known.b);
        known.a.collision.self = was.self_a;
        known.b.collision.self = was.self_b;
        known.a.collision.sheet = was.sheet_a;
        known.b.collision.sheet = was.sheet_b;
        return known;
    }

    void run() const {
        const std::size_t pairs = memory_.pair_keys.size();
        require(pairs <= stages::no_pair / 2 && memory_.identities.size() == pairs);
        require(std::ranges::is_sorted(memory_.pair_keys));
        require(memory_.directed.empty() || memory_.directed.size() == 2 * pairs);
        require(memory_.ages.size() == memory_.contact_keys.size());
        // Contacts of pairs in which nothing moves are taken over.
        require(memory_.contacts.size() == memory_.contact_keys.size() ||
                (memory_.contacts.empty() && memory_.directed.empty()));
        require(std::ranges::is_sorted(memory_.contact_keys));
        require(memory_.sheet_records.size() == memory_.sheet_keys.size());
        require(std::ranges::is_sorted(memory_.sheet_keys));
        require(memory_.deepest.empty() || memory_.deepest.size() == pairs);
        require(memory_.sheet_bits <= 32);
        if (!memory_.directed.empty())
            for (std::uint32_t i = 0; i < 2 * pairs; ++i) check_directed(i);
        for (std::size_t i = 0; i < memory_.contacts.size(); ++i) check_contact(i);
        for (std::size_t i = 0; i < memory_.sheet_records.size(); ++i) check_sheet_record(i);
    }

private:
    /// Gives a body the mesh of that key; false if there is none.
    bool take_mesh(std::uint64_t key, BodyView& body) const {
        if (body.mesh_key == key) return true;
        const MeshView* const mesh = mesh_with_(key);
        if (mesh != nullptr) body.mesh = *mesh;
        return mesh != nullptr;
    }

    void check_directed(std::uint32_t i) const {
        const Known k = known(i / 2);
        if (!k.is_known) return;
        const BodyView &source = k.source(i % 2), &target = k.target(i % 2);
        const PairMemory& m = memory_.directed[i];
        // Of bodies that stay where they are, both directions go on or neither.
        const bool rigid = source.motion != Motion::deforming && target.motion != Motion::deforming;
        const double limit = rigid ? std::min(source.mesh.box.extent(), target.mesh.box.extent())
                                   : std::numeric_limits<double>::infinity();
        require((m.odometer == 0 || (m.odometer > 0 && m.odometer < limit)) && m.step >= 0 &&
                std::isfinite(m.step) && std::isfinite(m.at_full));
        if (!stages::is_asked(source, target, k.pair.is_self(), i % 2)) return;
        const std::uint32_t first = m.first_block, count = block_count(source.mesh);
        require_range(first, count, memory_.blocks.size());
        for (std::uint32_t b = 0; b < count; ++b) {
            const BlockRecord& block = memory_.blocks[first + b];
            require((block.kept & ~stages::first_bits(block_length(source.mesh, b))) == 0);
            require_range(block.first_patch, bit_count(block.kept), memory_.patches.size());
            std::uint32_t place = block.first_patch;
            for (std::uint32_t left = block.kept; left != 0; left &= left - 1, ++place)
                check_patch(memory_.patches[place],
                            patch_length(source.mesh, b * constants::block_size + lowest_bit(left)),
                            target.mesh);
        }
    }

    void check_patch(const PatchRecord& patch, std::uint32_t length, const MeshView& target) const {
        require((patch.mask & ~stages::first_bits(length)) == 0);
        require_range(patch.first_vertex, bit_count(patch.mask), memory_.vertices.size());
        for (std::uint32_t k = 0; k < bit_count(patch.mask); ++k) {
            const VertexRecord& record = memory_.vertices[patch.first_vertex + k];
            require(record.triangle == no_triangle ||
                    (record.triangle < target.triangles.size &&
                     record.seen_triangle < target.triangles.size));
        }
    }

    void check_contact(std::size_t i) const {
        const Contact& c = memory_.contacts[i];
        const Known k = known(ContactKey::pair_of(memory_.contact_keys[i]));
        if (!k.is_known) return;
        require(c.a == ids_[k.pair.a] && c.b == ids_[k.pair.b]);
        const auto side = static_cast<std::uint32_t>(c.source);
        const MeshView &source = k.source(side).mesh, &target = k.target(side).mesh;
        require(c.vertex < source.positions.size && c.triangle < target.triangles.size);
        require(!c.is_edge() || (c.edge_end < source.positions.size && c.edge < source.edges.size));
    }

    void check_sheet_record(std::size_t i) const {
        const SheetKey sheet_key{memory_.sheet_bits};
        const Known k = known(sheet_key.pair_of(memory_.sheet_keys[i]));
        if (!k.is_known) return;
        const FeatureKind kind = sheet_key.kind_of(memory_.sheet_keys[i]);
        const SheetRecord& record = memory_.sheet_records[i];
        require(record.side >= -1 && record.side <= 1);
        if (kind == FeatureKind::vertex_of_a) require(record.other < k.b.mesh.triangles.size);
        if (kind == FeatureKind::vertex_of_b) require(record.other < k.a.mesh.triangles.size);
    }

    const StepMemory& memory_;
    View<const BodyView> bodies_;
    View<const BodyId> ids_;
    const std::function<const MeshView*(std::uint64_t key)>& mesh_with_;
    stages::PairKeys as_keys_;
};

}  // namespace

void check(StepMemory& memory, View<const BodyView> bodies, View<const BodyId> ids,
           const std::function<const MeshView*(std::uint64_t key)>& mesh_with) {
    const Checker checker(memory, bodies, ids, mesh_with);
    checker.run();
    for (std::uint64_t pair = 0; pair < memory.pair_keys.size(); ++pair)
        if (!checker.known(pair).is_known) memory.identities[pair] = {};
}

}  // namespace pierce
