/* The joints' Coulomb friction. */
#ifndef CARDSFLOW_FRICTION_H
#define CARDSFLOW_FRICTION_H

#include "../blob/state.h"

/* As limits_keep, with the joints' friction over a time h as well. */
CORE_INSIDE void friction_keep(core *c, real h);

#endif
