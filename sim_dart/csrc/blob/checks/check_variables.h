/* Check of the functions that map q to the motions of frames. */
#ifndef CARDSFLOW_CHECK_VARIABLES_H
#define CARDSFLOW_CHECK_VARIABLES_H

#include "../layout.h"

#include <stddef.h>

/* Return 0, or write a message and return 1. */
CORE_INSIDE int check_variables(const blob_view *view, char *message, size_t capacity);

#endif
