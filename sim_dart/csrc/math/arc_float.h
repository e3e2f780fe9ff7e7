/* Coefficients of arc.h for single precision: the relative error of the polynomial is below 2e-9. */
#ifndef CARDSFLOW_ARC_FLOAT_H
#define CARDSFLOW_ARC_FLOAT_H

#include "../numbers/real.h"

/* (atan x - x)/x^3 by z = x^2, for |x| <= 7/16 */
static inline real arc_polynomial(real z)
{
    const real z2 = z * z;
    return (-0.33333305 + z * 0.19997787) + z2 * ((-0.14230315 + z * 0.104951814) + z2 * -0.058281954);
}

/* atan of 0, 0.5, 1, 1.5 and infinity as high + low */
static const real ARC_CORNER[5][2] = {{0, 0},
                                      {0.46364760398864746, 5.01215868808913e-09},
                                      {0.7853981852531433, -2.1855694143368964e-08},
                                      {0.9827937483787537, -2.5131424052915463e-08},
                                      {1.5707963705062866, -4.371138828673793e-08}};

#endif
