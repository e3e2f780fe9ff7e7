/* Opening a blob. */
#ifndef CARDSFLOW_BLOB_H
#define CARDSFLOW_BLOB_H

#include "layout.h"

#include <stddef.h>

/* 0, or a message in `message`: all of it is checked but for the muscle laws' parameters, so that nothing
   after it reads out of bounds. */
CORE_INSIDE int blob_open(blob_view *view, const void *blob, size_t size, char *message, size_t capacity);

#endif
