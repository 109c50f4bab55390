#include <cuda_runtime.h>

#include <array>
#include <mutex>
#include <new>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "core/body/body_view.hpp"
#include "core/body/scene.hpp"
#include "core/device/view.hpp"
#include "core/mesh/mesh_view.hpp"
#include "core/step/pipeline.hpp"
#include "core/trace/bvh/bvh_tracer.hpp"
#include "gpu_cuda/caller_stream.hpp"
#include "gpu_cuda/capture.hpp"
#include "gpu_cuda/contact_arrays.cuh"
#include "gpu_cuda/cuda_executor.cuh"
#include "gpu_cuda/on_device.hpp"
#include "gpu_cuda/place_fetcher.cuh"
#include "gpu_cuda/reach_meter.cuh"
#include "gpu_cuda/scene_mirror.cuh"
#include "gpu_cuda/turns.hpp"
#include "pierce/cuda_backend.hpp"
#include "pierce/device_contacts.hpp"
#include "pierce/error.hpp"
#include "pierce/explain.hpp"
#include "pierce/partitioned_backend.hpp"
#include "pierce/reference_backends.hpp"

namespace pierce {
namespace {

using cuda::check;

bool has_pools(int device) {
    int pools = 0;
    cudaDeviceGetAttribute(&pools, cudaDevAttrMemoryPoolsSupported, device);
    return pools != 0;
}

std::string device_name(int device) {
    cudaDeviceProp properties;
    check(cudaGetDeviceProperties(&properties, device), "the device's properties");
    return properties.name;
}

/// All that steps leave on the device for the next one.
struct StepState {
    explicit StepState(const CudaOptions& options) : tracer({options.builder, options.rebuild}) {}

    CudaExecutor executor;
    BvhTracer<CudaExecutor> tracer;
    cuda::SceneMirror mirror{executor};
    Pipeline<CudaExecutor, BvhTracer<CudaExecutor>> pipeline{executor, tracer};
};

class CudaBackend : public Backend {
public:
    /// On the current device.
    explicit CudaBackend(CudaOptions options)
        : options_(std::move(options)), name_(device_name(device_)) {
        for (cudaEvent_t& event : events_) check(cudaEventCreate(&event), "an event");
        state();
    }
    ~CudaBackend() override {
        // What is freed after this body needs the device, too.
        current_at_end_.emplace(device_, std::nothrow);
        drop_graphs();
        for (cudaEvent_t event : events_) cudaEventDestroy(event);
    }

    std::string description() const override { return "cuda, " + name_; }
    bool runs_on_device() const override { return true; }
    bool certificates_pay() const override { return false; }

    void set_stream(void* stream) override {
        const cuda::OnDevice here(device_);
        caller_.set(static_cast<cudaStream_t>(stream));
    }

    void step(const Scene& host, StepStats& stats) override {
        const cuda::OnDevice here(device_);
        contacts_.clear();
        pairs_.clear();
        fetched_ = true;
        try {
            caller_.hold_up(stream());
            find_contacts(host, stats);
            caller_.let_go_on(stream());
        } catch (...) {
            start_over();
            throw;
        }
        fetched_ = false;
    }

    DeviceContacts device_contacts(std::uint32_t part, std::uint32_t worlds) override {
        if (part > 0) throw InputError("there is one part only");
        const cuda::OnDevice here(device_);
        const View<const BodyView> bodies = mirror().scene().bodies;
        DeviceContacts contacts{.solids = {}, .sheets = {}, .device = device_};
        contacts.solids = solids_.fill(executor(), pipeline().contacts(), bodies, worlds);
        // Since the step, sheets may have gone.
        if (mirror().scene().plan->sheets || !pipeline().sheet_contacts().empty())
            contacts.sheets = sheets_.fill(executor(), pipeline().sheet_contacts(), bodies, worlds);
        if (caller_.exists())
            caller_.let_go_on(stream());
        else
            executor().wait();
        return contacts;
    }

    View<const Contact> contacts() const override {
        fetch();
        return view_of(contacts_);
    }
    View<const Pair> pairs() const override {
        fetch();
        return view_of(pairs_);
    }

    Certificate certificate(View<const BodyView>, Pair, std::uint32_t,
                            std::uint32_t) const override {
        return {};
    }

    double measure_reach(View<const BodyView> bodies, View<const std::uint32_t> some,
                         View<const double> more, bool anew) override {
        const cuda::OnDevice here(device_);
        caller_.hold_up(stream());
        return meter_.measure(bodies, some, more, anew, stream());
    }
    void fetch_reach(View<const std::uint32_t> some, View<Box> reach) override {
        const cuda::OnDevice here(device_);
        meter_.fetch(some, reach, stream());
    }

    View<const FetchedPlace> fetch_places(View<const BodyView> bodies,
                                          View<const std::uint32_t> some) override {
        const cuda::OnDevice here(device_);
        caller_.hold_up(stream());
        return fetcher_.fetch(bodies, some, stream());
    }

    void fetch_bodies(View<BodyView> bodies) const override {
        const cuda::OnDevice here(device_);
        mirror().fetch(bodies);
    }

    void fetch_seen(View<const BodyId> ids, View<const View<SeenPatch>> seen) const override {
        const cuda::OnDevice here(device_);
        mirror().fetch_seen(ids, seen);
    }
    StepMemory memory() const override {
        const cuda::OnDevice here(device_);
        return pipeline().memory();
    }
    void remember(const StepMemory& memory) override {
        const cuda::OnDevice here(device_);
        contacts_.clear();
        pairs_.clear();
        fetched_ = true;
        pipeline().restore(memory);
        // Captured steps know where memory lay, and how much there was of it.
        restart();
    }

    void closest_hits(View<const BodyView> bodies, View<const Ray> rays, View<Hit> hits) override {
        outside_->closest_hits(bodies, rays, hits);
    }

private:
    StepState& state() const {
        if (!state_) state_.emplace(options_);
        return *state_;
    }
    CudaExecutor& executor() const { return state().executor; }
    BvhTracer<CudaExecutor>& tracer() const { return state().tracer; }
    cuda::SceneMirror& mirror() const { return state().mirror; }
    Pipeline<CudaExecutor, BvhTracer<CudaExecutor>>& pipeline() const { return state().pipeline; }
    cudaStream_t stream() const { return state().executor.stream(); }

    // The first steps after a change run stage by stage, so that the trees exist and the buffers
    // are large enough.
    static constexpr std::uint32_t rehearsals = 2;

    void find_contacts(const Scene& host, StepStats& stats) {
        using Change = cuda::SceneMirror::Change;
        // The device's time begins with the places of bodies.
        check(cudaEventRecord(events_[0], stream()), "an event");
        const Change change = mirror().update(host);
        if (change != Change::none || tracer().is_stale()) {
            executor().await_ghosts();
            tracer().arrange(executor(), host.bodies);
            tracer().build_changed(executor(), mirror().scene().bodies);
        }
        if (change == Change::all || (host.plan->casts_rays && tracer().is_stale())) restart();
        bank_ = 1 - bank_;
        if (!can_repeat() || repeated_ < rehearsals) {
            exact_step(stats);
            repeated_ = can_repeat() ? repeated_ + 1 : 0;
        } else {
            bounded_step(stats);
        }
    }

    /// After a step that failed: the next one begins from nothing. What was launched is awaited,
    /// and what failed is no longer CUDA's last error.
    void start_over() {
        const std::scoped_lock turn(cuda::captures_and_waits());
        cudaDeviceSynchronize();
        restart();
        state_.reset();
        cudaGetLastError();
    }

    /// True if steps may be bounded.
    bool can_repeat() const { return options_.graph && !options_.rebuild; }

    void restart() {
        repeated_ = 0;
        drop_graphs();
    }

    void drop_graphs() {
        for (cudaGraphExec_t& graph : graphs_) {
            if (graph != nullptr) cudaGraphExecDestroy(graph);
            graph = nullptr;
        }
        warm_ = 0;
    }

    void exact_step(StepStats& stats) {
        executor().begin_exact(bank_);
        pipeline().step(mirror().scene(), stats);
        executor().end();
        if (!executor().finish()) throw std::length_error("a step would list 2^32 things or more");
        pipeline().report(*mirror().scene().plan, stats);
    }

    /// Two steps without a graph give every buffer its size; then each of the two banks is captured
    /// once and played back.
    void bounded_step(StepStats& stats) {
        cudaGraphExec_t& graph = graphs_[bank_];
        mirror().keep_seen();
        if (graph != nullptr) {
            executor().begin_repetition(bank_);
            pipeline().recall(*mirror().scene().plan);
        } else if (warm_ < 2) {
            ++warm_;
            bounded_stages(stats);
        } else {
            graph = cuda::captured(stream(), [&] { bounded_stages(stats); });
        }
        stats.stages.clear();
        if (graph != nullptr) {
            check(cudaGraphLaunch(graph, stream()), "launch of a step");
            check(cudaEventRecord(events_[1], stream()), "an event");
        }
        if (executor().finish()) {
            float milliseconds = 0;
            if (graph != nullptr)
                check(cudaEventElapsedTime(&milliseconds, events_[0], events_[1]), "a time");
            stats.device_milliseconds = milliseconds;
            return pipeline().report(*mirror().scene().plan, stats);
        }
        // A list outgrew its room: the step runs once more as an exact step, from the same memory.
        pipeline().recall(*mirror().scene().plan);
        mirror().restore_seen();
        restart();
        exact_step(stats);
    }

    void bounded_stages(StepStats& stats) {
        executor().begin_bounded(bank_);
        pipeline().step(mirror().scene(), stats);
        executor().end();
    }

    void fetch() const {
        if (fetched_) return;
        const cuda::OnDevice here(device_);
        const std::uint32_t others = executor().number(count_of(pipeline().contacts()));
        const std::uint32_t of_sheets = executor().number(count_of(pipeline().sheet_contacts()));
        contacts_.resize(others + of_sheets);
        pairs_.resize(executor().number(count_of(pipeline().pairs())));
        executor().copy_to_host(contacts_.data(), pipeline().contacts().data(), others);
        executor().copy_to_host(contacts_.data() + others, pipeline().sheet_contacts().data(),
                                of_sheets);
        executor().copy_to_host(pairs_.data(), pipeline().pairs().data(), pairs_.size());
        executor().wait();
        fetched_ = true;
    }

    // The first member is the last one to end.
    std::optional<cuda::OnDevice> current_at_end_;
    int device_ = cuda::current_device();
    CudaOptions options_;
    std::string name_;
    mutable std::optional<StepState> state_;  ///< none after a step that has failed
    std::unique_ptr<Backend> outside_ = bvh_backend();
    std::uint32_t bank_ = 0, repeated_ = 0, warm_ = 0;
    std::array<cudaGraphExec_t, 2> graphs_{};
    std::array<cudaEvent_t, 2> events_{};
    cuda::CallerStream caller_;
    cuda::ContactArrays solids_, sheets_;
    cuda::ReachMeter meter_;
    cuda::PlaceFetcher fetcher_;
    mutable bool fetched_ = true;
    mutable std::vector<Contact> contacts_;
    mutable std::vector<Pair> pairs_;
};

}  // namespace

std::string cuda_problem() {
    int count = 0;
    const cudaError_t error = cudaGetDeviceCount(&count);
    if (error != cudaSuccess) return cudaGetErrorString(error);
    if (count == 0) return "no CUDA device";
    int device = 0;
    cudaGetDevice(&device);
    return has_pools(device) ? "" : "the device has no memory pools";
}

namespace {

/// Lets kernels of each device read what another one has.
void connect(std::span<const int> devices) {
    for (const int device : devices)
        for (const int other : devices) {
            if (device == other) continue;
            int can = 0;
            check(cudaDeviceCanAccessPeer(&can, device, other), "access to another device");
            if (can == 0)
                throw InputError("device " + std::to_string(device) +
                                 " cannot read the memory of device " + std::to_string(other));
            const cuda::OnDevice here(device);
            const cudaError_t error = cudaDeviceEnablePeerAccess(other, 0);
            if (error == cudaErrorPeerAccessAlreadyEnabled)
                cudaGetLastError();
            else
                check(error, "access to another device");
            // That is for cudaMalloc; what comes from the other device's pool is opened here.
            cudaMemPool_t pool = nullptr;
            check(cudaDeviceGetMemPool(&pool, other), "a device's memory pool");
            cudaMemAccessDesc access{};
            access.location = {.type = cudaMemLocationTypeDevice, .id = device};
            access.flags = cudaMemAccessFlagsProtReadWrite;
            check(cudaMemPoolSetAccess(pool, &access, 1), "access to another device's pool");
        }
}

}  // namespace

std::unique_ptr<Backend> cuda_backend(CudaOptions options) {
    check_tree_builder(options.builder);
    const std::string problem = cuda_problem();
    if (!problem.empty()) throw InputError("the cuda backend cannot run here: " + problem);
    int count = 0;
    check(cudaGetDeviceCount(&count), "the number of devices");
    for (const int device : options.devices)
        if (device < 0 || device >= count)
            throw InputError("there is no CUDA device " + std::to_string(device));
        else if (!has_pools(device))
            throw InputError("CUDA device " + std::to_string(device) + " has no memory pools");
    if (options.devices.empty()) return std::make_unique<CudaBackend>(options);
    connect(options.devices);
    std::vector<Part> parts;
    for (const int device : options.devices) {
        const cuda::OnDevice here(device);
        parts.push_back({.backend = std::make_unique<CudaBackend>(options)});
    }
    if (parts.size() == 1) return std::move(parts[0].backend);
    return partitioned_backend(std::move(parts));
}

std::unique_ptr<Backend> cuda_backend(CudaOptions options, std::unique_ptr<Backend> host,
                                      double share) {
    std::vector<std::unique_ptr<Backend>> devices;
    const std::vector<int> wanted = std::exchange(options.devices, {});
    if (wanted.empty()) devices.push_back(cuda_backend(options));
    for (const int device : wanted) {
        options.devices = {device};
        devices.push_back(cuda_backend(options));
    }
    return partitioned_backend(std::move(devices), std::move(host), share);
}

}  // namespace pierce
