/* Opening of robot blobs. */
#ifndef CARDSFLOW_BLOB_H
#define CARDSFLOW_BLOB_H

#include "layout.h"

#include <stddef.h>

/* Fill `view` and return 0, or write a message and return nonzero. All fields are checked except the
   parameters of the muscle laws, so that later code does not read out of bounds. */
CORE_INSIDE int blob_open(blob_view *view, const void *blob, size_t size, char *message, size_t capacity);

#endif
