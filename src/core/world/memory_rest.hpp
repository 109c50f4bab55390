#pragma once

#include <cstdint>

#include "pierce/step_stats.hpp"

namespace pierce {

/// Decides which steps of Temporal::certified remember. What a step remembers costs more than it
/// spares where most vertices send a ray all the same: bodies are fast, or change their shape. Such
/// steps *rest*: they run as Temporal::off, for longer each time, and then memory is tried again.
/// Contacts are the same either way. It decides by counts, not by clocks, so that every run and
/// every backend decides alike.
struct MemoryRest {
    std::uint32_t tried = 0;    ///< steps since memory was last taken up
    std::uint32_t poor = 0;     ///< of these, the last ones in a row that did not pay
    std::uint32_t resting = 0;  ///< steps to go without memory
    std::uint32_t rests = 0;    ///< in a row, each twice as long as the one before

    bool now() const { return resting > 0; }
    /// To be called before a step in which nearly all bodies are where they were: contacts of most
    /// pairs are taken over then.
    void end() { tried = poor = resting = 0; }
    /// To be called after every other step, with what it did. `deforms`: some body deforms.
    void note(const StepStats& stats, bool deforms);
};

}  // namespace pierce
