/* Numbers of several instances of a robot, one per lane of a vector: the core compiled for them computes all
   instances at once, with the same operations in the same order as for plain numbers. See ../batch/lanes.c.

   Comparisons result in a mask. Functions of real_functions.h choose numbers by masks; a decision that lanes
   do not share makes lanes leave the group: see `agreed` in ../blob/state.h. */
#ifndef CARDSFLOW_LANES_H
#define CARDSFLOW_LANES_H

#include <math.h>
#include <stdint.h>
#if defined(__x86_64__)
#include <immintrin.h>
#endif

#if !defined(GROUP)
#define GROUP 4 /* number of lanes, 4 or 8 */
#endif

typedef double real __attribute__((vector_size(8 * GROUP)));
typedef double constant; /* a number that all lanes share */
typedef int64_t truth __attribute__((vector_size(8 * GROUP)));
typedef int64_t whole __attribute__((vector_size(8 * GROUP)));
typedef int32_t short_whole __attribute__((vector_size(4 * GROUP)));

static inline real number(double x)
{
    return (real){0} + x;
}

/* Return one bit per lane. */
static inline int bits_of(truth x)
{
#if GROUP == 8
    return (int)_mm512_movepi64_mask((__m512i)x);
#elif defined(__AVX2__)
    return _mm256_movemask_pd((__m256d)x);
#else
    return (int)((x[0] & 1) | (x[1] & 2) | (x[2] & 4) | (x[3] & 8));
#endif
}

static inline int all_of(truth x)
{
    return bits_of(x) == (1 << GROUP) - 1;
}

static inline int any_of(truth x)
{
    return bits_of(x) != 0;
}

static inline real choose(truth is, real yes, real no)
{
    return (real)(((truth)yes & is) | ((truth)no & ~is));
}

static inline real absolute(real x)
{
    return (real)((truth)x & INT64_MAX);
}

static inline real square_root(real x)
{
#if GROUP == 8
    return (real)_mm512_sqrt_pd((__m512d)x);
#elif defined(__AVX2__)
    return (real)_mm256_sqrt_pd((__m256d)x);
#else
    for (int i = 0; i < GROUP; i++) x[i] = sqrt(x[i]);
    return x;
#endif
}

static inline real remainder_of(real x, double y)
{
    for (int i = 0; i < GROUP; i++) x[i] = fmod(x[i], y);
    return x;
}

/* Return the integer parts of numbers below 2^31, as integers and as numbers. */
static inline whole whole_of(real x)
{
    return __builtin_convertvector(__builtin_convertvector(x, short_whole), whole);
}

static inline real without_fraction(real x)
{
    return __builtin_convertvector(__builtin_convertvector(x, short_whole), real);
}

static inline truth is_finite(real x)
{
    return x - x == 0;
}

#undef isfinite
#define isfinite is_finite
#define fabs absolute
#define sqrt square_root
#define fmod remainder_of

#endif
