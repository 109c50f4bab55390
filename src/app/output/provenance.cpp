#include "app/output/provenance.hpp"

#include <LinearMath/btScalar.h>
#include <fmt/core.h>
#include <sys/utsname.h>
#include <tbb/version.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <thread>

#include "app/output/commit.hpp"
#include "pierce/embree_backend.hpp"
#include "scenes/detect/method.hpp"

namespace pierce::app {

using nlohmann::json;

namespace {

/// A value of /proc/cpuinfo; "unknown" if it is not there.
std::string processor(const std::string& key) {
    std::ifstream in("/proc/cpuinfo");
    for (std::string line; std::getline(in, line);)
        if (line.starts_with(key)) return line.substr(line.find(':') + 2);
    return "unknown";
}

}  // namespace

json machine_json() {
    utsname names{};
    uname(&names);
    json machine{{"processor", processor("model name")},
                 {"processor_mhz", processor("cpu MHz")},
                 {"threads", std::thread::hardware_concurrency()},
                 {"system", fmt::format("{} {}", names.sysname, names.release)}};
    if (scenes::cuda_can_run())
        machine["gpu"] = scenes::make_backend({.backend = "cuda"})->description();
    return machine;
}

json versions_json() {
    return {{"pierce", PIERCE_VERSION},
            {"commit", PIERCE_COMMIT},
            {"build", PIERCE_BUILD_TYPE},
            {"compiler", __VERSION__},
            {"embree", embree_version()},
            {"onetbb", fmt::format("{}.{}", TBB_VERSION_MAJOR, TBB_VERSION_MINOR)},
            {"bullet", fmt::format("{}.{}", btGetVersion() / 100, btGetVersion() % 100)}};
}

}  // namespace pierce::app
