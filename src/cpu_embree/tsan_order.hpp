#pragma once

#if defined(__SANITIZE_THREAD__)
#include <sanitizer/tsan_interface.h>
#endif

namespace pierce {

/// The first and the last member of what a task is made from. Tells the thread sanitizer what
/// oneTBB, which is not compiled for it, guarantees: a task is made before it runs, and over before
/// its memory is used anew. Nothing in other builds.
class TsanOrder {
public:
    TsanOrder() { pass(); }
    TsanOrder(const TsanOrder&) { pass(); }
    ~TsanOrder() { pass(); }

    /// Everyone who comes here sees all that those before have done. One place for all tasks: none
    /// can say which it is without reading what it was given.
    static void pass() {
#if defined(__SANITIZE_THREAD__)
        static char place = 0;
        __tsan_acquire(&place);
        __tsan_release(&place);
#endif
    }
};

}  // namespace pierce
