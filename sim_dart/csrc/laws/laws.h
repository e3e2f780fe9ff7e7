/* The tension laws of a robot. */
#ifndef CARDSFLOW_LAWS_H
#define CARDSFLOW_LAWS_H

#include "../blob/state.h"

/* 0, or a message; counts the laws' states and constants. */
CORE_INSIDE int laws_check(blob_view *view, char *message, size_t capacity);
CORE_INSIDE void laws_prepare(core *c);
/* -L'f at the state: 0, or 1 + the index of the first command that is not finite. */
CORE_INSIDE int muscles_pull(core *c, const real *u);
/* Whether all law_states are finite. */
CORE_INSIDE int muscles_are_sound(const core *c);

#endif
