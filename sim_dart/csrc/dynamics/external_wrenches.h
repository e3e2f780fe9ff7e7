/* Generalised external forces. */
#ifndef CARDSFLOW_EXTERNAL_WRENCHES_H
#define CARDSFLOW_EXTERNAL_WRENCHES_H

#include "../blob/state.h"

/* outer = extra, or nothing if that is NULL, and what core_external_wrenches has given, at the last q. */
CORE_INSIDE void external_wrenches_add(core *c, const real *extra);

#endif
