#pragma once

#include <filesystem>
#include <initializer_list>
#include <string>

#include "scenes/detect/method.hpp"

namespace pierce::app {

/// The processes that `mpirun -n N pierce` has started, its ranks. There is one if it was started
/// otherwise, or if this build has no MPI. To be made once, and to live as long as the command.
class Ranks {
public:
    Ranks(int& argc, char**& argv);
    ~Ranks();
    Ranks(const Ranks&) = delete;
    Ranks& operator=(const Ranks&) = delete;

    /// To be called at the end, with the exit code; returns the code to exit with, which is the
    /// worst of all on the first rank. If this rank has failed and others go on, they would wait
    /// for it: all are ended then, after a few seconds.
    int finish(int code) const;
};

/// How many ranks there are, and whether this is the first one, which alone prints and writes.
int rank_count();
bool is_first_rank();

/// Forgets files that a command is to write, on all ranks but the first.
void leave_to_first_rank(std::initializer_list<std::filesystem::path*> files);

/// Throws InputError, naming what the user has asked for, if there are several ranks.
void require_one_rank(const std::string& asked);

/// Lets all ranks share the work of steps.
void share_among_ranks(scenes::RaySettings& rays);

}  // namespace pierce::app
