#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "core/base/usable.hpp"
#include "core/body/fetched_place.hpp"
#include "core/body/reach.hpp"
#include "pierce/reference_backends.hpp"
#include "support/forwarding_backend.hpp"

namespace pierce::test {

/// Own trees on the host that pass for a backend on a device; its memory is the host's.
class DeviceBackend : public ForwardingBackend {
public:
    DeviceBackend() : ForwardingBackend(bvh_backend()) {}
    std::string description() const override { return "a device"; }
    bool runs_on_device() const override { return true; }
    bool certificates_pay() const override { return false; }

    void step(const Scene& given, StepStats& stats) override {
        Scene scene = given;
        std::vector<std::uint32_t> changed(given.changed.begin(), given.changed.end());
        for (std::uint32_t b = 0; b < scene.bodies.size; ++b) {
            BodyView& body = scene.bodies[b];
            if (!body.active || !(body.device_positions || body.device_pose.exists())) continue;
            changed.push_back(b);
            read_place(body);
        }
        std::ranges::sort(changed);
        changed.erase(std::ranges::unique(changed).begin(), changed.end());
        scene.changed = view_of(std::as_const(changed));
        ForwardingBackend::step(scene, stats);
    }

    double measure_reach(View<const BodyView> bodies, View<const std::uint32_t> some,
                         View<const double> more, bool) override {
        measured_.resize(some.size);
        for (std::uint32_t k = 0; k < some.size; ++k) {
            BodyView body = bodies[some[k]];
            read_place(body);
            PlacedBox place;
            for (const Vec3f p : body.positions) place.box.extend(to_double(p));
            for (std::uint32_t v = 0; v < body.start.size; ++v)
                place.travel = std::max(
                    place.travel, length(to_double(body.positions[v]) - to_double(body.start[v])));
            if (body.motion != Motion::deforming) place = placed_box(body.mesh.box, body.space);
            measured_[k] = reach_of(place, more[k]);
        }
        return INFINITY;
    }
    void fetch_reach(View<const std::uint32_t> some, View<Box> reach) override {
        for (std::uint32_t k = 0; k < some.size; ++k) reach[some[k]] = measured_.at(k);
    }
    View<const FetchedPlace> fetch_places(View<const BodyView> bodies,
                                          View<const std::uint32_t> some) override {
        places_.clear();
        for (const std::uint32_t b : some) {
            const BodyView& body = bodies[b];
            FetchedPlace& place = places_.emplace_back();
            if (body.device_pose.exists()) place.pose = body.device_pose.read();
            if (body.device_positions)
                place.positions = {body.device_positions, body.positions.size};
            if (body.device_start) place.start = {body.device_start, body.positions.size};
        }
        return view_of(std::as_const(places_));
    }

private:
    void read_place(BodyView& body) {
        if (body.device_pose.exists()) {
            const Pose pose = body.device_pose.read();
            body.fit = body.space = body.start_space = frame_of(pose);
        }
        if (body.device_positions) body.positions.data = body.device_positions;
        if (body.device_start) body.start.data = body.device_start;
        body.positions_version = first_version + ++versions_;
    }

    /// No version of the host is as large.
    static constexpr std::uint64_t first_version = std::uint64_t{1} << 62;

    std::uint64_t versions_ = 0;
    std::vector<Box> measured_;
    std::vector<FetchedPlace> places_;
};

}  // namespace pierce::test
