/* A cable off a pulley. */
#ifndef CARDSFLOW_PULLEY_H
#define CARDSFLOW_PULLEY_H

#include "cable.h"

/* Compute the cable off a swivelling pulley: it arrives at F along the unit vector v, and ends at b. */
CORE_INSIDE void pulley_off(const real F[3], const real v[3], real radius, const real b[3], contact *out);

#endif
