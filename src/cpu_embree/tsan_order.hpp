#pragma once

#if defined(__SANITIZE_THREAD__)
#include <sanitizer/tsan_interface.h>
#endif

namespace pierce {

/// The first and the last member of the function object of a task. It tells the thread sanitizer
/// what oneTBB, which is not compiled for the sanitizer, guarantees: a task is made before it runs,
/// and is over before its memory is used anew. In other builds it does nothing.
class TsanOrder {
public:
    TsanOrder() { pass(); }
    TsanOrder(const TsanOrder&) { pass(); }
    ~TsanOrder() { pass(); }

    /// A thread that calls this sees all that earlier callers have done. All tasks share one place,
    /// as a task cannot tell which one it is without reading its data.
    static void pass() {
#if defined(__SANITIZE_THREAD__)
        static char place = 0;
        __tsan_acquire(&place);
        __tsan_release(&place);
#endif
    }
};

}  // namespace pierce
