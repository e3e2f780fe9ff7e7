/* External generalised forces. */
#ifndef CARDSFLOW_EXTERNAL_WRENCHES_H
#define CARDSFLOW_EXTERNAL_WRENCHES_H

#include "../blob/state.h"

/* Compute outer = extra (0 if NULL) + the wrenches of core_external_wrenches, at the last q. */
CORE_INSIDE void external_wrenches_add(core *c, const real *extra);

#endif
