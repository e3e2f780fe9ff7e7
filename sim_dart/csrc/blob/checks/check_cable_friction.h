/* Friction of cables in bends. */
#ifndef CARDSFLOW_CHECK_CABLE_FRICTION_H
#define CARDSFLOW_CHECK_CABLE_FRICTION_H

#include "../layout.h"

#include <stddef.h>

/* 0, or a message. For paths that have been checked. */
CORE_INSIDE int check_cable_friction(const blob_view *view, char *message, size_t capacity);

#endif
