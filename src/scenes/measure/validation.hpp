#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "pierce/backend.hpp"
#include "pierce/contact.hpp"
#include "pierce/settings.hpp"
#include "scenes/recording/recording.hpp"

namespace pierce::scenes {

/// The contacts of the same vertex, or of the same part of an edge, in two lists that differ there;
/// one of the lists may have none.
struct ContactDifference {
    std::optional<Contact> found, right;

    /// The contact that exists: it says which vertex or edge the difference is about.
    // One of the two is there. NOLINTNEXTLINE(bugprone-unchecked-optional-access)
    const Contact& subject() const { return found ? *found : *right; }
};

/// Where two lists in the order of World::contacts() differ, in any bit that contact_hash() sees.
std::vector<ContactDifference> differences(std::span<const Contact> found,
                                           std::span<const Contact> right);

/// The right answer for two bodies.
struct Judgement {
    std::vector<Contact> contacts;
    std::array<std::vector<Contact>, 6> moved;  ///< the contacts with body b moved by the touch
                                                ///< tolerance, in six directions

    /// True if such a move changes the answer to another one, or to another triangle.
    bool is_near_tie(const ContactDifference& difference) const;
};

/// The definition of a right answer, pair by pair: two bodies alone, by brute force, without
/// memory.
class Judge {
public:
    /// The recording must outlive the judge. `every`: the steps that it judges use every so many of
    /// the recording's frames.
    Judge(const Recording& recording, Settings settings, std::uint32_t every);
    ~Judge();

    /// Judges two bodies a < b in a frame.
    Judgement judge(std::uint32_t frame, std::uint32_t a, std::uint32_t b);

private:
    struct State;
    std::unique_ptr<State> state_;
};

/// A backend that takes part in a validation.
struct Candidate {
    std::string name;
    std::unique_ptr<Backend> backend;
};

/// A contact that a candidate has but should not have, lacks but should have, or has with other
/// values.
struct WrongContact {
    std::uint32_t frame = 0;
    std::uint32_t candidate = 0;
    ContactDifference difference;
    bool near_tie = false;  ///< the contact is wrong nevertheless: all backends settle ties by one
                            ///< rule
};

/// The result of a validation.
struct Validation {
    struct Result {
        std::string name, description;
        std::uint64_t contacts = 0;
        std::uint32_t wrong_frames = 0, wrong_contacts = 0, near_ties = 0;
        std::vector<double> ms;  ///< per frame, the whole step
    };
    std::vector<Result> results;  ///< one per candidate
    std::vector<WrongContact> wrong;
    std::uint32_t frames = 0;
    std::uint32_t differing_frames = 0;  ///< frames in which not all lists are the same
};

/// Gives every `every`-th frame to all candidates, in turns. The judge decides about the pairs for
/// which their lists differ. With Temporal::paper, what is right depends on the steps before: the
/// reference, which follows the same frames, decides, and nothing is a near tie. `progress` gets
/// the number of frames that are done. Throws InputError unless there are two candidates at least.
Validation validate(const Recording& recording, std::vector<Candidate> candidates,
                    const Settings& settings, std::uint32_t every = 1,
                    const std::function<void(std::uint32_t)>& progress = {});

}  // namespace pierce::scenes
