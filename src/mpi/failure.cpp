#include "mpi/failure.hpp"

#include <algorithm>
#include <cstdint>
#include <stdexcept>
#include <string>
#include <vector>

#include "pierce/error.hpp"

namespace pierce::mpi {

bool any_failed(const Communicator& comm, const std::exception_ptr& failure) {
    const std::vector<std::uint8_t> all = comm.all_gather(std::uint8_t{failure != nullptr});
    return std::ranges::find(all, 1) != all.end();
}

void throw_failure(const Communicator& comm, const std::exception_ptr& failure) {
    // The first letter says what was thrown.
    std::string mine;
    try {
        if (failure) std::rethrow_exception(failure);
    } catch (const InputError& error) {
        mine = std::string("i") + error.what();
    } catch (const std::exception& error) {
        mine = std::string("e") + error.what();
    } catch (...) {
        mine = "esomething that is no std::exception";
    }
    const std::vector<std::string> all = comm.all_gather(mine);
    for (std::size_t from = 0; from < all.size(); ++from) {
        if (all[from].empty()) continue;
        const std::string text = "rank " + std::to_string(from) + ": " + all[from].substr(1);
        if (all[from][0] == 'i') throw InputError(text);
        throw std::runtime_error(text);
    }
    throw std::logic_error("no rank has failed");
}

}  // namespace pierce::mpi
