#pragma once

#include <mpi.h>

#include <memory>

#include "pierce/backend.hpp"

namespace pierce::mpi {

/// A backend for a world that every rank has in full, as where all ranks simulate the same: each
/// looks at its part of the pairs, and then has all contacts. `ranks` is duplicated; each rank may
/// bring another backend. Steps, and World::save(), are collective: all ranks have to make the same
/// calls with the same numbers. For worlds too large for that there is mpi::World. Places
/// are in the host's memory, also where `backend` runs on a device. Throws InputError if it is
/// null.
std::unique_ptr<Backend> ranks_backend(MPI_Comm ranks, std::unique_ptr<Backend> backend);

}  // namespace pierce::mpi
