#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "pierce/ids.hpp"

namespace pierce {

// What steps read and write. The types are defined in core/body, core/trace and core/step, which
// are not installed.
struct BodyView;
struct Box;
struct Certificate;
struct Contact;
struct DeviceContacts;
struct FetchedPlace;
struct Hit;
struct Pair;
struct PlannedPart;
struct Ray;
struct Scene;
struct SeenPatch;
struct StepMemory;
struct StepStats;
template <class T>
struct View;

/// Where steps run: an executor and a tracer behind one interface. A factory makes it
/// (reference_backends.hpp has two, each backend library has one), and a World takes it.
/// docs/new_backend.md says how to write one.
class Backend {
public:
    virtual ~Backend() = default;

    /// The backend's name and how it was made, for people: "embree 3.13.5, 2 threads".
    virtual std::string description() const = 0;
    /// True if steps run where set_device_positions() keeps positions.
    virtual bool runs_on_device() const { return false; }
    /// True if steps can call a PairFilter.
    virtual bool calls_pair_filters() const { return !runs_on_device(); }
    /// What runs where, if several backends share a world; else empty.
    virtual std::vector<PlannedPart> parts() const;
    /// Makes steps wait for what was issued on a stream of the device, and the stream for steps.
    /// Only for backends that run there.
    virtual void set_stream(void* stream);
    /// The last step's contacts in device memory. Only for backends that run there. `part`: the one
    /// of parts() that has found them. `worlds`: how many there are.
    virtual DeviceContacts device_contacts(std::uint32_t part, std::uint32_t worlds);
    /// Measures, for `some` bodies that have their places in device memory, the boxes that they
    /// reach in a step from there (core/body/reach.hpp). `more`: for each of them, how far they
    /// reach beyond their points. `anew`: these lists, or what they name, are not those of the last
    /// call. Returns how much further one of them reaches, at most, than fetch_reach() has told;
    /// infinity if that is not known. Only for backends that run there.
    virtual double measure_reach(View<const BodyView> bodies, View<const std::uint32_t> some,
                                 View<const double> more, bool anew);
    /// Tells what measure_reach() has found. `reach`: of all bodies; others stay as they are.
    virtual void fetch_reach(View<const std::uint32_t> some, View<Box> reach);
    /// Brings the places of some bodies from device memory, one entry each; valid until the next
    /// call. Only for backends that run there.
    virtual View<const FetchedPlace> fetch_places(View<const BodyView> bodies,
                                                  View<const std::uint32_t> some);
    /// False if tracing a ray costs less than proving that it is needless; Temporal::certified is
    /// Temporal::off then.
    virtual bool certificates_pay() const { return true; }
    virtual void step(const Scene& scene, StepStats& stats) = 0;
    /// True if step_at_rest() may stand for a step.
    virtual bool can_rest() const { return false; }
    /// What a step does if nothing has changed since the last step, nor in that one: all contacts
    /// become one step older.
    virtual void step_at_rest() {}
    /// Results of the last step; valid until the next one.
    virtual View<const Contact> contacts() const = 0;
    /// The same contacts, which stay as they are as long as the pointer is there.
    /// Copies them unless overridden.
    virtual std::shared_ptr<const Contact> keep_contacts();
    virtual View<const Pair> pairs() const = 0;
    /// The proof by which a vertex needed no ray in the last step. `side`: which body of the pair
    /// the vertex belongs to.
    virtual Certificate certificate(View<const BodyView> bodies, Pair pair, std::uint32_t side,
                                    std::uint32_t vertex) const = 0;
    /// Brings the world's views of its bodies up to date with what the last step found out about
    /// where the bodies are. Does nothing unless overridden.
    virtual void fetch_bodies(View<BodyView> bodies) const;
    /// Brings Scene::seen, the shapes that deforming bodies had in the last step, up to date. Does
    /// nothing unless overridden.
    virtual void fetch_seen(View<const BodyId> ids, View<const View<SeenPatch>> seen) const;
    /// What the last step keeps for the next one.
    virtual StepMemory memory() const = 0;
    /// Makes `memory` the memory of the last step, whichever backend it was taken from. The caller
    /// must have checked it.
    virtual void remember(const StepMemory& memory) = 0;
    /// Traces rays outside a step, bringing the targets' trees up to date first.
    virtual void closest_hits(View<const BodyView> bodies, View<const Ray> rays,
                              View<Hit> hits) = 0;
};

}  // namespace pierce
