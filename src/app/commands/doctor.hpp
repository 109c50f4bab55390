#pragma once

#include <filesystem>

namespace pierce::app {

/// What this machine has, what the command will use of it, and what could be installed.
/// `file`: where this is written as JSON, too; empty: nowhere. Returns 0 if the backend that is
/// taken by default finds contacts, and those that all others find; else 1.
int doctor(const std::filesystem::path& file);

}  // namespace pierce::app
