/* What of a blob is not about muscle paths: frames, coordinates, bodies, muscles and tasks. */
#ifndef CARDSFLOW_CHECK_ROBOT_H
#define CARDSFLOW_CHECK_ROBOT_H

#include "../layout.h"

#include <stddef.h>

/* 0, or a message. */
CORE_INSIDE int check_robot(const blob_view *view, char *message, size_t capacity);

#endif
