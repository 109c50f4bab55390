#pragma once

#include <sys/types.h>

#include <string>

namespace pierce::app {

/// Waits for a program that was started, to end. Returns its status, as waitpid() has it. If this
/// program should stop, ends that one and throws Interrupted. `what` is going on.
int wait_for(pid_t child, const std::string& what);

}  // namespace pierce::app
