/* Whether steps in lanes are compiled: they need vectors of GCC or Clang, and double precision. */
#ifndef CARDSFLOW_LANE_SUPPORT_H
#define CARDSFLOW_LANE_SUPPORT_H

#if defined(__GNUC__) && (defined(__x86_64__) || defined(__aarch64__)) && !defined(CARDSFLOW_FLOAT) && \
    !defined(CARDSFLOW_PARTS)
#define HAS_LANES 1
#else
#define HAS_LANES 0
#endif

/* Whether versions for processors with vectors of four and eight numbers exist. */
#if HAS_LANES && defined(__x86_64__)
#define HAS_WIDE_VERSIONS 1
#else
#define HAS_WIDE_VERSIONS 0
#endif

typedef int lane_support; /* ISO C forbids empty files */

#endif
