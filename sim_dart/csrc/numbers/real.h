/* The type of all numbers: double precision; with CARDSFLOW_FLOAT single precision, for processors without a
   double-precision floating point unit; with CARDSFLOW_TANGENT complex numbers, for derivatives: see
   ../tangent/tangent.h; with CARDSFLOW_LANES vectors of numbers, one per instance: see lanes.h.

   In single precision no double may occur, as in `0.5 * x`. The compiler must treat literals as floats:

     gcc              -DCARDSFLOW_FLOAT -fsingle-precision-constant
     clang, zig cc    -DCARDSFLOW_FLOAT -Xclang -cl-single-precision-constant */
#ifndef CARDSFLOW_REAL_H
#define CARDSFLOW_REAL_H

#include <math.h>
#include <stdint.h>

/* PRECISE(double precision, single precision): a tolerance or another constant that depends on the number of
   digits. A whole_number has the size of a real, so that both can share a block of memory. */
#if defined(CARDSFLOW_FLOAT)

typedef float real;
typedef int32_t whole_number;
#define PRECISE(of_double, of_float) of_float

typedef char literals_must_be_of_single_precision[sizeof 1.0 == sizeof(real) ? 1 : -1];

#else

typedef int64_t whole_number;
#define PRECISE(of_double, of_float) of_double

#endif

/* CORE_INSIDE declares functions that other files of the core call. With CARDSFLOW_TANGENT or CARDSFLOW_LANES
   all of them are in one translation unit. */
#if defined(CARDSFLOW_TANGENT) || defined(CARDSFLOW_LANES)
#define IS_ONE_UNIT 1
#define CORE_INSIDE static
#else
#define IS_ONE_UNIT 0
#define CORE_INSIDE
#endif

#if defined(CARDSFLOW_TANGENT)
#include "complex_step.h"
#else

#if defined(CARDSFLOW_LANES)
#include "lanes.h"
#elif !defined(CARDSFLOW_FLOAT)
typedef double real;
#endif

/* Whether numbers have a tangent: their change along one direction. */
#define HAS_TANGENT 0

/* Return the number without its tangent, for comparisons. */
static inline real value_of(real x)
{
    return x;
}

static inline real tangent_of(real x)
{
    (void)x;
    return (real){0};
}

#endif
#endif
