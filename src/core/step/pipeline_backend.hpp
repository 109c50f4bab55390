#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "core/body/body_view.hpp"
#include "core/body/scene.hpp"
#include "core/device/view.hpp"
#include "core/step/pipeline.hpp"
#include "pierce/backend.hpp"

namespace pierce {

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
        grow_older();
        contacts_.clear();
        try {
            executor_->run([&] { pipeline_.step(scene, stats); });
            pipeline_.report(*scene.plan, stats);
            join_contacts();
        } catch (...) {
            contacts_.clear();
            pipeline_.restore(StepMemory{});
            throw;
        }
    }
    bool can_rest() const override { return !runs_on_device(); }
    void step_at_rest() override { ++steps_at_rest_; }
    View<const Contact> contacts() const override {
        grow_older();
        if (!contacts_.empty()) return view_of(contacts_);
        return pipeline_.contacts().empty() ? view_of(pipeline_.sheet_contacts())
                                            : view_of(pipeline_.contacts());
    }
    std::shared_ptr<const Contact> keep_contacts() override {
        grow_older();
        return pipeline_.sheet_contacts().empty() ? pipeline_.keep_contacts()
                                                  : Backend::keep_contacts();
    }
    View<const Pair> pairs() const override { return view_of(pipeline_.pairs()); }

    Certificate certificate(View<const BodyView> bodies, Pair pair, std::uint32_t side,
                            std::uint32_t vertex) const override {
        return pipeline_.certificate(bodies, pair, side, vertex);
    }

    StepMemory memory() const override {
        grow_older();
        return pipeline_.memory();
    }
    void remember(const StepMemory& memory) override {
        steps_at_rest_ = 0;
        contacts_.clear();
        pipeline_.restore(memory);
    }

    void closest_hits(View<const BodyView> bodies, View<const Ray> rays, View<Hit> hits) override {
        std::vector<std::uint32_t> wanted(bodies.size, 0);
        for (const Ray& ray : rays) wanted[ray.target] = 1;
        executor_->run([&] {
            tracer_->update(*executor_, bodies, view_of(std::as_const(wanted)));
            tracer_->closest_hits(*executor_, bodies, rays.size, rays, hits);
        });
    }

protected:
    E& executor() { return *executor_; }
    Pipeline<E, T>& pipeline() { return pipeline_; }

private:
    void join_contacts() {
        const auto &others = pipeline_.contacts(), &of_sheets = pipeline_.sheet_contacts();
        if (others.empty() || of_sheets.empty()) return;
        contacts_.assign(others.begin(), others.end());
        contacts_.insert(contacts_.end(), of_sheets.begin(), of_sheets.end());
    }
    /// Contacts are as old as they are to be when someone asks for them.
    void grow_older() const {
        if (steps_at_rest_ == 0) return;
        executor_->run([&] { pipeline_.step_at_rest(steps_at_rest_); });
        steps_at_rest_ = 0;
    }

    std::string description_;
    std::unique_ptr<E> executor_;
    std::unique_ptr<T> tracer_;
    mutable Pipeline<E, T> pipeline_;
    mutable std::uint32_t steps_at_rest_ = 0;  ///< since contacts were last asked for
    std::vector<Contact> contacts_;  ///< all contacts, if some are those of sheets and some are not
};

}  // namespace pierce
