#include "mpi/communicator.hpp"

#include <algorithm>
#include <stdexcept>
#include <utility>

namespace pierce::mpi {
namespace {

/// MPI counts bytes with an int.
constexpr std::size_t most_at_once = std::size_t{1} << 30;
constexpr int tag = 1;

}  // namespace

void check(int result) {
    if (result == MPI_SUCCESS) return;
    char text[MPI_MAX_ERROR_STRING];
    int length = 0;
    MPI_Error_string(result, text, &length);
    throw std::runtime_error("MPI: " + std::string(text, static_cast<std::size_t>(length)));
}

Communicator::Communicator(MPI_Comm like) {
    check(MPI_Comm_dup(like, &comm_));
    check(MPI_Comm_set_errhandler(comm_, MPI_ERRORS_RETURN));
    check(MPI_Comm_rank(comm_, &rank_));
    check(MPI_Comm_size(comm_, &size_));
}

Communicator::~Communicator() {
    int over = 0;
    MPI_Finalized(&over);
    if (!over) MPI_Comm_free(&comm_);
}

std::vector<std::string> Communicator::all_gather(const std::string& mine) const {
    return Exchange(*this, std::vector<std::string>(static_cast<std::size_t>(size_), mine))
        .finish();
}

Exchange::Exchange(const Communicator& comm, std::vector<std::string> to)
    : comm_(comm), to_(std::move(to)), from_(to_.size()), sizes_from_(to_.size(), 0) {
    for (const std::string& message : to_) sizes_to_.push_back(message.size());
    check(MPI_Ialltoall(sizes_to_.data(), 1, MPI_UINT64_T, sizes_from_.data(), 1, MPI_UINT64_T,
                        comm_.get(), &sizes_));
    add_requests(true, to_);
}

Exchange::~Exchange() {
    if (sizes_ != MPI_REQUEST_NULL) MPI_Wait(&sizes_, MPI_STATUS_IGNORE);
    MPI_Waitall(static_cast<int>(requests_.size()), requests_.data(), MPI_STATUSES_IGNORE);
}

void Exchange::add_requests(bool sends, std::vector<std::string>& messages) {
    for (int other = 0; other < comm_.size(); ++other) {
        if (other == comm_.rank()) continue;
        std::string& message = messages[static_cast<std::size_t>(other)];
        for (std::size_t at = 0; at < message.size(); at += most_at_once) {
            const auto count = static_cast<int>(std::min(most_at_once, message.size() - at));
            MPI_Request& request = requests_.emplace_back();
            check(sends ? MPI_Isend(message.data() + at, count, MPI_BYTE, other, tag, comm_.get(),
                                    &request)
                        : MPI_Irecv(message.data() + at, count, MPI_BYTE, other, tag, comm_.get(),
                                    &request));
        }
    }
}

std::vector<std::string> Exchange::finish() {
    check(MPI_Wait(&sizes_, MPI_STATUS_IGNORE));
    for (std::size_t other = 0; other < from_.size(); ++other)
        from_[other].resize(sizes_from_[other]);
    const auto self = static_cast<std::size_t>(comm_.rank());
    from_[self] = to_[self];
    add_requests(false, from_);
    check(MPI_Waitall(static_cast<int>(requests_.size()), requests_.data(), MPI_STATUSES_IGNORE));
    return std::move(from_);
}

}  // namespace pierce::mpi
