#pragma once

#include <cstddef>

/// PIERCE_CHECK_PLACE(place, size): with PIERCE_CHECKED_VIEWS, ends the program and says where,
/// unless place < size. Without PIERCE_CHECKED_VIEWS, and on a device, it does nothing.
#if defined(PIERCE_CHECKED_VIEWS) && !defined(__CUDA_ARCH__)
#include <cstdio>
#include <cstdlib>
#define PIERCE_CHECK_PLACE(place, size)                                                 \
    ((place) < (size)                                                                   \
         ? void()                                                                       \
         : (std::fprintf(stderr, "%s:%d: place %zu of %zu in %s\n", __FILE__, __LINE__, \
                         std::size_t{place}, std::size_t{size}, __PRETTY_FUNCTION__),   \
            std::abort()))
#else
#define PIERCE_CHECK_PLACE(place, size) void()
#endif
