/* Polynomials of the elementary functions, and their coefficients. */
#ifndef CARDSFLOW_POLYNOMIAL_H
#define CARDSFLOW_POLYNOMIAL_H

#include "../numbers/real_functions.h"

#include <stddef.h>

#if defined(CARDSFLOW_FLOAT)
#include "elementary_float.h"
#else
#include "elementary_double.h"
#endif

#define POLYNOMIAL(z, c) polynomial(z, c, sizeof c / sizeof *c)

/* Evaluate even and odd powers separately by Horner's scheme: two short chains that a processor computes in
   parallel. */
static inline real polynomial(real z, const constant *c, size_t count)
{
    const size_t last = (count - 1) / 2;
    const real zz = z * z;
    real even = number(c[2 * last]), odd = number(2 * last + 1 < count ? c[2 * last + 1] : 0);
    for (size_t k = last; k-- > 0;) even = even * zz + c[2 * k], odd = odd * zz + c[2 * k + 1];
    return even + z * odd;
}

#endif
