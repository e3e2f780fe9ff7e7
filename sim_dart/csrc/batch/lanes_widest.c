/* lanes.c for processors with AVX-512, with eight lanes. */
#include "lane_support.h"

#if HAS_WIDE_VERSIONS
#if defined(__clang__)
#pragma clang attribute push(__attribute__((target("avx512f,avx512dq"))), apply_to = function)
#else
#pragma GCC target("avx512f,avx512dq,prefer-vector-width=512")
#endif
#define GROUP 8
#define LANES_NAME BATCH_LANES_WIDEST
#define LANES_NARROWER (&BATCH_LANES_WIDE)
#include "lanes.c"
#if defined(__clang__)
#pragma clang attribute pop
#endif
#endif
