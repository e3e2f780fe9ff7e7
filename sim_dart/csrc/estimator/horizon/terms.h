/* Terms of the cost of a frame. */
#ifndef CARDSFLOW_HORIZON_TERMS_H
#define CARDSFLOW_HORIZON_TERMS_H

#include "frames.h"

/* Append a measurement to the frame that is collected: its index from e->lengths; its derivatives by the first
   `width` states; its residual at the current state, and its variance. */
void horizon_add(estimator *e, size_t slot, const real *row, size_t width, real residual, real variance);

/* Append the bounds of q at the current state. */
void horizon_add_bounds(estimator *e);

#endif
