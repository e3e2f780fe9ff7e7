/* The numbers that everything here computes with: of double precision; or with CARDSFLOW_FLOAT of single
   precision, for processors whose floating point unit knows no other; or with CARDSFLOW_TANGENT complex ones,
   for derivatives: see ../tangent/tangent.h.

   With single precision no double may slip in, as it would by `0.5 * x`: the compiler is to take literals
   for floats.
       gcc              -DCARDSFLOW_FLOAT -fsingle-precision-constant
       clang, zig cc    -DCARDSFLOW_FLOAT -Xclang -cl-single-precision-constant                        */
#ifndef CARDSFLOW_REAL_H
#define CARDSFLOW_REAL_H

#include <math.h>
#include <stdint.h>

/* PRECISE(of double precision, of single precision): a tolerance or another number that depends on how many
   digits there are. A whole_number is as wide as a real, so that both may share a piece of memory.     */
#if defined(CARDSFLOW_FLOAT)

typedef float real;
typedef int32_t whole_number;
#define PRECISE(of_double, of_float) of_float

typedef char literals_must_be_of_single_precision[sizeof 1.0 == sizeof(real) ? 1 : -1];

#else

typedef int64_t whole_number;
#define PRECISE(of_double, of_float) of_double

#endif

/* CORE_INSIDE declares functions that other files of the core call. With CARDSFLOW_TANGENT all are in one. */
#if defined(CARDSFLOW_TANGENT)
#define CORE_INSIDE static

#include "complex_step.h"

#else
#define CORE_INSIDE

#if !defined(CARDSFLOW_FLOAT)
typedef double real;
#endif

/* Whether numbers have a tangent: how they change along one direction. */
#define HAS_TANGENT 0

/* What a comparison looks at: the number, without its tangent. */
static inline real value_of(real x)
{
    return x;
}

static inline real tangent_of(real x)
{
    (void)x;
    return 0;
}

#endif
#endif
