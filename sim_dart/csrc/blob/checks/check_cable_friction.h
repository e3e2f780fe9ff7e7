/* Check of the fields for cable friction. */
#ifndef CARDSFLOW_CHECK_CABLE_FRICTION_H
#define CARDSFLOW_CHECK_CABLE_FRICTION_H

#include "../layout.h"

#include <stddef.h>

/* Return 0, or write a message and return nonzero. The paths must have been checked before. */
CORE_INSIDE int check_cable_friction(const blob_view *view, char *message, size_t capacity);

#endif
