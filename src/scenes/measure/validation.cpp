#include "scenes/measure/validation.hpp"

#include <algorithm>
#include <cmath>
#include <set>
#include <tuple>
#include <utility>

#include "pierce/contact_hash.hpp"
#include "pierce/error.hpp"
#include "pierce/reference_backends.hpp"
#include "pierce/world.hpp"
#include "scenes/detect/detector.hpp"

namespace pierce::scenes {
namespace {

/// The order of contact lists.
auto place_of(const Contact& c) {
    return std::tuple(c.a.index, c.b.index, c.source, c.is_edge(), c.is_edge() ? c.edge : c.vertex,
                      c.chord);
}

bool same(const Contact& a, const Contact& b) {
    return contact_hash({&a, 1}) == contact_hash({&b, 1});
}

std::vector<Contact> of_pair(std::span<const Contact> contacts, BodyPair pair) {
    std::vector<Contact> list;
    std::ranges::copy_if(contacts, std::back_inserter(list),
                         [&](const Contact& c) { return BodyPair(c.a.index, c.b.index) == pair; });
    return list;
}

}  // namespace

std::vector<ContactDifference> differences(std::span<const Contact> found,
                                           std::span<const Contact> right) {
    std::vector<ContactDifference> result;
    std::size_t f = 0, r = 0;
    while (f < found.size() || r < right.size()) {
        if (r == right.size() || (f < found.size() && place_of(found[f]) < place_of(right[r]))) {
            result.push_back({found[f++], std::nullopt});
        } else if (f == found.size() || place_of(right[r]) < place_of(found[f])) {
            result.push_back({std::nullopt, right[r++]});
        } else {
            if (!same(found[f], right[r])) result.push_back({found[f], right[r]});
            ++f;
            ++r;
        }
    }
    return result;
}

bool Judgement::is_near_tie(const ContactDifference& difference) const {
    const std::optional<Contact>& right = difference.right;
    return std::ranges::any_of(moved, [&](const std::vector<Contact>& list) {
        const auto at = std::ranges::find(list, place_of(difference.subject()), place_of);
        return (at != list.end()) != right.has_value() ||
               (right && at->triangle != right->triangle);
    });
}

struct Judge::State {
    const Recording& recording;
    std::uint32_t every;
    World world;
    std::vector<MeshId> meshes;

    State(const Recording& frames, const Settings& settings, std::uint32_t stride)
        : recording(frames), every(stride), world(reference_backend(), settings) {
        for (const SceneMesh& mesh : recording.meshes)
            meshes.push_back(world.add_mesh(mesh.name, mesh.data, {.inside = mesh.inside}));
    }

    /// A body of the recording while it is in the world.
    struct Actor {
        State& state;
        std::uint32_t index;
        const RecordedBody& recorded = state.recording.bodies[index];
        BodyId id = add();

        Actor(State& judge_state, std::uint32_t body) : state(judge_state), index(body) {}
        Actor(const Actor&) = delete;
        ~Actor() { state.world.remove_body(id); }

        bool deforms() const { return recorded.motion == Motion::deforming; }

        BodyId add() {
            const MeshId mesh = state.meshes[recorded.mesh];
            if (deforms()) return state.world.add_deforming_body(mesh);
            return recorded.motion == Motion::fixed ? state.world.add_fixed_body(mesh)
                                                    : state.world.add_rigid_body(mesh);
        }

        void put(std::uint32_t frame, Vec3d shift = {}) {
            if (!deforms()) {
                Pose pose = state.recording.pose(index, frame);
                pose.position += shift;
                return state.world.set_pose(id, pose);
            }
            const std::span<const Vec3f> there = state.recording.positions(index, frame);
            std::vector<Vec3f> positions(there.begin(), there.end());
            for (Vec3f& p : positions) p = to_float(to_double(p) + shift);
            const MeshId mesh = state.meshes[state.recording.mesh_of(index, frame)];
            if (state.world.mesh_of(id) != mesh) state.world.set_mesh(id, mesh, positions);
            state.world.set_positions(id, positions);
        }

        /// Takes the steps before `frame` with this body alone. The fit of a deforming body depends
        /// on the steps before, and the last digit of where a part of an edge begins depends on the
        /// fit.
        void follow(std::uint32_t frame) {
            for (std::uint32_t f = 0; deforms() && f < frame; f += state.every) {
                put(f);
                state.world.detect();
            }
        }

        /// Leaves the body out of the next steps.
        void hide() {
            if (!deforms())
                return state.world.set_pose(id, {.position = {std::nan(""), 0, 0}, .rotation = {}});
            const Vec3f nowhere{std::nanf(""), 0, 0};
            state.world.set_positions(
                id, std::vector<Vec3f>(state.world.mesh(state.world.mesh_of(id)).positions().size(),
                                       nowhere));
        }
    };

    /// Contacts of the two bodies where they are now; the world holds no others.
    std::vector<Contact> detect(BodyPair pair) {
        world.detect();
        std::vector<Contact> list(world.contacts().begin(), world.contacts().end());
        for (Contact& c : list) {
            c.a = {pair.first, 1};
            c.b = {pair.second, 1};
        }
        return list;
    }
};

Judge::Judge(const Recording& recording, Settings settings, std::uint32_t every) {
    settings.temporal = Temporal::off;
    state_ = std::make_unique<State>(recording, settings, every);
}

Judge::~Judge() = default;

Judgement Judge::judge(std::uint32_t frame, std::uint32_t a, std::uint32_t b) {
    State& s = *state_;
    State::Actor first(s, a);
    first.follow(frame);
    first.hide();
    State::Actor second(s, b);
    second.follow(frame);
    first.put(frame);
    second.put(frame);
    Judgement judgement;
    judgement.contacts = s.detect({a, b});
    double touch = 0;
    for (const World::BodyBox& body : s.world.body_boxes())
        touch = std::max(touch, constants::touch_tolerance * body.box.extent());
    for (int k = 0; k < 6; ++k) {
        Vec3d shift;
        shift[k / 2] = k % 2 == 0 ? touch : -touch;
        second.put(frame, shift);
        judgement.moved[static_cast<std::size_t>(k)] = s.detect({a, b});
    }
    return judgement;
}

namespace {

/// Notes where a candidate's list differs from the right one, and whether that is a near tie.
template <class IsNearTie>
bool note_wrong(std::uint32_t frame, std::uint32_t candidate, std::span<const Contact> list,
                std::span<const Contact> right, const IsNearTie& is_near_tie,
                Validation& validation) {
    Validation::Result& result = validation.results[candidate];
    const std::vector<ContactDifference> found = differences(list, right);
    for (const ContactDifference& difference : found) {
        const bool near_tie = is_near_tie(difference);
        validation.wrong.push_back({.frame = frame,
                                    .candidate = candidate,
                                    .difference = difference,
                                    .near_tie = near_tie});
        result.near_ties += near_tie;
    }
    result.wrong_contacts += static_cast<std::uint32_t>(found.size());
    return !found.empty();
}

/// Lets the judge decide about the pairs for which the lists differ, and notes what is wrong in
/// which list.
void judge_frame(Judge& judge, std::uint32_t frame, std::span<const std::span<const Contact>> lists,
                 Validation& validation) {
    std::set<BodyPair> disputed;
    for (const std::span<const Contact>& list : lists.subspan(1))
        for (const ContactDifference& d : differences(list, lists[0]))
            disputed.emplace(d.subject().a.index, d.subject().b.index);
    std::set<std::uint32_t> wrong;
    for (const auto& [a, b] : disputed) {
        const Judgement right = judge.judge(frame, a, b);
        const auto is_near_tie = [&](const ContactDifference& d) { return right.is_near_tie(d); };
        for (std::uint32_t c = 0; c < lists.size(); ++c)
            if (note_wrong(frame, c, of_pair(lists[c], {a, b}), right.contacts, is_near_tie,
                           validation))
                wrong.insert(c);
    }
    for (std::uint32_t c : wrong) ++validation.results[c].wrong_frames;
}

/// The reference on the frames that the candidates get, as far as they are asked for.
class Follower {
public:
    Follower(const Recording& recording, const Settings& settings, std::uint32_t every)
        : recording_(recording),
          every_(every),
          detector_(make_detector(scene_of(recording), reference_backend(), settings)) {}

    /// The right contacts in a frame; frames must be asked for in order.
    std::span<const Contact> contacts_in(std::uint32_t frame) {
        for (; next_ <= frame; next_ += every_) {
            put_frame(*detector_, recording_, next_);
            detector_->detect();
        }
        return detector_->world()->contacts();
    }

private:
    const Recording& recording_;
    std::uint32_t every_, next_ = 0;
    std::unique_ptr<Detector> detector_;
};

void follow_frame(Follower& follower, std::uint32_t frame,
                  std::span<const std::span<const Contact>> lists, Validation& validation) {
    const std::span<const Contact> right = follower.contacts_in(frame);
    for (std::uint32_t c = 0; c < lists.size(); ++c)
        if (note_wrong(
                frame, c, lists[c], right, [](const auto&) { return false; }, validation))
            ++validation.results[c].wrong_frames;
}

}  // namespace

Validation validate(const Recording& recording, std::vector<Candidate> candidates,
                    const Settings& settings, std::uint32_t every,
                    const std::function<void(std::uint32_t)>& progress) {
    if (candidates.size() < 2)
        throw InputError("validation compares backends: it needs two at least");
    if (every == 0) throw InputError("validation looks at every Nth frame: N is 1 at least");
    const SceneSetup scene = scene_of(recording);
    Validation validation;
    std::vector<std::unique_ptr<Detector>> detectors;
    for (Candidate& candidate : candidates) {
        detectors.push_back(make_detector(scene, std::move(candidate.backend), settings));
        Validation::Result& result = validation.results.emplace_back();
        result.name = candidate.name;
        result.description = detectors.back()->world()->backend();
    }
    // Made only when there is something to decide, as both have to make the meshes.
    std::optional<Judge> judge;
    std::optional<Follower> follower;
    for (std::uint32_t f = 0; f < recording.frame_count; f += every) {
        std::set<std::uint64_t> hashes;
        std::vector<std::span<const Contact>> lists;
        for (std::size_t c = 0; c < detectors.size(); ++c) {
            put_frame(*detectors[c], recording, f);
            const FrameResult frame = detectors[c]->detect();
            hashes.insert(frame.hash);
            lists.push_back(detectors[c]->world()->contacts());
            validation.results[c].contacts += lists.back().size();
            validation.results[c].ms.push_back(frame.total_ms);
        }
        ++validation.frames;
        if (hashes.size() > 1) {
            ++validation.differing_frames;
            if (settings.temporal == Temporal::paper) {
                if (!follower) follower.emplace(recording, settings, every);
                follow_frame(*follower, f, lists, validation);
            } else {
                if (!judge) judge.emplace(recording, settings, every);
                judge_frame(*judge, f, lists, validation);
            }
        }
        if (progress) progress(f + 1);
    }
    return validation;
}

}  // namespace pierce::scenes
