/* Evidence of lost forces from the motion of a robot without tension sensors.

   A Kalman filter of q, qd and w, an unknown generalised load on the left side of the motion equation, follows the fit of
   lengths and encoders with the accelerations of the model:

     qdd = a - W w,  dw/dt white noise,  q = fit + noise

   a: acceleration with the commanded forces and without loads; W: inverse mass matrix. A muscle that has lost the share s
   of its force f acts as the load -s f L, which has a known direction and a known course. The innovations are white
   without it, and contain s times a known signature with it (Willsky and Jones 1976), so that its Bayes factor follows
   from two sums. Alternatives are unknown loads, as of payloads and contacts: constant in any direction after a linear
   rise; changing, which is the density of a second filter, whose loads change by `load_change` within a window; or
   disturbances that enlarge the innovations.

   The signatures are computed after a sum of innovations has exceeded its threshold, from the stored last ticks. */
#ifndef CARDSFLOW_FAULTS_MOTION_FILTER_H
#define CARDSFLOW_FAULTS_MOTION_FILTER_H

#include "state.h"

/* The record of a tick, with the covariance F F' of the innovation and P of the state: gain = P H' F'^-1, white = F^-1 times
   the innovation; agile: log density of the second filter minus that of the first one. F = 0 without a fit. */
typedef struct {
    real *gain, *mobility, *factor, *white, *forces, *lengths, *jacobian, *agile;
} motion_record;

motion_record motion_at(const faults *s, real tick);

/* Compute F with A = F F'; its diagonal contains the reciprocals. Return 0, or 1 if A is not positive definite. */
int motion_decompose(size_t n, const real *A, real *factor);
/* Compute x <- F^-1 x. */
void motion_whiten(size_t n, const real *factor, real *x);
/* Advance x = (q, qd, w) by h with the accelerations -W w. */
void motion_advance(const faults *s, const real *W, real h, real *x);
void motion_add_gain(size_t n, const real *gain, const real *white, real sign, real *x);

/* Process a tick; `is_fit`: the fit contains no wrong sensor. Return 1, or 0 if the filters begin again. */
int motion_filter(faults *s, real h, int steps, int is_fit);

#endif
