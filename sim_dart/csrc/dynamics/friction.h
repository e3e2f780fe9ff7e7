/* Coulomb friction of joints. */
#ifndef CARDSFLOW_FRICTION_H
#define CARDSFLOW_FRICTION_H

#include "../blob/state.h"

/* Do the same as limits_enforce, including joint friction over a time h. */
CORE_INSIDE void friction_enforce(core *c, real h);

#endif
