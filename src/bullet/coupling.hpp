#pragma once

#include <BulletSoftBody/btSoftBody.h>

#include <cstdint>
#include <optional>
#include <span>
#include <unordered_map>
#include <vector>

#include "bullet/pair_algorithm.hpp"
#include "pierce/parting.hpp"
#include "pierce/world.hpp"

namespace pierce::bullet {

/// A Bullet object bound to a body, and where it was when contacts were last looked for.
struct Binding {
    btCollisionObject* object = nullptr;
    btSoftBody* soft = nullptr;  ///< the object, if it is soft
    BodyId body;
    std::optional<btTransform> place;     ///< of one that is not soft
    std::vector<Vec3f> positions;         ///< of a soft one
    std::vector<btSoftBody::Face> faces;  ///< by triangle; contacts keep their addresses
    bool takes_contacts = true;  ///< of a soft one: nothing in its arrays is of an earlier step
    std::uint64_t moved_in = 0;  ///< the last detection that found it elsewhere
    MeshId judged;               ///< the mesh of which `is_convex` is true or not
    bool is_convex = false;
};

/// Bullet's objects and the bodies they are bound to: places go to the World, contacts come back.
class Coupling {
public:
    Coupling(World& contacts, std::uint32_t most_per_pair)
        : world_(contacts), most_per_pair_(most_per_pair) {}

    World& world() { return world_; }
    /// Ends what bound the object or the body before.
    void bind(btCollisionObject& object, btSoftBody* soft, BodyId body);
    /// The object is not looked at; it may be gone.
    void unbind(const btCollisionObject* object);
    /// Empties the contact arrays of soft bodies, which may point to what was unbound.
    void forget_soft_contacts();
    static void forget_soft_contacts_of(std::span<const Binding> some);
    Binding* find(const btCollisionObject* object);

    /// True if the object is not where contacts were last looked for.
    static bool has_moved(const Binding& binding);
    bool any_has_moved() const;
    /// True if it has moved since the begin of the step before this one.
    bool has_moved_lately(const Binding& binding) const {
        return has_moved(binding) || binding.moved_in > lately_;
    }
    /// Looks for contacts of all bodies, where Bullet has them.
    void detect();
    /// The bodies that are fast (InstallOptions::continuous), and where Bullet takes them next.
    std::vector<PoseAhead> going_fast() const;
    /// Looks for what such bodies meet on their way, after detect().
    void look_ahead(std::span<const PoseAhead> fast);
    /// Notes which soft bodies Bullet has emptied the contact arrays of, as it does for those that
    /// are awake. To be called before anything in a step gets contacts.
    void begin_step();

    /// Gives Bullet the contacts of two bound objects. `algorithm` is what Bullet keeps of them.
    void write(PairAlgorithm& algorithm, Binding& a, Binding& b);
    /// Gives Bullet the contacts of soft bodies with themselves.
    void write_self();
    /// The last contacts in which a soft body takes part and both bodies are bound.
    std::vector<Contact> soft_contacts() const;

    /// The number of contacts of pairs that reached Bullet's solver (PairAlgorithm).
    std::uint32_t& written() { return written_; }
    std::uint32_t written_self() const { return written_self_; }

private:
    struct Range {
        std::size_t begin = 0, end = 0;
    };
    static std::uint64_t key(BodyId a, BodyId b) { return std::uint64_t{a.index} << 32 | b.index; }
    void index_contacts();
    std::span<const Contact> contacts_of(BodyId a, BodyId b);
    std::span<const ImpactContact> impacts_of(BodyId a, BodyId b) const;
    ContactSide side(const Binding& binding);
    std::uint32_t write_soft(Binding& a, Binding& b, std::span<const Contact> contacts);
    bool is_convex(Binding& binding) const;
    std::optional<Parting> way_apart(Binding& a, Binding& b, std::span<const Contact> contacts);

    World& world_;
    std::uint32_t most_per_pair_;
    std::vector<Binding> bindings_;
    std::unordered_map<const btCollisionObject*, std::size_t> by_object_;
    std::unordered_map<BodyId, std::size_t> by_body_;
    std::span<const Contact> indexed_;                  ///< World::contacts() as they were then
    std::unordered_map<std::uint64_t, Range> by_pair_;  ///< places there
    bool is_indexed_ = false;                           ///< since the step began
    std::vector<Vec3f> moved_;                          ///< positions on their way to the world
    std::vector<ImpactContact> impacts_;                ///< sorted by (a, b)
    std::uint64_t detections_ = 0, begun_at_ = 0, lately_ = 0;  ///< see Binding::moved_in
    std::uint32_t written_ = 0, written_self_ = 0;
};

}  // namespace pierce::bullet
