/* Check of surfaces, wraps and pulleys. */
#ifndef CARDSFLOW_CHECK_PATHS_H
#define CARDSFLOW_CHECK_PATHS_H

#include "../layout.h"

#include <stddef.h>

/* Return 0, or write a message and return nonzero. */
CORE_INSIDE int check_paths(const blob_view *view, char *message, size_t capacity);

#endif
