/* What of a blob muscle paths need beside points, wraps and pulleys. */
#ifndef CARDSFLOW_CHECK_ROUTES_H
#define CARDSFLOW_CHECK_ROUTES_H

#include "../layout.h"

#include <stddef.h>

/* 0, or a message. */
CORE_INSIDE int check_routes(const blob_view *view, char *message, size_t capacity);

#endif
