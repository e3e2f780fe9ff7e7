/* Check of conditional points, moving points, branches and terms of path lengths. */
#ifndef CARDSFLOW_CHECK_ROUTES_H
#define CARDSFLOW_CHECK_ROUTES_H

#include "../layout.h"

#include <stddef.h>

/* Return 0, or write a message and return nonzero. */
CORE_INSIDE int check_routes(const blob_view *view, char *message, size_t capacity);

#endif
