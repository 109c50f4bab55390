#pragma once

#include <cuda_runtime.h>
#include <thrust/iterator/counting_iterator.h>
#include <thrust/iterator/tabulate_output_iterator.h>
#include <thrust/iterator/transform_iterator.h>
#include <thrust/iterator/transform_output_iterator.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstring>
#include <cub/device/device_radix_sort.cuh>
#include <cub/device/device_scan.cuh>
#include <cub/device/device_select.cuh>
#include <limits>
#include <stdexcept>

#include "core/device/lanes.hpp"
#include "core/device/view.hpp"
#include "core/execute/executor.hpp"
#include "core/execute/list_id.hpp"
#include "gpu_cuda/branch.cuh"
#include "gpu_cuda/counting_sort.cuh"
#include "gpu_cuda/device_buffer.hpp"
#include "gpu_cuda/device_copy.hpp"
#include "gpu_cuda/emit_stage.cuh"
#include "gpu_cuda/stage_kernels.cuh"
#include "pierce/min_max.hpp"

namespace pierce {
/// Runs stages on the GPU, one thread per item, on one stream, with a second stream for the work
/// given to beside(). In exact steps the totals come back to the host, which waits for each. In
/// bounded steps the totals stay on the device. Launches and buffers are then sized by the totals
/// of exact steps, with room to grow. So the host waits for nothing, and the step can be captured
/// as a graph. finish() reports a step that did not fit. This is one long class, as all its parts
/// share the streams and totals.
class CudaExecutor {
public:
    using Count = cuda::DeviceCount;
    template <class T>
    using Buffer = cuda::DeviceBuffer<T>;
    template <class T>
    using Sum = cuda::SharedValue<T>;
    // Measured: with more than 512 bodies a sweep's launches take less time than a look at all
    // pairs. With one item for all partners of a body in the sweep, that item would be the longest
    // of the whole step.
    static constexpr ExecutorTraits traits{.host_reads = false,
                                           .overlaps_updates = true,
                                           .joins_stages = true,
                                           .bodies_at_once = 512,
                                           .sweep_walks = 8};

    CudaExecutor() {
        using cuda::check;
        int low = 0, high = 0;
        check(cudaDeviceGetStreamPriorityRange(&low, &high), "the priorities of streams");
        check(cudaStreamCreateWithPriority(&stream_, cudaStreamNonBlocking, high), "a stream");
        check(cudaStreamCreateWithPriority(&side_.stream, cudaStreamNonBlocking, low), "a stream");
        check(cudaStreamCreateWithPriority(&branch_stream_, cudaStreamNonBlocking, high),
              "a stream");
        for (cudaEvent_t* event : {&forked_, &joined_, &lists_begun_})
            check(cudaEventCreateWithFlags(event, cudaEventDisableTiming), "an event");
        totals_.resize(2 * most_totals);
        overflow_.resize(2);
        check(cudaHostAlloc(&host_totals_, (2 * most_totals + 1) * sizeof(std::uint32_t),
                            cudaHostAllocDefault),
              "allocation of pinned memory");
        epoch_.resize(1);
        clear(totals_);
        clear(overflow_);
        clear(epoch_);
        blocks_done_.resize(2);
        clear(blocks_done_);
    }
    CudaExecutor(const CudaExecutor&) = delete;
    ~CudaExecutor() {
        cudaFreeHost(host_totals_);
        for (cudaEvent_t event : {forked_, joined_, lists_begun_}) cudaEventDestroy(event);
        for (cudaStream_t stream : {stream_, side_.stream, branch_stream_})
            cudaStreamDestroy(stream);
    }

    cudaStream_t stream() const { return stream_; }

    /// Begins a step, or the repetition of a captured step. `bank`: 0 or 1, not the one of the last
    /// step, whose totals are still read.
    void begin_exact(std::uint32_t bank) { begin(bank, false); }
    void begin_bounded(std::uint32_t bank) {
        begin_repetition(bank);
        // The lists begin on the second stream, beside the stages that come before the first list.
        fork();
        std::swap(stream_, side_.stream);
        begin_lists(totals_.data() + bank * most_totals, most_totals);
        cuda::check(cudaEventRecord(lists_begun_, stream_), "an event");
        std::swap(stream_, side_.stream);
        waits_for_lists_ = true;
    }
    void begin_repetition(std::uint32_t bank) { begin(bank, true); }
    /// Ends a step: starts the copy of the step's totals, and of whether it overflowed, to the
    /// host.
    void end() {
        wait_for_lists();
        copy_to_host(host_totals_, totals_.data(), 2 * most_totals);
        copy_to_host(host_totals_ + 2 * most_totals, overflow_.data(), 1);
    }
    /// Waits for the device; true if the step fitted.
    bool finish() {
        wait();
        is_finished_ = true;
        if (host_totals_[2 * most_totals] == 0) return true;
        clear(overflow_);
        return false;
    }

    /// Runs work that is independent of everything issued before join(). In bounded steps the work
    /// has a stream of its own, so that it fills what other stages leave free on the GPU. It is
    /// done as a whole, unless a list has outgrown its room before, or one of its own lists does.
    template <class Work>
    void beside(const Work& work) {
        if (!bounded_) return work();
        fork();
        swap_sides();
        copy(overflow_.data() + 1, overflow_.data(), 1, cudaMemcpyDeviceToDevice);
        is_beside_ = true;
        work();
        is_beside_ = false;
        swap_sides();
        cuda::check(cudaEventRecord(joined_, side_.stream), "an event");
        is_forked_ = true;
    }
    /// Sets when the positions of ghosts have come. The event is recorded before a step is issued.
    void expect_ghosts(cudaEvent_t have_come) { ghosts_have_come_ = have_come; }
    void await_ghosts() {
        // A captured step waits for what is recorded before each of its launches.
        const unsigned flag = cuda::is_captured(stream_) ? cudaEventWaitExternal
                                                         : cudaEventWaitDefault;
        if (ghosts_have_come_ != nullptr)
            cuda::check(cudaStreamWaitEvent(stream_, ghosts_have_come_, flag), "an event");
    }
    void join() {
        if (is_forked_) cuda::check(cudaStreamWaitEvent(stream_, joined_), "an event");
        is_forked_ = false;
    }

    /// Runs work that consists of stages as a whole.
    template <class Work>
    void run(const Work& work) {
        work();
    }

    bool is_empty(const Count& n) const { return n.bound() == 0; }
    static Count times(std::uint32_t k, const Count& n) { return k * n; }

    /// Runs work that does nothing if the test holds for no item. A captured step leaves the work
    /// out then.
    template <class Test, class Work>
    void when_any(const Count& n, const Test& test, const Work& work) {
        if (is_empty(n)) return;
        if (!bounded_ || !cuda::is_captured(stream_)) return work();
        join();
        const cudaGraphConditionalHandle handle = cuda::branch_handle(stream_);
        for_each(n, cuda::TakeBranch<Test>{handle, test});
        const cudaGraph_t branch = cuda::add_branch(stream_, handle);
        cuda::check(cudaStreamBeginCaptureToGraph(branch_stream_, branch, nullptr, nullptr, 0,
                                                  cudaStreamCaptureModeThreadLocal),
                    "capture of a branch");
        std::swap(stream_, branch_stream_);
        work();
        std::swap(stream_, branch_stream_);
        cudaGraph_t captured = nullptr;
        cuda::check(cudaStreamEndCapture(branch_stream_, &captured), "capture of a branch");
    }

    /// Runs work again and again until `left()` is zero. A bounded step repeats it as often as the
    /// longest exact step so far, and once more; it did not fit if something is left then. A round
    /// reads totals of the round before, so two rounds' places for them serve all in turn; emit()
    /// needs new ones.
    template <class Left, class Work>
    void repeat(ListId id, const Left& left, const Work& work) {
        std::uint32_t& most = rounds_[static_cast<std::size_t>(id)];
        const std::uint32_t begin = next_;
        std::uint32_t round = 0, of_round = 0;
        for (; bounded_ ? round <= most : left().bound() > 0; ++round) {
            next_ = begin + round % 2 * of_round;
            work();
            if (round == 0) of_round = next_ - begin;
        }
        next_ = begin + 2 * of_round;
        if (!bounded_)
            most = max_of(round, most);
        else
            for_each(left(), cuda::SetOverflow{{overflow_.data(), is_beside_}});
    }

    template <class F>
    void for_each(Count n, const F& stage) {
        if (n.bound() == 0) return;
        const std::uint32_t threads = has_rooms<F>() ? room_threads
                                      : n.bound() < cuda::many_items || cuda::launch_of<F>.is_uneven
                                          ? cuda::few_threads
                                          : cuda::block_threads;
        cuda::run_stage<<<(n.bound() - 1) / threads + 1, threads, 0, stream_>>>(stage, items(n));
        cuda::check(cudaGetLastError(), "a launch");
    }

    template <class... F>
    void in_turn(Count n, const F&... stages) {
        if (n.bound() <= cuda::few_items)
            for_each(n, cuda::InTurn<F...>(stages...));
        else
            (launch(n, stages), ...);
    }

    Count exclusive_scan(ListId id, Count n, View<const std::uint32_t> in,
                         View<std::uint32_t> out) {
        if (n.bound() == 0) return next_total_of_nothing(id);
        const cuda::CountAt count{items(n), in.data};
        const cuda::NoteTotal to = next_total(id, 0xffffffffu);
        if (n.bound() <= cuda::short_list) {
            cuda::scan_short_list<<<1, cuda::scan_threads, 0, stream_>>>(count, out.data, to);
            cuda::check(cudaGetLastError(), "a launch");
            return noted(id, to);
        }
        const auto counts = thrust::make_transform_iterator(
            thrust::counting_iterator<std::uint32_t>(0), count);
        const auto offsets = thrust::make_tabulate_output_iterator(
            cuda::WriteOffset{count, out.data, to});
        with_scratch([&](void* scratch, std::size_t& bytes) {
            return cub::DeviceScan::ExclusiveSum(scratch, bytes, counts, offsets, cub_items(n),
                                                 stream_);
        });
        return noted(id, to);
    }

    template <class F, class... T>
    void emit(ListId id, Count n, const F& finder, Buffer<T>&... lists) {
        if (n.bound() == 0) {
            const Count none = next_total_of_nothing(id);
            return (lists.resize(none), ...);
        }
        cuda::NoteTotal to = next_total(id, 0xffffffffu);
        if (!bounded_) {
            // The first launch only counts, to see how much room the lists need.
            begin_lists(to.total, 1);
            to.room = 0xffffffffu;
            launch_emit(id, n, finder, to);
            to.room = noted(id, to).bound();
            (lists.resize(to.room), ...);
            begin_lists(to.total, 1);
            return launch_emit(id, n, finder, to, lists.data()...);
        }
        (lists.resize({to.room, to.total, 1}), ...);
        launch_emit(id, n, finder, to, lists.data()...);
        ++next_;
    }

    template <class F>
    Count select(ListId id, Count n, const F& wanted, View<std::uint32_t> out) {
        if (n.bound() == 0) return next_total_of_nothing(id);
        const cuda::WantedAt<F> is_wanted{items(n), wanted};
        const cuda::NoteTotal to = next_total(id, n.bound());
        if (n.bound() <= cuda::short_list) {
            cuda::select_from_short_list<<<1, cuda::scan_threads, 0, stream_>>>(is_wanted, out.data,
                                                                                to);
            cuda::check(cudaGetLastError(), "a launch");
            return noted(id, to);
        }
        with_scratch([&](void* scratch, std::size_t& bytes) {
            return cub::DeviceSelect::If(
                scratch, bytes, thrust::counting_iterator<std::uint32_t>(0),
                thrust::make_transform_output_iterator(out.data, cuda::ListedAt<F>{wanted}),
                thrust::make_tabulate_output_iterator(to), cub_items(n), is_wanted, stream_);
        });
        return noted(id, to);
    }

    void sort(Count n, int bits, View<std::uint64_t> keys, View<const std::uint32_t> values,
              View<std::uint64_t> sorted_keys, View<std::uint32_t> sorted_values) {
        if (n.bound() == 0) return;
        if (n.bound() <= cuda::counted_list) {
            const std::uint32_t blocks = (n.bound() - 1) / cuda::counted_keys + 1;
            cuda::
                sort_by_counting<<<blocks, cuda::counted_keys * cuda::counted_parts, 0, stream_>>>(
                    items(n), keys.data, values.data, sorted_keys.data, sorted_values.data);
            return cuda::check(cudaGetLastError(), "a launch");
        }
        if (bits <= 32) return sort_narrow(n, bits, keys, values, sorted_keys, sorted_values);
        if (!n.is_known()) for_each(n.bound(), cuda::PadKey{items(n), keys.data});
        with_scratch([&](void* scratch, std::size_t& bytes) {
            return cub::DeviceRadixSort::SortPairs(
                scratch, bytes, std::as_const(keys.data), sorted_keys.data, values.data,
                sorted_values.data, cub_items(n), 0, bits, stream_);
        });
    }

    template <class F, class T>
    void reduce(Count n, const F& term, Sum<T>& sum) {
        if (n.bound() == 0) return for_each(1, cuda::FillWith<T>{sum.data(), T{}});
        if (n.bound() <= cuda::few_items)
            add_up<cuda::few_threads>(n, term, sum);
        else
            add_up<cuda::block_threads>(n, term, sum);
    }

    /// The result of a reduction. Waits for the device, unless the step is finished.
    template <class T>
    T read(const Sum<T>& sum) const {
        wait_for_step();
        return *sum.data();
    }

    bool are_few_sixteens(const Count& groups) const {
        return groups.bound() <= cuda::few_sixteens;
    }
    Count in_sixteens(const Count& groups) const { return constants::group_size * groups; }

    bool are_few_in_lanes(const Count& things) const {
        return things.bound() <= cuda::few_in_lanes;
    }
    Count in_lanes(const Count& things) const { return Lanes::count * things; }

    std::uint32_t number(const Count& count) const {
        if (count.is_known()) return count.bound();
        wait_for_step();
        return count.number(
            [&](const std::uint32_t* total) { return host_totals_[place_in_bank(total)]; });
    }
    /// The count in the last step: a list that a captured step has made keeps the count that it had
    /// when it was captured, with the totals of that bank.
    Count in_last_step(const Count& count) const {
        return count.with(
            [&](const std::uint32_t* total) { return totals_.data() + place_in_bank(total); });
    }

    template <class T>
    std::vector<T> download(const Buffer<T>& buffer) const {
        std::vector<T> items(number(count_of(buffer)));
        copy_to_host(items.data(), buffer.data(), items.size());
        wait();
        return items;
    }

    template <class T>
    void upload(std::span<const T> items, Buffer<T>& buffer) {
        buffer.resize(static_cast<std::uint32_t>(items.size()));
        if (items.size_bytes() == 0) return;
        if (items.size_bytes() > staged_at_once) {
            copy(buffer.data(), items.data(), items.size(), cudaMemcpyHostToDevice);
            return wait();  // the caller may free the items now
        }
        if (staged_ + items.size_bytes() > staged_at_once) wait();
        std::byte* const staged = stage_.resize(staged_at_once) + staged_;
        std::memcpy(staged, items.data(), items.size_bytes());
        copy(reinterpret_cast<std::byte*>(buffer.data()), staged, items.size_bytes(),
             cudaMemcpyHostToDevice);
        staged_ += items.size_bytes();
    }

    template <class T>
    void assign(Buffer<T>& buffer, Count count, const T& value) {
        buffer.resize(count);
        for_each(count, cuda::FillWith<T>{buffer.data(), value});
    }

    template <class T>
    void copy(T* to, const T* from, std::size_t count, cudaMemcpyKind kind) const {
        cuda::copy(to, from, count, kind, stream_);
    }

    template <class T>
    void copy_to_host(T* to, const T* from, std::size_t count) const {
        copy(to, from, count, cudaMemcpyDeviceToHost);
    }

    /// Waits at the end of a timed stage, except in steps that wait for nothing.
    void settle() const {
        if (!bounded_) wait();
    }

    void wait() const {
        cuda::check(cudaStreamSynchronize(stream_), "waiting for the device");
        staged_ = 0;
    }

private:
    static constexpr std::uint32_t most_totals = 128;
    // Short arrays go to the device from memory that the host writes without waiting.
    static constexpr std::size_t staged_at_once = std::size_t{1} << 14;  // [bytes]

    void begin(std::uint32_t bank, bool is_bounded) {
        is_finished_ = false;
        bounded_ = is_bounded;
        bank_ = bank;
        next_ = 0;
    }

    std::size_t place_in_bank(const std::uint32_t* total) const {
        const auto place = static_cast<std::uint32_t>(total - totals_.data()) % most_totals;
        return bank_ * most_totals + place;
    }

    void wait_for_step() const {
        if (!is_finished_) wait();
    }

    static int cub_items(const Count& n) {
        if (n.bound() > static_cast<std::uint32_t>(std::numeric_limits<int>::max()))
            throw std::length_error("a sort or a sum of 2^31 things or more");
        return static_cast<int>(n.bound());
    }

    cuda::Items items(const Count& n) const { return {n, overflow_.data() + is_beside_}; }

    // By how much a total may exceed that of the exact step before a bounded step must be repeated.
    static constexpr std::uint32_t spare_share = 8, spare_items = 1024;

    Count next_total_of_nothing(ListId id) {
        ++next_;
        if (!bounded_) grow_bound(id, spare_items);
        return 0;
    }

    template <class F>
    void launch(const Count& n, const F& stage) {
        if constexpr (!is_no_stage<F>) for_each(n, stage);
    }

    /// The place of the next total. `most`: the largest value that it can have.
    cuda::NoteTotal next_total(ListId id, std::uint32_t most) {
        wait_for_lists();
        if (bounded_ && next_ + 1 == most_totals)
            throw std::logic_error("a step has more totals than there is room for");
        // Exact steps may have any number of totals, as their totals are not read later.
        std::uint32_t* const place = totals_.data() + bank_ * most_totals + next_ % most_totals;
        return {.room = bounded_ ? min_of(known_bound(id), most) : most,
                .total = place,
                .overflow = {overflow_.data(), is_beside_}};
    }

    /// The count for a total that has been written, or will be.
    Count noted(ListId id, const cuda::NoteTotal& to) {
        ++next_;
        if (bounded_) return {to.room, to.total, 1};
        std::uint32_t* const host = host_totals_ + (to.total - totals_.data());
        copy_to_host(host, to.total, 1);
        wait();
        grow_bound(id, *host + *host / spare_share + spare_items);
        return *host;
    }

    /// The room for a total in bounded steps: the largest total of all exact steps so far, and some
    /// more. So a total that changes between small and large does not make every other step run
    /// twice.
    std::uint32_t known_bound(ListId id) const {
        return max_of(bounds_[static_cast<std::size_t>(id)], spare_items);
    }

    void grow_bound(ListId id, std::uint32_t bound) {
        std::uint32_t& known = bounds_[static_cast<std::size_t>(id)];
        known = max_of(bound, known);
    }

    template <class T>
    void clear(Buffer<T>& buffer) const {
        cuda::check(cudaMemsetAsync(buffer.data(), 0, buffer.size() * sizeof(T), stream_),
                    "clearing device memory");
    }

    /// To be called before anything is emitted; once in a bounded step, in which every list is
    /// emitted once.
    void begin_lists(std::uint32_t* totals, std::uint32_t count) {
        for_each(count, cuda::BeginLists{totals, epoch_.data()});
    }

    template <class F, class... T>
    void launch_emit(ListId id, Count n, const F& finder, const cuda::NoteTotal& to, T*... lists) {
        const std::uint32_t threads = n.bound() < cuda::many_emitting ? cuda::few_threads
                                                                      : cuda::block_threads;
        const std::uint32_t blocks = (n.bound() - 1) / threads + 1;
        Buffer<std::uint64_t>& sums = sums_of_blocks_[static_cast<std::size_t>(id)];
        if (sums.size() < blocks) {
            sums.resize(blocks);
            clear(sums);
        }
        const cuda::Emitted emitted{.room = to.room,
                                    .total = to.total,
                                    .overflow = to.overflow,
                                    .sums = {sums.data(), epoch_.data()},
                                    .in_order = in_order<F>() || blocks <= cuda::few_blocks};
        cuda::emit_stage<<<blocks, threads, 0, stream_>>>(finder, items(n), emitted, lists...);
        cuda::check(cudaGetLastError(), "a launch");
    }

    template <std::uint32_t threads, class F, class T>
    void add_up(Count n, const F& term, Sum<T>& sum) {
        const std::uint32_t blocks = min_of((n.bound() - 1) / threads + 1, cuda::most_sums);
        scratch_.resize(static_cast<std::uint32_t>(cuda::most_sums * sizeof(T)));
        cuda::add_up<threads>
            <<<blocks, threads, 0, stream_>>>(term, items(n), reinterpret_cast<T*>(scratch_.data()),
                                              blocks_done_.data() + is_beside_, sum.data());
        cuda::check(cudaGetLastError(), "a launch");
    }

    /// Sorts keys of no more than 32 bits as 32-bit numbers, so that every pass moves less.
    void sort_narrow(Count n, int bits, View<const std::uint64_t> keys,
                     View<const std::uint32_t> values, View<std::uint64_t> sorted_keys,
                     View<std::uint32_t> sorted_values) {
        const auto sort = [&](void* scratch, std::size_t& bytes, const std::uint32_t* from,
                              std::uint32_t* to) {
            cuda::check(
                cub::DeviceRadixSort::SortPairs(scratch, bytes, from, to, values.data,
                                                sorted_values.data, cub_items(n), 0, bits, stream_),
                "a sort");
        };
        std::size_t bytes = 0;
        sort(nullptr, bytes, nullptr, nullptr);
        constexpr std::size_t word = sizeof(std::uint32_t);
        const std::size_t begin = (bytes + word - 1) / word;  // the first word after the sort's own
                                                              // scratch memory
        need_scratch(word * (begin + 2 * std::size_t{n.bound()}));
        std::uint32_t* const narrow = reinterpret_cast<std::uint32_t*>(scratch_.data()) + begin;
        for_each(n.bound(), cuda::NarrowKey{items(n), keys.data, narrow});
        sort(scratch_.data(), bytes, narrow, narrow + n.bound());
        for_each(n.bound(), cuda::WidenKey{items(n), narrow + n.bound(), sorted_keys.data});
    }

    /// Makes the second stream wait for all that was issued so far.
    void fork() {
        cuda::check(cudaEventRecord(forked_, stream_), "an event");
        cuda::check(cudaStreamWaitEvent(side_.stream, forked_), "an event");
    }

    /// Waits until the lists have begun. Work beside the rest runs after that on its stream anyway.
    void wait_for_lists() {
        if (!waits_for_lists_ || is_beside_) return;
        cuda::check(cudaStreamWaitEvent(stream_, lists_begun_), "an event");
        waits_for_lists_ = false;
    }

    void swap_sides() {
        std::swap(stream_, side_.stream);
        std::swap(scratch_, side_.scratch);
    }

    void need_scratch(std::size_t bytes) {
        if (bytes > std::numeric_limits<std::uint32_t>::max())
            throw std::length_error("a sort or a sum would need 4 GiB of scratch memory");
        scratch_.resize(static_cast<std::uint32_t>(bytes));
    }

    /// Calls a function of CUB's twice: for the size of its scratch memory, and with it.
    template <class F>
    void with_scratch(const F& call) {
        std::size_t bytes = 0;
        cuda::check(call(nullptr, bytes), "preparing a collective operation");
        need_scratch(bytes);
        cuda::check(call(scratch_.data(), bytes), "a collective operation");
    }

    cudaStream_t stream_ = nullptr, branch_stream_ = nullptr;
    bool bounded_ = false;
    bool is_finished_ = false;  ///< what the last step has summed and counted is there
    std::uint32_t bank_ = 0, next_ = 0;
    std::array<std::uint32_t, list_count> bounds_{};  ///< the room for each total; 0: unknown
    std::array<std::uint32_t, list_count> rounds_{};  ///< how often work was repeated at most
    std::array<Buffer<std::uint64_t>, list_count> sums_of_blocks_;
    Buffer<std::uint32_t> totals_;
    Buffer<std::uint32_t> epoch_;        ///< of the sums of blocks
    Buffer<std::uint32_t> blocks_done_;  ///< of a reduction, and of a reduction beside the rest
    Buffer<std::uint32_t> overflow_;  ///< whether a total has overflowed, and whether one had when
                                      ///< the work beside the rest began, or has there
    std::uint32_t* host_totals_ = nullptr;  ///< the totals of both banks, and whether one has
                                            ///< overflowed
    cuda::StagingBuffer<std::byte> stage_;
    mutable std::size_t staged_ = 0;  ///< bytes of it that the device may still read
    Buffer<std::byte> scratch_;
    /// What belongs to the work beside the rest.
    struct {
        cudaStream_t stream = nullptr;
        Buffer<std::byte> scratch;
    } side_;
    cudaEvent_t forked_ = nullptr, joined_ = nullptr, lists_begun_ = nullptr;
    cudaEvent_t ghosts_have_come_ = nullptr;  ///< another one's; null: there are no ghosts
    bool is_forked_ = false, is_beside_ = false;
    bool waits_for_lists_ = false;  ///< the lists still begin on the second stream
};

static_assert(Executor<CudaExecutor>);

}  // namespace pierce
