#pragma once

/// Marks a function that a stage seldom calls: it is not copied into the stage, which on a device
/// would need registers for it in every item.
#if defined(__CUDACC__)
#define PIERCE_RARELY __noinline__
#else
#define PIERCE_RARELY [[gnu::noinline]]
#endif
