/* Check of what stands between q and the motions of frames. */
#ifndef CARDSFLOW_CHECK_VARIABLES_H
#define CARDSFLOW_CHECK_VARIABLES_H

#include "../layout.h"

#include <stddef.h>

/* 0, or 1 and a message. */
CORE_INSIDE int check_variables(const blob_view *view, char *message, size_t capacity);

#endif
