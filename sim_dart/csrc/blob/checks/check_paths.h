/* What of a blob muscle paths need next to the via points: surfaces, wraps and pulleys. */
#ifndef CARDSFLOW_CHECK_PATHS_H
#define CARDSFLOW_CHECK_PATHS_H

#include "../layout.h"

#include <stddef.h>

/* 0, or a message. */
CORE_INSIDE int check_paths(const blob_view *view, char *message, size_t capacity);

#endif
