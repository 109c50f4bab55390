#pragma once

#include <mpi.h>

#include <cstdint>
#include <string>
#include <type_traits>
#include <vector>

namespace pierce::mpi {

/// Throws std::runtime_error, with MPI's words, for what a call of MPI has returned.
void check(int result);

/// A communicator of our own, and what is said on it.
class Communicator {
public:
    explicit Communicator(MPI_Comm like);
    ~Communicator();
    Communicator(const Communicator&) = delete;
    Communicator& operator=(const Communicator&) = delete;

    MPI_Comm get() const { return comm_; }
    int rank() const { return rank_; }
    int size() const { return size_; }

    /// Every rank's value, by rank.
    template <class T>
    std::vector<T> all_gather(const T& mine) const {
        static_assert(std::is_trivially_copyable_v<T>);
        std::vector<T> all(static_cast<std::size_t>(size_));
        check(MPI_Allgather(&mine, sizeof(T), MPI_BYTE, all.data(), sizeof(T), MPI_BYTE, comm_));
        return all;
    }
    /// Every rank's bytes, by rank; they may be as many as fit into memory.
    std::vector<std::string> all_gather(const std::string& mine) const;

private:
    MPI_Comm comm_ = MPI_COMM_NULL;
    int rank_ = 0, size_ = 1;
};

/// Every rank sends bytes to every other one. It begins where it is made, and does not wait there.
class Exchange {
public:
    /// `to`: per rank.
    Exchange(const Communicator& comm, std::vector<std::string> to);
    ~Exchange();
    Exchange(const Exchange&) = delete;
    Exchange& operator=(const Exchange&) = delete;

    /// Waits for all. Returns what each rank has sent to this one.
    std::vector<std::string> finish();

private:
    void add_requests(bool sends, std::vector<std::string>& messages);

    const Communicator& comm_;
    std::vector<std::string> to_, from_;
    std::vector<std::uint64_t> sizes_to_, sizes_from_;
    std::vector<MPI_Request> requests_;
    MPI_Request sizes_ = MPI_REQUEST_NULL;
};

}  // namespace pierce::mpi
