/* Check of frames, coordinates, bodies, muscles and tasks. */
#ifndef CARDSFLOW_CHECK_ROBOT_H
#define CARDSFLOW_CHECK_ROBOT_H

#include "../layout.h"

#include <stddef.h>

/* Return 0, or write a message and return nonzero. */
CORE_INSIDE int check_robot(const blob_view *view, char *message, size_t capacity);

#endif
