/* The muscle laws of a robot. */
#ifndef CARDSFLOW_LAWS_H
#define CARDSFLOW_LAWS_H

#include "../blob/state.h"

/* Check the laws, and count their states and constants. Return 0, or write a message and return nonzero. */
CORE_INSIDE int laws_check(blob_view *view, char *message, size_t capacity);
CORE_INSIDE void laws_prepare(core *c);
/* Compute torques = -L'f at the current state. Return 0, or 1 + the index of the first command that is not
   finite. */
CORE_INSIDE int muscles_pull(core *c, const real *u);
/* For heavy cables: compute the constants at the last move; add `way` times their weight, beyond -L'f, to
   the forces on variables. The length of the cable is from commands u; if u is NULL, from the path. */
CORE_INSIDE void laws_place(core *c);
CORE_INSIDE void laws_weigh(const core *c, const real *u, real way, real *forces);
/* Return whether all law_states are finite. */
CORE_INSIDE int muscles_are_sound(const core *c);

#endif
