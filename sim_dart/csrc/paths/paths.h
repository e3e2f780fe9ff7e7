/* Muscle paths. */
#ifndef CARDSFLOW_PATHS_H
#define CARDSFLOW_PATHS_H

#include "../blob/state.h"

CORE_INSIDE void paths_prepare(core *c);
/* Compute lengths and Jacobian at the last q. */
CORE_INSIDE void paths_move(core *c);

#endif
