/* Vectors with three elements, and 3 x 3 matrices, row by row. */
#ifndef CARDSFLOW_VECTORS_H
#define CARDSFLOW_VECTORS_H

#include "../numbers/real_functions.h"

static inline real dot3(const real a[3], const real b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static inline void cross3(real out[3], const real a[3], const real b[3])
{
    out[0] = a[1] * b[2] - a[2] * b[1];
    out[1] = a[2] * b[0] - a[0] * b[2];
    out[2] = a[0] * b[1] - a[1] * b[0];
}

/* Compute out = R v. */
static inline void rotate3(real out[3], const real R[9], const real v[3])
{
    for (int k = 0; k < 3; k++) out[k] = dot3(R + 3 * k, v);
}

/* Compute out = A B. */
static inline void multiply3(real out[9], const real A[9], const real B[9])
{
    for (int i = 0; i < 3; i++)
        for (int k = 0; k < 3; k++)
            out[3 * i + k] = A[3 * i] * B[k] + A[3 * i + 1] * B[3 + k] + A[3 * i + 2] * B[6 + k];
}

static inline void add3(real out[3], const real v[3])
{
    for (int k = 0; k < 3; k++) out[k] += v[k];
}

static inline void add_cross3(real out[3], const real a[3], const real b[3])
{
    real product[3];
    cross3(product, a, b);
    add3(out, product);
}

#if !defined(CARDSFLOW_LANES)
/* Compute a unit vector perpendicular to v. */
static inline void unit_across(real out[3], const real v[3])
{
    int least = 0;
    for (int k = 1; k < 3; k++)
        if (value_of(fabs(v[k])) < value_of(fabs(v[least]))) least = k;
    real e[3] = {0, 0, 0}, w[3];
    e[least] = 1;
    cross3(w, v, e);
    const real norm = sqrt(dot3(w, w));
    for (int k = 0; k < 3; k++) out[k] = value_of(norm) > 0 ? w[k] / norm : e[k];
}
#endif

/* Add w x (w x r). */
static inline void add_centripetal(real out[3], const real w[3], const real r[3])
{
    real wr[3];
    cross3(wr, w, r);
    add_cross3(out, w, wr);
}

#endif
