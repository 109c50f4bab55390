#pragma once

#include <memory>
#include <string>

#include "pierce/core/explain.hpp"
#include "pierce/core/pipeline.hpp"

namespace pierce {

/// Where steps run: an executor and a tracer behind one door. Made by a factory (reference_backend below, and one per
/// backend library) and handed to a World.
class Backend {
public:
    virtual ~Backend() = default;

    /// What it is and how it was made, for people: "embree 3.13.5, 2 threads".
    virtual std::string description() const = 0;
    /// True if steps run where set_device_positions() keeps positions.
    virtual bool runs_on_device() const { return false; }
    /// False if tracing a ray costs less than proving that it is needless; Temporal::certified is Temporal::off then.
    virtual bool certificates_pay() const { return true; }
    virtual void step(const Scene& scene, StepStats& stats) = 0;
    /// Results of the last step; valid until the next one.
    virtual View<const Contact> contacts() const = 0;
    virtual View<const Pair> pairs() const = 0;
    /// What spared a vertex its ray in the last step. `side`: the pair's body it belongs to.
    virtual Certificate certificate(View<const BodyView> bodies, Pair pair, std::uint32_t side,
                                    std::uint32_t vertex) const = 0;
    /// Brings the world's views of its bodies up to date with what the last step found out about where they are.
    virtual void fetch_bodies(View<BodyView>) const {}
    /// Brings deforming bodies' shapes of the last step (Scene::seen) up to date with what the last step has seen.
    virtual void fetch_seen(View<const BodyId>, View<const View<SeenPatch>>) const {}
    /// What the last step has left for the next one.
    virtual StepMemory memory() const { return {}; }
    /// Makes that the last step's, whoever has taken it. It must have been checked.
    virtual void remember(const StepMemory&) {}
    /// Traces rays outside a step, bringing the targets' trees up to date first.
    virtual void closest_hits(View<const BodyView> bodies, View<const Ray> rays, View<Hit> hits) = 0;
};

/// Any executor and tracer as a Backend.
template <class E, class T>
class PipelineBackend : public Backend {
public:
    PipelineBackend(std::string description, std::unique_ptr<E> executor, std::unique_ptr<T> tracer)
        : description_(std::move(description)),
          executor_(std::move(executor)),
          tracer_(std::move(tracer)),
          pipeline_(*executor_, *tracer_) {}

    std::string description() const override { return description_; }
    void step(const Scene& scene, StepStats& stats) override {
        executor_->run([&] { pipeline_.step(scene, stats); });
        pipeline_.report(*scene.plan, stats);
        has_sheets_ = scene.plan->sheets;
        if (!has_sheets_) return;
        const auto &others = pipeline_.contacts(), &of_sheets = pipeline_.sheet_contacts();
        contacts_.assign(others.begin(), others.end());
        contacts_.insert(contacts_.end(), of_sheets.begin(), of_sheets.end());
    }
    View<const Contact> contacts() const override {
        return has_sheets_ ? view_of(contacts_) : view_of(pipeline_.contacts());
    }
    View<const Pair> pairs() const override { return view_of(pipeline_.pairs()); }

    Certificate certificate(View<const BodyView> bodies, Pair pair, std::uint32_t side,
                            std::uint32_t vertex) const override {
        return pipeline_.certificate(bodies, pair, side, vertex);
    }

    StepMemory memory() const override { return pipeline_.memory(); }
    void remember(const StepMemory& memory) override { pipeline_.remember(memory); }

    void closest_hits(View<const BodyView> bodies, View<const Ray> rays, View<Hit> hits) override {
        std::vector<std::uint32_t> wanted(bodies.size, 0);
        for (const Ray& ray : rays) wanted[ray.target] = 1;
        executor_->run([&] {
            tracer_->update(*executor_, bodies, view_of(std::as_const(wanted)));
            tracer_->closest_hits(*executor_, "trace", bodies, rays.size, rays, hits);
        });
    }

private:
    std::string description_;
    std::unique_ptr<E> executor_;
    std::unique_ptr<T> tracer_;
    Pipeline<E, T> pipeline_;
    bool has_sheets_ = false;
    std::vector<Contact> contacts_;  ///< all of them, if some are sheets'
};

/// One thread and brute force: slow, simple, and the definition of what every other backend must answer.
std::unique_ptr<Backend> reference_backend();

/// One thread and our own trees, the ones that serve the GPU: for tests of theirs on any machine.
std::unique_ptr<Backend> bvh_backend();

}  // namespace pierce
