#include "fuzz/judge.hpp"

#include <algorithm>
#include <exception>
#include <map>
#include <set>

#include "fuzz/invariants.hpp"
#include "fuzz/model.hpp"
#include "pierce/error.hpp"

namespace pierce::fuzz {
namespace {

/// What two lists of contacts have to have in common.
enum class Alike { in_all, but_for_how_found, but_for_history };

bool are_alike(Contact a, Contact b, Alike alike) {
    if (alike == Alike::but_for_history) a.age = b.age = 0;
    if (alike != Alike::in_all) {
        for (Contact* c : {&a, &b})
            if (c->found == Found::walk || c->found == Found::prediction) c->found = Found::full;
    }
    const auto bits = [](const Contact& c) {
        return std::tuple(c.a, c.b, c.source, c.grazing, c.found, c.reprojected, c.of_sheet,
                          c.unknown_side, c.vertex, c.edge_end, c.edge, c.chord, c.other_edge,
                          c.triangle, c.age);
    };
    const auto numbers = [](const Contact& c) {
        return std::array{c.along,          c.time,           c.distance,  c.barycentric[0],
                          c.barycentric[1], c.barycentric[2], c.point_a.x, c.point_a.y,
                          c.point_a.z,      c.point_b.x,      c.point_b.y, c.point_b.z,
                          c.normal.x,       c.normal.y,       c.normal.z,  c.face_normal.x,
                          c.face_normal.y,  c.face_normal.z};
    };
    const auto same = [](double x, double y) { return x == y || (x != x && y != y); };
    return bits(a) == bits(b) && std::ranges::equal(numbers(a), numbers(b), same);
}

/// The first difference of two lists in words; nothing if there is none.
std::optional<std::string> difference(std::span<const Contact> a, std::span<const Contact> b,
                                      Alike alike) {
    for (std::size_t i = 0; i < std::max(a.size(), b.size()); ++i) {
        const auto text = [&](std::span<const Contact> all) {
            return i < all.size() ? to_text(all[i]) : "nothing";
        };
        if (i >= a.size() || i >= b.size() || !are_alike(a[i], b[i], alike))
            return std::to_string(a.size()) + " and " + std::to_string(b.size()) +
                   " contacts, of which number " + std::to_string(i) + " is\n    " + text(a) +
                   "\nand\n    " + text(b);
    }
    return std::nullopt;
}

class Judge {
public:
    Judge(const Program& program, const std::vector<test::NamedBackend>& backends,
          JudgeCounts& counts)
        : program_(program), backends_(backends), counts_(counts), model_(program.settings) {}

    std::optional<Failure> run() {
        ++counts_.worlds;
        if (!make_players()) return failure_;
        for (at_ = 0; at_ < program_.calls.size() && !failure_; ++at_) play(program_.calls[at_]);
        return failure_;
    }

private:
    void fail(const std::string& kind, const std::string& text) {
        if (failure_) return;
        const std::string call = at_ < program_.calls.size() ? name_of(program_.calls[at_].kind)
                                                             : "no";
        failure_ = {kind, "call " + std::to_string(at_) + " (" + call + "): " + text};
    }

    /// True if there is a world to play on.
    bool make_players() {
        std::size_t refused = 0;
        for (const test::NamedBackend& backend : backends_) try {
                players_.emplace_back(backend.make, program_.settings, pool_);
            } catch (const InputError&) {
                ++refused;
            }
        if (refused > 0 && refused < backends_.size())
            fail("backends differ in what they refuse", "settings");
        return refused == 0;
    }

    void play(const Call& call) {
        ++counts_.calls;
        std::vector<Player::Outcome> outcomes;
        for (std::size_t i = 0; i < players_.size(); ++i) try {
                outcomes.push_back(players_[i].play(call));
            } catch (const std::exception& error) {
                return fail("an exception that is not InputError",
                            backends_[i].name + ": " + error.what());
            }
        const bool asks_of_last_step = call.kind == Call::Kind::explain ||
                                       call.kind == Call::Kind::cast_rays ||
                                       call.kind == Call::Kind::probe;
        for (std::size_t i = 1; i < players_.size(); ++i) {
            if (asks_of_last_step && restored_.contains(i)) continue;  // it has none
            if (outcomes[i].refused != outcomes[0].refused ||
                (outcomes[i].text != outcomes[0].text &&
                 !(call.kind == Call::Kind::explain && remembers_less(i))))
                return fail("backends differ in what a call answers",
                            backends_[0].name + ": " + outcomes[0].text + "\n" + backends_[i].name +
                                ": " + outcomes[i].text);
        }
        if (call.kind == Call::Kind::detect) restored_.clear();
        if (outcomes[0].refused) {
            ++counts_.refused;
            return model_.skip(call);
        }
        if (call.kind == Call::Kind::restore) restore();
        if (call.kind == Call::Kind::detect) look_at_step();
        model_.apply(call, players_[0]);
        if (call.kind == Call::Kind::forget_sides) knows_sides_ = false;
    }

    /// Every second world goes on as another backend has saved it; the others must not notice that
    /// they were saved.
    void restore() {
        for (std::size_t i = 1; i < players_.size(); i += 2) try {
                if (remembers_less(i) || remembers_less(i - 1)) continue;
                players_[i].restore(players_[i - 1].save());
                restored_.insert(i);
            } catch (const std::exception& error) {
                return fail("a saved world is restored", backends_[i].name + ": " + error.what());
            }
    }

    /// True for a backend on which certificates do not pay: it casts rays where others have a
    /// proof, or walk.
    bool remembers_less(std::size_t player) {
        return players_[player].world().plan().settings.temporal !=
               players_[0].world().plan().settings.temporal;
    }

    void look_at_step() {
        const std::span<const Contact> contacts = players_[0].world().contacts();
        ++counts_.steps;
        counts_.contacts += contacts.size();
        for (std::size_t i = 1; i < players_.size(); ++i)
            if (const auto text = difference(
                    contacts, players_[i].world().contacts(),
                    remembers_less(i) ? Alike::but_for_how_found : Alike::in_all))
                return fail("backends differ",
                            backends_[0].name + " and " + backends_[i].name + ": " + *text);
        if (const auto broken = broken_invariant(model_, contacts))
            return fail(broken->kind, broken->text);
        if (program_.settings.temporal != Temporal::paper && !knows_sides_) {
            compare_with_fresh(contacts);
            compare_with_worlds_alone(contacts);
        }
        if (failure_) return;
        if (const auto wrong = contradicted_by_truth(model_, contacts, counts_.oracle))
            return fail(wrong->kind, wrong->text);
        knows_sides_ = std::ranges::any_of(
            contacts, [](const Contact& c) { return c.of_sheet && !(c.distance > 0); });
    }

    /// What a step remembers never changes its contacts: a new world in the same state, which
    /// remembers nothing, has the same. But for the paper's mode, and for the sides of sheets that
    /// touch something or are through it.
    void compare_with_fresh(std::span<const Contact> contacts) {
        Player fresh = model_.fresh(backends_[0].make, Temporal::off, pool_);
        const std::vector<Contact> expected = contacts_of(fresh, model_.bodies());
        if (const auto text = difference(contacts, expected, Alike::but_for_history))
            fail("history changes contacts", "world and fresh world: " + *text);
    }

    /// Each world's contacts are those of a world without worlds that has its bodies and those in
    /// all worlds.
    void compare_with_worlds_alone(std::span<const Contact> contacts) {
        const WorldOffsets offsets = players_[0].world().world_offsets();
        if (offsets.worlds != model_.worlds())
            return fail("worlds are those that bodies are in", "world_offsets()");
        std::set<BodyId> in_all;
        for (const ModelBody* b : model_.bodies())
            if (b->filter.world == all_worlds) in_all.insert(b->id);
        for (std::size_t i = 0; i < offsets.worlds.size(); ++i) {
            std::vector<Contact> own;
            for (const auto* begins : {&offsets.solids, &offsets.sheets})
                own.insert(own.end(), contacts.begin() + (*begins)[i],
                           contacts.begin() + (*begins)[i + 1]);
            std::vector<Contact> expected;
            if (model_.is_active(offsets.worlds[i])) {
                std::vector<const ModelBody*> bodies;
                Player alone = model_.alone(offsets.worlds[i], backends_[0].make, Temporal::off,
                                            pool_, bodies);
                expected = contacts_of(alone, bodies);
                std::erase_if(expected, [&](const Contact& c) {
                    return in_all.contains(c.a) && in_all.contains(c.b);
                });
            }
            if (const auto text = difference(own, expected, Alike::but_for_history))
                return fail("a world in a world has the contacts that it has alone",
                            "world " + std::to_string(offsets.worlds[i]) + ": " + *text);
        }
    }

    /// After a step; with the handles of `bodies`, which are those of the player's, in that order.
    static std::vector<Contact> contacts_of(Player& player,
                                            const std::vector<const ModelBody*>& bodies) {
        player.world().detect();
        std::map<BodyId, BodyId> id;
        for (std::size_t i = 0; i < bodies.size(); ++i) id[player.bodies()[i]] = bodies[i]->id;
        std::vector<Contact> contacts(player.world().contacts().begin(),
                                      player.world().contacts().end());
        for (Contact& c : contacts) {
            c.a = id[c.a];
            c.b = id[c.b];
        }
        return contacts;
    }

    const Program& program_;
    const std::vector<test::NamedBackend>& backends_;
    JudgeCounts& counts_;
    std::shared_ptr<MeshPool> pool_ = std::make_shared<MeshPool>();
    Model model_;
    std::vector<Player> players_;
    std::set<std::size_t> restored_;  ///< since the last step
    bool knows_sides_ = false;        ///< of sheets that touch something or are through it
    std::size_t at_ = 0;
    std::optional<Failure> failure_;
};

}  // namespace

JudgeCounts& JudgeCounts::operator+=(const JudgeCounts& o) {
    for (const auto member : {&JudgeCounts::worlds, &JudgeCounts::steps, &JudgeCounts::contacts,
                              &JudgeCounts::calls, &JudgeCounts::refused})
        this->*member += o.*member;
    oracle += o.oracle;
    return *this;
}

std::optional<Failure> judge(const Program& program,
                             const std::vector<test::NamedBackend>& backends, JudgeCounts& counts) {
    return Judge(program, backends, counts).run();
}

}  // namespace pierce::fuzz
