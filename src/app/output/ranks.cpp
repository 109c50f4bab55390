#include "app/output/ranks.hpp"

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <thread>
#include <utility>

#include "pierce/error.hpp"
#if PIERCE_HAS_MPI
#include <mpi.h>

#include "pierce/mpi/ranks_backend.hpp"
#endif

namespace pierce::app {

#if PIERCE_HAS_MPI

namespace {

/// True if a launcher has started this process as one of several: Open MPI, MPICH and Slurm say so.
bool is_launched() {
    const char* const marks[] = {"OMPI_COMM_WORLD_SIZE", "PMI_SIZE", "PMIX_RANK"};
    return std::ranges::any_of(marks, [](const char* mark) { return std::getenv(mark); });
}

/// For how long a rank that has failed waits for others to end.
constexpr std::chrono::seconds patience{3};

bool has_started() {
    int started = 0, over = 0;
    MPI_Initialized(&started);
    MPI_Finalized(&over);
    return started != 0 && over == 0;
}

}  // namespace

Ranks::Ranks(int& argc, char**& argv) {
    if (!is_launched()) return;
    MPI_Init(&argc, &argv);
    if (!is_first_rank() && std::freopen("/dev/null", "w", stdout) == nullptr)
        throw InputError("/dev/null cannot be written");
}

Ranks::~Ranks() {
    if (has_started()) MPI_Finalize();
}

int Ranks::finish(int code) const {
    if (rank_count() == 1) return code;
    using namespace std::chrono;
    const auto begin = steady_clock::now();
    MPI_Request all = MPI_REQUEST_NULL;
    int worst = code;
    MPI_Iallreduce(&code, &worst, 1, MPI_INT, MPI_MAX, MPI_COMM_WORLD, &all);
    for (int are_here = 0; are_here == 0;) {
        MPI_Test(&all, &are_here, MPI_STATUS_IGNORE);
        if (code != 0 && steady_clock::now() - begin > patience) MPI_Abort(MPI_COMM_WORLD, code);
        if (are_here == 0) std::this_thread::sleep_for(milliseconds(1));
    }
    // The launcher ends the others as soon as one exits with a failure. All of them have ended by
    // themselves, and have nothing to say about that.
    std::signal(SIGTERM, SIG_IGN);
    return is_first_rank() ? worst : 0;
}

int rank_count() {
    int count = 1;
    if (has_started()) MPI_Comm_size(MPI_COMM_WORLD, &count);
    return count;
}

bool is_first_rank() {
    int rank = 0;
    if (has_started()) MPI_Comm_rank(MPI_COMM_WORLD, &rank);
    return rank == 0;
}

void share_among_ranks(scenes::RaySettings& rays) {
    if (rank_count() == 1) return;
    rays.shared = [](std::unique_ptr<Backend> own) {
        return mpi::ranks_backend(MPI_COMM_WORLD, std::move(own));
    };
}

#else

Ranks::Ranks(int&, char**&) {}
Ranks::~Ranks() = default;
int Ranks::finish(int code) const { return code; }
int rank_count() { return 1; }
bool is_first_rank() { return true; }
void share_among_ranks(scenes::RaySettings&) {}

#endif

void leave_to_first_rank(std::initializer_list<std::filesystem::path*> files) {
    if (is_first_rank()) return;
    for (std::filesystem::path* file : files) file->clear();
}

void require_one_rank(const std::string& asked) {
    if (rank_count() > 1) throw InputError(asked + " is for one process, not for several ranks");
}

}  // namespace pierce::app
