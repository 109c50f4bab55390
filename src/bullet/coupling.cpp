#include "bullet/coupling.hpp"

#include <algorithm>
#include <cstring>
#include <iterator>
#include <utility>

#include "bullet/foremost.hpp"
#include "bullet/soft_response.hpp"
#include "pierce/bullet/bullet_convert.hpp"
#include "pierce/constants.hpp"

namespace pierce::bullet {
namespace {

/// The triangles of a mesh as Bullet's soft solver wants them. The soft body's own faces need not
/// be those of the mesh's surface.
std::vector<btSoftBody::Face> faces_of(const Mesh& mesh, btSoftBody& soft) {
    std::vector<btSoftBody::Face> faces(mesh.triangles().size());
    for (std::size_t t = 0; t < faces.size(); ++t)
        for (int k = 0; k < 3; ++k)
            faces[t].m_n[k] = &soft.m_nodes[static_cast<int>(mesh.triangles()[t].vertex[k])];
    return faces;
}

}  // namespace

void Coupling::bind(btCollisionObject& object, btSoftBody* soft, BodyId body) {
    unbind(&object);
    if (const auto last = by_body_.find(body); last != by_body_.end())
        unbind(bindings_[last->second].object);
    by_object_[&object] = bindings_.size();
    by_body_[body] = bindings_.size();
    Binding& made = bindings_.emplace_back();
    made.object = &object;
    made.soft = soft;
    made.body = body;
    if (soft != nullptr) made.faces = faces_of(world_.mesh(world_.mesh_of(body)), *soft);
}

void Coupling::unbind(const btCollisionObject* object) {
    const auto found = by_object_.find(object);
    if (found == by_object_.end()) return;
    const std::size_t place = found->second;
    by_object_.erase(found);
    by_body_.erase(bindings_[place].body);
    if (place + 1 != bindings_.size()) {
        // Faces of the other one keep their addresses.
        bindings_[place] = std::move(bindings_.back());
        by_object_[bindings_[place].object] = place;
        by_body_[bindings_[place].body] = place;
    }
    bindings_.pop_back();
}

void Coupling::forget_soft_contacts() { forget_soft_contacts_of(bindings_); }

void Coupling::forget_soft_contacts_of(std::span<const Binding> some) {
    for (const Binding& binding : some) {
        if (binding.soft == nullptr) continue;
        binding.soft->m_rcontacts.resizeNoInitialize(0);
        binding.soft->m_scontacts.resizeNoInitialize(0);
    }
}

Binding* Coupling::find(const btCollisionObject* object) {
    const auto found = by_object_.find(object);
    return found != by_object_.end() ? &bindings_[found->second] : nullptr;
}

bool Coupling::has_moved(const Binding& binding) {
    if (binding.soft == nullptr) return binding.place != binding.object->getWorldTransform();
    if (binding.positions.size() != static_cast<std::size_t>(binding.soft->m_nodes.size()))
        return true;
    for (std::size_t i = 0; i < binding.positions.size(); ++i)
        if (binding.positions[i] !=
            from_bullet_float(binding.soft->m_nodes[static_cast<int>(i)].m_x))
            return true;
    return false;
}

bool Coupling::any_has_moved() const {
    return std::ranges::any_of(bindings_, [](const Binding& b) { return has_moved(b); });
}

void Coupling::detect() {
    ++detections_;
    for (Binding& binding : bindings_) {
        if (!has_moved(binding)) continue;
        // What the world refuses has not moved yet.
        if (binding.soft == nullptr) {
            const btTransform place = binding.object->getWorldTransform();
            world_.set_pose(binding.body, from_bullet(place));
            binding.place = place;
        } else {
            moved_.clear();
            for (int i = 0; i < binding.soft->m_nodes.size(); ++i)
                moved_.push_back(from_bullet_float(binding.soft->m_nodes[i].m_x));
            world_.set_positions(binding.body, moved_);
            std::swap(binding.positions, moved_);
        }
        binding.moved_in = detections_;
    }
    world_.detect();
    is_indexed_ = false;
}

namespace {

/// The most meetings of a pair: what comes flat is held at its corners.
constexpr std::uint32_t most_meetings = 8;

/// True if the object goes further in this step than Bullet's threshold for continuous collisions.
bool is_fast(const Binding& binding) {
    const btScalar threshold = binding.object->getCcdSquareMotionThreshold();
    if (binding.soft != nullptr || !(threshold > 0) || !binding.object->isActive() ||
        binding.object->isStaticOrKinematicObject())
        return false;
    const btVector3 way = binding.object->getInterpolationWorldTransform().getOrigin() -
                          binding.object->getWorldTransform().getOrigin();
    return way.length2() > threshold;
}

}  // namespace

std::vector<PoseAhead> Coupling::going_fast() const {
    std::vector<PoseAhead> fast;
    for (const Binding& binding : bindings_)
        if (is_fast(binding) && world_.motion_of(binding.body) == Motion::rigid)
            fast.push_back(
                {binding.body, from_bullet(binding.object->getInterpolationWorldTransform())});
    return fast;
}

void Coupling::look_ahead(std::span<const PoseAhead> fast) {
    impacts_ = fast.empty() ? std::vector<ImpactContact>{}
                            : world_.impacts_ahead(fast, most_meetings);
}

std::span<const ImpactContact> Coupling::impacts_of(BodyId a, BodyId b) const {
    const auto key_of = [](const ImpactContact& impact) { return key(impact.a, impact.b); };
    const auto range = std::ranges::equal_range(impacts_, key(a, b), {}, key_of);
    return {range.begin(), range.end()};
}

void Coupling::index_contacts() {
    by_pair_.clear();
    const std::span<const Contact> contacts = indexed_ = world_.contacts();
    for (std::size_t begin = 0, end = 0; begin < contacts.size(); begin = end) {
        while (end < contacts.size() && contacts[end].a == contacts[begin].a &&
               contacts[end].b == contacts[begin].b &&
               contacts[end].of_sheet == contacts[begin].of_sheet)
            ++end;
        // A SheetResponse handles sheets.
        if (!contacts[begin].of_sheet)
            by_pair_[key(contacts[begin].a, contacts[begin].b)] = {begin, end};
    }
    is_indexed_ = true;
}

void Coupling::begin_step() {
    lately_ = std::exchange(begun_at_, detections_);
    impacts_.clear();
    // Whoever owns the world may have called detect(); new contacts may lie where the last ones
    // did.
    is_indexed_ = false;
    for (Binding& binding : bindings_)
        if (binding.soft != nullptr)
            binding.takes_contacts = binding.soft->m_rcontacts.size() == 0 &&
                                     binding.soft->m_scontacts.size() == 0;
}

std::span<const Contact> Coupling::contacts_of(BodyId a, BodyId b) {
    const std::span<const Contact> now = world_.contacts();
    if (!is_indexed_ || now.data() != indexed_.data() || now.size() != indexed_.size())
        index_contacts();
    const auto found = by_pair_.find(key(a, b));
    if (found == by_pair_.end()) return {};
    return now.subspan(found->second.begin, found->second.end - found->second.begin);
}

ContactSide Coupling::side(const Binding& binding) {
    return {.object = binding.object,
            .body = binding.body,
            .mesh = &world_.mesh(world_.mesh_of(binding.body))};
}

std::uint32_t Coupling::write_soft(Binding& a, Binding& b, std::span<const Contact> contacts) {
    std::uint32_t count = 0;
    for (const Contact& c : contacts) {
        if (c.distance > 0) continue;  // Bullet's soft contacts know no gap
        Binding& source = c.source == Side::a ? a : b;
        Binding& target = c.source == Side::a ? b : a;
        ++count;
        // Bullet keeps a contact with the body whose nodes it moves first.
        if (!(source.soft != nullptr ? source : target).takes_contacts) continue;
        if (source.soft != nullptr && target.soft != nullptr)
            add_soft_soft(*source.soft, target.faces[c.triangle], *target.soft, c);
        else if (source.soft != nullptr)
            add_soft_rigid(*source.soft, *target.object, c);
        else
            add_rigid_soft(*source.object, target.faces[c.triangle], *target.soft, c);
    }
    return count;
}

namespace {

/// True for a vertex or an edge of a mesh that is near another body, or hardly in it, but whose
/// surroundings come nearer, such as a floor's in front of a box that stands on it: a point there
/// would stop what slides.
bool is_aside(const Contact& contact, const btCollisionObject& source, const MeshView& mesh) {
    const double touch = constants::touch_tolerance * mesh.box.extent();
    if (contact.found != Found::near && contact.penetration_depth() > constants::skin * touch)
        return false;
    const btVector3 out = to_bullet(contact.source == Side::a ? contact.normal : -contact.normal);
    const Vec3d way = from_bullet(out * source.getWorldTransform().getBasis());
    return !(contact.is_edge() ? is_foremost(mesh, contact.vertex, contact.edge_end, way)
                               : is_foremost(mesh, contact.vertex, way));
}

}  // namespace

bool Coupling::is_convex(Binding& binding) const {
    const MeshId mesh = world_.mesh_of(binding.body);
    if (binding.judged != mesh) {
        binding.judged = mesh;
        binding.is_convex = pierce::is_convex(world_.mesh(mesh));
    }
    return binding.is_convex;
}

namespace {

/// Contacts at right angles ask for a way up to 1.8 times as long as the deepest one does.
constexpr double longest_detour = 2;

/// True if contacts lead against each other, or say how far one of the bodies has to go as a whole.
bool are_at_odds(std::span<const Contact> contacts) {
    double deepest = 0;
    for (const Contact& c : contacts) {
        if (c.found == Found::separation) return true;
        deepest = std::max(deepest, c.penetration_depth());
    }
    const std::optional<Parting> way = least_translation(contacts);
    return !way || way->depth > longest_detour * deepest;
}

}  // namespace

/// For convex bodies that are deep in each other. Of other bodies, those that are linked have such
/// contacts, too, and their way apart is long.
std::optional<Parting> Coupling::way_apart(Binding& a, Binding& b,
                                           std::span<const Contact> contacts) {
    if (contacts.empty() || !is_convex(a) || !is_convex(b) || !are_at_odds(contacts))
        return std::nullopt;
    return world_.parting(a.body, b.body);
}

void Coupling::write(PairAlgorithm& algorithm, Binding& first, Binding& second) {
    const bool in_order = first.body.index <= second.body.index;
    Binding &a = in_order ? first : second, &b = in_order ? second : first;
    const std::span<const Contact> contacts = contacts_of(a.body, b.body);
    if (a.soft != nullptr || b.soft != nullptr) {
        algorithm.note_soft(write_soft(a, b, contacts));
        return;
    }
    const std::span<const ImpactContact> impacts = impacts_of(a.body, b.body);
    // Most pairs whose boxes overlap have nothing to write, and had nothing.
    if (contacts.empty() && impacts.empty() && algorithm.has_no_points()) return;
    const MeshView meshes[2] = {world_.mesh(world_.mesh_of(a.body)).view({}),
                                world_.mesh(world_.mesh_of(b.body)).view({})};
    const auto is_left_out = [&](const Contact& c) {
        return c.source == Side::a ? is_aside(c, *a.object, meshes[0])
                                   : is_aside(c, *b.object, meshes[1]);
    };
    std::vector<Contact> others;
    const bool leaves_out = std::ranges::any_of(contacts, is_left_out);
    if (leaves_out) std::ranges::remove_copy_if(contacts, std::back_inserter(others), is_left_out);
    algorithm.write_manifolds(side(a), side(b),
                              leaves_out ? std::span<const Contact>(others) : contacts,
                              most_per_pair_, impacts, way_apart(a, b, contacts));
}

void Coupling::write_self() {
    written_self_ = 0;
    for (Binding& binding : bindings_)
        if (binding.soft != nullptr)
            written_self_ += write_soft(binding, binding, contacts_of(binding.body, binding.body));
}

std::vector<Contact> Coupling::soft_contacts() const {
    std::vector<Contact> result;
    for (const Contact& contact : world_.contacts()) {
        const auto a = by_body_.find(contact.a), b = by_body_.find(contact.b);
        if (contact.of_sheet || a == by_body_.end() || b == by_body_.end()) continue;
        if (bindings_[a->second].soft != nullptr || bindings_[b->second].soft != nullptr)
            result.push_back(contact);
    }
    return result;
}

}  // namespace pierce::bullet
