/* lanes.c for processors with AVX2. */
#include "lane_support.h"

#if HAS_WIDE_VERSIONS
#if defined(__clang__)
#pragma clang attribute push(__attribute__((target("avx2"))), apply_to = function)
#else
#pragma GCC target("avx2")
#endif
#define LANES_NAME BATCH_LANES_WIDE
#define LANES_NARROWER NULL
#include "lanes.c"
#if defined(__clang__)
#pragma clang attribute pop
#endif
#endif
