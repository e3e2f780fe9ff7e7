/* What is constant about the paths of a robot, so that moves can skip it. */
#ifndef CARDSFLOW_STRUCTURE_H
#define CARDSFLOW_STRUCTURE_H

#include "../../blob/state.h"

/* Compute fixed_length, and the range of coordinates that each muscle depends on: column_first, column_end. */
CORE_INSIDE void structure_prepare(core *c);

#endif
