#pragma once

#include <algorithm>
#include <cstdint>
#include <memory>
#include <span>
#include <type_traits>
#include <utility>
#include <vector>

#include "core/execute/executor_traits.hpp"
#include "core/execute/list_id.hpp"
#include "core/execute/list_length.hpp"

namespace pierce {

/// Leaves the new elements of a vector uninitialized, also those of types that say with what they
/// begin: every element is written before a stage reads it.
template <class T>
struct UninitializedAllocator : std::allocator<T> {
    template <class U>
    struct rebind {  // NOLINT(readability-identifier-naming): the name that allocators have
        using other = UninitializedAllocator<U>;
    };
    template <class U>
    void construct(U* p) noexcept {
        if constexpr (!std::is_trivially_copyable_v<U>) ::new (static_cast<void*>(p)) U;
    }
    template <class U, class... Args>
    void construct(U* p, Args&&... args) {
        ::new (static_cast<void*>(p)) U(std::forward<Args>(args)...);
    }
};

/// A list in memory of the host. Where it grows, it grows by more than is asked for, because counts
/// go up and down from step to step.
template <class T>
class HostBuffer : public std::vector<T, UninitializedAllocator<T>> {
    using List = std::vector<T, UninitializedAllocator<T>>;

public:
    using List::List;

    void resize(std::size_t count) {
        if (count > List::capacity())
            List::reserve(std::max(count + count / 4, 2 * List::capacity()));
        List::resize(count);
    }
    /// The same where all items are written anew: what the list held is not copied.
    void renew(std::size_t count) {
        List::clear();
        resize(count);
    }
};

template <class T>
std::uint32_t count_of(const HostBuffer<T>& buffer) {
    return static_cast<std::uint32_t>(buffer.size());
}

/// The common part of executors on the host: counts are numbers, buffers are vectors, sums are
/// values.
class HostExecutor {
public:
    using Count = std::uint32_t;
    template <class T>
    using Buffer = HostBuffer<T>;
    template <class T>
    using Sum = T;
    static constexpr ExecutorTraits traits{};

    /// The result of a reduction.
    template <class T>
    T read(const T& sum) const {
        return sum;
    }

    /// The number of items of a stage that handles so many groups (Sixteen).
    std::uint32_t in_sixteens(std::uint32_t groups) const { return groups; }

    /// The number of items of a stage whose lanes work on so many things (Lanes).
    std::uint32_t in_lanes(std::uint32_t things) const { return things; }

    /// False, as there is one lane.
    bool are_few_in_lanes(std::uint32_t) const { return false; }

    /// False, as an item on the host handles a whole group.
    bool are_few_sixteens(std::uint32_t) const { return false; }

    bool is_empty(std::uint32_t count) const { return count == 0; }

    /// Runs work that does nothing if a test holds for no item. To ask all items costs as much.
    template <class Test, class Work>
    void when_any(std::uint32_t, const Test&, const Work& work) {
        work();
    }

    /// Runs work again and again until `left()` is zero.
    template <class Left, class Work>
    void repeat(ListId, const Left& left, const Work& work) {
        while (left() > 0) work();
    }

    /// So many times a count. Throws std::length_error for 2^32 things or more.
    static std::uint32_t times(std::uint32_t k, std::uint32_t count) {
        return list_length(std::uint64_t{k} * count);
    }

    /// A count as a number.
    std::uint32_t number(std::uint32_t count) const { return count; }

    template <class T>
    void assign(HostBuffer<T>& buffer, std::uint32_t count, const T& value) {
        buffer.assign(count, value);
    }

    /// Runs work that consists of stages as a whole.
    template <class Work>
    void run(const Work& work) {
        work();
    }

    /// Does nothing, as a stage is over when its call returns.
    void settle() const {}

    /// Runs work that is independent of everything issued before join().
    template <class Work>
    void beside(const Work& work) {
        work();
    }
    void join() {}
    void await_ghosts() {}

    template <class T>
    std::vector<T> download(const HostBuffer<T>& buffer) const {
        return {buffer.begin(), buffer.end()};
    }

    template <class T>
    void upload(std::span<const T> items, HostBuffer<T>& buffer) {
        buffer.assign(items.begin(), items.end());
    }
};

}  // namespace pierce
