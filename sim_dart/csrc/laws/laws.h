/* The muscle laws of a robot. */
#ifndef CARDSFLOW_LAWS_H
#define CARDSFLOW_LAWS_H

#include "../blob/state.h"

/* 0, or a message; counts the laws' states and constants. */
CORE_INSIDE int laws_check(blob_view *view, char *message, size_t capacity);
CORE_INSIDE void laws_prepare(core *c);
/* -L'f at the state: 0, or 1 + the index of the first command that is not finite. */
CORE_INSIDE int muscles_pull(core *c, const real *u);
/* Of heavy cables: what their laws know of the last move; `way` times what they pull down with beside -L'f is
   added to forces on variables, at commands u, or NULL: with as much cable as there is way.              */
CORE_INSIDE void laws_place(core *c);
CORE_INSIDE void laws_weigh(const core *c, const real *u, real way, real *forces);
/* Whether all law_states are finite. */
CORE_INSIDE int muscles_are_sound(const core *c);

#endif
