/* The linearised program of a horizon. With a multiplier l for each term, the shifts d of the states from their
   last solution are

     d = mean + S H' l,     S: covariance of all states without the measurements in the horizon

   and the residuals are r = residual - H d. At the minimum each l is the derivative of its loss at r: r / variance
   within bounds, +- huber / s for measurements, one of them 0 for inequalities.

   The cost is convex and piecewise quadratic. Newton's method with an exact line search minimises it in few
   steps: in each step the terms within their bounds are free, the others have constant multipliers. A Kalman
   filter forward and an adjoint recursion backward solve for the free multipliers, in a time proportional to the
   number of frames, without the inverse of a covariance (Bryson and Frazier 1963; de Jong 1989). So covariances
   may be singular. */
#ifndef CARDSFLOW_HORIZON_WINDOW_H
#define CARDSFLOW_HORIZON_WINDOW_H

#include "frames.h"

/* Solve the linearised program: compute `shift` of all frames, the arrival of the second frame, and the
   covariance of the state. Return whether the iterations converged. */
int window_solve(estimator *e);

#endif
