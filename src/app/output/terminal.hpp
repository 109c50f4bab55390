#pragma once

/// What the command may show on the terminal. It never uses colours.
namespace pierce::app {

/// Environment variable that makes the command, and what it starts, quiet.
inline constexpr const char* quiet_variable = "PIERCE_QUIET";

/// True if PIERCE_QUIET is set, to anything but 0.
bool is_quiet();

/// From now on nothing is printed on standard output, and no progress is shown, here and in
/// programs that are started. Standard error, and the file /dev/stdout, stay as they are.
void be_quiet();

/// True if standard error is a terminal on which a line can be drawn again.
bool shows_progress();

/// Removes the terminal's last line.
void clear_line();

}  // namespace pierce::app
